# SPDX-License-Identifier: Apache-2.0
"""What the viewer is made of: the edited scene, the camera under the mouse, the choice of the next render, and the
table of a view."""

import math
import threading
import time
from dataclasses import replace

import numpy
import OpenImageIO
import pytest

pytest.importorskip("tornado")
tomlkit = pytest.importorskip("tomlkit")

from conftest import SMOKE  # noqa: E402
from viewing import Viewer  # noqa: E402

import scrim  # noqa: E402
from scrim.view import _camera, _controls, _document, _luts, _opened, _pictures, _renderer, _session  # noqa: E402

TEXT = """\
# A shot
[camera]   # looks down
position = [0, 0, 5]
target = [0, 0, 0] # the middle
matrix_free = 1

[[volume]]
name = "smoke"
medium = { albedo = [0.9, 0.9, 0.9], phase = { type = "hg", g = 0.3 } }  # thin

[[light]]   # without a name
type = "distant"
intensity = 4   # bright
"""


# ---- the edited scene


def test_a_change_touches_its_value_alone():
    document = _document.Document(TEXT)
    changes = [
        (("light", 0, "intensity"), 2.123456789),
        (("volume", 0, "medium", "phase", "g"), 0.5),
        (("camera", "target"), [1.0, 0.0, 0.25]),
    ]
    document.take(document.changed(changes))
    wanted = TEXT.replace("intensity = 4 ", "intensity = 2.12346 ").replace("g = 0.3", "g = 0.5")
    assert document.text == wanted.replace("target = [0, 0, 0]", "target = [1.0, 0.0, 0.25]")


def test_new_keys_and_sections_are_added_and_keys_are_removed():
    document = _document.Document(TEXT)
    changes = [
        (("ambient", "color"), [0.1, 0.1, 0.1]),
        (("volume", 0, "density", "scale"), 3.0),
        (("camera", "matrix_free"), None),
        (("camera", "absent"), None),
    ]
    document.take(document.changed(changes))
    data = tomlkit.parse(document.text).unwrap()
    assert data["ambient"] == {"color": [0.1, 0.1, 0.1]} and data["volume"][0]["density"] == {"scale": 3.0}
    assert "matrix_free" not in data["camera"] and data["camera"]["position"] == [0, 0, 5]
    assert all(f"# {comment}" in document.text for comment in ("A shot", "looks down", "the middle", "thin", "bright"))


def test_assignments_lead_from_the_opened_scene_to_this_one():
    document = _document.Document(SMOKE)
    text = document.changed([(("light", 1, "intensity"), 2.5), (("camera", "fov"), 20.0)])
    document.take(text)
    assert sorted(document.assignments()) == ["camera.fov=20.0", "light.rim.intensity=2.5"]
    assert scrim.loads(SMOKE, document.assignments()).resolved() == scrim.loads(text).resolved()
    document.take(document.changed([(("light", 0, "intensity"), None)]))
    with pytest.raises(scrim.UsageError, match="cannot remove 'light.key.intensity'; save the scene instead"):
        document.assignments()
    document = _document.Document(SMOKE)
    document.take(document.changed([(("light", 2), {"name": "third", "type": "dome"})]))
    with pytest.raises(scrim.UsageError, match="^the command line cannot add 'light.third'; save the scene instead$"):
        document.assignments()


# ---- the camera


def looking():
    matrix = numpy.eye(4)
    matrix[:3, 3] = [0, 0, 10]
    return _camera.Pose(matrix, 10.0, _camera.Lens(math.radians(40), None, 1.5))


UP = numpy.array([0.0, 1.0, 0.0])


def test_an_orbit_keeps_the_pivot_the_distance_and_the_horizon():
    pose = looking()
    for dx, dy in [(0.3, 0.1), (-0.7, 0.2), (0.05, -0.4), (0.0, 3.0), (1.0, -5.0)]:
        pose = pose.orbited(UP, dx, dy)
        assert pose.pivot == pytest.approx([0, 0, 0], abs=1e-9)
        assert numpy.linalg.norm(pose.eye) == pytest.approx(10)
        rotation = pose.matrix[:3, :3]
        assert rotation.T @ rotation == pytest.approx(numpy.eye(3), abs=1e-9)
        assert numpy.linalg.det(rotation) == pytest.approx(1)
        assert rotation[1, 0] == pytest.approx(0, abs=1e-9) and rotation[1, 1] > 0


def test_a_drag_to_the_right_turns_the_front_to_the_right_and_a_drag_down_shows_the_top():
    front = numpy.array([0, 0, 1, 1.0])  # a point before the pivot
    right = (numpy.linalg.inv(looking().orbited(UP, 0.1, 0).matrix) @ front)[0]
    assert right == pytest.approx(math.sin(0.1 * math.pi))
    assert looking().orbited(UP, 0, 0.1).eye[1] == pytest.approx(10 * math.sin(0.1 * math.pi))


def test_a_pan_moves_the_pivot_with_the_pointer():
    pose = looking().panned(0.25, 0.1)
    old = numpy.linalg.inv(pose.matrix) @ [0, 0, 0, 1]
    high = 2 * 10 * math.tan(math.radians(20)) / 1.5
    assert old[:2] == pytest.approx([0.25 * high, -0.1 * high])


def test_framing_fits_a_box_and_no_more():
    for aspect in (0.5, 1.5):
        lens = _camera.Lens(math.radians(40), None, aspect)
        pose = _camera.Pose(looking().matrix, 10.0, lens).framed([3, -1, 2], [5, 3, 4])
        center = numpy.linalg.inv(pose.matrix) @ [4, 1, 3, 1]
        assert center[:2] == pytest.approx([0, 0], abs=1e-9)
        radius = 0.5 * math.sqrt(4 + 16 + 4)
        half = math.atan(math.tan(math.radians(20)) * min(1, 1 / aspect))  # of the shorter side
        assert math.asin(radius / -center[2]) == pytest.approx(half)


@pytest.mark.parametrize("up", [[0, 1, 0], [0, 0, 1], [1, 0, 0], [0, 0, -1]])
def test_angles_of_a_light_are_a_direction_and_back(up):
    up = numpy.array(up, float)
    for azimuth, elevation in [(0, 0), (30, 20), (-120, -45), (170, 80)]:
        direction = _camera.direction_of(azimuth, elevation, up)
        assert _camera.angles_of(direction, up) == pytest.approx((azimuth, elevation))
        assert -numpy.dot(direction, up) == pytest.approx(math.sin(math.radians(elevation)))


# ---- the next render


def wanted(text=SMOKE, moves=False, since=0.0, muted=frozenset(), verify=False, region=None, plays=False, **view):
    shot = scrim.loads(text)
    data, resolved = tomlkit.parse(text).unwrap(), shot.resolved()
    return _renderer.Wanted(
        text, _pictures.shape_of(data, view, 1), _pictures.strengths_of(data, resolved), view, 1, (64, 48), False,
        moves=moves, since=since, muted=muted, verify=verify, region=region, plays=plays,
    )  # fmt: skip


@pytest.fixture(scope="module")
def pictures():
    """By what was rendered: coarse, a draft, the file's picture, layers, or the last two."""
    it = wanted()
    own = _pictures.own_layers(it.shape.lights)
    frame = scrim.loads(SMOKE, {"output.layers": _pictures.LAYERS, **own}).render()

    def of(stage, has_layers=False, **more):
        return replace(_pictures.pictures_of(frame, it.shape, it.strengths, stage, 0.1, has_layers), **more)

    out = {stage: of(stage) for stage in ("motion", "draft")}
    out |= {"exact": of("final", frame=frame), "layers": of("final", True), "all": of("final", True, frame=frame)}
    return {None: None, **out, "moved light": coarse_light(out["all"])}


def coarse_light(pictures):
    layers = {**pictures.layers, "light.key": replace(pictures.layers["light.key"], stage="motion")}
    return replace(pictures, layers=layers, frame=None, is_whole=False)


MOVED, BRIGHTER = SMOKE.replace("0.6, -0.5", "0.1, -0.5"), SMOKE.replace("4.5", "9")
FINER = SMOKE + '\n[render]\nquality = "high"\n'
MUTED = frozenset(["light.key"])
EXACT, COARSE, LAYERS = ("exact", "final", ""), ("whole", "motion", ""), ("layers", "final", "")


@pytest.mark.parametrize(
    ("there", "wish", "expected"),
    [
        (None, {}, COARSE),
        ("all", {"moves": True, "position": 1}, COARSE),
        ("motion", {}, EXACT),
        ("motion", {"moves": True}, None),
        ("draft", {}, EXACT),
        ("exact", {}, LAYERS),
        ("exact", {"moves": True}, None),
        ("all", {}, None),
        ("exact", {"text": BRIGHTER, "moves": True}, COARSE),  # its layers are not there yet
        ("all", {"text": BRIGHTER, "moves": True}, None),
        ("all", {"text": BRIGHTER, "since": 0.9}, None),  # the sum shows it; who knows whether more follows
        ("all", {"text": BRIGHTER}, EXACT),
        ("all", {"text": MOVED, "moves": True}, ("light", "motion", "key")),
        ("moved light", {}, ("light", "final", "key")),
        ("layers", {}, EXACT),
        ("all", {"text": FINER, "since": 0.9}, EXACT),
        ("all", {"text": SMOKE.replace("25", "30")}, COARSE),
        ("exact", {"muted": MUTED}, COARSE),
        ("layers", {"muted": MUTED}, EXACT),
        ("all", {"muted": MUTED}, None),
        ("exact", {"verify": True}, ("verify", "final", "")),
        ("all", {"region": (0, 0, 8, 8)}, ("region", "region", "")),
        ("all", {"region": (0, 0, 8, 8), "text": BRIGHTER}, COARSE),
        ("motion", {"plays": True}, ("whole", "draft", "")),
        ("draft", {"plays": True}, None),
    ],
)
def test_the_next_render_is_the_one_that_helps_most(pictures, there, wish, expected):
    task = _renderer.next_task(wanted(**wish), pictures[there], 1.0)
    assert (task and (task.kind, task.stage, task.light)) == expected


def test_a_draft_goes_before_a_picture_that_takes_long(pictures):
    for there, expected in [("motion", "whole draft"), ("draft", "exact final"), ("all", None)]:
        task = _renderer.next_task(wanted(), pictures[there], 1.0, is_slow=True)
        assert (task and f"{task.kind} {task.stage}") == expected


def test_a_picture_that_comes_late_is_that_of_the_last_event():
    calls, shown = [], threading.Event()
    opened = _opened.Opened(SMOKE, "", ".", "smoke", [1])
    session = _session.Session(opened, lambda message: None, shown.set, lambda seconds, call: calls.append(call))
    for _ in range(3000):
        while calls:
            calls.pop(0)()
        if session.pictures is not None and session.pictures.layers is not None and session.exact_frame() is not None:
            break
        time.sleep(0.01)
    late, wanted_then = session.pictures, session._wanted
    session.handle({"type": "rest", "serial": 5})  # changes nothing, while layers of before are under way
    assert session.serial_shown == 5
    calls.clear()
    session._took(late, wanted_then, None)
    calls.pop()()
    assert session.serial_shown == 5
    session.close()


def test_layers_with_weights_are_the_picture_of_other_strengths():
    dials = {"render.texel": 1.0, "render.sheet_thickness": 1.0, "output.layers": _pictures.LAYERS}
    change = {"light.key.intensity": 1.5, "light.key.exposure": 1.0, "light.rim.temperature": 3200.0}
    first, second = scrim.loads(SMOKE, dials), scrim.loads(SMOKE, {**dials, **change})
    data = tomlkit.parse(SMOKE).unwrap()
    frame, then, now = first.render(), *(_pictures.strengths_of(data, s.resolved()) for s in (first, second))
    mixed = sum(
        frame[name] * _pictures.weight(now.of[name], then.of[name]).astype(numpy.float32)
        for name in frame.layers
        if name in now.of and frame[name].any()
    )
    rendered = second.render().image[..., :3]
    # Single precision, and as many terms as there are sheets in front of a pixel.
    assert numpy.abs(mixed - rendered).max() <= 1e-4 * rendered.max()


def test_controls_accept_what_their_keys_hold():
    groups = _controls.groups_of(tomlkit.parse(SMOKE).unwrap(), UP)
    controls = {control.id: control for group in groups for control in group.controls}
    assert controls["light.key.intensity"].value == 4.5 and controls["scene.render.quality"].value == "standard"
    for name, good, bad in [
        ("light.key.intensity", 3.0, True),
        ("light.key.intensity", 3, float("nan")),
        ("light.rim.color", [1.0, 0.5, 0], [1.0, 0.5]),
        ("scene.render.quality", "high", "best"),
        ("light.key.shadows", False, 0),
    ]:
        assert controls[name].accepts(good) and not controls[name].accepts(bad), name
    keyed = SMOKE.replace("intensity = 4.5", "intensity = { keys = [[1, 2.0], [5, 3.0]] }")
    control = _controls.groups_of(tomlkit.parse(keyed).unwrap(), UP)[0].controls[0]
    assert (control.value, control.key) == (2.0, "here") and control.accepts(2.0)
    strange = SMOKE.replace("intensity = 4.5", 'intensity = 1\ncolor = { keys = [[1, { temperature = 3000 }]] }')
    control = _controls.groups_of(tomlkit.parse(strange).unwrap(), UP)[0].controls[2]
    assert control.is_fixed and not control.accepts([1.0, 1.0, 1.0])


def test_a_clear_sky_has_controls_of_its_sun_and_air():
    sky = SMOKE + '\n[[light]]\nname = "sky"\ntype = "dome"\nsky = { sun_elevation = { keys = [[1, 9], [3, 5]] } }\n'
    groups = _controls.groups_of(tomlkit.parse(sky).unwrap(), UP, 2)
    controls = {control.id: control for group in groups for control in group.controls}
    assert controls["light.sky.sky.sun_elevation"].value == 7 and controls["light.sky.sky.dust_density"].value == 1
    assert controls["light.sky.sky.sun_disc"].accepts(False)
    assert not any(name.startswith("light.key.sky") for name in controls)


# ---- what the engine tells


def test_a_shot_tells_its_scene_in_plain_numbers():
    told = scrim.loads(SMOKE, {"light.key.exposure": 1, "camera.orbit.radius": 5}).resolved()
    assert told["lights"] == {"key": [9, 9, 9], "rim": pytest.approx([0.5, 0.7, 1])}
    assert told["camera"]["fov"] == 36 and told["camera"]["resolution"] == (64, 48)
    matrix = numpy.array(scrim.loads(SMOKE).resolved()["camera"]["matrix"])
    assert matrix[:3, 3] == pytest.approx([0, 0.3, 5]) and matrix[3] == pytest.approx([0, 0, 0, 1])
    assert -matrix[:3, 2] == pytest.approx(numpy.array([0, -0.3, -5]) / math.hypot(0.3, 5))
    assert told["ambient"] == [0, 0, 0] and told["volumes"]["smoke"]["file"] == ""


def test_a_view_is_what_previews_show(tmp_path):
    shot = scrim.loads(SMOKE)
    frame = shot.render()
    frame.preview(tmp_path / "p.png")
    display = next(iter(shot.displays))
    shown = shot.displayed(frame.image, display, shot.displays[display][0])
    png = OpenImageIO.ImageBuf(str(tmp_path / "p.png")).get_pixels(OpenImageIO.UINT8)[..., :3]
    assert numpy.abs(numpy.clip(shown[..., :3], 0, 1) * 255 - png).max() <= 1.01  # previews are dithered
    with pytest.raises(scrim.InputError, match="unknown view 'none'"):
        shot.displayed(frame.image, "sRGB", "none")
    with pytest.raises(scrim.UsageError, match="expected an array"):
        shot.displayed(frame.image[..., :3].copy(), "sRGB")


def test_the_table_of_a_view_is_the_view_to_a_step_of_eight_bits():
    shot = scrim.loads(SMOKE)
    display = next(iter(shot.displays))
    view = shot.displays[display][0]
    size = _luts.SIZE
    words = numpy.frombuffer(_luts.table(shot, display, view), numpy.uint32).reshape(size, size, size)
    table = numpy.stack([words >> 10 * part & 1023 for part in range(3)], axis=-1) / 1023
    # Greys and hues between the entries, each brightness between black and the brightest that a display tells apart.
    tint = numpy.array([[1, 1, 1], [1, 0.9, 0.8], [0.7, 0.9, 1], [1, 0.5, 0.3]])
    colours = (numpy.geomspace(1e-3, 20, 200)[:, None, None] * tint).reshape(-1, 3)
    place = numpy.log2(1 + _luts.KNEE * colours) / numpy.log2(1 + _luts.KNEE * _luts.MOST) * (size - 1)
    low = numpy.minimum(place.astype(int), size - 2)
    part, found = place - low, 0
    for corner in numpy.ndindex(2, 2, 2):
        at = low + corner
        share = numpy.prod(numpy.where(corner, part, 1 - part), axis=1)
        found = found + share[:, None] * table[at[:, 2], at[:, 1], at[:, 0]]
    pixels = numpy.ones((1, len(colours), 4), numpy.float32)
    pixels[0, :, :3] = colours
    wanted = numpy.clip(shot.displayed(pixels, display, view)[0, :, :3], 0, 1)
    assert numpy.abs(found - wanted).max() * 255 <= 1.0, numpy.abs(found - wanted).max() * 255


def test_a_surface_that_is_seen_follows_a_light_while_its_slider_moves(tmp_path, python_path):
    (tmp_path / "floor.obj").write_text("v -9 -1 -9\nv 9 -1 -9\nv 9 -1 9\nv -9 -1 9\nf 4 3 2 1\n")
    path = tmp_path / "seen.toml"
    path.write_text(SMOKE + '\n[[mesh]]\nfile = "floor.obj"\ncolor = [0.5, 0.5, 0.5]\n')
    viewer = Viewer(path, python_path)
    browser = viewer.browser()
    try:
        before = browser.until_layers()[-6:, :, :3].mean()  # the floor
        browser.send(type="set", id="light.key.intensity", value=45.0, done=False)
        serial = browser.serial
        browser.until(lambda m: m["type"] == "pictures" and m["serial"] >= serial)
        assert browser.head["stage"] == "motion" and browser.head["weights"] is None
        assert browser.pictures["beauty"][-2:, :, :3].mean() > 3 * before
        browser.send(type="rest")
        assert browser.until_exact()[-6:, :, :3].mean() > 3 * before
    finally:
        browser.close()
        viewer.close()
