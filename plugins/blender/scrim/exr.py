# SPDX-License-Identifier: Apache-2.0
# Reads the EXR that Scrim writes for us, and writes one that it reads: one part, scan lines, no compression. Blender's
# own reader gives no access to the pixels of pictures with layers, and loads render results only by names of
# Blender's. This one is exact, and takes no library but NumPy, which Blender brings along.
import struct

import numpy as np

_TYPES = {1: np.dtype("<f2"), 2: np.dtype("<f4")}


class Picture:
    """`channels`: arrays of float32 by name, rows from the top, over the data window; `data_window` and
    `display_window` are (x0, y0, x1, y1), both ends inside."""

    def __init__(self, channels, data_window, display_window):
        self.channels = channels
        self.data_window = data_window
        self.display_window = display_window

    def region(self, name, x0, y0, width, height, outside=0.0):
        """The channel in the pixels [x0, x0 + width) x [y0, y0 + height) of the display window, rows from the top;
        `outside` where the data window does not reach."""
        out = np.full((height, width), outside, np.float32)
        left, top, right, bottom = self.data_window
        a, b = max(left, x0), min(right + 1, x0 + width)
        c, d = max(top, y0), min(bottom + 1, y0 + height)
        if a < b and c < d:
            out[c - y0 : d - y0, a - x0 : b - x0] = self.channels[name][c - top : d - top, a - left : b - left]
        return out


def _string(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def _header(data, at):
    attributes = {}
    while True:
        name, at = _string(data, at)
        if not name:
            return attributes, at
        _, at = _string(data, at)
        (size,) = struct.unpack_from("<i", data, at)
        attributes[name] = data[at + 4 : at + 4 + size]
        at += 4 + size


def _channels(content):
    out, at = [], 0
    while content[at] != 0:
        name, at = _string(content, at)
        kind, _, x, y = struct.unpack_from("<iiii", content, at)
        at += 16
        if kind not in _TYPES or (x, y) != (1, 1):
            raise ValueError(f"channel '{name}' is neither half nor float, or is subsampled")
        out.append((name, _TYPES[kind]))
    return out


def read(path):
    with open(path, "rb") as file:
        data = file.read()
    if len(data) < 8 or data[:4] != b"\x76\x2f\x31\x01":
        raise ValueError(f"'{path}' is not an EXR")
    if struct.unpack_from("<i", data, 4)[0] & 0x1A00:
        raise ValueError(f"'{path}' is tiled, deep, or of several parts; expected one picture of scan lines")
    attributes, at = _header(data, 8)
    if attributes["compression"][0] != 0:
        raise ValueError(f"'{path}' is compressed; expected no compression")
    window = struct.unpack("<iiii", attributes["dataWindow"])
    display = struct.unpack("<iiii", attributes["displayWindow"])
    width, height = window[2] - window[0] + 1, window[3] - window[1] + 1
    channels = _channels(attributes["channels"])
    out = {name: np.empty((height, width), np.float32) for name, _ in channels}
    for offset in struct.unpack_from(f"<{height}Q", data, at):
        y, _ = struct.unpack_from("<ii", data, offset)
        begin = offset + 8
        for name, dtype in channels:
            out[name][y - window[1]] = np.frombuffer(data, dtype, width, begin)
            begin += width * dtype.itemsize
    return Picture(out, window, display)


def _attribute(name, kind, content):
    return name + b"\0" + kind + b"\0" + struct.pack("<i", len(content)) + content


def write(path, pixels):
    """`pixels`: height x width x 3 (RGB) or 4 (RGBA), rows from the top."""
    height, width, count = pixels.shape
    names = sorted((b"RGBA"[i : i + 1], i) for i in range(count))  # as files have them
    window = struct.pack("<iiii", 0, 0, width - 1, height - 1)
    head = b"\x76\x2f\x31\x01" + struct.pack("<i", 2)
    channels = b"".join(name + b"\0" + struct.pack("<iiii", 2, 0, 1, 1) for name, _ in names) + b"\0"
    head += _attribute(b"channels", b"chlist", channels)
    head += _attribute(b"compression", b"compression", b"\0")
    head += _attribute(b"dataWindow", b"box2i", window) + _attribute(b"displayWindow", b"box2i", window)
    head += _attribute(b"lineOrder", b"lineOrder", b"\0")
    head += _attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1))
    head += _attribute(b"screenWindowCenter", b"v2f", struct.pack("<ff", 0, 0))
    head += _attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1)) + b"\0"
    size = 4 * count * width
    first = len(head) + 8 * height
    offsets = [first + y * (8 + size) for y in range(height)]
    with open(path, "wb") as file:
        file.write(head + struct.pack(f"<{height}Q", *offsets))
        for y in range(height):
            line = np.stack([pixels[y, :, c] for _, c in names]).astype("<f4")
            file.write(struct.pack("<ii", y, size) + line.tobytes())
