# SPDX-License-Identifier: Apache-2.0
"""Pictures as arrays of NumPy, for tools that write no EXR and for what compares frames: uncompressed floats alone."""
import struct

import numpy as np

CHANNELS = "ABGR"  # in a file they are in alphabetical order


def attribute(name, kind, data):
    return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(data)) + data


def write(path, rgba):
    """`rgba`: (height, width, 4), rows from the top."""
    height, width, _ = rgba.shape
    channels = b"".join(c.encode() + b"\0" + struct.pack("<iiii", 2, 0, 1, 1) for c in CHANNELS) + b"\0"
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = struct.pack("<ii", 20000630, 2) + b"".join([
        attribute("channels", "chlist", channels), attribute("compression", "compression", b"\0"),
        attribute("dataWindow", "box2i", window), attribute("displayWindow", "box2i", window),
        attribute("lineOrder", "lineOrder", b"\0"), attribute("pixelAspectRatio", "float", struct.pack("<f", 1)),
        attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)),
        attribute("screenWindowWidth", "float", struct.pack("<f", 1))]) + b"\0"
    row = 16 * width
    begin = len(header) + 8 * height
    planes = np.ascontiguousarray(rgba[..., ::-1].transpose(0, 2, 1), "<f4")
    with open(path, "wb") as file:
        file.write(header + struct.pack(f"<{height}Q", *(begin + y * (row + 8) for y in range(height))))
        for y in range(height):
            file.write(struct.pack("<ii", y, row) + planes[y].tobytes())


def read(path):
    """(height, width, 3) of the display window; `path` is an uncompressed scan-line file of floats."""
    with open(path, "rb") as file:
        data = file.read()
    at, attributes = 8, {}
    while data[at]:
        name, kind = data[at:].split(b"\0", 2)[:2]
        at += len(name) + len(kind) + 2
        size, = struct.unpack_from("<i", data, at)
        attributes[name.decode()] = data[at + 4:at + 4 + size]
        at += 4 + size
    if attributes["compression"] != b"\0":
        raise SystemExit(f"{path}: expected no compression")
    names, rest = [], attributes["channels"]
    while rest[0]:
        name, rest = rest.split(b"\0", 1)
        if struct.unpack_from("<i", rest)[0] != 2:
            raise SystemExit(f"{path}: expected floats")
        names.append(name.decode().split(".")[-1])
        rest = rest[16:]
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    dx0, dy0, dx1, dy1 = struct.unpack("<4i", attributes["displayWindow"])
    image = np.zeros((dy1 - dy0 + 1, dx1 - dx0 + 1, 3), np.float32)
    shape, order = (len(names), x1 - x0 + 1), [names.index(c) for c in "RGB"]
    for offset in struct.unpack_from(f"<{y1 - y0 + 1}Q", data, at + 1):
        y, = struct.unpack_from("<i", data, offset)
        row = np.frombuffer(data, "<f4", shape[0] * shape[1], offset + 8).reshape(shape)[order]
        image[y - dy0, x0 - dx0:x1 - dx0 + 1] = row.T
    return image
