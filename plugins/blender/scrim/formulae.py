# SPDX-License-Identifier: Apache-2.0
# What Cycles' numbers are in Scrim's units. Plain numbers in, tables of a scene out, nothing of Blender: each law
# stands here once, with the place in Cycles' source text that it was read from.
import math

_LEAST = 1e-12


def light_strength(color, energy, exposure=0.0, temperature_color=(1.0, 1.0, 1.0)):
    """What all laws below begin with: colour * energy * 2^exposure (* the colour of the light's temperature)."""
    return [c * t * energy * 2.0**exposure for c, t in zip(color, temperature_color)]


def split(strength):
    """(colour with a largest part of 1, intensity), so that scenes stay readable. Lights do not take light away."""
    strength = [max(s, 0.0) for s in strength]
    most = max(strength)
    if most <= 0:
        return [1.0, 1.0, 1.0], 0.0
    return [s / most for s in strength], most


def shining(strength, factor):
    color, intensity = split(strength)
    return {"color": color, "intensity": intensity * factor}


# scene/light.cpp: eval_fac of a distant light is 1 / (pi sin^2(angle / 2)) if normalised, else 1: its radiance. Scrim's
# intensity is what thin smoke gets from all of the sun: radiance times the solid angle 2 pi (1 - cos(angle / 2)).
# Before 4.0 it is the strength, whatever the angle (kernel/light/light.h: the factor and the density of samples are
# the same number).
def sun(strength, angle, normalize=True, before_4=False):
    half = 0.5 * angle
    if before_4:
        return {"type": "distant", **shining(strength, 1.0), **({"angle": math.degrees(angle)} if half > 0 else {})}
    if half <= 0:
        return {"type": "distant", **shining(strength, 1.0)}
    cap = 2 * math.pi * 2 * math.sin(0.5 * half) ** 2
    radiance = 1 / (math.pi * math.sin(half) ** 2) if normalize else 1.0
    return {"type": "distant", **shining(strength, radiance * cap), "angle": math.degrees(angle)}


# scene/light.cpp: 1 / (4 pi) for points without a size; radiance 1 / (4 pi^2 r^2) on a sphere, or 1 / pi if not
# normalised.
def point(strength, radius, normalize=True):
    if radius <= _LEAST:
        return {"type": "point", **shining(strength, 1 / (4 * math.pi))}
    radiance = 1 / (4 * math.pi**2 * radius**2) if normalize else 1 / math.pi
    return {"type": "area", "shape": "sphere", **shining(strength, radiance), "radius": radius}


# kernel/light/spot.h: smoothstep of (cos - cos(size / 2)) / ((1 - cos(size / 2)) * blend). Scrim's fades by the same
# law, from the cone's border to the angle at which that is 1.
def spot(strength, size, blend, radius=0.0, normalize=True):
    half = 0.5 * size
    outer = math.cos(half)
    inner = math.acos(min(1.0, outer + (1 - outer) * blend))
    flux = 1 / (4 * math.pi)
    if radius > _LEAST and not normalize:
        flux = radius**2  # radiance 1 / pi over a disk that faces what it lights
    return {
        "type": "spot",
        **shining(strength, flux),
        "cone": math.degrees(size),
        "blend": min(max(1 - inner / half, 0.0), 1.0),
    }


# scene/light.cpp: radiance 1 / (pi area), or 1 / pi if not normalised; one-sided, and even where the spread is 180
# degrees. Before 4.0: 1 / (4 area).
def area(strength, width, height, ellipse, normalize=True, before_4=False):
    size = width * height * (0.25 * math.pi if ellipse else 1.0)
    radiance = 1 / ((4 if before_4 else math.pi) * size) if normalize else 1 / math.pi
    if ellipse:
        return {"type": "area", "shape": "disk", **shining(strength, radiance), "radius": 0.25 * (width + height)}
    return {"type": "area", "shape": "rectangle", **shining(strength, radiance), "width": width, "height": height}


def object_density(matrix):
    """What Cycles multiplies coefficients by where a volume's space is 'OBJECT' (scene/object.cpp): one over the length
    that the object's matrix gives to a unit vector along (1, 1, 1)."""
    along = [sum(matrix[i][j] for j in range(3)) / math.sqrt(3) for i in range(3)]
    length = math.sqrt(sum(a * a for a in along))
    return 1 / length if length > _LEAST else 1.0


def principled_extinction(color, absorption):
    """sigma_t / density in each channel (svm/closure.h): sigma_s = c, sigma_a = max(1 - c, 0) max(1 - sqrt(a), 0)."""
    return [c + max(1 - c, 0.0) * max(1 - math.sqrt(max(a, 0.0)), 0.0) for c, a in zip(color, absorption)]


def medium(scattering, extinction):
    """`density.scale`, and the keys of a medium, of coefficients for grid value 1."""
    scattering = [max(s, 0.0) for s in scattering]
    most = max(extinction)
    if most <= 0:
        return 0.0, {"albedo": [0.0, 0.0, 0.0]}
    keys = {"albedo": [min(s / e, 1.0) if e > 0 else 0.0 for s, e in zip(scattering, extinction)]}
    tint = [e / most for e in extinction]
    if min(tint) < 1:
        keys["extinction_tint"] = tint
    return most, keys


def phase(kind, g):
    if kind == "RAYLEIGH":
        return {"type": "rayleigh"}
    if abs(g) < 1e-6:
        return {"type": "isotropic"}
    return {"type": "hg", "g": min(max(g, -0.999), 0.999)}


def camera_window(width, height, pixel_aspect, sensor_fit, sensor_width, sensor_height):
    """(does the sensor fit the picture's width?, its size, width over height of the picture as it is seen): Cycles'
    blender_camera_viewplane."""
    aspect = width * pixel_aspect / height
    horizontal = aspect > 1 if sensor_fit == "AUTO" else sensor_fit == "HORIZONTAL"
    return horizontal, sensor_height if sensor_fit == "VERTICAL" else sensor_width, aspect


def camera_lens(kind, horizontal, sensor, aspect, lens, ortho_scale, shift):
    """Blender's shift counts the side that the sensor fits, Scrim's the picture's width."""
    keys = {"shift": [s if horizontal else s / aspect for s in shift]}
    if kind == "ORTHO":
        keys["type"] = "orthographic"
        keys["height"] = ortho_scale / aspect if horizontal else ortho_scale
    else:
        keys["fov"] = math.degrees(2 * math.atan(0.5 * sensor / lens))
        keys["fov_axis"] = "horizontal" if horizontal else "vertical"
    return keys


def shutter(length, position):
    """Frames about the frame in which the shutter is open."""
    opens = {"START": 0.0, "CENTER": -0.5, "END": -1.0}[position] * length
    return [opens, opens + length]


def border(width, height, min_x, max_x, min_y, max_y):
    """Blender's border in pixels (x0, y0, width, height), rows from the bottom: its ends are cut to whole pixels."""
    x0, x1 = int(min_x * width), int(max_x * width)
    y0, y1 = int(min_y * height), int(max_y * height)
    return x0, y0, max(x1 - x0, 1), max(y1 - y0, 1)
