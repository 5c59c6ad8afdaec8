"""Cost of a collision of ellipsoids by surface vertices and by GJK (Srinivasan 2019, tables 4-5 and 4-6):
`python3 cases/superellipsoid-scaling/scaling.py`. Settles the bed once, then times its step by each method at the
source's stiffness."""
import re
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import sweep

CASE = (Path(__file__).parent / "ellipsoids.toml").read_text()
FOLDER = sweep.RESULTS / "superellipsoid-scaling"
# What makes the settled bed as soft as the source's, where overlaps are deep enough for vertices to find them.
SOFT = [
    ("normal_stiffness = 4000", "normal_stiffness = 40"),
    ("dt = 1.2e-6", "dt = 1.2e-5"),
    ("impact_speed = 1\n", "impact_speed = 0.02\n"),
]
# Table 4-6, microseconds per collision and processor.
SOURCE = {20: 13.1, 30: 25.5, 40: 46.07}


def bench(name, keys):
    """Microseconds per particle and step; pairs tested, walls aside, and contacts per particle."""
    text = CASE.replace("semi_axes", f"{keys}semi_axes")
    text = re.sub(r'place = \{ kind = "lattice".*', 'place = { kind = "file", path = "settled/run/particles.vtkhdf" }', text)
    for old, new in SOFT:
        assert old in text
        text = text.replace(old, new)
    # Vertices let bodies sink into each other until one is found inside.
    text += "\n[limits]\noverlap = 0.5\n"
    path = FOLDER / f"{name}.toml"
    path.write_text(text)
    command = [sweep.PROGRAM, "bench", path, "--warm", "100", "--steps", "50", "--segments", "3"]
    done = subprocess.run(command, check=True, capture_output=True, text=True, env=sweep.environment())
    times = sorted(float(t) for t in re.findall(r"us_per_particle_step\s+(\S+)", done.stdout))
    found = re.search(r"contacts_per_particle (\S+) wall_contacts (\d+)", done.stdout)
    pairs = int(re.search(r"pairs \d+ (\d+)", done.stdout).group(1)) / 2000
    return times[1], pairs, float(found.group(1)) + int(found.group(2)) / 2000


def main():
    settled = CASE.replace('"results/superellipsoid-scaling"', f'"{FOLDER / "settled/run"}"')
    settled = settled.replace("particles = 0\n", "particles = 0.1\n")
    sweep.run(settled, FOLDER / "settled")
    print(f"{'method':<15} {'us/particle/step':>16} {'pairs':>6} {'us/pair':>8} {'contacts':>9} {'us/contact':>11} {'source (2012)':>14}")
    for name, keys, source in [("GJK", "", "-")] + [
        (f"{n * n} vertices", f"surface_vertices = {{ per_direction = {n} }}\n", t) for n, t in SOURCE.items()
    ]:
        step, pairs, contacts = bench(name.replace(" ", "-"), keys)
        print(f"{name:<15} {step:>16.3f} {pairs:>6.2f} {step / pairs:>8.3f} {contacts:>9.2f} {step / contacts:>11.3f} {source:>14}", flush=True)


if __name__ == "__main__":
    main()
