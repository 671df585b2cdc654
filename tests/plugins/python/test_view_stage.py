# SPDX-License-Identifier: Apache-2.0
"""The viewer on stages of OpenUSD: their cameras, and what they leave behind when they are saved as scenes."""

import shlex
import subprocess
import sys

import numpy
import OpenEXR
import pytest

pytest.importorskip("tornado")
pytest.importorskip("tomlkit")
pytest.importorskip("pxr", reason="usd-core is not installed")

from conftest import PROGRAM  # noqa: E402
from pxr import Gf, Usd, UsdGeom, UsdRender  # noqa: E402
from usd_stages import lit_fog_stage  # noqa: E402
from viewing import Viewer  # noqa: E402

import scrim.usd  # noqa: E402


@pytest.fixture
def stage(tmp_path):
    """The slab with a card that hides half of it, and a second camera from the side."""
    made = lit_fog_stage(tmp_path)
    made.camera("/World/side", place=(50, 0, 0), turn=(0, 90, 0))
    card = UsdGeom.Plane.Define(made.stage, "/card")
    card.GetAxisAttr().Set("Z")
    card.GetWidthAttr().Set(12.0)
    card.GetLengthAttr().Set(30.0)
    UsdGeom.Xformable(card).AddTranslateOp().Set((6, 0, 20))
    made.stage.SetMetadata("renderSettingsPrimPath", "/Render/rs")
    settings = UsdRender.Settings.Define(made.stage, "/Render/rs")
    settings.GetResolutionAttr().Set(Gf.Vec2i(32, 32))
    settings.GetCameraRel().SetTargets(["/cam"])
    made.stage.Save()
    return made.path


@pytest.fixture
def browser(stage, python_path):
    viewer = Viewer(stage, python_path)
    browser = viewer.browser()
    yield browser
    browser.close()
    viewer.close()


def test_a_stage_is_seen_through_its_other_cameras(browser):
    front = browser.until_exact()
    assert browser.state["cameras"] == ["/cam", "/World/side"]
    assert front[16, 26, 3] == 0 and front[16, 6, 3] > 0.1  # the card hides the right half
    browser.send(type="camera", name="/World/side", done=True)
    side = browser.until_exact()
    assert side[16, 16, 3] > 0.1 and numpy.abs(side - front).max() > 0.1
    browser.send(type="undo")
    assert numpy.array_equal(browser.until_exact(), front)
    browser.send(type="camera", name="/key")
    assert "no camera '/key'" in browser.until(lambda m: m["type"] == "error")["text"]


def test_a_saved_stage_keeps_its_solids(browser, stage):
    shown = browser.until_exact()
    browser.send(type="save", name="kept.toml")
    browser.until(lambda m: m["type"] == "state" and m["file"] == "kept.toml")
    folder = stage.parent
    (solid,) = (folder / "kept.files").iterdir()
    assert f'file = "kept.files/{solid.name}"' in (folder / "kept.toml").read_text()
    picture = scrim.open(folder / "kept.toml").render().image
    assert numpy.array_equal(picture.astype(numpy.float16), shown)
    assert numpy.array_equal(browser.until_exact(), shown)


@pytest.fixture
def moving(stage):
    """The stage, whose fog rises in three frames, while its second camera moves back."""
    made = Usd.Stage.Open(str(stage))
    made.SetStartTimeCode(1)
    made.SetEndTimeCode(3)
    rise = UsdGeom.Xformable(made.GetPrimAtPath("/fog")).AddTranslateOp(opSuffix="rise")
    back = UsdGeom.Xformable(made.GetPrimAtPath("/World/side")).AddTranslateOp(opSuffix="back")
    for frame in (1, 2, 3):
        rise.Set((0, 3.0 * (frame - 1), 0), frame)
        back.Set((0, 4.0 * (frame - 1), 0), frame)
    made.Save()
    return stage


def half(frame):
    return frame.image.astype(numpy.float16)


def test_frames_of_a_stage_are_those_of_the_command_and_changes_go_with_them(moving, browser, python_path):
    shot = scrim.usd.open(moving)
    assert numpy.array_equal(browser.until_exact(), half(shot.render(1)))
    assert browser.state["frames"] == [1, 2, 3]
    browser.send(type="frame", number=3, done=True)
    third = browser.until_exact()
    assert numpy.array_equal(third, half(shot.render(3))) and not numpy.array_equal(third, half(shot.render(1)))
    browser.send(type="set", id="light.key.intensity", value=7.0, done=True)
    browser.until_exact()
    browser.send(type="frame", number=2, done=True)
    second = browser.until_exact()
    brighter = scrim.usd.open(moving, {"light.key.intensity": 7.0})
    assert numpy.array_equal(second, half(brighter.render(2)))
    # The command line makes this picture of the stage.
    words = shlex.split(browser.state["command"])[1:-1]
    environment = {**python_path, "SCRIM_PYTHON": sys.executable}
    command = [PROGRAM, *words, moving.parent / "p.exr", "-q"]
    subprocess.run(command, check=True, cwd=moving.parent, env=environment)
    with OpenEXR.File(str(moving.parent / "p.exr")) as file:
        (x0, y0), (x1, y1) = file.header()["dataWindow"]
        part = second[y0 : y1 + 1, x0 : x1 + 1]
        assert numpy.array_equal(file.channels()["RGBA"].pixels.astype(numpy.float32), part)
        assert part.sum() == second.sum()  # the rest is empty
    # What is undone is the change; the frame stays.
    browser.send(type="undo")
    assert numpy.array_equal(browser.until_exact(), half(shot.render(2))) and browser.state["frame"] == 2
    browser.send(type="redo")
    assert numpy.array_equal(browser.until_exact(), second)


def test_a_camera_that_is_looked_through_moves_with_the_frames(moving, browser):
    browser.until_exact()
    browser.send(type="camera", name="/World/side", done=True)
    browser.until_exact()
    browser.send(type="frame", number=3, done=True)
    side = scrim.usd.open(moving, camera="/World/side")
    assert numpy.array_equal(browser.until_exact(), half(side.render(3)))
    browser.send(type="frame", number=1, done=True)
    assert numpy.array_equal(browser.until_exact(), half(side.render(1)))


def test_frames_of_a_stage_play_and_are_kept(moving, browser):
    browser.until_exact()
    browser.send(type="play", on=True)
    seen = []
    browser.until(lambda m: m["type"] == "frame" and (seen.append(m["number"]) or len(seen) > 7))
    browser.send(type="play", on=False)
    assert seen[:7] == [2, 3, 1, 2, 3, 1, 2]
    browser.until_exact()
    frame = browser.state["frame"]
    assert numpy.array_equal(browser.pictures["beauty"], half(scrim.usd.open(moving).render(frame)))


def test_a_stage_that_is_saved_is_the_scene_of_the_frame_that_is_shown(moving, browser):
    browser.until_exact()
    browser.send(type="frame", number=3, done=True)
    shown = browser.until_exact()
    browser.send(type="save", name="third.toml")
    browser.until(lambda m: m["type"] == "state" and m["file"] == "third.toml")
    picture = scrim.open(moving.parent / "third.toml").render().image
    assert numpy.array_equal(picture.astype(numpy.float16), shown)
