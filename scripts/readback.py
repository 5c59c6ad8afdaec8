#!/usr/bin/env python3
"""Reads the files of a run back as a viewer would, and checks what they say.

Usage: readback.py DIRECTORY

Opens particles, walls and surfaces by vtkHDFReader (.vtkhdf) and by vtkXdmfReader (.xdmf) and checks
steps, times, counts, arrays, orientations and metadata, and that both readers see the same. Ends with an
exit code other than 0 and a message if something is wrong.
"""

import csv
import math
import re
import sys
from pathlib import Path

import h5py
import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkOutputWindow, vtkStringOutputWindow, vtkVersion
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as Pipeline
from vtkmodules.vtkIOHDF import vtkHDFReader
from vtkmodules.vtkIOXdmf2 import vtkXdmfReader

try:
    import tomllib
except ImportError:  # before Python 3.11
    tomllib = None

# Name, unit and components of the arrays of each file.
PARTICLES = {
    "id": ("-", 1), "shape": ("-", 1), "material": ("-", 1), "coordination": ("-", 1),
    "wall_contacts": ("-", 1), "radius": ("m", 1), "scale": ("-", 1), "orientation_wxyz": ("-", 4),
    "velocity": ("m/s", 3), "angular_velocity": ("rad/s", 3), "force": ("N", 3), "torque": ("N m", 3),
}
WALLS = {"wall": ("-", 1), "velocity": ("m/s", 3)}
SURFACES = {"id": ("-", 1), "shape": ("-", 1), "speed": ("m/s", 1)}


def require(condition, message):
    if not condition:
        sys.exit(f"readback: {message}")


class Steps:
    """The steps of a file as one reader shows them."""

    def __init__(self, path, reader):
        self.name, self.reader = path.name, reader
        require(path.exists(), f"{path} is missing")
        reader.SetFileName(str(path))
        reader.UpdateInformation()
        self.times = np.array(reader.GetOutputInformation(0).Get(Pipeline.TIME_STEPS()) or [])

    def read(self, step, field_data):
        """Points, cells and arrays of a step."""
        self.reader.UpdateTimeStep(self.times[step])
        data = self.reader.GetOutputDataObject(0)
        while not data.IsA("vtkPointSet"):
            require(data.IsA("vtkCompositeDataSet"), f"{self.name}: step {step} is a {data.GetClassName()}")
            data = data.GetPartition(0) if data.IsA("vtkPartitionedDataSet") else data.GetBlock(0)
            if data is None:
                return np.zeros((0, 3)), np.zeros(0, int), {}
        points = data.GetPoints()
        points = vtk_to_numpy(points.GetData()) if points and points.GetNumberOfPoints() else np.zeros((0, 3))
        corners = [data.GetCell(k).GetPointId(i) for k in range(data.GetNumberOfCells())
                   for i in range(data.GetCell(k).GetNumberOfPoints())]
        attributes = data.GetPointData() if field_data == "PointData" else data.GetCellData()
        arrays = [attributes.GetArray(k) for k in range(attributes.GetNumberOfArrays())]
        return points, np.array(corners, int), {a.GetName(): vtk_to_numpy(a) for a in arrays}


def check_metadata(path, arrays, field_data):
    """Origin, units and precision of a file; returns the case."""
    with h5py.File(path) as file:
        origin = file["grains-mpi"].attrs
        require(re.match(r"grains-mpi \d+\.\d+\.\d+ \(git [0-9a-f]{7,40}", origin["program"]),
                f"{path.name}: the program is `{origin['program']}`, without a git hash")
        require(int(origin["ranks"]) >= 1 and int(origin["seed"]) >= 0, f"{path.name}: ranks and seed")
        case = tomllib.loads(origin["case"]) if tomllib else None
        require(case is None or "domain" in case, f"{path.name}: the case has no domain")
        root = file["VTKHDF"]
        require(root["Points"].attrs["unit"] == "m", f"{path.name}: unit of Points")
        require(set(root[field_data]) == set(arrays), f"{path.name}: arrays {sorted(root[field_data])}")
        for name, (unit, components) in arrays.items():
            data = root[field_data][name]
            require(data.attrs["unit"] == unit, f"{path.name}: unit of {name}")
            require(data.shape[1:] == ((components,) if components > 1 else ()), f"{path.name}: {name}")
        wide = np.float32 if case and case["output"]["precision"] == "f32" else np.float64
        require(root["Points"].dtype == wide, f"{path.name}: Points are {root['Points'].dtype}")
        if case and case["output"]["compress"]:
            require(root["Points"].compression == "gzip", f"{path.name}: is not compressed")
    return case


def check_file(directory, name, arrays, corners, field_data, interval):
    """Opens a file by both readers; returns the case and, per step, time, points, cells and arrays."""
    path = directory / f"{name}.vtkhdf"
    case = check_metadata(path, arrays, field_data)
    new, old = Steps(path, vtkHDFReader()), Steps(path.with_suffix(".xdmf"), vtkXdmfReader())
    times = new.times
    require(len(times) > 1 and np.all(np.diff(times) > 0), f"{name}: times {times}")
    require(np.array_equal(times, old.times), f"{name}: times {times} and {old.times} in the two readers")
    if case:
        wanted = interval(case["output"]) * np.arange(len(times))
        require(np.allclose(times, wanted, rtol=0, atol=0.51 * wanted[1]), f"{name}: times {times}")
    steps = []
    for k, time in enumerate(times):
        points, cells, found = new.read(k, field_data)
        label = f"{name} at {time} s"
        count = len(cells) // corners
        rows = len(points) if field_data == "PointData" else count
        require(np.all(np.isfinite(points)), f"{label}: positions that are not numbers")
        require(rows == 0 or set(found) == set(arrays), f"{label}: arrays {sorted(found)}")
        for array in found:
            require(found[array].shape[0] == rows, f"{label}: {array} has {found[array].shape[0]} rows")
            require(np.all(np.isfinite(found[array])), f"{label}: {array} is not finite")
        old_points, old_cells, old_found = old.read(k, field_data)
        require(np.array_equal(points, old_points), f"{label}: points differ in the XDMF reader")
        require(np.array_equal(cells, old_cells), f"{label}: cells differ in the XDMF reader")
        for array in found if rows else []:
            require(array in old_found, f"{label}: the XDMF reader finds no {array}")
            require(np.array_equal(found[array], old_found[array].reshape(found[array].shape)),
                    f"{label}: {array} differs in the XDMF reader")
        steps.append((time, points, cells, found))
    return case, steps


def check_particles(directory):
    case, steps = check_file(directory, "particles", PARTICLES, 1, "PointData", lambda o: o["particles"])
    inside = {}
    with open(directory / "series.csv", encoding="utf-8") as file:
        for row in csv.DictReader(line for line in file if not line.startswith("#")):
            inside[float(row["time"])] = float(row["particles"])
    matched = 0
    for time, points, cells, found in steps:
        label = f"particles at {time} s"
        require(np.array_equal(cells, np.arange(len(points))), f"{label}: not a vertex on each point")
        if time in inside:
            matched += 1
            require(inside[time] == len(points), f"{label}: {len(points)}, in the series {inside[time]}")
        if len(points) == 0:
            continue
        require(len(set(found["id"])) == len(points), f"{label}: ids are not unique")
        lengths = np.linalg.norm(found["orientation_wxyz"].astype(float), axis=1)
        require(np.allclose(lengths, 1, atol=1e-6), f"{label}: quaternions of length {lengths.min()}")
        require(np.all(found["radius"] > 0), f"{label}: radii")
        if case:
            lower, upper = np.array(case["domain"]["lower"]), np.array(case["domain"]["upper"])
            slack = 1e-6 * np.max(upper - lower)
            require(np.all(points >= lower - slack) and np.all(points <= upper + slack),
                    f"{label}: outside the domain")
    require(matched > 1, "particles: no snapshot has a row in the series")
    return steps


def check_surfaces(directory, particles):
    """Every triangle must belong to a particle and lie within its bounding sphere."""
    _, steps = check_file(directory, "surfaces", SURFACES, 3, "CellData", lambda o: o["surfaces"])
    compared = 0
    for time, points, cells, found in steps:
        near = [p for p in particles if math.isclose(p[0], time, rel_tol=1e-9, abs_tol=1e-12)]
        if not near:
            continue
        _, centers, _, of_particles = near[0]
        label = f"surfaces at {time} s"
        owners = np.repeat(found.get("id", np.zeros(0)), 3)
        require(set(owners) == set(of_particles.get("id", [])), f"{label}: not those of the particles")
        if len(owners) == 0:
            continue
        row = {number: k for k, number in enumerate(of_particles["id"])}
        rows = np.array([row[number] for number in owners])
        distance = np.linalg.norm(points[cells].astype(float) - centers[rows], axis=1)
        excess = np.max(distance / of_particles["radius"][rows])
        # Round shapes are tessellated at equal volume: corners lie a little outside.
        require(excess < 1.02, f"{label}: a vertex {excess} bounding radii from its particle")
        compared += 1
    require(compared > 0, "surfaces: at no time are there particles and surfaces")
    return steps


def main():
    require(len(sys.argv) == 2, "give the directory of a run")
    directory = Path(sys.argv[1])
    window = vtkStringOutputWindow()
    vtkOutputWindow.SetInstance(window)
    particles = check_particles(directory)
    checked = {"particles": particles}
    if (directory / "walls.vtkhdf").exists():
        _, checked["walls"] = check_file(directory, "walls", WALLS, 3, "CellData", lambda o: o["particles"])
        require([s[0] for s in checked["walls"]] == [s[0] for s in particles], "walls at other times")
    if (directory / "surfaces.vtkhdf").exists():
        checked["surfaces"] = check_surfaces(directory, particles)
    require(not window.GetOutput(), f"the readers complain:\n{window.GetOutput()}")
    for name, steps in checked.items():
        counts = [len(points) for _, points, _, _ in steps]
        print(f"{name}: {len(steps)} steps, {min(counts)} to {max(counts)} points, "
              f"the same by both readers of VTK {vtkVersion.GetVTKVersion()}")


main()
