"""The results of a run: snapshots, time series, fluid and analyses. Reads the files alone, while a run writes them or later."""
from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any, Iterator, Mapping, Optional, Union

import h5py
import numpy as np
import pandas as pd

#: Which states: "first", "last", a place from 0 (or from the end, below 0), or a time (s), of which the nearest is taken.
Which = Union[str, int, float]


def open_run(directory: Union[str, os.PathLike]) -> "Run":
    """The results in a folder."""
    return Run(directory)


class Run:
    """The results of a run in a folder."""

    def __init__(self, directory: Union[str, os.PathLike]):
        self.directory = Path(directory)
        if not self.directory.is_dir():
            raise FileNotFoundError(f"{self.directory}: no such folder")
        known = ("series.csv", "particles.vtkhdf", "fluid.vtkhdf", "case.resolved.toml")
        if not any((self.directory / name).exists() for name in known):
            raise FileNotFoundError(f"{self.directory}: holds no results; give the `output.directory` of a run")

    @property
    def series(self) -> pd.DataFrame:
        """The time series (SI units, those of the columns in the file's comments)."""
        return self.table("series.csv")

    def table(self, name: str) -> pd.DataFrame:
        """A table of the run or of an analysis, such as "profile-axis.csv"."""
        return pd.read_csv(self.directory / name, comment="#")

    @property
    def status(self) -> dict:
        """How far a run of the program is, or how it ended."""
        path = self.directory / "status.json"
        if not path.exists():
            raise FileNotFoundError(f"{path}: only runs of the program grains-mpi write it")
        return json.loads(path.read_text(encoding="utf-8"))

    @property
    def case(self) -> Any:
        """The case of the run with every default spelt out."""
        from ._case import Case
        return Case.load(self.directory / "case.resolved.toml")

    @property
    def times(self) -> np.ndarray:
        """Times of the snapshots of the particles (s)."""
        return _File(self.directory / "particles.vtkhdf").times

    def particles(self, which: Which = "last") -> "Snapshot":
        """The particles at one of `times`."""
        return Snapshot(self.directory / "particles.vtkhdf", which)

    def snapshots(self) -> "Iterator[Snapshot]":
        """The particles at all of `times`, one after the other."""
        for k in range(len(self.times)):
            yield self.particles(k)

    def walls(self, which: Which = "last") -> Any:
        """The walls at a time, as a mesh of pyvista."""
        return _surface(self.directory / "walls.vtkhdf", which)

    @property
    def fluid(self) -> Any:
        """The fields of the fluid as an xarray.Dataset over time, z, y, x (middles of the cells), which reads what is asked for."""
        return Cells(self.directory / "fluid.vtkhdf").dataset()

    @property
    def mean_fluid(self) -> Any:
        """The means of these fields over time, if the case asked for them."""
        return Cells(self.directory / "fluid-mean.vtkhdf").dataset()

    def fluid_mesh(self, which: Which = "last") -> Any:
        """The fields of the fluid at a time, as a grid of pyvista."""
        return Cells(self.directory / "fluid.vtkhdf").mesh(which)

    def analyse(self, what: str, comm: Any = None, **options: Any) -> "dict[str, pd.DataFrame]":
        """Does an analysis, as `grains-mpi analyse WHAT`; returns its tables by name.

        Options are those of the command line: `run.analyse("profiles", time="all", bins=20)`. A value of True is a flag; a list
        gives an option several values. Tables and pictures are also written to the folder `analysis` of the run.
        """
        from . import _compiled
        words = [what, str(self.directory)]
        for name, value in options.items():
            option = "--" + name.replace("_", "-")
            if value is True:
                words.append(option)
            elif value is not None and value is not False:
                values = value if isinstance(value, (list, tuple, np.ndarray)) else [value]
                words += [option + "=" + str(values[0])] + [str(v) for v in values[1:]]
        _, folder, files = _compiled.load().analyse(words, _compiled.address(comm))
        tables = [Path(folder) / name for name in files if name.endswith(".csv")]
        return {path.stem: pd.read_csv(path, comment="#") for path in tables}

    def __repr__(self) -> str:
        return f"<grains.Run {str(self.directory)!r}>"


class _File:
    """A file of steps."""

    def __init__(self, path: Path):
        self.path = path
        if not path.exists():
            raise FileNotFoundError(f"{path}: the run has not written it; see [output] of its case")
        with self.open() as file:
            self.times = file["VTKHDF/Steps/Values"][:file["VTKHDF/Steps"].attrs["NSteps"]]

    def open(self) -> h5py.File:
        # A run may be writing to it: it is complete after each step.
        return h5py.File(self.path, "r", locking=False)

    def place(self, which: Which) -> int:
        count = len(self.times)
        if count == 0:
            raise IndexError(f"{self.path}: holds no state yet")
        if which in ("first", "last"):
            return 0 if which == "first" else count - 1
        if isinstance(which, (bool, str)):
            raise ValueError(f"{which!r}: give \"first\", \"last\", a place or a time (s)")
        if isinstance(which, (int, np.integer)):
            if not -count <= which < count:
                raise IndexError(f"{self.path}: state {which} of {count}")
            return int(which) % count
        return int(np.argmin(np.abs(self.times - which)))


class Snapshot(Mapping):
    """The particles at a time: a mapping of the names of fields to arrays, `position` among them."""

    def __init__(self, path: Path, which: Which = "last"):
        self._file = _File(Path(path))
        step = self._file.place(which)
        #: Time (s).
        self.time: float = float(self._file.times[step])
        with self._file.open() as file:
            root = file["VTKHDF"]
            steps = root["Steps"]
            first, part = int(steps["PointOffsets"][step]), int(steps["PartOffsets"][step])
            count = int(root["NumberOfPoints"][part:part + int(steps["NumberOfParts"][step])].sum())
            self._arrays = {"position": root["Points"][first:first + count]}
            #: Units of the fields.
            self.units = {"position": "m"}
            for name, data in root["PointData"].items():
                start = int(steps["PointDataOffsets"][name][step])
                self._arrays[name] = data[start:start + count]
                self.units[name] = str(data.attrs["unit"])

    def __getitem__(self, name: str) -> np.ndarray:
        return self._arrays[name]

    def __iter__(self) -> "Iterator[str]":
        return iter(self._arrays)

    def __len__(self) -> int:
        return len(self._arrays)

    @property
    def count(self) -> int:
        """Number of particles."""
        return len(self._arrays["position"])

    def frame(self) -> pd.DataFrame:
        """All fields as a table, a row per particle in the order of `id`; vectors have columns such as velocity_x."""
        columns = {}
        for name, values in self.items():
            if values.ndim == 1:
                columns[name] = values
                continue
            parts = "wxyz" if values.shape[1] == 4 else "xyz"
            stem = "" if name == "position" else name.removesuffix("_wxyz") + "_"
            columns.update({stem + part: values[:, k] for k, part in enumerate(parts)})
        return pd.DataFrame(columns).set_index("id").sort_index()

    def points(self) -> Any:
        """The particles as points of pyvista, with all fields."""
        import pyvista
        cloud = pyvista.PolyData(np.asarray(self["position"], float))
        for name, values in self.items():
            if name != "position":
                cloud[name] = values
        cloud["speed"] = np.linalg.norm(self["velocity"], axis=1) if "velocity" in self else np.zeros(self.count)
        return cloud

    def mesh(self) -> Any:
        """The particles in their true shapes, sizes and orientations, as one mesh of pyvista with all fields."""
        import pyvista
        cloud, parts = self.points(), []
        for shape in np.unique(self["shape"]):
            surface = pyvista.read(self._file.path.parent / "shapes" / f"{shape}.vtp")
            mine = np.flatnonzero(np.asarray(self["shape"]) == shape)
            corners, count = np.asarray(surface.points, float), len(mine)
            turned = np.einsum("nij,pj->npi", _rotations(self["orientation_wxyz"][mine]), corners)
            turned = turned * np.asarray(self["scale"][mine], float)[:, None, None]
            points = (turned + np.asarray(self["position"][mine], float)[:, None, :]).reshape(-1, 3)
            faces = np.asarray(surface.regular_faces)
            faces = (faces[None] + len(corners) * np.arange(count)[:, None, None]).reshape(-1, faces.shape[1])
            part = pyvista.PolyData.from_regular_faces(points, faces)
            for name in cloud.point_data:
                part[name] = np.repeat(np.asarray(cloud[name])[mine], len(corners), axis=0)
            parts.append(part)
        return pyvista.merge(parts) if parts else pyvista.PolyData()

    def __repr__(self) -> str:
        return f"<grains.Snapshot of {self.count} particles at {self.time:g} s>"


class Cells:
    """The fields of the fluid in its cells, over time."""

    def __init__(self, path: Path):
        self._file = _File(Path(path))
        #: Times (s).
        self.times = self._file.times
        with self._file.open() as file:
            #: Coordinates of the faces between cells along x, y and z (m).
            self.nodes = tuple(file["grid"][axis][:] for axis in "xyz")
            #: Units of the fields.
            self.units = {name: str(data.attrs["unit"]) for name, data in file["VTKHDF/CellData"].items()}

    def field(self, name: str, which: Any = slice(None)) -> np.ndarray:
        """A field, [time, z, y, x] or [time, z, y, x, 3], or at one time (see `Which`) without the first axis."""
        with self._file.open() as file:
            data = file["VTKHDF/CellData"][name]
            if isinstance(which, slice):
                return data[:len(self.times)][which]
            return data[self._file.place(which)]

    def dataset(self) -> Any:
        """All fields as an xarray.Dataset."""
        import xarray
        from ._lazy import lazy
        middles = [0.5 * (nodes[1:] + nodes[:-1]) for nodes in self.nodes]
        coordinates = {"time": ("time", self.times, {"units": "s"}), "component": list("xyz")}
        coordinates.update({a: (a, m, {"units": "m"}) for a, m in zip("xyz", middles)})
        fields = {}
        with self._file.open() as file:
            shapes = {name: (data.shape, data.dtype) for name, data in file["VTKHDF/CellData"].items()}
        for name, (shape, kind) in shapes.items():
            axes = ("time", "z", "y", "x") + (("component",) if len(shape) == 5 else ())
            values = lazy(self._file, f"VTKHDF/CellData/{name}", (len(self.times),) + shape[1:], kind)
            fields[name] = (axes, values, {"units": self.units[name]})
        return xarray.Dataset(fields, coordinates)

    def mesh(self, which: Which = "last") -> Any:
        """All fields at a time, as a rectilinear grid of pyvista."""
        import pyvista
        grid = pyvista.RectilinearGrid(*self.nodes)
        for name in self.units:
            values = self.field(name, which)
            grid.cell_data[name] = values.reshape(grid.n_cells, -1).squeeze()
        return grid


def _surface(path: Path, which: Which) -> Any:
    """The triangles of a file at a time, as a mesh of pyvista."""
    import pyvista
    file = _File(path)
    step = file.place(which)
    with file.open() as data:
        root, steps = data["VTKHDF"], data["VTKHDF/Steps"]
        part = int(steps["PartOffsets"][step])
        polygons = 2 if len(steps["CellOffsets"].shape) > 1 else None
        count = int(root["NumberOfPoints"][part])
        first = int(steps["PointOffsets"][step])
        points = root["Points"][first:first + count]
        topology = root["Polygons"]
        start = int(steps["ConnectivityIdOffsets"][step][polygons])
        ids = topology["Connectivity"][start:start + int(topology["NumberOfConnectivityIds"][part])]
        mesh = pyvista.PolyData.from_regular_faces(np.asarray(points, float), ids.reshape(-1, 3))
        for name, values in root["CellData"].items():
            begin = int(steps["CellDataOffsets"][name][step])
            mesh.cell_data[name] = values[begin:begin + len(ids) // 3]
    return mesh


def _rotations(quaternions: np.ndarray) -> np.ndarray:
    """Matrices [n, 3, 3] of quaternions (w, x, y, z)."""
    w, x, y, z = np.asarray(quaternions, float).T
    rows = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
    return np.moveaxis(np.array(rows), 2, 0)
