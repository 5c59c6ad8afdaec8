"""Simulations on several ranks."""
import importlib.util
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).with_name("on_ranks.py")


def on_ranks(ranks, communicator):
    """What the script prints on a number of ranks."""
    command = ["mpirun", "-n", str(ranks), sys.executable, SCRIPT, communicator, f"{communicator}-{ranks}"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout.strip().splitlines()[-1]


@pytest.mark.skipif(not shutil.which("mpirun"), reason="no mpirun")
def test_the_bits_are_the_same_on_any_ranks():
    assert on_ranks(3, "own") == on_ranks(1, "own")


@pytest.mark.skipif(not importlib.util.find_spec("mpi4py"), reason="no mpi4py")
def test_the_communicator_of_mpi4py_is_used():
    assert on_ranks(2, "mpi4py") == on_ranks(1, "own")
