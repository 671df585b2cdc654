# SPDX-License-Identifier: Apache-2.0
# What nodes compute as code in OpenVDB AX: the program runs the code, and each grid holds the number that Blender's
# manual and Cycles' laws give.
import math
import os
import sys
from types import SimpleNamespace

import pytest
from evaluated import numbers_of
from lookalikes import link, node, principled, tree_of

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "plugins", "blender"))
from scrim import nodes  # noqa: E402
from scrim.expressions import Code, NotMapped  # noqa: E402

GRIDS = {"d": 0.3, "e": 2.5}


def attribute(name, output="Fac"):
    values = {"attribute_type": "GEOMETRY", "attribute_name": name}
    return node("ShaderNodeAttribute", name, outputs=(output,), values=values)


def fed(made, **sources):
    for socket, source in sources.items():
        link(source, made, socket.replace("_", " "))
    return made


def socket_of(source):
    return fed(node("end", In=None), In=source).inputs["In"]


def results(sources, grids=None, vectors=()):
    """The number of each node, computed at a voxel by the program."""
    grids = grids or GRIDS
    code = Code(list(grids), vectors)
    names = [code.grid(code.of(socket_of(source))) for source in sources]
    found = numbers_of(code.text, **grids)
    return [found[name] for name in names]


def math_of(operation, clamp=False, c=0.0, swapped=False):
    values = {"operation": operation, "use_clamp": clamp}
    made = node("ShaderNodeMath", operation, values=values, A=0.0, B=0.0, C=c)
    return fed(made, A=attribute("e" if swapped else "d"), B=attribute("d" if swapped else "e"))


def test_mathematics_is_that_of_the_manual():
    d, e = 0.3, 2.5
    expected = {
        "ADD": d + e, "SUBTRACT": d - e, "MULTIPLY": d * e, "DIVIDE": d / e, "MULTIPLY_ADD": d * e + 0.7,
        "POWER": d**e, "LOGARITHM": math.log(d, e), "SQRT": math.sqrt(d), "INVERSE_SQRT": d**-0.5, "ABSOLUTE": d,
        "EXPONENT": math.exp(d), "MINIMUM": d, "MAXIMUM": e, "LESS_THAN": 1, "GREATER_THAN": 0, "SIGN": 1, "COMPARE": 0,
        "ROUND": 0, "FLOOR": 0, "CEIL": 1, "TRUNC": 0, "FRACT": d, "FLOORED_MODULO": d, "SNAP": 0, "SINE": math.sin(d),
        "COSINE": math.cos(d), "TANGENT": math.tan(d), "ARCTANGENT": math.atan(d), "ARCTAN2": math.atan2(d, e),
        "RADIANS": math.radians(d), "DEGREES": math.degrees(d),
    }  # fmt: skip
    found = results([math_of(operation, c=0.7) for operation in expected])
    # Grids hold no number below 0 once they are shown, but the code's own do.
    assert found == pytest.approx(list(expected.values()), rel=1e-5, abs=1e-6), list(expected)
    swapped = {
        "SUBTRACT": 2.2, "FLOORED_MODULO": 0.1, "SNAP": 2.4, "ROUND": 3, "TRUNC": 2, "FRACT": 0.5, "CEIL": 3,
        "GREATER_THAN": 1,
    }  # fmt: skip
    assert results([math_of(o, swapped=True) for o in swapped]) == pytest.approx(list(swapped.values()), rel=1e-5)
    assert results([math_of("ADD", clamp=True)]) == [1]


def test_what_has_no_value_is_zero():
    zero = {"d": 0.0, "e": 0.0}
    operations = ["DIVIDE", "LOGARITHM", "INVERSE_SQRT", "FLOORED_MODULO", "SNAP", "SQRT"]
    assert results([math_of(o) for o in operations], zero) == [0] * len(operations)


def map_range(kind, clamp, value="d", low=0.2, high=0.6, first=1.0, last=5.0):
    values = {"interpolation_type": kind, "clamp": clamp, "data_type": "FLOAT"}
    sockets = {"Value": 0.0, "From_Min": low, "From_Max": high, "To_Min": first, "To_Max": last, "Steps": 4.0}
    return fed(node("ShaderNodeMapRange", kind, values=values, **sockets), Value=attribute(value))


def test_map_range_maps_as_the_manual_says():
    t = (0.3 - 0.2) / 0.4
    s, ss = t * t * (3 - 2 * t), t * t * t * (t * (t * 6 - 15) + 10)
    sources = [
        map_range("LINEAR", False), map_range("SMOOTHSTEP", False), map_range("SMOOTHERSTEP", False),
        map_range("STEPPED", False), map_range("LINEAR", False, "e"), map_range("LINEAR", True, "e"),
        map_range("LINEAR", True, "e", first=5.0, last=1.0), map_range("SMOOTHSTEP", False, "e"),
        map_range("LINEAR", False, low=0.4, high=0.4),
    ]  # fmt: skip
    expected = [1 + 4 * t, 1 + 4 * s, 1 + 4 * ss, 1 + 4 * math.floor(t * 5) / 4, 1 + 4 * 5.75, 5, 1, 5, 0]
    assert results(sources) == pytest.approx(expected, rel=1e-5)


def ramp(interpolation, points, grid="d"):
    elements = [SimpleNamespace(position=p, color=(*c, 1.0)) for p, c in points]
    settings = SimpleNamespace(color_mode="RGB", interpolation=interpolation, elements=elements)
    made = node("ShaderNodeValToRGB", "Ramp", outputs=("Color", "Alpha"), values={"color_ramp": settings}, Fac=0.0)
    return fed(made, Fac=attribute(grid))


def parts(source):
    """The three components of a vector, as numbers."""
    made = [node("ShaderNodeSeparateXYZ", c, outputs=(c,), Vector=None) for c in "XYZ"]
    return [fed(m, Vector=source) for m in made]


def test_ramps_of_colours():
    points = [(0.1, (0.0, 0.0, 1.0)), (0.5, (1.0, 0.5, 0.0)), (0.9, (1.0, 1.0, 1.0))]
    t = 0.5  # of 0.3 between the first two
    assert results(parts(ramp("LINEAR", points))) == pytest.approx([t, 0.5 * t, 1 - t], rel=1e-5)
    assert results(parts(ramp("CONSTANT", points))) == pytest.approx([0, 0, 1])
    assert results(parts(ramp("EASE", points))) == pytest.approx([0.5, 0.25, 0.5], rel=1e-5)
    assert results(parts(ramp("LINEAR", points, "e"))) == pytest.approx([1, 1, 1])
    assert results([ramp("LINEAR", points)]) == pytest.approx([0.2126 * t + 0.7152 * 0.5 * t + 0.0722 * (1 - t)])
    with pytest.raises(NotMapped, match="the settings of node 'Ramp'"):
        results([ramp("B_SPLINE", points)])


def mix(blend, data_type="RGBA", clamp_result=False, clamp_factor=True, factor_mode="UNIFORM", grid="d"):
    names = ["Factor", "F3", "A1", "B1", "A3", "B3", "A", "B"]
    values = {"data_type": data_type, "blend_type": blend, "clamp_factor": clamp_factor, "clamp_result": clamp_result,
              "factor_mode": factor_mode}  # fmt: skip
    sockets = dict.fromkeys(names, 0.0)
    sockets.update(A=(0.2, 0.4, 0.8, 1), B=(0.5, 0.1, 0.9, 1), A1=2.0, B1=6.0, A3=(1, 2, 3), B3=(3, 2, 2))
    sockets.update(F3=(0.5, -1.0, 2.0))
    return fed(node("ShaderNodeMix", blend, outputs=("Result",), values=values, **sockets), Factor=attribute(grid))


def test_mixing():
    a, b, f = (0.2, 0.4, 0.8), (0.5, 0.1, 0.9), 0.3
    laws = {
        "MIX": lambda x, y: x + (y - x) * f,
        "ADD": lambda x, y: x + f * y,
        "SUBTRACT": lambda x, y: x - f * y,
        "MULTIPLY": lambda x, y: x * (1 - f + f * y),
        "DARKEN": lambda x, y: min(x, y) * f + x * (1 - f),
        "LIGHTEN": lambda x, y: max(x, y) * f + x * (1 - f),
        "SCREEN": lambda x, y: 1 - (1 - f + f * (1 - y)) * (1 - x),
        "DIFFERENCE": lambda x, y: x * (1 - f) + abs(x - y) * f,
    }
    for blend, law in laws.items():
        expected = [law(x, y) for x, y in zip(a, b)]
        assert results(parts(mix(blend))) == pytest.approx(expected, rel=1e-5), blend
    assert results([mix("MIX", "FLOAT")]) == pytest.approx([2 + 4 * f], rel=1e-5)
    assert results([mix("MIX")]) == pytest.approx([0.2126 * 0.29 + 0.7152 * 0.31 + 0.0722 * 0.83], rel=1e-5)
    assert max(results(parts(mix("ADD", clamp_result=True)))) == 1
    with pytest.raises(NotMapped, match="the blending OVERLAY of node 'OVERLAY'"):
        results([mix("OVERLAY")])


def test_mixing_of_vectors():
    assert results(parts(mix("MIX", "VECTOR"))) == pytest.approx([1.6, 2, 2.7], rel=1e-5)
    # A vector becomes a number by its mean, and not by its brightness as a colour does.
    assert results([mix("MIX", "VECTOR")]) == pytest.approx([2.1], rel=1e-5)
    assert results(parts(mix("MIX", "VECTOR", grid="e"))) == pytest.approx([3, 2, 2])
    assert results(parts(mix("MIX", "VECTOR", clamp_factor=False, grid="e"))) == pytest.approx([6, 2, 0.5], rel=1e-5)
    each = mix("MIX", "VECTOR", factor_mode="NON_UNIFORM")
    assert results(parts(each)) == pytest.approx([2, 2, 2])
    each = mix("MIX", "VECTOR", clamp_factor=False, factor_mode="NON_UNIFORM")
    assert results(parts(each)) == pytest.approx([2, 2, 1])
    with pytest.raises(NotMapped, match="the settings of node 'MIX'"):
        results([mix("MIX", "ROTATION")])


def vectors(operation, **sockets):
    made = node("ShaderNodeVectorMath", operation, values={"operation": operation},
                A=(1.0, 2.0, 2.0), B=(0.5, -1.0, 3.0), C=(1.0, 1.0, 1.0), Scale=1.0)  # fmt: skip
    return fed(made, **sockets)


def test_mathematics_of_vectors():
    d = attribute("d")
    assert results(parts(vectors("ADD", A=d))) == pytest.approx([0.8, -0.7, 3.3], rel=1e-5)
    assert results(parts(vectors("MULTIPLY", A=d))) == pytest.approx([0.15, -0.3, 0.9], rel=1e-5)
    assert results(parts(vectors("DIVIDE", A=d))) == pytest.approx([0.6, -0.3, 0.1], rel=1e-5)
    assert results([vectors("DOT_PRODUCT", A=d)]) == pytest.approx([0.3 * 2.5], rel=1e-5)
    assert results([vectors("LENGTH", A=d)]) == pytest.approx([0.3 * 3**0.5], rel=1e-5)
    assert results([vectors("DISTANCE", A=d)]) == pytest.approx([(0.04 + 1.69 + 7.29) ** 0.5], rel=1e-5)
    assert results(parts(vectors("SCALE", Scale=d))) == pytest.approx([0.3, 0.6, 0.6], rel=1e-5)
    assert results(parts(vectors("NORMALIZE", A=d))) == pytest.approx([3**-0.5] * 3, rel=1e-5)
    assert results(parts(vectors("MAXIMUM", A=d))) == pytest.approx([0.5, 0.3, 3], rel=1e-5)
    assert results(parts(vectors("CROSS_PRODUCT", A=d))) == pytest.approx([1.2, -0.75, -0.45], rel=1e-5)
    with pytest.raises(NotMapped, match="the operation REFLECT of node 'REFLECT'"):
        results([vectors("REFLECT", A=d)])


def test_a_graph_becomes_code_of_the_volume():
    density = map_range("SMOOTHSTEP", True)
    shader = fed(principled(Density_Attribute="e", Density=0.0), Density=density)
    medium = nodes.medium_of(tree_of(shader), ["d", "e"])
    t = 0.25
    # The last grid is the product of the expression and of the attribute that the shader names.
    assert medium.keys()[0] == {"grid": "scrim_2", "scale": 1}
    assert numbers_of(medium.ax, **GRIDS)["scrim_2"] == pytest.approx(2.5 * (1 + 4 * t * t * (3 - 2 * t)), rel=1e-5)


def test_colours_of_a_glow_are_a_ramp_over_what_is_computed():
    points = [(0.0, (0.0, 0.0, 0.0)), (1.0, (1.0, 0.5, 0.0))]
    shader = fed(principled(Density_Attribute="d", Emission_Strength=3.0), Emission_Color=ramp("LINEAR", points, "e"))
    medium = nodes.medium_of(tree_of(shader), ["d", "e"])
    assert medium.emission == {"grid": "e", "scale": 3, "ramp": [[0, [0, 0, 0]], [1, [1, 0.5, 0]]]} and not medium.ax
    bright = ramp("LINEAR", [(0.0, (0.1, 0.0, 0.0)), (1.0, (1.0, 0.5, 0.0))])
    shader = fed(principled(Density_Attribute="d", Emission_Strength=3.0), Emission_Color=bright)
    with pytest.raises(NotMapped, match="a colour of node 'Ramp' at 0 that is not black"):
        nodes.medium_of(tree_of(shader), ["d", "e"])


def test_what_cannot_be_computed_is_named():
    def why(source, names=("d", "e")):
        with pytest.raises(NotMapped) as raised:
            nodes.medium_of(tree_of(fed(principled(Density_Attribute="d"), Density=source)), list(names))
        return str(raised.value)

    def noise(**values):
        settings = {"noise_dimensions": "3D", "noise_type": "FBM", "normalize": True, **values}
        sockets = {"Vector": None, "Scale": 5.0, "Detail": 2.0, "Roughness": 0.5, "Lacunarity": 2.0, "Distortion": 0.0}
        return node("ShaderNodeTexNoise", "Noise", outputs=("Fac",), values=settings, **sockets)

    voronoi = node("ShaderNodeTexVoronoi", "Cells", outputs=("Distance",))
    added = node("ShaderNodeMath", values={"operation": "ADD", "use_clamp": False}, A=0.0, B=0.0)
    assert why(fed(added, A=attribute("d"), B=voronoi)) == "node 'Cells' at 'B'"
    assert why(noise()) == "the inputs of node 'Noise'"  # its place is in the box of the volume, which has no name here
    assert why(noise(noise_dimensions="4D")) == "the settings of node 'Noise'"
    place = node("ShaderNodeTexCoord", "Place", outputs=("Generated",), values={"object": None})
    assert why(fed(noise(), Vector=place)) == "the output 'Generated' of node 'Place'"
    assert why(math_of("WRAP")) == "the operation WRAP of node 'WRAP'"
    assert why(math_of("ADD"), ["d"]) == "the grid e: the volume has d"
    odd = fed(math_of("ADD"))
    odd.inputs["B"].links.clear()
    assert why(fed(odd, B=attribute("a b")), ["d", "a b"]) == "the name of the grid 'a b' in an expression"
