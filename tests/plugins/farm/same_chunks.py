# SPDX-License-Identifier: Apache-2.0
"""same_chunks.py A.exr B.exr: do two OpenEXR files, flat or deep, hold the same pixels, bit by bit? The headers may
differ (tiles tell of their work apart); what is packed behind them may not."""
import struct
import sys


def chunks_of(path):
    """Channels and data window as the file has them, and all bytes of its chunks."""
    with open(path, "rb") as file:
        data = file.read()
    at, attributes = 8, {}
    while data[at] != 0:
        end = data.index(b"\0", at)
        name, at = data[at:end], end + 1
        at = data.index(b"\0", at) + 1
        size = struct.unpack_from("<i", data, at)[0]
        attributes[name] = data[at + 4 : at + 4 + size]
        at += 4 + size
    first = struct.unpack_from("<Q", data, at + 1)[0]
    return attributes[b"channels"], attributes[b"dataWindow"], data[first:]


a, b = chunks_of(sys.argv[1]), chunks_of(sys.argv[2])
if a != b:
    sys.exit(f"{sys.argv[1]} and {sys.argv[2]} differ: channels {a[0] != b[0]}, window {a[1] != b[1]}, "
             f"pixels {a[2] != b[2]}")
if len(a[2]) < 1000:
    sys.exit(f"{sys.argv[1]} holds next to nothing")
