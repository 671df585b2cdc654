# SPDX-License-Identifier: Apache-2.0
"""The scene that is edited, as text. A change touches only the keys that it changes: tomlkit keeps comments, order and
spelling of everything else.

This text is what is rendered, so a saved scene shows what the viewer showed.
"""

from __future__ import annotations

import copy
import os
import re
import tempfile
from collections.abc import Iterable, Iterator, Mapping

import tomlkit
from tomlkit.items import Array, String, StringType, Trivia
from scrim_kit import toml_text

from .._errors import OutputError, UsageError

# A place in a scene: names of tables and keys, and numbers of items in lists of tables.
Place = tuple[str | int, ...]
Change = tuple[Place, object]  # None removes the key

_PLAIN = re.compile(r"[A-Za-z0-9_-]+")
_DIGITS = 6  # significant digits of numbers from sliders


def rounded(value: object) -> object:
    """A number with as many digits as a person would write; in lists, each number."""
    if isinstance(value, float):
        return float(f"{value:.{_DIGITS}g}")
    if isinstance(value, (list, tuple)):
        return [rounded(one) for one in value]
    if isinstance(value, dict):
        return {key: rounded(one) for key, one in value.items()}
    return value


def name_of(kind: str, index: int, table: Mapping) -> str:
    """The name by which --set knows an item of a list of tables: its own, else the default."""
    return str(table.get("name", f"{kind}{index + 1}"))


def path_of(kind: str, index: int, table: Mapping) -> str:
    """How --set reaches an item of a list of tables: by its name where that can be a part of a path, else by its
    place."""
    name = name_of(kind, index, table)
    return f"{kind}.{name}" if _PLAIN.fullmatch(name) else f"{kind}[{index}]"


def _change(document: dict, place: Place, value: object) -> None:
    """Changes a text that was parsed, or plain tables."""
    *tables, key = place
    table = document
    for name in tables:
        if isinstance(table, Mapping) and name not in table:
            if value is None:
                return
            if table is document and name in LISTS:
                table[name] = tomlkit.aot() if isinstance(document, tomlkit.TOMLDocument) else []
            else:
                table[name] = _new_table(document, table)
        table = table[name]
    if isinstance(table, list):
        _change_list(document, table, key, value)
    elif value is None:
        table.pop(key, None)
    elif table.get(key) != value:
        is_text = isinstance(document, tomlkit.TOMLDocument)
        if is_text and _holds_lists(table.get(key)) and _holds_lists(value):
            _change_items(table[key], value)
        else:
            table[key] = _written(value, table.get(key)) if is_text else copy.deepcopy(value)


def _holds_lists(value: object) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(one, list) for one in value)


def _change_items(items: Array, value: list) -> None:
    """Changes a list of lists, such as keys, in place: what stays keeps its spelling and its comments."""
    for index, one in enumerate(value):
        if index < len(items) and items[index] == one:
            continue
        if index < len(items) and len(items) >= len(value):
            items[index] = one
        else:
            items.insert(index, one)
    while len(items) > len(value):
        items.pop()


def _change_list(document: dict, tables: list, index: int, value: object) -> None:
    """Removes an item of a list of tables, or adds one behind the others."""
    if value is None:
        del tables[index]
        return
    if not isinstance(document, tomlkit.TOMLDocument):
        tables.append(copy.deepcopy(value))
        return
    table = tomlkit.inline_table() if isinstance(tables, Array) else tomlkit.table()
    table.update(copy.deepcopy(value))
    if not isinstance(tables, Array):
        table.add(tomlkit.nl())
    tables.append(table)


def _merged(before: Mapping, after: Mapping, base: Mapping, place: Place = ()) -> Iterator[Change]:
    """The changes from `before` to `after`, as changes of `base`. Items of lists of tables are identified by their
    names."""
    for key in [*before, *(key for key in after if key not in before)]:
        old, new, now = before.get(key), after.get(key), base.get(key)
        if old == new:
            continue
        if not place and key in LISTS:
            yield from _merged_lists(key, old or [], new or [], now or [])
        elif all(isinstance(one, Mapping) for one in (old, new, now)):
            yield from _merged(old, new, now, (*place, key))
        else:
            yield (*place, key), new


def _merged_lists(key: str, before: list, after: list, base: list) -> Iterator[Change]:
    old, new, now = ({name_of(key, i, it): i for i, it in enumerate(one)} for one in (before, after, base))
    for name in new:
        if name in old and name in now:
            yield from _merged(before[old[name]], after[new[name]], base[now[name]], (key, now[name]))
    added = [name for name in new if name not in old and name not in now]
    yield from (((key, len(base) + i), after[new[name]]) for i, name in enumerate(added))
    yield from (((key, now[name]), None) for name in reversed(now) if name in old and name not in new)


def _written(value: object, before: object) -> object:
    """`value` as it is written in place of `before`. A text of several lines keeps the kind of quotes of `before`,
    else it is literal. A list of tables has a line for each table."""
    if isinstance(value, str) and "\n" in value:
        return _lines(value, before)
    if not (isinstance(value, list) and value and all(isinstance(one, dict) for one in value)):
        return value
    out = tomlkit.array().multiline(True)
    for one in value:
        table = tomlkit.inline_table()
        table.update(one)
        out.append(table)
    return out


def _lines(text: str, before: object) -> String:
    kind, trivia = StringType.MLL, Trivia()
    if isinstance(before, String):
        trivia = before.trivia
        if before.as_string().startswith('"""'):
            kind = StringType.MLB
    if "'''" in text:
        kind = StringType.MLB
    raw = text if kind is StringType.MLL else text.replace("\\", "\\\\").replace('"""', '""\\"')
    return String(kind, text, "\n" + raw, trivia)


def _new_table(document: dict, table: dict) -> dict:
    if not isinstance(document, tomlkit.TOMLDocument):
        return {}
    # Within a section a short table is written in one line; at the top of the scene it becomes a section.
    return tomlkit.table() if table is document else tomlkit.inline_table()


class Document:
    """A scene's text with its history. `file`: where it was read and is saved; "": it is new. Not thread-safe."""

    def __init__(self, text: str, file: str = "") -> None:
        self.file = file
        self._saved = text  # what the file holds
        self._original = text  # what a command line begins with
        self._base = text  # the text to which the changes are made
        self._past: list[tuple[str, str]] = []  # bases, and texts that were made of them
        self._future: list[tuple[str, str]] = []
        self._step: object = None
        self._set(text)

    def _set(self, text: str) -> None:
        self.text = text
        self.data: dict = tomlkit.parse(text).unwrap()
        # Parsing the text takes too long for a slider, so the parsed text is changed in place.
        self._parsed: tomlkit.TOMLDocument | None = None  # the text, parsed; None: not yet
        self._next: tuple[str, tomlkit.TOMLDocument, dict] | None = None  # the last result of `changed`, parsed

    @property
    def can_undo(self) -> bool:
        return bool(self._past)

    @property
    def can_redo(self) -> bool:
        return bool(self._future)

    @property
    def is_changed(self) -> bool:
        """Whether the text differs from that of the file."""
        return not self.file or self.text != self._saved

    def changed(self, changes: Iterable[Change]) -> str:
        """The text with these changes."""
        document, self._parsed = self._parsed or tomlkit.parse(self.text), None
        data = copy.deepcopy(self.data)
        for place, value in changes:
            _change(document, place, rounded(value))
            _change(data, place, rounded(value))
        text = tomlkit.dumps(document)
        self._next = (text, document, data)
        return text

    def data_of(self, text: str) -> dict:
        """The tables of a text. The scene's text and the last result of `changed` are not parsed again."""
        if text == self.text:
            return self.data
        return self._next[2] if self._next and self._next[0] == text else tomlkit.parse(text).unwrap()

    def take(self, text: str, step: object = None) -> None:
        """Makes `text` the scene. Changes of the same `step` that follow each other are undone together."""
        if text == self.text:
            return
        if step is None or step != self._step:
            self._past.append((self._base, self.text))
        self._step = step
        self._future.clear()
        if self._next is None or self._next[0] != text:
            self._set(text)
        else:
            self.text, self._parsed, self.data = self._next
            self._next = None

    def undo(self) -> bool:
        return self._move(self._past, self._future)

    def redo(self) -> bool:
        return self._move(self._future, self._past)

    def _move(self, source: list[str], target: list[str]) -> bool:
        self._step = None
        if not source:
            return False
        target.append((self._base, self.text))
        base, text = source.pop()
        self._set(text if base == self._base else _on_base(base, text, self._base))
        return True

    def on_base(self, base: str, instead: Mapping[str, object]) -> str:
        """The text that the changes so far make of another base. `instead`: sections that replace those of the
        result."""
        return base if self.text == self._base and not instead else _on_base(self._base, self.text, base, instead)

    def take_base(self, base: str, text: str) -> None:
        """Makes `text` the scene, which is `base` with the changes so far. That is no step to undo."""
        if not self.file:
            self._original = base
        self._base = base
        self._set(text)

    def save(self, file: str = "") -> None:
        """Writes the scene to its own file or, where `file` is given, to a new one, which is its own from then on.
        Raises OutputError where somebody else changed the file, where the new one exists, and where writing fails."""
        try:
            if file:
                _write_new(file, self.text)
                self.file = file
            else:
                with open(self.file, encoding="utf-8", newline="") as there:
                    if there.read() != self._saved:
                        raise OutputError(f"{self.file}: changed on disk since it was opened; save under a new name")
                _replace(self.file, self.text)
        except OSError as error:
            raise OutputError(f"cannot write '{file or self.file}': {error.strerror}") from error
        self._saved = self._original = self.text

    def assignments(self) -> list[str]:
        """Texts for --set that make this scene of the one that was opened. Raises UsageError where --set cannot."""
        original = tomlkit.parse(self._original).unwrap()
        before = dict(_values(original))
        now = dict(_values(self.data))
        for kind in LISTS:
            known = [name_of(kind, i, one) for i, one in enumerate(original.get(kind, []))]
            for index, one in enumerate(self.data.get(kind, [])):
                if (name := name_of(kind, index, one)) not in known:
                    raise UsageError(f"the command line cannot add '{kind}.{name}'; save the scene instead")
        gone = [path for path in before if path not in now]
        rivals = ("camera.",)  # --set of a camera's key removes the keys that exclude it
        lost = [path for path in gone if not path.startswith(rivals)]
        if lost:
            raise UsageError(f"the command line cannot remove '{lost[0]}'; save the scene instead")
        return [toml_text.assignment(path, value) for path, value in now.items() if before.get(path) != value]


def _on_base(before: str, after: str, base: str, instead: Mapping[str, object] | None = None) -> str:
    """The changes that led from one text to another, made to a third."""
    document, data = tomlkit.parse(base), tomlkit.parse(base).unwrap()
    changes = [
        change
        for change in _merged(tomlkit.parse(before).unwrap(), tomlkit.parse(after).unwrap(), data)
        if change[0][0] not in (instead or {})
    ]
    for place, value in [*changes, *(((key,), None) for key in instead or {})]:
        _change(document, place, value)
    for key, value in (instead or {}).items():
        _change(document, (key,), value)
    return tomlkit.dumps(document)


def _values(scene: Mapping) -> Iterator[tuple[str, object]]:
    """(path as for --set, value) of every value of a scene."""
    for key, value in scene.items():
        if isinstance(value, Mapping):
            for inner, it in _values(value):
                yield f"{key}.{inner}", it
        elif isinstance(value, list) and value and all(isinstance(one, Mapping) for one in value) and key in LISTS:
            for index, one in enumerate(value):
                for inner, it in _values(one):
                    yield f"{path_of(key, index, one)}.{inner}", it
        else:
            yield key, value


LISTS = ("volume", "light", "mesh")


def _write_new(file: str, text: str) -> None:
    try:
        with open(file, "x", encoding="utf-8", newline="") as new:
            new.write(text)
    except FileExistsError:
        raise OutputError(f"{file}: there is such a file already; choose another name") from None


def _replace(file: str, text: str) -> None:
    # Written beside the file and renamed: whoever reads the file meanwhile gets a whole scene.
    file = os.path.realpath(file)
    mode = os.stat(file).st_mode & 0o7777
    handle, part = tempfile.mkstemp(prefix=".scrim-view-", dir=os.path.dirname(file))
    try:
        with os.fdopen(handle, "w", encoding="utf-8", newline="") as new:
            new.write(text)
        os.chmod(part, mode)
        os.replace(part, file)
    except BaseException:
        os.unlink(part)
        raise
