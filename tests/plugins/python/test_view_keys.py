# SPDX-License-Identifier: Apache-2.0
"""Controls of values that a scene animates, of phase functions, and of the lens."""

import numpy
import pytest

pytest.importorskip("tornado")
tomlkit = pytest.importorskip("tomlkit")

from conftest import SMOKE  # noqa: E402
from viewing import Viewer  # noqa: E402

import scrim  # noqa: E402
from scrim.view import _controls, _document, _keys, _lens, _phases  # noqa: E402

UP = numpy.array([0.0, 1.0, 0.0])
KEYS = "intensity = { keys = [[1, 2.0], [5, 8.0], [9, 3.0]] }   # beats"
KEYED = SMOKE.replace("intensity = 4.5", KEYS)


def control(text, name, frame=1):
    groups = _controls.groups_of(tomlkit.parse(text).unwrap(), UP, frame, 5.0)
    return next(one for group in groups for one in group.controls if one.id == name)


# ---- values that have keys


@pytest.mark.parametrize("interpolation", ["linear", "smooth"])
@pytest.mark.parametrize("frame", [0, 1, 3, 5, 6, 12])
def test_a_keyed_value_is_the_one_that_is_rendered(interpolation, frame):
    text = KEYED.replace("[9, 3.0]] }", f'[9, 3.0]], interpolation = "{interpolation}" }}')
    wanted = scrim.loads(text).resolved(frame)["lights"]["key"][0]
    shown = control(text, "light.key.intensity", frame)
    assert shown.value == pytest.approx(wanted, rel=1e-6)
    assert shown.key == ("here" if frame in (1, 5, 9) else "between")
    assert control(text, "light.rim.intensity", frame).key == ""


def test_a_keyed_direction_has_angles_and_a_handle_and_a_change_makes_a_key():
    text = SMOKE.replace("direction = [0.6, -0.5, -0.6]", "direction = { keys = [[1, [0, 0, -1]], [3, [-1, 0, 0]]] }")
    assert control(text, "light.key.azimuth", 1).value == pytest.approx(0)
    azimuth = control(text, "light.key.azimuth", 2)
    assert azimuth.value == pytest.approx(45) and azimuth.key == "between"
    scene = tomlkit.parse(text).unwrap()
    ((place, keys),) = _keys.kept(scene, azimuth.changes(60.0), 2)
    assert place == ("light", 0, "direction", "keys") and [key[0] for key in keys] == [1, 2, 3]
    assert keys[1][1] == pytest.approx([-numpy.sin(numpy.pi / 3), 0, -0.5])


def test_a_change_of_a_keyed_value_touches_its_key_alone():
    document = _document.Document(KEYED)
    for frame, keys in [(5, "[[1, 2.0], [5, 4.5], [9, 3.0]]"), (7, "[[1, 2.0], [5, 8.0], [7, 4.5], [9, 3.0]]")]:
        changes = control(KEYED, "light.key.intensity", frame).changes(4.5)
        text = document.changed(_keys.kept(document.data, changes, frame))
        assert text == KEYED.replace(KEYS, KEYS.replace("[[1, 2.0], [5, 8.0], [9, 3.0]]", keys))


def test_keys_on_lines_of_their_own_keep_their_comments():
    lines = "intensity = { keys = [\n    [1, 2],   # dark\n    [9, 3.0],   # the end\n] }"
    document = _document.Document(SMOKE.replace("intensity = 4.5", lines))
    for frame, value, wanted in [
        (9, 6.0, lines.replace("3.0", "6.0")),
        (5, 4.0, lines.replace("# dark\n", "# dark\n    [5, 4.0],\n").replace("3.0", "6.0")),
    ]:
        changes = control(document.text, "light.key.intensity", frame).changes(value)
        document.take(document.changed(_keys.kept(document.data, changes, frame)))
        assert document.text == SMOKE.replace("intensity = 4.5", wanted)
        assert document.data == tomlkit.parse(document.text).unwrap()


def test_value_at_refuses_keys_that_do_not_fit():
    with pytest.raises(scrim.UsageError, match="keys: expected as many frames as values, and one of them at least"):
        scrim._scrim.value_at([1.0, 2.0], [1.0], 1)


@pytest.fixture
def keyed(tmp_path, python_path):
    """A browser that shows KEYED, and the path of its scene."""
    path = tmp_path / "keyed.toml"
    path.write_text(KEYED)
    viewer = Viewer(path, python_path)
    browser = viewer.browser()
    try:
        yield browser, path
    finally:
        browser.close()
        viewer.close()


def test_a_key_is_set_at_the_frame_that_is_shown(keyed):
    browser, path = keyed
    browser.until_layers()
    assert browser.state["frames"] == list(range(1, 10))  # the file has no sequence, but keys
    browser.send(type="frame", number=7, done=True)
    before = browser.until_layers()
    shown = {c["id"]: c for g in browser.state["groups"] for c in g["controls"]}["light.key.intensity"]
    assert (shown["value"], shown["key"], shown["fixed"]) == (pytest.approx(5.5), "between", False)
    browser.send(type="set", id="light.key.intensity", value=11.0, done=True)
    after = browser.until_exact()
    assert after[..., :3].mean() > 1.3 * before[..., :3].mean()
    shown = {c["id"]: c for g in browser.state["groups"] for c in g["controls"]}["light.key.intensity"]
    assert (shown["value"], shown["key"]) == (11.0, "here")
    browser.send(type="save")
    browser.until(lambda m: m["type"] == "state" and not m["changed"])
    assert "[7, 11.0], [9, 3.0]] }   # beats" in path.read_text()
    assert numpy.array_equal(scrim.open(path).render(7).image.astype(numpy.float16), after)
    browser.send(type="frame", number=20, done=True)  # behind the last key
    browser.until_exact()
    assert browser.state["frames"] == list(range(1, 21))


def test_frames_between_keys_are_played(keyed):
    browser, _ = keyed
    browser.until_exact()
    browser.send(type="play", on=True)
    played = [browser.until(lambda m: m["type"] == "frame")["number"] for _ in range(10)]
    assert played[1:] == [(played[0] - 1 + step) % 9 + 1 for step in range(1, 10)]


def test_a_sun_that_sets_is_seen_at_each_frame_and_raised_by_a_slider(tmp_path, python_path):
    """The sky behind the smoke, its elevation keyed: the picture is that of `scrim render` of what is saved."""
    sky = '\n[[light]]\nname = "sky"\ntype = "dome"\nvisible = true\nsamples = 12\n'
    sky += "sky = { sun_elevation = { keys = [[1, 30], [9, -2]] } }\n"
    path = tmp_path / "shot.toml"
    path.write_text(SMOKE.replace("[output]", sky + "[output]"))
    viewer = Viewer(path, python_path)
    browser = viewer.browser()
    try:
        day = browser.until_exact()
        assert day[0, 0, 2] > 1.5 * day[0, 0, 0] and day[0, 0, 3] == 1  # blue
        browser.send(type="frame", number=9, done=True)
        dusk = browser.until_exact()
        assert dusk[0, 0, 2] < 0.05 * day[0, 0, 2]
        browser.send(type="set", id="light.sky.sky.sun_elevation", value=10.0, done=True)
        raised = browser.until_exact()
        assert raised[0, 0, 2] > 10 * dusk[0, 0, 2]
        browser.send(type="save")
        browser.until(lambda m: m["type"] == "state" and not m["changed"])
        assert "sun_elevation = { keys = [[1, 30], [9, 10.0]] }" in path.read_text()
        assert numpy.array_equal(scrim.open(path).render(9).image.astype(numpy.float16), raised)
    finally:
        browser.close()
        viewer.close()


# ---- phase functions


@pytest.mark.parametrize("kind", _phases.KINDS)
def test_each_phase_function_is_chosen_with_its_numbers_and_without_those_of_others(kind):
    document = _document.Document(SMOKE)
    for other in (*_phases.KINDS, kind):
        changes = control(document.text, "volume.smoke.medium.phase.type").changes(other)
        document.take(document.changed(changes))
        scrim.loads(document.text)  # raises where a number is missing, or belongs to another function
    phase = document.data["volume"][0]["medium"]["phase"]
    assert phase == {"type": kind, **_phases.KINDS[kind]}
    for key, value in _phases.KINDS[kind].items():
        number = control(document.text, f"volume.smoke.medium.phase.{key}")
        assert number.value == value and number.least <= value <= number.most
        for end in (number.least, number.most):
            scrim.loads(document.changed(number.changes(end)))


def test_every_phase_function_of_scenes_is_offered():
    assert set(_phases.KINDS) == set(schema_choices("phase"))
    assert set(control(SMOKE, "volume.smoke.medium.phase.type").choices) == set(_phases.KINDS)


def schema_choices(name):
    """The choices of `type` in a table of this name, anywhere in the schema of scenes."""

    def found(value, inside):
        if isinstance(value, dict):
            if inside and "enum" in value.get("properties", {}).get("type", {}):
                return value["properties"]["type"]["enum"]
            for key, one in value.items():
                if (choices := found(one, inside or key == name)) is not None:
                    return choices
        return next(filter(None, (found(one, inside) for one in value)), None) if isinstance(value, list) else None

    return found(scrim._scrim.scene_schema(), False)


# ---- the lens


def test_a_lens_comes_focused_on_the_pivot_and_goes_without_a_trace():
    document = _document.Document(SMOKE)
    document.take(document.changed(control(SMOKE, "scene.camera.lens").changes(True)))
    scrim.loads(document.text)
    assert control(document.text, "scene.camera.focus_distance").value == 5.0
    wider = control(document.text, "scene.camera.fstop").changes(0.5)
    sizes = control(document.text, "scene.camera.world_unit").changes(10.0)
    scrim.loads(document.changed([*wider, *sizes]))
    document.take(document.changed([*wider, *sizes]))
    document.take(document.changed(control(document.text, "scene.camera.lens").changes(False)))
    assert tomlkit.parse(document.text).unwrap() == tomlkit.parse(SMOKE).unwrap()
    scrim.loads(document.text)


def test_a_click_focuses_on_what_is_seen_there():
    depth = numpy.zeros((48, 64), numpy.float32)
    depth[12, 32] = 4.25
    scene = tomlkit.parse(SMOKE).unwrap()
    at = (32.5 / 64, 12.5 / 48)
    assert _lens.focused(scene, depth, *at) == [(("camera", "fstop"), 2.8), (("camera", "focus_distance"), 4.25)]
    scene["camera"] |= {"lens_radius": 0.1, "focus_distance": 5.0}
    assert _lens.focused(scene, depth, *at) == [(("camera", "focus_distance"), 4.25)]
    with pytest.raises(scrim.UsageError, match="there is nothing to focus on at this place"):
        _lens.focused(scene, depth, 0.1, 0.1)
    scene["camera"]["type"] = "orthographic"
    with pytest.raises(scrim.UsageError, match="only a perspective camera that the scene itself describes"):
        _lens.focused(scene, depth, *at)
