#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The look of multiple scattering: Scrim's octaves beside a path tracer with many bounces.

    tests/tools/bench/octaves.py ASSET.vdb --work DIR [--density X] [--g G] [--albedo A] [--samples N] [--bounces N]...
                                 [--fit] [--octaves COUNT,EXTINCTION,CONTRIBUTION,PHASE]... [--jpg FILE]

Needs a build (SCRIM_BUILD names it), Blender for Cycles, and ImageMagick for --jpg. The scene is the asset as
`scrim render ASSET` frames it, --density times as dense, in a black world under one sun, from two sides: `front`, as
the framing's key light stands, and `back`, behind the volume. Cycles renders each view with every number of --bounces
after the first scattering (0 is single scattering: there Scrim must agree, or the two do not render the same scene),
each twice with different seeds. The mean of the two is what counts, half of what they differ by is its noise. Pictures
of Cycles that lie in DIR are not rendered anew.

Prints a table: relative RMSE (RMS of the difference over mean of the reference, as `scrim render --verify` has it) of
8 x 8 blocks of those pixels whose alpha exceeds 1e-3, since blocks have less noise than pixels, the ratio of mean
brightness to that of the reference, and the seconds of rendering alone. --fit searches the octaves' three factors, with
contribution <= extinction, so that the error on one view is least, and tells the error on the other; then on both; and
`freely`, on both without that limit. octaves.jpg among the examples is that of

    tests/tools/bench/octaves.py wdas_cloud_sixteenth.vdb --work DIR --samples 192 --bounces 0 --bounces 128 --fit \
                                 --jpg FILE
"""
import argparse
import array
import json
import math
import os
import re
import struct
import subprocess
import tomllib
from pathlib import Path

HERE = Path(__file__).resolve().parent
BIN = Path(os.environ.get("SCRIM_BUILD", HERE.parents[2] / "build")) / "bin"
BLOCK = 8          # pixels
OPAQUE = 1e-3      # least alpha of a pixel that counts
BACK_HEIGHT = 25   # degrees of the sun behind the volume above the line of sight: it lights the edge, not the lens
DEFAULTS = (8, 0.5, 0.5, 0.5)  # octaves, their extinction, contribution and phase
COUNTS = (8, 16)   # of octaves that are fitted
SEEDS = (1, 2)
MARGIN, TILE = 5, 320  # pixels about what is shown, and across it when it is shown
SHOWN = ("16 fitted to both", "8 fitted freely")  # beside the default
WHITE = 0.995      # part of the reference's pixels that no picture clips


# ---- pictures: rows of red and alpha, all scenes are grey

class Picture:
    def __init__(self, width, height, red, alpha):
        self.width, self.height, self.red, self.alpha = width, height, red, alpha


def read_exr(path):
    """An uncompressed scan-line EXR of floats, filled up to its display window."""
    data = Path(path).read_bytes()
    at, attributes = 8, {}
    while data[at]:
        name, kind = (data[at:].split(b"\0", 2)[:2])
        at += len(name) + len(kind) + 2
        size, = struct.unpack_from("<i", data, at)
        attributes[name.decode()] = data[at + 4:at + 4 + size]
        at += 4 + size
    channels, rest = [], attributes["channels"]
    while rest[0]:
        name, rest = rest.split(b"\0", 1)
        kind, = struct.unpack_from("<i", rest)
        if kind != 2 or attributes["compression"] != b"\0":
            raise SystemExit(f"{path}: expected uncompressed floats")
        channels.append(name.decode().split(".")[-1])
        rest = rest[16:]
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    dx0, dy0, dx1, dy1 = struct.unpack("<4i", attributes["displayWindow"])
    width, height, row = dx1 - dx0 + 1, dy1 - dy0 + 1, x1 - x0 + 1
    planes = {"R": array.array("f", bytes(4 * width * height)), "A": array.array("f", bytes(4 * width * height))}
    for offset in struct.unpack_from(f"<{y1 - y0 + 1}Q", data, at + 1):
        y, _ = struct.unpack_from("<2i", data, offset)
        for name, plane in planes.items():
            begin = offset + 8 + 4 * row * channels.index(name)
            to = (y - dy0) * width + x0 - dx0
            plane[to:to + row] = array.array("f", data[begin:begin + 4 * row])
    return Picture(width, height, planes["R"], planes["A"])


def mean_of(pictures):
    first = pictures[0]
    red = array.array("f", (sum(values) / len(pictures) for values in zip(*(p.red for p in pictures))))
    return Picture(first.width, first.height, red, first.alpha)


def blocks(picture, alpha):
    """(pixels, mean red of them) of every block that has pixels of `alpha` that count."""
    sums = {}
    for i, (red, a) in enumerate(zip(picture.red, alpha)):
        if a > OPAQUE:
            key = (i % picture.width // BLOCK, i // picture.width // BLOCK)
            count, total = sums.get(key, (0, 0.0))
            sums[key] = (count + 1, total + red)
    return [(count, total / count) for _, (count, total) in sorted(sums.items())]


def block_centres(alpha, width):
    """Where these blocks are, from -1 to 1, y up."""
    keys = {(i % width // BLOCK, i // width // BLOCK) for i, a in enumerate(alpha) if a > OPAQUE}
    return [((2 * x + 1) * BLOCK / width - 1, 1 - (2 * y + 1) * BLOCK / width) for x, y in sorted(keys)]


def error(picture, reference, alpha):
    """Relative RMSE of blocks, and the ratio of means."""
    pairs = list(zip(blocks(picture, alpha), blocks(reference, alpha)))
    pixels = sum(count for (count, _), _ in pairs)
    mean = sum(count * r for (count, _), (_, r) in pairs) / pixels
    square = sum(count * (p - r)**2 for (count, p), (_, r) in pairs) / pixels
    return math.sqrt(square) / mean, sum(count * p for (count, p), _ in pairs) / pixels / mean


# ---- the scene, for both

def unit(v):
    return [c / math.hypot(*v) for c in v]


def camera_axes(look):
    """To the right and up in the picture, where y is up in the world."""
    right = unit([-look[2], 0, look[0]])
    return right, [right[1] * look[2] - right[2] * look[1], right[2] * look[0] - right[0] * look[2],
                   right[0] * look[1] - right[1] * look[0]]


def frame(options):
    """What both render, as numbers: those of peers.py, and `views`, the sun's direction of travel in each."""
    def scrim(*arguments):
        return subprocess.run([BIN / "scrim", *arguments], check=True, stdout=subprocess.PIPE, text=True).stdout

    scene = tomllib.loads(scrim("render", options.asset, "--print-scene"))
    grid = json.loads(scrim("info", "--json", options.asset))["grids"][0]
    camera, key = scene["camera"], scene["light"][0]
    look = unit([t - p for t, p in zip(camera["target"], camera["position"])])
    _, up = camera_axes(look)
    height = math.radians(BACK_HEIGHT)
    back = [-math.cos(height) * l - math.sin(height) * u for l, u in zip(look, up)]
    return {"asset": str(Path(options.asset).resolve()), "grid": grid["name"], "eye": camera["position"], "look": look,
            "target": camera["target"], "fov": camera["fov"], "resolution": [options.pixels, options.pixels],
            "scale": scene["volume"][0]["density"]["scale"] * options.density, "voxel": grid["voxel_size"][0],
            "albedo": options.albedo, "g": options.g, "irradiance": math.pi,
            "views": {"front": unit(key["direction"]), "back": back}}


class Scrim:
    """Renders a view with some octaves."""

    def __init__(self, numbers, options):
        self.numbers, self.work, self.cache = numbers, options.work, {}
        self.options = ["--threads", str(options.threads), "--quality", options.quality, "-q"]

    def render(self, view, octaves, g=None):
        """The picture and the seconds it took; no octaves: single scattering; no g: that of the scene."""
        key = view, octaves, g
        if key in self.cache:
            return self.cache[key]
        n = self.numbers
        g = n["g"] if g is None else g
        octaves = "" if octaves is None else (
            "octaves = {{ count = {}, extinction = {}, contribution = {}, phase = {} }}\n".format(*octaves))
        scene, picture, stats = (self.work / name for name in ("scene.toml", "scrim.exr", "stats.json"))
        scene.write_text(
            f"[camera]\nposition = {n['eye']}\ntarget = {n['target']}\nfov = {n['fov']}\n"
            f"resolution = {n['resolution']}\n"
            f"[[volume]]\nfile = \"{n['asset']}\"\ndensity = {{ scale = {n['scale']} }}\n"
            f"[volume.medium]\nalbedo = {3 * [n['albedo']]}\nphase = {{ type = \"hg\", g = {g} }}\n{octaves}"
            f"[[light]]\nname = \"sun\"\ntype = \"distant\"\ndirection = {n['views'][view]}\n"
            f"intensity = {n['irradiance']}\n[output]\ntype = \"float\"\ncompression = \"none\"\n")
        subprocess.run([BIN / "scrim", "render", scene, "-o", picture, "--stats", stats, *self.options], check=True)
        seconds = json.loads(stats.read_text())[0]["seconds"]
        result = read_exr(picture), seconds["plan"] + seconds["render"]
        self.cache[key] = result
        return result


def cycles(numbers, view, bounces, seed, options):
    """The picture and the seconds between Cycles' first sample and its last."""
    name = options.work / f"cycles_{view}_bounces{bounces}_seed{seed}"
    picture, log, given = (name.with_suffix(s) for s in (".exr", ".log", ".json"))
    text = json.dumps(numbers | {"light": numbers["views"][view], "bounces": bounces, "seed": seed,
                                 "samples": options.samples})
    if not picture.exists() or given.read_text() != text:
        given.write_text(text)
        with open(log, "w") as out:
            subprocess.run(["blender", "-b", "--factory-startup", "-t", str(options.threads), "-P",
                            HERE / "peers_cycles.py", "--", given, picture, str(options.samples), "1"], check=True,
                           stdout=out, stderr=subprocess.STDOUT)
        if not picture.exists():
            raise SystemExit(f"Cycles failed:\n{log.read_text()[-2000:]}")
    times = [60 * int(m) + float(s)
             for m, s in re.findall(r"Time:(\d+):(\d+\.\d+).* \| (?:Sample 0/|Finished)", log.read_text())]
    return read_exr(picture), times[-1] - times[0]


class PathTraced:
    """A view as Cycles has it, of all seeds."""

    def __init__(self, numbers, view, bounces, options):
        found = [cycles(numbers, view, bounces, seed, options) for seed in SEEDS]
        self.picture = mean_of([picture for picture, _ in found])
        self.seconds = sum(seconds for _, seconds in found)
        self.seeds = [picture for picture, _ in found]

    def noise(self, alpha):
        """Relative RMSE of the mean: half the difference of the two it is the mean of."""
        return error(self.seeds[0], self.seeds[1], alpha)[0] / 2


# ---- the search

class Octaves:
    """Blocks of a view for any octaves without rendering them, since a picture is linear in them: one octave is the
    isotropic picture with its extinction towards the light, times its phase function, which under a distant light is a
    number for each pixel. Tabulated over the square root of extinction."""

    STEPS = 24

    def __init__(self, scrim, view, alpha):
        n = scrim.numbers
        self.table = []
        for k in range(self.STEPS + 1):
            # Two octaves are single scattering and the one that is wanted.
            both, single = (scrim.render(view, (2, *factors), g=0)[0]
                            for factors in (((k / self.STEPS)**2, 1, 1), (1, 0, 1)))
            self.table.append([b - s for (_, b), (_, s) in zip(blocks(both, alpha), blocks(single, alpha))])
        self.cosines, self.g = [], n["g"]
        half = math.tan(math.radians(n["fov"] / 2))
        right, up = camera_axes(n["look"])
        for x, y in block_centres(alpha, n["resolution"][0]):
            ray = unit([l + half * (x * r + y * u) for l, r, u in zip(n["look"], right, up)])
            self.cosines.append(-sum(a * b for a, b in zip(n["views"][view], ray)))

    def __call__(self, count, extinction, contribution, phase):
        sums = [0.0] * len(self.cosines)
        for n in range(count):
            at = math.sqrt(extinction**n) * self.STEPS
            k = min(int(at), self.STEPS - 1)
            g = self.g * phase**n
            weight = contribution**n * (1 - g * g)
            for i, (low, high, c) in enumerate(zip(self.table[k], self.table[k + 1], self.cosines)):
                sums[i] += weight * (low + (at - k) * (high - low)) * (1 + g * g - 2 * g * c)**-1.5
        return sums


def fit(views, references, count, most_ratio=1.0):
    """The `count` octaves of least error (root of the mean square) to the blocks of `references`: a grid, refined about
    its best. Contribution is searched as its ratio to extinction, which is at most `most_ratio`."""
    def factors(extinction, ratio, phase):
        return extinction, min(extinction * ratio * most_ratio, 1), phase

    def cost(point):
        square = 0
        for octaves, reference in zip(views, references):
            pixels, total = sum(n for n, _ in reference), sum(n * r for n, r in reference)
            picture = octaves(count, *factors(*point))
            square += pixels * sum(n * (p - r)**2 for p, (n, r) in zip(picture, reference)) / total**2
        return square

    best, step, reach = (0.5, 0.5, 0.5), 0.125, 4
    while step > 0.004:
        lines = [[c + k * step for k in range(-reach, reach + 1) if 0 <= c + k * step <= 1] for c in best]
        best = min(((e, r, p) for e in lines[0] for r in lines[1] for p in lines[2]), key=cost)
        step, reach = step / 2, 2
    return count, *(round(c, 2) for c in factors(*best))


# ---- what is shown

def write_pgm(picture, exposure, path):
    """As 8-bit sRGB on black."""
    def encode(value):
        v = min(max(value * exposure, 0), 1)
        return round(255 * (12.92 * v if v <= 0.0031308 else 1.055 * v**(1 / 2.4) - 0.055))

    path.write_bytes(f"P5\n{picture.width} {picture.height}\n255\n".encode() + bytes(map(encode, picture.red)))


def side_by_side(rows, alpha, work, exposure, out):
    """`rows` of (title, picture), cut to what `alpha` covers."""
    width = rows[0][0][1].width
    covered = [(i % width, i // width) for i, a in enumerate(alpha) if a > OPAQUE]
    (x0, x1), (y0, y1) = ((min(c) - MARGIN, max(c) + 1 + MARGIN) for c in zip(*covered))
    tiles = []
    for row in rows:
        for title, picture in row:
            grey, tile = work / "grey.pgm", work / f"tile_{len(tiles)}.png"
            write_pgm(picture, exposure, grey)
            subprocess.run(["convert", grey, "-crop", f"{x1 - x0}x{y1 - y0}+{max(x0, 0)}+{max(y0, 0)}", "+repage",
                            "-filter", "Mitchell", "-resize", f"{TILE}x{TILE}", "-background", "#202020",
                            "-gravity", "South", "-splice", "0x24", "-fill", "white", "-font", "DejaVu-Sans",
                            "-pointsize", "14", "-annotate", "+0+4", title, tile], check=True)
            tiles.append(tile)
    subprocess.run(["montage", *tiles, "-tile", f"{len(rows[0])}x", "-geometry", "+2+2", "-background", "#202020",
                    "-quality", "85", out], check=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("asset", metavar="ASSET.vdb")
    parser.add_argument("--work", type=Path, required=True, metavar="DIR", help="for pictures; those there are used")
    parser.add_argument("--density", type=float, default=2, help="times that of the framing")
    parser.add_argument("--g", type=float, default=0.75, help="of the Henyey-Greenstein phase function")
    parser.add_argument("--albedo", type=float, default=1)
    parser.add_argument("--pixels", type=int, default=192, help="edge of the picture")
    parser.add_argument("--samples", type=int, default=64, help="of Cycles, for each of two seeds")
    parser.add_argument("--quality", default="high", help="of Scrim")
    parser.add_argument("--bounces", type=int, action="append", help="of Cycles; default: 0, 32, 64 and 128")
    parser.add_argument("--octaves", action="append", default=[], metavar="N,E,C,P", help="further octaves to compare")
    parser.add_argument("--fit", action="store_true", help="search the factors")
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--jpg", help="all pictures side by side")
    options = parser.parse_args()
    options.work.mkdir(parents=True, exist_ok=True)
    numbers = frame(options)
    views = list(numbers["views"])
    scrim = Scrim(numbers, options)
    single = {view: scrim.render(view, None)[0] for view in views}
    alphas = {view: single[view].alpha for view in views}
    print(f"{Path(options.asset).name}: extinction {numbers['scale']:.4g}, albedo {options.albedo:g}, g {options.g:g}, "
          f"{options.pixels} x {options.pixels} pixels")

    print(f"\n  {'Cycles, ' + str(len(SEEDS) * options.samples) + ' samples':<34}"
          + "".join(f"{view + ': mean':>14}{'noise %':>9}{'s':>8}" for view in views))
    traced = {}
    for bounces in options.bounces or [0, 32, 64, 128]:
        line = f"  {str(bounces) + ' bounces':<34}"
        for view in views:
            t = traced[view, bounces] = PathTraced(numbers, view, bounces, options)
            pairs = blocks(t.picture, alphas[view])
            mean = sum(count * red for count, red in pairs) / sum(count for count, _ in pairs)
            line += f"{mean:>14.5f}{100 * t.noise(alphas[view]):>9.2f}{t.seconds:>8.1f}"
        print(line, flush=True)

    most = max(bounces for _, bounces in traced)
    references = {view: traced[view, most].picture for view in views}
    settings = {}
    if options.fit:
        octaves = [Octaves(scrim, view, alphas[view]) for view in views]
        wanted = [blocks(references[view], alphas[view]) for view in views]
        for count in COUNTS:
            for i, view in enumerate(views):
                settings[f"{count} fitted to {view}"] = fit(octaves[i:i + 1], wanted[i:i + 1], count)
            settings[f"{count} fitted to both"] = fit(octaves, wanted, count)
            settings[f"{count} fitted freely"] = fit(octaves, wanted, count, most_ratio=2)
    for i, text in enumerate(options.octaves):
        settings[f"given, {i + 1}"] = (int(text.split(",")[0]), *map(float, text.split(",")[1:]))
    settings = {"default": DEFAULTS} | settings | {"single scattering": None}

    def row(name, setting, bounces):
        line = f"  {name:<50}"
        for view in views:
            picture, seconds = scrim.render(view, setting)
            e, ratio = error(picture, traced[view, bounces].picture, alphas[view])
            line += f"{view + ':':>8}{100 * e:>9.2f}{ratio:>8.3f}{seconds:>8.3f}"
        print(line, flush=True)

    columns = 8 * " " + f"{'error %':>9}{'mean':>8}{'s':>8}"
    print(f"\n  {'Scrim (octaves: extinction, contribution, phase)':<50}" + 2 * columns)
    if (views[0], 0) in traced:
        row("single scattering, beside 0 bounces", None, 0)
    print(f"  beside {most} bounces")
    for name, setting in settings.items():
        row(name + ("" if setting is None else " ({}: {:g}, {:g}, {:g})".format(*setting)), setting, most)

    if options.jpg:
        columns = [DEFAULTS, *(settings[name] for name in SHOWN if name in settings), None]
        names = ["Scrim, " + ("{} octaves {:g} {:g} {:g}".format(*c) if c else "single scattering") for c in columns]
        rows = [[(f"Cycles, {most} bounces, sun in {view}", references[view])]
                + [(name, scrim.render(view, c)[0]) for name, c in zip(names, columns)] for view in views]
        brightest = sorted(red for v in views for red in references[v].red)
        side_by_side(rows, alphas[views[0]], options.work, 1 / brightest[int(WHITE * len(brightest))], options.jpg)


if __name__ == "__main__":
    main()
