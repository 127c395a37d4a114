"""Words made sentences."""

from __future__ import annotations


def sentence(words: str) -> str:
    """Give words as a sentence; a name of the catalogue that begins them stays as `add` takes it."""
    first = words.split(maxsplit=1)[0] if words.split() else ""
    begun = words if set("_:") & set(first) else f"{words[:1].upper()}{words[1:]}"
    return begun if begun.endswith(".") else f"{begun}."
