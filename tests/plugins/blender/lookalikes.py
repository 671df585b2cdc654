# SPDX-License-Identifier: Apache-2.0
# Nodes as the add-on sees those of Blender, for tests without it.
from types import SimpleNamespace


class Socket:
    def __init__(self, name, value=None):
        self.name, self.default_value, self.links = name, value, []


class Inputs(dict):
    def __getitem__(self, key):
        return list(self.values())[key] if isinstance(key, int) else dict.__getitem__(self, key)

    def __iter__(self):
        return iter(self.values())


def node(kind, name="", outputs=("Out",), values=None, **sockets):
    inputs = Inputs((n.replace("_", " "), Socket(n.replace("_", " "), v)) for n, v in sockets.items())
    fields = {"bl_idname": kind, "name": name or kind, "inputs": inputs, "outputs": [Socket(o) for o in outputs]}
    return SimpleNamespace(**fields, **(values or {}))


def link(source, target, socket, output=0):
    made = SimpleNamespace(from_node=source, from_socket=source.outputs[output])
    target.inputs[socket].links.append(made)


def principled(**values):
    sockets = {
        "Color": (0.5, 0.5, 0.5, 1), "Color_Attribute": "", "Density": 1.0, "Density_Attribute": "density",
        "Anisotropy": 0.0, "Absorption_Color": (0, 0, 0, 1), "Emission_Strength": 0.0,
        "Emission_Color": (1, 1, 1, 1), "Blackbody_Intensity": 0.0, "Blackbody_Tint": (1, 1, 1, 1),
        "Temperature": 1000.0, "Temperature_Attribute": "temperature",
    }  # fmt: skip
    return node("ShaderNodeVolumePrincipled", **{**sockets, **values})


def tree_of(*shaders):
    output = node("ShaderNodeOutputMaterial", Volume=None, Surface=None, values={"is_active_output": True})
    nodes_, last = [output, *shaders], shaders[0]
    for other in shaders[1:]:
        add = node("ShaderNodeAddShader", A=None, B=None)
        link(last, add, "A"), link(other, add, "B")
        nodes_.append(add)
        last = add
    link(last, output, "Volume")
    return SimpleNamespace(nodes=nodes_)
