# SPDX-License-Identifier: Apache-2.0
"""Volumes from arrays and from OpenVDB files."""

import math

import numpy
import pytest
from conftest import SLAB

import scrim

ONES = numpy.ones((16, 16, 16), numpy.float32)
CENTRED = {"origin": (-7.5, -7.5, -7.5)}


def rendered(field, overrides=None, volume="fog"):
    shot = scrim.loads(SLAB, overrides)
    shot.set_volume(volume, field)
    return shot.render().image


def test_a_slab_has_its_closed_form():
    tau = 1.6  # 16 voxels of extinction 0.1
    middle = rendered(scrim.Field(ONES, **CENTRED))[16, 16]
    alpha = 1 - math.exp(-tau)
    assert abs(middle[3] - alpha) < 0.01 * alpha
    # Zhang and Crawfis's equation for light from the front: E rho / (8 pi) (1 - exp(-2 tau)).
    light = 0.9 / (8 * math.pi) * (1 - math.exp(-2 * tau))
    assert numpy.allclose(middle[:3], light, rtol=0.01)


def test_voxel_size_and_scale_agree():
    # Half as fine, twice as wide: the same slab.
    coarse = numpy.ones((8, 8, 8), numpy.float32)
    image = rendered(scrim.Field(coarse, 2.0, origin=(-7, -7, -7)))
    tau = 1.6
    assert abs(image[16, 16, 3] - (1 - math.exp(-tau))) < 0.01
    matrix = numpy.diag([2.0, 2.0, 2.0, 1.0])
    matrix[:3, 3] = -7
    assert numpy.array_equal(rendered(scrim.Field(coarse, transform=matrix)), image)


def test_axes_of_the_array_are_those_of_the_world():
    for axis, (row, column) in enumerate([(16, 24), (8, 16)]):  # +x is right, +y is up
        array = numpy.zeros((16, 16, 16), numpy.float32)
        array[(slice(None),) * axis + (slice(11, 16),)] = 1
        image = rendered(scrim.Field(array, **CENTRED))
        assert image[row, column, 3] > 0.5 and image[31 - row, 31 - column, 3] < 0.01


def test_strides_and_types_do_not_matter():
    numbers = numpy.random.default_rng(7).integers(0, 9, (20, 9, 14)).astype(numpy.float32)
    whole = rendered(scrim.Field(numbers))
    fortran = numpy.asfortranarray(numbers)
    apart = numpy.zeros((40, 18, 28), numpy.float64)
    apart[::2, 1::2, ::2] = numbers
    backwards = numbers[::-1, ::-1, ::-1].copy()[::-1, ::-1, ::-1]
    swapped = numbers.astype(numbers.dtype.newbyteorder())
    packed = numpy.zeros(numbers.shape, [("other", "u1"), ("density", "f4")])
    packed["density"] = numbers
    for same in [
        packed["density"],
        fortran,
        apart[::2, 1::2, ::2],
        backwards,
        swapped,
        numbers.astype(numpy.float16),
        numbers.astype(numpy.uint8),
        numbers.astype(numpy.int64),
        numbers.tolist(),
    ]:
        field = scrim.Field(same)
        assert field.active_voxels == numpy.count_nonzero(numbers) and field.max == 8
        assert numpy.array_equal(rendered(field), whole)
    assert whole.max() > 0


def peak_beyond(make):
    """Bytes of memory that a call takes at most beyond what there was before."""
    with open("/proc/self/clear_refs", "w") as file:
        file.write("5")  # the peak starts anew

    def now(key):
        with open("/proc/self/status") as file:
            return next(1024 * int(line.split()[1]) for line in file if line.startswith(key))

    before = now("VmRSS")
    made = make()
    return now("VmHWM") - before, now("VmRSS") - before, made


def test_an_array_is_copied_once_whatever_its_numbers():
    scrim.Field(ONES)
    native = numpy.full((192, 192, 192), 3, numpy.float32)
    for array in [
        native,
        numpy.asfortranarray(native),
        native.astype(native.dtype.newbyteorder()),
        native.astype(numpy.float64),
        native.astype(numpy.float16),
        native.astype(numpy.int16).astype(">i2"),
        native.astype(numpy.uint64),
        native > 0,
    ]:
        peak, _, field = peak_beyond(lambda array=array: scrim.Field(array))
        assert field.active_voxels == native.size and field.max in (1, 3)
        assert peak < 1.3 * field.nbytes, array.dtype


def test_emptiness_of_an_array_takes_no_memory():
    array = numpy.zeros((256, 256, 256), numpy.float32)
    array[100:110, 100:110, 100:110] = 1
    peak, kept, field = peak_beyond(lambda: scrim.Field(array))
    assert field.active_voxels == 1000 and peak < 0.1 * array.nbytes
    array -= 1000  # as the air of a scan: not 0, but nothing either
    array[100:110, 100:110, 100:110] = 1
    peak, kept, field = peak_beyond(lambda: scrim.Field(array))
    assert field.active_voxels == 1000 and kept < 0.1 * array.nbytes and peak < 1.3 * array.nbytes


def test_a_colour_is_an_array_of_three(tmp_path):
    colours = numpy.zeros((16, 16, 16, 3), numpy.float32)
    colours[:] = (0.8, 0.4, 0.2)
    albedo = {"volume.fog.medium": {"albedo": {"grid": "Cd"}}}
    image = rendered([scrim.Field(ONES, **CENTRED), scrim.Field(colours, name="Cd", **CENTRED)], albedo)
    red, green, blue, alpha = image[16, 16]
    assert red > 0.01 and abs(green / red - 0.5) < 1e-3 and abs(blue / red - 0.25) < 1e-3


def test_the_array_is_read_once():
    array = ONES.copy()
    field = scrim.Field(array, **CENTRED)
    before = rendered(field)
    array[:] = 0
    assert numpy.array_equal(rendered(field), before)


def test_what_is_no_density_counts_as_nothing_and_is_said(caplog):
    array = ONES.copy()
    array[0, 0, :3] = numpy.nan, numpy.inf, -1
    field = scrim.Field(array)
    assert field.active_voxels == 16**3 - 3
    assert [r.levelname for r in caplog.records] == ["WARNING"]
    assert "grid 'density'" in caplog.records[0].getMessage()


def test_a_field_says_what_it_is():
    field = scrim.Field(ONES, (1, 2, 3), origin=(10, 0, 0))
    assert field.name == "density" and field.active_voxels == 4096 and field.nbytes > 4 * 4096
    assert field.bounds == ((10, 0, 0), (25, 30, 45))
    assert repr(field) == "<scrim.Field 'density', 4096 voxels>"
    assert scrim.Field(ONES * 0).bounds is None


def test_volumes_may_change_from_frame_to_frame():
    shot = scrim.loads(SLAB)
    found = []
    for density in (0.5, 1.0):
        shot.set_volume("fog", scrim.Field(ONES * density, **CENTRED))
        found.append(shot.render().image[16, 16, 3])
    assert found[0] < found[1] and abs(found[1] - (1 - math.exp(-1.6))) < 0.01


def test_files_of_openvdb_are_volumes(tmp_path, program):
    made = program("make", "noise", "resolution=32", "-q", "-o", tmp_path / "smoke.vdb")
    assert made.returncode == 0, made.stderr
    (field,) = scrim.read_vdb(tmp_path / "smoke.vdb")
    assert field.name == "density" and field.active_voxels > 1000
    scene = scrim.open(tmp_path / "smoke.vdb", resolution=(40, 30))
    from_file = scene.render().image
    toml = scene.toml().replace(str(tmp_path / "smoke.vdb"), "absent.vdb")
    name = scene.volumes[0]
    for grids in [field, [field], tmp_path / "smoke.vdb", str(tmp_path / "smoke.vdb")]:
        shot = scrim.loads(toml)
        shot.set_volume(name, grids)
        assert numpy.array_equal(shot.render().image, from_file)
    with pytest.raises(scrim.InputError, match="there is no grid 'heat' that could be rendered; there is 'density'"):
        scrim.read_vdb(tmp_path / "smoke.vdb", ["heat"])
    with pytest.raises(scrim.InputError, match="absent.vdb"):
        scrim.read_vdb(tmp_path / "absent.vdb")


def test_grids_of_openvdbs_own_module_are_volumes():
    openvdb = pytest.importorskip("pyopenvdb")  # Debian's wants NumPy 1
    array = 1 + numpy.random.default_rng(1).random((16, 16, 16)).astype(numpy.float32)
    grid = openvdb.FloatGrid()
    grid.name = "density"
    grid.copyFromArray(array)
    grid.transform = openvdb.createLinearTransform(1.0)
    grid.transform.translate((-7.5, -7.5, -7.5))
    assert numpy.array_equal(rendered(grid), rendered(scrim.Field(array, **CENTRED)))


@pytest.mark.parametrize(
    "arguments, text",
    [
        (
            [numpy.ones((2, 2))],
            r"grid 'density': the array is of shape \(2, 2\); expected \(nx, ny, nz\), or \(nx, ny, nz, 3\)",
        ),
        ([numpy.ones((2, 2, 2, 2))], r"the array is of shape \(2, 2, 2, 2\)"),
        ([numpy.ones((2, 0, 2))], r"the array is of shape \(2, 0, 2\)"),
        (
            [numpy.ones((2, 2, 2), complex)],
            "grid 'density': the array holds complex128; expected floats or whole numbers",
        ),
        ([[["a"]]], "the array holds <U1"),
        ([ONES, 0], "^voxel_size: expected world units above 0$"),
        ([ONES, (1, -1, 1)], "^voxel_size: expected world units above 0$"),
        ([ONES, (1, 1)], r"^\(1, 1\): expected a voxel size: one number or three$"),
    ],
)
def test_arrays_that_are_no_volume_say_why(arguments, text):
    with pytest.raises(scrim.UsageError, match=text):
        scrim.Field(*arguments)


@pytest.mark.parametrize(
    "keywords, text",
    [
        ({"origin": (1, 2)}, r"^\(1, 2\): expected an origin: three numbers$"),
        ({"transform": numpy.eye(3)}, "expected a matrix of 4 x 4 numbers, row by row"),
        (
            {"transform": numpy.ones((4, 4))},
            "^transform: expected a matrix of 4 x 4 numbers, row by row, whose last row is 0, 0, 0, 1$",
        ),
        (
            {"transform": numpy.eye(4), "origin": (0, 0, 0)},
            "^transform: it says where voxels lie; expected neither voxel_size nor origin",
        ),
        ({"transform": numpy.diag([1, 1, 0, 1])}, "density"),
    ],
)
def test_places_that_are_none_say_why(keywords, text):
    with pytest.raises(scrim.Error, match=text):
        scrim.Field(ONES, **keywords)


def test_volumes_that_are_not_there_say_which_are():
    shot = scrim.loads(SLAB)
    with pytest.raises(scrim.UsageError, match="^scene: there is no volume 'smoke'; there is 'fog'$"):
        shot.set_volume("smoke", scrim.Field(ONES))
    with pytest.raises(
        scrim.UsageError, match="^a volume's grid is of type int; expected a scrim.Field, an OpenVDB grid, the path"
    ):
        shot.set_volume("fog", 3)
    with pytest.raises(scrim.UsageError, match="^volume 'fog': expected at least one grid$"):
        shot.set_volume("fog", [])
    with pytest.raises(scrim.UsageError, match=r"^scene:\d+:\d+: volume 'fog' has no file, no source and no grids$"):
        shot.render()
    shot.set_volume("fog", scrim.Field(ONES, name="heat"))
    with pytest.raises(scrim.InputError, match="volume 'fog' has no grid 'density'; there is 'heat'"):
        shot = scrim.loads(SLAB, {"volume.fog.density.grid": "density"})
        shot.set_volume("fog", scrim.Field(ONES, name="heat"))
        shot.render()
