// SPDX-License-Identifier: Apache-2.0
// Other ways to look at the picture: false colours, all layers side by side, and how bright its pixels are.

import { layOver } from "./places.js";
import { element, short } from "./values.js";

const STOPS = [-12, 8]; // of the histogram, from 1
const BINS = 120;

export class Looks {
    /** `by(id)`: elements of the page; `redraw()`; `pick(layer)`: a layer was chosen from the sheet. */
    constructor(picture, by, redraw, pick) {
        Object.assign(this, { picture, by, redraw, pick, isCounting: false });
        by("look").addEventListener("change", () => {
            picture.look = by("look").value;
            redraw();
        });
        by("layers").addEventListener("click", () => this.#toggle("layers", () => (picture.sheet = picture.sheet ? null : ["beauty"])));
        by("count").addEventListener("click", () => this.#toggle("count", () => (this.isCounting = !this.isCounting)));
    }

    #toggle(id, change) {
        this.by(id).setAttribute("aria-pressed", String(Boolean(change())));
        this.redraw();
    }

    /** To be called after each draw that is not quick, with the canvas's place on the page. */
    update(canvas) {
        const { picture, by } = this;
        by("legend").textContent = { depth: `${short(picture.depths[0], 4)} to ${short(picture.depths[1], 4)}`, transmittance: "0 to 1" }[picture.look] ?? "";
        by("histogram").hidden = !this.isCounting;
        if (this.isCounting) this.#count();
        this.#label(canvas);
    }

    #label(canvas) {
        const { picture } = this;
        const root = this.by("sheet");
        root.hidden = !picture.sheet;
        if (root.hidden) return;
        const names = ["beauty", ...picture.layers];
        if (String(names) !== String(picture.sheet)) {
            picture.sheet = names;
            this.redraw();
        }
        layOver(root, canvas);
        root.style.setProperty("--columns", Math.ceil(Math.sqrt(names.length)));
        if (String([...root.children].map((tile) => tile.textContent)) !== String(names)) {
            root.replaceChildren(...names.map((name) => this.#tile(name)));
        }
        for (const tile of root.children) tile.className = picture.muted.has(tile.textContent) ? "muted" : "";
    }

    #tile(name) {
        const tile = element("div");
        const button = tile.appendChild(element("button", { textContent: name }));
        button.addEventListener("click", () => {
            this.#toggle("layers", () => (this.picture.sheet = null));
            this.pick(name);
        });
        return tile;
    }

    #count() {
        const values = this.picture.samples();
        const bins = [0, 1, 2].map(() => new Float32Array(BINS));
        for (let i = 0; i < values.length; i += 4) {
            for (let channel = 0; channel < 3; ++channel) {
                const stops = Math.log2(Math.max(values[i + channel], 1e-9)) + this.picture.exposure;
                const bin = Math.floor(((stops - STOPS[0]) / (STOPS[1] - STOPS[0])) * BINS);
                if (bin >= 0) bins[channel][Math.min(bin, BINS - 1)] += 1;
            }
        }
        const canvas = this.by("histogram");
        const context = canvas.getContext("2d");
        const most = Math.max(...bins.map((all) => Math.max(...all)), 1);
        context.clearRect(0, 0, canvas.width, canvas.height);
        context.globalCompositeOperation = "lighter";
        bins.forEach((all, channel) => {
            context.fillStyle = ["#d04040", "#40b040", "#4060e0"][channel];
            all.forEach((count, bin) => {
                const height = Math.sqrt(count / most) * canvas.height;
                context.fillRect((bin * canvas.width) / BINS, canvas.height - height, canvas.width / BINS, height);
            });
        });
        context.globalCompositeOperation = "source-over";
        context.fillStyle = "#e6e6e6"; // where 1 is, which most views show as white
        context.fillRect((-STOPS[0] / (STOPS[1] - STOPS[0])) * canvas.width, 0, 1, canvas.height);
    }
}
