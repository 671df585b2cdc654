// SPDX-License-Identifier: Apache-2.0
// The mouse and the keys over the picture move the view.
//
// Plain and Alt drags are as in Maya and Houdini: left orbits, middle pans, right dollies; Shift and Ctrl choose for one
// button. A Shift-click that does not move is no pan: it points at a place.

import { layOver, placeOf } from "./places.js";

const NEAR = 3; // pixels that a click may move
const WHEEL = 0.08;

function modeOf(event) {
    if (event.button === 1 || event.shiftKey) return "pan";
    return event.button === 2 || event.ctrlKey ? "dolly" : "orbit";
}

/** A box that is drawn over the canvas with the next drag: `done` hears its sides in parts of the canvas. */
export function drawBox(canvas, box, done) {
    const at = (event) => placeOf(canvas, event).map((v) => Math.min(Math.max(v, 0), 1));
    canvas.addEventListener("pointerdown", (event) => {
        event.stopImmediatePropagation(); // the view stays
        canvas.setPointerCapture(event.pointerId);
        const from = at(event);
        const sides = (it) => [0, 1].map((i) => Math.min(from[i], at(it)[i])).concat([0, 1].map((i) => Math.max(from[i], at(it)[i])));
        const move = (it) => {
            it.stopImmediatePropagation();
            showBox(canvas, box, sides(it));
        };
        canvas.addEventListener("pointermove", move, true);
        canvas.addEventListener("pointerup", (it) => {
            it.stopImmediatePropagation();
            canvas.removeEventListener("pointermove", move, true);
            done(sides(it));
        }, { once: true, capture: true });
    }, { once: true, capture: true });
}

/** Lays `box` over a part of the canvas; null hides it. */
/** Waits for a click on the canvas: `done` hears its place in parts of the canvas. Returns a function that waits no more. */
export function pickPlace(canvas, done) {
    const stopped = new AbortController();
    canvas.addEventListener("pointerdown", (event) => {
        event.stopImmediatePropagation(); // the view stays
        done(...placeOf(canvas, event));
    }, { once: true, capture: true, signal: stopped.signal });
    return () => stopped.abort();
}

export function showBox(canvas, box, sides) {
    box.hidden = !sides;
    if (sides) layOver(box, canvas, sides);
}

/** `send(message)`; `hover(event)`: the mouse moves without a button; `point(x, y)`: a part of the canvas was meant. */
export function steer(canvas, send, hover, point) {
    let drag = null;
    let moved = { dx: 0, dy: 0 };
    const flush = () => {
        if (!drag || (!moved.dx && !moved.dy)) return;
        send({ type: "navigate", mode: drag.mode, ...moved });
        moved = { dx: 0, dy: 0 };
    };
    canvas.addEventListener("pointerdown", (event) => {
        canvas.setPointerCapture(event.pointerId);
        const { clientX: x, clientY: y } = event;
        drag = { mode: modeOf(event), x, y, from: [x, y], points: event.shiftKey && event.button === 0 };
        canvas.focus();
        event.preventDefault();
    });
    canvas.addEventListener("pointermove", (event) => {
        if (!drag) return hover(event);
        if (drag.points && Math.hypot(event.clientX - drag.from[0], event.clientY - drag.from[1]) <= NEAR) return;
        drag.points = false;
        const height = canvas.getBoundingClientRect().height;
        moved.dx += (event.clientX - drag.x) / height;
        moved.dy += (event.clientY - drag.y) / height;
        [drag.x, drag.y] = [event.clientX, event.clientY];
        flush(); // browsers give one such event for each picture of the screen
    });
    const drop = () => {
        if (!drag) return;
        const { points, from } = drag;
        flush();
        drag = null;
        if (!points) return send({ type: "rest" });
        point(...placeOf(canvas, { clientX: from[0], clientY: from[1] }));
    };
    canvas.addEventListener("pointerup", drop);
    canvas.addEventListener("pointercancel", drop);
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => {
        event.preventDefault();
        send({ type: "navigate", mode: "dolly", dx: 0, dy: Math.sign(event.deltaY) * WHEEL });
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
        const turns = { ArrowLeft: [-0.03, 0], ArrowRight: [0.03, 0], ArrowUp: [0, -0.03], ArrowDown: [0, 0.03] }[event.key];
        const dolly = { "+": -WHEEL, "-": WHEEL }[event.key];
        if (turns) send({ type: "navigate", mode: event.shiftKey ? "pan" : "orbit", dx: turns[0], dy: turns[1] });
        else if (dolly) send({ type: "navigate", mode: "dolly", dx: 0, dy: dolly });
        else return;
        event.preventDefault();
    });
}
