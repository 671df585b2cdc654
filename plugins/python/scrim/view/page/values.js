// SPDX-License-Identifier: Apache-2.0
// What the parts of the panel share: elements, numbers as text, and the curve of sRGB.

export function element(name, values = {}) {
    return Object.assign(document.createElement(name), values);
}

// Numbers as the viewer writes them, six digits, and as there is room for them.
export function short(value, digits = 6) {
    return String(Number(Number(value).toPrecision(digits)));
}

export function linear(v) {
    return v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
}

export function encoded(v) {
    const byte = Math.round(255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055));
    return byte.toString(16).padStart(2, "0");
}
