# SPDX-License-Identifier: Apache-2.0
"""What takes long keeps nobody waiting: files that are opened and written, volumes that are read. Stages are in
test_view_stage.py."""

import threading

import pytest

pytest.importorskip("tornado")
pytest.importorskip("tomlkit")

from conftest import SMOKE  # noqa: E402
from viewing import PATIENCE, Browser, Serving  # noqa: E402

from scrim import _bounds  # noqa: E402
from scrim.view import _opening, _server  # noqa: E402


def test_others_are_answered_while_a_file_is_opened_or_written(tmp_path, monkeypatch):
    for name in ("a", "b"):
        (tmp_path / f"{name}.toml").write_text(SMOKE)
    may_go_on, begun = threading.Event(), threading.Event()
    right = _server.opened

    def slow(path, **more):
        begun.set()
        assert may_go_on.wait(PATIENCE)
        return right(path, **more)

    monkeypatch.setattr(_server, "opened", slow)
    serving = Serving(lambda: _opening.opened(str(tmp_path)))
    browser, other = Browser(serving), Browser(serving)
    browser.until_exact()
    browser.send(type="open", name="b.toml")
    assert begun.wait(PATIENCE)
    assert serving.get("/page.js")[0] == 200
    other.send(type="set", id="light.key.intensity", value=6.0, done=True)
    other.until_exact()
    may_go_on.set()
    browser.serial = other.serial = 9
    browser.until(lambda m: m["type"] == "state" and m["title"] == "b.toml")
    browser.until(lambda m: m["type"] == "pictures" and m["exact"])

    begun.clear()
    may_go_on.clear()
    writes = _server._exr_of

    def slowly(frame):
        begun.set()
        assert may_go_on.wait(PATIENCE)
        return writes(frame)

    monkeypatch.setattr(_server, "_exr_of", slowly)
    got = []
    getting = threading.Thread(target=lambda: got.append(serving.get("/picture.exr")))
    getting.start()
    assert begun.wait(PATIENCE)
    assert serving.get("/style.css")[0] == 200
    may_go_on.set()
    getting.join(PATIENCE)
    assert got[0][0] == 200 and got[0][1].startswith(b"v/1\x01")
    browser.close()
    other.close()
    serving.end()


def test_framing_waits_beside_for_a_volume_that_is_slow_and_asks_again_after_a_failure(tmp_path, program, monkeypatch):
    assert program("make", "noise", "resolution=16", "-q", "-o", tmp_path / "a.vdb").returncode == 0
    text = SMOKE.replace('source = "noise"\nparameters = { resolution = 32, seed = 4 }', 'file = "a.vdb"')
    (tmp_path / "shot.toml").write_text(text)
    may_go_on, asked = threading.Event(), []
    right = _bounds.program.ask

    def slow(words, seconds):
        asked.append(words)
        assert may_go_on.wait(PATIENCE)
        if len(asked) == 1:
            raise _bounds.Failure("scrim took longer than 20 seconds")
        return right(words, seconds)

    monkeypatch.setattr(_bounds.program, "ask", slow)
    serving = Serving(lambda: _opening.opened(str(tmp_path / "shot.toml")))
    browser = Browser(serving)
    browser.until(lambda m: m["type"] == "state")
    browser.send(type="view", to="frame")
    browser.until(lambda m: m["type"] == "state" and m["message"] == "reading where the volumes are")
    assert serving.get("/page.js")[0] == 200
    may_go_on.set()
    assert "does not say where its voxels are" in browser.until(lambda m: m["type"] == "error")["text"]
    browser.send(type="view", to="frame")
    browser.until(lambda m: m["type"] == "state" and m["free"])
    assert len(asked) == 2
    browser.close()
    serving.end()
