// SPDX-License-Identifier: Apache-2.0
// Draws pictures with WebGL 2: sums layers by their weights, and shows the sum through exposure, a view's table and gamma.
//
// One pass does all of it. It has a program for each number of layers, and for what is switched on: without a graphics
// unit every operation on a pixel counts. Layers are brought to the size of the canvas once, so that the pass reads one
// texel of each. The canvas has no more pixels than the picture has, nor than the screen shows.
//
// While the view moves, pictures come from views that it has left already, and are coarse. So a picture is warped to the
// newest view, and the last sharp one lies over the drafts until the view has turned too far from it.

import { CELLS, COPY, CORNERS, GRID, SHARE, shader } from "./shaders.js";

const LAYERS_A_PASS = 12; // every WebGL 2 has 16 textures
const BEFORE = LAYERS_A_PASS; // units behind those of the layers
const TABLE = LAYERS_A_PASS + 1;
const PLATE = LAYERS_A_PASS + 2;
// When quick draws become coarser or finer: at less than half of 60 draws a second, or at nearly all of them.
const SLOW_MS = 40;
const FAST_MS = 18;
const MOST_DIVISOR = 4;
// The turn of the view after which a draft is shown in place of the last sharp picture: for each pixel of the canvas that a
// pixel of the draft is wide, and two more for its dials; and the most.
const TURN = (4 * Math.PI) / 180;
const MOST_TURN = (45 * Math.PI) / 180;
const BORDERS = 4; // divides the pixels of a draft of which only the borders are seen
// What is shown in false colours: a channel of a slot, or 1 less it; `hole` is shown black.
const FALSE = {
    depth: { slot: "depth", pick: [1, 0, 0, 0], shift: 0, hole: 0 },
    transmittance: { slot: "beauty", pick: [0, 0, 0, -1], shift: 1, hole: -1 },
};

export class Picture {
    constructor(canvas) {
        this.canvas = canvas;
        const gl = canvas.getContext("webgl2", { alpha: false, antialias: false });
        if (!gl || !gl.getExtension("EXT_color_buffer_float")) {
            throw new Error("this browser has no WebGL 2 with pictures of half floats, which the viewer needs");
        }
        this.gl = gl;
        gl.getExtension("OES_texture_float_linear");
        this.textures = new Map(); // number -> { texture, width, height, fitted }
        this.slots = {};
        this.weights = null;
        this.muted = new Set(); // layers that the user left out
        this.lit = new Map(); // the last weights of layers that were not black
        this.exposure = 0;
        this.gamma = 1;
        this.wipe = 0;
        this.full = [canvas.width, canvas.height];
        this.divisor = 1; // of the pixels of quick draws
        this.programs = new Map();
        this.sum = this.#target();
        this.snapshot = this.#target();
        this.probe = this.#target();
        this.few = this.#target();
        this.sharp = { ...this.#target(), camera: null, ahead: null, event: -1, shown: this.#target(), look: "" }; // added up
        this.draft = this.#target();
        this.tables = 0; // that came
        this.nothing = this.#target(); // no depth is known
        this.#resize(this.nothing, 1, 1);
        this.camera = this.aim = null; // of the pictures, and the newest
        this.event = this.changedBy = -1; // the last event in the pictures; see `turnTo`
        this.look = "picture"; // or a key of FALSE
        this.depths = [0, 1]; // the nearest and the farthest
        this.sheet = null; // names of layers that are shown side by side
        this.frames = gl.createFramebuffer();
    }

    /** A view's table: ten bits for each of red, green and blue in a word, red fastest. */
    setTable(head, bytes) {
        const gl = this.gl;
        this.table ??= gl.createTexture();
        ++this.tables;
        this.head = head;
        gl.activeTexture(gl.TEXTURE0 + TABLE);
        gl.bindTexture(gl.TEXTURE_3D, this.table);
        const words = new Uint32Array(bytes.buffer, bytes.byteOffset, head.size ** 3);
        gl.texImage3D(gl.TEXTURE_3D, 0, gl.RGB10_A2, head.size, head.size, head.size, 0, gl.RGBA, gl.UNSIGNED_INT_2_10_10_10_REV, words);
        for (const name of ["MIN_FILTER", "MAG_FILTER"]) gl.texParameteri(gl.TEXTURE_3D, gl[`TEXTURE_${name}`], gl.LINEAR);
        for (const name of ["S", "T", "R"]) gl.texParameteri(gl.TEXTURE_3D, gl[`TEXTURE_WRAP_${name}`], gl.CLAMP_TO_EDGE);
    }

    /** Pictures of the slots; those that are not fresh are here already. */
    setPictures(head, bytes) {
        const gl = this.gl;
        if (head.stage !== "motion") this.sharp.camera = null;
        Object.assign(this, { camera: head.camera, stage: head.stage, event: head.serial });
        let offset = 0;
        for (const { number, shape } of head.fresh) {
            const [height, width, channels] = shape;
            const texture = gl.createTexture();
            this.#bindPlain(texture);
            gl.pixelStorei(gl.UNPACK_ALIGNMENT, 2);
            const formats = { 2: [gl.RG16F, gl.RG], 3: [gl.RGB16F, gl.RGB], 4: [gl.RGBA16F, gl.RGBA] }[channels];
            gl.texImage2D(gl.TEXTURE_2D, 0, formats[0], width, height, 0, formats[1], gl.HALF_FLOAT, halves(bytes, offset, width * height * channels));
            offset += 2 * width * height * channels;
            this.textures.set(number, { texture, width, height, fitted: null });
        }
        const used = new Set([...Object.values(head.slots), this.sharp.camera && this.sharp.ahead]);
        for (const [number, { texture, fitted }] of this.textures) {
            if (!used.has(number)) {
                gl.deleteTexture(texture);
                if (fitted) gl.deleteTexture(fitted.texture);
                this.textures.delete(number);
            }
        }
        this.slots = head.slots;
        this.setWeights(head.weights);
        this.depths = head.depths ?? this.depths;
        this.turnTo(head.aim);
    }

    /** Shows what is here as the view `aim` sees it. `changedBy`: the last event that changed more than the view. */
    turnTo(aim, changedBy = this.changedBy) {
        Object.assign(this, { aim, changedBy });
        if (this.sharp.event < changedBy) this.sharp.camera = null;
        if (!this.isWarped || this.sharp.camera || this.stage === "motion" || this.event < changedBy) return;
        this.#addInto(this.sharp);
        Object.assign(this.sharp, { camera: this.camera, ahead: this.slots.depth, event: this.event, look: "" });
    }

    /** Whether the newest view is another one than that of the pictures. */
    get isWarped() {
        return this.isReady && ["matrix", "width", "shift", "flat"].some((key) => String(this.aim[key]) !== String(this.camera[key]));
    }

    /** Names of the layers that add up to the picture. */
    get layers() {
        return Object.keys(this.slots).filter((name) => !["beauty", "rest", "depth", "plate"].includes(name));
    }

    /** Factors of layers by name; null: the beauty is the picture. */
    setWeights(weights) {
        this.weights = weights;
        for (const [name, weight] of Object.entries(weights ?? {})) if (weight.some(Boolean)) this.lit.set(name, weight);
    }

    get isReady() {
        return this.slots.beauty !== undefined && this.table !== undefined;
    }

    /** Width and height of the picture that was rendered. */
    get size() {
        const { width, height } = this.textures.get(this.slots.beauty);
        return [width, height];
    }

    /** Sets how many pixels the screen shows of the canvas. */
    resize(width, height) {
        this.full = [width, height];
    }

    /** `isQuick`: coarser where the graphics unit is slow (`tookTo`); the next draw makes up for it. */
    draw(isQuick = false) {
        if (!this.isReady) return;
        if (this.sheet) return this.#drawSheet();
        const moves = this.isWarped || (this.sharp.camera && this.#trust() > 0);
        if (moves && this.look === "picture" && this.#turnFrom(this.camera) < MOST_TURN) return this.#drawWarped();
        const isFalse = FALSE[this.look] && this.#slot(FALSE[this.look].slot);
        const parts = isFalse ? [[this.#slot(FALSE[this.look].slot), [1, 1, 1, 1]]] : this.#fewParts(this.#parts());
        const [width, height] = this.#sizeOf(parts);
        const divisor = isQuick ? this.divisor : 1;
        const size = [Math.ceil(width / divisor), Math.ceil(height / divisor)];
        const layers = parts.map(([it, weight]) => [this.#fitted(it, width, height), weight]);
        this.#begin(...size);
        const isWiped = this.wipe && this.snapshot.width;
        this.#show(layers, [...(isFalse ? ["FALSE"] : []), ...(isWiped ? ["WIPE"] : []), ...this.#over], [0, 0, ...size]);
    }

    get #gamma() {
        return this.gamma !== 1 ? ["GAMMA"] : [];
    }

    /** The switches of the whole picture. */
    get #over() {
        return this.#slot("plate") ? ["PLATE", ...this.#gamma] : this.#gamma;
    }

    /** The pictures, and over them the last sharp one, as the newest view sees them. */
    #drawWarped() {
        const { gl, sharp } = this;
        this.#begin(...this.full);
        gl.clearColor(0, 0, 0, 1);
        gl.clear(gl.COLOR_BUFFER_BIT);
        if (this.#slot("plate")) this.#show([[this.nothing, [0, 0, 0, 0]]], this.#over, [0, 0, ...this.full]);
        const trust = sharp.camera ? this.#trust() : 0;
        if (sharp.camera !== this.camera) {
            const divisor = trust === 1 ? BORDERS : 1;
            const size = this.size.map((side, i) => Math.ceil(Math.min(side, this.full[i]) / divisor));
            this.#showInto(this.draft, this.#fewParts(this.#parts()), size);
            this.#warp(this.draft, this.camera, this.slots.depth, 1);
        }
        if (trust > 0) {
            const look = `${this.exposure} ${this.gamma} ${this.tables}`;
            if (sharp.look !== look) this.#showInto(sharp.shown, [[sharp, [1, 1, 1, 1]]], [sharp.width, sharp.height]);
            sharp.look = look;
            this.#warp(sharp.shown, sharp.camera, sharp.ahead, trust);
        }
        if (!this.wipe || !this.snapshot.width) return;
        gl.enable(gl.SCISSOR_TEST);
        gl.scissor(0, 0, Math.round(this.wipe * this.full[0]), this.full[1]);
        this.#show([[this.#fitted(this.snapshot, ...this.full), [1, 1, 1, 1]]], this.#over, [0, 0, ...this.full]);
        gl.disable(gl.SCISSOR_TEST);
    }

    /** How much of the sharp picture is shown: all of it, until the view has turned so far that a draft is better. */
    #trust() {
        const most = Math.min(TURN * (2 + this.full[0] / this.size[0]), MOST_TURN);
        const share = 3 - (3 * this.#turnFrom(this.sharp.camera)) / most;
        return this.sharp.camera === this.camera ? 1 : Math.min(Math.max(share, 0), 1);
    }

    /** The angle from a camera to the newest view. */
    #turnFrom(camera) {
        const [back, before] = [this.aim, camera].map(({ matrix }) => matrix.slice(8, 11));
        return Math.acos(Math.min(back.reduce((sum, v, i) => sum + v * before[i], 0), 1));
    }

    /** Layers as the screen shows them, in a target. */
    #showInto(target, layers, size) {
        this.#resize(target, ...size);
        const isApart = this.#slot("plate") ? ["APART"] : [];
        this.#show(layers, [...isApart, ...this.#gamma], [0, 0, ...size], this.#framed(target));
    }

    /** Draws what a camera saw as the newest view sees it. `ahead`: the number of its depth. */
    #warp(shown, camera, ahead, share) {
        const { gl, aim } = this;
        const { program, places } = this.#programOf("warp", () => SHARE, GRID);
        const lens = ({ width, flat, shift }) => [width, Number(flat), shift[0], shift[1]];
        gl.useProgram(program);
        this.#unit(0, shown.texture, places.layer0);
        this.#unit(1, (this.textures.get(ahead) ?? this.nothing).texture, places.ahead);
        gl.uniformMatrix4fv(places.from, false, camera.matrix);
        gl.uniformMatrix4fv(places.to, false, aim.matrix);
        gl.uniform4fv(places.fromLens, lens(camera));
        gl.uniform4fv(places.toLens, lens(aim));
        gl.uniform1f(places.aspect, aim.aspect);
        gl.uniform1f(places.distance, camera.distance);
        gl.bindFramebuffer(gl.FRAMEBUFFER, null);
        gl.viewport(0, 0, ...this.full);
        gl.clear(gl.DEPTH_BUFFER_BIT);
        gl.uniform1f(places.share, share);
        gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
        gl.enable(gl.DEPTH_TEST);
        if (share < 1 || this.#slot("plate")) gl.enable(gl.BLEND);
        gl.drawArrays(gl.TRIANGLES, 0, 6 * CELLS[0] * CELLS[1]);
        for (const what of [gl.DEPTH_TEST, gl.BLEND]) gl.disable(what);
    }

    /** All layers side by side, which is `sheet` by rows: names of layers, or "beauty". */
    #drawSheet() {
        const columns = Math.ceil(Math.sqrt(this.sheet.length));
        const [width, height] = this.full.map((side) => Math.floor(side / columns));
        this.#begin(...this.full);
        this.gl.clearColor(0.05, 0.05, 0.05, 1);
        this.gl.clear(this.gl.COLOR_BUFFER_BIT);
        this.sheet.forEach((name, i) => {
            const weight = (this.muted.has(name) ? this.lit.get(name) : this.weights?.[name]) ?? [1, 1, 1];
            const parts = name === "beauty" ? this.#fewParts(this.#parts()) : [[this.#slot(name), [...weight, 0]]];
            const row = Math.floor(i / columns);
            if (parts[0][0]) this.#show(parts, name === "beauty" ? this.#over : this.#gamma, [(i % columns) * width, this.full[1] - (row + 1) * height, width, height]);
        });
    }

    #begin(across, down) {
        const { gl, canvas } = this;
        if (canvas.width !== across || canvas.height !== down) [canvas.width, canvas.height] = [across, down];
        gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    }

    /** Shows a sum of layers in a part of the canvas, or of another frame. */
    #show(layers, switches, viewport, frame = null) {
        const gl = this.gl;
        const places = this.#use(layers, true, switches);
        gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
        gl.viewport(...viewport);
        if (places.before) this.#unit(BEFORE, this.snapshot.texture, places.before);
        if (places.plate) this.#unit(PLATE, this.#slot("plate").texture, places.plate);
        gl.activeTexture(gl.TEXTURE0 + TABLE);
        gl.bindTexture(gl.TEXTURE_3D, this.table);
        const { pick, shift, hole, slot } = FALSE[this.look] ?? { pick: [0, 0, 0, 0] };
        const [low, high] = slot === "depth" ? this.depths : [0, 1];
        if (places.pick) gl.uniform4fv(places.pick, pick);
        const { knee, most, size } = this.head;
        const numbers = { gain: 2 ** this.exposure, gamma: this.gamma, wipe: this.wipe, knee, reach: Math.log2(1 + knee * most), size, shift, hole, low, high };
        for (const [name, value] of Object.entries(numbers)) if (places[name]) gl.uniform1f(places[name], value);
        if (places.table) gl.uniform1i(places.table, TABLE);
        gl.drawArrays(gl.TRIANGLES, 0, 3);
    }

    /** Red, green, blue and alpha of some pixels all over the picture: 160 by 90. */
    samples() {
        const gl = this.gl;
        this.#resize(this.few, 160, 90);
        this.#addUp(this.few, this.#parts(), [0, 0, 160, 90]);
        const values = new Float32Array(4 * 160 * 90);
        gl.readPixels(0, 0, 160, 90, gl.RGBA, gl.FLOAT, values);
        return values;
    }

    /** Keeps the picture as the one to compare with. */
    keepSnapshot() {
        this.#addInto(this.snapshot);
    }

    /** Premultiplied scene-linear R, G, B, A of the rendered picture at (0..1, 0..1 from the top), to half floats. */
    valueAt(x, y) {
        if (this.slots.beauty === undefined) return null;
        const gl = this.gl;
        const [width, height] = this.size;
        const at = [Math.min(Math.floor(x * width), width - 1), Math.min(Math.floor(y * height), height - 1)];
        const parts = this.#parts(true);
        // The pixel is the only one of the sum that falls into the target.
        this.#resize(this.probe, 1, 1);
        this.#addUp(this.probe, parts, [-at[0], -at[1], width, height]);
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

    // ---- what is summed

    #slot(name) {
        return this.textures.get(this.slots[name]);
    }

    /** The layers of the picture with their weights: the beauty alone where no weight differs from 1. Its alpha is no sum
        of layers; it is left out where nobody asks for it. */
    #parts(hasAlpha = Boolean(this.#slot("plate"))) {
        if (!this.weights) return [[this.#slot("beauty"), [1, 1, 1, 1]]];
        const shines = Object.entries(this.weights).filter(([name, weight]) => this.#slot(name) && weight.some((w) => w !== 0));
        const all = shines.map(([name, weight]) => [this.#slot(name), [...weight, 0]]);
        if (this.#slot("rest")) all.push([this.#slot("rest"), [1, 1, 1, 0]]);
        if (hasAlpha) all.push([this.#slot("beauty"), [0, 0, 0, 1]]);
        return all.length ? all : [[this.#slot("beauty"), [0, 0, 0, 1]]];
    }

    /** As many as a pass takes: more are added up first. */
    #fewParts(parts) {
        if (parts.length <= LAYERS_A_PASS) return parts;
        this.#addInto(this.sum);
        return [[this.sum, [1, 1, 1, 1]]];
    }

    /** Adds the layers of the picture up, into a target. */
    #addInto(target) {
        const parts = this.#parts();
        const [width, height] = this.#sizeOf(parts);
        this.#resize(target, width, height);
        this.#addUp(target, parts.map(([it, weight]) => [this.#fitted(it, width, height), weight]), [0, 0, width, height]);
    }

    /** Pixels of a sum: no more than the largest part has, nor than the screen shows. */
    #sizeOf(parts) {
        const most = (side) => Math.max(...parts.map(([it]) => it[side]));
        return [Math.min(most("width"), this.full[0]), Math.min(most("height"), this.full[1])];
    }

    /** A picture in this size: itself, or a copy that is kept. */
    #fitted(it, width, height) {
        if (it.width === width && it.height === height) return it;
        if (it.fitted?.width === width && it.fitted.height === height) return it.fitted;
        const gl = this.gl;
        it.fitted ??= this.#target();
        this.#resize(it.fitted, width, height);
        const { program, places } = this.#programOf("copy", () => COPY);
        gl.useProgram(program);
        this.#unit(0, it.texture, places.layer0);
        gl.bindFramebuffer(gl.FRAMEBUFFER, this.#framed(it.fitted));
        gl.viewport(0, 0, width, height);
        gl.drawArrays(gl.TRIANGLES, 0, 3);
        return it.fitted;
    }

    #addUp(target, layers, viewport) {
        const gl = this.gl;
        gl.blendFunc(gl.ONE, gl.ONE);
        for (let first = 0; first < layers.length; first += LAYERS_A_PASS) {
            this.#use(layers.slice(first, first + LAYERS_A_PASS), false, []);
            gl.bindFramebuffer(gl.FRAMEBUFFER, this.#framed(target));
            gl.viewport(...viewport);
            if (first > 0) gl.enable(gl.BLEND);
            gl.drawArrays(gl.TRIANGLES, 0, 3);
        }
        gl.disable(gl.BLEND);
    }

    /** Takes the program for these layers and hands them to it; gives the places of its other uniforms. */
    #use(layers, isShown, switches) {
        const key = `${layers.length} ${isShown} ${switches}`;
        const { program, places } = this.#programOf(key, () => shader(layers.length, isShown, switches));
        this.gl.useProgram(program);
        layers.forEach(([it], i) => this.#unit(i, it.texture, places[`layer${i}`]));
        this.gl.uniform4fv(places["weights[0]"], layers.flatMap(([, weight]) => weight));
        return places;
    }

    // ---- WebGL

    #programOf(key, text, corners = CORNERS) {
        if (!this.programs.has(key)) this.programs.set(key, this.#program(text(), corners));
        return this.programs.get(key);
    }

    #program(fragments, corners) {
        const gl = this.gl;
        const program = gl.createProgram();
        for (const [kind, text] of [[gl.VERTEX_SHADER, corners], [gl.FRAGMENT_SHADER, fragments]]) {
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
