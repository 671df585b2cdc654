// SPDX-License-Identifier: Apache-2.0
// The pixels that were compared with brute force, over the picture: each in the colour of its error, the means of the
// errors of regions, and the values of the pixel under the pointer.

import { layOver } from "./places.js";
import { short } from "./values.js";

const MOST = 4; // times the promise, at the end of the colours, which begin at a quarter of it
const COLOURS = [[106, 155, 255], [80, 216, 232], [96, 216, 96], [240, 208, 64], [255, 106, 80]]; // as in the style
const SIDE = 7; // of a pixel's mark, on the screen
const NEAR = 12; // how far from a mark the pointer may be
const REGIONS = 8; // along the longer side

/** The colour of an error that is `times` the promise. */
export function colourOf(times) {
    const place = 2 + 2 * Math.min(Math.max(Math.log2(Math.max(times, 1e-9)) / Math.log2(MOST), -1), 1);
    const first = Math.min(Math.floor(place), COLOURS.length - 2);
    return COLOURS[first].map((v, i) => Math.round(v + (place - first) * (COLOURS[first + 1][i] - v)));
}

export class Verified {
    /** `by(id)`: elements of the page; `resolution()`: pixels of the picture. */
    constructor(by, picture, resolution) {
        Object.assign(this, { by, picture, resolution, pixels: [], promise: 1, isShown: false, isHidden: false, chosen: -1 });
        by("error-regions").addEventListener("change", () => this.draw());
        by("error-next").addEventListener("click", () => this.#isOn && this.#choose((this.chosen + 1) % this.pixels.length));
        by("error-hide").addEventListener("click", () => {
            this.isHidden = true;
            this.draw();
        });
    }

    /** Takes what the viewer found: pixels [x, y, picture, truth, error], the worst first. */
    take({ pixels, promise, states }) {
        Object.assign(this, { pixels, promise, isHidden: false, chosen: -1 });
        const unit = `${short(100 * promise, 3)} %`;
        const within = pixels.filter((pixel) => pixel[4] <= promise).length;
        this.by("error-unit").textContent = `Errors ÷ ${unit}${states ? ", which the picture promises for all pixels together" : ""}. `
            + `${within} of ${pixels.length} pixels are below it.`;
    }

    show(isShown) {
        if (this.isShown === isShown) return;
        this.isShown = isShown;
        this.draw();
    }

    get #isOn() {
        return this.isShown && !this.isHidden && this.pixels.length > 0;
    }

    /** Lies over the picture, with as many pixels as the screen has. */
    draw() {
        const canvas = this.by("errors");
        canvas.hidden = this.by("verified").hidden = !this.#isOn;
        if (!this.#isOn) return;
        layOver(canvas, this.picture);
        [canvas.width, canvas.height] = [this.picture.offsetWidth, this.picture.offsetHeight].map((side) => Math.round(side * devicePixelRatio));
        const context = canvas.getContext("2d");
        context.scale(devicePixelRatio, devicePixelRatio);
        if (this.by("error-regions").checked) this.#drawRegions(context);
        // The worst come last, and hide others.
        for (let i = this.pixels.length - 1; i >= 0; --i) this.#drawPixel(context, i);
        this.#say(this.chosen);
    }

    /** The pointer is over a part of the picture. */
    point(x, y) {
        if (!this.#isOn) return;
        const [across, down] = [x * this.picture.offsetWidth, y * this.picture.offsetHeight];
        let [nearest, least] = [-1, NEAR];
        this.pixels.forEach((pixel, i) => {
            const far = Math.hypot(...this.#placeOf(pixel).map((v, axis) => v - [across, down][axis]));
            if (far < least) [nearest, least] = [i, far];
        });
        if (nearest >= 0 && nearest !== this.chosen) this.#choose(nearest);
    }

    #choose(index) {
        this.chosen = index;
        this.draw();
    }

    #placeOf([x, y]) {
        const [width, height] = this.resolution();
        return [((x + 0.5) / width) * this.picture.offsetWidth, ((y + 0.5) / height) * this.picture.offsetHeight];
    }

    #drawPixel(context, index) {
        const [x, y] = this.#placeOf(this.pixels[index]);
        const [width, height] = this.resolution();
        const sides = [this.picture.offsetWidth / width, this.picture.offsetHeight / height].map((side) => Math.max(side, SIDE));
        context.fillStyle = `rgb(${colourOf(this.pixels[index][4] / this.promise)})`;
        context.strokeStyle = index === this.chosen ? "#fff" : "#000";
        context.lineWidth = index === this.chosen ? 3 : 1;
        context.beginPath();
        context.rect(x - sides[0] / 2, y - sides[1] / 2, ...sides);
        context.fill();
        context.stroke();
    }

    /** Squares of the picture with the root of the mean of their squared errors: { x, y, side, error }, in pixels. */
    regions() {
        const side = Math.max(...this.resolution()) / REGIONS;
        const sums = new Map();
        for (const [x, y, , , error] of this.pixels) {
            const corner = [x, y].map((v) => Math.floor(v / side) * side);
            const sum = sums.get(String(corner)) ?? { x: corner[0], y: corner[1], squares: 0, count: 0 };
            sums.set(String(corner), { ...sum, squares: sum.squares + error * error, count: sum.count + 1 });
        }
        return [...sums.values()].map(({ x, y, squares, count }) => ({ x, y, side, error: Math.sqrt(squares / count) }));
    }

    #drawRegions(context) {
        const [width, height] = this.resolution();
        const [across, down] = [this.picture.offsetWidth / width, this.picture.offsetHeight / height];
        for (const { x, y, side, error } of this.regions()) {
            context.fillStyle = `rgba(${colourOf(error / this.promise)}, 0.55)`;
            context.fillRect(x * across, y * down, side * across, side * down);
        }
    }

    #say(index) {
        const pixel = this.pixels[index];
        const rgb = (values) => values.map((v) => v.toPrecision(3)).join("  ");
        this.by("error-value").textContent = !pixel ? "Point at a pixel." : [
            `${pixel[0]}, ${pixel[1]}: error ${short(100 * pixel[4], 3)} %, ${short(pixel[4] / this.promise, 2)} × promise`,
            `picture ${rgb(pixel[2])}`,
            `truth   ${rgb(pixel[3])}`,
        ].join("\n");
    }
}
