#!/usr/bin/env python3
"""Reads the files of a run back as a viewer would, and checks what they say.

Usage: readback.py DIRECTORY

Opens particles, walls, surfaces and the fields of a fluid by vtkHDFReader (.vtkhdf) and by vtkXdmfReader
(.xdmf; the only one for stretched grids) and checks steps, times, counts, arrays, orientations and metadata, and that both readers see the same. Ends with an
exit code other than 0 and a message if something is wrong.
"""

import csv
import math
import re
import sys
import tomllib
from pathlib import Path

import h5py
import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkOutputWindow, vtkStringOutputWindow, vtkVersion
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as Pipeline
from vtkmodules.vtkIOHDF import vtkHDFReader
from vtkmodules.vtkIOXdmf2 import vtkXdmfReader
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader


# Name, unit and components of the arrays of each file; of those of particles a case may leave out some.
PARTICLES = {
    "id": ("-", 1), "shape": ("-", 1), "material": ("-", 1), "coordination": ("-", 1),
    "wall_contacts": ("-", 1), "radius": ("m", 1), "scale": ("-", 1), "orientation_wxyz": ("-", 4),
    "velocity": ("m/s", 3), "angular_velocity": ("rad/s", 3), "force": ("N", 3), "torque": ("N m", 3),
    "fluid_force": ("N", 3), "fluid_torque": ("N m", 3),
}
WALLS = {"wall": ("-", 1), "velocity": ("m/s", 3)}
ALWAYS = {"id", "shape", "radius", "scale", "orientation_wxyz"}
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
        case = tomllib.loads(origin["case"])
        require("domain" in case, f"{path.name}: the case has no domain")
        root = file["VTKHDF"]
        for name in root:
            if isinstance(root[name], h5py.Group) and "Offsets" in root[name]:
                require(root[name]["Offsets"].dtype == np.int64, f"{path.name}: {name}/Offsets are not int64")
        require(root["Points"].attrs["unit"] == "m", f"{path.name}: unit of Points")
        require(set(root[field_data]) == set(arrays), f"{path.name}: arrays {sorted(root[field_data])}")
        for name, (unit, components) in arrays.items():
            data = root[field_data][name]
            require(data.attrs["unit"] == unit, f"{path.name}: unit of {name}")
            require(data.shape[1:] == ((components,) if components > 1 else ()), f"{path.name}: {name}")
        wide = np.float32 if case["output"]["precision"] == "f32" else np.float64
        require(root["Points"].dtype == wide, f"{path.name}: Points are {root['Points'].dtype}")
        if case["output"]["compress"]:
            require(root["Points"].compression == "gzip", f"{path.name}: is not compressed")
    return case


def check_file(directory, name, arrays, corners, field_data, interval):
    """Opens a file by both readers; returns the case and, per step, time, points, cells and arrays."""
    path = directory / f"{name}.vtkhdf"
    if name == "particles":
        with h5py.File(path) as file:
            case = tomllib.loads(file["grains-mpi"].attrs["case"])
            kept = ALWAYS | set(case["output"]["fields"])
            if "resolved" not in case.get("fluid", {}):
                kept -= {"fluid_force", "fluid_torque"}
        arrays = {array: arrays[array] for array in arrays if array in kept}
    case = check_metadata(path, arrays, field_data)
    new, old = Steps(path, vtkHDFReader()), Steps(path.with_suffix(".xdmf"), vtkXdmfReader())
    times = new.times
    require(len(times) > 1 and np.all(np.diff(times) > 0), f"{name}: times {times}")
    require(np.array_equal(times, old.times), f"{name}: times {times} and {old.times} in the two readers")
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
        lower, upper = np.array(case["domain"]["lower"]), np.array(case["domain"]["upper"])
        slack = 1e-6 * np.max(upper - lower)
        require(np.all(points >= lower - slack) and np.all(points <= upper + slack),
                f"{label}: outside the domain")
    require(matched > 1, "particles: no snapshot has a row in the series")
    return steps


def reference_shapes(directory):
    """Corners of the triangles of each reference shape, [triangles * 3][3]."""
    shapes = {}
    for path in (directory / "shapes").glob("*.vtp"):
        reader = vtkXMLPolyDataReader()
        reader.SetFileName(str(path))
        reader.Update()
        data = reader.GetOutput()
        cells = vtk_to_numpy(data.GetPolys().GetConnectivityArray())
        shapes[int(path.stem)] = vtk_to_numpy(data.GetPoints().GetData())[cells]
    return shapes


def turned(corners, quaternion):
    """Points turned by a unit quaternion (w, x, y, z): what a viewer does to a glyph."""
    w, v = quaternion[0], np.array(quaternion[1:], float)
    across = 2 * np.cross(v, corners)
    return corners + w * across + np.cross(v, across)


def check_surfaces(directory, particles):
    """The surface of each particle is its reference shape, turned, scaled and moved as its snapshot says."""
    _, steps = check_file(directory, "surfaces", SURFACES, 3, "CellData", lambda o: o["surfaces"])
    shapes, compared = reference_shapes(directory), 0
    for time, points, cells, found in steps:
        near = [p for p in particles if math.isclose(p[0], time, rel_tol=1e-9, abs_tol=1e-12)]
        if not near:
            continue
        _, centers, _, bodies = near[0]
        label = f"surfaces at {time} s"
        owners = found.get("id", np.zeros(0))
        require(set(owners) == set(bodies.get("id", [])), f"{label}: not those of the particles")
        if len(owners) == 0:
            continue
        corners = points[cells].astype(float)
        for k, number in enumerate(bodies["id"]):
            shape = shapes[bodies["shape"][k]]
            wanted = centers[k] + bodies["scale"][k] * turned(shape, bodies["orientation_wxyz"][k])
            written = corners[np.repeat(owners == number, 3)]
            require(written.shape == wanted.shape, f"{label}: particle {number} has {len(written)} corners")
            error = np.max(np.abs(written - wanted)) / bodies["radius"][k]
            require(error < 1e-4, f"{label}: particle {number} is {error} radii off its snapshot")
        compared += 1
    require(compared > 0, "surfaces: at no time are there particles and surfaces")
    return steps


def check_fluid(directory):
    """Opens the fields of a fluid by both readers; returns whether it is alone, its readers, and
    per step its time and its cells."""
    path = directory / "fluid.vtkhdf"
    with h5py.File(path) as file:
        group = file["VTKHDF"]["CellData"]
        written = {name: group[name][...] for name in group}
        nodes = [file["grid"][axis][...] for axis in "xyz"]
        case = tomllib.loads(file["grains-mpi"].attrs["case"])
        interval = case["fluid"]["output"]["interval"]
        for name in group:
            require(group[name].attrs["unit"] in ("m/s", "Pa", "-"), f"fluid: unit of {name}")
    readers = [vtkXdmfReader()]
    # Stretched grids are read by the XDMF file alone.
    widths = [np.diff(line) for line in nodes]
    if all(np.allclose(w, w[0], rtol=1e-9) for w in widths):
        readers.append(vtkHDFReader())
    files = [path.with_suffix(".xdmf"), path]
    steps = []
    for reader, file in zip(readers, files):
        reader.SetFileName(str(file))
        reader.UpdateInformation()
        times = np.array(reader.GetOutputInformation(0).Get(Pipeline.TIME_STEPS()) or [])
        require(np.allclose(times, interval * np.arange(len(times)), atol=1e-9), f"{file.name}: times {times}")
        require(len(times) == len(next(iter(written.values()))), f"{file.name}: {len(times)} times")
        for k, time in enumerate(times):
            reader.UpdateTimeStep(time)
            data = reader.GetOutputDataObject(0)
            while data.IsA("vtkCompositeDataSet"):
                data = data.GetBlock(0)
            bounds = [edge for line in nodes for edge in (line[0], line[-1])]
            require(np.allclose(data.GetBounds(), bounds, rtol=1e-9), f"{file.name}: bounds {data.GetBounds()}")
            attributes = data.GetCellData()
            for name, values in written.items():
                array = attributes.GetArray(name)
                require(array, f"{file.name} at {time} s: no {name}")
                found = vtk_to_numpy(array).reshape(values[k].shape)
                require(np.array_equal(found, values[k]), f"{file.name} at {time} s: {name} differs from the file's")
                require(np.all(np.isfinite(found)), f"{file.name} at {time} s: {name} is not finite")
            if file.suffix == ".xdmf":
                steps.append((time, range(data.GetNumberOfCells()), None, None))
    return not case.get("insert"), len(readers), steps


def main():
    require(len(sys.argv) == 2, "give the directory of a run")
    directory = Path(sys.argv[1])
    window = vtkStringOutputWindow()
    vtkOutputWindow.SetInstance(window)
    checked, is_alone, readers = {}, False, 2
    if (directory / "fluid.vtkhdf").exists():
        is_alone, readers, checked["fluid"] = check_fluid(directory)
    if not is_alone:
        checked["particles"] = particles = check_particles(directory)
    if (directory / "walls.vtkhdf").exists():
        _, checked["walls"] = check_file(directory, "walls", WALLS, 3, "CellData", lambda o: o["particles"])
        require([s[0] for s in checked["walls"]] == [s[0] for s in particles], "walls at other times")
    if (directory / "surfaces.vtkhdf").exists():
        checked["surfaces"] = check_surfaces(directory, particles)
    require(not window.GetOutput(), f"the readers complain:\n{window.GetOutput()}")
    for name, steps in checked.items():
        counts = [len(points) for _, points, _, _ in steps]
        noun, by = ("cells", readers) if name == "fluid" else ("points", 2)
        seen = "the same by both readers" if by == 2 else "by the XDMF reader"
        print(f"{name}: {len(steps)} steps, {min(counts)} to {max(counts)} {noun}, {seen} of VTK {vtkVersion.GetVTKVersion()}")


main()
