#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws the slides of the paper's scenes, as small PNG files beside this script. Needs Python alone.

Each slide is a function of a point (x, y), both from -1 to 1, y up, that returns linear red, green and blue; it is
sampled 4 x 4 times a pixel and stored as sRGB.
"""
import math
import os
import struct
import zlib

SIZE = 256
BLACK, WHITE = (0, 0, 0), (1, 1, 1)


def grid(x, y):
    """Dark lines on white: ten cells across (hipip_grid, ZC02 Fig. 1d and 10)."""
    cell = [abs((5 * t + 0.5) % 1 - 0.5) for t in (x, y)]
    return (0.04, 0.04, 0.04) if min(cell) < 0.07 else WHITE


def rings(x, y):
    """Red and green rings by turns (slide_rings, ZC02 Fig. 14)."""
    ring = 7 * math.hypot(x, y)
    if ring > 6.5 or ring % 1 < 0.25:
        return BLACK
    return (1, 0.06, 0.04) if int(ring) % 2 == 0 else (0.05, 0.9, 0.1)


def beams(x, y):
    """Three round holes, one a colour (beams, ZC02 Fig. 16)."""
    for height, colour in ((0.5, (1, 0.04, 0.03)), (0, (0.03, 1, 0.05)), (-0.5, (0.05, 0.12, 1))):
        if math.hypot(x, y - height) < 0.15:
            return colour
    return BLACK


def beam(x, y):
    """One round hole (perpendicular, ZC02 Fig. 19)."""
    return WHITE if math.hypot(x, y) < 0.9 else BLACK


LETTERS = {
    "S": (".###.", "#...#", "#....", ".###.", "....#", "#...#", ".###."),
    "C": (".###.", "#...#", "#....", "#....", "#....", "#...#", ".###."),
    "R": ("####.", "#...#", "#...#", "####.", "#.#..", "#..#.", "#...#"),
    "I": (".###.", "..#..", "..#..", "..#..", "..#..", "..#..", ".###."),
    "M": ("#...#", "##.##", "#.#.#", "#.#.#", "#...#", "#...#", "#...#"),
}


def logo(x, y):
    """Scrim's sign, a sheet of gauze in folds under its name, in a red ring on white (slide_logo, ZC02 Fig. 15)."""
    red, ink = (0.75, 0.02, 0.02), (0.03, 0.03, 0.05)
    r = math.hypot(x, y)
    if r > 0.97:
        return WHITE
    if r > 0.84:
        return red
    column, row = math.floor((x + 0.725) / 0.05), math.floor((0.28 - y) / 0.05 / 1.15)
    if 0 <= column < 29 and 0 <= row < 7:
        letter, inside = divmod(column, 6)
        if inside < 5 and LETTERS["SCRIM"[letter]][row][inside] == "#":
            return ink
    fold = 0.07 * math.sin(9 * x)
    for height in (0.56, 0.44, -0.3, -0.42, -0.54):
        if abs(y - height - fold) < 0.025 and abs(x) < math.sqrt(max(0, 0.6 - height * height)) - 0.06:
            return red
    return WHITE


def srgb(v):
    return 12.92 * v if v <= 0.0031308 else 1.055 * v ** (1 / 2.4) - 0.055


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def draw(slide):
    samples = [(i + 0.5) / 4 for i in range(4)]
    rows = bytearray()
    for j in range(SIZE):
        rows.append(0)  # the row is not filtered
        for i in range(SIZE):
            total = [0.0, 0.0, 0.0]
            for v in samples:
                for u in samples:
                    colour = slide(2 * (i + u) / SIZE - 1, 1 - 2 * (j + v) / SIZE)
                    total = [t + c for t, c in zip(total, colour)]
            rows.extend(round(255 * srgb(t / 16)) for t in total)
    header = struct.pack(">IIBBBBB", SIZE, SIZE, 8, 2, 0, 0, 0)
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), slide.__name__ + ".png")
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(bytes(rows), 9)))
        file.write(chunk(b"IEND", b""))


for each in (grid, rings, beams, beam, logo):
    draw(each)
