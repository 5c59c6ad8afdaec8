"""Cases that the tests share."""
import copy
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent.parent

BALLS = {
    "name": "balls", "seed": 3, "gravity": [0, 0, -9.81],
    "domain": {"lower": [0, 0, 0], "upper": [0.08, 0.06, 0.06]},
    "time": {"end": 0.02, "dt": 4e-5},
    "material": [{"name": "glass", "density": 2500}],
    "contact": [{"between": ["glass", "glass"], "normal_stiffness": 1e4, "restitution": 0.7, "friction": 0.3}],
    "shape": [{"name": "ball", "kind": "sphere", "radius": 5e-3},
              {"name": "brick", "kind": "box", "edges": [1e-2, 8e-3, 6e-3]}],
    "insert": [{"name": "balls", "count": 16,
                "particles": [{"shape": "ball", "material": "glass"}, {"shape": "brick", "material": "glass"}],
                "place": {"kind": "lattice", "lower": [0.02, 0.01, 0.02], "upper": [0.07, 0.055, 0.05],
                          "spacing": 0.0145}}],
    "wall": [{"name": "box", "material": "glass", "kind": "box", "lower": [0.005, 0.005, 0.005],
              "upper": [0.075, 0.059, 0.059]}],
    "output": {"directory": "results", "series": 0.001, "particles": 0.01, "checkpoint": 0.01},
}


@pytest.fixture
def balls():
    """A case of balls and bricks that fall in a box."""
    return copy.deepcopy(BALLS)


@pytest.fixture
def bed():
    """The path of a small bed of beads that a gas flows through."""
    return ROOT / "mpi-tests/cases/bed.toml"


@pytest.fixture(autouse=True)
def own_folder(tmp_path, monkeypatch):
    """Results of a test are in a folder of its own."""
    monkeypatch.chdir(tmp_path)
