"""Energy through collisions, hard and soft (Srinivasan 2019, section 4.1.1), as a table and as energy.png:
`python3 cases/superellipsoid-energy/energy.py`."""
import re
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import sweep

HERE = Path(__file__).parent


def energies(case, folder):
    """Times, kinetic energy over that at the start, and largest speeds of a run."""
    sweep.run(re.sub(r'directory = "[^"]*"', f'directory = "{folder / "run"}"', case), folder)
    rows = sweep.table(folder / "run/series.csv")
    energy = [float(r["kinetic_translation"]) + float(r["kinetic_rotation"]) for r in rows]
    return [float(r["time"]) for r in rows], [e / energy[0] for e in energy], [float(r["max_speed"]) for r in rows]


def main():
    figure, (pair, many) = plt.subplots(1, 2, figsize=(10, 3), layout="constrained")
    two = (HERE / "ellipsoids.toml").read_text()
    print(f"{'':<14} {'e':>4} {'KE after the pair':>18} {'speed':>8} {'KE after the walls':>19}")
    for model in ("hard", "soft"):
        for restitution in (0.4, 1.0):
            case = two.replace('model = "hard"', f'model = "{model}"')
            case = case.replace("restitution = 0.4", f"restitution = {restitution}")
            folder = sweep.RESULTS / "superellipsoid-energy" / f"{model}-{restitution}"
            times, ratio, speed = energies(case, folder)
            pair.plot(times, ratio, "-" if model == "hard" else "--", label=f"{model}, e = {restitution}")
            # Between the pair's collision at 0.09 s and the walls, 0.36 m away.
            k = min(range(len(times)), key=lambda i: abs(times[i] - 0.2))
            print(f"{model:<14} {restitution:>4} {ratio[k]:>18.12f} {speed[k]:>8.5f} {ratio[-1]:>19.12f}")
    folder = sweep.RESULTS / "superellipsoid-energy/cylinders"
    times, ratio, _ = energies((HERE / "cylinders.toml").read_text(), folder)
    found = re.search(r"(\d+) collisions", (folder / "log").read_text())
    count = int(found.group(1)) if found else 0
    worst = max(abs(r - 1) for r in ratio)
    print(f"50 cylinders: energy changes by {worst:.1e} in {count} collisions, {worst / max(count, 1):.1e} per collision")
    many.plot(times, [r - 1 for r in ratio])
    pair.set(title="two ellipsoids, then the walls", xlabel="time (s)", ylabel="kinetic energy / that at the start")
    many.set(title="fifty elastic cylinders", xlabel="time (s)", ylabel="relative change of kinetic energy")
    pair.legend()
    figure.savefig(HERE / "energy.png", dpi=100)


if __name__ == "__main__":
    main()
