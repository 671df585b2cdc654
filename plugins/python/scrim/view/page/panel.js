// SPDX-License-Identifier: Apache-2.0
// Draws the controls that the viewer lists, and tells what the user makes of them.
//
// Elements are kept while the list has the same controls, so that a slider under the finger stays where it is.

import { code } from "./code.js";
import { curve } from "./curves.js";
import { element, encoded, linear, short } from "./values.js";

const STEPS = 1000; // of a slider
// Values that have keys: see `key` of a control.
const MARKS = {
    "": { textContent: "", title: "" },
    here: { textContent: "◆ ", title: "This frame has a key: a change sets its value." },
    between: { textContent: "◇ ", title: "Other frames have keys: a change makes one for this frame." },
};

export class Panel {
    /** `change(control, value, done)`: a control was moved, or let go; `mute(names)`: layers that do not shine;
        `remove(light)`: a light goes. */
    constructor(root, change, mute, remove) {
        Object.assign(this, { root, change, mute, remove });
        this.known = "";
        this.setters = new Map();
        this.marks = new Map();
        this.controls = new Map(); // as the viewer said them last, with the values that were changed since
        this.muted = new Set();
        this.solo = null;
    }

    update(groups, muted) {
        this.muted = new Set(muted);
        const names = JSON.stringify(groups.map((g) => [g.title, g.controls.map((c) => [c.id, c.kind, c.fixed, c.least, c.most])]));
        if (names !== this.known) {
            this.known = names;
            this.setters.clear();
            this.marks.clear();
            this.layers = groups.filter((g) => g.kind === "light" || g.kind === "ambient").map(layerOf);
            const open = new Map([...this.root.children].map((one) => [one.dataset.title, isOpen(one)]));
            const used = this.root.contains(document.activeElement) ? document.activeElement : null;
            this.root.replaceChildren(...groups.map((group) => this.#group(group, open)));
            this.used = used;
        }
        for (const group of groups) {
            for (const control of group.controls) {
                this.controls.set(control.id, control);
                this.setters.get(control.id)?.(control);
                if (this.marks.has(control.id)) Object.assign(this.marks.get(control.id), MARKS[control.key]);
            }
        }
        this.#goOn();
        for (const button of this.root.querySelectorAll("button[data-layer]")) {
            const name = button.dataset.layer;
            const isOn = button.dataset.does === "mute" ? this.muted.has(name) : this.solo === name;
            button.setAttribute("aria-pressed", String(isOn));
        }
    }

    /** Goes on with the element that was in use before all of them were made anew. */
    #goOn() {
        const label = this.used?.ariaLabel;
        const same = label && [...this.root.querySelectorAll("[aria-label]")].find((one) => one.ariaLabel === label);
        if (same) same.focus({ preventScroll: true });
        if (same?.matches("textarea")) same.setSelectionRange(this.used.selectionStart, this.used.selectionEnd);
        this.used = null;
    }

    /** Leaves all other layers out, or takes them in again. */
    soloOf(name) {
        this.solo = this.solo === name ? null : name;
        this.mute(this.solo === null ? [] : this.layers.filter((other) => other !== name));
    }

    /** Folds the panels of all lights, or unfolds them where all are folded. */
    foldLights() {
        const lights = [...this.root.children].filter((one) => ["light", "ambient"].includes(one.dataset.kind));
        const opens = !lights.some(isOpen);
        for (const light of lights) fold(light, opens);
    }

    /** `open`: which groups are unfolded, by title. */
    #group(group, open) {
        const root = element("section", { className: "group" });
        Object.assign(root.dataset, { title: group.title, kind: group.kind });
        const head = root.appendChild(element("div", { className: "head" }));
        const heading = head.appendChild(element("h2"));
        const button = heading.appendChild(element("button", { className: "fold", textContent: group.title }));
        button.addEventListener("click", () => fold(root, !isOpen(root)));
        if (group.kind === "light") {
            const remove = head.appendChild(element("button", { textContent: "Remove", ariaLabel: `Remove ${group.name}` }));
            remove.addEventListener("click", () => this.remove(group.name));
        }
        if (group.kind === "light" || group.kind === "ambient") {
            head.append(this.#layerButton(group, "mute", "Mute"), this.#layerButton(group, "solo", "Solo"));
        }
        root.appendChild(element("div")).append(...group.controls.map((control) => this.#row(control, group)));
        fold(root, open.get(group.title) ?? !group.folded);
        return root;
    }

    #layerButton(group, does, text) {
        const name = layerOf(group);
        const button = element("button", { textContent: text, ariaPressed: "false", ariaLabel: `${text} ${group.name}` });
        Object.assign(button.dataset, { layer: name, does });
        button.addEventListener("click", () => {
            if (does === "solo") return this.soloOf(name);
            this.solo = null;
            if (!this.muted.delete(name)) this.muted.add(name);
            this.mute([...this.muted]);
        });
        return button;
    }

    #row(control, group) {
        const row = element("div", { className: "row" });
        const label = `${group.title} ${control.label}`;
        if (control.kind !== "code") {
            const name = row.appendChild(element("span", { textContent: `${control.label} ` }));
            this.marks.set(control.id, name.appendChild(element("span", { className: "key" })));
            if (control.unit) name.append(element("small", { textContent: control.unit }));
        }
        if (control.fixed) {
            row.append(element("span", { className: "fixed", textContent: control.kind === "code" ? "is in a file of its own" : "has keys: edit the file" }));
            return row;
        }
        const make = { number: slider, colour: triple, vector: triple, choice, switch: checkbox, code, ramp: curve, colours: curve, transfer: curve }[control.kind];
        const { parts, set } = make(control, label, (value, done) => this.change(this.controls.get(control.id), value, done));
        row.append(...parts);
        this.setters.set(control.id, set);
        return row;
    }
}

function isOpen(group) {
    return !group.lastElementChild.hidden;
}

function fold(group, opens) {
    group.lastElementChild.hidden = !opens;
    group.querySelector(".fold").setAttribute("aria-expanded", String(opens));
}

function layerOf(group) {
    return group.kind === "light" ? `light.${group.name}` : group.kind;
}

function slider(control, label, change) {
    const { least, most, log, zero } = control;
    const range = element("input", { type: "range", min: 0, max: STEPS, step: 1, ariaLabel: label });
    const field = element("input", { type: "number", step: "any", ariaLabel: `${label}, number` });
    const toValue = (place) => {
        if (zero && place === 0) return 0;
        return log ? least * (most / least) ** (place / STEPS) : least + ((most - least) * place) / STEPS;
    };
    const toPlace = (value) => STEPS * (log ? Math.log(Math.max(value, least) / least) / Math.log(most / least) : (value - least) / (most - least));
    const say = (done) => change(Number(short(toValue(Number(range.value)))), done);
    range.addEventListener("input", () => {
        field.value = short(toValue(Number(range.value)));
        say(false);
    });
    range.addEventListener("change", () => say(true));
    range.addEventListener("dblclick", () => field.focus());
    field.addEventListener("change", () => field.value !== "" && change(Number(field.value), true));
    const set = ({ value }) => {
        if (document.activeElement !== field) field.value = short(value, 4);
        if (!range.matches(":active")) range.value = toPlace(value);
    };
    return { parts: [range, field], set };
}

// Scene-linear numbers, and for colours a patch to choose by eye, which keeps the brightness of the largest one.
function triple(control, label, change) {
    const isColour = control.kind === "colour";
    const box = element("div", { className: isColour ? "triple" : "triple plain" });
    const fields = ["red", "green", "blue"].map((name, i) =>
        element("input", { type: "number", step: isColour ? 0.01 : "any", ariaLabel: `${label} ${isColour ? name : "xyz"[i]}` }));
    let exact = [0, 0, 0]; // fields show fewer digits
    fields.forEach((field, i) => field.addEventListener("change", () => {
        if (field.value !== "") change(exact.map((v, at) => (at === i ? Number(field.value) : v)), true);
    }));
    box.append(...fields);
    const patch = element("input", { type: "color", className: "swatch", ariaLabel: `${label} patch` });
    const choose = (done) => {
        const rgb = [1, 3, 5].map((i) => linear(parseInt(patch.value.slice(i, i + 2), 16) / 255));
        const most = Math.max(...fields.map((f) => Number(f.value)), 1e-6);
        const scale = Math.max(...rgb) > 0 ? most / Math.max(...rgb) : 0;
        change(rgb.map((v) => Number(short(v * scale))), done);
    };
    patch.addEventListener("input", () => choose(false));
    patch.addEventListener("change", () => choose(true));
    if (isColour) box.append(patch);
    const set = ({ value }) => {
        exact = [...value];
        fields.forEach((field, i) => {
            if (document.activeElement !== field) field.value = short(value[i], isColour ? 4 : 6);
        });
        const most = Math.max(...value, 1e-6);
        if (!patch.matches(":active")) patch.value = "#" + value.map((v) => encoded(Math.max(v, 0) / most)).join("");
    };
    return { parts: [box], set };
}

function choice(control, label, change) {
    const select = element("select", { ariaLabel: label });
    select.append(...control.choices.map((name, i) => element("option", { value: name, textContent: control.labels[i] })));
    select.addEventListener("change", () => change(select.value, true));
    return { parts: [select], set: ({ value }) => (select.value = value) };
}

function checkbox(control, label, change) {
    const box = element("input", { type: "checkbox", ariaLabel: label });
    box.addEventListener("change", () => change(box.checked, true));
    return { parts: [box], set: ({ value }) => (box.checked = value) };
}
