# SPDX-License-Identifier: Apache-2.0
"""Pictures: what they hold, whose memory it is, and that they are the program's."""

import gc
import math

import numpy
import OpenEXR
import pytest

import scrim


def test_values_are_those_of_the_programs_file_bit_for_bit(smoke, tmp_path, program):
    done = program("render", smoke, "-o", tmp_path / "program.exr", "-q")
    assert done.returncode == 0, done.stderr
    frame = scrim.open(smoke).render()
    with OpenEXR.File(str(tmp_path / "program.exr"), separate_channels=True) as file:
        channels = {name: channel.pixels for name, channel in file.channels().items()}
        x0, y0 = file.header()["dataWindow"][0]
        x1, y1 = file.header()["dataWindow"][1]
    compared = 0
    for layer in ["beauty", *frame.layers]:
        inside = frame[layer][y0 : y1 + 1, x0 : x1 + 1]
        for i, name in enumerate(frame.channels(layer)):
            assert channels[name].dtype == numpy.float32
            assert numpy.array_equal(inside[:, :, i].view(numpy.uint32), channels[name].view(numpy.uint32)), name
            compared += 1
    assert compared == len(channels) == 4 + 3 + 3 + 2


def test_writing_gives_the_programs_pixels(smoke, tmp_path, program):
    assert program("render", smoke, "-o", tmp_path / "program.exr", "-q").returncode == 0
    frame = scrim.open(smoke).render(7)
    path = frame.write(tmp_path / "own.####.exr")
    assert path == str(tmp_path / "own.0007.exr")
    with OpenEXR.File(path, separate_channels=True) as own:
        with OpenEXR.File(str(tmp_path / "program.exr"), separate_channels=True) as other:
            assert own.channels().keys() == other.channels().keys()
            for name, channel in own.channels().items():
                assert numpy.array_equal(channel.pixels, other.channels()[name].pixels), name


def test_pictures_are_arrays_of_height_width_channels(smoke):
    frame = scrim.open(smoke).render()
    assert frame.layers == ["light.key", "light.rim", "depth"]
    assert frame.image.shape == frame["beauty"].shape == (48, 64, 4)
    assert frame["light.key"].shape == (48, 64, 3) and frame["light.key"].dtype == numpy.float32
    assert frame.channels("depth") == ["Z", "depth.mean"] and frame["depth"].shape == (48, 64, 2)
    assert frame.window == (0, 0, 64, 48) and frame.number == 1
    assert repr(frame) == "<scrim.Frame 1, 64x48>"
    together = frame["light.key"] + frame["light.rim"]
    assert together.max() > 0.05
    assert numpy.allclose(together, frame.image[:, :, :3], atol=1e-6)


def test_arrays_are_views_that_keep_the_frames_memory(smoke):
    frame = scrim.open(smoke).render()
    image, again = frame.image, frame.image
    assert image.ctypes.data == again.ctypes.data and not image.flags.owndata
    before, key = image.copy(), frame["light.key"]
    key_before = key.copy()
    del frame, again
    gc.collect()
    fill = [numpy.full((48, 64, 4), float(i), numpy.float32) for i in range(200)]  # would take freed memory
    assert numpy.array_equal(image, before) and numpy.array_equal(key, key_before)
    assert len(fill) == 200


def test_views_cannot_be_written_to(smoke):
    image = scrim.open(smoke).render().image
    assert not image.flags.writeable
    with pytest.raises(ValueError, match="read-only"):
        image[0, 0, 0] = 1


def test_a_layer_that_is_not_there_names_the_choices(smoke):
    frame = scrim.open(smoke).render()
    with pytest.raises(scrim.UsageError, match="'light.key', 'light.rim' or 'depth'"):
        frame["light.fill"]


def test_a_crop_is_a_part_of_the_picture(smoke):
    whole = scrim.open(smoke).render()
    part = scrim.open(smoke).render(crop=(10, 20, 42, 37))
    assert part.window == (10, 20, 42, 37)
    assert numpy.array_equal(part.image, whole.image[20:37, 10:42])


def test_verification_gives_an_error_and_its_interval(smoke):
    frame = scrim.open(smoke).render(verify=60)
    assert 0 < frame.error < 0.05
    found = frame.stats["verification"]
    assert found["error"] == frame.error and found["lower"] <= frame.error <= found["upper"]
    assert scrim.open(smoke).render().error is None


def test_a_tolerance_that_is_not_reached_is_said(smoke):
    frame = scrim.open(smoke, {"camera.resolution": [24, 18]}).render(tolerance=1e-5, verify=20)
    assert not frame.stats["tolerance"]["met"]
    with pytest.raises(
        scrim.AccuracyError, match=r"^frame 1: its error may be [0-9.e-]+, more than the tolerance of 1e-05$"
    ):
        frame.require_accuracy()
    scrim.open(smoke).render().require_accuracy()


def test_stats_are_numbers_of_the_render(smoke):
    stats = scrim.open(smoke).render(threads=1).stats
    assert stats["threads"] == 1 and stats["resolution"] == [64, 48]
    assert stats["work"]["sheets"] > 0 and stats["seconds"]["render"] > 0


def test_pixels_do_not_depend_on_threads(smoke):
    one, all_of_them = scrim.open(smoke).render(threads=1), scrim.open(smoke).render()
    assert numpy.array_equal(one.image, all_of_them.image)


def test_previews_and_deep_pictures_are_written(smoke, tmp_path):
    frame = scrim.open(smoke, {"output.deep": str(tmp_path / "deep.exr")}).render()
    frame.write_deep()
    frame.preview(tmp_path / "look.png")
    assert (tmp_path / "deep.exr").stat().st_size > 1000
    assert (tmp_path / "look.png").read_bytes().startswith(b"\x89PNG")


def test_a_picture_that_cannot_be_written_says_why(smoke, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(scrim.OutputError, match="file"):
        scrim.open(smoke).render().write(tmp_path / "file" / "own.exr")


def test_memory_that_does_not_suffice_is_a_memory_error(smoke):
    with pytest.raises(scrim.OutOfMemoryError, match="limit of") as caught:
        scrim.open(smoke).render(memory=1000)
    assert isinstance(caught.value, MemoryError)


def test_a_missing_file_stops_blackens_or_skips(tmp_path):
    scene = {
        "camera": {"position": [0, 0, 5], "target": [0, 0, 0]},
        "volume": [{"name": "smoke", "file": "smoke.####.vdb"}],
        "light": [{"name": "key", "type": "distant", "direction": [0, 0, -1]}],
    }
    shot = scrim.loads(scene, {"camera.resolution": [8, 8]}, folder=tmp_path)
    with pytest.raises(scrim.InputError, match=r"^scene:\d+:\d+: volume 'smoke': there is no file '.*smoke.0003.vdb'$"):
        shot.render(3)
    assert shot.render(3, missing="skip") is None
    assert math.isclose(shot.render(3, missing="black").image.sum(), 0)
    with pytest.raises(scrim.UsageError, match="^missing='none': expected 'error', 'black' or 'skip'$"):
        shot.render(3, missing="none")


def test_examined_pixels_make_the_error_of_the_verification(smoke):
    frame = scrim.open(smoke).render(verify=150)
    place, picture, truth = (frame.examined[name] for name in ("place", "picture", "truth"))
    stats = frame.stats["verification"]
    assert len(place) == stats["pixels"] >= 150 and place.shape[1] == 2 and truth.shape == picture.shape
    assert numpy.array_equal(picture.astype(numpy.float32), frame.image[place[:, 1], place[:, 0]])
    both = numpy.maximum(picture, truth)  # those count that show something
    assert ((both[:, 3] > 1e-3) | (both[:, :3].max(axis=1) > 1e-3 * truth[:, :3].max())).all()
    assert truth[:, :3].mean() == pytest.approx(stats["mean"], rel=1e-12)
    off = (picture - truth)[:, :3]
    assert numpy.sqrt((off**2).mean()) / stats["mean"] == pytest.approx(frame.error, rel=1e-9)
    assert scrim.open(smoke).render().examined is None
