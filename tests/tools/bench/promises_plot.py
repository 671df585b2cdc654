# SPDX-License-Identifier: Apache-2.0
"""The rows of promises.py as a picture: error over promise, and time over the least time that would have done."""
from peers_plot import BOTTOM, HEIGHT, LEFT, TOP, WIDTH, Axis, marker, text

PRESETS = {"draft": ("#009E73", "up"), "standard": ("#0072B2", "circle"), "high": ("#D55E00", "square"),
           "ultra": ("#CC79A7", "diamond")}


def panel(points, x0, title, x_title, y_title, percent):
    """`points`: (x, y, preset, words). Below the diagonal, y is no more than x."""
    values = [v for p in points for v in p[:2]]
    x, y = Axis(values, x0, x0 + WIDTH), Axis(values, TOP + HEIGHT, TOP)
    unit = (lambda v: f"{100 * v:g} %") if percent else (lambda v: f"{v:g}")
    ticks = [t for t in x.ticks if len(x.ticks) < 12 or f"{t:e}"[0] == "1"]
    out = [f'<rect x="{x0}" y="{TOP}" width="{WIDTH}" height="{HEIGHT}" fill="none" stroke="#888"/>',
           text(x0, TOP - 8, title, "start", 'font-weight="bold"')]
    for tick in ticks:
        out.append(f'<line x1="{x(tick):.1f}" y1="{TOP}" x2="{x(tick):.1f}" y2="{TOP + HEIGHT}" stroke="#ddd"/>')
        out.append(f'<line x1="{x0}" y1="{y(tick):.1f}" x2="{x0 + WIDTH}" y2="{y(tick):.1f}" stroke="#ddd"/>')
        out.append(text(x(tick), TOP + HEIGHT + 16, unit(tick)))
        out.append(text(x0 - 6, y(tick) + 4, unit(tick), "end"))
    out.append(f'<line x1="{x0}" y1="{TOP + HEIGHT}" x2="{x0 + WIDTH}" y2="{TOP}" stroke="#444" '
               'stroke-dasharray="4 3"/>')
    out.append(text(x0 + WIDTH / 2, TOP + HEIGHT + 36, x_title))
    out.append(text(x0 + 8, TOP + 18, y_title, "start"))
    return out + [marker(x(a), y(b), *reversed(PRESETS[preset]), words) for a, b, preset, words in points]


def plot(rows, svg_file):
    errors = [(r["promise"], max(r["error"], 1e-6), r["preset"],
               f"{r['scene']}, {r['asset']}, {r['preset']}: {100 * r['error']:.3g} %") for r in rows]
    times = [(r["best_seconds"], r["seconds"], r["preset"],
              f"{r['scene']}, {r['asset']}, {r['preset']}: {r['seconds']:.3g} s, {r['best_seconds']:.3g} s with "
              f"{r['best_setting']}") for r in rows if r["best_seconds"]]
    gap = LEFT + 20
    width, height = LEFT + 2 * WIDTH + gap + 20, TOP + HEIGHT + BOTTOM
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
           'font-family="sans-serif" font-size="12">', "<!-- SPDX-License-Identifier: Apache-2.0 -->",
           f'<rect width="{width}" height="{height}" fill="white"/>',
           text(LEFT, 24, f"Presets in {len({r['scene'] for r in rows})} scenes by lot", "start",
                'font-size="15" font-weight="bold"')]
    at = LEFT
    for preset, (colour, shape) in PRESETS.items():
        out += [marker(at + 6, 52, shape, colour), text(at + 17, 56, preset, "start")]
        at += 90
    out += panel(errors, LEFT, "Error: kept below the diagonal", "promise", "measured", True)
    if times:
        out += panel(times, LEFT + WIDTH + gap, "Time: the nearer to the diagonal, the better",
                     "seconds of the best setting that keeps the promise", "seconds of the preset", False)
    svg_file.write_text("\n".join(out + ["</svg>"]) + "\n")
