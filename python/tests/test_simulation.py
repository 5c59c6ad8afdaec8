"""Simulations: running, looking and steering."""
import gc

import numpy as np
import pytest

import grains


def state(simulation):
    """Identities, positions and velocities, by identity."""
    particles = simulation.particles
    order = np.argsort(particles.id)
    return [np.array(values[order]) for values in (particles.id, particles.position, particles.velocity)]


def same(a, b):
    return all(np.array_equal(x, y) for x, y in zip(a, b))


def test_looking_changes_no_bit(balls):
    with grains.Simulation(balls, writes_files=False) as plain:
        plain.run()
        expected = state(plain)
    seen, looked, kept = [], [], []
    with grains.Simulation(balls, writes_files=False) as watched:
        def look(simulation):
            looked.append(simulation.particles.position)
            seen.append((simulation.time, looked[-1].copy()))
        watched.every(0.002, look)
        while watched.run(watched.time + 0.0013):
            kept.append(watched.particles.velocity)
        assert same(state(watched), expected)
    times = [time for time, _ in seen]
    assert np.allclose(times, 0.002 * np.arange(len(times)), atol=2.1e-5) and len(times) == 11
    # What was looked at is still what it was.
    assert all(np.array_equal(shown, copy) for shown, (_, copy) in zip(looked, seen))
    assert not np.array_equal(seen[0][1], seen[-1][1])


def test_arrays_outlive_steps_and_the_simulation(balls):
    simulation = grains.Simulation(balls, writes_files=False)
    before = simulation.particles.position
    copy = before.copy()
    assert before.base is not None and not before.flags.writeable and not before.flags.owndata
    simulation.step(50)
    after = simulation.particles.position
    assert np.array_equal(before, copy) and not np.array_equal(after, copy)
    simulation.close()
    del simulation
    gc.collect()
    assert np.array_equal(before, copy) and np.isfinite(after).all()
    with pytest.raises(ValueError):
        before[0, 0] = 1.0


def test_arrays_outlive_a_simulation_that_is_forgotten(balls):
    position = grains.Simulation(balls, writes_files=False).particles.position
    gc.collect()
    others = [grains.Simulation(balls, writes_files=False) for _ in range(3)]
    assert np.array_equal(position, others[0].particles.position)
    del others
    gc.collect()
    assert np.all((position > 0) & (position < 0.08))


def test_arrays_are_not_copies(balls):
    with grains.Simulation(balls, writes_files=False) as simulation:
        a, b = simulation.particles.position, simulation.particles.position
        assert a.ctypes.data == b.ctypes.data
        velocity = simulation.particles.velocity
        assert velocity.ctypes.data - a.ctypes.data < a.strides[0]


def test_fields_agree_with_each_other(balls):
    with grains.Simulation(balls, writes_files=False) as simulation:
        simulation.run(0.01)
        particles = simulation.particles
        assert len(particles) == 16 == len(np.unique(particles.id))
        assert np.allclose(np.linalg.norm(particles.orientation, axis=1), 1)
        assert set(particles.shape) == {0, 1} and set(particles.material) == {0}
        balls_of = particles.shape == 0
        assert np.allclose(particles.radius[balls_of], 5e-3)
        assert np.allclose(particles.mass[balls_of], 2500 * 4 / 3 * np.pi * 5e-3**3)
        assert np.allclose(particles.mass[~balls_of], 2500 * 8 * 5e-3 * 4e-3 * 3e-3)
        with pytest.raises(ValueError, match=r"\[heat\]"):
            particles.temperature
        assert simulation.sum(2.0) == 2.0 and simulation.max(3.0) == 3.0 and simulation.size == 1


def test_the_files_are_those_of_the_program(balls):
    with grains.Simulation(balls) as simulation:
        simulation.run()
        last = state(simulation)
        summary = simulation.close()
    assert summary["inside"] == 16 and simulation.status == "finished"
    run = grains.open("results")
    stored = run.particles("last")
    order = np.argsort(stored["id"])
    assert np.array_equal(stored["id"][order], last[0])
    assert np.allclose(stored["position"][order], last[1], rtol=1e-6)
    assert len(run.series) == 21 and run.times[-1] == pytest.approx(0.02)


def test_a_stop_and_a_restart_give_the_same_bits(balls):
    with grains.Simulation(balls, writes_files=False) as simulation:
        simulation.run()
        expected = state(simulation)
    with grains.Simulation(balls) as simulation:
        assert simulation.run(0.0077)
        simulation.stop()
        assert not simulation.run() and simulation.status == "stopped"
    with grains.Simulation(balls, restart="latest") as simulation:
        assert 0.0077 < simulation.time < 0.008
        simulation.run()
        assert same(state(simulation), expected)


def test_a_closed_simulation_says_so(balls):
    simulation = grains.Simulation(balls, writes_files=False)
    simulation.close()
    with pytest.raises(ValueError, match="closed"):
        simulation.run()


def test_an_error_in_a_function_leaves_the_simulation(balls):
    with pytest.raises(ZeroDivisionError):
        with grains.Simulation(balls) as simulation:
            simulation.at(0.005, lambda s: 1 / 0)
            simulation.run()
    assert grains.open("results").series["time"].iloc[-1] <= 0.005 + 4e-5


def test_a_state_that_cannot_be_trusted_is_an_error(balls):
    balls["insert"][0]["velocity"] = [0, 0, 90]
    balls["limits"] = {"overlap": 0.02}
    with pytest.raises(grains.UnphysicalError, match="step"):
        with grains.Simulation(balls, writes_files=False) as simulation:
            simulation.run()


def test_a_wall_moves_as_it_is_told(balls):
    balls["wall"].append({"name": "plate", "material": "glass", "kind": "plane", "point": [0, 0, 0.001],
                          "normal": [0, 0, 1]})
    with grains.Simulation(balls, writes_files=False) as simulation:
        simulation.set_wall_motion("plate", {"kind": "translation", "velocity": [0, 0, 0.05]})
        simulation.run(0.01)
        assert simulation.walls["plate"].displacement[2] == pytest.approx(5e-4, rel=1e-2)
        simulation.set_wall_motion("plate", None)
        simulation.run(0.02)
        assert simulation.walls["plate"].displacement[2] == pytest.approx(5e-4, rel=1e-2)
        with pytest.raises(grains.CaseError, match="plate"):
            simulation.set_wall_motion("plates", None)
        with pytest.raises(grains.CaseError, match="velocity"):
            simulation.set_wall_motion("plate", {"kind": "translation", "speed": 1.0})


def test_insertion_goes_as_it_is_told(balls):
    balls["insert"][0].update(
        count=40, batch=4, interval=0.002, particles=[{"shape": "ball", "material": "glass"}],
        place={"kind": "window", "window": {"kind": "box", "lower": [0.012, 0.012, 0.03], "upper": [0.068, 0.05, 0.05]}})
    with grains.Simulation(balls, writes_files=False) as simulation:
        simulation.run(0.0033)
        assert len(simulation.particles) == 8
        simulation.set_insertion("balls", batch=4, interval=0.002, next=np.inf)
        simulation.run(0.009)
        assert len(simulation.particles) == 8
        simulation.set_insertion("balls", batch=2, interval=0.001)
        simulation.run(0.0125)
        assert len(simulation.particles) == 16
        with pytest.raises(grains.CaseError, match="balls"):
            simulation.set_insertion("sand", batch=1, interval=1)


def test_an_inlet_lets_in_what_it_is_told(bed):
    case = grains.Case.load(bed).changed({"time.end": 0.02})
    with grains.Simulation(case, writes_files=False) as simulation:
        simulation.run(0.001)
        fluid = simulation.fluid
        assert fluid.pressure.shape == (16, 4, 12) and len(fluid.nodes[2]) == 17
        assert 0.3 < fluid.void_fraction.min() < 0.95
        before = fluid.face_velocity[2]
        kept = before.copy()
        simulation.set_inlet_velocity(0, [0, 0, 0.5])
        simulation.run(0.002)
        assert np.array_equal(before, kept)
        # What comes in goes out: the superficial velocity at the top is that of the inlet.
        top = (simulation.fluid.face_velocity[2] * simulation.fluid.void_fraction)[-1].mean()
        assert top == pytest.approx(0.5, rel=0.1) and kept[-1].mean() == pytest.approx(1.0, rel=0.1)
        with pytest.raises(grains.CaseError, match="inlet"):
            simulation.set_inlet_velocity(1, [0, 0, 1])
        with pytest.raises(grains.CaseError, match=r"boundary\[7\]"):
            simulation.set_inlet_velocity(7, [0, 0, 1])


def test_setting_what_an_inlet_has_changes_little(bed):
    case = grains.Case.load(bed).changed({"time.end": 0.02})
    pressures = []
    for is_told in (False, True):
        with grains.Simulation(case, writes_files=False) as simulation:
            simulation.run(0.0005)
            if is_told:
                simulation.set_inlet_velocity(0, [0, 0, 1.0])
            simulation.run(0.001)
            pressures.append(simulation.fluid.pressure.copy())
    assert np.allclose(*pressures, rtol=1e-6, atol=1e-6 * np.abs(pressures[0]).max())
