# SPDX-License-Identifier: Apache-2.0
# The picture while it is rendered. `scrim render --display-server` sends it to a viewer that listens, by the protocol
# of tev; this is such a viewer, for one program.
import socket
import struct
import threading

import numpy as np

CREATE, UPDATE = 4, 6
HEADER = struct.Struct("<IB")
MOST_BYTES = 1 << 26  # of a packet: the program's tiles take 262,144


class SoFar:
    """Listens on a port of this machine until it is closed. Whatever is sent there that is no picture ends it."""

    def __init__(self):
        self._lock = threading.Lock()
        self._pixels, self._changed = None, False
        self._server = socket.create_server(("127.0.0.1", 0))
        self.address = "127.0.0.1:%d" % self._server.getsockname()[1]
        threading.Thread(target=self._listen, daemon=True).start()

    def take(self):
        """Red, green, blue and alpha, rows from the top, if there is news; else None."""
        with self._lock:
            if not self._changed:
                return None
            self._changed = False
            return self._pixels.copy()

    def close(self):
        try:
            self._server.shutdown(socket.SHUT_RDWR)  # or the thread would wait for a program that never came
        except OSError:
            pass
        self._server.close()

    def _listen(self):
        try:
            connection, _ = self._server.accept()
            with connection, connection.makefile("rb") as stream:
                while len(head := stream.read(HEADER.size)) == HEADER.size:
                    size, kind = HEADER.unpack(head)
                    if not HEADER.size <= size <= MOST_BYTES:
                        return
                    self._hear(kind, _Packet(stream.read(size - HEADER.size)))
        except (OSError, ValueError, struct.error):
            pass

    def _hear(self, kind, packet):
        packet.numbers("B", 1)  # whether to come to the front
        packet.text()
        if kind == CREATE:
            width, height = packet.numbers("i", 2)
            with self._lock:
                self._pixels = np.zeros((height, width, 4), np.float32)
        elif kind == UPDATE and self._pixels is not None:
            for _ in range(packet.numbers("i", 1)[0]):
                packet.text()  # R, G, B, A
            x, y, width, height = packet.numbers("i", 4)
            packet.numbers("q", 8)  # where each channel begins, and its stride: pixel by pixel
            with self._lock:
                self._pixels[y : y + height, x : x + width] = packet.floats().reshape(height, width, 4)
                self._changed = True


class _Packet:
    def __init__(self, data):
        self._data, self._at = data, 0

    def numbers(self, form, count):
        values = struct.unpack_from(f"<{count}{form}", self._data, self._at)
        self._at += struct.calcsize(f"<{count}{form}")
        return values

    def text(self):
        end = self._data.index(b"\0", self._at)
        text, self._at = self._data[self._at : end], end + 1
        return text

    def floats(self):
        return np.frombuffer(self._data, "<f4", offset=self._at)
