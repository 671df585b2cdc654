// SPDX-License-Identifier: Apache-2.0
// The expression of a volume in a text field with the numbers of its lines. It is applied as a whole; where it has a
// mistake, its line is marked, and the mistake stands below.

import { element } from "./values.js";

const ROWS = [4, 24]; // the fewest and the most lines that are seen at once
let fields = 0;
const drafts = new Map(); // control -> what is written and not applied yet, and what the scene said then

export function code(control, label, change) {
    const box = element("div", { className: "code" });
    const numbers = element("pre", { className: "numbers" });
    numbers.setAttribute("aria-hidden", "true");
    const field = element("textarea", { spellcheck: false, wrap: "off", ariaLabel: `${label}: Ctrl+Enter applies it` });
    const mistake = element("output", { id: `mistake-${++fields}`, className: "mistake" });
    mistake.setAttribute("role", "alert");
    field.setAttribute("aria-describedby", mistake.id);
    const apply = element("button", { textContent: "Apply (Ctrl+Enter)", disabled: true });
    apply.ariaLabel = `Apply ${label}`;
    const text = element("div", { className: "text" });
    text.append(numbers, field);
    const wide = element("button", { textContent: "Wide", title: "More or less room for the panel" });
    wide.addEventListener("click", () => {
        document.querySelector("main").classList.toggle("wide");
        dispatchEvent(new Event("resize"));
    });
    const bar = element("div", { className: "bar" });
    bar.append(wide, apply);
    box.append(text, mistake, bar);
    let given = null; // what the scene says
    let wrong = 0; // the line of the mistake

    const number = () => {
        const count = field.value.split("\n").length;
        field.rows = Math.min(Math.max(count, ROWS[0]), ROWS[1]);
        numbers.replaceChildren(...Array.from({ length: count }, (_, i) =>
            element("span", { textContent: `${i + 1}\n`, className: i + 1 === wrong ? "wrong" : "" })));
        numbers.scrollTop = field.scrollTop;
        apply.disabled = field.value === given;
    };
    const give = () => field.value !== given && change(field.value, true);
    field.addEventListener("input", () => {
        if (field.value === given) drafts.delete(control.id);
        else drafts.set(control.id, { base: given, text: field.value });
        number();
    });
    field.addEventListener("scroll", () => (numbers.scrollTop = field.scrollTop));
    field.addEventListener("keydown", (event) => {
        if (event.key !== "Enter" || !(event.ctrlKey || event.metaKey)) return;
        event.preventDefault();
        give();
    });
    apply.addEventListener("click", give);
    const set = (now) => {
        // What is being written stays, unless the scene has got another expression meanwhile.
        const draft = drafts.get(control.id);
        const text = draft?.base === now.value ? draft.text : now.value;
        if (draft?.base !== now.value) drafts.delete(control.id);
        if (field.value !== text) {
            const { selectionStart: from, selectionEnd: to } = field;
            field.value = text;
            field.setSelectionRange(from, to);
        }
        given = now.value;
        wrong = now.mistake?.line ?? 0;
        field.setAttribute("aria-invalid", String(wrong > 0));
        const words = wrong ? `Line ${wrong}, column ${now.mistake.column}: ${now.mistake.text}` : "";
        if (mistake.textContent !== words) mistake.textContent = words;
        number();
    };
    return { parts: [box], set };
}
