#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""peers.csv as a picture: error against time, both logarithmic, a panel for each asset and kind of time.

    tests/tools/bench/peers_plot.py peers.csv peers.svg

Each tool has a colour of its own (of the palettes by Okabe and Ito and by Tol, which the colour-blind tell apart) and a
shape. All settings are drawn; a line joins those that no other setting of the tool beats in both error and time.
"""
import csv
import math
import sys
from html import escape

WIDTH, HEIGHT = 420, 300  # of a panel, within its axes
LEFT, TOP, GAP, BOTTOM = 70, 100, 56, 50
TOOLS = {"scrim": ("Scrim", "#0072B2", "circle"), "vdb_render": ("vdb_render", "#D55E00", "square"),
         "cycles 3": ("Cycles of Blender 3", "#882255", "diamond"),
         "cycles 4": ("Cycles of Blender 4", "#CC79A7", "diamond"),
         "cycles 5": ("Cycles of Blender 5", "#AA4499", "down"), "mitsuba": ("Mitsuba 3", "#56B4E9", "up"),
         "luxcore": ("LuxCore", "#999933", "square"), "light volume": ("dense marcher, light volume", "#009E73", "up"),
         "shadow rays": ("dense marcher, shadow rays", "#000000", "down"),
         "sweep": ("dense marcher, swept light", "#E69F00", "right")}
TIMES = {"render_seconds": "seconds to render, as each tool says",
         "process_seconds": "seconds of the whole program, with start, loading and writing"}
SHAPES = {"square": [(-4, -4), (4, -4), (4, 4), (-4, 4)], "diamond": [(0, -5.5), (5.5, 0), (0, 5.5), (-5.5, 0)],
          "up": [(0, -5), (5, 4), (-5, 4)], "down": [(0, 5), (5, -4), (-5, -4)],
          "right": [(5, 0), (-4, 5), (-4, -5)]}


def marker(x, y, shape, colour, title=""):
    inner = f"<title>{escape(title)}</title>" if title else ""
    look = f'fill="{colour}" fill-opacity="0.55" stroke="{colour}"'
    if shape == "circle":
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4.5" {look}>{inner}</circle>'
    points = " ".join(f"{x + dx:.1f},{y + dy:.1f}" for dx, dy in SHAPES[shape])
    return f'<polygon points="{points}" {look}>{inner}</polygon>'


def text(x, y, words, anchor="middle", more=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" {more}>{escape(words)}</text>'


class Axis:
    """A logarithmic scale from data to pixels, with ticks at 1, 2 and 5 times powers of ten."""

    def __init__(self, values, begin, end):
        low, high = math.log10(min(values) / 1.15), math.log10(max(values) * 1.15)
        self.begin, self.low, self.scale = begin, low, (end - begin) / (high - low)
        decades = range(math.floor(low), math.ceil(high) + 1)
        self.ticks = [m * 10.0**d for d in decades for m in (1, 2, 5) if low <= math.log10(m * 10.0**d) <= high]

    def __call__(self, value):
        return self.begin + (math.log10(value) - self.low) * self.scale


def front(points):
    """Those (time, error, ...) that no other beats in both, by time."""
    best, chosen = math.inf, []
    for point in sorted(points):
        if point[1] < best:
            best = point[1]
            chosen.append(point)
    return chosen


def panel(rows, time, x0, y0, x, y, title, last):
    out = [f'<rect x="{x0}" y="{y0}" width="{WIDTH}" height="{HEIGHT}" fill="none" stroke="#888"/>',
           text(x0, y0 - 8, title, "start", 'font-weight="bold"')]
    for tick in x.ticks:
        out.append(f'<line x1="{x(tick):.1f}" y1="{y0}" x2="{x(tick):.1f}" y2="{y0 + HEIGHT}" stroke="#ddd"/>')
        out.append(text(x(tick), y0 + HEIGHT + 16, f"{tick:g}"))
    for tick in y.ticks:
        out.append(f'<line x1="{x0}" y1="{y(tick):.1f}" x2="{x0 + WIDTH}" y2="{y(tick):.1f}" stroke="#ddd"/>')
        out.append(text(x0 - 6, y(tick) + 4, f"{100 * tick:g} %", "end"))
    if last:
        out.append(text(x0 + WIDTH / 2, y0 + HEIGHT + 36, TIMES[time]))
    for tool, (_, colour, shape) in TOOLS.items():
        points = [(float(r[time]), float(r["error"]), r["setting"]) for r in rows if r["tool"] == tool and r[time]]
        line = " ".join(f"{x(t):.1f},{y(e):.1f}" for t, e, _ in front(points))
        out.append(f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="1.5"/>')
        out += [marker(x(t), y(e), shape, colour, f"{tool}, {setting}: {100 * e:.2f} %, {t:g} s") for t, e, setting in points]
    return out


def plot(csv_file, svg_file):
    with open(csv_file, newline="") as file:
        rows = list(csv.DictReader(file))
    assets = list(dict.fromkeys(r["asset"] for r in rows))
    width = LEFT + len(TIMES) * (WIDTH + LEFT) - LEFT + 20
    height = TOP + len(assets) * (HEIGHT + GAP) - GAP + BOTTOM
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
           'font-family="sans-serif" font-size="12">', "<!-- SPDX-License-Identifier: Apache-2.0 -->",
           f'<rect width="{width}" height="{height}" fill="white"/>',
           text(LEFT, 24, "Relative RMSE against brute force, over time: lower and further left is better", "start",
                'font-size="15" font-weight="bold"')]
    at, line = LEFT, 44
    for tool, (name, colour, shape) in TOOLS.items():
        if any(r["tool"] == tool for r in rows):
            if at + 36 + 6.3 * len(name) > width:
                at, line = LEFT, line + 20
            out += [marker(at + 6, line, shape, colour), text(at + 17, line + 4, name, "start")]
            at += 36 + 6.3 * len(name)
    for column, time in enumerate(TIMES):
        x0 = LEFT + column * (WIDTH + LEFT)
        x = Axis([float(r[time]) for r in rows if r[time]], x0, x0 + WIDTH)
        for line, asset in enumerate(assets):
            y0 = TOP + line * (HEIGHT + GAP)
            of_asset = [r for r in rows if r["asset"] == asset]
            y = Axis([float(r["error"]) for r in of_asset], y0 + HEIGHT, y0)
            title = f"{asset}, {int(of_asset[0]['voxels']) / 1e6:.2f} M voxels"
            out += panel(of_asset, time, x0, y0, x, y, title, line == len(assets) - 1)
    with open(svg_file, "w") as file:
        file.write("\n".join(out + ["</svg>"]) + "\n")


if __name__ == "__main__":
    plot(*sys.argv[1:])
