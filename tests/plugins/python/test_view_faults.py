# SPDX-License-Identifier: Apache-2.0
"""The viewer where something goes wrong: the page says so, and what is done next counts."""

import json
import shlex
import subprocess
import threading

import numpy
import OpenEXR
import pytest

pytest.importorskip("tornado")
pytest.importorskip("tomlkit")

from conftest import PROGRAM, SMOKE  # noqa: E402
from viewing import PATIENCE, Viewer  # noqa: E402

import scrim  # noqa: E402
from scrim.view import _opened, _renderer, _session  # noqa: E402

GROUPED = SMOKE.replace('type = "distant"', 'type = "distant"\ngroup = "suns"')
NAMES = ("Sun.001", "key-light", "Key Light", 'a\\"b', "lämpchen", "view1")


@pytest.fixture
def view(tmp_path, python_path):
    started = []

    def start(text):
        path = tmp_path / "shot.toml"
        path.write_text(text, encoding="utf-8")
        started.append(Viewer(path, python_path))
        return started[-1]

    yield start
    for viewer in started:
        viewer.close()


@pytest.fixture
def browser(view):
    made = view(SMOKE).browser()
    yield made
    made.close()


def half(text):
    return scrim.loads(text).render().image.astype(numpy.float16)


def rgba(path):
    with OpenEXR.File(str(path)) as file:
        return file.channels()["RGBA"].pixels


@pytest.mark.parametrize("name", [*NAMES, None])
def test_lights_of_any_name_and_of_groups_are_dimmed_turned_and_left_out(view, tmp_path, name):
    text = GROUPED if name is None else SMOKE.replace('name = "key"', f'name = "{name}"')
    light = json.loads(f'"{name or "key"}"')
    viewer = view(text)
    browser = viewer.browser()
    browser.until_layers()
    assert {f"light.{light}", "light.rim"} <= set(browser.pictures)
    browser.send(type="set", id=f"light.{light}.intensity", value=9.0, done=False)
    weights = browser.until(lambda m: m["type"] == "weights")["weights"]
    assert weights[f"light.{light}"] == pytest.approx([2, 2, 2]) and weights["light.rim"] == [1, 1, 1]
    before = dict(browser.head["slots"])
    browser.send(type="set", id=f"light.{light}.elevation", value=-20.0, done=False)
    browser.until(lambda m: m["type"] == "pictures")
    assert browser.head["slots"][f"light.{light}"] != before[f"light.{light}"]
    assert browser.head["slots"]["light.rim"] == before["light.rim"]
    browser.send(type="muted", names=[f"light.{light}"])
    browser.send(type="rest")
    browser.until_layers()
    words = shlex.split(browser.state["command"])
    done = subprocess.run([PROGRAM, *words[1:], "-q"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, (done.stderr, words)
    browser.send(type="muted", names=[])
    browser.send(type="save")
    browser.until(lambda m: m["type"] == "state" and m["message"].startswith("saved"))
    browser.send(type="rest")
    assert numpy.array_equal(browser.until_exact(), half((tmp_path / "shot.toml").read_text(encoding="utf-8")))
    assert not browser.errors
    # Without the light: what the command renders.
    dark = (tmp_path / "shot.toml").read_text(encoding="utf-8").replace("intensity = 9.0", "intensity = 0.0")
    scrim.loads(dark).render().write(tmp_path / "dark.exr")
    assert numpy.array_equal(rgba(tmp_path / "picture.exr"), rgba(tmp_path / "dark.exr"))
    browser.close()


def value(browser, name):
    found = [c["value"] for group in browser.state["groups"] for c in group["controls"] if c["id"] == name]
    return found[0]


JUNK = (None, True, -1, 10**400, 2**31, 1.5, float("nan"), float("inf"), "", "x", "\ud800", "a\0b", [], [[]], {},
        [None])  # fmt: skip
FIELDS = {
    "navigate": ("mode", "dx", "dy"), "rest": (), "view": ("to",), "set": ("id", "value"), "place": ("light", "x", "y"),
    "add": ("light",), "remove": ("light",), "highlight": ("light", "x", "y"), "camera": ("name",), "muted": ("names",),
    "frame": ("number",), "play": ("on",), "region": ("box",), "undo": (), "redo": (), "save": ("name",),
    "display": ("display", "view"), "open": ("name",), "have": (), "verify": (),
}  # fmt: skip
GOOD = {"mode": "orbit", "dx": 0.1, "dy": 0.1, "id": "light.key.intensity", "light": "key", "x": 0.5, "y": 0.5,
        "display": "sRGB", "view": "x"}  # fmt: skip


def malformed():
    yield from ("", "{", "[]", "3", '"x"', "null", "{}", "[" * 60000, '{"type":' + "[" * 60000, b"\xff\xfe")
    for kind in JUNK:
        yield json.dumps({"type": kind})
    for kind, fields in FIELDS.items():
        yield json.dumps({"type": kind, "serial": "x"})
        for field in fields:
            for junk in JUNK:
                given = {name: GOOD.get(name) for name in fields} | {field: junk}
                yield json.dumps({"type": kind, **given})
    for control in ("light.key.color", "light.key.shadows", "volume.smoke.ax", "volume.smoke.density.ramp",
                    "volume.smoke.medium.scattering", "scene.render.quality", "volume.smoke.density.scale"):  # fmt: skip
        for junk in (*JUNK, [10**400] * 3, [[10**400, 1, None]] * 2, [[0, 0, None], [1, "x", None]]):
            yield json.dumps({"type": "set", "id": control, "value": junk})


def test_no_message_ends_the_connection_or_the_viewer(browser):
    browser.until_exact()
    for message in malformed():
        browser._do(lambda: browser._socket.write_message(message, binary=isinstance(message, bytes)))  # noqa: B023
    browser.send(type="play", on=False)
    browser.send(type="muted", names=[])
    browser.send(type="set", id="volume.smoke.ax", value="")
    browser.send(type="region", box=None)
    browser.send(type="view", to="scene")
    browser.send(type="set", id="light.key.intensity", value=3.25, done=True)
    browser.until_exact()
    assert value(browser, "light.key.intensity") == 3.25
    assert not [text for text in browser.errors if text.startswith("the viewer failed")], browser.errors


def test_a_frame_beyond_all_frames_is_refused_and_the_frame_stays(view):
    viewer = view(SMOKE)
    one, two = viewer.browser(), viewer.browser()
    one.until_exact()
    one.send(type="frame", number=2147483648, done=True)
    told = one.until(lambda m: m["type"] == "error")["text"]
    assert told == "the page asks for frame 2147483648; expected one up to 1000000000"
    two.send(type="set", id="light.key.intensity", value=2.0, done=True)
    two.until_exact()
    assert two.state["frame"] == 1 and not two.errors
    one.close()
    two.close()


OUTPUTS = """
[[output]]
layers = ["light"]
fps = 30
[[output]]
file = "z.exr"
layers = ["depth"]
"""


def test_a_scene_with_several_outputs_plays(tmp_path, program, python_path):
    for frame in (1, 2):
        assert program("make", "noise", "resolution=16", f"seed={frame}", "-q", "-o",
                       tmp_path / f"s.{frame}.vdb").returncode == 0  # fmt: skip
    text = SMOKE.split("[output]")[0] + OUTPUTS
    text = text.replace('source = "noise"\nparameters = { resolution = 32, seed = 4 }', 'file = "s.#.vdb"')
    (tmp_path / "shot.toml").write_text(text)
    viewer = Viewer(tmp_path / "shot.toml", python_path)
    browser = viewer.browser()
    browser.until_layers()
    browser.send(type="play", on=True)
    seen = []
    browser.until(lambda m: m["type"] == "frame" and (seen.append(m["number"]) or len(seen) > 3))
    assert seen == [2, 1, 2, 1] and not browser.errors
    browser.close()
    viewer.close()


class Heard:
    """A session of this process, whose calls are made by the test."""

    def __init__(self, text=SMOKE):
        self.calls, self.errors, self.states = [], [], []
        self.shown = threading.Event()
        opened = _opened.Opened(text, "", ".", "smoke", [1])
        self.session = _session.Session(
            opened, self.hear, self.shown.set, lambda seconds, call: self.calls.append(call)
        )

    def hear(self, message):
        if message["type"] == "error":
            self.errors.append(message["text"])
        if message["type"] == "state":
            self.states.append(message)

    def until(self, wanted):
        for _ in range(100 * PATIENCE):
            while self.calls:
                self.calls.pop(0)()
            if wanted():
                return
            self.shown.wait(0.01)
            self.shown.clear()
        raise AssertionError(self.errors)


@pytest.mark.parametrize("where", ["pictures_of", "next_task"])
def test_whatever_fails_in_the_renderer_is_told_and_the_next_change_is_rendered(monkeypatch, where):
    right = getattr(_renderer, where)
    fails = [True]

    def wrong(*arguments, **more):
        if fails[0]:
            raise KeyError("light.key")
        return right(*arguments, **more)

    monkeypatch.setattr(_renderer, where, wrong)
    heard = Heard()
    heard.until(lambda: heard.errors)
    assert "the viewer failed: KeyError: 'light.key'" in heard.errors[0] and heard.session.pictures is None
    fails[0] = False
    heard.session.handle({"type": "set", "id": "light.key.intensity", "value": 2.0, "done": True, "serial": 1})
    heard.until(lambda: heard.session.exact_frame() is not None)
    heard.session.close()


def test_what_fails_while_a_picture_is_taken_is_told():
    heard = Heard()
    heard.until(lambda: heard.session.exact_frame() is not None)
    heard.session.player.took = lambda *_: 1 / 0
    heard.session.handle({"type": "set", "id": "volume.smoke.density.scale", "value": 2.0, "done": True, "serial": 1})
    heard.until(lambda: heard.errors)
    assert heard.errors[0].startswith("the viewer failed: ZeroDivisionError: ")
    heard.session.close()
