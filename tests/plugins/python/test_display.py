# SPDX-License-Identifier: Apache-2.0
"""`scrim render --display-server`: what a viewer is sent, beside what tev's own client sends."""

import socket
import struct
import subprocess
import threading

import numpy
import OpenEXR
import pytest
from conftest import PROGRAM, SMOKE
from tevclient import packet

CHANNELS = ["R", "G", "B", "A"]
CREATE, UPDATE = 4, 6


class Viewer:
    """Takes packets: all of them, or so many bytes and then hangs up, or none at all."""

    def __init__(self, most_bytes=None, reads=True):
        self.packets = []
        self._most, self._reads = most_bytes, reads
        self._server = socket.create_server(("127.0.0.1", 0))
        self.address = "127.0.0.1:%d" % self._server.getsockname()[1]
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def _serve(self):
        connection, _ = self._server.accept()
        with connection:
            if not self._reads:
                self._done.wait(60)
                return
            taken = bytearray()
            while self._most is None or len(taken) < self._most:
                more = connection.recv(1 << 20)
                if not more:
                    break
                taken += more
        while len(taken) >= 4 and len(taken) >= struct.unpack_from("<I", taken)[0]:
            size = struct.unpack_from("<I", taken)[0]
            self.packets.append(bytes(taken[:size]))
            del taken[:size]
        self.left = len(taken)

    def close(self):
        self._done.set()
        self._thread.join(60)
        self._server.close()


class Reader:
    def __init__(self, data):
        self._data, self._at = data, 0

    def number(self, form):
        value = struct.unpack_from("<" + form, self._data, self._at)[0]
        self._at += struct.calcsize("<" + form)
        return value

    def text(self):
        end = self._data.index(b"\0", self._at)
        text, self._at = self._data[self._at : end].decode(), end + 1
        return text

    def floats(self):
        return numpy.frombuffer(self._data[self._at :], "<f4")


def decode_update(data):
    """(name, x, y, pixels) of a packet, which must be what tev's client makes of them."""
    reader = Reader(data)
    assert reader.number("I") == len(data) and reader.number("B") == UPDATE and reader.number("B") == 0
    name = reader.text()
    assert [reader.text() for _ in range(reader.number("i"))] == CHANNELS
    x, y, width, height = (reader.number("i") for _ in range(4))
    for _ in range(8):
        reader.number("q")
    pixels = reader.floats().reshape(height, width, 4)
    assert bytes(packet.update_image(name, pixels, CHANNELS, x, y, False)) == data
    return name, x, y, pixels


def pictures_of(viewer):
    """{name: [every state of the picture]}, after each packet."""
    states = {}
    for data in viewer.packets:
        if data[4] == CREATE:
            reader = Reader(data)
            reader.number("I"), reader.number("B")
            focus, name = reader.number("B"), reader.text()
            width, height = reader.number("i"), reader.number("i")
            assert bytes(packet.create_image(name, width, height, CHANNELS, bool(focus))) == data
            assert focus == (0 if states else 1)
            assert name not in states
            states[name] = [numpy.zeros((height, width, 4), numpy.float32)]
        else:
            name, x, y, pixels = decode_update(data)
            now = states[name][-1].copy()
            now[y : y + pixels.shape[0], x : x + pixels.shape[1]] = pixels
            states[name].append(now)
    assert viewer.left == 0
    return states


def read_exr(path):
    """RGBA of the whole display window."""
    with OpenEXR.File(str(path)) as file:
        (x, y), _ = file.header()["dataWindow"]
        _, (right, bottom) = file.header()["displayWindow"]
        pixels = file.channels()["RGBA"].pixels
    picture = numpy.zeros((bottom + 1, right + 1, 4), numpy.float32)
    picture[y : y + pixels.shape[0], x : x + pixels.shape[1]] = pixels
    return picture


@pytest.fixture
def render(tmp_path):
    (tmp_path / "smoke.toml").write_text(SMOKE + 'colorspace = "lin_rec709_scene"\nfile = "smoke.exr"\n')

    def run(*arguments):
        return subprocess.run(
            [PROGRAM, "render", "smoke.toml", "--set", "output.layers=[]", *arguments],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            timeout=120,
        )

    return run


def test_the_viewer_ends_with_the_picture_in_linear_rec709(render, tmp_path):
    viewer = Viewer()
    result = render("--res", "300x200", "--frames", "1-2", "-o", "smoke.####.exr", "--display-server", viewer.address)
    viewer.close()
    assert result.returncode == 0, result.stderr
    pictures = pictures_of(viewer)
    assert list(pictures) == ["smoke.0001.exr", "smoke.0002.exr"]
    for name, states in pictures.items():
        picture = read_exr(tmp_path / name)
        assert picture[..., 3].max() > 0.3
        assert states[-1].shape == picture.shape
        numpy.testing.assert_allclose(states[-1], picture, rtol=1e-5, atol=1e-6)


def test_a_config_without_linear_rec709_is_shown_in_its_working_space(render, tmp_path):
    (tmp_path / "old.ocio").write_text(
        "ocio_profile_version: 1\n"
        "roles: {scene_linear: ours, default: ours}\n"
        "displays: {monitor: [!<View> {name: plain, colorspace: ours}]}\n"
        "colorspaces: [!<ColorSpace> {name: ours}]\n"
    )
    viewer = Viewer()
    spaces = ["--ocio", "old.ocio", "--set", "output.colorspace=ours"]
    result = render("--res", "96x64", *spaces, "--display-server", viewer.address)
    viewer.close()
    assert result.returncode == 0, result.stderr
    assert "stopped showing" not in result.stderr
    (states,) = pictures_of(viewer).values()
    numpy.testing.assert_allclose(states[-1], read_exr(tmp_path / "smoke.exr"), rtol=1e-5, atol=1e-6)


def test_the_picture_is_shown_while_it_grows(render):
    viewer = Viewer()
    result = render(
        "--res",
        "640x480",
        "--quality",
        "ultra",
        "--set",
        "volume.smoke.parameters.resolution=128",
        "--display-server",
        viewer.address,
    )
    viewer.close()
    assert result.returncode == 0, result.stderr
    (states,) = pictures_of(viewer).values()
    last = states[-1][..., 3]
    unfinished = [state[..., 3] for state in states[1:-1] if (state[..., 3] < 0.5 * last).sum() > 1000]
    grown = [alpha for alpha in unfinished if 0.02 < alpha.max()]
    assert grown, f"{len(states)} packets, none of a picture under way"
    for alpha in grown:  # sheets in front of others are there first, and nothing is taken back
        assert (alpha <= last + 1e-4).all()


def test_a_crop_is_shown_alone(render, tmp_path):
    viewer = Viewer()
    assert render("--res", "300x200", "--crop", "100,50,240,190", "--display-server", viewer.address).returncode == 0
    viewer.close()
    (states,) = pictures_of(viewer).values()
    assert states[-1].shape == (140, 140, 4)


def test_a_viewer_that_hangs_up_costs_no_picture(render, tmp_path):
    viewer = Viewer(most_bytes=1000)
    result = render("--res", "1024x768", "--frames", "1-2", "-o", "smoke.####.exr", "--display-server", viewer.address)
    viewer.close()
    assert result.returncode == 0, result.stderr
    assert result.stderr.count(f"--display-server {viewer.address}: stopped showing pictures: ") == 1
    assert read_exr(tmp_path / "smoke.0002.exr")[..., 3].max() > 0.3


def test_a_viewer_that_takes_nothing_holds_nothing_up(render, tmp_path):
    viewer = Viewer(reads=False)
    result = render("--res", "2048x1536", "--display-server", viewer.address)
    viewer.close()
    assert result.returncode == 0, result.stderr
    assert (tmp_path / "smoke.exr").exists()


def test_without_a_viewer_pictures_are_rendered_all_the_same(render, tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as free:
        address = "127.0.0.1:%d" % free.getsockname()[1]
    result = render("--display-server", address)
    assert result.returncode == 0
    assert result.stderr.startswith(
        f"scrim: warning: --display-server {address}: no viewer answers: Connection refused; pictures are rendered but"
        " not shown\n"
    )
    (tmp_path / "smoke.exr").unlink()
    result = render("--display-server", "localhost:tev")
    assert result.returncode == 2
    assert result.stderr == (
        "scrim: error: --display-server 'localhost:tev': expected HOST:PORT, such as 127.0.0.1:14158\n"
    )
    assert not list(tmp_path.glob("*.exr"))
