# SPDX-License-Identifier: Apache-2.0
"""Expressions in OpenVDB AX and shading in the viewer: how they are written into the scene, where their mistakes are
shown, and that the picture is that of the scene with them."""

import shlex
import subprocess

import numpy
import pytest

pytest.importorskip("tornado")
pytest.importorskip("tomlkit")

import tomlkit  # noqa: E402
from conftest import PROGRAM  # noqa: E402
from viewing import Viewer  # noqa: E402

import scrim  # noqa: E402
from scrim.view import _code, _controls, _document  # noqa: E402

CODE = """\
[camera]
position = [0, 0, 5]
target = [0, 0, 0]
fov = 36
resolution = [64, 48]

[[volume]]
name = "ball"
source = "primitives"
density = { scale = 20 }
# What it does
ax = '''
float n = $gain;   // brightness
f@density *= n;
'''   # and no more
[volume.parameters]
shapes = "sphere radius=1"   # the ball
resolution = 24
gain = 1   # of it all

[[light]]
name = "key"
type = "distant"
direction = [0, 0, -1]
intensity = 3
"""


def edited(text, code, volume=0):
    """The scene's text after `code` was applied."""
    document = _document.Document(text)
    return document.changed(_code.changes(document.data["volume"][volume], ("volume", volume), code))


def test_an_expression_keeps_its_quotes_and_all_comments():
    text = edited(CODE, "f@density *= 0.5 * $gain;\n")
    assert text == CODE.replace("float n = $gain;   // brightness\nf@density *= n;\n", "f@density *= 0.5 * $gain;\n")
    basic = CODE.replace("'''", '"""')
    text = edited(basic, 'f@density *= $gain; // "a\\b" """c\n')
    assert 'ax = """\n' in text and "# and no more" in text
    assert tomlkit.parse(text)["volume"][0]["ax"] == 'f@density *= $gain; // "a\\b" """c\n'
    quoted = edited(CODE, "f@density *= $gain; // '''\nf@density = 1;")
    assert tomlkit.parse(quoted)["volume"][0]["ax"] == "f@density *= $gain; // '''\nf@density = 1;\n"
    assert "\nax = 'f@density" not in edited(CODE, "") and "ax" not in tomlkit.parse(edited(CODE, " \n"))["volume"][0]


def test_new_variables_bring_parameters_and_those_that_go_take_theirs():
    new = tomlkit.parse(edited(CODE, "f@density *= $loud + v$wind + vec3f$drift + $time + $frame;")).unwrap()
    assert new["volume"][0]["parameters"] == {
        "shapes": "sphere radius=1", "resolution": 24, "loud": 1.0, "wind": [0.0, 0.0, 0.0], "drift": [0.0, 0.0, 0.0],
    }  # fmt: skip
    plain = '[[volume]]\nfile = "a.vdb"\n'
    grown = edited(plain, "f@density *= $gain;\n")
    assert tomlkit.parse(grown)["volume"][0]["parameters"] == {"gain": 1.0}
    assert edited(grown, "") == plain
    scrim.loads(edited(CODE, "f@density *= $loud;"))


def test_a_parameter_that_is_used_is_a_slider_and_a_sources_own_is_none():
    groups = {group.title: group for group in _controls.groups_of(tomlkit.parse(CODE).unwrap(), numpy.eye(3)[1])}
    code, gain = groups["ball: code"].controls
    assert (code.kind, code.value) == ("code", "float n = $gain;   // brightness\nf@density *= n;\n")
    assert (gain.id, gain.value, gain.least, gain.most) == ("volume.ball.parameters.gain", 1, 0, 1)
    assert [_code.range_of(v) for v in (0.0, 0.35, 3.0, -20.0)] == [(0, 1), (0, 1), (0, 10), (-100, 100)]
    assert code.accepts("f@a = 1;") and not code.accepts(3) and not code.accepts("x" * 60_000)


@pytest.mark.parametrize("quote", ["'''", '"""'])
def test_a_mistake_is_at_its_line_and_column_of_the_expression(quote, tmp_path):
    two = CODE.replace("'''", quote) + '[[volume]]\nname = "second"\nsource = "primitives"\n'
    two += 'parameters = { shapes = "sphere radius=1", resolution = 8 }\n'
    two += f"ax = {quote}f@density = 1;\n  oops();{quote}\n"
    broken = two.replace("f@density *= n;", "f@density *= m;")
    for text, volume, line, column in ((broken, "ball", 2, 14), (two, "second", 2, 3)):
        (tmp_path / "a.toml").write_text(text)
        with pytest.raises(scrim.InputError) as raised:
            scrim.loads(text, name="a.toml").render()
        found = _code.mistake(text, "a.toml", str(raised.value))
        assert (found["volume"], found["line"]) == (volume, line), str(raised.value)
        assert abs(found["column"] - column) <= 1, str(raised.value)  # AX says the operator's place, or the name's
    assert _code.mistake(two, "a.toml", "a.toml:2:1: camera") is None
    assert _code.mistake(two, "a.toml", "b.toml:14:1: another") is None


def test_shading_that_is_not_there_begins_at_what_changes_nothing():
    scene = tomlkit.parse(CODE).unwrap()
    (shading,) = (g for g in _controls.groups_of(scene, numpy.eye(3)[1]) if g.kind == "shading")
    assert shading.folded and shading.controls
    before = scrim.loads(CODE).render().image
    seen = set()
    for control in shading.controls:
        if not control.id.split("volume.ball.")[1].startswith(("density.edge", "density.remap")):
            document = _document.Document(CODE)
            same = scrim.loads(document.changed(control.changes(control.value))).render().image
            assert numpy.abs(same - before).max() < 1e-6, control.id
            seen.add(control.label)
    assert seen == {"resample", "displace amount", "noise amount"}


def test_ends_of_a_pair_move_each_other_and_the_scene_stays_right():
    text = CODE.replace("{ scale = 20 }", "{ scale = 20, edge = [0.1, 0.3], noise = { octaves = 3 } }")
    document = _document.Document(text)
    controls = {
        c.id.removeprefix("volume.ball.density."): c
        for g in _controls.groups_of(document.data, numpy.eye(3)[1])
        if g.kind == "shading"
        for c in g.controls
    }
    for name, value, edge in (("edge.low", 0.5, [0.5, 0.501]), ("edge.high", 0.05, [0.049, 0.05])):
        new = document.changed(controls[name].changes(value))
        assert tomlkit.parse(new)["volume"][0]["density"]["edge"] == pytest.approx(edge)
        scrim.loads(new)
    assert "octaves = 5" in document.changed(controls["noise.octaves"].changes(4.7))


@pytest.fixture
def browser(tmp_path, python_path):
    (tmp_path / "code.toml").write_text(CODE)
    viewer = Viewer(tmp_path / "code.toml", python_path)
    browser = viewer.browser()
    yield browser
    browser.close()
    viewer.close()


def code_of(state):
    return next(g for g in state["groups"] if g["kind"] == "code")["controls"][0]


def test_a_mistake_is_in_the_state_until_it_is_mended_and_the_picture_is_the_scenes(browser, tmp_path):
    browser.until_exact()
    browser.send(type="set", id="volume.ball.ax", value="f@density *= $gain;\n   f@density *= oops;\n", done=True)
    browser.until(lambda m: m["type"] == "state" and "mistake" in code_of(m))
    assert browser.errors and code_of(browser.state)["mistake"]["line"] == 2
    browser.send(type="set", id="light.key.intensity", value=2.0, done=True)  # other changes do not hide it
    browser.until(lambda m: m["type"] == "state" and "mistake" in code_of(m) and m["serial"] >= browser.serial)
    good = "f@density *= 0.25 * $gain;\n"
    browser.send(type="set", id="volume.ball.ax", value=good, done=True)
    shown = browser.until_exact()
    assert "mistake" not in code_of(browser.state)
    browser.send(type="save")
    browser.until(lambda m: m["type"] == "state" and not m["changed"])
    saved = (tmp_path / "code.toml").read_text()
    assert saved == edited(CODE.replace("intensity = 3", "intensity = 2.0"), good)
    assert numpy.array_equal(shown, scrim.loads(saved).render().image.astype(numpy.float16))


def test_the_command_says_the_expression(browser, tmp_path):
    browser.until_exact()
    browser.send(type="set", id="volume.ball.ax", value="f@density *= $gain;\n// it's \"mine\"\n", done=True)
    shown = browser.until_exact()
    assert "--set" in browser.state["command"]
    words = shlex.split(browser.state["command"])[1:-1]
    subprocess.run([PROGRAM, *words, tmp_path / "p.exr", "-q"], check=True, cwd=tmp_path)
    text = edited(CODE, "f@density *= $gain;\n// it's \"mine\"\n")
    assert numpy.array_equal(shown, scrim.loads(text).render().image.astype(numpy.float16))
