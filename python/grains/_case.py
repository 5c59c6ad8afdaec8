"""Cases: what a simulation is of."""
from __future__ import annotations

import copy
import json
import os
from pathlib import Path
from typing import Any, Mapping, Union

from . import _compiled

#: What can be made a case of: a case, the path of a case file, or its content as nested dictionaries.
AnyCase = Union["Case", str, os.PathLike, Mapping[str, Any]]


class Case:
    """A case, checked: wrong keys, values and references raise `grains.CaseError`, which names the key and the remedy.

    `content` is the case as nested dictionaries, as in the manual's reference of all keys. `folder` is the folder to which paths of
    meshes, tables and results are relative.
    """

    def __init__(self, content: Mapping[str, Any], folder: Union[str, os.PathLike] = ".", name: str = "case"):
        text = _compiled.load().toml_of_json(json.dumps(content, default=_plain))
        self._set(text, str(folder), name)

    def _set(self, text: str, folder: str, name: str) -> None:
        self._folder, self._name, self._text = folder, name, text
        self._case = _compiled.load().Case.parse(text, name, folder)

    @classmethod
    def load(cls, path: Union[str, os.PathLike]) -> "Case":
        """The case of a file."""
        path = Path(path)
        try:
            text = path.read_text(encoding="utf-8")
        except OSError as error:
            raise _compiled.load().FilesError(f"{path}: {error.strerror}") from None
        return cls.parse(text, folder=path.parent, name=str(path))

    @classmethod
    def parse(cls, text: str, folder: Union[str, os.PathLike] = ".", name: str = "case") -> "Case":
        """The case of a text in TOML."""
        case = cls.__new__(cls)
        case._set(text, str(folder), name)
        return case

    @property
    def content(self) -> dict:
        """The case as it was given, as nested dictionaries; changing them does not change the case."""
        return json.loads(_compiled.load().json_of_toml(self._text))

    def changed(self, changes: Mapping[str, Any]) -> "Case":
        """The same case with other values, such as `{"time.end": 2.0, "wall.plate.motion": {...}, "insert.0.count": 100}`.

        Elements of lists such as `[[wall]]` are addressed by their name or by their place, from 0. A value of None removes a key.
        """
        content = self.content
        for address, value in changes.items():
            _set_in(content, address, copy.deepcopy(value))
        return Case(content, self._folder, self._name)

    def to_toml(self) -> str:
        """The case as a case file with every default spelt out."""
        return self._case.to_toml()

    @property
    def warnings(self) -> list:
        """Values that are allowed but unlikely."""
        return self._case.warnings

    def check(self, ranks: int = 1) -> dict:
        """What the case will be and cost on a number of ranks, as `grains-mpi check` finds it, without running it.

        Keys: `ranks`, `subdomains`, `memory` (bytes), `disk` (bytes), `warnings`; with particles also `particles`, `mass` (kg),
        `time_step`, `recommended_time_step` (s), `time_step_reason`, `steps`, `seconds` (s) and `max_overlap` (over the radius).
        """
        return self._case.check(ranks)

    def __repr__(self) -> str:
        return f"<grains.Case {self._name!r}>"


def case_of(case: AnyCase) -> Case:
    """A case of whatever can be made one."""
    if isinstance(case, Case):
        return case
    return Case(case) if isinstance(case, Mapping) else Case.load(case)


def schema() -> dict:
    """The JSON schema of case files."""
    return json.loads(_compiled.load().schema())


def _plain(value: Any) -> Any:
    """Numbers and arrays of numpy, and paths, as JSON has them."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise TypeError(f"a case cannot hold {value!r}; give numbers, texts, lists and dictionaries")


def _set_in(content: Any, address: str, value: Any) -> None:
    keys = address.split(".")
    for depth, key in enumerate(keys[:-1]):
        content = _inside(content, key, ".".join(keys[:depth + 1]))
    last = keys[-1]
    if isinstance(content, list):
        content[_place(content, last, address)] = value
    elif value is None:
        content.pop(last, None)
    else:
        content[last] = value


def _inside(content: Any, key: str, address: str) -> Any:
    if isinstance(content, list):
        return content[_place(content, key, address)]
    if not isinstance(content.get(key), (dict, list)):
        if key in content:
            raise _compiled.load().CaseError(f"{address}: is {content[key]!r}, which has no keys")
        content[key] = {}
    return content[key]


def _place(items: list, key: str, address: str) -> int:
    names = [item.get("name") if isinstance(item, dict) else None for item in items]
    if key in names:
        return names.index(key)
    if key.isdecimal() and int(key) < len(items):
        return int(key)
    known = ", ".join(str(name) for name in names if name) or f"0 to {len(items) - 1}"
    raise _compiled.load().CaseError(f"{address}: there is none; there are {known}")
