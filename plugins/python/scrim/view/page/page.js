// SPDX-License-Identifier: Apache-2.0
// The page of the viewer: sends what the user does, and shows what comes back.

import { Handles } from "./handles.js";
import { Looks } from "./looks.js";
import { Panel } from "./panel.js";
import { Picture } from "./picture.js";
import { Verified } from "./verified.js";
import { layOver, placeOf } from "./places.js";
import { drawBox, pickPlace, showBox, steer } from "./steer.js";

const RETRY_MS = 500; // until a lost connection is tried again
const BUTTON_KEYS = { f: "frame-all", Home: "scene-camera", s: "snapshot", w: "compare", l: "layers", h: "lights", r: "region", d: "focus", n: "error-next", " ": "play" };

const by = (id) => document.getElementById(id);
const canvas = by("picture");
let socket = null;
let serial = 0; // of the last event
let state = null;
let stage = { text: "" };
let isDrawn = true;
let hasEnded = false;
const sent = new Map(); // serial -> time, of events whose picture has not come yet
// For measurements: milliseconds from an event to its picture, or to what is here with its weights, or from its view.
const times = { picture: [], weights: [], view: [] };

/** An error stays until a later event went well. */
let failed = 0;
function fail(text) {
    failed = serial;
    by("error").textContent = text;
    by("error").hidden = !text;
}

function say(text) {
    Object.assign(by("status"), { textContent: text, title: text }); // there may be no room for all of it
}

let picture = null;
try {
    picture = new Picture(canvas);
} catch (problem) {
    fail(problem.message);
}

function send(message) {
    if (socket?.readyState !== WebSocket.OPEN) return;
    if (!["display", "save"].includes(message.type)) verified.show(false); // until the picture is verified again
    socket.send(JSON.stringify({ ...message, serial: ++serial }));
    sent.set(serial, performance.now());
}

// ---- what comes

function connect() {
    socket = new WebSocket(new URL("socket", location.href).href.replace("http", "ws")); // https becomes wss
    socket.binaryType = "arraybuffer";
    socket.onopen = () => fail("");
    socket.onmessage = ({ data }) => (typeof data === "string" ? hear(JSON.parse(data)) : receive(data));
    socket.onclose = (event) => {
        if (event.code === 1001 || hasEnded) return fail("The viewer has ended.");
        say("connection lost, trying again");
        setTimeout(connect, RETRY_MS);
    };
}

function hear(message) {
    if (message.type === "state") return showState(message);
    if (message.type === "error") return fail(message.text);
    if (message.type === "weights") {
        moved = message.handles;
        turnTo(message);
        return weigh(message.weights, message.serial);
    }
    if (message.type === "verified") verified.take(message);
    if (message.type === "frame") showFrame(message.number);
    if (message.type === "progress") {
        by("progress").value = message.part ?? 0;
        by("progress").style.visibility = message.part === null ? "hidden" : "visible";
    }
}

function receive(buffer) {
    const length = new DataView(buffer).getUint32(0, true);
    const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
    const bytes = new Uint8Array(buffer, 4 + length);
    if (head.type === "lut") {
        picture?.setTable(head, bytes);
        document.body.dataset.table = head.fine ? "fine" : "coarse";
    }
    if (head.type === "pictures") {
        picture?.setPictures(head, bytes);
        stage = head;
        showStage();
    }
    if (head.type === "pictures") socket.send(JSON.stringify({ type: "have" }));
    // While a light is dragged its layer comes again and again, and all of them are summed each time.
    redraw(() => head.type === "pictures" && settle(head.serial, times.picture), sent.size > 1 && Boolean(picture?.weights));
}

function settle(upTo, list) {
    const now = performance.now();
    for (const [number, then] of sent) {
        if (number > upTo) continue;
        if (number === upTo) list.push(now - then);
        sent.delete(number);
    }
}

/** Draws before the next picture of the screen. `after` is called before the one behind it: what was drawn is then shown.
    `isQuick`: more of the same will follow at once; if not, a better picture follows soon. */
const SOON_MS = 150;
let waiting = [];
let better = 0;
let moved = null; // handles of lights, which go with the next picture
function redraw(after, isQuick = false) {
    if (after) waiting.push(after);
    if (!isDrawn) return;
    isDrawn = false;
    requestAnimationFrame((then) => {
        isDrawn = true;
        picture?.draw(isQuick);
        if (moved) handles.update(moved);
        moved = null;
        const all = waiting;
        waiting = [];
        requestAnimationFrame((now) => {
            if (isQuick) picture?.tookTo(now - then);
            else looks?.update(canvas);
            all.forEach((call) => call(now));
        });
        clearTimeout(better);
        if (isQuick) better = setTimeout(() => redraw(), SOON_MS);
    });
}

function showStage() {
    const words = { motion: "moving", draft: "draft", final: "finished", region: "finished in the region" };
    const isFile = stage.exact && state && !state.free && !state.changed && !state.muted.length;
    const text = isFile ? "finished: the file's picture" : words[stage.stage] ?? "";
    const percent = (part) => `${(100 * part).toPrecision(2)} %`;
    const error = stage.error ? `, error ${percent(stage.error.error)} of ${stage.error.pixels} pixels` : "";
    say(stage.seconds ? `${text} (${stage.seconds.toFixed(2)} s${error})` : text);
    document.body.dataset.stage = stage.exact ? "exact" : stage.stage ?? "";
    verified.show(stage.exact && Boolean(stage.error));
    document.body.dataset.layers = stage.layers ? "ready" : "";
    by("download").style.visibility = stage.exact ? "visible" : "hidden";
}

function showState(message) {
    state = message;
    serial = Math.max(serial, message.serial);
    if (message.serial > failed) fail("");
    document.title = `${state.changed ? "• " : ""}${state.title} · Scrim`;
    by("title").textContent = state.title + (state.changed ? " •" : "");
    by("undo").disabled = !state.undo;
    by("redo").disabled = !state.redo;
    by("save").disabled = !state.file || !state.changed;
    by("keep-view").disabled = by("scene-camera").disabled = !state.free;
    const isWrong = state.groups.some(({ controls }) => controls.some(({ mistake }) => mistake));
    if (isWrong) say("the code has a mistake: the last picture");
    if (state.message) say(state.message);
    fillViews();
    by("open").hidden = !state.others.length;
    if (by("open").options.length !== state.others.length) by("open").replaceChildren(...state.others.map((name) => new Option(name)));
    by("open").value = state.title;
    by("timeline").hidden = state.frames.length < 2;
    const frame = by("frame");
    [frame.min, frame.max] = [state.frames[0], state.frames[state.frames.length - 1]];
    if (!frame.matches(":active")) showFrame(state.frame);
    by("play").setAttribute("aria-pressed", String(state.playing));
    draws(isDrawing);
    fillCameras();
    panel.update(state.groups, state.muted);
    moved = null;
    handles.update(state.handles);
    handles.mute(state.muted);
    if (picture) picture.muted = new Set(state.muted);
    turnTo(state);
    weigh(state.weights, state.serial);
    resize();
}

/** Shows the pictures that are here from the newest view. */
function turnTo({ camera, changed_by: changedBy, serial: upTo }) {
    if (!picture?.isReady) return;
    picture.turnTo(camera, changedBy);
    const then = sent.get(upTo);
    if (picture.isWarped) redraw((now) => then && times.view.push(now - then));
}

/** Shows other weights of the layers that are here. */
function weigh(weights, upTo) {
    if (!picture || picture.slots.beauty === undefined || alike(weights, picture.weights)) return;
    picture.setWeights(weights);
    redraw(() => weights && settle(upTo, times.weights), true);
}

function alike(a, b) {
    if (!a || !b) return a === b;
    return Object.keys(a).every((name) => b[name]?.every((v, i) => Math.abs(v - a[name][i]) <= 1e-5 * Math.abs(v)));
}

/** Shows what a control makes of its layer, before the viewer has read it: light adds up. */
function foresee(control, value) {
    const weight = picture?.weights?.[control.layer] ?? (stage.layers && picture.slots[control.layer] !== undefined ? [1, 1, 1] : null);
    if (!weight || !control.law) return;
    const [now, then] = [value, control.value].map((v) => (Array.isArray(v) ? v : [v, v, v]));
    const factors = weight.map((w, i) => (control.law === "stops" ? w * 2 ** (now[i] - then[i]) : (w * now[i]) / then[i]));
    if (state.muted.includes(control.layer) || factors.some((f) => !Number.isFinite(f))) return;
    picture.setWeights({ ...(picture.weights ?? Object.fromEntries(picture.layers.map((name) => [name, [1, 1, 1]]))), [control.layer]: factors });
    const upTo = serial;
    redraw(() => settle(upTo, times.weights), true);
}

function showFrame(number) {
    by("frame").value = number;
    if (document.activeElement !== by("frame-number")) by("frame-number").value = number;
}

function fillCameras() {
    const select = by("cameras");
    select.hidden = state.cameras.length < 2;
    if (select.options.length - 1 !== state.cameras.length) {
        select.replaceChildren(new Option("Look through…", ""), ...state.cameras.map((name) => new Option(name)));
    }
    select.value = "";
}

function fillViews() {
    const all = Object.entries(state.displays).flatMap(([display, views]) => views.map((view) => JSON.stringify([display, view])));
    const select = by("view");
    if (select.options.length !== all.length) {
        select.replaceChildren(...all.map((value) => new Option(JSON.parse(value).reverse().join(" · "), value)));
    }
    select.value = JSON.stringify([state.display, state.view]);
}

function resize() {
    if (!state) return;
    const [width, height] = state.resolution;
    const box = by("stage").getBoundingClientRect();
    const scale = Math.min((box.width - 2) / (height * state.aspect), (box.height - 2) / height); // its frame is seen
    const [across, down] = [Math.floor(height * state.aspect * scale), Math.floor(height * scale)];
    const before = `${canvas.style.width} ${picture?.full}`;
    Object.assign(canvas.style, { width: `${across}px`, height: `${down}px` });
    // No more pixels than the picture has, nor than the screen shows.
    const share = Math.min(1, (down * devicePixelRatio) / height);
    picture?.resize(Math.max(Math.round(width * share), 1), Math.max(Math.round(height * share), 1));
    if (before !== `${canvas.style.width} ${picture?.full}`) redraw();
    placeWipe();
    placeGate();
    handles.fit();
    verified.draw();
    showBox(canvas, by("box"), state.region && state.region.map((v, i) => v / state.resolution[i % 2]));
}

/** The frame of another aspect, as large as it fits into the picture. */
function placeGate() {
    const gate = by("gate");
    gate.hidden = !by("aspect").value;
    layOver(gate, canvas);
    const across = Math.min(canvas.offsetWidth, canvas.offsetHeight * by("aspect").value);
    Object.assign(gate.firstElementChild.style, { width: `${across}px`, height: `${across / by("aspect").value}px` });
}

// ---- what the user does

const click = (id, call) => by(id).addEventListener("click", call);
let step = 0;
const panel = new Panel(by("panel"), (control, value, done) => {
    send({ type: "set", id: control.id, value, done, step: `${control.id} ${step}` });
    if (!done) foresee(control, value);
    control.value = value;
    if (done) ++step;
}, (names) => send({ type: "muted", names }), (light) => send({ type: "remove", light }));
by("add-light").addEventListener("change", () => {
    send({ type: "add", light: by("add-light").value });
    by("add-light").value = "";
});

const handles = new Handles(by("handles"), canvas, (light, x, y, done) => {
    send({ type: "place", light, x, y, done, step: `place ${light} ${step}` });
    if (done) ++step;
});
click("fold", () => panel.foldLights());
click("lights", () => {
    by("handles").hidden = !by("handles").hidden;
    by("lights").setAttribute("aria-pressed", String(!by("handles").hidden));
});
const verified = new Verified(by, canvas, () => state.resolution);
let isDrawing = false; // a region
const draws = (on) => by("region").setAttribute("aria-pressed", String((isDrawing = on) || Boolean(state?.region)));
click("region", () => {
    if (isDrawing) return;
    if (state.region) return send({ type: "region", box: null });
    draws(true);
    drawBox(canvas, by("box"), (box) => {
        draws(false);
        send({ type: "region", box });
    });
});
let stopFocus = null; // while a place is waited for
function focusOn(stop) {
    stopFocus = stop;
    by("focus").setAttribute("aria-pressed", String(Boolean(stop)));
    by("stage").classList.toggle("picks", Boolean(stop));
}
click("focus", () => {
    if (stopFocus) {
        stopFocus();
        return focusOn(null);
    }
    focusOn(pickPlace(canvas, (x, y) => {
        focusOn(null);
        send({ type: "focus", x, y, done: true });
    }));
});
const looks = picture && new Looks(picture, by, redraw, (layer) => layer !== "beauty" && panel.soloOf(layer));

steer(canvas, send, showPixel, (x, y) => {
    if (handles.selected === null) return fail("There is no light with a handle that could shine here.");
    send({ type: "highlight", light: handles.selected, x, y, done: true });
});

function showPixel(event) {
    const [x, y] = placeOf(canvas, event);
    if (!picture || x < 0 || y < 0 || x >= 1 || y >= 1) return;
    verified.point(x, y);
    const value = picture.valueAt(x, y);
    if (!value) return;
    const place = `${Math.floor(x * state.resolution[0])}, ${Math.floor(y * state.resolution[1])}`;
    by("pixel").textContent = `${place}:  ${[...value].map((v) => v.toPrecision(3)).join("  ")}`;
}

for (const type of ["undo", "redo", "save", "verify"]) click(type, () => send({ type }));
click("save-as", () => {
    const name = prompt("Name of the new scene, in the same folder:", state.file || state.title.replace(/\.[^.]*$/, "") + ".toml");
    if (name) send({ type: "save", name });
});
click("command", async () => {
    await navigator.clipboard.writeText(state.command).catch(() => prompt("The command:", state.command));
    say("the command is copied");
});
click("frame-all", () => send({ type: "view", to: "frame" }));
click("scene-camera", () => send({ type: "view", to: "scene" }));
click("keep-view", () => send({ type: "view", to: "keep" }));
click("end", () => {
    hasEnded = true;
    send({ type: "end" });
});
by("open").addEventListener("change", () => {
    if (state.changed && state.undo && !confirm(`Leave ${state.title} without saving it?`)) return void (by("open").value = state.title);
    send({ type: "open", name: by("open").value });
});
by("view").addEventListener("change", (event) => {
    const [display, view] = JSON.parse(event.target.value);
    send({ type: "display", display, view });
});
for (const name of ["exposure", "gamma"]) {
    by(name).addEventListener("input", () => {
        if (picture && by(name).value !== "") picture[name] = Number(by(name).value);
        redraw();
    });
}
by("frame").addEventListener("input", () => send({ type: "frame", number: Number(by("frame").value), done: false }));
by("frame").addEventListener("change", () => send({ type: "rest" }));
by("frame-number").addEventListener("change", () => {
    const number = Number.parseInt(by("frame-number").value, 10);
    if (Number.isFinite(number)) send({ type: "frame", number, done: true });
});
click("play", () => send({ type: "play", on: !state.playing }));
by("cameras").addEventListener("change", (event) => event.target.value && send({ type: "camera", name: event.target.value, done: true }));

click("snapshot", () => {
    picture?.keepSnapshot();
    by("compare").disabled = false;
});
click("compare", () => {
    picture.wipe = picture.wipe ? 0 : 0.5;
    by("compare").setAttribute("aria-pressed", String(picture.wipe > 0));
    placeWipe();
    redraw();
});
function placeWipe() {
    const bar = by("wipe");
    bar.hidden = !picture?.wipe;
    bar.style.left = `${canvas.offsetLeft + (picture?.wipe ?? 0) * canvas.offsetWidth}px`;
}
by("wipe").addEventListener("pointerdown", (event) => by("wipe").setPointerCapture(event.pointerId));
by("wipe").addEventListener("pointermove", (event) => {
    if (!event.buttons) return;
    picture.wipe = Math.min(Math.max(placeOf(canvas, event)[0], 0.001), 1);
    placeWipe();
    redraw();
});

by("aspect").addEventListener("change", placeGate);

addEventListener("resize", resize);
addEventListener("keydown", (event) => {
    if (event.target.matches("input, select, textarea") || (event.key === " " && event.target.matches("button, summary"))) return;
    if (event.ctrlKey || event.metaKey) {
        const id = { z: event.shiftKey ? "redo" : "undo", s: "save" }[event.key.toLowerCase()];
        if (!id) return;
        event.preventDefault();
        if (!by(id).disabled) by(id).click();
        return;
    }
    const button = BUTTON_KEYS[event.key];
    const field = { e: "exposure", g: "gamma" }[event.key.toLowerCase()];
    if (button && !by(button).disabled) by(button).click();
    else if (field) {
        by(field)[event.shiftKey ? "stepDown" : "stepUp"]();
        by(field).dispatchEvent(new Event("input"));
    }
});

// For tests and measurements.
globalThis.scrim = {
    times,
    get socket() { return socket; },
    get picture() { return picture; },
    get state() { return state; },
    get pending() { return sent.size; },
    get isConnected() { return socket?.readyState === WebSocket.OPEN; },
    get isSettled() { return stage.serial >= (state?.serial ?? Infinity) && serial === state.serial; },
    verified,
    cut: () => socket.close(),
    readPixels: () => picture.readPixels(),
};
connect();
