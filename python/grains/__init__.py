"""Granular and particulate flow: build, run, steer and read simulations of grains-mpi.

    import grains

    case = grains.Case.load("silo.toml").changed({"time.end": 2.0})
    with grains.Simulation(case) as silo:
        silo.every(0.1, lambda s: print(s.time, s.particles.velocity[:, 2].min()))
        silo.run()

    run = grains.open("results/silo")
    run.series.plot(x="time", y="kinetic_translation")
    run.particles("last").mesh().plot()

Reading results needs no compiled part; everything else does. All quantities are in SI units.
"""
from ._case import Case, schema
from ._results import Cells, Run, Snapshot, open_run as open
from ._simulation import Fluid, Particles, Simulation, Wall

__all__ = ["Case", "CaseError", "Cells", "FilesError", "Fluid", "Particles", "Run", "Simulation", "Snapshot",
           "UnphysicalError", "Wall", "open", "schema"]


def __getattr__(name):
    if name in ("CaseError", "UnphysicalError", "FilesError", "__version__"):
        from . import _compiled
        return getattr(_compiled.load(), name)
    raise AttributeError(f"module 'grains' has no attribute {name!r}")
