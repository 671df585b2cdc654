// SPDX-License-Identifier: Apache-2.0
// A ramp or transfer function as a curve: points [value of the grid, height, colour] that are dragged, added by a double
// click, and removed by Delete. A point in use has its numbers in fields.

import { element, encoded, linear, short } from "./values.js";

const WIDTH = 300;
const HEIGHT = 80;
const SPACE = 8; // around the curve
const SVG = "http://www.w3.org/2000/svg";

function drawn(name, values) {
    const it = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(values)) it.setAttribute(key, value);
    return it;
}

/** Colour of light for the screen. */
function shown(colour) {
    const most = Math.max(...colour, 1e-6);
    return "#" + colour.map((v) => encoded(Math.max(v, 0) / Math.max(most, 1))).join("");
}

class Curve {
    constructor(control, label, change) {
        Object.assign(this, { kind: control.kind, label, change, points: [], chosen: 0 });
        this.box = element("div", { className: "curve" });
        this.svg = drawn("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "group", "aria-label": label });
        this.fields = element("div", { className: "fields" });
        this.more = element("button", {});
        this.more.addEventListener("click", () => this.#give(this.points.length ? [] : this.#usual(), true));
        this.box.append(this.svg, this.fields, this.more);
        this.svg.addEventListener("dblclick", (event) => this.#add(event));
    }

    set(points) {
        if (this.isHeld) return;
        this.points = points.map((point) => [...point]);
        this.chosen = Math.min(this.chosen, Math.max(points.length - 1, 0));
        this.#draw();
    }

    get hasHeight() { return this.kind !== "colours"; }
    get hasColour() { return this.kind !== "ramp"; }

    #usual() {
        return [0, 1].map((v) => [v, this.hasHeight ? v : null, this.hasColour ? [v, v, v] : null]);
    }

    #give(points, done) {
        this.points = points;
        this.#draw();
        this.change(points.map((point) => [...point]), done);
    }

    // ---- places on the drawing

    #range() {
        const values = this.points.map(([v]) => v);
        const [low, high] = [Math.min(...values), Math.max(...values)];
        const most = Math.max(...this.points.map(([, height]) => height ?? 0), 1e-9);
        return this.isHeld ? this.held : { low, high: high > low ? high : low + 1, most: 1.1 * most };
    }

    #at([value, height]) {
        const { low, high, most } = this.#range();
        const y = this.hasHeight ? 1 - height / most : 0.5;
        return [SPACE + ((value - low) / (high - low)) * (WIDTH - 2 * SPACE), SPACE + y * (HEIGHT - 2 * SPACE)];
    }

    #from(event) {
        const { low, high, most } = this.#range();
        const box = this.svg.getBoundingClientRect();
        const [x, y] = [((event.clientX - box.left) / box.width) * WIDTH, ((event.clientY - box.top) / box.height) * HEIGHT];
        const value = low + ((x - SPACE) / (WIDTH - 2 * SPACE)) * (high - low);
        return [value, Math.max(most * (1 - (y - SPACE) / (HEIGHT - 2 * SPACE)), 0)];
    }

    // ---- what the user does

    /** Points keep their order. */
    #move(index, value, height, done) {
        const [before, after] = [this.points[index - 1]?.[0] ?? -Infinity, this.points[index + 1]?.[0] ?? Infinity];
        const moved = [Number(short(Math.min(Math.max(value, before), after))), this.hasHeight ? Number(short(height)) : null, this.points[index][2]];
        this.#give(this.points.map((point, i) => (i === index ? moved : point)), done);
    }

    #add(event) {
        if (!this.points.length) return;
        const [value, height] = this.#from(event);
        const index = this.points.findIndex(([v]) => v > value);
        const at = index < 0 ? this.points.length : index;
        const like = this.points[Math.max(at - 1, 0)];
        this.chosen = at;
        this.#give(this.points.toSpliced(at, 0, [Number(short(value)), this.hasHeight ? Number(short(height)) : null, like[2] && [...like[2]]]), true);
    }

    #remove(index) {
        if (this.points.length > 2) this.#give(this.points.toSpliced(index, 1), true);
    }

    // ---- what it looks like

    #draw() {
        const focused = [...this.svg.querySelectorAll("circle")].indexOf(document.activeElement);
        this.svg.replaceChildren();
        this.more.textContent = this.points.length ? "Remove curve" : "Add curve";
        this.more.hidden = this.kind === "transfer";
        this.svg.style.display = this.points.length ? "" : "none";
        const places = this.points.map((point) => this.#at(point));
        if (this.hasColour) places.slice(1).forEach(([x], i) => this.#bar(i, places[i][0], x));
        this.svg.append(drawn("polyline", { points: places.map((p) => p.join(",")).join(" "), fill: "none", stroke: "#e6e6e6" }));
        this.svg.append(...places.map((place, index) => this.#dot(index, ...place)));
        if (focused >= 0) this.svg.querySelectorAll("circle")[focused]?.focus();
        this.#drawFields();
    }

    #bar(index, from, to) {
        const id = `g${Math.random().toString(36).slice(2)}`;
        const gradient = drawn("linearGradient", { id });
        [0, 1].forEach((end) => gradient.append(drawn("stop", { offset: end, "stop-color": shown(this.points[index + end][2]) })));
        this.svg.append(gradient, drawn("rect", { x: from, y: SPACE, width: Math.max(to - from, 0), height: HEIGHT - 2 * SPACE, fill: `url(#${id})` }));
    }

    #dot(index, x, y) {
        const [value, height] = this.points[index];
        const text = `${this.label}, point ${index + 1} of ${this.points.length}: ${short(value)}${this.hasHeight ? `, ${short(height)}` : ""}`;
        const dot = drawn("circle", { cx: x, cy: y, r: 5, tabindex: 0, role: "button", "aria-label": text });
        dot.classList.toggle("chosen", index === this.chosen);
        dot.addEventListener("focus", () => this.chosen !== index && this.#choose(index));
        dot.addEventListener("pointerdown", (event) => this.#hold(event, index));
        dot.addEventListener("keydown", (event) => {
            const { low, high, most } = this.#range();
            const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
            if (steps) this.#move(index, value + (steps[0] * (high - low)) / 50, Math.max((height ?? 0) + (steps[1] * most) / 50, 0), true);
            else if (event.key === "Delete") this.#remove(index);
            else return;
            event.preventDefault();
            event.stopPropagation();
        });
        return dot;
    }

    #choose(index) {
        this.chosen = index;
        this.#draw();
    }

    #hold(event, index) {
        this.chosen = index;
        this.held = this.#range(); // the ends stay while a point is dragged
        this.isHeld = true;
        const move = (it) => this.#move(index, ...this.#from(it), false);
        const drop = (it) => {
            removeEventListener("pointermove", move);
            const at = this.#from(it);
            this.isHeld = false;
            this.#move(index, ...at, true);
        };
        addEventListener("pointermove", move);
        addEventListener("pointerup", drop, { once: true });
        event.preventDefault();
    }

    #drawFields() {
        const point = this.points[this.chosen];
        const wanted = point ? `${this.hasHeight} ${this.hasColour}` : "";
        if (this.shape !== wanted) {
            this.shape = wanted;
            this.fields.replaceChildren(...(point ? this.#makeFields() : []));
        }
        if (!point) return;
        const [value, height, colour] = this.fields.children;
        const fields = this.hasHeight ? { value, height, colour } : { value, colour: height };
        if (document.activeElement !== value) value.value = short(point[0]);
        if (this.hasHeight && document.activeElement !== height) height.value = short(point[1]);
        if (this.hasColour) fields.colour.value = shown(point[2]);
    }

    #makeFields() {
        const number = (name, at) => {
            const field = element("input", { type: "number", step: "any", ariaLabel: `${this.label}, ${name} of the point` });
            field.addEventListener("change", () => {
                const point = [...this.points[this.chosen]];
                point[at] = Number(field.value);
                if (field.value !== "") this.#move(this.chosen, point[0], point[1] ?? 0, true);
            });
            return field;
        };
        const parts = [number("value", 0)];
        if (this.hasHeight) parts.push(number("height", 1));
        if (this.hasColour) {
            const patch = element("input", { type: "color", className: "swatch", ariaLabel: `${this.label}, colour of the point` });
            const give = (done) => {
                const most = Math.max(...this.points[this.chosen][2], 1);
                const rgb = [1, 3, 5].map((i) => Number(short(most * linear(parseInt(patch.value.slice(i, i + 2), 16) / 255))));
                this.#give(this.points.map((p, i) => (i === this.chosen ? [p[0], p[1], rgb] : p)), done);
            };
            patch.addEventListener("input", () => give(false));
            patch.addEventListener("change", () => give(true));
            parts.push(patch);
        }
        return parts;
    }
}

export function curve(control, label, change) {
    const made = new Curve(control, label, change);
    return { parts: [made.box], set: ({ value }) => made.set(value) };
}
