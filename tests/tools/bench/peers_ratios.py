#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""At what render time each tool of peers.csv has the same error, and how many times Scrim's that is.

    tests/tools/bench/peers_ratios.py peers.csv [peers_check.csv]      (Markdown, a table for each asset)

Between the settings that no other beats in both error and time, logarithms are interpolated; beyond the coarsest its
time counts. Beyond the finest those without noise have none. Of those that draw at random, time grows linearly, and
noise falls as samples^-p: 1 / sqrt(samples), or faster where it did between the fewest and the most that were measured,
which samples that are spread evenly (Cycles') do. `~` stands before such a time, beyond what was measured, `>` where it
would be more than 10 times as long as anything measured. Of all ways to render (steps, integrators) the fastest
counts. What peers_check.py found in common to two seeds, where it is
more than that script's own noise, is an error that stays: what is left of the error for noise is sqrt(error^2 -
bias^2).
"""
import csv
import math
import re
import sys

ERRORS = (0.05, 0.02, 0.01, 0.005)
FAR = 10  # times the longest that was measured: an extrapolation beyond says no more than "more"


def read(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def front(points):
    """Those (time, error) that no other beats in both, by time."""
    chosen = []
    for time, error in sorted(points):
        if not chosen or error < chosen[-1][1]:
            chosen.append((time, error))
    return chosen


def interpolated(points, error):
    """(time, whether it is beyond what was measured) or None."""
    points = front(points)
    if error >= points[0][1]:
        return points[0][0], False
    for (t0, e0), (t1, e1) in zip(points, points[1:]):
        if e1 <= error:
            part = math.log(error / e0) / math.log(e1 / e0)
            return t0 * (t1 / t0)**part, False
    return None


def power(points):
    """p of one way to render, of (samples, time, error)."""
    (few, _, most_error), *_, (many, _, least_error) = points
    return min(1.0, max(0.5, math.log(most_error / least_error) / math.log(many / few)))


def of_samples(points, bias, error):
    """As `interpolated`, of (samples, time, error) of one way to render."""
    points = sorted(points)
    measured = interpolated([p[1:] for p in points], error)
    if measured or error <= bias or len(points) < 2:
        return measured
    most, time, least = points[-1]
    left = math.sqrt(max(least**2 - bias**2, 0.25 * least**2))
    samples = most * (left / math.sqrt(error**2 - bias**2))**(1 / power(points))
    return time + (time - points[-2][1]) / (most - points[-2][0]) * (samples - most), True


def ways(rows):
    """{way: [(samples, time, error)]} of a tool that draws at random, {} of one that does not."""
    found = {}
    for r in rows:
        match = re.fullmatch(r"samples (\d+) (.+)", r["setting"])
        if match:
            found.setdefault(match[2], []).append((int(match[1]), float(r["render_seconds"]), float(r["error"])))
    return found


def time_of(rows, tool, biases, error):
    mine = [r for r in rows if r["tool"] == tool]
    random = ways(mine)
    if not random:
        return interpolated([(float(r["render_seconds"]), float(r["error"])) for r in mine], error)
    # What stops early has no fixed relation of samples to noise.
    times = [of_samples(points, biases.get((tool, way), 0), error) for way, points in random.items()
             if "adaptive" not in way]
    return min(filter(None, times), default=None)


def powers(rows):
    """How noise fell, as words."""
    said = [f"{tool}, {way}: {power(sorted(points)):.2f}" for tool in dict.fromkeys(r["tool"] for r in rows)
            for way, points in ways([r for r in rows if r["tool"] == tool]).items() if len(points) > 1]
    return "p: " + "; ".join(said) if said else ""


def seconds(value):
    return f"{1000 * value:.0f} ms" if value < 1 else f"{value:.2g} s" if value < 100 else f"{round(value, -2):.0f} s"


def cell(found, own, most):
    """(time, extrapolated?) beside Scrim's; times beyond `most` are not told."""
    if not found:
        return "-"
    time = min(found[0], most)
    ratio = f" ({float(f'{time / own[0]:.2g}'):g} x)" if own else ""
    return ("> " if time < found[0] else "~ " if found[1] else "") + seconds(time) + ratio


def table(rows, biases):
    tools = list(dict.fromkeys(r["tool"] for r in rows))
    own = [time_of(rows, "scrim", biases, e) for e in ERRORS]
    print(f"\n{rows[0]['asset']}\n\n| error | " + " | ".join(f"{100 * e:g} %" for e in ERRORS) + " |")
    print("| --- |" + " --- |" * len(ERRORS))
    for tool in tools:
        cells = []
        for error, mine in zip(ERRORS, own):
            cells.append(cell(time_of(rows, tool, biases, error), mine if tool != "scrim" else None,
                              FAR * max(float(r["render_seconds"]) for r in rows if r["tool"] == tool)))
        print(f"| {tool} | " + " | ".join(cells) + " |")
    print(f"\n{powers(rows)}")


def main(peers_csv, check_csv=None):
    checked = read(check_csv) if check_csv else []
    biases = {}
    for r in checked:  # of more than one the one with most samples, which comes last
        bias = float(r["bias"])
        biases[r["tool"], r["how"]] = bias if bias > float(r["noise"]) else 0
    rows = read(peers_csv)
    for asset in dict.fromkeys(r["asset"] for r in rows):
        table([r for r in rows if r["asset"] == asset], biases)


if __name__ == "__main__":
    main(*sys.argv[1:])
