#!/usr/bin/env python3
"""Checks that a validator accepts the case files and names every typo in one of their keys once.

Usage: schema_typos.py SCHEMA FOLDER...        (SCHEMA: what `grains-mpi schema` prints)

Every key of every case in the folders is misspelt in turn. The validator must then name the wrong word in one error; keys that
are now missing may be others. Wrong words for `kind` and other choices must give one error as well.
"""

import copy
import json
import sys
import tomllib
from pathlib import Path

from jsonschema import Draft202012Validator


def places(value, path=()):
    """Paths of all keys of a case."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield (*path, key)
            yield from places(inner, (*path, key))
    elif isinstance(value, list):
        for k, inner in enumerate(value):
            yield from places(inner, (*path, k))


def at(case, path):
    for key in path:
        case = case[key]
    return case


def leaves(errors):
    """Errors without those that only gather others."""
    for error in errors:
        if error.context:
            yield from leaves(error.context)
        else:
            yield error


def main():
    schema = json.loads(Path(sys.argv[1]).read_text())
    Draft202012Validator.check_schema(schema)
    validator = Draft202012Validator(schema)
    faults, typos = [], 0
    files = sorted(file for folder in sys.argv[2:] for file in Path(folder).rglob("*.toml"))
    for file in files:
        case = tomllib.loads(file.read_text())
        if "domain" not in case:
            continue
        faults += [f"{file}: {error.json_path}: {error.message[:200]}" for error in validator.iter_errors(case)]
        for path in places(case):
            typos += 1
            *outer, key = path
            wrong = copy.deepcopy(case)
            table = at(wrong, outer)
            table[key + "x"] = table.pop(key)
            errors = [error.message for error in leaves(validator.iter_errors(wrong))]
            naming = [message for message in errors if f"'{key}x'" in message and "unexpected" in message]
            missing = [message for message in errors if message.endswith("is a required property")]
            # A misspelt `kind` is a missing one until it is mended: its table has no keys yet to compare with.
            if key == "kind" and len(missing) == 1 and len(errors) <= 2:
                continue
            if len(naming) != 1 or len(naming) + len(missing) != len(errors):
                faults.append(f"{file}: {path} misspelt: {[message[:150] for message in errors]}")
            if isinstance(at(case, path), str) and key in ("kind", "face", "drag", "model", "precision", "motion"):
                wrong = copy.deepcopy(case)
                at(wrong, outer)[key] = "nonsense"
                errors = [error.message for error in leaves(validator.iter_errors(wrong))]
                if len(errors) != 1:
                    faults.append(f"{file}: {path} = nonsense: {[message[:150] for message in errors]}")
    if faults:
        sys.exit("\n".join(faults[:20] + [f"{len(faults)} faults"]))
    if not typos:
        sys.exit("no cases found")
    print(f"{typos} typos in {len(files)} cases, each named once")


main()
