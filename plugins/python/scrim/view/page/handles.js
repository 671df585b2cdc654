// SPDX-License-Identifier: Apache-2.0
// Lights in the picture: a button for each, which is dragged to where the light shall be, or moved by arrow keys.

import { layOver, placeOf } from "./places.js";

const STEP = 0.01; // of an arrow key

export class Handles {
    /** `place(light, x, y, done)`: a handle is at this part of the canvas. */
    constructor(root, canvas, place) {
        Object.assign(this, { root, canvas, place, selected: null, held: null, width: 0, height: 0 });
        this.buttons = new Map();
    }

    update(handles) {
        let added = null; // is in use at once
        const names = new Set(handles.map(({ light }) => light));
        for (const [name, button] of this.buttons) {
            if (names.has(name)) continue;
            button.remove();
            this.buttons.delete(name);
        }
        const isOpen = this.buttons.size > 0;
        for (const handle of handles) {
            if (isOpen && !this.buttons.has(handle.light)) added = handle.light;
            if (!this.buttons.has(handle.light)) this.buttons.set(handle.light, this.root.appendChild(this.#button(handle)));
            if (this.held !== handle.light) this.#put(handle.light, handle.x, handle.y);
        }
        if (added) this.select(added);
        if (!names.has(this.selected)) this.select(handles[0]?.light ?? null);
    }

    /** `layers`: those that do not shine. */
    mute(layers) {
        for (const [name, button] of this.buttons) {
            const isMuted = layers.includes(`light.${name}`);
            button.classList.toggle("muted", isMuted);
            button.title = isMuted ? `${name} (muted)` : name;
        }
    }

    select(light) {
        this.selected = light;
        for (const [name, button] of this.buttons) button.setAttribute("aria-pressed", String(name === light));
    }

    /** Lies over the canvas. */
    fit() {
        Object.assign(this, { width: this.canvas.offsetWidth, height: this.canvas.offsetHeight });
        for (const [light, { x, y }] of this.buttons) this.#put(light, x, y);
        layOver(this.root, this.canvas);
    }

    #put(light, x, y) {
        const button = this.buttons.get(light);
        Object.assign(button, { x, y });
        // A transform needs no new layout, nor a new painting, while the view turns.
        button.style.transform = `translate(${x * this.width}px, ${y * this.height}px)`;
    }

    #button({ light, kind }) {
        const button = Object.assign(document.createElement("button"), { textContent: kind === "way" ? "☀" : "●", title: light });
        button.className = kind;
        button.ariaLabel = `Place light ${light}: drag, or use arrow keys`;
        button.setAttribute("aria-pressed", "false");
        const move = (x, y, done) => {
            this.#put(light, x, y);
            this.place(light, x, y, done);
        };
        button.addEventListener("pointerdown", (event) => {
            button.setPointerCapture(event.pointerId);
            this.held = light;
            this.select(light);
        });
        button.addEventListener("pointermove", (event) => this.held === light && move(...placeOf(this.canvas, event), false));
        button.addEventListener("pointerup", (event) => {
            if (this.held !== light) return;
            this.held = null;
            move(...placeOf(this.canvas, event), true);
        });
        button.addEventListener("pointercancel", () => (this.held = null));
        button.addEventListener("focus", () => this.select(light));
        button.addEventListener("keydown", (event) => {
            const steps = { ArrowLeft: [-STEP, 0], ArrowRight: [STEP, 0], ArrowUp: [0, -STEP], ArrowDown: [0, STEP] }[event.key];
            if (!steps) return;
            event.preventDefault();
            move(button.x + steps[0], button.y + steps[1], true);
        });
        return button;
    }
}
