"""Results of runs."""
import numpy as np
import pandas as pd
import pytest

import grains


@pytest.fixture
def run(balls):
    """A run of balls and bricks."""
    with grains.Simulation(balls) as simulation:
        simulation.run()
    return grains.open("results")


def test_series_and_snapshots(run):
    assert isinstance(run.series, pd.DataFrame) and {"time", "kinetic_translation"} <= set(run.series.columns)
    assert np.allclose(run.times, [0, 0.01, 0.02], atol=4e-5)
    first, nearest = run.particles("first"), run.particles(0.0101)
    assert first.time == 0 and nearest.time == pytest.approx(0.01, abs=4e-5)
    assert [s.time for s in run.snapshots()] == list(run.times)
    assert nearest.units["velocity"] == "m/s" and nearest.count == 16
    frame = nearest.frame()
    assert list(frame.index) == list(range(16))
    assert np.array_equal(np.sort(frame["x"]), np.sort(nearest["position"][:, 0]))
    assert {"velocity_z", "orientation_w"} <= set(frame.columns)
    assert run.case.content["name"] == "balls"


def test_which_state_is_told(run):
    with pytest.raises(IndexError, match="state 3 of 3"):
        run.particles(3)
    with pytest.raises(ValueError, match="first"):
        run.particles("middle")
    assert run.particles(-1).time == run.particles("last").time


def test_a_folder_without_results_is_told(tmp_path):
    with pytest.raises(FileNotFoundError, match="no such folder"):
        grains.open("nowhere")
    with pytest.raises(FileNotFoundError, match="output.directory"):
        grains.open(tmp_path)


def test_analyses_give_tables(run):
    tables = run.analyse("coordination", time="all")
    assert "coordination" in tables and len(tables["coordination"]) == 3
    with pytest.raises(grains.CaseError, match="--sort"):
        run.analyse("coordination", sort=1)
    with pytest.raises(grains.CaseError, match="coordinates"):
        run.analyse("coordinates")


def test_meshes_have_the_true_shapes(run):
    pytest.importorskip("pyvista")
    snapshot = run.particles("last")
    mesh = snapshot.mesh()
    bricks = np.asarray(snapshot["shape"]) == 1
    volume = bricks.sum() * 8 * 5e-3 * 4e-3 * 3e-3
    balls = (~bricks).sum() * 4 / 3 * np.pi * 5e-3**3
    # Spheres are drawn with facets.
    assert 0.93 * balls + volume < mesh.volume < balls + volume
    ids = np.asarray(mesh["id"])
    for k in range(snapshot.count):
        corners = np.asarray(mesh.points)[ids == snapshot["id"][k]]
        assert np.allclose(corners.mean(axis=0), snapshot["position"][k], atol=1e-6)
        assert np.linalg.norm(corners - snapshot["position"][k], axis=1).max() <= snapshot["radius"][k] * 1.01
    walls = run.walls("last")
    assert walls.n_cells == 12 and np.all(np.abs(walls.points) < 0.081) and set(walls["wall"]) == {0}


def test_the_fluid_is_what_its_file_holds(bed):
    xarray = pytest.importorskip("xarray")
    case = grains.Case.load(bed).changed({"time.end": 0.001, "output.particles": 0.0005,
                                          "output.directory": "results"})
    with grains.Simulation(case) as simulation:
        simulation.run()
        void_fraction = simulation.fluid.void_fraction.copy()
    fluid = grains.open("results").fluid
    assert isinstance(fluid, xarray.Dataset) and dict(fluid.sizes) == {
        "time": 3, "z": 16, "y": 4, "x": 12, "component": 3}
    assert np.allclose(fluid["void_fraction"].isel(time=-1), void_fraction, rtol=1e-6)
    assert fluid["velocity"].attrs["units"] == "m/s"
    rise = fluid["velocity"].sel(component="z").isel(time=-1, z=-1).mean()
    assert float(rise) == pytest.approx(1.0, rel=0.1)
    mesh = pytest.importorskip("pyvista") and grains.open("results").fluid_mesh("last")
    assert mesh.n_cells == 16 * 4 * 12
    assert np.allclose(mesh["void_fraction"], void_fraction.ravel(), rtol=1e-6)
