"""A drum at many speeds and with many shapes (thesis 3.4.2): `python3 cases/drum/drum.py [--shapes ...] [--rpm ...]`.
Each shape settles once; then its drum turns at each speed. Runs what is missing, two at a time, and goes on where it
was stopped; prints the table of what there is."""
import argparse
import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "packing"))
import sweep
from packing import SPHERE, shapes

CASE = (Path(__file__).parent / "drum.toml").read_text()
# Errata R16-25: the text has 1250 3-D crosses; 951 fill 35 % of the drum at the porosity of table 3.3.
COUNT = {"spheres": 3000, "cubes": 3000, "tetrahedra": 2600, "crosses-2d": 1500, "crosses-3d": 1250}
LAW = """normal_stiffness = 1e5
restitution = 0.73
friction = 0.55
tangential = { kind = "viscous", gamma_t = 1e5 }"""
# A tenth of the stiffness and a tangential spring, for which a longer step will do.
SOFT_LAW = """normal_stiffness = 1e4
restitution = 0.73
friction = 0.55"""
SPEEDS = [5, 20, 42, 80, 125, 150, 200, 220, 250]


def common(shape, soft):
    """The case with the bodies, their number, and the law."""
    text = CASE.replace(SPHERE, shapes()[shape]).replace("count = 3000", f"count = {COUNT[shape]}")
    if soft:
        assert LAW in text
        text = text.replace(LAW, SOFT_LAW).replace("dt = 2e-6", "dt = 4e-6\naccept_coarse_dt = true")
    return text


def settling(shape, soft, folder):
    """The case of the bed in the drum at rest."""
    text = common(shape, soft).replace('name = "drum, 20 rpm"', f'name = "drum of {shape}, at rest"')
    motion = text.index("motion = {")
    text = text[:motion] + text[text.index("\n", motion) + 1:]
    text = text.replace("end = 7", "end = 2").replace("particles = 0.02", "particles = 0.1")
    return text.replace('"results/drum/20-rpm"', f'"{folder / "run"}"') + "\n[stop]\nkinetic_energy_below = 1e-6\nafter = 0.8\n"


def turning(shape, soft, rpm, seconds, bed, folder):
    """The case of the drum turning from the settled bed."""
    text = common(shape, soft).replace('name = "drum, 20 rpm"', f'name = "drum of {shape}, {rpm:g} rpm"')
    start = text.index("place = {")
    end = text.index("velocity = [0, 0, -0.5]\n") + len("velocity = [0, 0, -0.5]\n")
    text = text[:start] + f'place = {{ kind = "file", path = "{bed / "run" / "particles.vtkhdf"}" }}\n' + text[end:]
    text = text.replace("angular_velocity = 2.0943951, start = 1", f"angular_velocity = {rpm * math.pi / 30!r}")
    text = text.replace("end = 7", f"end = {seconds:g}").replace('"results/drum/20-rpm"', f'"{folder / "run"}"')
    return text


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shapes", nargs="+", default=list(COUNT), choices=list(COUNT))
    parser.add_argument("--rpm", nargs="+", type=float, default=SPEEDS)
    parser.add_argument("--seconds", type=float, default=3, help="time the drum turns (s)")
    parser.add_argument("--stiff", action="store_true", help="the thesis's stiffness and law for all shapes, not for spheres only")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    soft = lambda shape: shape != "spheres" and not options.stiff
    name = lambda shape: shape + ("-stiff" if options.stiff and shape != "spheres" else "")
    bed = lambda shape: sweep.RESULTS / "drum" / name(shape) / "bed"
    folder = lambda shape, rpm: sweep.RESULTS / "drum" / name(shape) / f"{rpm:g}-rpm-{options.seconds:g}-s"
    sweep.run_all([(settling(s, soft(s), bed(s)), bed(s)) for s in options.shapes], options.jobs)
    points = [(s, rpm) for s in options.shapes for rpm in options.rpm]
    sweep.run_all([(turning(s, soft(s), rpm, options.seconds, bed(s), folder(s, rpm)), folder(s, rpm)) for s, rpm in points], options.jobs)
    print(f"{'shape':<11} {'rpm':>4} {'turns':>6} {'speed/rim':>9} {'with drum':>9} {'angle':>6} {'coordination':>12}")
    for shape, rpm in points:
        run = folder(shape, rpm)
        if not (run / "done").exists():
            continue
        window = f"{options.seconds / 2:g}:{options.seconds:g}"
        rows = sweep.analyse("drum", run, "--time", window)
        mean = lambda key: sum(float(row[key]) for row in rows) / len(rows)
        touch = sweep.analyse("coordination", run, "--time", window)
        coordination = sum(float(row["coordination"]) for row in touch) / len(touch)
        print(f"{shape:<11} {rpm:>4g} {options.seconds * rpm / 60:>6.2f} {mean('speed'):>9.3f} "
              f"{mean('order'):>9.3f} {mean('angle'):>6.1f} {coordination:>12.2f}")


if __name__ == "__main__":
    main()
