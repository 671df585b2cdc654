# SPDX-License-Identifier: Apache-2.0
# Numbers of Blender's media and cameras in Scrim's units, each law with its place in Cycles' source text. Plain
# numbers in, tables of a scene out; nothing of Blender is imported. The laws of light are in the kit.
import math

_LEAST = 1e-12


def object_density(matrix):
    """The factor of Cycles on coefficients where a volume's space is 'OBJECT' (scene/object.cpp): one over the length
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


def phase(kind, number):
    """`number` gives the value of a socket by its name."""
    if kind == "RAYLEIGH":
        return {"type": "rayleigh"}
    if kind == "MIE":  # Cycles has the same fit
        return {"type": "droplets", "size": min(max(number("Diameter"), 1e-3), 50.0)}
    g = min(max(number("Anisotropy"), -0.999), 0.999)
    if kind == "DRAINE":
        return {"type": "draine", "g": g, "alpha": max(number("Alpha"), 0.0)}
    return {"type": "isotropic"} if abs(g) < 1e-6 else {"type": "hg", "g": g}


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


def lens_radius(lens, fstop):
    """In Blender's units, of which Cycles takes a thousandth as a millimetre. `lens`: focal length, mm."""
    return 1e-3 * lens / (2 * max(fstop, 1e-5))


def shutter(length, position):
    """Frames about the frame in which the shutter is open."""
    opens = {"START": 0.0, "CENTER": -0.5, "END": -1.0}[position] * length
    return [opens, opens + length]


def border(width, height, min_x, max_x, min_y, max_y):
    """Blender's border in pixels (x0, y0, width, height), rows from the bottom: its ends are cut to whole pixels."""
    x0, x1 = int(min_x * width), int(max_x * width)
    y0, y1 = int(min_y * height), int(max_y * height)
    return x0, y0, max(x1 - x0, 1), max(y1 - y0, 1)
