"""The studio answers its own pages alone, and gives and takes files of its own folder alone."""

from __future__ import annotations

import asyncio
import mimetypes
import os
import subprocess

import pytest

pytest.importorskip("starlette", reason="needs the extra 'studio'")
pytest.importorskip("uvicorn", reason="needs the extra 'studio'")

from studio_server import running

from pipeclamp.studio import uploads
from pipeclamp.studio.project import Project
from pipeclamp.studio.security import Door
from pipeclamp.studio.work import end_with_children
from pipeclamp_models.base.errors import UserError


@pytest.fixture(scope="module")
def studio(tmp_path_factory):
    with running(tmp_path_factory.mktemp("studio") / "home") as running_studio:
        yield running_studio


def test_scripts_are_scripts_whatever_the_system_calls_them(tmp_path, monkeypatch):
    """Windows has types of files in its registry, where .js is often text/plain: no browser runs that as a module."""
    monkeypatch.setitem(mimetypes.types_map, ".js", "text/plain")
    mimetypes.add_type("text/plain", ".js")
    with running(tmp_path / "home") as studio:
        for name, kind in (("studio.js", "text/javascript"), ("studio.css", "text/css"), ("icon.svg", "image/svg+xml")):
            assert studio.ask(f"/static/{name}")[1]["content-type"].startswith(kind)


def test_where_there_are_no_groups_a_job_is_ended_with_its_children(monkeypatch):
    called = []
    monkeypatch.delattr(os, "killpg")
    monkeypatch.setattr(subprocess, "run", lambda words, **_: called.append(words))
    end_with_children(1234)
    assert called == [["taskkill", "/T", "/F", "/PID", "1234"]]


EVIL = "http://evil.example"
FOREIGN = {
    "a foreign name that points here": ({"Host": "evil.example"}, 421),
    "another port": ({"Host": "127.0.0.1:1"}, 421),
    "no name": ({"Host": ""}, 421),
    "a name with credentials": ({"Host": "127.0.0.1@evil.example"}, 421),
    "a foreign page": ({"Origin": EVIL}, 403),
    "a sandboxed page": ({"Origin": "null"}, 403),
    "a foreign page's picture": ({"Origin": None, "Sec-Fetch-Site": "cross-site"}, 403),
    "a page of another port": ({"Origin": None, "Sec-Fetch-Site": "same-site"}, 403),
    "no token": ({"Cookie": None}, 403),
    "a wrong token": ({"Cookie": "pipeclamp_studio_{port}=x"}, 403),
}


@pytest.mark.parametrize("path", ["/", "/static/studio.js", "/plotly.js", "/c/clamp_a/files/law1.json"])
@pytest.mark.parametrize("who", FOREIGN)
def test_strangers_are_refused(studio, path, who):
    headers, status = FOREIGN[who]
    told = {
        name: value if value is None else value.replace("{port}", str(studio.door.port))
        for name, value in headers.items()
    }
    answered, given, _ = studio.ask(path, headers=told)
    assert answered == status
    assert "set-cookie" not in given


@pytest.mark.parametrize("origin", [None, EVIL, "null"])
def test_nothing_is_done_for_another_page(studio, origin):
    status, _, _ = studio.ask("/c/clamp_a/jobs", "POST", {"kind": "identify", "base": "power"}, {"Origin": origin})
    assert status == 403
    assert not studio.desk.jobs.of("clamp_a")


def test_the_token_opens_it_and_becomes_a_cookie_that_no_script_reads(studio):
    without = {"Cookie": None, "Origin": None}
    status, headers, _ = studio.ask(f"/?token={studio.door.token}", headers=without)
    assert status == 200
    assert {"HttpOnly", "SameSite=Strict"} <= {part.strip() for part in headers["set-cookie"].split(";")}
    assert studio.ask("/?token=wrong", headers=without)[0] == 403
    assert studio.ask("/?token=wrong")[0] == 403
    assert studio.door.url.endswith(f":{studio.door.port}/?token={studio.door.token}")


def test_what_is_answered_runs_no_strangers_script(studio):
    _, headers, _ = studio.ask("/")
    policy = {rule.split()[0]: rule.split()[1:] for rule in headers["content-security-policy"].split(";")}
    assert policy["default-src"] == ["'self'"]
    assert "script-src" not in policy
    assert policy["frame-ancestors"] == policy["base-uri"] == policy["object-src"] == ["'none'"]
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["referrer-policy"] == "no-referrer"


def test_only_this_machine_is_served_unless_told():
    here = Door("127.0.0.1", 80)
    assert here.loopback
    assert all(map(here.serves, ("127.0.0.1:80", "localhost", "[::1]:80")))
    assert not any(map(here.serves, ("192.168.1.5:80", "example.org", "127.0.0.1.example.org:80", "::1", "a b")))
    everywhere = Door("0.0.0.0", 80)
    assert everywhere.serves("192.168.1.5")
    assert not everywhere.serves("evil.example")


PATHS = [
    "../secret.json", "%2e%2e%2fsecret.json", "..%5csecret.json", "%2Fetc%2Fpasswd", "/etc/passwd", "law1.json%00.csv",
    "session.json", "law9.json", "linked.json", "law3.json", ".law1.json.part",
]  # fmt: skip


@pytest.mark.parametrize("path", PATHS)
def test_files_of_its_own_folder_alone_are_given(studio, path):
    folder = studio.desk.home / "clamp_a_laws"
    folder.mkdir(parents=True, exist_ok=True)
    (studio.desk.home / "secret.json").write_text("secret")
    (folder / "law2.json").write_text("mine")
    for name in ("linked.json", "law3.json"):
        if not os.path.lexists(folder / name):
            (folder / name).symlink_to(studio.desk.home / "secret.json")
    status, _, content = studio.ask(f"/c/clamp_a/files/{path}", headers={"Accept": "*/*"})
    assert status in (400, 404)
    assert b"secret" not in content.replace(b"secret.json", b"")
    assert studio.ask("/c/clamp_a/files/law2.json")[2] == b"mine"


@pytest.mark.parametrize("key", ["..", "%2e%2e", "%2Fetc", "uploads", "no_such"])
def test_campaigns_of_its_own_folder_alone_are_opened(studio, key):
    assert studio.ask(f"/c/{key}/")[0] in (400, 404)


def test_a_law_that_leads_out_of_the_folder_is_no_law(tmp_path):
    project = Project("clamp_a", tmp_path / "home")
    (tmp_path / "elsewhere.json").write_text("{}")
    (project.folder / "law1.json").symlink_to(tmp_path / "elsewhere.json")
    for name in ("law1", "../elsewhere", "/etc/passwd", "law0", "law1/../law1"):
        with pytest.raises(UserError, match="no such file"):
            project.path_of(name)


SAFE = {
    "A0.5_f3_T20.csv": "A0.5_f3_T20.csv",
    "../../etc/passwd": "passwd",
    "C:\\Users\\x\\a b.csv": "a b.csv",
    "a\x00b\n.csv": "a_b_.csv",
    ".hidden.csv": "hidden.csv",
    "con.csv": "_con.csv",
    'a";<b>.csv': "a___b_.csv",
    f"{'x' * 300}.csv": f"{'x' * 116}.csv",
}


@pytest.mark.parametrize("given", SAFE)
def test_names_of_uploads_are_names(given):
    assert uploads.safe_name(given) == SAFE[given]


@pytest.mark.parametrize("given", ["", "..", "/", "\x00", ".", "..."])
def test_what_is_no_name_is_refused(given):
    with pytest.raises(UserError):
        uploads.safe_name(given)


@pytest.mark.parametrize("given", ["", "..", "a/b", "a\\b", ".x", "a b", "con", "uploads", "x" * 61])
def test_names_of_campaigns_are_names(given):
    with pytest.raises(UserError):
        uploads.safe_campaign(given)


BATCH = "0123456789abcdef"


def test_uploads_are_limited(studio, monkeypatch):
    def put(name, content, batch=BATCH, headers=None):
        return studio.ask(f"/uploads/{batch}/{name}", "PUT", content, headers)[0]

    monkeypatch.setattr(uploads, "MOST_UPLOAD_BYTES", 10)
    monkeypatch.setattr(uploads, "MOST_UPLOAD_FILES", 2)
    assert put("a.csv", b"0123456789") == 200
    assert put("a.csv", b"0") == 400
    assert put("b.csv", b"0123456789x") == 413
    assert put("b.csv", b"0", headers={"Origin": EVIL}) == 403
    assert put("b.csv", b"0", batch="..") in (400, 404)
    assert put("..%2Fb.csv", b"0") in (400, 404)
    assert put("b.csv", b"0") == 200
    assert put("c.csv", b"0") == 400
    assert sorted(path.name for path in (studio.desk.home / "uploads" / BATCH).iterdir()) == ["a.csv", "b.csv"]


def test_an_upload_that_is_longer_than_it_says_leaves_nothing(tmp_path, monkeypatch):
    async def pieces():
        for _ in range(4):
            yield b"0123"

    monkeypatch.setattr(uploads, "MOST_UPLOAD_BYTES", 10)
    with pytest.raises(UserError, match="too large"):
        asyncio.run(uploads.take(tmp_path, BATCH, "a.csv", pieces()))
    assert not list((tmp_path / "uploads" / BATCH).iterdir())


def test_questions_are_short(studio):
    assert studio.ask("/c/clamp_a/jobs", "POST", b"x" * (1 << 17))[0] == 413
