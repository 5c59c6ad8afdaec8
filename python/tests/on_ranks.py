"""A run on the ranks of an mpirun; prints a digest of its last state.  on_ranks.py own|mpi4py FOLDER"""
import hashlib
import sys

import numpy as np

comm = None
if sys.argv[1] == "mpi4py":
    from mpi4py import MPI
    comm = MPI.COMM_WORLD

import grains
from conftest import BALLS

BALLS["output"]["directory"] = sys.argv[2]
BALLS["wall"].append({"name": "plate", "material": "glass", "kind": "plane", "point": [0, 0, 0.006],
                      "normal": [0, 0, 1]})
WINDOW = {"kind": "box", "lower": [0.013, 0.013, 0.02], "upper": [0.067, 0.05, 0.05]}
BALLS["insert"][0].update(batch=8, interval=0.5, place={"kind": "window", "window": WINDOW, "attempts": 5000})


def steer(simulation):
    simulation.set_wall_motion("plate", {"kind": "translation", "velocity": [0.2, 0, 0.3]})
    simulation.set_insertion("balls", batch=2, interval=0.002)


with grains.Simulation(BALLS, comm=comm) as simulation:
    seen = []
    simulation.at(0.003, steer)
    simulation.every(0.005, lambda s: seen.append(s.sum(float(len(s.particles)))))
    simulation.run()
    # What is due at 0.005 s is inserted by the step that begins there.
    assert seen == [8.0, 10.0, 16.0, 16.0, 16.0], seen
    if comm is not None:
        assert simulation.size == comm.size and simulation.rank == comm.rank
    rank, last = simulation.rank, simulation.time
if rank == 0:
    snapshot = grains.open(sys.argv[2]).particles("last")
    order = np.argsort(snapshot["id"])
    digest = hashlib.sha256()
    for name in ("id", "position", "velocity", "orientation_wxyz"):
        digest.update(np.ascontiguousarray(snapshot[name][order]).tobytes())
    print(digest.hexdigest(), last)
