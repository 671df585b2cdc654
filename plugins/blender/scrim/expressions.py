# SPDX-License-Identifier: Apache-2.0
# Nodes that compute with grids and places, as code in OpenVDB AX that runs at each voxel. The laws are those of Cycles'
# svm/*.h. What has no counterpart raises NotMapped. Nodes are used by their names alone, so that tests need no Blender.
import math
import re

_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_NAME = re.compile(_WORD.pattern + r"\Z")
_GREY = [0.2126, 0.7152, 0.0722]  # of Rec.709, in which Blender works unless its configuration is another one


class NotMapped(Exception):
    pass


def source_of(socket):
    """(node, name of its output) that feeds the socket, past reroutes."""
    while socket.links:
        link = socket.links[0]
        node = link.from_node
        if node.bl_idname != "NodeReroute":
            return node, link.from_socket.name
        socket = node.inputs[0]
    return None, ""


def constant_of(socket):
    value = socket.default_value
    return [float(v) for v in list(value)[:3]] if hasattr(value, "__len__") else [float(value)] * 3


def _number(value):
    text = repr(float(value))
    if text in ("inf", "-inf", "nan"):
        raise NotMapped(f"the number {text}")
    return f"{text}f" if value >= 0 else f"({text}f)"


# `{0}`, `{1}`, ... are the inputs, which are variables. Divisions by 0 give 0, and so do roots of what is below 0.
_MATH = {
    "ADD": "{0} + {1}",
    "SUBTRACT": "{0} - {1}",
    "MULTIPLY": "{0} * {1}",
    "DIVIDE": "{1} == 0.0f ? 0.0f : {0} / {1}",
    "MULTIPLY_ADD": "{0} * {1} + {2}",
    "POWER": "{0} < 0.0f && {1} != round({1}) ? 0.0f : pow({0}, {1})",
    "LOGARITHM": "{0} <= 0.0f || {1} <= 0.0f || {1} == 1.0f ? 0.0f : log({0}) / log({1})",
    "SQRT": "sqrt(max({0}, 0.0f))",
    "INVERSE_SQRT": "{0} > 0.0f ? 1.0f / sqrt({0}) : 0.0f",
    "ABSOLUTE": "abs({0})",
    "EXPONENT": "exp({0})",
    "MINIMUM": "min({0}, {1})",
    "MAXIMUM": "max({0}, {1})",
    "LESS_THAN": "{0} < {1} ? 1.0f : 0.0f",
    "GREATER_THAN": "{0} > {1} ? 1.0f : 0.0f",
    "SIGN": "{0} > 0.0f ? 1.0f : {0} < 0.0f ? -1.0f : 0.0f",
    "COMPARE": "{0} == {1} || abs({0} - {1}) <= max({2}, 1e-5f) ? 1.0f : 0.0f",
    "ROUND": "floor({0} + 0.5f)",
    "FLOOR": "floor({0})",
    "CEIL": "ceil({0})",
    "TRUNC": "{0} >= 0.0f ? floor({0}) : ceil({0})",
    "FRACT": "{0} - floor({0})",
    "FLOORED_MODULO": "{1} == 0.0f ? 0.0f : {0} - floor({0} / {1}) * {1}",
    "SNAP": "{1} == 0.0f ? 0.0f : floor({0} / {1}) * {1}",
    "SINE": "sin({0})",
    "COSINE": "cos({0})",
    "TANGENT": "tan({0})",
    "ARCTANGENT": "atan({0})",
    "ARCTAN2": "atan2({0}, {1})",
    "RADIANS": "{0} * 0.017453292519943295f",
    "DEGREES": "{0} * 57.29577951308232f",
}
_VECTOR_MATH = {
    "ADD": "{0} + {1}",
    "SUBTRACT": "{0} - {1}",
    "MULTIPLY": "{0} * {1}",
    "CROSS_PRODUCT": "cross({0}, {1})",
    "MULTIPLY_ADD": "{0} * {1} + {2}",
    "DOT_PRODUCT": "dot({0}, {1})",
    "LENGTH": "length({0})",
    "DISTANCE": "length({0} - {1})",
    "NORMALIZE": "length({0}) > 0.0f ? {0} / length({0}) : {0}",
}
_BY_COMPONENT = {"DIVIDE", "ABSOLUTE", "MINIMUM", "MAXIMUM", "FLOOR", "CEIL", "SNAP", "SINE", "COSINE", "TANGENT"}
_NUMBERS = {"DOT_PRODUCT", "LENGTH", "DISTANCE"}  # of vectors
_BLENDS = {  # with the factor {0}, of what is below {1} and on top {2}
    "MIX": "{1} + ({2} - {1}) * {0}",
    "ADD": "{1} + {2} * {0}",
    "SUBTRACT": "{1} - {2} * {0}",
    "MULTIPLY": "{1} * (1.0f - {0} + {2} * {0})",
    "DARKEN": "min({1}, {2}) * {0} + {1} * (1.0f - {0})",
    "LIGHTEN": "max({1}, {2}) * {0} + {1} * (1.0f - {0})",
    "SCREEN": "1.0f - (1.0f - {0} + {0} * (1.0f - {2})) * (1.0f - {1})",
    "DIFFERENCE": "{1} * (1.0f - {0}) + abs({1} - {2}) * {0}",
}
_MAPPED = {
    "LINEAR": "{t}",
    "STEPPED": "{s} > 0.0f ? floor({t} * ({s} + 1.0f)) / {s} : 0.0f",
    "SMOOTHSTEP": "{t} * {t} * (3.0f - 2.0f * {t})",
    "SMOOTHERSTEP": "{t} * {t} * {t} * ({t} * ({t} * 6.0f - 15.0f) + 10.0f)",
}


class Code:
    """Statements, and the variables that hold what nodes give: ("v3", True) for a vector. `vectors` are the names of
    those of the volume's `grids` that hold vectors."""

    def __init__(self, grids, vectors=()):
        self.grids, self.vectors = grids, set(vectors)
        self.lines, self.made, self._known = [], {}, {}
        self._kept = []  # nodes, so that none gets the identity of another
        self._varying = set()  # names of variables that depend on grids or on the place

    @property
    def text(self):
        return "\n".join(self.lines)

    # Grids

    def grid(self, variable, least=None):
        """A new grid that holds the variable; returns its name."""
        name, vector = f"scrim_{len(self.made) + 1}", variable[1]
        text = variable[0] if least is None else f"max({variable[0]}, {_number(least)})"
        self.made[name] = self._new(text, vector)
        self.lines.append(f"{'v' if vector else 'f'}@{name} = {self.made[name][0]};")
        return name

    def variable_of(self, name):
        return self.made.get(name) or self.read(name)

    def read(self, name):
        if name not in self.grids:
            has = ", ".join(self.grids) or "none"
            raise NotMapped(f"the grid {name}: the volume has {has}")
        if not _NAME.match(name):
            raise NotMapped(f"the name of the grid '{name}' in an expression")
        vector = name in self.vectors
        return self._known.get(("@", name)) or self._new(f"{'v' if vector else 'f'}@{name}", vector, ("@", name))

    def _new(self, text, vector, key=None):
        variable = (f"v{len(self._known) + len(self.lines)}", vector)
        self.lines.append(f"{'vec3f' if vector else 'float'} {variable[0]} = {text};")
        if "@" in text or "getvoxelpws" in text or self._varying.intersection(_WORD.findall(text)):
            self._varying.add(variable[0])
        if key is not None:
            self._known[key] = variable
        return variable

    def varies(self, variable):
        return variable[0] in self._varying

    # Conversions

    def scalar(self, variable, colour=False):
        name, vector = variable
        if not vector:
            return variable
        weights = _GREY if colour else [1 / 3] * 3
        return self._new(" + ".join(f"{_number(w)} * {name}.{c}" for w, c in zip(weights, "xyz")), False)

    def vector(self, variable):
        return variable if variable[1] else self._new("{ %s, %s, %s }" % ((variable[0],) * 3), True)

    # Sockets

    def of(self, socket, vector=False):
        """The variable of what comes in, as a vector or a number."""
        node, output = source_of(socket)
        if node is None:
            numbers = constant_of(socket)
            if vector:
                return self._new("{ %s }" % ", ".join(map(_number, numbers)), True)
            return self._new(_number(numbers[0] if len(set(numbers)) == 1 else sum(numbers) / 3), False)
        self._kept.append(node)
        key = (node.as_pointer() if hasattr(node, "as_pointer") else id(node), output)
        variable = self._known.get(key)
        if variable is None:
            make = getattr(self, "_" + node.bl_idname.removeprefix("ShaderNode").lower(), None)
            if make is None:
                raise NotMapped(f"node '{node.name}' at '{socket.name}'")
            first = len(self.lines)
            variable = self._known[key] = make(node, output)
            if self._varying.intersection(_WORD.findall(" ".join(self.lines[first:]))):
                self._varying.add(variable[0])
        # All results of a Mix node have one name; its data type tells a colour from a vector.
        colour = output == "Color" or (output == "Result" and getattr(node, "data_type", "") == "RGBA")
        return self.vector(variable) if vector else self.scalar(variable, colour)

    def _value(self, node, output):
        return self._new(_number(node.outputs[0].default_value), False)

    def _rgb(self, node, output):
        numbers = [float(v) for v in list(node.outputs[0].default_value)[:3]]
        return self._new("{ %s }" % ", ".join(map(_number, numbers)), True)

    def _attribute(self, node, output):
        if node.attribute_type != "GEOMETRY" or output == "Alpha":
            raise NotMapped(f"the output '{output}' of node '{node.name}'")
        variable = self.read(node.attribute_name)
        return self.scalar(variable) if output in ("Fac", "Factor") else variable

    def _volumeinfo(self, node, output):
        return self.read({"Density": "density", "Flame": "flame", "Temperature": "temperature"}.get(output, "color"))

    def _texcoord(self, node, output):
        if output != "Object" or getattr(node, "object", None) is not None:
            raise NotMapped(f"the output '{output}' of node '{node.name}'")
        return self._new("getvoxelpws()", True)

    def _mapping(self, node, output):
        x, y, z = constant_of(node.inputs["Rotation"])
        fixed = not any(node.inputs[name].links for name in ("Location", "Rotation", "Scale") if name in node.inputs)
        if node.vector_type != "POINT" or not fixed:
            raise NotMapped(f"the inputs of node '{node.name}'")
        p = self.of(node.inputs["Vector"], True)[0]
        scale, location = constant_of(node.inputs["Scale"]), constant_of(node.inputs["Location"])
        (cx, sx), (cy, sy), (cz, sz) = ((math.cos(a), math.sin(a)) for a in (x, y, z))
        rows = [
            [cy * cz, sx * sy * cz - cx * sz, cx * sy * cz + sx * sz],
            [cy * sz, sx * sy * sz + cx * cz, cx * sy * sz - sx * cz],
            [-sy, sx * cy, cx * cy],
        ]
        parts = [
            " + ".join([f"{_number(row[i] * scale[i])} * {p}.{'xyz'[i]}" for i in range(3)] + [_number(at)])
            for row, at in zip(rows, location)
        ]
        return self._new("{ %s }" % ", ".join(parts), True)

    def _separatexyz(self, node, output):
        return self._new(f"{self.of(node.inputs[0], True)[0]}.{output.lower()}", False)

    def _combinexyz(self, node, output):
        return self._new("{ %s }" % ", ".join(self.of(node.inputs[i])[0] for i in range(3)), True)

    def _clamp(self, node, output):
        value, low, high = (self.of(node.inputs[i])[0] for i in range(3))
        if getattr(node, "clamp_type", "MINMAX") != "MINMAX":
            raise NotMapped(f"the way in which node '{node.name}' clamps")
        return self._new(f"min(max({value}, {low}), {high})", False)

    def _math(self, node, output):
        if node.operation not in _MATH:
            raise NotMapped(f"the operation {node.operation} of node '{node.name}'")
        law = _MATH[node.operation]
        inputs = [self.of(node.inputs[i])[0] for i in range(3) if "{%d}" % i in law]
        made = self._new(law.format(*inputs), False)
        return self._new(f"clamp({made[0]}, 0.0f, 1.0f)", False) if node.use_clamp else made

    def _vectormath(self, node, output):
        kind = node.operation
        if kind == "SCALE":
            factor = self.of(node.inputs["Scale"])
            return self._new(f"{self.of(node.inputs[0], True)[0]} * {factor[0]}", True)
        kind = {"FRACTION": "FRACT"}.get(kind, kind)
        if kind in _BY_COMPONENT or kind == "FRACT":
            law = _MATH[kind]
            inputs = [self.of(node.inputs[i], True)[0] for i in range(2) if "{%d}" % i in law]
            parts = [self._new(law.format(*(f"{name}.{c}" for name in inputs)), False)[0] for c in "xyz"]
            return self._new("{ %s }" % ", ".join(parts), True)
        if kind not in _VECTOR_MATH:
            raise NotMapped(f"the operation {kind} of node '{node.name}'")
        law = _VECTOR_MATH[kind]
        inputs = [self.of(node.inputs[i], True)[0] for i in range(3) if "{%d}" % i in law]
        return self._new(law.format(*inputs), kind not in _NUMBERS)

    def _maprange(self, node, output):
        kind = node.interpolation_type
        if getattr(node, "data_type", "FLOAT") != "FLOAT" or kind not in _MAPPED:
            raise NotMapped(f"the settings of node '{node.name}'")
        value, low, high, first, last = (self.of(node.inputs[i])[0] for i in range(5))
        t = self._new(f"{low} == {high} ? 0.0f : ({value} - {low}) / ({high} - {low})", False)[0]
        if kind.startswith("SMOOTH"):
            t = self._new(f"clamp({t}, 0.0f, 1.0f)", False)[0]
        steps = self.of(node.inputs["Steps"])[0] if kind == "STEPPED" else ""
        t = self._new(_MAPPED[kind].format(t=t, s=steps), False)[0]
        made = self._new(f"{low} == {high} ? 0.0f : {first} + {t} * ({last} - {first})", False)
        if not node.clamp or kind.startswith("SMOOTH"):
            return made
        return self._new(f"min(max({made[0]}, min({first}, {last})), max({first}, {last}))", False)

    def _valtorgb(self, node, output):
        ramp = node.color_ramp
        if output != "Color" or ramp.color_mode != "RGB" or ramp.interpolation not in ("LINEAR", "CONSTANT", "EASE"):
            raise NotMapped(f"the settings of node '{node.name}'")
        t = self.of(node.inputs[0])[0]
        points = [(float(e.position), [float(c) for c in list(e.color)[:3]]) for e in ramp.elements]
        made = self._new("{ %s }" % ", ".join(map(_number, points[0][1])), True)
        for (low, a), (high, b) in zip(points, points[1:]):
            if high <= low or ramp.interpolation == "CONSTANT":
                step = _number(high)
                self.lines.append(f"if ({t} >= {step}) {made[0]} = {{ {', '.join(map(_number, b))} }};")
                continue
            u = self._new(f"clamp(({t} - {_number(low)}) / {_number(high - low)}, 0.0f, 1.0f)", False)[0]
            if ramp.interpolation == "EASE":
                u = self._new(_MAPPED["SMOOTHSTEP"].format(t=u), False)[0]
            parts = [f"{_number(x)} + {_number(y - x)} * {u}" for x, y in zip(a, b)]
            self.lines.append(f"if ({t} >= {_number(low)}) {made[0]} = {{ {', '.join(parts)} }};")
        return made

    def _mix(self, node, output):
        kind = getattr(node, "data_type", "RGBA")
        first = {"FLOAT": 2, "VECTOR": 4, "RGBA": 6}.get(kind)
        if first is None:
            raise NotMapped(f"the settings of node '{node.name}'")
        blend = node.blend_type if kind == "RGBA" else "MIX"
        result = node.clamp_result if kind == "RGBA" else False
        factor = 1 if kind == "VECTOR" and node.factor_mode == "NON_UNIFORM" else 0
        return self._mixed(node, (factor, first, first + 1), blend, node.clamp_factor, result, kind != "FLOAT")

    def _mixrgb(self, node, output):
        return self._mixed(node, (0, 1, 2), node.blend_type, True, node.use_clamp, True)

    def _mixed(self, node, sockets, blend, clamp_factor, clamp_result, vector):
        if blend not in _BLENDS:
            raise NotMapped(f"the blending {blend} of node '{node.name}'")
        by_component = sockets[0] == 1  # each component has a factor of its own
        factor = self.of(node.inputs[sockets[0]], by_component)[0]
        factors = [f"{factor}.{c}" if by_component else factor for c in "xyz"]
        if clamp_factor:
            factors = [f"clamp({f}, 0.0f, 1.0f)" for f in factors]
        a, b = (self.of(node.inputs[i], vector)[0] for i in sockets[1:])
        law = _BLENDS[blend]
        if not vector:
            return self._new(law.format(factors[0], a, b), False)
        parts = [law.format(f, f"{a}.{c}", f"{b}.{c}") for f, c in zip(factors, "xyz")]
        if clamp_result:
            parts = [f"clamp({part}, 0.0f, 1.0f)" for part in parts]
        return self._new("{ %s }" % ", ".join(parts), True)

    def _texnoise(self, node, output):
        """Perlin's noise with Cycles' hash (svm/noise.h, util/hash.h): the sum of octaves, from 0 to 1."""
        kind = getattr(node, "noise_type", "FBM")
        fixed = not node.inputs["Distortion"].links and constant_of(node.inputs["Distortion"])[0] == 0
        detail = node.inputs["Detail"]
        if output not in ("Fac", "Factor") or node.noise_dimensions != "3D" or kind != "FBM" or not fixed:
            raise NotMapped(f"the settings of node '{node.name}'")
        if detail.links or not node.inputs["Vector"].links:
            raise NotMapped(f"the inputs of node '{node.name}'")
        p, scale = self.of(node.inputs["Vector"], True)[0], self.of(node.inputs["Scale"])[0]
        roughness = self.of(node.inputs["Roughness"])[0]
        lacunarity = self.of(node.inputs["Lacunarity"])[0] if "Lacunarity" in node.inputs else "2.0f"
        made = self._new("0.0f", False)
        octaves = min(max(constant_of(detail)[0], 0.0), 15.0)
        law = _NOISE.replace("OUT", made[0]).replace("POINT", p).replace("SCALE", scale).replace("ROUGH", roughness)
        law = law.replace("LACUNARITY", lacunarity).replace("WHOLE", str(int(octaves)))
        law = law.replace("REST", _number(octaves - int(octaves)))
        self.lines.append(law.replace("NORMALIZE", "1" if getattr(node, "normalize", True) else "0"))
        return made


def _rot(x, k):
    return f"(({x} << {k}) | (({x} >> {32 - k}) & {(1 << k) - 1}))"


def _final():
    """Jenkins' last mixing of three words."""
    steps = ("cb14", "ac11", "ba25", "cb16", "ac4", "ba14", "cb24")
    return " ".join(f"{s[0]} = {s[0]} ^ {s[1]}; {s[0]} = {s[0]} - {_rot(s[1], int(s[2:]))};" for s in steps)


_NOISE = (
    """{
  float amp = 1.0f, most = 0.0f, sum = 0.0f, freq = SCALE;
  int last = REST > 0.0f ? WHOLE + 1 : WHOLE;
  for (int octave = 0; octave <= last; ++octave) {
    vec3f q = POINT * freq;
    float bx = floor(q.x), by = floor(q.y), bz = floor(q.z);
    float fx = q.x - bx, fy = q.y - by, fz = q.z - bz;
    float ux = fx * fx * fx * (fx * (fx * 6.0f - 15.0f) + 10.0f);
    float uy = fy * fy * fy * (fy * (fy * 6.0f - 15.0f) + 10.0f);
    float uz = fz * fz * fz * (fz * (fz * 6.0f - 15.0f) + 10.0f);
    float total = 0.0f;
    for (int corner = 0; corner < 8; ++corner) {
      int dx = corner & 1, dy = (corner >> 1) & 1, dz = corner >> 2;
      int a = -559038712, b = -559038712, c = -559038712;
      a += int(bx) + dx; b += int(by) + dy; c += int(bz) + dz;
      """
    + _final()
    + """
      int h = c & 15;
      float x = fx - dx, y = fy - dy, z = fz - dz;
      float u = h < 8 ? x : y;
      float v = h < 4 ? y : (h == 12 || h == 14 ? x : z);
      float w = (dx == 1 ? ux : 1.0f - ux) * (dy == 1 ? uy : 1.0f - uy) * (dz == 1 ? uz : 1.0f - uz);
      total += w * (((h & 1) != 0 ? -u : u) + ((h & 2) != 0 ? -v : v));
    }
    total *= 0.982f;
    if (octave <= WHOLE) {
      sum += total * amp; most += amp;
      OUT = NORMALIZE == 1 ? 0.5f * sum / most + 0.5f : sum;
    } else {
      float more = NORMALIZE == 1 ? 0.5f * (sum + total * amp) / (most + amp) + 0.5f : sum + total * amp;
      OUT = OUT + (more - OUT) * REST;
    }
    amp *= clamp(ROUGH, 0.0f, 1.0f);
    freq *= LACUNARITY;
  }
}"""
)
