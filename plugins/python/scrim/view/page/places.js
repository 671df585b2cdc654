// SPDX-License-Identifier: Apache-2.0
// Places in the picture, which are parts of the canvas: 0 to 1 from its upper left corner.

/** Where an event is. */
export function placeOf(canvas, event) {
    const { left, top, width, height } = canvas.getBoundingClientRect();
    return [(event.clientX - left) / width, (event.clientY - top) / height];
}

/** Puts an element of the same parent over the canvas, or over the part of it between two corners. */
export function layOver(element, canvas, [x0, y0, x1, y1] = [0, 0, 1, 1]) {
    const { offsetLeft, offsetTop, offsetWidth, offsetHeight } = canvas;
    const numbers = { left: offsetLeft + x0 * offsetWidth, top: offsetTop + y0 * offsetHeight, width: (x1 - x0) * offsetWidth, height: (y1 - y0) * offsetHeight };
    for (const [side, number] of Object.entries(numbers)) element.style[side] = `${number}px`;
}
