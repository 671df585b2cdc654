#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Do features cost more together than alone? Every kind of light on every medium, and beside every other feature.

    tests/tools/bench/pairs.py [--build DIR] [--only WORD]... [--timeout SECONDS] [--out FOLDER] [--least RATIO]

Needs a build (--build names another than build/), and makes its volumes with `scrim make`. A scene has one light, one
medium and at most one further feature (LIGHTS, MEDIA and FEATURES below), 160 x 120 pixels. What a scene should cost is
the dearer one of its parts: the same light on plain smoke, a sun on the same medium, a sun on plain smoke with the same
feature. Seconds are of the processor, of whole commands. --only keeps scenes whose names hold all of these words.

Prints all costs in Markdown, the media of a light first, and then what costs more than --least (default 3) times the
dearer of its parts, the worst first. A command that takes longer than --timeout (default 60) is ended, and counts as
that.
"""

import argparse
import json
import tempfile
from pathlib import Path

import shots
import shots_scenes

ROOT = Path(__file__).resolve().parents[3]


def light(kind, *keys):
    return f'[[light]]\nname = "l"\ntype = "{kind}"\n' + "".join(f"{key}\n" for key in keys) + "\n"


BESIDE, INSIDE, AT = "position = [60, 50, 40]", "position = [6, 4, -5]", "target = [0, 0, 0]"
SUN = "sun"
LIGHTS = {
    SUN: light("distant", "direction = [-1, -1, -0.5]", "intensity = 5"),
    "wide sun": light("distant", "direction = [-1, -1, -0.5]", "intensity = 5", "angle = 10"),
    "dome": light("dome", "intensity = 1"),
    "point beside": light("point", BESIDE, "intensity = 20000"),
    "point inside": light("point", INSIDE, "intensity = 500", "radius = 1"),
    "spot": light("spot", BESIDE, AT, "cone = 60", "intensity = 20000"),
    "projector": light("projector", BESIDE, AT, "intensity = 20000", 'slide = { file = "SLIDE" }'),
    "rectangle": light("area", 'shape = "rectangle"', "width = 50", "height = 50", BESIDE, AT, "intensity = 8"),
    "sphere beside": light("area", 'shape = "sphere"', "radius = 3", BESIDE, "intensity = 600"),
    "sphere inside": light("area", 'shape = "sphere"', "radius = 3", INSIDE, "intensity = 20"),
}

PLAIN = "smoke"
VOLUME = '[[volume]]\nname = "v"\nfile = "NOISE"\ndensity = { scale = 0.1 }\n'
MEDIA = {
    PLAIN: VOLUME,
    "coloured": VOLUME + "[volume.medium]\nalbedo = [0.9, 0.8, 0.7]\nextinction_tint = [1, 0.8, 0.6]\n",
    "droplets": VOLUME + '[volume.medium]\nphase = { type = "droplets", size = 12 }\n',
    "dense": VOLUME.replace("0.1", "0.6"),
    "octaves": VOLUME + "[volume.medium]\noctaves = { count = 8 }\n",
    "full": VOLUME + '[volume.medium]\nscattering = "full"\nalbedo = [0.9, 0.9, 0.9]\n',
    "scan": VOLUME.replace("0.1", "1") + "[volume.classified]\ntransfer = [{ value = 0.35, extinction = 0 }, "
            "{ value = 0.6, extinction = 1.5, color = [0.8, 0.6, 0.5] }]\n",
    "glowing": VOLUME + '[volume.medium]\nemission = { grid = "density", scale = 0.02 }\n',
}

NONE = ""
FEATURES = {
    NONE: "",
    "haze": '[[volume]]\nname = "haze"\nfile = "HAZE"\ndensity = { scale = 0.002 }\n',
    "fine ball": '[[volume]]\nname = "ball"\nfile = "BALL"\ndensity = { scale = 1 }\n'
                 "transform = { translate = [-20, 5, 30] }\n",
    "scan beside": '[[volume]]\nname = "scan"\nfile = "SMALL"\ntransform = { translate = [-20, 0, 25] }\n'
                   "density = { scale = 1 }\n[volume.classified]\ntransfer = [{ value = 0.35, extinction = 0 }, "
                   "{ value = 0.6, extinction = 1.5 }]\n",
    "droplets beside": '[[volume]]\nname = "drops"\nfile = "SMALL"\ntransform = { translate = [-20, 0, 25] }\n'
                       'density = { scale = 0.1 }\n[volume.medium]\nphase = { type = "droplets", size = 12 }\n',
    "full beside": '[[volume]]\nname = "full"\nfile = "SMALL"\ntransform = { translate = [-20, 0, 25] }\n'
                   'density = { scale = 0.1 }\n[volume.medium]\nscattering = "full"\n',
    "no shadow of one": '[[volume]]\nname = "other"\nfile = "SMALL"\ntransform = { translate = [-20, 0, 25] }\n'
                        "density = { scale = 0.1 }\nshadows = false\n",
    "solid": '[[mesh]]\nfile = "BLOCK"\n',
    "caught": '[[mesh]]\nfile = "BLOCK"\ncatch = true\nshadows = false\n',
    "layers": '[output]\nlayers = ["light", "emission", "ambient", "depth"]\n',
    "deep": '[output]\ndeep = "deep.exr"\n',
    "orthographic": "",
    "blur": "",
    "depth of field": "",
    "eye inside": "",
    "per view": '[render]\nsplat = "per-view"\n',
}
CAMERA = '[camera]\nposition = [40, 30, 130]\ntarget = [0, 0, 0]\nfov = 40\nresolution = [160, 120]\n'
CAMERAS = {
    "orthographic": '[camera]\ntype = "orthographic"\nheight = 80\nposition = [40, 30, 130]\ntarget = [0, 0, 0]\n'
                    "resolution = [160, 120]\n",
    "blur": CAMERA.replace("[40, 30, 130]", "{ keys = [[0, [40, 30, 130]], [2, [44, 30, 130]]] }")
            + "shutter = [-0.25, 0.25]\n",
    "depth of field": CAMERA + "lens_radius = 0.6\nfocus_distance = 120\n",
    "eye inside": CAMERA.replace("[40, 30, 130]", "[10, 8, 20]"),
}


class Bench:
    """Renders scenes in a folder, each once."""

    def __init__(self, build, folder, timeout):
        self.scrim, self.folder, self.timeout = build / "bin" / "scrim", folder, timeout
        assets = shots_scenes.Assets(self.scrim, folder)
        self.files = {
            "NOISE": assets.make("noise", "noise", shape="ball", resolution=72, size=72, density=1),
            "SMALL": assets.make("small", "noise", shape="ball", resolution=24, size=24, density=1),
            "HAZE": assets.make("haze", "noise", shape="box", resolution=30, size=300, density=1, turbulence=0.3),
            "BALL": assets.make("ball", "noise", shape="ball", resolution=40, size=4, density=1),
            "SLIDE": self.slide(), "BLOCK": self.block()}
        self.costs = {}

    def slide(self):
        path = self.folder / "slide.ppm"
        path.write_text("P3 8 8 255\n" + " ".join("255 240 220" if (i + i // 8) % 2 else "40 60 90" for i in range(64)))
        return path

    def block(self):
        path = self.folder / "block.obj"
        corners = [(30 + 8 * (i & 1), 20 + 8 * (i >> 1 & 1), 10 + 8 * (i >> 2 & 1)) for i in range(8)]
        faces = ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"]
        path.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "".join(f"f {f}\n" for f in faces))
        return path

    def cost(self, lit, medium, feature):
        name = "-".join(word.replace(" ", "_") for word in (lit, medium, feature or "alone"))
        if name not in self.costs:
            text = CAMERAS.get(feature, CAMERA) + "\n" + LIGHTS[lit] + MEDIA[medium] + "\n" + FEATURES[feature]
            for word, path in self.files.items():
                text = text.replace(word, str(path))
            scene = self.folder / f"{name}.toml"
            scene.write_text(text)
            command = [self.scrim, "render", scene, "-o", scene.with_suffix(".exr"), "-q"]
            self.costs[name] = shots.run(command, scene.with_suffix(".log"), self.timeout)
            print(f"{name}: {self.costs[name].processor:.2f} s, {self.costs[name].memory:.0f} MB "
                  f"{self.costs[name].failure}", flush=True)
        return self.costs[name]

    def ratio(self, lit, medium, feature):
        """Of a scene to the dearer one of its parts. Every command starts, which is no part of either."""
        start = self.cost(SUN, PLAIN, NONE).processor / 2
        parts = [self.cost(lit, PLAIN, NONE), self.cost(SUN, medium, NONE), self.cost(SUN, PLAIN, feature)]
        return self.cost(lit, medium, feature).processor / max(start, *(part.processor for part in parts))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=Path, default=ROOT / "build")
    parser.add_argument("--only", action="append", default=[])
    parser.add_argument("--timeout", type=float, default=60)
    parser.add_argument("--least", type=float, default=3)
    parser.add_argument("--out", type=Path)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = args.out or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        bench = Bench(args.build, folder.resolve(), args.timeout)
        scenes = [(lit, medium, NONE) for lit in LIGHTS for medium in MEDIA]
        scenes += [(lit, PLAIN, feature) for lit in LIGHTS for feature in FEATURES if feature]
        scenes += [(SUN, medium, feature) for medium in MEDIA if medium != PLAIN for feature in FEATURES if feature]
        scenes = [scene for scene in scenes if all(word in " ".join(scene) for word in args.only)]
        found = sorted(((bench.ratio(*scene), scene) for scene in scenes), reverse=True)
        costs = {name: vars(cost) for name, cost in bench.costs.items()}
        (folder / "pairs.json").write_text(json.dumps(costs, indent=1))
        print("\n| times | light | medium | with | s |\n| --- | --- | --- | --- | --- |")
        for ratio, scene in found:
            if ratio >= args.least or bench.cost(*scene).failure:
                cost = bench.cost(*scene)
                print(f"| {ratio:.1f} | {' | '.join(scene)} | {cost.processor:.2f} {cost.failure} |")


if __name__ == "__main__":
    main()
