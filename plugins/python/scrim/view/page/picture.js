// SPDX-License-Identifier: Apache-2.0
// Draws pictures with WebGL 2: sums layers by their weights, and shows the sum through exposure, a view's table and gamma.
//
// The sum is kept in a texture of half floats, no larger than what the canvas shows. Other weights need one pass over it,
// another exposure none.

const LAYERS_A_PASS = 12; // every WebGL 2 has 16 textures
// When quick sums become coarser or finer: at less than half of 60 draws a second, or at nearly all of them.
const SLOW_MS = 40;
const FAST_MS = 18;
const MOST_DIVISOR = 4;
const CORNERS = `#version 300 es
out vec2 uv;
void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0;
    uv = vec2(corner.x, corner.y);
    gl_Position = vec4(corner * 2.0 - 1.0, 0.0, 1.0);
}`;

function sumShader(count) {
    const layers = Array.from({ length: count }, (_, i) => i);
    return `#version 300 es
precision highp float;
in vec2 uv;
out vec4 sum;
${layers.map((i) => `uniform sampler2D layer${i};`).join("\n")}
uniform vec4 weights[${count}];
void main() {
    sum = ${layers.map((i) => `texture(layer${i}, uv) * weights[${i}]`).join(" + ")};
}`;
}

// Rows of pictures go from top to bottom, so they are upside down in textures, and upright in the canvas.
const SHOW = `#version 300 es
precision highp float;
precision highp sampler3D;
in vec2 uv;
out vec4 shown;
uniform sampler2D now, before;
uniform sampler3D table;
uniform float gain, gamma, wipe, knee, reach, size;
void main() {
    vec2 at = vec2(uv.x, 1.0 - uv.y);
    vec3 colour = uv.x < wipe ? texture(before, at).rgb : texture(now, at).rgb;
    vec3 place = log2(1.0 + knee * max(colour * gain, 0.0)) / reach;
    colour = texture(table, (clamp(place, 0.0, 1.0) * (size - 1.0) + 0.5) / size).rgb;
    shown = vec4(pow(colour, vec3(1.0 / gamma)), 1.0);
}`;

export class Picture {
    constructor(canvas) {
        this.canvas = canvas;
        const gl = canvas.getContext("webgl2", { alpha: false, antialias: false, preserveDrawingBuffer: true });
        if (!gl || !gl.getExtension("EXT_color_buffer_float")) {
            throw new Error("this browser has no WebGL 2 with pictures of half floats, which the viewer needs");
        }
        this.gl = gl;
        gl.getExtension("OES_texture_float_linear");
        this.textures = new Map(); // number -> { texture, width, height }
        this.slots = {};
        this.weights = null;
        this.exposure = 0;
        this.gamma = 1;
        this.wipe = 0;
        this.full = [canvas.width, canvas.height];
        this.divisor = 1; // of the pixels of quick sums
        this.drawn = 1; // that of the sum that is there
        this.programs = new Map();
        this.show = this.#program(SHOW);
        this.sum = this.#target();
        this.snapshot = this.#target();
        this.probe = this.#target();
        this.frames = gl.createFramebuffer();
        this.isStale = true;
    }

    /** A view's table: half floats, red fastest. */
    setTable(head, bytes) {
        const gl = this.gl;
        this.table ??= gl.createTexture();
        this.head = head;
        gl.bindTexture(gl.TEXTURE_3D, this.table);
        gl.pixelStorei(gl.UNPACK_ALIGNMENT, 2);
        gl.texImage3D(gl.TEXTURE_3D, 0, gl.RGB16F, head.size, head.size, head.size, 0, gl.RGB, gl.HALF_FLOAT, halves(bytes, 0, 3 * head.size ** 3));
        for (const name of ["MIN_FILTER", "MAG_FILTER"]) gl.texParameteri(gl.TEXTURE_3D, gl[`TEXTURE_${name}`], gl.LINEAR);
        for (const name of ["S", "T", "R"]) gl.texParameteri(gl.TEXTURE_3D, gl[`TEXTURE_WRAP_${name}`], gl.CLAMP_TO_EDGE);
    }

    /** Pictures of the slots; those that are not fresh are here already. */
    setPictures(head, bytes) {
        const gl = this.gl;
        let offset = 0;
        for (const { number, shape } of head.fresh) {
            const [height, width, channels] = shape;
            const texture = gl.createTexture();
            this.#bindPlain(texture);
            gl.pixelStorei(gl.UNPACK_ALIGNMENT, 2);
            const formats = channels === 4 ? [gl.RGBA16F, gl.RGBA] : [gl.RGB16F, gl.RGB];
            gl.texImage2D(gl.TEXTURE_2D, 0, formats[0], width, height, 0, formats[1], gl.HALF_FLOAT, halves(bytes, offset, width * height * channels));
            offset += 2 * width * height * channels;
            this.textures.set(number, { texture, width, height });
        }
        const used = new Set(Object.values(head.slots));
        for (const [number, { texture }] of this.textures) {
            if (!used.has(number)) {
                gl.deleteTexture(texture);
                this.textures.delete(number);
            }
        }
        this.slots = head.slots;
        this.setWeights(head.weights);
    }

    /** Factors of layers by name; null: the beauty is the picture. */
    setWeights(weights) {
        this.weights = weights;
        this.isStale = true;
    }

    get isReady() {
        return this.slots.beauty !== undefined && this.table !== undefined;
    }

    /** Width and height of the picture that was rendered. */
    get size() {
        const { width, height } = this.textures.get(this.slots.beauty);
        return [width, height];
    }

    /** Sets how many pixels the canvas has, unless a draw is quick. */
    resize(width, height) {
        const [before, below] = this.full;
        this.full = [width, height];
        this.isStale ||= before !== width || below !== height;
    }

    /** `isQuick`: coarser where the graphics unit is slow (`tookTo`); the next draw makes up for it. */
    draw(isQuick = false) {
        if (!this.isReady) return;
        const gl = this.gl;
        this.#bringUp(isQuick);
        const { canvas } = this;
        const [across, down] = this.full.map((n) => Math.ceil(n / this.drawn));
        if (canvas.width !== across || canvas.height !== down) [canvas.width, canvas.height] = [across, down];
        gl.bindFramebuffer(gl.FRAMEBUFFER, null);
        gl.viewport(0, 0, this.canvas.width, this.canvas.height);
        gl.useProgram(this.show.program);
        const { now, before, table, gain, gamma, wipe, knee, reach, size } = this.show.places;
        this.#unit(0, this.sum.texture, now);
        this.#unit(1, this.snapshot.width ? this.snapshot.texture : this.sum.texture, before);
        gl.activeTexture(gl.TEXTURE2);
        gl.bindTexture(gl.TEXTURE_3D, this.table);
        gl.uniform1i(table, 2);
        gl.uniform1f(gain, 2 ** this.exposure);
        gl.uniform1f(gamma, this.gamma);
        gl.uniform1f(wipe, this.wipe);
        gl.uniform1f(knee, this.head.knee);
        gl.uniform1f(reach, Math.log2(1 + this.head.knee * this.head.most));
        gl.uniform1f(size, this.head.size);
        gl.drawArrays(gl.TRIANGLES, 0, 3);
    }

    /** Keeps the picture as the one to compare with. */
    keepSnapshot() {
        const gl = this.gl;
        this.#bringUp();
        const { width, height } = this.sum;
        this.#resize(this.snapshot, width, height);
        gl.bindFramebuffer(gl.READ_FRAMEBUFFER, this.#framed(this.sum));
        this.#bindPlain(this.snapshot.texture);
        gl.copyTexSubImage2D(gl.TEXTURE_2D, 0, 0, 0, 0, 0, width, height);
    }

    /** Premultiplied scene-linear R, G, B, A of the rendered picture at (0..1, 0..1 from the top), to half floats. */
    valueAt(x, y) {
        if (this.slots.beauty === undefined) return null;
        const gl = this.gl;
        const [width, height] = this.size;
        const at = [Math.min(Math.floor(x * width), width - 1), Math.min(Math.floor(y * height), height - 1)];
        // The pixel is the only one of the sum that falls into the target.
        this.#resize(this.probe, 1, 1);
        this.#addUp(this.probe, -at[0], -at[1], width, height);
        const value = new Float32Array(4);
        gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.FLOAT, value);
        return value;
    }

    /** Hears how many milliseconds a draw took to the screen. Without a graphics unit a sum of layers takes long. */
    tookTo(milliseconds) {
        if (milliseconds > SLOW_MS) this.divisor = Math.min(this.divisor + 1, MOST_DIVISOR);
        else if (milliseconds < FAST_MS) this.divisor = Math.max(this.divisor - 1, 1);
    }

    /** What the canvas shows: R, G, B, A from 0 to 255, rows from bottom to top. */
    readPixels() {
        const gl = this.gl;
        this.draw();
        const { width, height } = this.canvas;
        const bytes = new Uint8Array(4 * width * height);
        gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
        return [...bytes];
    }

    #bringUp(isQuick = false) {
        const divisor = isQuick ? this.divisor : 1;
        if (!this.isStale && divisor >= this.drawn) return;
        this.isStale = false;
        this.drawn = divisor;
        const [width, height] = this.size;
        const size = [Math.min(width, this.full[0]), Math.min(height, this.full[1])].map((n) => Math.ceil(n / divisor));
        this.#resize(this.sum, ...size);
        this.#addUp(this.sum, 0, 0, ...size);
    }

    #addUp(target, left, top, width, height) {
        const gl = this.gl;
        // The beauty gives the alpha, and the colour where no weight differs from 1.
        const all = [[this.slots.beauty, this.weights ? [0, 0, 0, 1] : [1, 1, 1, 1]]];
        if (this.weights) {
            if (this.slots.rest !== undefined) all.push([this.slots.rest, [1, 1, 1, 0]]);
            for (const [name, weight] of Object.entries(this.weights)) {
                if (this.slots[name] !== undefined && weight.some((w) => w !== 0)) all.push([this.slots[name], [...weight, 0]]);
            }
        }
        gl.bindFramebuffer(gl.FRAMEBUFFER, this.#framed(target));
        gl.viewport(left, top, width, height);
        gl.blendFunc(gl.ONE, gl.ONE);
        for (let first = 0; first < all.length; first += LAYERS_A_PASS) {
            const some = all.slice(first, first + LAYERS_A_PASS);
            const { program, places } = this.#sumOf(some.length);
            if (first > 0) gl.enable(gl.BLEND);
            gl.useProgram(program);
            some.forEach(([number], i) => {
                const it = this.textures.get(number);
                this.#unit(i, it.texture, places[`layer${i}`]);
                // Coarse sums and those of the same size take one texel, which is cheaper.
                const isPlain = this.drawn > 1 || (it.width === width && it.height === height);
                gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, isPlain ? gl.NEAREST : gl.LINEAR);
            });
            gl.uniform4fv(places["weights[0]"], some.flatMap(([, weight]) => weight));
            gl.drawArrays(gl.TRIANGLES, 0, 3);
        }
        gl.disable(gl.BLEND);
    }

    #sumOf(count) {
        if (!this.programs.has(count)) this.programs.set(count, this.#program(sumShader(count)));
        return this.programs.get(count);
    }

    #program(fragments) {
        const gl = this.gl;
        const program = gl.createProgram();
        for (const [kind, text] of [[gl.VERTEX_SHADER, CORNERS], [gl.FRAGMENT_SHADER, fragments]]) {
            const shader = gl.createShader(kind);
            gl.shaderSource(shader, text);
            gl.compileShader(shader);
            gl.attachShader(program, shader);
        }
        gl.linkProgram(program);
        if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
        const places = {};
        for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); ++i) {
            const { name } = gl.getActiveUniform(program, i);
            places[name] = gl.getUniformLocation(program, name);
        }
        return { program, places };
    }

    #target() {
        return { texture: this.gl.createTexture(), width: 0, height: 0 };
    }

    #resize(target, width, height) {
        const gl = this.gl;
        if (target.width === width && target.height === height) return;
        this.#bindPlain(target.texture);
        gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA16F, width, height, 0, gl.RGBA, gl.HALF_FLOAT, null);
        Object.assign(target, { width, height });
    }

    #framed(target) {
        const gl = this.gl;
        gl.bindFramebuffer(gl.FRAMEBUFFER, this.frames);
        gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, target.texture, 0);
        return this.frames;
    }

    #bindPlain(texture) {
        const gl = this.gl;
        gl.activeTexture(gl.TEXTURE0);
        gl.bindTexture(gl.TEXTURE_2D, texture);
        for (const name of ["MIN_FILTER", "MAG_FILTER"]) gl.texParameteri(gl.TEXTURE_2D, gl[`TEXTURE_${name}`], gl.LINEAR);
        for (const name of ["S", "T"]) gl.texParameteri(gl.TEXTURE_2D, gl[`TEXTURE_WRAP_${name}`], gl.CLAMP_TO_EDGE);
    }

    #unit(index, texture, place) {
        const gl = this.gl;
        gl.activeTexture(gl.TEXTURE0 + index);
        gl.bindTexture(gl.TEXTURE_2D, texture);
        gl.uniform1i(place, index);
    }
}

function halves(bytes, offset, count) {
    return new Uint16Array(bytes.buffer, bytes.byteOffset + offset, count);
}
