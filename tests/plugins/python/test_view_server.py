# SPDX-License-Identifier: Apache-2.0
"""`scrim view` without a browser: what it shows, saves and refuses, by real requests to its own process."""

import asyncio
import gc
import http.cookiejar
import os
import re
import shlex
import signal
import subprocess
import sys
import threading
import time
import urllib.request
import weakref
from dataclasses import replace
from pathlib import Path

import numpy
import OpenEXR
import pytest

pytest.importorskip("tornado")
pytest.importorskip("tomlkit")

import psutil  # noqa: E402
from conftest import PROGRAM, SMOKE  # noqa: E402
from viewing import PATIENCE, Browser, Serving, Viewer  # noqa: E402

import scrim  # noqa: E402
from scrim.view import _opening, _session  # noqa: E402

COMMENTED = SMOKE.replace("intensity = 4.5", "intensity = 4.5   # the sun").replace("[camera]", "# A shot\n[camera]")


@pytest.fixture
def view(tmp_path, python_path):
    """Starts viewers, and ends them."""
    started = []

    def start(text=COMMENTED, *options):
        path = tmp_path / "shot.toml"
        path.write_text(text)
        started.append(Viewer(path, python_path, *options))
        return started[-1]

    yield start
    for viewer in started:
        viewer.close()


def rgba(path):
    with OpenEXR.File(str(path)) as file:
        channels = file.channels()
        if "RGBA" in channels:
            return channels["RGBA"].pixels
        return numpy.stack([channels[name].pixels for name in "RGBA"], axis=-1)


def test_the_first_picture_is_refined_to_that_of_the_scene(view):
    browser = view().browser()
    stages = []
    browser.until(lambda m: m["type"] == "pictures" and (stages.append(m["stage"]) or m["exact"]))
    order = ["motion", "draft", "final"]  # a slow browser is not sent all of them
    assert stages[-1] == "final" and [order.index(s) for s in stages] == sorted(order.index(s) for s in stages)
    assert numpy.array_equal(browser.pictures["beauty"], scrim.loads(COMMENTED).render().image.astype(numpy.float16))
    if not browser.head["layers"]:  # they come behind it, and the picture stays
        beauty = browser.head["slots"]["beauty"]
        browser.until(lambda m: m["type"] == "pictures" and m["layers"])
        assert browser.head["slots"]["beauty"] == beauty and browser.head["exact"]
    assert {"light.key", "light.rim"} <= set(browser.pictures)
    browser.close()


def test_layers_and_weights_make_the_picture_of_other_strengths(view):
    browser = view(COMMENTED + "\n[render]\ntexel = 1.0\nsheet_thickness = 1.0\n").browser()
    browser.until_layers()
    browser.send(type="set", id="light.key.intensity", value=9.0, done=False)
    weights = browser.until(lambda m: m["type"] == "weights")["weights"]
    assert weights["light.key"] == pytest.approx([2, 2, 2]) and weights["light.rim"] == [1, 1, 1]
    mixed = sum(numpy.array(weights[name]) * browser.pictures[name] for name in weights if name in browser.pictures)
    browser.send(type="rest")
    rendered = browser.until_exact()[..., :3]
    # Half floats have 11 digits; the sum has three terms of at most the picture's size.
    assert numpy.abs(mixed - rendered).max() <= 4 * 2.0**-11 * rendered.max()
    browser.close()


def test_a_saved_scene_keeps_comments_and_renders_the_viewers_picture_bit_for_bit(view, tmp_path):
    viewer = view()
    browser = viewer.browser()
    browser.send(type="set", id="light.key.intensity", value=7.5, done=True)
    browser.send(type="set", id="light.rim.azimuth", value=25.0, done=True)
    browser.send(type="navigate", mode="orbit", dx=0.1, dy=-0.05)
    browser.send(type="view", to="keep")
    browser.send(type="save")
    browser.until(lambda m: m["type"] == "state" and m["message"].startswith("saved"))
    browser.until_exact()
    (tmp_path / "viewer.exr").write_bytes(viewer.get("/picture.exr")[1])
    text = (tmp_path / "shot.toml").read_text()
    assert "intensity = 7.5   # the sun" in text and "# A shot" in text
    # Only the keys that changed differ.
    same = set(COMMENTED.splitlines()) & set(text.splitlines())
    assert len(set(COMMENTED.splitlines()) - same) == 4  # position, target, intensity, direction
    done = subprocess.run([PROGRAM, "render", tmp_path / "shot.toml", "-q", "-o", tmp_path / "program.exr"])
    assert done.returncode == 0
    assert numpy.array_equal(rgba(tmp_path / "viewer.exr"), rgba(tmp_path / "program.exr"))
    assert browser.state["changed"] is False and not browser.errors
    browser.close()
    viewer.process.send_signal(signal.SIGINT)
    assert viewer.process.wait(PATIENCE) == 128 + signal.SIGINT
    assert viewer.process.stderr.read() == ""  # nothing is left over either


def test_the_command_line_renders_the_viewers_picture_bit_for_bit(view, tmp_path):
    viewer = view()
    browser = viewer.browser()
    browser.send(type="set", id="volume.smoke.density.scale", value=12.0, done=True)
    browser.send(type="navigate", mode="dolly", dx=0, dy=-0.1)
    browser.send(type="rest")
    browser.until_exact()
    words = shlex.split(browser.state["command"])
    assert words[:2] == ["scrim", "render"] and "volume.smoke.density.scale=12.0" in words
    done = subprocess.run([PROGRAM, *words[1:], "-q"], cwd=tmp_path)
    assert done.returncode == 0
    (tmp_path / "viewer.exr").write_bytes(viewer.get("/picture.exr")[1])
    assert numpy.array_equal(rgba(tmp_path / "viewer.exr"), rgba(tmp_path / "picture.exr"))
    browser.close()


def test_moving_a_light_renders_that_light_alone(view):
    browser = view().browser()
    browser.until_layers()
    before = dict(browser.head["slots"])
    browser.send(type="set", id="light.key.elevation", value=-20.0, done=False)
    browser.until(lambda m: m["type"] == "pictures")
    after = browser.head["slots"]
    assert after["light.key"] != before["light.key"]
    assert {n: after[n] for n in after if n != "light.key"} == {n: before[n] for n in before if n != "light.key"}
    assert browser.head["weights"]["light.key"] == [1, 1, 1]
    browser.close()


def camera_of(text):
    return COMMENTED.replace("position = [0, 0.3, 5]\ntarget = [0, 0, 0]\nfov = 36", text)


@pytest.mark.parametrize(
    "camera",
    [
        'type = "orthographic"\nposition = [0, 0.3, 5]\ntarget = [0, 0, 0]\nheight = 3',
        "matrix = [[1, 0, 0, 0], [0, 1, 0, 0.1], [0, 0, 1, 5], [0, 0, 0, 1]]\nfocal_length = 50\naperture = 36",
        "orbit = { center = [0, 0, 0], radius = 5, elevation = 10, azimuth = 20 }",
        "position = { keys = [[1, [0, 0.3, 5]], [9, [3, 0.3, 5]]] }\ntarget = [0, 0, 0]\nshutter = [-0.25, 0.25]",
    ],
    ids=["orthographic", "matrix", "orbit", "keyed"],
)
def test_every_kind_of_camera_is_moved_and_kept(view, tmp_path, camera):
    viewer = view(camera_of(camera))
    browser = viewer.browser()
    start = browser.until_exact()
    for mode in ("orbit", "pan", "dolly"):
        browser.send(type="navigate", mode=mode, dx=0.05, dy=0.05)
    browser.send(type="rest")
    moved = browser.until_exact()
    assert numpy.abs(moved - start).max() > 0.1
    browser.send(type="view", to="keep")
    if "keys" in camera:
        assert "has keys" in browser.until(lambda m: m["type"] == "error")["text"]
        browser.send(type="view", to="scene")
        assert numpy.array_equal(browser.until_exact(), start)
    else:
        kept = browser.until_exact()
        assert browser.state["free"] is False
        # Six digits of the camera's place move the picture by a few thousandths of a pixel.
        assert numpy.abs(kept - moved).mean() < 1e-3 * moved.mean()
    browser.close()


def test_a_light_that_was_dark_is_rendered_when_it_is_to_shine(view):
    browser = view(COMMENTED.replace("intensity = 4.5", "intensity = 0.0")).browser()
    assert "light.key" not in browser.pictures
    dark = browser.until_exact()
    browser.send(type="set", id="light.key.intensity", value=4.0, done=True)
    assert browser.until_exact()[..., 0].mean() > 2 * dark[..., 0].mean()
    browser.close()


def test_a_muted_layer_has_no_weight_and_stays_in_the_scene(view):
    browser = view().browser()
    browser.until_layers()
    browser.send(type="muted", names=["light.key"])
    state = browser.until(lambda m: m["type"] == "state" and m["muted"])
    assert state["weights"]["light.key"] == [0, 0, 0] and state["weights"]["light.rim"] == [1, 1, 1]
    assert state["changed"] is False and "--set light.key.intensity=0.0" in state["command"]
    browser.close()


def test_what_is_wrong_is_told_where_it_is_and_changes_nothing(view):
    browser = view().browser()
    browser.send(type="set", id="light.key.intensity", value=-1.0, done=True)
    assert "shot.toml:18:13: 'intensity' is -1" in browser.until(lambda m: m["type"] == "error")["text"]
    assert browser.state["changed"] is False  # told before the error, which stays on the page
    for message, text in [
        ({"type": "set", "id": "light.key.intensity", "value": "9"}, "expected a number"),
        ({"type": "set", "id": "volume.smoke.file", "value": "/etc/passwd"}, "has no control 'volume.smoke.file'"),
        ({"type": "save", "name": "../other.toml"}, "expected one such as shot.toml, without folders"),
        ({"type": "save", "name": "shot.toml"}, "there is such a file already"),
        ({"type": "fly"}, "asks for 'fly', which this viewer does not know"),
        ({"type": "navigate", "mode": "roll", "dx": 0, "dy": 0}, "expected orbit, pan or dolly"),
        ({"type": "muted", "names": ["sun"]}, "expected some of ambient, emission, light.key, light.rim"),
        ({"type": "display", "display": "sRGB", "view": "none"}, "there is no view 'none'"),
        ({"type": "view", "to": "frame"}, "are not files"),
    ]:
        browser.send(**message)
        assert text in browser.until(lambda m: m["type"] == "error")["text"], message
    browser.close()


def test_undo_and_redo_go_step_by_step(view):
    browser = view().browser()
    for value in (5.0, 6.0, 7.0):  # one drag
        browser.send(type="set", id="light.key.intensity", value=value, done=False, step="a")
    browser.send(type="set", id="light.key.intensity", value=8.0, done=True, step="b")

    def intensity():
        state = browser.until(lambda m: m["type"] == "state" and m["serial"] == browser.serial)
        return state["groups"][0]["controls"][0]["value"]

    assert intensity() == 8.0
    for kind, wanted in [("undo", 7.0), ("undo", 4.5), ("redo", 7.0), ("redo", 8.0)]:
        browser.send(type=kind)
        assert intensity() == wanted, kind
    browser.close()


def test_a_file_that_somebody_else_changed_is_not_overwritten(view, tmp_path):
    browser = view().browser()
    browser.send(type="set", id="light.key.intensity", value=5.0, done=True)
    (tmp_path / "shot.toml").write_text(COMMENTED + "# mine\n")
    browser.send(type="save")
    assert "changed on disk" in browser.until(lambda m: m["type"] == "error")["text"]
    assert (tmp_path / "shot.toml").read_text().endswith("# mine\n")
    browser.send(type="save", name="new.toml")
    browser.until(lambda m: m["type"] == "state" and m["file"] == "new.toml")
    assert "intensity = 5.0" in (tmp_path / "new.toml").read_text()
    browser.close()


def test_a_region_alone_is_refined_until_it_is_taken_away(view):
    browser = view().browser()
    browser.until_layers()
    browser.send(type="region", box=[0.25, 0.0, 0.5, 1.0])
    browser.send(type="set", id="volume.smoke.density.scale", value=40.0, done=True)
    serial = browser.serial
    browser.until(lambda m: m["type"] == "pictures" and m["stage"] == "region" and m["serial"] == serial)
    part = browser.pictures["beauty"]
    assert browser.state["region"] == [16, 0, 32, 48] and not browser.head["exact"]
    browser.send(type="region", box=None)
    whole = browser.until_exact()
    assert numpy.array_equal(part[:, 16:32], whole[:, 16:32]) and not numpy.array_equal(part[:, :16], whole[:, :16])
    browser.send(type="region", box=[0.5, 0.5, 0.5, 0.5])
    browser.send(type="region", box=[0, 1])
    for text in ("the region has no pixel", "expected a box of four numbers"):
        assert text in browser.until(lambda m: m["type"] == "error")["text"]
    browser.close()


def test_a_verification_finds_the_error_that_the_program_finds(view, tmp_path):
    browser = view().browser()
    browser.send(type="verify")
    browser.until(lambda m: m["type"] == "pictures" and m["error"])
    found = browser.head["error"]
    stats = scrim.open(tmp_path / "shot.toml").render(verify=400).stats["verification"]
    assert found == stats and 0 < found["error"] < 0.05
    (pixels,) = browser.verified
    assert len(pixels["pixels"]) == stats["pixels"] and pixels["promise"] == 0.01 and pixels["states"]
    assert pixels["pixels"][0][:2] == stats["worst_pixel"]
    assert pixels["pixels"][0][4] == pytest.approx(stats["worst"], rel=1e-3)
    browser.close()


def test_two_browsers_see_the_same(view):
    viewer = view()
    one, two = viewer.browser(), viewer.browser()
    one.send(type="set", id="light.key.intensity", value=6.0, done=True)
    assert two.until(lambda m: m["type"] == "state" and m["changed"])["groups"][0]["controls"][0]["value"] == 6.0
    assert numpy.array_equal(one.until_exact(), two.until_exact())
    one.close()
    two.close()


def test_whoever_has_no_token_or_comes_from_elsewhere_is_refused(view, tmp_path):
    viewer = view()
    (tmp_path / "secret.txt").write_text("secret")
    assert viewer.get("/")[0] == 200
    for path in ("/", "/page.js", "/picture.exr", "/socket"):
        assert viewer.get(path, token=False)[0] == 403, path
        assert viewer.get(path + "?token=wrong", token=False)[0] == 403, path
        assert viewer.get(path, Host="evil.example")[0] == 403, path
        assert viewer.get(path, Origin="http://evil.example")[0] == 403, path
    for path in ("/secret.txt", "/shot.toml", "/../shot.toml", "/%2e%2e/__main__.py", "/etc/passwd", "//etc/passwd"):
        assert viewer.get(path)[0] in (403, 404), path
    with pytest.raises(Exception, match="403"):
        Browser(viewer, Origin=f"http://127.0.0.1:{viewer.port + 1}")
    assert f"127.0.0.1:{viewer.port}" in viewer.url
    listens = [c for c in psutil.Process(viewer.process.pid).net_connections() if c.status == "LISTEN"]
    assert [c.laddr.ip for c in listens] == ["127.0.0.1"]


@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGINT, "page"])
def test_it_ends_when_told_and_leaves_no_child(view, how):
    viewer = view()
    browser = viewer.browser()
    browser.until(lambda m: m["type"] == "pictures")
    children = psutil.Process(viewer.process.pid).children(recursive=True)
    if how == "page":
        browser.send(type="end")
    else:
        viewer.process.send_signal(how)
    assert viewer.process.wait(PATIENCE) == (0 if how == "page" else 128 + how)
    assert not [child for child in children if child.is_running() and child.status() != psutil.STATUS_ZOMBIE]
    browser.close()


@pytest.mark.parametrize(
    ("words", "status", "text"),
    [
        (["absent.toml"], 3, "absent.toml"),
        (["bad.toml"], 3, "bad.toml:4:1: "),
        (["picture.jpg"], 2, "expected a scene"),
        (["bad.toml", "--listen=8080"], 2, "--listen '8080': expected HOST:PORT"),
        (["bad.toml", "--up=w"], 2, "--up 'w': expected x, y, z"),
        (["bad.toml", "--res=64"], 2, "--res '64': expected WxH"),
        (["bad.toml", "--res=²x1"], 2, "--res '²x1': expected WxH"),
        (["bad.toml", "--listen=127.0.0.1:²"], 2, "--listen '127.0.0.1:²': expected HOST:PORT"),
        (["good.toml", "--res=64x64"], 2, "--up and --res are for assets"),
        (["empty"], 3, "empty: there is nothing to show; expected .toml, .usd, .vdb, .nrrd or .nii"),
        (["good.toml", "--listen=203.0.113.1:0"], 4, "cannot listen on 203.0.113.1:0"),
    ],
)
def test_a_viewer_that_cannot_start_says_why(tmp_path, python_path, words, status, text):
    (tmp_path / "bad.toml").write_text(SMOKE.replace("fov", "fow"))
    (tmp_path / "good.toml").write_text(SMOKE)
    (tmp_path / "empty").mkdir()
    environment = {**python_path, "SCRIM_PYTHON": sys.executable}
    done = subprocess.run(
        [PROGRAM, "view", *words], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=PATIENCE
    )
    assert (done.returncode, done.stdout) == (status, ""), done.stderr
    assert text in done.stderr.splitlines()[-1] and done.stderr.startswith("scrim: error: ")


def test_the_program_says_what_its_viewer_lacks(tmp_path):
    empty = tmp_path / "python"
    empty.write_text(f'#!/bin/sh\nexec {sys.executable} -S -E "$@"\n')
    empty.chmod(0o755)
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    for python, text in [(empty, "No module named 'scrim'"), (tmp_path / "none", "cannot start")]:
        done = subprocess.run(
            [PROGRAM, "view", "shot.toml"],
            env={**environment, "SCRIM_PYTHON": str(python)},
            capture_output=True,
            text=True,
        )
        assert done.returncode == 3 and text in done.stderr and "pip install '.[view]' in the folder of Scrim's" in done.stderr


def test_a_folder_opens_its_first_scene_and_then_the_others(tmp_path, program, python_path):
    assert program("make", "noise", "resolution=16", "-q", "-o", tmp_path / "a.vdb").returncode == 0
    (tmp_path / "absent.toml").write_text("[camera]")
    (tmp_path / "b.toml").write_text(COMMENTED)
    (tmp_path / "c.toml").write_text(COMMENTED.replace("[64, 48]", "[32, 24]"))
    (tmp_path / "notes.txt").write_text("mine")
    viewer = Viewer(tmp_path, python_path)
    browser = viewer.browser()
    assert browser.until_exact().shape == (48, 64, 4)
    assert browser.state["title"] == "b.toml"
    assert browser.state["others"] == ["absent.toml", "b.toml", "c.toml", "a.vdb"]
    for name, text in [("absent.toml", "absent.toml:1:1: "), ("notes.txt", "there is no 'notes.txt'"), (3, "no 3")]:
        browser.send(type="open", name=name)
        assert text in browser.until(lambda m: m["type"] == "error")["text"]
    for name, shape in [("c.toml", (24, 32, 4)), ("a.vdb", (512, 512, 4))]:
        browser.send(type="open", name=name)
        assert browser.until_exact().shape == shape and browser.state["title"] == name
    browser.close()
    viewer.close()


def test_an_asset_is_framed_and_saved_as_a_scene_beside_it(tmp_path, program, python_path):
    assert program("make", "noise", "resolution=24", "-q", "-o", tmp_path / "a.vdb").returncode == 0
    viewer = Viewer(tmp_path / "a.vdb", python_path, "--res=64x48")
    browser = viewer.browser()
    assert browser.until_exact().shape == (48, 64, 4)
    far = browser.pictures["beauty"][..., 3].mean()
    browser.send(type="navigate", mode="dolly", dx=0, dy=1.0)
    browser.until_exact()
    browser.send(type="view", to="frame")
    near = browser.until_exact()[..., 3].mean()
    assert near == pytest.approx(far, rel=0.5)  # it fills about as much as the asset's own framing
    browser.send(type="save")
    assert "has no file yet" in browser.until(lambda m: m["type"] == "error")["text"]
    browser.send(type="save", name="a.toml")
    browser.until(lambda m: m["type"] == "state" and m["file"] == "a.toml")
    assert Path(tmp_path / "a.toml").read_text().startswith("# A scene for")
    browser.close()
    viewer.close()


def test_a_refused_event_leaves_the_picture_finished(view):
    browser = view().browser()
    browser.until_exact()
    browser.send(type="set", id="light.key.intensity", value=-1.0, done=True)
    serial = browser.serial
    shown = browser.until(lambda m: m["type"] == "pictures" and m["serial"] == serial)
    assert shown["exact"]
    browser.close()


# ---- the start


def test_the_page_is_there_while_an_asset_is_read_and_the_picture_follows(tmp_path):
    (tmp_path / "shot.toml").write_text(COMMENTED)
    may_go_on = threading.Event()

    def opening():
        assert may_go_on.wait(PATIENCE)
        return _opening.opened(str(tmp_path / "shot.toml"))

    serving = Serving(opening)
    assert serving.get("/")[0] == 200 and serving.get("/page.js")[0] == 200 and serving.get("/picture.exr")[0] == 409
    browser = Browser(serving)
    browser.send(type="undo")  # is too early, and nothing happens
    assert serving.get("/style.css")[0] == 200
    may_go_on.set()
    browser.serial = 0
    assert numpy.array_equal(browser.until_exact(), scrim.loads(COMMENTED).render().image.astype(numpy.float16))
    browser.close()
    serving.end()


def test_a_viewer_can_end_while_an_asset_is_read_and_says_what_is_wrong_with_it():
    never = threading.Event()
    serving = Serving(lambda: never.wait(PATIENCE))
    assert serving.get("/")[0] == 200
    serving.end()
    never.set()

    def bad():
        raise scrim.InputError("a.vdb: bad")

    serving = Serving(bad)
    serving.thread.join(PATIENCE)
    assert str(serving.problem) == "a.vdb: bad"


def test_an_asset_is_read_once(tmp_path, program):
    asset = tmp_path / "a.vdb"
    assert program("make", "noise", "resolution=24", "-q", "-o", asset).returncode == 0
    scene = _opening.opened(str(asset))
    assert _opening.takes_long(str(asset)) and not _opening.takes_long(str(tmp_path / "a.toml"))
    before = scrim.open(asset).render().image.astype(numpy.float16)
    asset.write_bytes(b"")  # whoever reads it now finds nothing
    shown, failed = [], []
    there = threading.Event()
    session = _session.Session(scene, lambda message: message["type"] == "error" and failed.append(message["text"]),
                               lambda: there.set(), lambda seconds, call: call())  # fmt: skip
    while session.exact_frame() is None and not failed:
        assert there.wait(PATIENCE)
        there.clear()
    shown = session.exact_frame()
    session.close()
    assert not failed and numpy.array_equal(shown.image.astype(numpy.float16), before)


def test_the_volumes_of_an_asset_go_when_another_file_is_opened(tmp_path, program):
    for name, size in (("a", 150), ("b", 16)):
        assert program("make", "noise", f"resolution={size}", "-q", "-o", tmp_path / f"{name}.vdb").returncode == 0
    scenes = [replace(_opening.opened(str(tmp_path / "a.vdb")), others=["a.vdb", "b.vdb"])]
    first = weakref.ref(scenes[0])
    assert first().loaded is not None
    serving = Serving(scenes.pop)
    browser = Browser(serving)
    browser.until_exact()
    browser.send(type="open", name="b.vdb")
    browser.until(lambda m: m["type"] == "state" and m["title"] == "b.vdb")
    browser.until_exact()
    gc.collect()
    assert first() is None
    browser.close()
    serving.end()


# ---- who may come in


def browser_of(tmp_path):
    """A browser for $BROWSER that keeps its words, and a copy of the file that it is sent to with the file's mode."""
    path = tmp_path / "browser"
    path.write_text(
        f'#!/bin/sh\necho "$@" >{tmp_path}/words\nfile="${{1#file://}}"\nstat -c %a "$file" >{tmp_path}/mode\n'
        f'cp "$file" {tmp_path}/copy\nmv {tmp_path}/copy {tmp_path}/open.html\n'
    )
    path.chmod(0o755)
    return f"{path} %s"


@pytest.fixture
def invite(tmp_path, python_path):
    """A viewer that opens a browser."""
    (tmp_path / "shot.toml").write_text(COMMENTED)
    started = []

    def start(browser):
        environment = {**python_path, "TMPDIR": str(tmp_path)}
        started.append(Viewer(tmp_path / "shot.toml", environment, browser=browser))
        return started[-1]

    yield start
    for viewer in started:
        viewer.close()


def test_the_browser_gets_a_ticket_that_no_command_line_shows_and_that_counts_once(invite, tmp_path):
    viewer = invite(browser_of(tmp_path))
    for _ in range(10 * PATIENCE):
        if (tmp_path / "open.html").exists():
            break
        time.sleep(0.1)
    words = (tmp_path / "words").read_text().strip()
    assert words.startswith(f"file://{tmp_path}/scrim-view-") and viewer.token not in words
    assert (tmp_path / "mode").read_text().strip() == "600"
    page = (tmp_path / "open.html").read_text()
    ticket = re.search(r"/\?ticket=([\w-]+)", page)[1]
    assert ticket not in words and viewer.token not in page
    assert viewer.get(f"/?ticket={ticket}x", token=False)[0] == 403
    assert viewer.get(f"/?ticket={ticket}", token=False)[0] == 200  # with the cookie that it was given
    assert viewer.get(f"/?ticket={ticket}", token=False)[0] == 403
    assert not list(tmp_path.glob("scrim-view-*"))
    assert viewer.get("/")[0] == 200  # the address that was printed opens further browsers


def test_a_ticket_that_nobody_used_ends_with_the_viewer(invite, tmp_path):
    viewer = invite("true %s")
    viewer.browser().close()
    assert list(tmp_path.glob("scrim-view-*/open.html"))
    viewer.close()
    assert not list(tmp_path.glob("scrim-view-*"))


def test_the_cookie_is_not_the_token(view):
    viewer = view()
    cookies = http.cookiejar.CookieJar(http.cookiejar.DefaultCookiePolicy(strict_domain=False))
    opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor(cookies))
    assert opener.open(viewer.url, timeout=PATIENCE).status == 200
    (cookie,) = cookies
    assert cookie.value != viewer.token and cookie.has_nonstandard_attr("HttpOnly")
    assert viewer.get(f"/?token={cookie.value}", token=False)[0] == 403
