# SPDX-License-Identifier: Apache-2.0
"""Stages that the tests of OpenUSD make: a slab of fog, of which closed forms are known, and what is around it."""

import math
import subprocess

import scrim.usd
from conftest import PROGRAM
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdVol

EDGE = 16  # of the slab, in voxels and units
EXTINCTION = 0.05
TAU = EDGE * EXTINCTION
ALBEDO = 0.9


def front(irradiance):
    """Radiance of the slab lit along the view, of light that scatters once."""
    return irradiance * ALBEDO / (8 * math.pi) * (1 - math.exp(-2 * TAU))


def behind(irradiance):
    """The same, lit from behind."""
    return irradiance * ALBEDO / (4 * math.pi) * TAU * math.exp(-TAU)


def write_fog(folder, name="slab.vdb", edge=EDGE, spacing=1.0, value=1):
    """A cube of equal voxels around the origin. Its grid is called density."""
    scan = folder / "fog.nrrd"
    head = f"NRRD0004\ntype: uint8\ndimension: 3\nsizes: {edge} {edge} {edge}\n"
    head += f"spacings: {spacing} {spacing} {spacing}\nencoding: raw\n\n"
    scan.write_bytes(head.encode() + bytes([value]) * edge**3)
    make = [PROGRAM, "make", "scan", f"file={scan}", "center=true", "-q", "-o", folder / name]
    subprocess.run(make, check=True)
    return folder / name


def write_dust(folder):
    """So small and thin that each of its voxels gets the same light, and keeps none from the others."""
    return write_fog(folder, "dust.vdb", edge=8, spacing=0.05)


def fluence(frame):
    """The light that dust of albedo 1 gets from all sides, by what it shows."""
    image = frame.image.astype(float)
    return 4 * math.pi * image[:, :, :3].sum(axis=(0, 1)) / image[:, :, 3].sum()


class Stage:
    """A stage in memory, that is saved when it is opened."""

    def __init__(self, folder, up="Y", meters=1.0):
        self.folder, self.path = folder, folder / "shot.usda"
        self.stage = Usd.Stage.CreateNew(str(self.path))
        UsdGeom.SetStageUpAxis(self.stage, up)
        UsdGeom.SetStageMetersPerUnit(self.stage, meters)

    def camera(self, path="/cam", place=(0, 0, 50), ortho=24.0, turn=None):
        camera = UsdGeom.Camera.Define(self.stage, path)
        camera.AddTranslateOp().Set(Gf.Vec3d(*place))
        if turn:
            camera.AddRotateXYZOp().Set(Gf.Vec3f(*turn))
        if ortho:
            camera.GetProjectionAttr().Set("orthographic")
            camera.GetHorizontalApertureAttr().Set(10 * ortho)
            camera.GetVerticalApertureAttr().Set(10 * ortho)
        return camera

    def volume(self, path="/fog", files=("slab.vdb",), grids=("density",), said=True):
        volume = UsdVol.Volume.Define(self.stage, path)
        for file, grid in zip(files, grids):
            asset = UsdVol.OpenVDBAsset.Define(self.stage, f"{path}/{grid}")
            asset.CreateFilePathAttr(Sdf.AssetPath(file))
            asset.CreateFieldNameAttr(grid)
            volume.CreateFieldRelationship(grid, asset.GetPath())
        if said:
            self.say(volume, "density:scale", Sdf.ValueTypeNames.Float, EXTINCTION)
            self.say(volume, "albedo", Sdf.ValueTypeNames.Color3f, Gf.Vec3f(ALBEDO))
        return volume

    def dust(self, path="/dust", place=(0, 0, 0)):
        """With a camera before it that shows nothing else."""
        write_dust(self.folder)
        volume = self.volume(path, ["dust.vdb"], said=False)
        volume.AddTranslateOp().Set(Gf.Vec3d(*place))
        self.say(volume, "density:scale", Sdf.ValueTypeNames.Float, 0.005)
        self.say(volume, "albedo", Sdf.ValueTypeNames.Color3f, Gf.Vec3f(1))
        return volume

    @staticmethod
    def say(schema, name, kind, value):
        attribute = schema.GetPrim().CreateAttribute(f"scrim:{name}", kind)
        attribute.Set(value)
        return attribute

    def light(self, kind, path="/key", **inputs):
        light = getattr(UsdLux, kind).Define(self.stage, path)
        for name, value in inputs.items():
            light.GetPrim().GetAttribute("inputs:" + name).Set(value)
        return light

    def open(self, overrides=None, **keywords):
        self.stage.Save()
        keywords.setdefault("resolution", (16, 16))
        return scrim.usd.open(self.path, {"render.quality": "ultra", **(overrides or {})}, **keywords)


def fog_stage(folder):
    """A stage with the slab, seen from the front and not lit."""
    write_fog(folder)
    stage = Stage(folder)
    stage.camera()
    stage.volume()
    return stage


def lit_fog_stage(folder):
    """The same, lit from the front."""
    stage = fog_stage(folder)
    stage.light("DistantLight", intensity=1.0, angle=0.0)
    return stage
