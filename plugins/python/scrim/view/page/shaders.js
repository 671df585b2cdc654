// SPDX-License-Identifier: Apache-2.0
// The programs of the graphics unit. Switches leave out of them what is not wanted.

export const CORNERS = `#version 300 es
out vec2 uv;
void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0;
    uv = vec2(corner.x, corner.y);
    gl_Position = vec4(corner * 2.0 - 1.0, 0.0, 1.0);
}`;

// A picture from another view: a grid of points that lie where the picture saw something, or else in the plane through the
// pivot, seen from the view `to`. A view is what the viewer sends as a camera; `Lens` is its (width, flat, shift).
export const CELLS = [96, 54]; // of the grid
export const GRID = `#version 300 es
precision highp float;
uniform sampler2D ahead; // the mean depth in green, 0 where nothing is
uniform mat4 from, to;
uniform vec4 fromLens, toLens;
uniform float aspect, distance;
out vec2 uv;
void main() {
    int cell = gl_VertexID / 6, corner = gl_VertexID % 6;
    ivec2 step = ivec2(corner == 1 || corner == 4 || corner == 5, corner == 2 || corner == 3 || corner == 5);
    vec2 at = vec2(ivec2(cell % ${CELLS[0]}, cell / ${CELLS[0]}) + step) / vec2(${CELLS});
    uv = vec2(at.x, 1.0 - at.y);
    ivec2 size = textureSize(ahead, 0);
    float depth = texelFetch(ahead, min(ivec2(at * vec2(size)), size - 1), 0).g;
    if (depth <= 0.0) depth = distance;
    vec2 film = vec2(uv.x - 0.5, (uv.y - 0.5) / aspect) + fromLens.zw;
    vec3 place = vec3(film * fromLens.x * (fromLens.y > 0.0 ? 1.0 : depth), -depth);
    vec3 seen = transpose(mat3(to)) * ((from * vec4(place, 1.0)).xyz - to[3].xyz);
    float w = toLens.y > 0.0 ? 1.0 : -seen.z;
    float order = (-seen.z - distance) / (abs(seen.z) + distance); // nearer is less, between -1 and 1
    gl_Position = vec4(2.0 * (seen.xy / toLens.x - toLens.zw * w) * vec2(1.0, aspect), order * w, w);
}`;

// Rows of pictures go from top to bottom, so they are upside down in textures, and upright in the canvas.
const SHOW = `
#ifdef WIPE
    if (uv.x < wipe) sum = texture(before, at);
#endif
    vec3 colour = sum.rgb;
#ifdef FALSE
    float value = dot(sum, pick) + shift;
    float part = clamp((value - low) / (high - low), 0.0, 1.0);
    colour = value <= hole ? vec3(0.0) : clamp(1.5 - abs(4.0 * part - vec3(3.0, 2.0, 1.0)), 0.0, 1.0);
    result = vec4(colour, 1.0);
#else
#ifdef PLATE
    colour += (1.0 - clamp(sum.a, 0.0, 1.0)) * texture(plate, at).rgb;
#endif
    float alpha = 1.0;
#ifdef APART
    alpha = clamp(sum.a, 0.0, 1.0);
    colour /= max(alpha, 1e-4);
#endif
    vec3 place = log2(1.0 + knee * max(colour * gain, 0.0)) / reach;
    colour = texture(table, (clamp(place, 0.0, 1.0) * (size - 1.0) + 0.5) / size).rgb;
#ifdef GAMMA
    colour = pow(colour, vec3(1.0 / gamma));
#endif
    result = vec4(colour * alpha, alpha);
#endif`;

/** Sums layers by weights; `isShown`: and shows the sum, as `switches` say: FALSE; WIPE; GAMMA; PLATE, over
    the plate; APART, with its alpha, for what is laid over another picture later. */
export function shader(count, isShown, switches) {
    const layers = Array.from({ length: count }, (_, i) => i);
    return `#version 300 es
${switches.map((name) => `#define ${name}`).join("\n")}
precision highp float;
precision highp sampler3D;
in vec2 uv;
out vec4 result;
${layers.map((i) => `uniform sampler2D layer${i};`).join("\n")}
uniform vec4 weights[${count}];
uniform sampler2D before, plate;
uniform sampler3D table;
uniform float gain, gamma, wipe, knee, reach, size;
uniform vec4 pick;
uniform float shift, low, high, hole;
vec4 of(sampler2D layer, vec2 at) { return texelFetch(layer, ivec2(at * vec2(textureSize(layer, 0))), 0); }
void main() {
    vec2 at = ${isShown ? "vec2(uv.x, 1.0 - uv.y)" : "uv"};
    vec4 sum = ${layers.map((i) => `of(layer${i}, at) * weights[${i}]`).join(" + ")};
    ${isShown ? SHOW : "result = sum;"}
}`;
}

export const COPY = `#version 300 es
precision highp float;
in vec2 uv;
out vec4 result;
uniform sampler2D layer0;
void main() { result = texture(layer0, uv); }`;

/** A part of a picture that is warped. */
export const SHARE = `#version 300 es
precision highp float;
in vec2 uv;
out vec4 result;
uniform sampler2D layer0;
uniform float share;
void main() { result = texture(layer0, uv) * share; }`;
