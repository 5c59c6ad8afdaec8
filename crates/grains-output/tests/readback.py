#!/usr/bin/env python3
"""Reads a temporal VTKHDF file with every reader at hand and compares what they find.

    readback.py FILE.vtkhdf [--expect EXPECTED.json] [--same OTHER.vtkhdf]

Readers: h5py (the reference), VTK's vtkHDFReader (9.3 or later) and VTK's XDMF 2 reader on the .xdmf file
beside it. Checked are the times, and per step points, cells and every array bit by bit, in the order of time
and against it. EXPECTED.json holds `times`, `points` and `cells` per step. Exits with 1 and a message at a
mismatch; a reader that is not installed is named on a line that begins with `skipped`.
"""
import argparse
import json
import os
import sys

import h5py
import numpy as np


def fail(message):
    sys.exit(f"readback: {message}")


def check(condition, message):
    if not condition:
        fail(message)


class Step:
    """What a reader found at a time: positions, corners of cells, arrays by name."""

    def __init__(self, points, cells, fields):
        self.points, self.cells, self.fields = points, cells, fields


def every_dataset(group, before=""):
    for name, item in group.items():
        if isinstance(item, h5py.Group):
            yield from every_dataset(item, f"{before}{name}/")
        else:
            yield before + name, item


def check_attributes(file, path):
    root = file["VTKHDF"]
    kind = root.attrs["Type"]
    check(kind in (b"PolyData", "PolyData"), f"{path}: the attribute Type is {kind!r}")
    check(tuple(root.attrs["Version"]) == (2, 0), f"{path}: the version is {root.attrs['Version']}")
    check("grains-mpi" in file and len(file["grains-mpi"].attrs["case"]) > 0, f"{path}: no metadata")
    for name, dataset in every_dataset(root):
        if name.startswith(("Points", "PointData", "CellData", "Steps/Values")):
            check("unit" in dataset.attrs, f"{path}: {name} has no unit")
        elif name != "Steps/Values":
            check(dataset.dtype == np.int64, f"{path}: {name} is {dataset.dtype}")


def read_h5py(path):
    """Times and steps by the counts alone, apart from the offsets that VTK uses."""
    with h5py.File(path, "r") as file:
        check_attributes(file, path)
        root = file["VTKHDF"]
        count = int(root["Steps"].attrs["NSteps"])
        times = root["Steps/Values"][...]
        check(len(times) == count, f"{path}: {len(times)} times for {count} steps")
        used, group = ("Polygons", "CellData") if "CellData" in root else ("Vertices", "PointData")
        corners = 3 if used == "Polygons" else 1
        points, cells = root["NumberOfPoints"][...], root[f"{used}/NumberOfCells"][...]
        check(len(points) == count and len(cells) == count, f"{path}: not one part per step")
        positions, connectivity = root["Points"][...], root[f"{used}/Connectivity"][...]
        arrays = {name: root[f"{group}/{name}"][...] for name in root[group]}
    steps, p, c = [], 0, 0
    for k in range(count):
        first, end = (c, c + cells[k]) if group == "CellData" else (p, p + points[k])
        steps.append(Step(
            positions[p:p + points[k]],
            connectivity[c * corners:(c + cells[k]) * corners],
            {name: values[first:end] for name, values in arrays.items()},
        ))
        p, c = p + points[k], c + cells[k]
    rows = c if group == "CellData" else p
    check(p == len(positions) and c * corners == len(connectivity), f"{path}: rows beyond the steps")
    for name, values in arrays.items():
        check(len(values) == rows, f"{path}: {name} has {len(values)} rows, {rows} belong to steps")
    return list(times), steps, group


def only_part(data):
    """The data set within composites of one part, or None."""
    while data is not None and not data.IsA("vtkDataSet"):
        is_flat = data.IsA("vtkPartitionedDataSet")
        parts = data.GetNumberOfPartitions() if is_flat else data.GetNumberOfBlocks()
        check(parts <= 1, f"{parts} parts in a step")
        if parts == 0:
            return None
        data = data.GetPartition(0) if is_flat else data.GetBlock(0)
    return data


def from_vtk(data, group):
    """A step of what a VTK reader returned."""
    from vtk.util.numpy_support import vtk_to_numpy

    data = only_part(data)
    if data is None or data.GetNumberOfPoints() == 0:
        check(data is None or data.GetNumberOfCells() == 0, "cells without points")
        return Step(np.zeros((0, 3)), np.zeros(0), {})
    if data.IsA("vtkPolyData"):
        cells = data.GetPolys() if data.GetNumberOfPolys() else data.GetVerts()
    else:
        cells = data.GetCells()
    check(data.GetNumberOfCells() == cells.GetNumberOfCells(), "cells of two kinds")
    corners = np.diff(vtk_to_numpy(cells.GetOffsetsArray()))
    check((corners == (3 if group == "CellData" else 1)).all(), f"cells with {set(corners)} corners")
    attributes = data.GetCellData() if group == "CellData" else data.GetPointData()
    names = [attributes.GetArrayName(i) for i in range(attributes.GetNumberOfArrays())]
    fields = {name: vtk_to_numpy(attributes.GetArray(name)) for name in names}
    return Step(vtk_to_numpy(data.GetPoints().GetData()), vtk_to_numpy(cells.GetConnectivityArray()), fields)


def compare(reader, path, times, steps, group):
    """Reads all steps forward and backward with a VTK reader."""
    import vtk

    errors = []

    @vtk.calldata_type(vtk.VTK_STRING)
    def note(_, __, text):
        errors.append(text)

    reader.AddObserver("ErrorEvent", note)
    reader.SetFileName(path)
    reader.UpdateInformation()
    key = vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS()
    information = reader.GetOutputInformation(0)
    found = [information.Get(key, i) for i in range(information.Length(key))] if information.Has(key) else []
    name = f"{path} in {reader.GetClassName()} {vtk.VTK_VERSION}"
    check(np.array_equal(found, times), f"{name}: the times are {found}, not {times}")
    order = list(range(len(times)))
    for k in order + order[::-1]:
        reader.UpdateTimeStep(times[k])
        where = f"{name}, step {k}"
        check(not errors, f"{where}: {errors}")
        step, wanted = from_vtk(reader.GetOutputDataObject(0), group), steps[k]
        for what in ["points", "cells"]:
            one, two = getattr(step, what), getattr(wanted, what)
            check(len(one) == len(two), f"{where}: {len(one)} values of {what}, not {len(two)}")
            check(np.array_equal(one, two), f"{where}: other {what}")
        for field, values in wanted.fields.items():
            # An array without rows may be absent.
            if len(values) > 0:
                check(field in step.fields, f"{where}: no array {field}, there are {sorted(step.fields)}")
                shape = step.fields[field].shape
                check(shape == values.shape, f"{where}: {field} has the shape {shape}, not {values.shape}")
                check(np.array_equal(step.fields[field], values), f"{where}: {field} differs")
    print(f"{name}: ok, points {[len(s.points) for s in steps]}")


def compare_files(path, other):
    """Every dataset of two files is the same, bit by bit."""
    with h5py.File(path, "r") as one, h5py.File(other, "r") as two:
        ones, twos = dict(every_dataset(one["VTKHDF"])), dict(every_dataset(two["VTKHDF"]))
        check(ones.keys() == twos.keys(), f"{path} and {other} hold different datasets")
        for name, dataset in ones.items():
            same = dataset.dtype == twos[name].dtype and np.array_equal(dataset[...], twos[name][...])
            check(same, f"{name} differs in {path} and {other}")
    print(f"{path} and {other}: the same")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file")
    parser.add_argument("--expect")
    parser.add_argument("--same")
    options = parser.parse_args()
    if options.same:
        compare_files(options.file, options.same)
    times, steps, group = read_h5py(options.file)
    if options.expect:
        with open(options.expect) as file:
            expected = json.load(file)
        corners = 3 if group == "CellData" else 1
        found = {
            "times": times,
            "points": [len(s.points) for s in steps],
            "cells": [len(s.cells) // corners for s in steps],
        }
        for key, value in expected.items():
            check(np.array_equal(found[key], value), f"{options.file}: {key} are {found[key]}, not {value}")
    try:
        import vtk
    except ImportError:
        print("skipped: Python's vtk is not installed, only h5py read the file")
        return
    sidecar = os.path.splitext(options.file)[0] + ".xdmf"
    for name, path in [("vtkHDFReader", options.file), ("vtkXdmfReader", sidecar)]:
        if hasattr(vtk, name):
            compare(getattr(vtk, name)(), path, times, steps, group)
        else:
            print(f"skipped: this VTK {vtk.VTK_VERSION} has no {name}")


main()
