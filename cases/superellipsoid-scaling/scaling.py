"""Cost of a collision of ellipsoids by surface vertices and by GJK (Srinivasan 2019, tables 4-5 and 4-6):
`python3 cases/superellipsoid-scaling/scaling.py`. Settles the bed once, then times its step by each method."""
import re
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import sweep

CASE = (Path(__file__).parent / "ellipsoids.toml").read_text()
FOLDER = sweep.RESULTS / "superellipsoid-scaling"
# Table 4-6, microseconds per collision and processor.
SOURCE = {20: 13.1, 30: 25.5, 40: 46.07}


def bench(name, keys):
    """Microseconds per particle and step and per contact, and contacts per particle."""
    text = CASE.replace("semi_axes", f"{keys}semi_axes")
    text = re.sub(r'place = \{ kind = "lattice".*', 'place = { kind = "file", path = "settled/run/particles.vtkhdf" }', text)
    path = FOLDER / f"{name}.toml"
    path.write_text(text)
    command = [sweep.PROGRAM, "bench", path, "--warm", "200", "--steps", "400", "--segments", "3"]
    done = subprocess.run(command, check=True, capture_output=True, text=True, env=sweep.environment())
    times = sorted(float(t) for t in re.findall(r"us_per_particle_step\s+(\S+)", done.stdout))
    found = re.search(r"contacts_per_particle (\S+) wall_contacts (\d+)", done.stdout)
    contacts = float(found.group(1)) + int(found.group(2)) / 2000
    return times[1], times[1] / contacts, contacts


def main():
    settled = CASE.replace('"results/superellipsoid-scaling"', f'"{FOLDER / "settled/run"}"')
    settled = settled.replace("particles = 0\n", "particles = 0.1\n")
    sweep.run(settled, FOLDER / "settled")
    print(f"{'method':<18} {'us/particle/step':>17} {'contacts':>9} {'us/collision':>13} {'source (2012)':>14}")
    for name, keys, source in [("GJK", "", "-")] + [
        (f"{n * n} vertices", f"surface_vertices = {{ per_direction = {n} }}\n", t) for n, t in SOURCE.items()
    ]:
        step, collision, contacts = bench(name.replace(" ", "-"), keys)
        print(f"{name:<18} {step:>17.3f} {contacts:>9.2f} {collision:>13.3f} {source:>14}")


if __name__ == "__main__":
    main()
