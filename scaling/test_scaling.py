#!/usr/bin/env python3
"""Tests of the studies that run nothing: `python3 -m unittest` in this folder."""

import argparse
import contextlib
import importlib.util
import itertools
import math
import os
import subprocess
import tempfile
import tomllib
import unittest
from pathlib import Path

import dam_break
import ellipsoids
import exchange
import fluidised_bed
import limits
import model
import project
import silos
import slurm
import study
import weak

STUDIES = [silos.STUDY, dam_break.STUDY, fluidised_bed.STUDY, ellipsoids.STUDY, weak.STUDY]

# Two segments of `bench` on two ranks, and what it counts per rank.
OUTPUT = """\
us_per_particle_step 0.02000 particles 8000 rebuilds 1 pairs 20000 0 300 clones 450
  neighbour lists 0.00100  clone update 0.00200  particle contacts 0.01000  wall contacts 0.00100  motion 0.00400  agreement of ranks 0.00200  output 0.00000
us_per_particle_step 0.03000 particles 8000 rebuilds 2 pairs 20000 0 300 clones 460
  neighbour lists 0.00100  clone update 0.00400  particle contacts 0.01000  wall contacts 0.00100  motion 0.00400  agreement of ranks 0.01000  output 0.00000
per_rank owned mean 4000 max 4100
per_rank clones mean 455.5 max 460
per_rank bytes mean 32796 max 33120
contacts_per_particle 2.2600 wall_contacts 120
"""


def found(us, ranks):
    """What `bench` would have printed of a step that takes so long on one rank (us per particle)."""
    text = OUTPUT.replace("0.02000", f"{us / ranks:.8f}").replace("0.03000", f"{us / ranks:.8f}")
    return study.parse(text.replace("particles 8000", f"particles {4000 * ranks}"))


def options(folder, **changed):
    """Options as from the command line."""
    parser = argparse.ArgumentParser()
    slurm.add_options(parser)
    values = vars(parser.parse_args([]))
    values |= dict(binary=Path("grains mpi"), count=1000, kinds=None, warm=None, steps=None, settle_ranks=2,
                   ranks=[1, 64, 128], slurm=Path(folder))
    return argparse.Namespace(**(values | changed))


class Tables(unittest.TestCase):
    def test_bench_is_read(self):
        here = study.parse(OUTPUT)
        self.assertEqual(here.times, [0.02, 0.03])
        self.assertEqual((here.particles, here.rebuilds, here.clones, here.contacts), (8000, 2, 460, 2.26))
        self.assertAlmostEqual(here.communication(), 0.018 / 0.05)
        self.assertAlmostEqual(here.imbalance(), 1.025)
        self.assertEqual(here.per_rank["bytes"], (32796.0, 33120.0))

    def test_what_the_program_does_not_count_is_a_dash(self):
        here = study.parse("\n".join(line for line in OUTPUT.splitlines() if not line.startswith("per_rank")))
        system = weak.STUDY.systems[0]
        _, rows = study.count_rows([system], {(system.label, 2): here}, [2])
        self.assertEqual(rows[0][3:], ["-"] * 6)
        self.assertIsNone(study.parse("error: no"))

    def test_weak_scaling_compares_steps_of_one_rank(self):
        system = weak.STUDY.systems[0]
        results = {(system.label, 1): found(0.05, 1), (system.label, 4): found(0.0625, 4)}
        scaling = study.factors(weak.STUDY, system, results, [1, 4])
        self.assertAlmostEqual(scaling[1], 1.0)
        self.assertAlmostEqual(scaling[4], 0.8, places=3)

    def test_strong_scaling_compares_the_whole(self):
        system = ellipsoids.STUDY.systems[0]
        results = {(system.label, n): found(0.05, n) for n in (2, 8)}
        scaling = study.factors(ellipsoids.STUDY, system, results, [2, 8])
        self.assertAlmostEqual(scaling[2], 2.0)
        self.assertAlmostEqual(scaling[8], 8.0, places=3)

    def test_rows_stand_beside_the_source_where_only_that_was_run(self):
        system = dam_break.STUDY.systems[0]
        header, rows = study.timing_rows(dam_break.STUDY, [system], {}, [1])
        self.assertEqual([row[1] for row in rows], [1, 512])
        self.assertEqual(rows[1][header.index("S(n)") + 1], "0.930")
        self.assertTrue(all(len(row) == len(header) for row in rows))


class Limits(unittest.TestCase):
    def test_segments_are_read_with_the_work_they_did(self):
        bodies = limits.Loop(Path("."), "bed.toml", 60)
        output = "us_per_particle_step 0.5 particles 2000 rebuilds 1\nus_per_particle_step 0.75 particles 2000 rebuilds 0\n"
        self.assertEqual(bodies.segments(output, 60), [(500, 120_000), (750, 120_000)])
        fluid = limits.Loop(Path("."), "cavity.toml", 4, of_fluid=True)
        output += "fluid_ns_per_cell_step 80.5 exchange 20.5 cells 1000 steps 3 iterations 3\n"
        self.assertEqual(fluid.segments(output, 4), [(101, 3000)])

    def test_a_benchmark_without_timing_is_an_error(self):
        with self.assertRaises(SystemExit):
            limits.Loop(Path("."), "bed.toml", 60).segments("error: no such file", 60)


class Sources(unittest.TestCase):
    def test_times_per_particle_are_those_of_the_whole_silo(self):
        seconds = {"d": 86400, "h": 3600, "min": 60, "s": 1}
        for silo, time, microseconds in silos.REFERENCE:
            words = time.split()
            whole = sum(int(n) * seconds[unit] for n, unit in zip(words[::2], words[1::2]))
            count = int(silo.split()[0].replace(",", ""))
            self.assertLess(abs(1e6 * whole / 300000 / count - microseconds), 0.7, silo)

    def test_speed_up_of_the_ellipsoids(self):
        self.assertAlmostEqual(ellipsoids.SPEED_UP[8], 7.179, places=3)
        self.assertAlmostEqual(ellipsoids.SPEED_UP[8] / 8, 0.8973, places=4)
        self.assertAlmostEqual(ellipsoids.SPEED_UP[4], 3.749, places=3)
        self.assertAlmostEqual(ellipsoids.SPEED_UP[2] / 2, 0.967, delta=1e-3)

    def test_sizes_grow_with_the_cores(self):
        for cores, particles in zip(dam_break.CORES, dam_break.PARTICLES):
            self.assertLess(abs(particles / cores / dam_break.COUNT - 1), 2e-3)
        for nodes, (length, million) in zip(fluidised_bed.NODES, fluidised_bed.SIZES):
            self.assertEqual((length, round(million, 1)), (200 * nodes, round(4.8 * nodes, 1)))

    def test_a_full_rank_has_as_many_as_the_source(self):
        self.assertEqual(fluidised_bed.per_rank(300000), 300000)
        self.assertEqual(fluidised_bed.shape(300000), (20, 8, 300))
        self.assertEqual(dam_break.whole(101850), 101850)
        self.assertAlmostEqual(silos.width(14000), 0.25)
        self.assertAlmostEqual(silos.hopper_height(0.25), 0.185375, places=5)


class Cases(unittest.TestCase):
    def test_every_case_is_toml_with_one_subdomain_per_rank(self):
        for one in STUDIES:
            for system in one.systems:
                for count in {system.actual(min(system.count, 2000)), system.count}:
                    for stage in system.stages(count):
                        tomllib.loads(stage.text)
                    for ranks in (1, 6, 16):
                        text, _ = system.case(count, ranks)
                        domain = tomllib.loads(text)["domain"]
                        if not one.is_strong:
                            self.assertEqual(math.prod(domain["ranks"]), ranks, system.label)

    def test_copies_fill_the_silos_of_all_ranks(self):
        for merged in (False, True):
            text, wanted = silos.discharge("spheres", 2000, 6, merged)
            case = tomllib.loads(text)
            self.assertEqual(wanted.counts, (3, 2, 1))
            width = (case["domain"]["upper"][0] - case["domain"]["lower"][0]) / 3
            self.assertAlmostEqual(wanted.spacing[0], width, places=5)
            vertices, faces = case["wall"][0]["vertices"], case["wall"][0]["faces"]
            self.assertEqual(len(vertices), max(map(max, faces)) + 1)

    def test_exchange_names_its_strategy(self):
        for strategy in exchange.STRATEGIES:
            case = tomllib.loads(weak.bed(500, exchange.layout(27), f'exchange = "{strategy}"\n'))
            self.assertEqual((case["domain"]["exchange"], case["domain"]["ranks"]), (strategy, [3, 3, 3]))
        self.assertEqual(exchange.layout(16), (4, 4, 1))


class Jobs(unittest.TestCase):
    def test_scripts_are_shell_and_depend_on_each_other(self):
        for launcher in ("srun", "mpirun"):
            for one in STUDIES:
                with tempfile.TemporaryDirectory() as folder:
                    wanted = options(folder, launcher=launcher, sbatch=["account=granular"])
                    with contextlib.redirect_stdout(None):
                        slurm.write_study(one, study.chosen(one, wanted), wanted)
                    scripts = sorted(Path(folder).rglob("*.sbatch")) + sorted(Path(folder).glob("*.sh"))
                    for script in scripts:
                        subprocess.run(["bash", "-n", script], check=True)
                    self.submit(one, Path(folder))

    def submit(self, one, folder):
        """Runs the submit script with a pretended sbatch that counts and remembers."""
        tools = folder / "tools"
        tools.mkdir()
        (tools / "sbatch").write_text('#!/bin/bash\necho "$@" >>"$CALLS"\nwc -l <"$CALLS"\n')
        (tools / "sbatch").chmod(0o755)
        calls = folder / "calls"
        environment = os.environ | {"PATH": f"{tools}:{os.environ['PATH']}", "CALLS": str(calls)}
        subprocess.run([folder / f"submit-{one.name}.sh"], check=True, env=environment, stdout=subprocess.DEVNULL)
        lines = calls.read_text().splitlines()
        points = [line for line in lines if "job.sbatch" in line]
        wanted = options(folder)
        systems = study.chosen(one, wanted)
        self.assertEqual(len(points), len(systems) * len(wanted.ranks))
        beds = {stage.name for system in systems for stage in system.stages(system.count)}
        self.assertEqual(len(lines) - len(points), len(beds) * wanted.links)
        if beds:
            self.assertTrue(all("--dependency=afterok:" in line for line in points))
            self.assertEqual(sum("--dependency=afterany:" in line for line in lines), len(beds) * (wanted.links - 1))

    def test_nodes_follow_from_ranks_per_node(self):
        text = slurm.header("name", Path("/folder"), 128, options("/folder", ranks_per_node=48))
        for line in ("#SBATCH --nodes=3", "#SBATCH --ntasks=128", "#SBATCH --ntasks-per-node=48"):
            self.assertIn(line, text)


def cube(ranks_per_edge, particles, periodic=True):
    """A cube of cubes, filled."""
    per_rank = particles * math.pi / 6 / 0.6
    edge = ranks_per_edge * per_rank ** (1 / 3)
    upper, origin = (edge,) * 3, (0.0,) * 3
    return model.Bed(origin, upper, origin, upper, (periodic,) * 3, (ranks_per_edge,) * 3, particles * ranks_per_edge**3, 1.0, 0.6)


CONSTANTS = model.Constants(work=[(1000, 4e-8), (100000, 9e-8)], rebuild=6e-7, clone=4e-9, message=5e-7)
NETWORK = model.Network("network", 2e-6, 25e9, "")


class Model(unittest.TestCase):
    def test_clones_of_a_cube_within_the_bed(self):
        bed = cube(4, 8000)
        middle = model.counts(bed, (1, 1, 1))
        share = (1 + 2 * bed.layer() / bed.subdomain(0)) ** 3 - 1
        self.assertAlmostEqual(middle.clones / middle.owned, share)
        self.assertEqual(middle.neighbours, 26)
        self.assertAlmostEqual(middle.remote, middle.clones)
        of_notices = 8 * 2 * 26
        self.assertAlmostEqual((middle.bytes("body") - of_notices) / (middle.bytes() - of_notices), 13 / 9)

    def test_a_rank_is_its_own_neighbour_without_messages(self):
        alone = model.counts(cube(1, 8000), (0, 0, 0))
        self.assertGreater(alone.clones, 0)
        self.assertEqual((alone.remote, alone.neighbours), (0, 0))
        # Two ranks per periodic axis meet on both sides, in one message.
        self.assertEqual(model.counts(cube(2, 8000), (0, 0, 0)).neighbours, 7)

    def test_closed_faces_have_no_neighbours(self):
        bed = cube(3, 1000, periodic=False)
        self.assertEqual(model.counts(bed, (0, 0, 0)).neighbours, 7)
        self.assertEqual(model.counts(bed, (1, 1, 1)).neighbours, 26)
        self.assertAlmostEqual(sum(times for _, times in model.kinds_of_place(cube(12, 1000, periodic=False))), 12**3)

    def test_every_particle_is_owned_once(self):
        bed = cube(3, 1000, periodic=False)
        bed.filled_upper = (bed.upper[0], bed.upper[1], 0.4 * bed.upper[2])
        owned = sum(times * model.counts(bed, place).owned for place, times in model.kinds_of_place(bed))
        self.assertAlmostEqual(owned, bed.particles, places=6)
        mean, most = model.mean_and_most(bed)["owned"]
        self.assertAlmostEqual(most / mean, 2.5)

    def test_the_layer_grows_with_the_fastest(self):
        bed = cube(2, 8000)
        self.assertAlmostEqual(bed.layer(), 1.2625)
        bed.reaches = (0.025, 0.025)
        self.assertAlmostEqual(bed.layer(), 1.028125)

    def test_what_is_hidden_behind_work_is_no_longer_seen(self):
        bed = cube(8, 8000, periodic=False)
        seen, hidden = (model.step(bed, CONSTANTS, NETWORK, 64, 60, overlap=overlap) for overlap in (False, True))
        self.assertLess(hidden["messages"], seen["messages"])
        self.assertGreater(hidden["messages"], 0)

    def test_one_rank_scales_perfectly(self):
        bed = cube(1, 8000, periodic=False)
        terms = model.step(bed, CONSTANTS, NETWORK, 128, 60)
        self.assertAlmostEqual(model.scaling(bed, terms, CONSTANTS, 60), 1.0)
        self.assertEqual(sum(terms[name] for name in model.TERMS[1:]), 0.0)

    def test_more_ranks_never_scale_better(self):
        factors = []
        for edge in (1, 2, 4, 8, 16, 32, 64):
            bed = cube(edge, 8000, periodic=False)
            terms = model.step(bed, CONSTANTS, NETWORK, 64, 60)
            self.assertTrue(all(value >= 0 for value in terms.values()))
            factors.append(model.scaling(bed, terms, CONSTANTS, 60))
        self.assertEqual(factors, sorted(factors, reverse=True))
        self.assertGreater(factors[-1], 0)

    def test_larger_loads_scale_better(self):
        share = lambda particles: model.step(cube(8, particles, False), CONSTANTS, NETWORK, 64, 60)
        shares = [share(n)["work"] / sum(share(n).values()) for n in (1000, 8000, 64000, 512000)]
        self.assertEqual(shares, sorted(shares))

    def test_bricks_send_no_more_off_their_node_than_rows(self):
        bed = cube(16, 8000, periodic=False)
        leaving = lambda node: sum(model.counts(bed, place, node).off_node for place in node)
        brick, row = model.brick(bed, 64), model.row(bed, 64)
        self.assertEqual((len(brick), len(row)), (64, 64))
        self.assertLess(leaving(brick), leaving(row))

    def test_bricks_fill_the_grid_or_are_not_used(self):
        bed = cube(5, 8000, periodic=False)
        self.assertEqual(model.brick(bed, 4), model.row(bed, 4))

    def test_pairs_are_of_owned_particles_unless_borders_are_near(self):
        shares = [model.counts(cube(4, particles), (1, 1, 1)).inner for particles in (10, 1000, 10**6)]
        self.assertEqual(shares, sorted(shares))
        self.assertGreater(shares[-1], 0.95)
        self.assertEqual(model.counts(cube(1, 1000, periodic=False), (0, 0, 0)).inner, 1.0)

    def test_grids(self):
        best = model.layouts(64, (1.0, 1.0, 1.0))
        self.assertEqual(best, {"columns": (8, 8, 1), "blocks": (4, 4, 4)})
        self.assertEqual(sorted(set(model.grids(6))), sorted(model.grids(6)))

    def test_imbalance_by_chance(self):
        self.assertEqual(model.imbalance_by_chance(1000, 1, 0.6), 1.0)
        few, many = (model.imbalance_by_chance(1000, ranks, 0.6) for ranks in (2, 2000))
        self.assertLess(1.0, few)
        self.assertLess(few, many)
        self.assertAlmostEqual(model.imbalance_by_chance(10**12, 100, 0.6), 1.0, places=5)

    def test_cost_is_interpolated(self):
        self.assertEqual(CONSTANTS.cost(10), 4e-8)
        self.assertAlmostEqual(CONSTANTS.cost(10000), 6.5e-8)
        self.assertEqual(CONSTANTS.cost(10**9), 9e-8)

    def test_the_case_of_the_check_is_that_of_the_model(self):
        text, bed = project.random_bed(100, (2, 2, 2))
        case = tomllib.loads(text)
        places = project.random_places(bed.particles, bed.filled_lower, bed.filled_upper)
        self.assertEqual(len(places), bed.particles)
        self.assertTrue(all(math.dist(a, b) > project.DIAMETER for a, b in itertools.combinations(places, 2)))
        self.assertEqual([round(x, 6) for x in bed.upper], case["domain"]["upper"])
        self.assertLess(bed.solid_fraction, 0.3)


@unittest.skipUnless(importlib.util.find_spec("numpy"), "needs NumPy")
class Rebuilds(unittest.TestCase):
    def simulated(self, grid, hot, steps=400):
        """How often each rank rebuilds, spheres of the ranks `hot` being faster."""
        import numpy
        import rebuilds

        chance, width = numpy.random.default_rng(2), rebuilds.edge(50)
        # One grid of places per rank, away from borders.
        corners = numpy.array(list(itertools.product(*map(range, grid)))) * width
        places = (corners[:, None] + width * chance.uniform(0.3, 0.7, (len(corners), 50, 3))).reshape(-1, 3)
        velocities = chance.normal(0, 5e-4, places.shape)
        for k in hot:
            velocities[50 * k:50 * (k + 1)] *= 10
        ranks = rebuilds.Ranks((places, velocities), grid, 50)
        found = [ranks.step(step) for step in range(steps)]
        return sum(own for own, _ in found), sum(border for _, border in found)

    def test_ranks_alike_rebuild_as_seldom_as_lists_last(self):
        own, border = self.simulated((3, 1, 1), [])
        self.assertEqual((set(own), set(border)), ({5}, {0}))

    def test_a_hot_rank_does_not_wake_those_that_are_no_neighbours(self):
        own, border = self.simulated((6, 1, 1), [0])
        self.assertGreater(own[0], 2 * own[3])
        self.assertEqual(list(border[2:5]), [0, 0, 0])
        self.assertTrue(border[1] > 0 and border[5] > 0)


if __name__ == "__main__":
    unittest.main()
