#!/usr/bin/env python3
"""Write docs/develop/dependencies.md: what the program is linked with, with licences.

Usage: scripts/dependencies.py [--check]
With --check it compares the page with Cargo.lock, and fails where they differ.
"""

import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/develop/dependencies.md"
LICENCES = {"0BSD", "Apache-2.0", "Apache-2.0 WITH LLVM-exception", "BSD-2-Clause", "BSD-3-Clause", "ISC", "MIT", "Unicode-3.0", "Unlicense", "Zlib"}
REGISTRY = "registry+https://github.com/rust-lang/crates.io-index"
# Crates that say their licence in a file alone.
IN_FILES = {"slsqp": "MIT"}

HEAD = """# Dependencies and their licences

`scripts/dependencies.py` writes this page, and refuses crates that are not of crates.io or have other licences than these. The tests
compare it with `Cargo.lock`, which pins every version.

None of them, those of `fuzz/Cargo.lock` included, had a known vulnerability in the [RustSec database](https://rustsec.org) of 2026-08-21.
One is no longer maintained: `custom_derive` (RUSTSEC-2025-0058), macros of the bindings of MPI that no input reaches.
`bytemuck_derive` and `memmap2` came later and have not been compared with it; RUSTSEC-2026-0186 is mended in `memmap2` 0.9.11.

| library of the system | licence |
|---|---|
| Open MPI | BSD-3-Clause |
| HDF5 | BSD-3-Clause-like |
| PETSc | BSD-2-Clause |

| crate | version | used by | licence |
|---|---|---|---|
"""


def command(*words):
    return subprocess.run(words, cwd=ROOT, check=True, capture_output=True, text=True).stdout


def reached(metadata, kinds):
    """Ids of the packages that those of the workspace reach by dependencies of these kinds."""
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    found, todo = set(), list(metadata["workspace_members"])
    while todo:
        if (package := todo.pop()) in found:
            continue
        found.add(package)
        for dependency in nodes[package]["deps"]:
            if any(kind["kind"] in kinds for kind in dependency["dep_kinds"]):
                todo.append(dependency["pkg"])
    return found


def is_allowed(licence):
    """Whether one of the alternatives of an expression has only licences that are allowed."""
    words = licence.replace("(", "").replace(")", "").replace("/", " OR ")
    return any(all(part in LICENCES for part in either.split(" AND ")) for either in words.split(" OR "))


def page():
    metadata = json.loads(command("cargo", "metadata", "--locked", "--format-version", "1", "--filter-platform", "x86_64-unknown-linux-gnu"))
    linked = reached(metadata, [None])
    builds = reached(metadata, [None, "build"])
    rows = []
    for package in sorted(metadata["packages"], key=lambda package: (package["name"], package["version"])):
        if package["source"] is None:
            continue
        used = "program" if package["id"] in linked else "build" if package["id"] in builds else "tests"
        licence = package["license"] or IN_FILES[package["name"]]
        if package["source"] != REGISTRY or not is_allowed(licence):
            sys.exit(f"error: {package['name']} is of {package['source']}, under {licence}; see scripts/dependencies.py")
        rows.append(f"| {package['name']} | {package['version']} | {used} | {licence} |\n")
    return HEAD + "".join(rows)


def main():
    if sys.argv[1:] == ["--check"]:
        if PAGE.read_text() != page():
            sys.exit(f"error: {PAGE.relative_to(ROOT)} is not what Cargo.lock says; run scripts/dependencies.py")
    else:
        PAGE.write_text(page())


if __name__ == "__main__":
    main()
