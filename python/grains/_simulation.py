"""Simulations in progress: run them, look at them, steer them."""
from __future__ import annotations

import json
import os
from typing import Any, Callable, Mapping, Optional, Sequence, Union

import numpy as np

from . import _compiled
from ._case import AnyCase, Case, case_of


class Simulation:
    """A simulation of a case: in this process, or on all ranks of a communicator of mpi4py, which then do the same calls.

    Arrays of `particles` and `fluid` show the memory of the simulation without copying it. They can be read only, and stay what they
    were when the simulation goes on: it then leaves them the memory and takes another.

    `comm`: communicator of mpi4py; without it the ranks of the mpirun that started Python, or this process alone.
    `restart`: checkpoint to continue, or "latest".
    `writes_files`: whether it writes what the case's `[output]` says; without rows of the time series `[stop]` is not looked at.
    `petsc`: options for PETSc.
    """

    def __init__(self, case: AnyCase, comm: Any = None, restart: Union[str, os.PathLike, None] = None,
                 writes_files: bool = True, petsc: Sequence[str] = ()):
        self.case: Case = case_of(case)
        compiled = _compiled.load()
        restart = None if restart is None else os.fspath(restart)
        self._running = compiled.Simulation(self.case._case, _compiled.address(comm), restart, writes_files,
                                            list(petsc))
        self._events: list = []
        #: What the simulation has done, once it is closed.
        self.summary: Optional[dict] = None
        _compiled.keep(self)

    # Running

    def step(self, count: int = 1) -> bool:
        """Does a number of steps; whether there are more. Functions of `every` and `at` are not called."""
        return self._running.advance(count)

    def every(self, interval: float, function: Callable[["Simulation"], Any]) -> None:
        """Calls a function with this simulation every so often (s), from now on, at the step nearest to each time."""
        if not interval > 0:
            raise ValueError(f"interval = {interval}: must be positive (s)")
        self._events.append([self.time, interval, function])

    def at(self, time: float, function: Callable[["Simulation"], Any]) -> None:
        """Calls a function with this simulation once, at the step nearest to a time (s)."""
        self._events.append([time, None, function])

    def run(self, until: Optional[float] = None) -> bool:
        """Goes on to a time (s), or to the end; whether there is more to do.

        Ctrl-C writes a checkpoint, and raises KeyboardInterrupt.
        """
        until = np.inf if until is None else until
        half = 0.5 * self.time_step
        while True:
            for event in [e for e in self._events if e[0] <= self.time + half]:
                time, interval, function = event
                if interval is None:
                    self._events.remove(event)
                else:
                    event[0] = time + interval * max(1, np.floor((self.time + half - time) / interval + 1))
                function(self)
            if self.status != "running" or until <= self.time + half:
                return self.status == "running"
            self._running.run_to(min([until] + [event[0] for event in self._events]))

    def stop(self) -> None:
        """Asks for the end: a checkpoint is written at one of the next ten steps, which is the last."""
        self._running.stop()

    def close(self) -> dict:
        """Ends the simulation, with a checkpoint if it was still running; returns what it has done."""
        if self.summary is None:
            self.summary = self._running.close()
        return self.summary

    def _abandon(self) -> None:
        self._running.abandon()

    def __enter__(self) -> "Simulation":
        return self

    def __exit__(self, kind: Any, error: Any, trace: Any) -> None:
        if kind is None or issubclass(kind, KeyboardInterrupt):
            self.close()
        else:
            self._abandon()

    # Looking

    @property
    def status(self) -> str:
        """"running", "finished" or "stopped"."""
        return self._running.status

    @property
    def time(self) -> float:
        """Time of the present state (s)."""
        return self._running.time

    @property
    def steps(self) -> int:
        """Steps of the particles so far, those before a restart included."""
        return self._running.steps

    @property
    def time_step(self) -> float:
        """Time step of the particles (s)."""
        return self._running.time_step

    @property
    def rank(self) -> int:
        """Rank of this process."""
        return self._running.ranks[0]

    @property
    def size(self) -> int:
        """Number of ranks."""
        return self._running.ranks[1]

    @property
    def particles(self) -> "Particles":
        """The particles of this rank."""
        return Particles(self._running)

    @property
    def fluid(self) -> Optional["Fluid"]:
        """The cells of the fluid of this rank, if there is a fluid."""
        return None if self._running.fluid("pressure") is None else Fluid(self._running)

    @property
    def walls(self) -> "dict[str, Wall]":
        """The walls by their names."""
        return {name: Wall(**values) for name, values in self._running.walls().items()}

    def sum(self, value: float) -> float:
        """Sum of a number over the ranks; all ranks together."""
        return self._running.sum(value)

    def max(self, value: float) -> float:
        """Largest of a number over the ranks; all ranks together."""
        return self._running.max(value)

    # Steering; a restart goes on with what the case says.

    def set_wall_motion(self, wall: str, motion: Optional[Mapping[str, Any]]) -> None:
        """Moves a wall otherwise from now on, from where it is; all ranks together.

        `motion` is a motion as a case has it, such as `{"kind": "translation", "velocity": [0, 0, 0.1]}`; None stops the wall.
        """
        text = None if motion is None else _compiled.load().toml_of_json(json.dumps(motion))
        self._running.set_wall_motion(wall, text)

    def set_inlet_velocity(self, boundary: int, velocity: Sequence[float]) -> None:
        """Lets in a velocity (m/s) through `[[fluid.boundary]]` number `boundary`, an `inlet`; all ranks together."""
        self._running.set_inlet_velocity(boundary, [float(v) for v in velocity])

    def set_inlet_flow(self, boundary: int, flow: float) -> None:
        """Lets in a flow through `[[fluid.boundary]]` number `boundary`, a `flow_inlet`: kg/s or m³/s, as the case states it."""
        self._running.set_inlet_flow(boundary, float(flow))

    def set_insertion(self, name: str, batch: int, interval: float, next: Optional[float] = None) -> None:
        """Inserts `batch` particles every `interval` (s) from now on, or from the time `next` (s); never if that is infinite.

        The number of particles in all stays that of the case. All ranks together.
        """
        self._running.set_insertion(name, batch, interval, next)


class Particles:
    """The particles of a rank: arrays over them, in the order of the memory, which changes as they move; `id` tells them apart."""

    def __init__(self, running: Any):
        self._running = running

    def __len__(self) -> int:
        return self._running.particle_count

    @property
    def id(self) -> np.ndarray:
        """Identities, which they keep."""
        return self._running.particles("id")

    @property
    def position(self) -> np.ndarray:
        """Centres (m), [n, 3]."""
        return self._running.particles("position")

    @property
    def velocity(self) -> np.ndarray:
        """Velocities of the centres (m/s), [n, 3]."""
        return self._running.particles("velocity")

    @property
    def angular_velocity(self) -> np.ndarray:
        """Angular velocities (rad/s), [n, 3]."""
        return self._running.particles("angular_velocity")

    @property
    def radius(self) -> np.ndarray:
        """Radii of the bounding spheres (m); of spheres, their radii."""
        return self._running.particles("radius")

    @property
    def mass(self) -> np.ndarray:
        """Masses (kg)."""
        return self._running.particles("mass")

    @property
    def force(self) -> np.ndarray:
        """Forces at the last step (N), [n, 3]."""
        return self._running.particles("force")

    @property
    def torque(self) -> np.ndarray:
        """Torques about the centres at the last step (N m), [n, 3]."""
        return self._running.particles("torque")

    @property
    def temperature(self) -> np.ndarray:
        """Temperatures (K), if the case has any."""
        return self._running.particles("temperature")

    @property
    def orientation(self) -> np.ndarray:
        """Quaternions (w, x, y, z) from the shape as the case gives it to the world, [n, 4]; a copy."""
        return self._running.particles("orientation")

    @property
    def shape(self) -> np.ndarray:
        """Places of their shapes in the case; a copy."""
        return self._running.particles("shape")

    @property
    def material(self) -> np.ndarray:
        """Places of their materials in the case; a copy."""
        return self._running.particles("material")


class Fluid:
    """The cells of the fluid on a rank: arrays [nz, ny, nx]."""

    def __init__(self, running: Any):
        self._running = running

    @property
    def pressure(self) -> np.ndarray:
        """Pressure in the cells (Pa)."""
        return self._running.fluid("pressure")

    @property
    def face_velocity(self) -> "tuple[np.ndarray, np.ndarray, np.ndarray]":
        """Components of the velocity (m/s), each on the upper faces of the cells along its axis."""
        x, y, z = (self._running.fluid(f"velocity_{axis}") for axis in "xyz")
        return x, y, z

    @property
    def void_fraction(self) -> Optional[np.ndarray]:
        """Void fraction of the cells; None unless the flow is averaged over particles."""
        return self._running.fluid("void_fraction")

    def scalar(self, name: str) -> np.ndarray:
        """A scalar of the case, in the cells."""
        values = self._running.fluid(name)
        if values is None:
            raise KeyError(f"the fluid has no scalar {name!r}")
        return values

    @property
    def nodes(self) -> "tuple[np.ndarray, np.ndarray, np.ndarray]":
        """Coordinates of the faces between the cells along x, y and z (m)."""
        x, y, z = self._running.fluid_nodes()
        return x, y, z


class Wall:
    """A wall, with the loads of this rank's particles; `Simulation.sum` adds those of all ranks."""

    def __init__(self, displacement: Sequence[float], velocity: Sequence[float],
                 angular_velocity: Sequence[float], force: Sequence[float], torque: Sequence[float]):
        #: How far it has moved (m).
        self.displacement = np.array(displacement)
        #: Velocity (m/s).
        self.velocity = np.array(velocity)
        #: Angular velocity (rad/s).
        self.angular_velocity = np.array(angular_velocity)
        #: Force of the particles (N).
        self.force = np.array(force)
        #: Torque of the particles about the origin (N m).
        self.torque = np.array(torque)
