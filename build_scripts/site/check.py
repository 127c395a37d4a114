"""Whether the built site stands by itself: links and anchors inside it lead somewhere, nothing comes from a network.

Run: python build_scripts/site/check.py SITE
"""

import re
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

LOADED = {"script": "src", "img": "src", "link": "href", "source": "src", "iframe": "src"}
"""Elements that a browser loads by itself, and the attribute that says from where."""
RELATIONS = {"canonical", "search", "index", "next", "prev", "author", "license", "edit"}
"""What a `link` may lead to without being loaded."""
STYLE = re.compile(r"""(?:url\(\s*|@import\s+)["']?(https?:|//)""")


class Page(HTMLParser):
    """What a page refers to and what others can refer to in it."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.loads: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Take a tag."""
        given = {name: value for name, value in attrs if value}
        self.anchors |= {given[name] for name in ("id", "name") if name in given}
        if tag == "a" and "href" in given:
            self.links.append(given["href"])
        if (name := LOADED.get(tag)) in given and not set(given.get("rel", "").split()) & RELATIONS:
            self.loads.append(given[str(name)])


def faults(site: Path) -> list[str]:
    """Give what is wrong, a line each."""
    pages = {path.resolve(): Page(path.read_text(encoding="utf-8")) for path in site.rglob("*.html")}
    found = []
    for path, page in pages.items():
        place = path.relative_to(site.resolve()).as_posix()
        for target in {*page.links, *page.loads}:
            parts = urlsplit(target)
            if parts.scheme or parts.netloc:
                if target in page.loads and parts.scheme != "data":
                    found.append(f"{place}: loads {target}")
                continue
            file = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not file.exists():
                found.append(f"{place}: {target} isn't there")
            elif parts.fragment and file in pages and unquote(parts.fragment) not in pages[file].anchors:
                found.append(f"{place}: {target} has no such anchor")
    styles = site.rglob("*.css")
    found += [f"{path.name}: loads from a network" for path in styles if STYLE.search(path.read_text(encoding="utf-8"))]
    return sorted(found)


def main() -> None:
    """Check, and say what is wrong."""
    site = Path(sys.argv[1])
    if wrong := faults(site):
        sys.exit("\n".join(wrong))
    print(f"{site}: {len(list(site.rglob('*.html')))} pages, every link inside leads somewhere, nothing is loaded")


if __name__ == "__main__":
    main()
