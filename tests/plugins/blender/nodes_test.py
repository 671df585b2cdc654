# SPDX-License-Identifier: Apache-2.0
# What becomes of nodes, row by row of the table in examples/BLENDER.md that is not in mapping_test.py.
import math
import os
import sys
from types import SimpleNamespace

import pytest
from evaluated import numbers_of
from lookalikes import link, node, principled, tree_of

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "plugins", "blender"))
from scrim import formulae, nodes, values  # noqa: E402


def attribute(name, output="Fac", kind="GEOMETRY"):
    values = {"attribute_type": kind, "attribute_name": name}
    return node("ShaderNodeAttribute", name, outputs=(output,), values=values)


def fed(shader, socket, source, output=0):
    link(source, shader, socket, output)
    return shader


def scatter(phase="HENYEY_GREENSTEIN", color=(0.5, 0.5, 0.5, 1), density=1.0, g=0.0, name="", **more):
    values = {"phase": phase}
    return node("ShaderNodeVolumeScatter", name, values=values, Color=color, Density=density, Anisotropy=g, **more)


def math_node(operation, a, b, clamp=False):
    made = node("ShaderNodeMath", operation, values={"operation": operation, "use_clamp": clamp}, A=a, B=b)
    return made


def value(number):
    made = node("ShaderNodeValue")
    made.outputs[0].default_value = number
    return made


# Media


def test_coloured_absorption_tints_the_extinction():
    tree = tree_of(principled(Density=2.0, Color=(1, 0.5, 0.5, 1), Absorption_Color=(0, 0, 0.25, 1)))
    density, keys = nodes.medium_of(tree, ["density"]).keys()
    # sigma_t = 2 (1, 1, 0.5 + 0.5 (1 - 0.5)); sigma_s = 2 (1, 0.5, 0.5)
    assert density["scale"] == pytest.approx(2) and keys["extinction_tint"] == pytest.approx([1, 1, 0.75])
    assert keys["albedo"] == pytest.approx([1, 0.5, 0.5 / 0.75])


def test_a_grid_of_densities_may_come_from_a_link():
    shader = fed(principled(Density_Attribute=""), "Density", attribute("smoke"))
    assert nodes.medium_of(tree_of(shader), ["smoke"]).keys()[0] == {"grid": "smoke", "scale": 1}


def test_the_product_of_two_grids_is_an_expression():
    shader = fed(principled(), "Density", attribute("smoke"))
    medium = nodes.medium_of(tree_of(shader), ["density", "smoke"])
    assert medium.keys()[0] == {"grid": "scrim_1", "scale": 1}
    assert numbers_of(medium.ax, smoke=3.0, density=0.5) == {"scrim_1": 1.5}
    shader = fed(principled(Color_Attribute="Cd"), "Color", attribute("heat", "Color"))
    with pytest.raises(nodes.NotMapped, match="the product of the grids 'heat' and 'Cd'"):
        nodes.medium_of(tree_of(shader), ["density", "heat", "Cd"])


def test_a_linked_grid_of_colours_is_albedo():
    shader = fed(principled(), "Color", attribute("Cd", "Color"))
    keys = nodes.medium_of(tree_of(shader), ["density", "Cd"]).keys()[1]
    assert keys["albedo"] == {"grid": "Cd", "scale": 1}
    shader = principled(Color=(0.2, 0.4, 0.6, 1), Color_Attribute="Cd", Absorption_Color=(0.5, 0, 0, 1))
    medium = nodes.medium_of(tree_of(shader), ["density", "Cd"])
    assert medium.keys()[1]["albedo"] == {"grid": "Cd", "scale": pytest.approx(0.4)}
    assert medium.notes == [
        "'Absorption Color' beside a grid of colours (taken for black)",
        "a 'Color' beside a grid of colours that is not grey (taken for its mean)",
    ]


@pytest.mark.parametrize("g, phase", [(0, {"type": "isotropic"}), (2, {"type": "hg", "g": 0.999})])
def test_anisotropy_is_henyeys_and_greensteins(g, phase):
    assert nodes.medium_of(tree_of(principled(Anisotropy=g)), ["density"]).keys()[1]["phase"] == phase


def test_a_black_bodys_grid_tint_and_temperature():
    shader = fed(principled(Blackbody_Intensity=3.0, Blackbody_Tint=(0.5, 0.5, 0.5, 1)), "Temperature", attribute("T"))
    medium = nodes.medium_of(tree_of(shader), ["density", "T"])
    assert medium.blackbody == {"grid": "T", "scale": 1, "intensity": 1.5, "normalize": False} and not medium.notes
    shader = principled(Blackbody_Intensity=1.0, Blackbody_Tint=(1, 0.5, 0, 1), Temperature_Attribute="T")
    medium = nodes.medium_of(tree_of(shader), ["density", "T"])
    assert medium.blackbody["intensity"] == pytest.approx(0.5)
    assert medium.notes == ["a 'Blackbody Tint' that is not grey (taken for its mean)"]
    medium = nodes.medium_of(tree_of(principled(Blackbody_Intensity=1.0)), ["density"])
    assert medium.blackbody is None
    assert medium.notes == ["a black body of one temperature everywhere; there is no grid 'temperature'"]


def test_emission_is_strength_times_colour_whatever_the_density():
    strength = fed(math_node("MULTIPLY", 1.0, 3.0), "A", attribute("flame"))
    shader = fed(principled(Density=7.0, Emission_Color=(1, 1, 1, 1)), "Emission Strength", strength)
    keys = nodes.medium_of(tree_of(shader), ["density", "flame"]).keys(0.5)[1]
    assert keys["emission"] == {"grid": "flame", "scale": 1.5}


def test_coloured_emission_is_a_ramp_without_an_end_in_sight():
    shader = fed(principled(Emission_Color=(1, 0.5, 0, 1)), "Emission Strength", attribute("flame"))
    emission = nodes.medium_of(tree_of(shader), ["density", "flame"]).emission
    (zero, black), (end, color) = emission["ramp"]
    assert (zero, black, emission["scale"]) == (0, [0, 0, 0], 1) and end >= 1e3
    assert [c / end for c in color] == pytest.approx([1, 0.5, 0])


def test_absorption_takes_what_its_colour_leaves():
    absorption = node("ShaderNodeVolumeAbsorption", Color=(0.75, 0.5, 1, 1), Density=1.0)
    fed(absorption, "Density", fed(math_node("MULTIPLY", 1.0, 4.0), "A", attribute("d")))
    density, keys = nodes.medium_of(tree_of(absorption), ["d"]).keys()
    assert density == {"grid": "d", "scale": 2}
    assert keys["extinction_tint"] == [0.5, 1, 0] and keys["albedo"] == [0, 0, 0]


def test_shaders_that_are_added_are_summed():
    glow = node("ShaderNodeEmission", Color=(1, 1, 1, 1), Strength=1.0)
    dark = node("ShaderNodeVolumeAbsorption", Color=(0, 0, 0, 1), Density=1.0)
    lit = scatter("RAYLEIGH", color=(1, 1, 1, 1))
    for shader, socket in ((glow, "Strength"), (dark, "Density"), (lit, "Density")):
        fed(shader, socket, attribute("d"))
    density, keys = nodes.medium_of(tree_of(lit, dark, glow), ["d"]).keys()
    assert density["scale"] == 2 and keys["albedo"] == [0.5] * 3
    assert keys["phase"] == {"type": "rayleigh"} and keys["emission"] == {"grid": "d", "scale": 1}


@pytest.mark.parametrize(
    "shader, phase",
    [
        (scatter("MIE", Diameter=12.0), {"type": "droplets", "size": 12}),
        (scatter("MIE", Diameter=80.0), {"type": "droplets", "size": 50}),
        (scatter("DRAINE", g=0.3, Alpha=0.5), {"type": "draine", "g": 0.3, "alpha": 0.5}),
    ],
)
def test_phase_functions_of_droplets_are_the_same(shader, phase):
    medium = nodes.medium_of(tree_of(fed(shader, "Density", attribute("d"))), ["d"])
    assert medium.phase == phase and not medium.notes


def test_other_phase_functions_are_noted():
    shader = scatter("FOURNIER_FORAND", name="Sea", g=0.3)
    medium = nodes.medium_of(tree_of(fed(shader, "Density", attribute("d"))), ["d"])
    assert medium.notes == ["the phase function FOURNIER_FORAND of node 'Sea' (taken for Henyey-Greenstein)"]
    assert medium.phase == {"type": "hg", "g": 0.3}


def test_sums_that_scrim_cannot_have_are_named():
    def both(*shaders):
        with pytest.raises(nodes.NotMapped) as raised:
            nodes.medium_of(tree_of(*shaders), ["density", "d", "e"])
        return str(raised.value)

    def lit(grid, **values):
        return fed(scatter(**values), "Density", attribute(grid))

    def glow():
        return fed(node("ShaderNodeEmission", Color=(1, 1, 1, 1), Strength=1.0), "Strength", attribute("d"))

    assert both(lit("d"), lit("e")) == "densities of several grids (d, e)"
    assert both(glow(), glow()) == "a second emission"
    text = "a sum of phase functions other than two Henyey-Greensteins"
    assert both(lit("d", g=0.1), lit("d", g=0.2), lit("d", g=0.3)) == text
    assert both(lit("d", phase="RAYLEIGH"), lit("d", g=0.2)) == text
    assert both(lit("d", phase="MIE", Diameter=9.0), lit("d", g=0.2)) == text
    assert both(principled(Color_Attribute="d"), principled()) == "a grid of colours beside another shader"
    assert both(principled(Density=0.0)) == "nothing that scatters, absorbs or glows by a grid"


def test_a_volume_without_a_material_has_blenders_default():
    density, keys = nodes.default_medium(["density"]).keys()
    assert density == {"grid": "density", "scale": 1} and keys["albedo"] == [0.5] * 3
    with pytest.raises(nodes.NotMapped, match="no material, and no grid 'density'"):
        nodes.default_medium(["smoke"])


# Values


@pytest.mark.parametrize("output, grid", list(values.INFO_GRIDS.items()))
def test_volume_info_names_grids(output, grid):
    shader = fed(principled(Density_Attribute=""), "Density", node("ShaderNodeVolumeInfo", outputs=(output,)))
    assert nodes.medium_of(tree_of(shader), [grid]).grid == grid == output.lower()


def test_values_and_colours_are_constants():
    color = node("ShaderNodeRGB")
    color.outputs[0].default_value = (0.1, 0.2, 0.3, 1)
    shader = fed(fed(principled(), "Color", color), "Density", value(6.0))
    density, keys = nodes.medium_of(tree_of(shader), ["density"]).keys()
    assert density["scale"] == pytest.approx(6) and keys["albedo"] == pytest.approx([0.1, 0.2, 0.3])


def test_math_multiplies_and_divides():
    product = fed(fed(math_node("MULTIPLY", 1.0, 1.0), "A", attribute("d")), "B", value(6.0))
    quotient = fed(math_node("DIVIDE", 1.0, 4.0), "A", product)
    reroute = node("NodeReroute", Input=None)
    link(quotient, reroute, "Input")
    shader = fed(principled(Density_Attribute=""), "Density", reroute)
    assert nodes.medium_of(tree_of(shader), ["d"]).keys()[0] == {"grid": "d", "scale": pytest.approx(1.5)}


@pytest.mark.parametrize(
    "source",
    [
        math_node("ADD", 1.0, 2.0),
        math_node("MULTIPLY", 1.0, 2.0, clamp=True),
        math_node("DIVIDE", 1.0, 0.0),
        node("ShaderNodeTexVoronoi", "Cells"),
    ],
)
def test_other_values_are_named(source):
    with pytest.raises(nodes.NotMapped, match=f"node '{source.name}' at 'Density'"):
        nodes.medium_of(tree_of(fed(principled(), "Density", source)), ["density", "d"])


# Lights and worlds


def shaded(output, kind, **sockets):
    """(a light or a world, its shader)"""
    shader = node(kind, **sockets)
    end = fed(node(output, Surface=None, values={"is_active_output": True}), "Surface", shader)
    return SimpleNamespace(use_nodes=True, node_tree=SimpleNamespace(nodes=[end, shader])), shader


def test_a_lights_emission_is_strength_times_colour():
    light, _ = shaded("ShaderNodeOutputLight", "ShaderNodeEmission", Color=(1, 0.5, 0, 1), Strength=4.0)
    assert nodes.light_emission(light).color == [4, 2, 0]
    assert nodes.light_emission(SimpleNamespace(use_nodes=False)).color == [1, 1, 1]
    light, shader = shaded("ShaderNodeOutputLight", "ShaderNodeEmission", Color=(1, 1, 1, 1), Strength=1.0)
    fed(shader, "Strength", attribute("d"))
    with pytest.raises(nodes.NotMapped, match="the attribute 'd'"):
        nodes.light_emission(light)
    light.node_tree.nodes[0].inputs["Surface"].links.clear()
    assert nodes.light_emission(light).color == [0, 0, 0]


def world(color=(1, 1, 1, 1), strength=1.0):
    return shaded("ShaderNodeOutputWorld", "ShaderNodeBackground", Color=color, Strength=strength)


def test_a_world_of_one_colour():
    assert nodes.sky_of(world((0.1, 0.2, 0.3, 1), 2.0)[0]).color == pytest.approx([0.2, 0.4, 0.6])
    assert nodes.sky_of(world(strength=0.0)[0]) is None
    assert nodes.sky_of(SimpleNamespace(use_nodes=False, color=(0.1, 0, 0))).color == [0.1, 0, 0]
    assert nodes.sky_of(SimpleNamespace(use_nodes=False, color=(0, 0, 0))) is None


def with_picture(kind="POINT", turn=(0.0, 0.0, 0.5), projection="EQUIRECTANGULAR", output="Generated"):
    made, background = world(strength=3.0)
    picture = node(
        "ShaderNodeTexEnvironment", "Sky", Vector=None, values={"image": "picture", "projection": projection}
    )
    mapping = node("ShaderNodeMapping", "Turn", Vector=None, Rotation=turn, values={"vector_type": kind})
    coordinates = node("ShaderNodeTexCoord", "Where", outputs=(output,))
    fed(background, "Color", fed(picture, "Vector", fed(mapping, "Vector", coordinates)))
    return made


def test_a_world_with_a_picture_turns_about_z():
    sky = nodes.sky_of(with_picture())
    assert (sky.color, sky.image, sky.turn) == ([3, 3, 3], "picture", pytest.approx(-math.degrees(0.5)))
    assert nodes.sky_of(with_picture("TEXTURE")).turn == pytest.approx(math.degrees(0.5))


def with_sky(kind="NISHITA", dust="dust_density", **more):
    made, background = world(strength=0.5)
    values = {"sky_type": kind, "sun_elevation": 0.5, "sun_rotation": 0.2, "sun_size": math.radians(0.545),
              "sun_intensity": 1.0, "sun_disc": True, "altitude": 300.0, "air_density": 1.0, dust: 2.0,
              "ozone_density": 3.0, **more}  # fmt: skip
    fed(background, "Color", node("ShaderNodeTexSky", "Sky", Vector=None, values=values))
    return made


@pytest.mark.parametrize(("kind", "dust"), [("NISHITA", "dust_density"), ("MULTIPLE_SCATTERING", "aerosol_density")])
def test_a_sky_texture_is_a_clear_sky(kind, dust):
    sky = nodes.sky_of(with_sky(kind, dust))
    assert sky.clear["sun_elevation"] == pytest.approx(math.degrees(0.5)) and sky.clear["dust_density"] == 2
    assert sky.clear["sun_size"] == pytest.approx(0.545) and sky.clear["altitude"] == 300 and sky.clear["sun_disc"]
    # Irradiance pi is 100000 lux, which are 146.4 of Blender's watts of light as bright as can be.
    assert sky.color == pytest.approx([0.5 * 100000 / 683 / math.pi] * 3)
    # The rotation of a dome about z starts at -y and is counterclockwise; that of the node starts at +y, clockwise.
    assert sky.turn == pytest.approx(180 - math.degrees(0.2))


@pytest.mark.parametrize(
    "made, text",
    [
        (with_sky("PREETHAM"), "the type PREETHAM of node 'Sky'"),
        (with_picture(turn=(0.1, 0, 0)), "a rotation about x or y by node 'Turn'"),
        (with_picture(projection="MIRROR_BALL"), "the projection MIRROR_BALL of node 'Sky'"),
        (with_picture(output="Camera"), "node 'Where'"),
        (shaded("ShaderNodeOutputWorld", "ShaderNodeMixShader")[0], "node 'ShaderNodeMixShader'"),
    ],
)
def test_other_worlds_are_named(made, text):
    with pytest.raises(nodes.NotMapped) as raised:
        nodes.sky_of(made)
    assert str(raised.value) == text


# Laws


def test_uneven_scales_count_along_the_diagonal():
    matrix = [[1, 0, 0, 0], [0, 2, 0, 0], [0, 0, 3, 0], [0, 0, 0, 1]]
    assert formulae.object_density(matrix) == pytest.approx(1 / math.sqrt((1 + 4 + 9) / 3))


def test_a_border_is_cut_to_whole_pixels():
    assert formulae.border(64, 48, 0.25, 0.76, 0.4, 0.8) == (16, 19, 32, 19)
    assert formulae.border(10, 10, 0.5, 0.5, 0.5, 0.5) == (5, 5, 1, 1)
