"""`pipeclamp studio` as a user calls it: its one line, how it ends, what it says where it can't serve."""

from __future__ import annotations

import importlib.util
import json
import re
import signal
import socket
import sys
import urllib.request

import pytest

pytest.importorskip("starlette", reason="needs the extra 'studio'")
pytest.importorskip("uvicorn", reason="needs the extra 'studio'")

LINE = re.compile(r"http://127\.0\.0\.1:\d+/\?token=[\w-]{20,}\n")


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.parametrize(("how", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_it_prints_its_address_and_serves_until_it_is_stopped_with_its_jobs(started, tmp_path, how, status):
    home = tmp_path / "home"
    process = started("studio", "clamp_a", "-o", home, "--no-browser")
    line = process.stdout.readline()
    assert LINE.fullmatch(line), line + process.stderr.read()
    with urllib.request.urlopen(line.strip()) as answer:
        assert "48 runs" in answer.read().decode()
    address, token = line.strip().split("/?token=")
    asked = urllib.request.Request(
        f"{address}/c/clamp_a/jobs?token={token}", b'{"kind": "identify", "base": "power"}', {"Origin": address}
    )
    with urllib.request.urlopen(asked) as answer:
        assert json.load(answer)["state"] == "running"
    followed = urllib.request.urlopen(f"{address}/c/clamp_a/jobs?token={token}")
    assert b"running" in followed.readline()
    process.send_signal(how)
    out, told = process.communicate(timeout=30)
    followed.close()
    assert process.returncode == status
    assert out == ""
    assert told == (
        f"pipeclamp: {'interrupted' if how == signal.SIGINT else 'terminated'}: all laws are in {home}; "
        "the same command goes on with them\n"
    )


def test_a_port_that_is_taken_is_told(refused, tmp_path):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        told = refused("studio", "-o", tmp_path / "home", "--no-browser", "--port", port)
    assert f"--port {port}: can't be bound" in told


def test_campaigns_that_cannot_serve_are_told_before_anything_is_served(refused, tmp_path):
    assert "no such folder" in refused("studio", "no_such", "-o", tmp_path / "home", "--no-browser")
    assert not (tmp_path / "home").exists()


def test_a_folder_with_laws_of_another_campaign_is_told(refused, tmp_path):
    session = '{"schema": "pipeclamp-studio-1", "campaign": "clamp_b", "steps": []}'
    (tmp_path / "session.json").write_text(session)
    assert "laws of 'clamp_b'" in refused("studio", "clamp_a", "-o", tmp_path, "--no-browser")


def test_without_the_extra_it_says_how_to_get_it(refused, monkeypatch):
    found = importlib.util.find_spec
    monkeypatch.setattr("pipeclamp.cli.studio.find_spec", lambda name: None if name == "starlette" else found(name))
    assert "pip install 'pipeclamp[studio]'" in refused("studio", "clamp_a", "--no-browser")
