# SPDX-License-Identifier: Apache-2.0
"""The viewer on stages of OpenUSD: their cameras, and what they leave behind when they are saved as scenes."""

import shlex
import shutil
import subprocess
import sys
import threading
import time
import zipfile

import numpy
import OpenEXR
import pytest

pytest.importorskip("tornado")
pytest.importorskip("tomlkit")
pytest.importorskip("pxr", reason="usd-core is not installed")

from conftest import PROGRAM  # noqa: E402
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdRender  # noqa: E402
from usd_stages import lit_fog_stage, write_fog  # noqa: E402
from viewing import PATIENCE, Browser, Door, Serving, Viewer  # noqa: E402

import scrim.usd  # noqa: E402
import scrim.view._document  # noqa: E402
import scrim.view._opening  # noqa: E402


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


def test_a_stage_is_shown_in_a_notebook_with_its_cameras(stage):
    shot = scrim.usd.open(stage, {"light.key.intensity": 7.0})
    view = shot.view(height=300)
    assert 'height="300"' in view._repr_html_()
    browser = Browser(Door(view.url))
    assert numpy.array_equal(browser.until_exact(), shot.render().image.astype(numpy.float16))
    assert browser.state["cameras"] == ["/cam", "/World/side"]
    browser.close()
    view.close()
    assert "intensity = 7.0" in view.toml


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


def test_a_stage_is_not_saved_over_anything(browser, stage):
    browser.until_exact()
    (stage.parent / "there.toml").write_text("mine")
    (stage.parent / "taken.files").mkdir()
    (stage.parent / "taken.files" / "card.ply").write_text("mine")
    before = sorted(stage.parent.iterdir())
    for name in ("there", "taken"):
        browser.send(type="save", name=f"{name}.toml")
        assert "there is such a file already" in browser.until(lambda m: m["type"] == "error")["text"]
    assert sorted(stage.parent.iterdir()) == before
    assert (stage.parent / "taken.files" / "card.ply").read_text() == "mine"


def test_a_stage_whose_scene_cannot_be_saved_leaves_no_files(browser, stage, monkeypatch):
    opened = scrim.view._opening.opened(str(stage))
    files = opened.temporary_files(scrim.view._document.Document(opened.text).data)
    assert files
    monkeypatch.setattr(shutil, "copy", lambda *_: open("/no/such/folder/x", "w"))
    with pytest.raises(scrim.OutputError, match="cannot write to '.*half.files': No such file or directory"):
        opened.copied(files, "half.toml")
    assert not (stage.parent / "half.files").exists()


@pytest.fixture
def packed(tmp_path):
    """A stage whose volumes, sky and profile of a light are in archives, some of one name."""
    made = lit_fog_stage(tmp_path)
    sky = numpy.zeros((8, 16, 3), numpy.float32)
    sky[:4] = 2.0
    OpenEXR.File({"type": OpenEXR.scanlineimage}, {"RGB": sky}).write(str(tmp_path / "sky.exr"))
    (tmp_path / "lamp.ies").write_text(
        "IESNA:LM-63-1995\nTILT=NONE\n1 1000 1 3 1 1 2 0 0 0\n1 1 0\n0 45 90\n0\n100 70 10\n"
    )
    contents = {"one/fog.usdz": {"slab.vdb": 1, "sky.exr": 0}, "two/fog.usdz": {"slab.vdb": 2, "lamp.ies": 0}}
    for archive, members in contents.items():
        (tmp_path / archive).parent.mkdir()
        with zipfile.ZipFile(tmp_path / archive, "w") as file:
            for member, value in members.items():
                file.write(write_fog(tmp_path, value=value) if value else tmp_path / member, member)
    for name in ("slab.vdb", "sky.exr", "lamp.ies"):
        (tmp_path / name).unlink()
    volume = made.volume("/two", ["two/fog.usdz[slab.vdb]", "one/fog.usdz[slab.vdb]"], ["density", "temperature"])
    made.stage.GetPrimAtPath("/two/temperature").GetAttribute("fieldName").Set("density")
    made.say(volume, "emission:grid", Sdf.ValueTypeNames.String, "temperature")
    volume.AddTranslateOp().Set(Gf.Vec3d(4, 0, 0))
    made.stage.GetPrimAtPath("/fog/density").GetAttribute("filePath").Set("one/fog.usdz[slab.vdb]")
    dome = made.light("DomeLight", "/sky")
    dome.GetTextureFileAttr().Set("one/fog.usdz[sky.exr]")
    lamp = made.light("SphereLight", "/lamp", radius=0.5, intensity=50.0)
    UsdLux.ShapingAPI.Apply(lamp.GetPrim()).CreateShapingIesFileAttr("two/fog.usdz[lamp.ies]")
    UsdGeom.Xformable(lamp).AddTranslateOp().Set(Gf.Vec3d(0, 30, 0))
    made.stage.Save()
    return made.path


def test_a_saved_stage_keeps_all_files_of_its_archives(packed, python_path):
    viewer = Viewer(packed, python_path, "--frame=1")
    browser = viewer.browser()
    shown = browser.until_exact()
    browser.send(type="save", name="kept.toml")
    browser.until(lambda m: m["type"] == "state" and m["file"] == "kept.toml")
    assert not browser.errors
    browser.close()
    viewer.close()  # and with it whatever was temporary
    text = (packed.parent / "kept.toml").read_text()
    assert "scrim-usd-" not in text
    kept = [path for path in (packed.parent / "kept.files").rglob("*") if path.is_file()]
    assert sorted(path.name for path in kept) == ["lamp.ies", "sky.exr", "slab.vdb", "slab.vdb"]
    assert numpy.array_equal(half(scrim.open(packed.parent / "kept.toml").render()), shown)


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


class Held:
    """A viewer of this process, whose stage's method `name` waits in each call until `may_go_on` is set, or for a third
    of PATIENCE. `arguments`: of all calls. `was_let_go`: whether each call went on because of `may_go_on`. `problems`:
    what the next calls raise; None: nothing."""

    def __init__(self, path, name, monkeypatch):
        self.arguments, self.was_let_go, self.problems = [], [], []
        self.begun, self.may_go_on = threading.Event(), threading.Event()
        self.may_go_on.set()
        right = getattr(scrim.usd.Shot, name)
        monkeypatch.setattr(scrim.usd.Shot, name, lambda shot, it: self._call(right, shot, it))
        self.serving = Serving(lambda: scrim.view._opening.opened(str(path)))
        self.browser = Browser(self.serving)
        self.browser.until_exact()
        self.may_go_on.clear()
        self.begun.clear()
        self.arguments, self.was_let_go = [], []

    def _call(self, right, shot, it):
        self.arguments.append(it)
        self.begun.set()
        self.was_let_go.append(self.may_go_on.wait(PATIENCE / 3))
        if self.problems and (problem := self.problems.pop(0)) is not None:
            raise problem
        return right(shot, it)


@pytest.fixture
def hold(moving, monkeypatch):
    made = []

    def hold(name):
        made.append(Held(moving, name, monkeypatch))
        return made[0]

    yield hold
    made[0].may_go_on.set()
    made[0].browser.close()
    made[0].serving.end()


@pytest.mark.parametrize(
    ("name", "message", "frame", "camera"),
    [
        ("toml", {"type": "frame", "number": 3}, 3, None),
        ("through", {"type": "camera", "name": "/World/side"}, 1, "/World/side"),
    ],
)
def test_others_are_answered_while_a_stage_is_read(hold, moving, name, message, frame, camera):
    held = hold(name)
    browser, other = held.browser, Browser(held.serving)
    browser.send(**message, done=True)
    assert held.begun.wait(PATIENCE)
    assert held.serving.get("/page.js")[0] == 200 and held.was_let_go == []
    browser.until(lambda m: m["type"] == "state" and m["message"].startswith("reading the "))
    other.serial = browser.serial
    other.send(type="set", id="light.key.intensity", value=7.0, done=True)
    other.until(lambda m: m["type"] == "state" and m["serial"] == other.serial)
    other.until(lambda m: m["type"] == "pictures" and m["exact"])
    assert other.head["serial"] < browser.serial and other.state["frame"] == 1  # the browser's event still waits
    held.may_go_on.set()
    browser.serial = other.serial
    picture = browser.until_exact()
    assert held.was_let_go == [True]
    right = scrim.usd.open(moving, {"light.key.intensity": 7.0}, camera=camera).render(frame)
    assert numpy.array_equal(picture, half(right)) and browser.state["message"] == ""
    other.close()


def test_of_frames_that_wait_for_the_stage_only_the_last_one_is_read(hold):
    held = hold("toml")
    for number in (2, 3, 1, 3):
        held.browser.send(type="frame", number=number, done=False)
        assert held.begun.wait(PATIENCE)
    held.browser.send(type="rest")  # is heard after the frames
    held.browser.until(lambda m: m["type"] == "state" and m["serial"] == held.browser.serial)
    held.may_go_on.set()
    held.browser.until_exact()
    assert held.arguments == [2, 3] and held.browser.state["frame"] == 3


def test_a_frame_that_is_read_when_playing_ends_is_not_gone_to(hold):
    held = hold("toml")
    held.browser.send(type="play", on=True)
    assert held.begun.wait(PATIENCE)
    held.browser.send(type="play", on=False)
    held.browser.until(lambda m: m["type"] == "state" and m["serial"] == held.browser.serial)
    held.may_go_on.set()
    while held.serving.server.session._stage.turns.is_busy:
        time.sleep(0.01)
    held.browser.send(type="rest")
    held.browser.until(lambda m: m["type"] == "state" and m["serial"] == held.browser.serial)
    assert held.browser.state["frame"] == 1 and held.arguments == [2]


def test_what_is_wrong_with_a_frame_of_a_stage_is_told_and_the_frame_stays(hold):
    held = hold("toml")
    browser = held.browser
    held.may_go_on.set()
    for message in ({"type": "play", "on": True}, {"type": "frame", "number": 2, "done": True}):
        held.problems = [scrim.InputError("shot.usda: the fog is gone")]
        browser.send(**message)
        assert browser.until(lambda m: m["type"] == "error")["text"] == "shot.usda: the fog is gone"
        browser.until(lambda m: m["type"] == "state" and m["serial"] == browser.serial and not m["playing"])
        assert browser.state["frame"] == 1
    browser.send(type="frame", number=2, done=True)
    browser.until_exact()
    assert browser.state["frame"] == 2


def test_a_stage_that_is_saved_is_the_scene_of_the_frame_that_is_shown(moving, browser):
    browser.until_exact()
    browser.send(type="frame", number=3, done=True)
    shown = browser.until_exact()
    browser.send(type="save", name="third.toml")
    browser.until(lambda m: m["type"] == "state" and m["file"] == "third.toml")
    picture = scrim.open(moving.parent / "third.toml").render().image
    assert numpy.array_equal(picture.astype(numpy.float16), shown)
