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
with grains.Simulation(BALLS, comm=comm) as simulation:
    seen = []
    simulation.every(0.005, lambda s: seen.append(s.sum(float(len(s.particles)))))
    simulation.run()
    assert seen == [16.0] * 5, seen
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
