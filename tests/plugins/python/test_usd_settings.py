# SPDX-License-Identifier: Apache-2.0
"""UsdRender, and the program `scrim` on stages."""

import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import time

import numpy
import OpenEXR
import pytest
from conftest import PROGRAM, ROOT

pytest.importorskip("pxr", reason="usd-core is not installed")

from pxr import Gf, Sdf, UsdGeom, UsdRender  # noqa: E402
from usd_stages import front, lit_fog_stage  # noqa: E402

import scrim  # noqa: E402


@pytest.fixture
def foggy(tmp_path):
    return lit_fog_stage(tmp_path)


def settings(stage, path="/Render/rs", **values):
    made = UsdRender.Settings.Define(stage.stage, path)
    for name, value in values.items():
        made.GetPrim().GetAttribute(name).Set(value)
    return made


def product(stage, of, path, **values):
    made = UsdRender.Product.Define(stage.stage, path)
    for name, value in values.items():
        made.GetPrim().GetAttribute(name).Set(value)
    of.GetProductsRel().AddTarget(path)
    return made


def channels(path):
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return dict(file.header()), {name: c.pixels for name, c in file.channels().items()}


# A film of 240 x 120 tenths of a unit in pictures of other shapes: the width and height that they show, in units.
@pytest.mark.parametrize(
    "policy, resolution, shown",
    [
        ("expandAperture", (32, 32), (24, 24)),
        ("expandAperture", (64, 16), (48, 12)),
        ("cropAperture", (32, 32), (12, 12)),
        ("cropAperture", (64, 16), (24, 6)),
        ("adjustApertureWidth", (32, 32), (12, 12)),
        ("adjustApertureWidth", (64, 16), (48, 12)),
        ("adjustApertureHeight", (32, 32), (24, 24)),
        ("adjustApertureHeight", (64, 16), (24, 6)),
        ("adjustPixelAspectRatio", (32, 32), (24, 12)),
        ("adjustPixelAspectRatio", (64, 16), (24, 12)),
    ],
)
@pytest.mark.parametrize("perspective", [False, True])
def test_the_film_fits_as_the_policy_says(foggy, policy, resolution, shown, perspective):
    camera = UsdGeom.Camera.Get(foggy.stage, "/cam")
    camera.GetVerticalApertureAttr().Set(120.0)
    if perspective:  # so far away that the film at the fog is as large, and the offset is twice as large in units
        camera.GetProjectionAttr().Set("perspective")
        camera.GetFocalLengthAttr().Set(10 * 5000.0)
        camera.GetPrim().GetAttribute("xformOp:translate").Set(Gf.Vec3d(0, 0, 5000))
        camera.GetClippingRangeAttr().Set(Gf.Vec2f(1, 1e6))
    camera.GetHorizontalApertureOffsetAttr().Set(5.0)
    UsdGeom.Xformable.Get(foggy.stage, "/fog").AddScaleOp().Set(Gf.Vec3f(0.125))  # two units wide
    foggy.stage.GetPrimAtPath("/fog").GetAttribute("scrim:density:scale").Set(0.005)
    made = settings(foggy, aspectRatioConformPolicy=policy)
    foggy.say(made, "render:antialias", Sdf.ValueTypeNames.Int, 8)
    shot = foggy.open(settings="/Render/rs", resolution=resolution)
    seen = -numpy.log1p(-shot.render().image[:, :, 3].astype(float))
    covered = seen.sum() / (2 * 0.005)
    expected = 2 * resolution[0] / shown[0] * 2 * resolution[1] / shown[1]
    assert covered == pytest.approx(expected, rel=0.005)
    columns = (seen.sum(axis=0) * (numpy.arange(resolution[0]) + 0.5)).sum() / seen.sum()
    # The film moved right by half a unit, and the fog with it to the left.
    assert columns == pytest.approx(resolution[0] * (0.5 - 0.5 / shown[0]), abs=0.05)


def test_the_data_window_is_the_crop(foggy):
    settings(foggy, dataWindowNDC=Gf.Vec4f(0.25, 0.5, 0.75, 1.0), resolution=Gf.Vec2i(32, 32))
    shot = foggy.open(settings="/Render/rs", resolution=None)
    assert shot.crop(1) == (8, 0, 24, 16)
    image = shot.render().image
    assert image.shape == (16, 16, 4)
    assert image[:5, :, 3].max() == 0 and image[7:, :, 3].min() > 0.5  # the fog covers rows 5 to 26
    wide = settings(foggy, dataWindowNDC=Gf.Vec4f(-0.25, 0.0, 1.0, 1.125))
    shot = foggy.open(settings="/Render/rs", resolution=None)
    assert shot.crop(1) == (-8, -4, 32, 32) and shot.scene(1)["camera"]["overscan"] == 8
    wide.GetDataWindowNDCAttr().Set(Gf.Vec4f(0.5, 0.5, 0.5, 0.5))
    with pytest.raises(scrim.InputError, match="contains no pixel of 32 x 32$"):
        foggy.open(settings="/Render/rs", resolution=None).render()


def test_products_name_pictures(foggy):
    rs = settings(foggy, resolution=Gf.Vec2i(24, 12), renderingColorSpace="lin_rec709_scene")
    rs.GetCameraRel().SetTargets(["/cam"])
    foggy.camera("/second", ortho=12.0)
    raster = product(foggy, rs, "/Render/main", productName="main.exr", resolution=Gf.Vec2i(16, 16))
    raster.GetCameraRel().SetTargets(["/second"])
    for name, source in (("ci", "Ci"), ("z", "z"), ("normals", "N")):
        var = UsdRender.Var.Define(foggy.stage, f"/Render/{name}")
        var.GetSourceNameAttr().Set(source)
        raster.GetOrderedVarsRel().AddTarget(var.GetPath())
        if source == "Ci":
            var.GetDataTypeAttr().Set("color3f")
    product(foggy, rs, "/Render/deep", productName="deep.exr", productType="deepRaster")
    product(foggy, rs, "/Render/more", productName="more.exr")
    product(foggy, rs, "/Render/odd", productName="odd.exr", productType="cryptomatte")
    foggy.stage.SetMetadata("renderSettingsPrimPath", "/Render/rs")
    shot = foggy.open(resolution=None)
    scene = shot.scene(1)
    assert scene["camera"]["resolution"] == [16, 16] and scene["camera"]["height"] == 12.0
    assert scene["output"] == {
        "file": "main.exr", "deep": "deep.exr", "type": "float", "layers": ["depth"], "colorspace": "lin_rec709_scene",
        "fps": 24.0,
    }  # fmt: skip
    for text in (
        "/Render/more: a second product of type 'raster' is not written; render it by settings of its own",
        "/Render/odd: products of type 'cryptomatte' are not written",
        "/Render/normals: render var 'N' is not written; scrim:output:layers of the settings names layers",
        "/Render/deep: its resolution is not that of /Render/main, which is taken for both",
    ):
        assert text in shot.warnings, shot.warnings
    frame = shot.render()
    frame.write()
    frame.write_deep()
    header, found = channels(foggy.folder / "main.exr")
    assert header["colorInteropID"] in ("lin_rec709_scene", b"lin_rec709_scene") and "Z" in found
    assert found["R"].dtype == numpy.float32 and (foggy.folder / "deep.exr").exists()


def test_working_colours_are_exact(foggy):
    """A light in Rec.709 on grey fog, written in Rec.709, is what it was."""
    foggy.stage.GetPrimAtPath("/key").GetAttribute("inputs:color").Set(Gf.Vec3f(0.9, 0.3, 0.1))
    settings(foggy, renderingColorSpace="lin_rec709_scene")
    frame = foggy.open({"output.type": "float"}, settings="/Render/rs").render()
    _, found = channels(frame.write(foggy.folder / "out.exr"))
    assert [found[c][6, 6] / front(1.0) for c in "RGB"] == pytest.approx([0.9, 0.3, 0.1], rel=1e-3)


def test_settings_that_are_not_there(foggy):
    with pytest.raises(scrim.InputError, match="^'/rs' is not a RenderSettings of the stage; expected none$"):
        foggy.open(settings="/rs").render()
    settings(foggy)
    with pytest.raises(scrim.InputError, match="^'rs' is not a RenderSettings of the stage; expected /Render/rs$"):
        foggy.open(settings="rs").render()


def test_purposes_are_those_of_the_settings(foggy):
    UsdGeom.Imageable.Get(foggy.stage, "/fog").GetPurposeAttr().Set("guide")
    settings(foggy, includedPurposes=["default", "guide"])
    assert foggy.open(settings="/Render/rs").volumes == ["fog"]
    assert foggy.open(purpose=["default", "guide"]).volumes == ["fog"]


def test_a_still_camera_of_the_settings(foggy):
    camera = UsdGeom.Camera.Get(foggy.stage, "/cam")
    camera.GetShutterCloseAttr().Set(0.5)
    made = settings(foggy)
    assert "shutter" in foggy.open(settings="/Render/rs").scene(1)["camera"]
    made.GetDisableMotionBlurAttr().Set(True)
    assert "shutter" not in foggy.open(settings="/Render/rs").scene(1)["camera"]


# The program


@pytest.fixture
def scrim_on(foggy, python_path):
    """The program on the stage, whose second frame is twice as bright."""
    intensity = foggy.stage.GetPrimAtPath("/key").GetAttribute("inputs:intensity")
    intensity.Set(1.0, 1)
    intensity.Set(2.0, 2)
    foggy.stage.SetStartTimeCode(1)
    foggy.stage.SetEndTimeCode(4)
    foggy.stage.Save()

    def run(*arguments, command="render", **environment):
        return subprocess.run(
            [PROGRAM, command, foggy.path, *map(str, arguments)],
            env={**python_path, "SCRIM_PYTHON": sys.executable, **environment},
            cwd=foggy.folder,
            capture_output=True,
            text=True,
        )

    return run


def test_the_program_renders_frames(scrim_on, foggy):
    done = scrim_on("--frames", "1-3", "-o", "out.####.exr", "--res", "16x16", "--quality", "ultra")
    assert done.returncode == 0, done.stderr
    middles = [channels(foggy.folder / f"out.{n:04}.exr")[1]["R"] for n in (1, 2, 3)]
    values = [m[m.shape[0] // 2, m.shape[1] // 2] for m in middles]
    assert values == pytest.approx([front(1.0), front(2.0), front(2.0)], rel=0.004)
    own = foggy.open({"output.type": "half"}).render(2).image
    assert values[1] == pytest.approx(own[8, 8, 0], rel=1e-3)


def test_the_program_leaves_nothing_behind(scrim_on, tmp_path):
    (tmp_path / "temporary").mkdir()
    for arguments in (["-o", "out.exr"], ["--camera", "/eye"]):
        scrim_on("--frames", "1", "--res", "8x8", *arguments, TMPDIR=str(tmp_path / "temporary"))
        assert not list((tmp_path / "temporary").iterdir())


def test_the_program_prints_the_scene_of_a_frame(scrim_on, foggy):
    done = scrim_on("--print-scene", "--frames", 2, "--res", "16x16", "-v", "--set", "render.quality=draft")
    assert done.returncode == 0, done.stderr
    assert "intensity = 2.0" in done.stdout and 'quality = "draft"' in done.stdout
    assert "/key: irradiance 2 on what faces it" in done.stderr
    shot = scrim.loads(done.stdout, folder=foggy.folder)
    assert shot.render().image.shape == (16, 16, 4)


def test_the_program_says_what_is_not_mapped(scrim_on, foggy):
    foggy.light("GeometryLight", "/tube")
    foggy.stage.Save()
    done = scrim_on("--frames", "1-2", "-o", "out.####.exr", "--res", "7x7", "-q")
    assert done.returncode == 0
    assert done.stderr == "scrim: warning: /tube: lights of type GeometryLight are not rendered\n"


@pytest.mark.parametrize(
    "arguments, status, text",
    [
        ([], 2, r"give the frames with --frames \(the stage has 1 to 4\)"),
        (["--frames", "1", "--camera", "/eye"], 3, "'/eye' is not a camera of the stage; expected /cam"),
        (["--frames", "1", "--distant", "lux"], 2, "--distant='lux': expected radiance or irradiance"),
        (["--frames", "1", "--meshes", "x"], 2, "--meshes='x': expected holdout, shadows or none"),
        (["--frames", "1", "--purpose", "a"], 2, "--purpose='a': expected default, render, proxy or guide"),
        (["--frames", "1", "--settings", "/rs"], 3, "'/rs' is not a RenderSettings of the stage; expected none"),
        (["--frames", "1", "--sidecar", "no.toml"], 3, r"no.toml: .*No such file"),
        (["--frames", "1,2", "-o", "one.exr"], 2, "all 2 frames would be written to 'one.exr'; put the frame into its"),
    ],
)
def test_the_programs_errors(scrim_on, arguments, status, text):
    done = scrim_on(*arguments)
    assert done.returncode == status and re.search(text, done.stderr.splitlines()[-1]), done.stderr


def test_the_program_without_openusd(scrim_on, tmp_path):
    done = scrim_on("--frames", "1", SCRIM_PYTHON="/no/python")
    assert done.returncode == 3
    assert (
        "cannot start '/no/python': No such file or directory; stages are read by Scrim's Python package" in done.stderr
    )
    hidden = tmp_path / "hidden" / "pxr"
    hidden.mkdir(parents=True)
    (hidden / "__init__.py").write_text("raise ImportError(\"No module named 'pxr'\")")
    path = f"{tmp_path / 'hidden'}{os.pathsep}{scrim_path()}"
    done = scrim_on("--frames", "1", PYTHONPATH=path)
    assert done.returncode == 2 and "OpenUSD's Python package is missing (No module named 'pxr')" in done.stderr
    done = scrim_on("--frames", "1", PYTHONPATH="")
    assert done.returncode == 3 and done.stderr.count("\n") == 1, done.stderr
    assert (
        f"{sys.executable}: No module named 'scrim'; stages are read by Scrim's Python package, with OpenUSD "
        "(pip install '.[usd]' in the folder of Scrim's sources); $SCRIM_PYTHON names the Python that has both"
    ) in done.stderr


def scrim_path():
    return os.path.dirname(os.path.dirname(scrim.__file__))


def test_the_program_needs_room(scrim_on):
    done = scrim_on("--frames", "1", TMPDIR="/no/folder")
    assert done.returncode == 4 and "cannot make a folder for a stage's scenes: '/no/folder/scrim-usd-" in done.stderr


def test_frames_are_as_many_as_one_likes(scrim_on, tmp_path):
    counting = tmp_path / "counting"
    counting.write_text(
        "#!/bin/sh\nfor word; do case $word in --frames=*) file=${word#--frames=} ;; esac; done\n"
        "printf 'error\\tusage\\t%s frames\\n' $(tr , '\\n' <$file | grep -c .)\n"
    )
    counting.chmod(0o755)
    done = scrim_on("--frames", "1-30000", "-o", "a.####.exr", SCRIM_PYTHON=str(counting))
    assert done.returncode == 2 and done.stderr.endswith(": 30000 frames\n"), done.stderr


@pytest.mark.parametrize("signals", [[signal.SIGINT, signal.SIGINT], [signal.SIGKILL]], ids=["twice", "killed"])
def test_a_program_that_ends_at_once_leaves_no_folder(foggy, tmp_path, python_path, signals):
    foggy.stage.Save()
    slow = tmp_path / "slow"  # a Python that reads the stage, and hears nothing
    slow.write_text("#!/bin/sh\ntrap '' INT TERM\necho $$ >&2\nexec 2>/dev/null\nwhile sleep 0.1; do echo; done\n")
    slow.chmod(0o755)
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    program = subprocess.Popen(
        [PROGRAM, "render", foggy.path, "--frames", "1"], stderr=subprocess.PIPE, text=True,
        env={**python_path, "SCRIM_PYTHON": str(slow), "TMPDIR": str(temporary)},
    )  # fmt: skip
    python = int(program.stderr.readline())
    assert os.listdir(temporary)
    for one in signals:
        program.send_signal(one)
        time.sleep(0.2)  # or two of them would be one
    program.communicate()
    os.kill(python, signal.SIGKILL)
    for _ in range(300):
        if not os.listdir(temporary):
            return
        time.sleep(0.1)
    raise AssertionError(os.listdir(temporary))


def test_other_commands_take_stages(scrim_on, foggy):
    done = scrim_on("--frames", "1", command="plan")
    assert done.returncode == 0 and "sheets" in done.stdout, done.stderr
    done = scrim_on("--frames", "1", "-o", "light.vdb", command="bake")
    assert done.returncode == 0 and (foggy.folder / "light.vdb").exists(), done.stderr
    done = scrim_on("--frames", "1-2", "-o", "light.####.vdb", command="bake")
    assert done.returncode == 2 and "the stage changes between these frames" in done.stderr


def test_the_commands_of_the_page_work(tmp_path, python_path):
    """In the order of examples/USD.md, smaller."""
    (tmp_path / "examples/scenes").mkdir(parents=True)
    shutil.copy(ROOT / "examples/scenes/shot.usda", tmp_path / "examples/scenes")
    page = (ROOT / "examples/USD.md").read_text()
    commands = re.findall(r"^scrim (.*?)(?:  +#.*)?$", page.split("```sh\n")[1].split("```")[0], re.MULTILINE)
    assert len(commands) == 3
    for command in commands:
        words = shlex.split(command.replace("--frames 1-24", "--frames 1-24x23"))
        if words[0] == "render":
            words += ["--res", "32x18", "--quality", "draft"]
        done = subprocess.run(
            [PROGRAM, *words], env={**python_path, "SCRIM_PYTHON": sys.executable}, cwd=tmp_path, capture_output=True,
            text=True,
        )  # fmt: skip
        assert done.returncode == 0 and "warning" not in done.stderr, done.stderr
        if "--print-scene" in words:
            assert "/World/Sun: irradiance 24 on what faces it" in done.stderr and "[[volume]]" in done.stdout
    first, last = (channels(tmp_path / f"shot.{n:04}.exr")[1]["A"] for n in (1, 24))
    assert first.max() > 0.5 and (first.shape != last.shape or not numpy.array_equal(first, last))


def test_the_package_runs_the_program_on_stages(scrim_on, foggy, python_path):
    done = subprocess.run(
        [sys.executable, "-m", "scrim", "render", foggy.path, "--frames", "1", "-o", "out.exr", "--res", "8x8", "-q"],
        env=python_path, cwd=foggy.folder, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0 and (foggy.folder / "out.exr").exists(), done.stderr
