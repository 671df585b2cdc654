# SPDX-License-Identifier: Apache-2.0
"""Laws of light: by closed forms, and by what the program shows of smoke that a light of these laws shines on."""

import math

import numpy
import pytest
from scrim_kit import light_laws as laws

import scrim

DISTANCE = 4.0
STRENGTH = [2.0, 1.0, 0.5]

# By closed forms


def test_a_sun_gives_the_same_irradiance_whatever_its_angle():
    for angle in (0.0, 0.01, 0.5, 1.5):
        sun = laws.cycles_sun([2, 1, 0], angle)
        # On a card that faces the sun: radiance times the integral of the cosine, pi sin^2(half).
        half = 0.5 * angle
        solid = 2 * math.pi * (1 - math.cos(half)) if angle else 1.0
        card = sun["intensity"] / solid * (math.pi * math.sin(half) ** 2 if angle else 1.0)
        assert card == pytest.approx(2.0)
        assert sun["color"] == [1, 0.5, 0]
        assert laws.usd_distant(2.0, math.degrees(angle), True) == pytest.approx((sun["intensity"], 2.0))


def test_a_sun_is_the_sum_of_its_rays():
    for half in (0.001, 0.3, 1.0, 1.5, 2.5, math.pi):
        rays = [(i + 0.5) * half / 20000 for i in range(20000)]
        ring = 2 * math.pi * half / 20000
        assert laws.sun_solid_angle(half) == pytest.approx(sum(math.sin(a) * ring for a in rays), rel=1e-6)
        lit = sum(abs(math.cos(a)) * math.sin(a) * ring for a in rays)
        assert laws.sun_on_card(half) == pytest.approx(lit, rel=1e-6)


def test_a_sphere_has_the_intensity_of_its_point():
    small = laws.cycles_point([8, 8, 8], 0.0)
    large = laws.cycles_point([8, 8, 8], 0.5)
    assert large["intensity"] * math.pi * 0.5**2 == pytest.approx(small["intensity"])
    assert laws.usd_point(8.0, 0.5, False) == pytest.approx(8.0 * math.pi * 0.5**2)
    assert laws.usd_point(8.0, 0.5, True) == pytest.approx(laws.usd_point(8.0 / (4 * math.pi * 0.5**2), 0.5, False))


def test_a_disk_gives_what_its_area_says():
    disk, square = (laws.cycles_area([1, 1, 1], 2, 2, ellipse) for ellipse in (True, False))
    assert disk["intensity"] * math.pi * disk["radius"] ** 2 == pytest.approx(1 / math.pi)
    assert square["intensity"] * 4 == pytest.approx(1 / math.pi)
    assert laws.cycles_area([1, 1, 1], 2, 2, False, normalize=False)["intensity"] == pytest.approx(1 / math.pi)


def test_a_spot_fades_between_the_same_cosines():
    for size in (0.3, 1.0, 2.5):
        for blend in (0.0, 0.2, 1.0):
            spot = laws.cycles_spot([1, 1, 1], size, blend)
            outer = math.cos(size / 2)
            inner = math.cos(math.radians(spot["cone"]) / 2 * (1 - spot["blend"]))
            assert inner - outer == pytest.approx((1 - outer) * blend, abs=1e-12)


def test_strength_counts_exposure_and_temperature():
    assert laws.cycles_strength((1, 0.5, 0), 3, 1, (1, 1, 0.5)) == [6, 3, 0]


def test_a_light_that_takes_light_away_gives_none():
    assert laws.shining([-1, 0, 0], 2.0) == {"color": [1, 1, 1], "intensity": 0}
    assert laws.shining([-1, 4, 2], 0.5) == {"color": [0, 1, 0.5], "intensity": 2}


def test_lights_that_are_not_normalised_have_their_radiance():
    angle = 0.4
    solid = 2 * math.pi * (1 - math.cos(0.5 * angle))
    assert laws.cycles_sun([2, 2, 2], angle, normalize=False)["intensity"] == pytest.approx(2 * solid)
    assert laws.usd_distant(2, math.degrees(angle), False)[0] == pytest.approx(2 * solid)
    assert laws.cycles_point([2, 2, 2], 0.5, normalize=False)["intensity"] == pytest.approx(2 / math.pi)
    # A ball of radius r and radiance L has the intensity L pi r^2 from afar.
    spot = laws.cycles_spot([2, 2, 2], 1.0, 0.2, radius=0.5, normalize=False)
    assert spot["intensity"] == pytest.approx(2 / math.pi * math.pi * 0.5**2)


def test_lights_before_4_0_follow_laws_of_their_own():
    for angle in (0.0, 0.7):
        sun = laws.cycles_sun([2, 1, 0], angle, before_4=True)
        assert sun["intensity"] == 2 and sun.get("angle", 0.0) == pytest.approx(math.degrees(angle))
    for ellipse in (True, False):
        old, new = (laws.cycles_area([1, 1, 1], 2, 2, ellipse, before_4=before) for before in (True, False))
        assert old["intensity"] / new["intensity"] == pytest.approx(math.pi / 4)


# By the program


def arrives(light, size=0.4):
    """The light that thin dust at the origin gets from all sides, by what it shows: it scatters all of it, evenly."""
    scene = {
        "camera": {"type": "orthographic", "position": [0, 0, 20], "target": [0, 0, 0], "height": 1.5 * size},
        "volume": [{"name": "dust", "density": {"scale": 0.002 / size}, "medium": {"albedo": [1, 1, 1]}}],
        "light": [{"name": "key", **light}],
        "render": {"quality": "ultra", "light_error": 0.002},
    }
    shot = scrim.loads(scene, resolution=(16, 16))
    # So small and thin that each of its voxels gets the same light, and keeps none from the others.
    voxel = size / 8
    shot.set_volume("dust", scrim.Field(numpy.ones((8, 8, 8)), voxel, origin=[-3.5 * voxel] * 3))
    image = shot.render().image.astype(float)
    return 4 * math.pi * image[:, :, :3].sum(axis=(0, 1)) / image[:, :, 3].sum()


def shines(part, rel=0.01):
    return pytest.approx([s * part for s in STRENGTH], rel=rel)


def at_distance(light, turn=0.0):
    """Off the dust along +z; it shines along -z, or turned away from there by radians."""
    return {**light, "position": [0, 0, DISTANCE], "direction": [math.sin(turn), 0, -math.cos(turn)]}


@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_the_programs_suns_are_those_of_cycles(angle):
    sun = {**laws.cycles_sun(STRENGTH, angle), "direction": [0, 0, -1]}
    assert arrives(sun) == shines(2 / (1 + math.cos(0.5 * angle)), rel=0.005)


@pytest.mark.parametrize("normalize", [True, False])
def test_the_programs_suns_are_those_of_usd(normalize):
    intensity, card = laws.usd_distant(3.0, 40.0, normalize)
    half = math.radians(20)
    radiance = 3.0 / (math.pi * math.sin(half) ** 2) if normalize else 3.0
    sun = {"type": "distant", "direction": [0, 0, -1], "angle": 40.0, "intensity": intensity}
    assert arrives(sun) == pytest.approx([radiance * 2 * math.pi * (1 - math.cos(half))] * 3, rel=0.005)
    assert card == pytest.approx(radiance * math.pi * math.sin(half) ** 2)


def test_the_programs_points_are_those_of_cycles_and_usd():
    point = at_distance(laws.cycles_point(STRENGTH, 0.0))
    del point["direction"]
    assert arrives(point) == shines(1 / (4 * math.pi * DISTANCE**2), rel=0.005)
    point = {"type": "point", "position": [0, 0, DISTANCE], "intensity": laws.usd_point(5.0, 0.1, False)}
    assert arrives(point) == pytest.approx([5.0 * math.pi * 0.1**2 / DISTANCE**2] * 3, rel=0.005)


def test_the_programs_spheres_are_those_of_cycles():
    sphere = at_distance(laws.cycles_point(STRENGTH, 0.8))
    del sphere["direction"]
    solid = 2 * math.pi * (1 - math.sqrt(1 - (0.8 / DISTANCE) ** 2))
    assert arrives(sphere) == shines(solid / (4 * math.pi**2 * 0.8**2))


@pytest.mark.parametrize("turn", [0.0, 0.3, 0.37, 0.41])
def test_the_programs_spots_fade_as_those_of_cycles(turn):
    size, blend = 0.8, 0.6
    spot = laws.cycles_spot(STRENGTH, size, blend)
    outer = math.cos(0.5 * size)
    t = min(max((math.cos(turn) - outer) / ((1 - outer) * blend), 0.0), 1.0)
    part = t * t * (3 - 2 * t) / (4 * math.pi * DISTANCE**2)
    assert arrives(at_distance(spot, turn), size=0.02) == shines(part)


def test_the_programs_areas_are_those_of_cycles():
    w, h, d = 2.0, 1.5, DISTANCE
    rectangle = at_distance(laws.cycles_area(STRENGTH, w, h, False))
    solid = 4 * math.atan(w * h / (2 * d * math.sqrt(4 * d * d + w * w + h * h)))
    assert arrives({**rectangle, "up": [0, 1, 0]}) == shines(solid / (math.pi * w * h))
    disk = at_distance(laws.cycles_area(STRENGTH, 1.6, 1.6, True))
    solid = 2 * math.pi * (1 - d / math.hypot(d, 0.8))
    assert arrives(disk) == shines(solid / (math.pi * math.pi * 0.8**2))
