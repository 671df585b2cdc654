# SPDX-License-Identifier: Apache-2.0
"""Texts and names of files that are no plain text: half characters, NULs, bytes that are not UTF-8."""

import os
import re
import shutil
import subprocess
import sys

import pytest
from conftest import PROGRAM, SMOKE

import scrim

HALF = "\ud800"
NUL = "victim\0.exr"


@pytest.fixture
def frame(smoke):
    return scrim.open(smoke, {"camera.resolution": [8, 8], "render.quality": "draft"}).render()


@pytest.mark.parametrize(
    "call, text",
    [
        (lambda shot: scrim.loads(f"[camera]\nfov = 3 # {HALF}"), r"the scene: '\ud800' at line 2, column 11 is no"),
        (lambda shot: scrim.loads({"camera": {"exr": HALF}}), r"'camera.exr' is not UTF-8: '\ud800'"),
        (lambda shot: shot.set([f"camera.fov={HALF}"]), r"override 1: '\ud800' at line 1, column 12 is no whole"),
        (lambda shot: shot.set({HALF: 3}), r"\ud800"),
        (lambda shot: shot.set({"output.file": HALF}), r"'output.file' is not UTF-8: '\ud800'"),
        (lambda shot: shot.set_volume(HALF, []), r"the name of a volume is '\ud800'; expected a string of whole char"),
        (lambda shot: shot.render(verify=HALF), r"verify is '\ud800'; expected a string of whole characters"),
        (lambda shot: scrim.Field([[[1.0]]], name=HALF), r"the name of a grid is '\ud800'; expected"),
    ],
)
def test_half_characters_are_refused_by_name(smoke, call, text):
    with pytest.raises(scrim.UsageError, match=re.escape(text)):
        call(scrim.open(smoke))


def test_the_name_of_a_layer_is_a_whole_text(frame):
    for ask in (lambda: frame[HALF], lambda: frame.channels(HALF)):
        with pytest.raises(scrim.UsageError, match=r"the name of a layer is '\\ud800'"):
            ask()


@pytest.fixture
def victim(tmp_path, monkeypatch):
    """A file whose name is that of a path up to its NUL, in the current folder."""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "victim"
    path.write_text("mine")
    yield
    assert path.read_text() == "mine" and not list(tmp_path.glob("*.exr"))


@pytest.mark.parametrize("call", ["write", "write_deep", "preview"])
def test_a_picture_is_not_written_to_a_path_with_a_nul(victim, frame, call):
    with pytest.raises(scrim.UsageError, match=r"the path 'victim\\x00.exr' holds a NUL; expected one without"):
        getattr(frame, call)(NUL)


@pytest.mark.parametrize(
    "call",
    [
        lambda: scrim.open(NUL),
        lambda: scrim.open("smoke.toml", ocio=NUL),
        lambda: scrim.loads(SMOKE, folder=NUL),
        lambda: scrim.loads(SMOKE, name=NUL),
        lambda: scrim.read_vdb(NUL),
        lambda: scrim.open("smoke.toml").study(1, NUL, budget=0.1),
    ],
    ids=["open", "ocio", "folder", "name", "read_vdb", "study"],
)
def test_no_path_with_a_nul_is_opened(victim, smoke, call):
    with pytest.raises(scrim.UsageError, match="holds a NUL"):
        call()


@pytest.mark.parametrize("key", ["output.file", "output.deep", "output.preview", "volume.smoke.file", "camera.exr"])
def test_no_scene_names_a_path_with_a_nul(victim, smoke, key):
    for overrides in ({key: NUL}, [f'{key}="victim\\u0000.exr"']):
        with pytest.raises(scrim.InputError, match="a string without NUL characters"):
            scrim.open(smoke, overrides).render().write()


ODD = os.fsdecode(b"sm\xf6ke")  # Latin-1


def test_files_may_have_names_that_are_not_utf8(tmp_path, smoke, program):
    shutil.copy(smoke, tmp_path / f"{ODD}.toml")
    shot = scrim.open(tmp_path / f"{ODD}.toml", {"camera.resolution": [8, 8]})
    assert shot.path == str(tmp_path / f"{ODD}.toml") and ODD in repr(shot)
    out = shot.render().write(tmp_path / f"{ODD}.exr")
    assert out == str(tmp_path / f"{ODD}.exr") and os.path.exists(out)
    assert program("make", "noise", "resolution=16", "-q", "-o", tmp_path / f"{ODD}.vdb").returncode == 0
    assert scrim.read_vdb(tmp_path / f"{ODD}.vdb")
    with pytest.raises(scrim.InputError, match=ODD):
        scrim.open(tmp_path / f"{ODD}2.toml")
    with pytest.raises(scrim.InputError, match=f"{ODD}:1:1"):
        scrim.loads("[camera]\nfow = 3", name=ODD)


def test_the_viewer_shows_files_whose_names_are_not_utf8(tmp_path, smoke, program, python_path):
    pytest.importorskip("tornado")
    pytest.importorskip("tomlkit")
    from viewing import Viewer

    folder = tmp_path / ODD
    folder.mkdir()
    shutil.copy(smoke, folder / f"{ODD}.toml")
    shutil.copy(smoke, folder / "plain.toml")
    for path, title in ((folder / f"{ODD}.toml", f"{ODD}.toml"), (folder, "plain.toml")):
        viewer = Viewer(path, python_path)
        browser = viewer.browser()
        browser.until_exact()
        assert browser.state["title"] == title
        if title == "plain.toml":
            assert browser.state["others"] == ["plain.toml", f"{ODD}.toml"]
            browser.send(type="open", name=f"{ODD}.toml")
            browser.until(lambda m: m["type"] == "state" and m["title"] == f"{ODD}.toml")
            browser.until_exact()
        browser.send(type="set", id="light.key.intensity", value=2.5, done=True)
        browser.send(type="save")
        browser.until(lambda m: m["type"] == "state" and m["message"].startswith("saved"))
        browser.close()
        viewer.close()
        assert viewer.process.stderr.closed and "intensity = 2.5" in (folder / f"{ODD}.toml").read_text()
    done = subprocess.run(
        [PROGRAM, "view", os.fsencode(tmp_path / f"{ODD}2.toml")], capture_output=True,
        env={**python_path, "SCRIM_PYTHON": sys.executable},
    )  # fmt: skip
    assert done.returncode == 3 and done.stderr.startswith(b"scrim: error: ") and b"Traceback" not in done.stderr
