# SPDX-License-Identifier: Apache-2.0
"""UsdGeom.Camera as [camera]. Apertures, offsets and focal lengths have one unit, and only their ratios count; an
orthographic film is in tenths of a world unit."""

from __future__ import annotations

from pxr import Usd, UsdGeom

from .._errors import InputError
from . import _laws, _own
from ._reading import Item, Reading, rows
from ._settings import Settings

_WIDTH = 960  # pixels; the width of a picture whose size nobody gave


def cameras_of(stage: Usd.Stage) -> list[Usd.Prim]:
    return [p for p in stage.Traverse(Usd.TraverseInstanceProxies()) if p.IsA(UsdGeom.Camera)]


def paths_of(stage: Usd.Stage) -> list[str]:
    return [str(prim.GetPath()) for prim in cameras_of(stage)]


def prim_of(reading: Reading, settings: Settings) -> Usd.Prim | None:
    """The camera that the stage is seen through; None where the stage has no camera, and nobody asked for one."""
    cameras = cameras_of(reading.stage)
    there = ", ".join(paths_of(reading.stage))
    wanted = reading.options.camera
    if wanted is None and settings.camera:
        wanted = str(settings.camera)
    if wanted is None:
        if len(cameras) > 1:
            raise InputError(f"the stage has {len(cameras)} cameras: name one of {there}")
        return cameras[0] if cameras else None
    named = [p for p in cameras if str(p.GetPath()) == wanted or p.GetName() == wanted]
    if len(named) != 1:
        raise InputError(f"'{wanted}' is not a camera of the stage; expected {there or 'one, but it has none'}")
    return named[0]


def _aspect(settings: Settings, film: tuple[float, float]) -> tuple[tuple[int, int], float]:
    """(resolution, pixel aspect)"""
    if settings.resolution is None:
        return (_WIDTH, max(1, round(_WIDTH * film[1] / film[0]))), settings.pixel_aspect
    width, height = settings.resolution
    if settings.policy == "adjustPixelAspectRatio":
        return (width, height), film[0] / film[1] * height / width
    return (width, height), settings.pixel_aspect


def _focus(reading: Reading, camera: UsdGeom.Camera) -> dict:
    """Depth of field, in world units; none without an f-stop and a distance."""

    def radius(time: float) -> float:
        stop = float(reading.get(camera.GetFStopAttr(), time))
        return 0.1 * float(reading.get(camera.GetFocalLengthAttr(), time)) / (2 * stop) if stop > 0 else 0.0

    def distance(time: float) -> float:
        return float(reading.get(camera.GetFocusDistanceAttr(), time))

    if not (distance(reading.frame) > 0 and radius(reading.frame) > 0):
        return {}
    return {"lens_radius": reading.moving(radius), "focus_distance": reading.moving(distance)}


def _lens(reading: Reading, camera: UsdGeom.Camera, settings: Settings) -> dict:
    frame = reading.frame

    def film(time: float) -> tuple[float, float]:
        return (
            float(reading.get(camera.GetHorizontalApertureAttr(), time)),
            float(reading.get(camera.GetVerticalApertureAttr(), time)),
        )

    size, pixel_aspect = _aspect(settings, film(frame))
    aspect = size[0] * pixel_aspect / size[1]

    def shown(time: float) -> tuple[float, float, str]:
        return _laws.film(film(time), aspect, settings.policy)

    def shift(time: float) -> list[float]:
        width = shown(time)[0]
        x = float(reading.get(camera.GetHorizontalApertureOffsetAttr(), time))
        y = float(reading.get(camera.GetVerticalApertureOffsetAttr(), time))
        return [x / width, y / width]

    out: dict = {"resolution": list(size)}
    if abs(pixel_aspect - 1) > 1e-6:
        out["pixel_aspect"] = pixel_aspect
    if reading.get(camera.GetProjectionAttr()) == UsdGeom.Tokens.orthographic:
        out["type"] = "orthographic"
        out["height"] = reading.moving(lambda t: shown(t)[1] / 10)
    else:
        out["focal_length"] = reading.moving(lambda t: float(reading.get(camera.GetFocalLengthAttr(), t)))
        out["aperture"] = reading.moving(lambda t: list(film(t)))
        out["fit"] = shown(frame)[2]
        if settings.depth_of_field:
            out.update(_focus(reading, camera))
    moved = reading.moving(shift)
    if moved != [0.0, 0.0]:
        out["shift"] = moved
    return out


def _frame(reading: Reading, prim: Usd.Prim, time: float) -> list[list[float]]:
    """Camera to world, without scale: axes are made orthonormal as cameras are."""
    matrix = reading.world(Item(prim), time)
    placed = matrix.RemoveScaleShear() if matrix.GetDeterminant() > 0 else matrix
    return rows(placed)


def _say_what_is_not(reading: Reading, prim: Usd.Prim, camera: UsdGeom.Camera) -> float:
    """Warns of what is not mapped of a camera. Returns the distance of its near plane."""
    if reading.get(camera.GetClippingPlanesAttr()):
        reading.warn(prim, "its clipping planes are not rendered")
    near, far = reading.get(camera.GetClippingRangeAttr())
    if camera.GetClippingRangeAttr().HasAuthoredValue() and far < 1e6:
        reading.warn(prim, f"its far clipping plane at {far:g} is not rendered")
    if near < 0:
        reading.warn(prim, f"its near clipping plane at {near:g} is taken as 0: nothing behind the camera is seen")
    return max(float(near), 0.0)


def exposure_scale(reading: Reading, prim: Usd.Prim) -> float:
    """The factor of the camera's exposure on the picture."""
    return float(UsdGeom.Camera(prim).ComputeLinearExposureScale(Usd.TimeCode(reading.frame)))


def shutter_of(reading: Reading, prim: Usd.Prim, settings: Settings) -> list[float] | None:
    """[opens, closes], in frames about the frame."""
    camera = UsdGeom.Camera(prim)
    opens, closes = float(reading.get(camera.GetShutterOpenAttr())), float(reading.get(camera.GetShutterCloseAttr()))
    if closes < opens:
        reading.warn(prim, f"its shutter closes at {closes:g}, before it opens at {opens:g}, and is taken as none")
    return [opens, closes] if settings.blur and closes > opens else None


def window(out: dict, settings: Settings) -> tuple[int, int, int, int] | None:
    """The pixels to render, x0, y0, x1, y1; None: all. `out`: [camera]; a window beyond the picture adds its
    overscan."""
    if settings.window == (0.0, 0.0, 1.0, 1.0):
        return None
    width, height = out["resolution"]
    crop = _laws.crop(settings.window, width, height)
    beyond = max(-crop[0], -crop[1], crop[2] - width, crop[3] - height)
    if beyond > 0:
        # Scrim's overscan is the same on all sides; the crop cuts away those pixels of it that are not in the window.
        out["overscan"] = max(int(beyond), out.get("overscan", 0))
    if not (crop[0] < crop[2] and crop[1] < crop[3]):
        raise InputError(f"dataWindowNDC {settings.window} contains no pixel of {width} x {height}")
    return crop


def read(reading: Reading, prim: Usd.Prim, settings: Settings) -> dict:
    """[camera]"""
    camera = UsdGeom.Camera(prim)
    out = _lens(reading, camera, settings)
    out["matrix"] = reading.moving(lambda time: _frame(reading, prim, time))
    near = _say_what_is_not(reading, prim, camera)
    if near > 0:
        out["near"] = near
    if len(reading.times) > 1:
        out["shutter"] = [reading.times[0] - reading.frame, reading.times[-1] - reading.frame]
    _own.merge(out, _own.attributes(reading, prim))
    return out
