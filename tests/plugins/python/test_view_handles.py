# SPDX-License-Identifier: Apache-2.0
"""Lights by their place in the picture, curves as points, and pictures that are kept of frames."""

import math
from types import SimpleNamespace

import numpy
import pytest

pytest.importorskip("tornado")
tomlkit = pytest.importorskip("tomlkit")

from conftest import SMOKE  # noqa: E402
from viewing import Viewer  # noqa: E402

import scrim  # noqa: E402
from scrim.view import _camera, _curves, _document, _handles, _lights, _playback, _session  # noqa: E402
from scrim.view._pictures import Texture  # noqa: E402


def view_of(height=None, shift=(0.0, 0.0)):
    """From (0, 0, 5) to the origin, four by three, 36 degrees across."""
    matrix = numpy.eye(4)
    matrix[2, 3] = 5
    return _handles.View(_camera.Pose(matrix, 5.0, _camera.Lens(math.radians(36), height, 4 / 3)), shift)


VIEWS = [view_of(), view_of(3.0), view_of(shift=(0.1, -0.05))]


@pytest.mark.parametrize("view", VIEWS)
def test_a_place_in_the_picture_is_a_point_and_back(view):
    for point in ([0, 0, 0], [0.4, -0.3, 1], [-1, 0.2, -2]):
        x, y, ahead = view.seen(numpy.array(point, float))
        assert ahead == pytest.approx(5 - point[2])
        assert view.point(x, y, ahead) == pytest.approx(point)


def test_a_place_in_the_picture_is_the_pixel_that_the_camera_shows():
    x, y, _ = view_of().seen(numpy.array([0.5, 0.25, 0.0]))
    half = math.tan(math.radians(18))
    assert x == pytest.approx(0.5 + 0.5 * 0.1 / half) and y == pytest.approx(0.5 - 0.5 * 0.05 / (half * 3 / 4))
    moved = view_of(shift=(0.1, 0.0)).seen(
        numpy.array([0.5, 0.25, 0.0])
    )  # the film to the right, what it shows to the left
    assert moved[0] == pytest.approx(x - 0.1)


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("direction", [[0.3, -0.5, -0.8], [0.3, -0.5, 0.8], [1, 0, 0], [0, 0, -1], [-0.2, 0.1, 0.99]])
def test_a_handle_says_where_light_comes_from_before_and_behind(view, direction):
    scene = {"light": [{"name": "key", "type": "distant", "direction": direction}]}
    (handle,) = _handles.of(scene, view)
    ((place, found),) = _handles.moved(scene, 0, view, handle["x"], handle["y"])
    assert place == ("light", 0, "direction")
    assert found == pytest.approx(numpy.array(direction) / numpy.linalg.norm(direction), abs=1e-9)


@pytest.mark.parametrize("up", [[0, 1, 0], [0, 0, 1], [1, 2, 3], [0, -1, 0]])
@pytest.mark.parametrize("elevation, rotation", [(20.0, 40.0), (60.0, -150.0), (-5.0, 100.0)])
def test_the_sun_of_a_sky_has_a_handle(elevation, rotation, up):
    sky = {"name": "sky", "type": "dome", "sky": {"sun_elevation": elevation}, "rotation": rotation, "up": up}
    scene, view = {"light": [sky]}, view_of()
    (handle,) = _handles.of(scene, view)
    assert handle["kind"] == "way"
    found = dict(_handles.moved(scene, 0, view, handle["x"], handle["y"]))
    assert found == {
        ("light", 0, "sky", "sun_elevation"): pytest.approx(elevation, abs=1e-6),
        ("light", 0, "rotation"): pytest.approx(rotation, abs=1e-6),
    }


def test_the_handle_of_a_sky_is_where_its_sun_is_seen():
    """It is the brightest pixel of a camera that looks along -z, before which the sun stands."""
    sky = {"type": "dome", "visible": True, "sky": {"sun_elevation": 8.0}, "rotation": 170.0}
    camera = {"position": [0, 0, 5], "target": [0, 0, 0], "fov": 60, "resolution": [60, 60]}
    volume = {"source": "noise", "parameters": {"resolution": 16}, "density": {"scale": 0}}
    scene = {"scene_version": 2, "camera": camera, "light": [sky], "volume": [volume]}
    seen = scrim.loads(scene).render().image[..., 0]
    row, column = numpy.unravel_index(numpy.argmax(seen), seen.shape)
    travel, half = numpy.array(_handles._from_sun(sky)), math.tan(math.radians(30))
    assert travel[2] > 0
    assert (column + 0.5) / 30 - 1 == pytest.approx(-travel[0] / travel[2] / half, abs=0.06)
    assert 1 - (row + 0.5) / 30 == pytest.approx(-travel[1] / travel[2] / half, abs=0.06)


def test_a_light_with_a_place_moves_beside_the_picture():
    scene = {"light": [{"name": "lamp", "type": "point", "position": [0.5, 0.5, 2.0]}]}
    view = view_of()
    ((place, found),) = _handles.moved(scene, 0, view, 0.5, 0.5)
    assert place == ("light", 0, "position") and found == pytest.approx([0, 0, 2])
    scene["light"][0]["position"] = [0, 0, 9]
    assert _handles.of(scene, view) == []  # behind the eye


def test_lights_that_the_scene_animates_or_aims_otherwise_have_no_handle():
    lights = [
        {"type": "distant", "direction": {"keys": [[1, [0, 0, -1]]]}},
        {"type": "spot", "orbit": {"radius": 2}, "position": [0, 0, 1]},
        {"type": "dome"},
    ]
    assert not any(_handles.has_handle(light) for light in lights)


def ball(view, radius=0.9, size=(192, 256)):
    """The depth of a ball around the origin."""
    depth = numpy.zeros(size, numpy.float32)
    for row, column in numpy.ndindex(size):
        way = view.point((column + 0.5) / size[1], (row + 0.5) / size[0], 1.0) - view.pose.eye
        a, b, c = way @ way, way @ view.pose.eye, view.pose.eye @ view.pose.eye - radius**2
        if b * b > a * c:
            depth[row, column] = (-b - math.sqrt(b * b - a * c)) / a
    return depth


def test_a_highlight_on_a_ball_is_lit_along_its_normal_or_reflected():
    view = view_of()
    depth = ball(view)
    scene = {"light": [{"type": "distant", "direction": [1, 0, 0]}], "volume": [{"medium": {}}]}
    x, y = 0.42, 0.62
    column, row = int(x * 256), int(y * 192)
    point = view.point(x, y, float(depth[row, column]))
    normal = point / numpy.linalg.norm(point)
    ((_, found),) = _handles.highlit(scene, 0, view, depth, x, y)
    assert -numpy.array(found) @ normal > math.cos(math.radians(3))
    scene["volume"] = [{"classified": {}}]
    ((_, found),) = _handles.highlit(scene, 0, view, depth, x, y)
    eye = (view.pose.eye - point) / numpy.linalg.norm(view.pose.eye - point)
    half = eye - numpy.array(found)
    assert half @ normal / numpy.linalg.norm(half) > math.cos(math.radians(3))
    scene["light"] = [{"type": "spot", "position": [3, 0, 0], "target": [0, 0, 0]}]
    (_, place), (_, target) = _handles.highlit(scene, 0, view, depth, x, y)
    assert target == pytest.approx(point, abs=0.02)
    assert numpy.linalg.norm(numpy.array(place) - point) == pytest.approx(numpy.linalg.norm(point - (3, 0, 0)))
    assert _handles.highlit(scene, 0, view, depth, 0.01, 0.01) is None


# ---- curves


CURVES = """\
[[volume]]
density = { scale = 2.0, ramp = [[0, 0], [0.5, 1]] }   # thin

[[volume]]
[volume.classified]
transfer = [
    { value = 10, extinction = 0 },   # air
    { value = 20, extinction = 3, color = [1, 0.5, 0.25] },
]
"""


def test_curves_are_points_and_points_are_curves():
    data = tomlkit.parse(CURVES).unwrap()
    ramp, transfer = data["volume"][0]["density"]["ramp"], data["volume"][1]["classified"]["transfer"]
    assert _curves.points("ramp", ramp) == [[0, 0, None], [0.5, 1, None]]
    assert _curves.points("colours", [[0, [0, 0, 0]], [1, [1, 0.5, 0]]]) == [
        [0, None, [0, 0, 0]],
        [1, None, [1, 0.5, 0]],
    ]
    assert _curves.points("transfer", transfer) == [[10, 0, [1, 1, 1]], [20, 3, [1, 0.5, 0.25]]]
    for kind, given in [
        ("ramp", {"keys": []}),
        ("colours", [[0, {"rgb": [1, 0, 0], "colorspace": "ACEScg"}], [1, [1, 1, 1]]]),
    ]:
        assert _curves.points(kind, given) is None
    for kind, bad in [
        ("ramp", [[0, 0, None]]),
        ("ramp", [[0, True, None], [1, 1, None]]),
        ("transfer", []),
        ("ramp", 3),
    ]:
        assert not _curves.accepts(kind, bad)


def test_a_moved_point_of_a_transfer_function_changes_its_number_alone():
    document = _document.Document(CURVES)
    place = ("volume", 1, "classified", "transfer")
    given = document.data["volume"][1]["classified"]["transfer"]
    moved = _curves.points("transfer", given)
    moved[1][1] = 4.5
    text = document.changed(_curves.changes("transfer", place, moved, given))
    assert text == CURVES.replace("extinction = 3", "extinction = 4.5")
    document.take(text)
    more = [*moved, [30, 1.0, [0.0, 0.0, 1.0]]]
    text = document.changed(
        _curves.changes("transfer", place, more, document.data["volume"][1]["classified"]["transfer"])
    )
    told = tomlkit.parse(text).unwrap()["volume"][1]["classified"]["transfer"]
    assert told[2] == {"value": 30.0, "color": [0.0, 0.0, 1.0], "extinction": 1.0} and len(told) == 3
    assert document.data_of(text)["volume"][1]["classified"]["transfer"] == told


def test_a_curve_is_added_and_removed():
    document = _document.Document(CURVES)
    place = ("volume", 0, "density", "ramp")
    text = document.changed(_curves.changes("ramp", place, [], [[0, 0], [0.5, 1]]))
    assert tomlkit.parse(text).unwrap()["volume"][0]["density"] == {"scale": 2.0}
    document.take(text)
    text = document.changed(_curves.changes("ramp", place, [[0, 0, None], [1, 2, None]], None))
    assert tomlkit.parse(text).unwrap()["volume"][0]["density"]["ramp"] == [[0.0, 0.0], [1.0, 2.0]]


# ---- frames


def test_pictures_of_frames_are_kept_up_to_a_limit():
    def picture():
        return SimpleNamespace(beauty=Texture.of(numpy.zeros((10, 10, 4), numpy.float32)), plate=None)  # 800 bytes

    cache = _playback.FrameCache(limit=2500)
    for frame in (1, 2, 3):
        cache.keep("look", frame, picture())
    assert cache.find("look", 1) and cache.size == 2400
    cache.keep("look", 4, picture())  # the second was asked for longest ago
    assert cache.frames("look") == [1, 3, 4] and cache.find("look", 2) is None and cache.size == 2400
    cache.keep("other", 1, picture())
    assert cache.find("other", 1) and cache.frames("look") == [1, 4] and cache.find("other", 4) is None


# ---- lights that come and go


@pytest.mark.parametrize("kind", _lights.KINDS)
def test_a_new_light_is_seen_in_the_picture_and_goes_without_a_trace(kind, tmp_path, python_path):
    path = tmp_path / "shot.toml"
    text = SMOKE.replace('[output]\ntype = "float"\nlayers = ["light", "depth"]\n', "[ambient]\ncolor = [0, 0, 0]\n")
    path.write_text(text)
    viewer = Viewer(path, python_path)
    browser = viewer.browser()
    try:
        before = browser.until_exact()
        browser.send(type="add", light=kind)
        after = browser.until_exact()
        assert after[..., :3].mean() > 1.1 * before[..., :3].mean()
        handles = {handle["light"]: handle for handle in browser.state["handles"]}
        if kind != "dome":  # a sky has no place
            assert all(0.05 < handles[kind][axis] < 0.95 for axis in "xy")
        browser.send(type="save")
        browser.until(lambda m: m["type"] == "state" and not m["changed"])
        saved = path.read_text()
        assert saved.startswith(text.split("[ambient]")[0]) and saved.endswith("\n[ambient]\ncolor = [0, 0, 0]\n")
        assert numpy.array_equal(scrim.open(path).render().image.astype(numpy.float16), after)
        browser.send(type="remove", light=kind)
        assert numpy.array_equal(browser.until_exact(), before)
        browser.send(type="save")
        browser.until(lambda m: m["type"] == "state" and not m["changed"])
        assert path.read_text() == text
        browser.send(type="undo")
        assert numpy.array_equal(browser.until_exact(), after)
    finally:
        browser.close()
        viewer.close()


def test_a_light_that_goes_leaves_the_names_of_the_others_and_no_link():
    links = 'lights = ["key", "light2"]\nshadows = ["light2", "key"]\n'
    linked = SMOKE.replace("density =", links + "density =", 1)
    document = _document.Document(linked.replace('name = "rim"\n', ""))
    document.take(document.changed(_lights.removed(document.data, 0)))
    assert [light["name"] for light in document.data["light"]] == ["light2"]
    assert document.data["volume"][0]["lights"] == document.data["volume"][0]["shadows"] == ["light2"]
    assert list(scrim.loads(document.text).resolved()["lights"]) == ["light2"]
    # A second new light of a kind has another name, and none is known before the first.
    pose = _session.Viewpoint(_session.Places(None, None))
    pose.read(document.data, scrim.loads(document.text).resolved())
    names = []
    for _ in range(3):
        made = _lights.added(document.data, "point", pose.pose, {})
        names.append(made["name"])
        document.take(document.changed([(("light", len(document.data["light"])), made)]))
    assert names == ["point", "point2", "point3"]
    with pytest.raises(scrim.UsageError, match="a light 'laser'; expected distant, point, sphere, rectangle, dome"):
        _lights.added(document.data, "laser", pose.pose, {})
