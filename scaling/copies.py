#!/usr/bin/env python3
"""Copies of a settled bed, side by side or on top of each other, as a particle file of a case.

Takes positions and orientations of the last snapshot of a run; velocities are left out, so that the copies begin
at rest. Needs numpy and h5py (scripts/python-environment).

    scaling/copies.py settled/particles.vtkhdf bed.h5 --counts 4 2 1 --spacing 0.25 0.25 0
"""

import argparse
from dataclasses import dataclass


@dataclass
class Copies:
    """A regular grid of copies."""

    counts: tuple = (1, 1, 1)  # along x, y, z
    spacing: tuple = (0.0, 0.0, 0.0)  # m; 0 along z: as high as the bed, so that copies just touch


def last_state(path):
    """Positions (m), orientations (w, x, y, z; None of spheres) and bounding radii (m) of the last snapshot."""
    import h5py

    with h5py.File(path) as file:
        group = file["VTKHDF"]
        first, number = int(group["Steps/PointOffsets"][-1]), int(group["NumberOfPoints"][-1])
        rows = slice(first, first + number)
        fields = group["PointData"]
        orientations = fields["orientation_wxyz"][rows] if "orientation_wxyz" in fields else None
        if orientations is not None and (orientations[:, 0] == 1).all():
            orientations = None
        return group["Points"][rows], orientations, fields["radius"][rows]


def write_copies(source, target, copies):
    """Writes the copies to an HDF5 table, copy by copy, x fastest."""
    import h5py

    positions, orientations, radii = last_state(source)
    number, spacing = len(positions), list(copies.spacing)
    if copies.counts[2] > 1 and spacing[2] == 0:
        spacing[2] = float((positions[:, 2] + radii).max() - (positions[:, 2] - radii).min())
    nx, ny, nz = copies.counts
    with h5py.File(target, "w") as file:
        names = ["x", "y", "z"] + (["qw", "qx", "qy", "qz"] if orientations is not None else [])
        columns = {name: file.create_dataset(name, (number * nx * ny * nz,), "f8") for name in names}
        for copy in range(nx * ny * nz):
            place = (copy % nx, copy // nx % ny, copy // (nx * ny))
            rows = slice(copy * number, (copy + 1) * number)
            for axis, name in enumerate("xyz"):
                columns[name][rows] = positions[:, axis] + place[axis] * spacing[axis]
            for k, name in enumerate(names[3:]):
                columns[name][rows] = orientations[:, k]


def copy_command(python, source, target, copies):
    """The command line that does the same."""
    counts, spacing = (list(map(str, values)) for values in (copies.counts, copies.spacing))
    return [str(python), __file__, str(source), str(target), "--counts", *counts, "--spacing", *spacing]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source", help="particles.vtkhdf of a run")
    parser.add_argument("target", help="HDF5 file to write")
    parser.add_argument("--counts", type=int, nargs=3, default=(1, 1, 1), help="copies along x, y, z")
    parser.add_argument("--spacing", type=float, nargs=3, default=(0, 0, 0), help="distance of copies (m)")
    options = parser.parse_args()
    write_copies(options.source, options.target, Copies(tuple(options.counts), tuple(options.spacing)))


if __name__ == "__main__":
    main()
