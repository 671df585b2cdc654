# SPDX-License-Identifier: Apache-2.0
"""Scenes by lot for promises.py: unlike assets, densities, lights, cameras and picture sizes.

Every asset is made a .vdb first, whose box then frames the camera. The n-th scene of a seed is always the same.
"""
import json
import math
import os
import random
import subprocess
from pathlib import Path

SHAPES = ("sphere radius=0.8 center=-0.3,0,0; box size=0.5,1.6,0.4 center=0.6,0,0.3 rotate=0,30,20; "
          "torus center=0,0,0 axis=0.3,1,0.2 radius=0.9 tube=0.12",
          "box size=1.2,0.3,1.2 center=0,-0.6,0; cylinder from=0,-0.5,0 to=0,0.7,0 radius=0.12; "
          "sphere radius=0.35 center=0,0.8,0")
SCANS = {"bonsai_256.nrrd": {"halve": "z", "threshold": 16, "window": "0, 255"},
         "ch2bet.nii.gz": {"threshold": 20, "window": "0, 255"},
         "teddybear_128x128x62_u8.raw": {"size": "128, 128, 62", "spacing": "2.8, 2.8, 5", "crop_to": "128, 89, 62",
                                         "threshold": 36, "window": "0, 255"},
         "neghip_64x64x64_u8.raw": {"size": "64, 64, 64", "window": "full"},
         "tooth.nhdr": {"window": "full"}, "stent.nrrd": {"window": "full", "orientation": "false"}}
KINDS = ("noise", "vdb", "scan", "noise", "primitives", "vdb", "noise", "scan")  # in turn
RESOLUTIONS = {"noise": (24, 48, 96, 180, 350), "primitives": (24, 64, 160)}  # voxels along the longest edge
PIXELS = (160, 320, 560)
# Densities as expressions leave them: `n` is a sum of octaves of noise, -1 to 1; the box reaches from -1 to 1.
FBM = ("vec3f p = getvoxelpws(); float n = 0, a = 1, f = {frequency:.3f}; "
       "for (int i = 0; i < {octaves}; ++i) {{ n += a * (2 * simplexnoise(p * f + {seed}) - 1); f *= 2.1; a *= 0.5; }} "
       "float r = length(p), y = p.y; f@density = ")
DENSITIES = {"wisps": "clamp(1.2 - 1.3 * r, 0, 1) * pow(clamp(n, 0, 1), 1.5);",
             "shell": "clamp(1 - 12 * abs(r - 0.6 - 0.15 * n), 0, 1);",
             "ridges": "clamp(1.3 - 1.4 * r, 0, 1) * pow(clamp(1 - abs(n), 0, 1), 8);",
             "layers": "exp(-2.5 * (y + 1)) * clamp(0.1 + n, 0, 1);",
             "gyroid": "clamp(1.5 - abs(sin(7 * p.x) * cos(7 * y) + sin(7 * y) * cos(7 * p.z) + sin(7 * p.z) * "
                       "cos(7 * p.x) + 0.4 * n) * 3, 0, 1) * clamp(4 - 4 * r, 0, 1);",
             "cut": "n > 0.15 && r < 0.95 ? 1 : 0;",
             "eroded": "clamp(3 - 3.2 * r - 2 * clamp(0.5 + n, 0, 1), 0, 1);"}


# What stands in for scans that may not be passed on: an engine, molecules, vessels, a jet.
STAND_INS = {
    "engine": ("primitives", {"resolution": 200, "shapes": "box size=1.6,0.9,0.7; cylinder from=-0.5,0.3,0 to=-0.5,0.9,0 "
               "radius=0.22; cylinder from=0,0.3,0 to=0,0.9,0 radius=0.22; cylinder from=0.5,0.3,0 to=0.5,0.9,0 "
               "radius=0.22; torus center=0,0,0.4 axis=0,0,1 radius=0.3 tube=0.07; cylinder from=-1,0,0 to=1,0,0 "
               "radius=0.1"}),
    "molecule": ("primitives", {"resolution": 160, "soft": 0.04, "shapes": "sphere radius=0.34 center=0,0,0; "
                 "sphere radius=0.26 center=0.6,0.3,0.1; sphere radius=0.26 center=-0.5,0.4,0.2; "
                 "sphere radius=0.2 center=0.1,-0.6,-0.2; cylinder from=0,0,0 to=0.6,0.3,0.1 radius=0.08; "
                 "cylinder from=0,0,0 to=-0.5,0.4,0.2 radius=0.08; cylinder from=0,0,0 to=0.1,-0.6,-0.2 radius=0.08"}),
    "vessels": ("noise", {"resolution": 200, "shape": "hypertexture", "seed": 3}),
    "jet": ("noise", {"resolution": 200, "shape": "plume", "seed": 5})}
LOOKS = {"bonsai_256.nrrd": ((0.09, 0), (0.13, 0.4), (0.2, 0.4), (0.24, 2.5), (0.7, 3)),
         "ch2bet.nii.gz": ((0.2, 0), (0.35, 1), (0.8, 2)),
         "teddybear_128x128x62_u8.raw": ((0.15, 0), (0.22, 0.8), (0.5, 1.6), (0.6, 2.8)),
         "neghip_64x64x64_u8.raw": ((0.12, 0), (0.22, 0.5), (0.35, 1), (0.6, 3)),
         "tooth.nhdr": ((0.45, 0), (0.52, 0.4), (0.6, 3)), "stent.nrrd": ((0.3, 0), (0.4, 0.5), (0.7, 3)),
         "engine": ((0.4, 0), (0.6, 2)), "molecule": ((0.3, 0), (0.5, 0.4), (0.9, 2)),
         "vessels": ((0.3, 0), (0.45, 2)), "jet": ((0.1, 0), (0.2, 0.15), (0.5, 0.15), (0.6, 1.5))}  # value, a voxel's depth


def log_uniform(lot, low, high):
    return math.exp(lot.uniform(math.log(low), math.log(high)))


def add(a, b, scale=1.0):
    return [p + scale * q for p, q in zip(a, b)]


def numbers(values):
    return "[" + ", ".join(f"{v:.6g}" for v in values) + "]"


class Asset:
    """A .vdb with its box in the world, its largest value and whether it is a scan."""

    def __init__(self, scrim, label, path, classified=False):
        self.label, self.path, self.classified = label, path, classified
        text = subprocess.run([scrim, "info", "--json", path], check=True, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True).stdout
        grids = [g for g in json.loads(text)["grids"] if g["usable"] and g["active_voxels"] + g["active_tiles"] > 0]
        grid = next((g for g in grids if g["name"] == "density"), grids[0])
        self.voxels, self.largest, self.voxel = grid["active_voxels"], grid["max_value"], grid["voxel_size"][0]
        m = grid["world_from_index"]
        corners = [[sum(m[row][c] * corner[c] for c in range(3)) + m[row][3] for row in range(3)]
                   for corner in [[grid["index_upper" if i >> a & 1 else "index_lower"][a] for a in range(3)]
                                  for i in range(8)]]
        low = [min(c[a] for c in corners) for a in range(3)]
        high = [max(c[a] for c in corners) for a in range(3)]
        self.middle = [(l + h) / 2 for l, h in zip(low, high)]
        self.radius = max(0.5 * math.dist(low, high), self.voxel)


def made(scrim, folder, label, source, parameters, classified=False):
    path = folder / (label.replace(" ", "_").replace(":", "_") + ".vdb")
    if not path.exists():
        done = subprocess.run([scrim, "make", source, *(f"{k}={v}" for k, v in parameters.items()), "-o", path, "-q"],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if done.returncode != 0:
            raise RuntimeError(done.stdout.strip().splitlines()[-1])
    return Asset(scrim, label, path, classified)


def draw_asset(lot, kind, scrim, folder):
    data = Path(os.environ["SCRIM_DATA"]) if "SCRIM_DATA" in os.environ else None
    files = sorted((data / "vdb").glob("*.vdb")) if data else []
    if data:
        files += [f for f in sorted((data / "sequence").glob("*/*.vdb"))[::6] if f.stat().st_size > 10000]
    if kind == "vdb" and files:
        file = lot.choice(files)
        return Asset(scrim, file.name, file)
    if kind == "scan" and data:
        name = lot.choice(sorted(SCANS))
        parameters = {"file": data / "scan" / name, "center": "true", **SCANS[name]}
        return made(scrim, folder, name.split(".")[0], "scan", parameters, classified=True)
    if kind == "primitives":
        n, shapes = lot.choice(RESOLUTIONS["primitives"]), lot.randrange(len(SHAPES))
        return made(scrim, folder, f"primitives:{n} {shapes}", "primitives",
                    {"resolution": n, "shapes": SHAPES[shapes]})
    n, seed = lot.choice(RESOLUTIONS["noise"]), lot.randrange(100)
    shape = lot.choice(("plume", "plume", "ball", "slab", "hypertexture"))
    return made(scrim, folder, f"noise:{n} {shape} {seed}", "noise", {"resolution": n, "shape": shape, "seed": seed})


def draw_ax(lot, scrim, folder):
    """A volume that an expression makes of a box."""
    kind, n, seed = lot.choice(sorted(DENSITIES)), lot.choice((40, 80, 160)), lot.randrange(100)
    code = FBM.format(frequency=log_uniform(lot, 1, 6), octaves=lot.randint(1, 5), seed=seed) + DENSITIES[kind]
    box = made(scrim, folder, f"box:{n}", "primitives", {"shapes": "box size=2,2,2", "voxel": 2 / n})
    return made(scrim, folder, f"ax:{kind} {n} {seed}", "ax", {"file": box.path, "code": code})


def draw_scan(index, scrim, folder):
    """Ten surfaces from three sides, in one light and in two: 30 scenes that are the same for every seed."""
    name = list(LOOKS)[index % len(LOOKS)]
    if name in SCANS:
        file = Path(os.environ["SCRIM_DATA"]) / "scan" / name
        asset = made(scrim, folder, name.split(".")[0], "scan", {"file": file, "center": "true", **SCANS[name]}, True)
    else:
        asset = made(scrim, folder, name, *STAND_INS[name], classified=True)
    side, lights = index // len(LOOKS) % 3, 1 + (index + index // len(LOOKS)) % 2
    turn = 0.4 + 2.1 * side
    to_eye = [0.95 * math.sin(turn), 0.31, 0.95 * math.cos(turn)]
    eye = add(asset.middle, to_eye, 0.85 * asset.radius / math.sin(math.radians(15)))
    points = ", ".join(f"{{ value = {v}, color = [{0.8 - 0.4 * v:.3g}, {0.3 + 0.3 * v:.3g}, {0.15 + 0.6 * v:.3g}], "
                       f"extinction = {e / asset.voxel:.6g} }}" for v, e in LOOKS[name])
    ways = ((0.8, -1.1, -0.9), (-1, -0.3, 0.5))[:lights]
    return asset, {"opacity": LOOKS[name][-1][1], "pixels_per_voxel": 0, "lights": lights, "edge": 512}, (
        f"[camera]\nposition = {numbers(eye)}\ntarget = {numbers(asset.middle)}\nfov = 30\nresolution = [512, 512]\n\n"
        f"[[volume]]\nfile = \"{asset.path}\"\n[volume.classified]\ntransfer = [{points}]\nambient = 1\ndiffuse = 0.9\n"
        "specular = 0.2\n" + "".join(f'\n[[light]]\ntype = "distant"\ndirection = {numbers(way)}\nintensity = 8\n'
                                     for way in ways) + "\n[ambient]\ncolor = [0.14, 0.15, 0.18]\n")


def medium_text(lot, asset, opacity):
    """`opacity`: optical depth of the densest voxel."""
    colour = [round(lot.uniform(0.5, 0.98), 2) for _ in range(3)]
    if not asset.classified:
        return (f"density = {{ scale = {opacity / (asset.largest * asset.voxel):.6g} }}\n"
                f"[volume.medium]\nalbedo = {numbers(colour)}\n")
    begin = lot.uniform(0.12, 0.4)
    steps = [(begin, 0), (begin + lot.uniform(0.03, 0.2), 0.5), (0.8, 1)]
    points = ", ".join(f"{{ value = {v:.3f}, color = {numbers(colour)}, extinction = {e * opacity / asset.voxel:.6g} }}"
                       for v, e in steps)
    shine = f"ambient = 1\ndiffuse = 0.9\nspecular = {lot.choice((0, 0.2))}\n"
    return f"[volume.classified]\ntransfer = [{points}]\n{shine}"


def light_text(lot, asset, index, to_eye):
    """`to_eye`: unit, from the asset to the eye. Lights stand before, beside and behind the asset, and anywhere."""
    side = [to_eye[2], 0, -to_eye[0]]
    where = lot.choice(("front", "side", "behind", "any"))
    way = {"front": to_eye, "behind": [-c for c in to_eye], "any": [lot.gauss(0, 1) for _ in range(3)],
           "side": add(side, to_eye, lot.uniform(-0.3, 0.3))}[where]
    way = add(way, [0, lot.uniform(-0.2, 0.8), 0])
    length = math.hypot(*way) or 1
    way = [c / length for c in way]
    kind = lot.choice(("distant", "distant", "point", "spot"))
    text = f'\n[[light]]\nname = "{where}{index}"\ntype = "{kind}"\n'
    if kind == "distant":
        return text + f"direction = {numbers(-c for c in way)}\nintensity = {lot.uniform(3, 12):.3g}\n"
    distance = lot.uniform(1.3, 3) * asset.radius
    text += f"position = {numbers(add(asset.middle, way, distance))}\nintensity = {8 * distance**2:.4g}\n"
    return text if kind == "point" else text + f"target = {numbers(asset.middle)}\ncone = {lot.uniform(30, 80):.3g}\n"


def extended_light_text(lot, asset, index):
    """A sky, a surface beside the asset, or a lamp in it."""
    way = [lot.gauss(0, 1) for _ in range(3)]
    way = [c / (math.hypot(*way) or 1) for c in way]
    kind = lot.choice(("dome", "rectangle", "disk", "sphere", "cylinder", "lamp", "lamp"))
    text = f'\n[[light]]\nname = "{kind}{index}"\n'
    if kind == "dome":
        return text + f'type = "dome"\nintensity = {lot.uniform(0.5, 2):.3g}\n'
    if kind == "lamp":
        place = add(asset.middle, way, lot.uniform(0, 0.7) * asset.radius)
        radius = f'"area"\nshape = "sphere"\nradius = {lot.uniform(0.01, 0.1) * asset.radius:.4g}'
        shape = lot.choice(('"point"', radius))
        return text + f"type = {shape}\nposition = {numbers(place)}\nintensity = {asset.radius**2:.4g}\n"
    distance, size = lot.uniform(1.1, 2.5) * asset.radius, lot.uniform(0.1, 0.8) * asset.radius
    extent = {"rectangle": f"width = {size:.4g}\nheight = {lot.uniform(0.3, 1) * size:.4g}\n",
              "cylinder": f"width = {size:.4g}\nradius = {0.1 * size:.4g}\n"}.get(kind, f"radius = {0.5 * size:.4g}\n")
    aim = "" if kind == "sphere" else f"target = {numbers(asset.middle)}\n"
    return (text + f'type = "area"\nshape = "{kind}"\n{extent}position = {numbers(add(asset.middle, way, distance))}\n'
            f"{aim}intensity = {10 * (distance / size)**2:.4g}\n")


def draw_scattering(seed, index, scrim, folder):
    """The n-th scene in which light scatters more than once: smoke of noise, 2 to 30 mean free paths across, of albedo
    0.8 to 0.9995 and g 0 to 0.9, with one to three lights. One in four burns, one in four is under a dome."""
    lot = random.Random(f"{seed}/{index}/scattering")
    n, shape, noise = lot.choice((40, 64, 96)), lot.choice(("plume", "ball", "ball", "slab")), lot.randrange(100)
    asset = made(scrim, folder, f"noise:{n} {shape} {noise}", "noise", {"resolution": n, "shape": shape, "seed": noise})
    depth, g = log_uniform(lot, 2, 30), lot.choice((0, 0, 0.4, 0.6, 0.75, 0.85, 0.9))
    albedo = [1 - log_uniform(lot, 0.0005, 0.2)] * 3
    if lot.random() < 0.25:
        albedo = [max(0.8, a - lot.uniform(0, 0.1)) for a in albedo]
    scale = depth / (asset.largest * asset.voxel * n)
    turn, rise, fov = lot.uniform(0, 2 * math.pi), lot.uniform(-0.5, 0.9), lot.choice((20, 35))
    to_eye = [math.cos(rise) * math.sin(turn), math.sin(rise), math.cos(rise) * math.cos(turn)]
    distance = asset.radius / math.sin(math.radians(fov / 2)) / log_uniform(lot, 0.7, 1.4)
    eye = add(asset.middle, to_eye, distance)
    pixels = lot.choice((120, 160, 240))
    lights = [light_text(lot, asset, i, to_eye) for i in range(lot.randint(1, 3))]
    fire, dome = index % 4 == 1, index % 4 == 3
    if dome:
        lights[0] = f'\n[[light]]\nname = "sky"\ntype = "dome"\nintensity = {lot.uniform(0.5, 2):.3g}\n'
    glow = (f'emission = {{ grid = "density", scale = {log_uniform(lot, 0.3, 3) * scale:.6g}, ramp = [[0, [0, 0, 0]], '
            f'[{0.4 * asset.largest:.6g}, [0, 0, 0]], [{asset.largest:.6g}, [1, 0.5, 0.2]]] }}\n') if fire else ""
    phase = f'phase = {{ type = "hg", g = {g} }}\n' if g else ""
    text = (f"[camera]\nposition = {numbers(eye)}\ntarget = {numbers(asset.middle)}\nfov = {fov}\n"
            f"resolution = [{pixels}, {pixels}]\n\n[[volume]]\nfile = \"{asset.path}\"\n"
            f"density = {{ scale = {scale:.6g} }}\n[volume.medium]\nalbedo = {numbers(albedo)}\n"
            f'scattering = "full"\n{phase}{glow}{"".join(lights)}')
    asset.label += (f", depth {depth:.3g}, albedo {max(albedo):.4f}{' and less' if min(albedo) < max(albedo) else ''}, "
                    f"g {g}{', fire' if fire else ''}{', dome' if dome else ''}")
    return asset, {"opacity": depth / n, "pixels_per_voxel": asset.voxel / distance * pixels /
                   (2 * math.tan(math.radians(fov / 2))), "lights": len(lights), "edge": pixels}, text


def draw(seed, index, scrim, folder, extended=False, ax=False):
    """The n-th scene: its asset, what is worth knowing about it, and its text. `extended`: lit by skies, surfaces and
    lamps in the smoke, and by a sun now and then; scans have none of these. `ax`: of volumes that expressions made."""
    lot = random.Random(f"{seed}/{index}")
    kinds = [kind for kind in KINDS if not extended or kind != "scan"]
    asset = draw_ax(lot, scrim, folder) if ax else draw_asset(lot, kinds[index % len(kinds)], scrim, folder)
    opacity = log_uniform(lot, 0.1, 4) if asset.classified else log_uniform(lot, 0.004, 2.5)
    # The camera orbits; zoomed out the volume fills less than the picture, zoomed in more.
    turn, rise, fov = lot.uniform(0, 2 * math.pi), lot.uniform(-0.5, 0.9), lot.choice((20, 35, 60))
    to_eye = [math.cos(rise) * math.sin(turn), math.sin(rise), math.cos(rise) * math.cos(turn)]
    distance = asset.radius / math.sin(math.radians(fov / 2)) / log_uniform(lot, 0.4, 2)
    eye = add(asset.middle, to_eye, max(distance, 1.15 * asset.radius))
    pixels = lot.choice(PIXELS)
    per_voxel = asset.voxel / math.dist(eye, asset.middle) * pixels / (2 * math.tan(math.radians(fov / 2)))
    if extended:
        lights = "".join(extended_light_text(lot, asset, i) for i in range(lot.randint(1, 2)))
        lights += light_text(lot, asset, 9, to_eye) if lot.random() < 0.3 else ""
    else:
        lights = "".join(light_text(lot, asset, i, to_eye) for i in range(lot.randint(1, 4)))
    ambient = "\n[ambient]\ncolor = [0.05, 0.06, 0.08]\n" if lot.random() < 0.3 else ""
    text = (f"[camera]\nposition = {numbers(eye)}\ntarget = {numbers(asset.middle)}\nfov = {fov}\n"
            f"resolution = [{pixels}, {pixels}]\n\n[[volume]]\nfile = \"{asset.path}\"\n"
            f"{medium_text(lot, asset, opacity)}{lights}{ambient}")
    return asset, {"opacity": opacity, "pixels_per_voxel": per_voxel, "lights": lights.count("[[light]]"),
                   "edge": pixels}, text
