"""Impact of a cylinder on a plane at 0 to 90 degrees, in several representations, against the closed form of
rigid bodies (thesis eqs 3.37-3.38 as corrected): `python cases/cylinder-impact/impact.py`, with the Python that
scripts/python-environment prints. Writes impact.csv, impact.png and cylinders.csv, the
places of the cylinders, beside this file."""
import csv
import math
import shutil
import sys
from pathlib import Path

import h5py
import matplotlib
import numpy

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import sweep

matplotlib.use("Agg")
import matplotlib.pyplot as plt

HERE = Path(__file__).parent
RADIUS, HEIGHT, MASS, RESTITUTION = 4e-3, 5.3e-3, 3.1e-4, 0.85
INERTIA = MASS * (3 * RADIUS**2 + HEIGHT**2) / 12
ANGLES = [0, 0.5, 5, 10, 15, 20, 25, 30, 35, 40, 45, 50, 55, 60, 65, 70, 75, 80, 85, 89.5, 90]
GAP = 2e-5
TRUE = '''kind = "cylinder"
radius = 4e-3
height = 5.3e-3'''


def sliced(count):
    """A cylinder of thinner ones."""
    return f'kind = "sliced_cylinder"\nradius = 4e-3\nheight = 5.3e-3\nslices = {count}'


def spheres(layers, rings, sphere):
    """A cylinder of spheres (thesis fig. 3.10)."""
    return f'kind = "sphere_cylinder"\nradius = 4e-3\nheight = 5.3e-3\nlayers = {layers}\nrings = {rings}\nsphere_radius = {sphere!r}'


# Name: keys of the shape, sharing of forces, contacts of faces.
BODIES = {"true": (TRUE, "mean", "point"), "true, spread": (TRUE, "mean", "patch")}
for slices in (2, 5, 10, 30):
    BODIES[f"{slices} slices, model A"] = (sliced(slices), "sum", "point")
    BODIES[f"{slices} slices, model B"] = (sliced(slices), "mean", "point")
BODIES["9 spheres"] = (spheres(1, [1, 8], 2.65e-3), "mean", "point")
BODIES["54 spheres"] = (spheres(3, [1, 17], 1.908e-3), "mean", "point")


def exact(angle):
    """Velocity away from the wall (m/s) and angular velocity (rad/s) after the impact."""
    if angle in (0, 90):
        return RESTITUTION, 0.0
    lever = math.hypot(RADIUS, HEIGHT / 2) * math.cos(math.atan2(HEIGHT / 2, RADIUS) + math.radians(angle))
    impulse = MASS * (1 + RESTITUTION) / (1 + MASS * lever**2 / INERTIA)
    return impulse / MASS - 1, impulse * lever / INERTIA


def write_places(path):
    """The cylinders, turned about y, their lowest points at one height."""
    with open(path, "w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["x", "y", "z", "qw", "qx", "qy", "qz", "vx", "vy", "vz"])
        for k, angle in enumerate(ANGLES):
            turn = math.radians(angle)
            lowest = RADIUS * math.sin(turn) + HEIGHT / 2 * math.cos(turn)
            half = -turn / 2
            rows.writerow([0.01 + 0.019 * k, 0.01, lowest + GAP, math.cos(half), 0, math.sin(half), 0, 0, 0, -1])


def run(name):
    """Velocity, angular velocity and contact time of each cylinder of a representation."""
    keys, composite, faces = BODIES[name]
    folder = sweep.RESULTS / "cylinder-impact" / name.replace(", ", "-").replace(" ", "-")
    folder.mkdir(parents=True, exist_ok=True)
    write_places(HERE / "cylinders.csv")
    shutil.copy(HERE / "cylinders.csv", folder)
    case = (HERE / "cylinders.toml").read_text().replace(TRUE, keys)
    if "sphere" in keys:
        case = case.replace("crust = 0.002\n", "")
    case = case.replace('composite = "mean"', f'composite = "{composite}"')
    case = case.replace('faces = "point"', f'faces = "{faces}"')
    case = case.replace('"results/cylinder-impact"', f'"{folder / "run"}"')
    sweep.run(case, folder)
    with h5py.File(folder / "run/particles.vtkhdf") as file:
        group = file["VTKHDF"]
        count = len(ANGLES)
        fields = {k: group["PointData"][k][:].reshape((-1, count) + group["PointData"][k].shape[1:])
                  for k in ("id", "velocity", "angular_velocity", "wall_contacts")}
        times = group["Steps/Values"][:]
    found = []
    for k in range(count):
        # Rows change places as particles are sorted.
        rows = numpy.argmax(fields["id"] == k, axis=1)
        pick = lambda field: fields[field][numpy.arange(len(rows)), rows]
        touching = pick("wall_contacts") > 0
        first = numpy.argmax(touching)
        apart = first + numpy.argmax(~touching[first:])
        found.append((pick("velocity")[apart, 2], pick("angular_velocity")[apart, 1], times[apart] - times[first]))
    return found


def main():
    results = {name: run(name) for name in BODIES}
    with open(HERE / "impact.csv", "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["representation", "angle_deg", "velocity_m_s", "exact_m_s", "omega_rad_s", "exact_rad_s", "contact_s"])
        for name, found in results.items():
            for angle, (velocity, omega, contact) in zip(ANGLES, found):
                v, w = exact(angle)
                table.writerow([name, angle, f"{velocity:.5f}", f"{v:.5f}", f"{omega:.3f}", f"{w:.3f}", f"{contact:.2e}"])
    print(f"{'representation':<20} {'V+ 0':>9} {'V+ 30':>9} {'omega 30':>9} {'V+ 60':>9} {'omega 60':>9} {'V+ 90':>9} {'omega 90':>9} "
          f"{'worst V':>8} {'worst w':>8} {'leaves at':>15} {'T_c 90 (us)':>11}")
    for name, found in [("exact", [(*exact(a), 0) for a in ANGLES])] + list(results.items()):
        at = lambda angle: found[ANGLES.index(angle)]
        inner = [(f, exact(a)) for a, f in zip(ANGLES, found) if 5 <= a <= 85]
        worst_v = max(abs(f[0] - e[0]) for f, e in inner)
        worst_w = max(abs(f[1] - e[1]) for f, e in inner) / max(abs(e[1]) for _, e in inner)
        print(f"{name:<20} {at(0)[0]:>9.5f} {at(30)[0]:>9.5f} {at(30)[1]:>9.2f} {at(60)[0]:>9.5f} {at(60)[1]:>9.2f} "
              f"{at(90)[0]:>9.5f} {at(90)[1]:>9.2f} {worst_v:>8.4f} {worst_w:>8.4f} {leaving(found):>15} {1e6 * at(90)[2]:>11.1f}")
    draw(results)


def leaving(found):
    """Least and largest velocity (m/s) of the contact point after the impact, at 0.5 to 89.5 degrees."""
    lever = lambda a: RADIUS * math.cos(math.radians(a)) - HEIGHT / 2 * math.sin(math.radians(a))
    speeds = [f[0] + f[1] * lever(a) for a, f in zip(ANGLES, found) if 0 < a < 90]
    return f"{min(speeds):.4f}-{max(speeds):.4f}"


def draw(results):
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2))
    smooth = numpy.linspace(0.01, 89.99, 300)
    left.plot(smooth, [exact(a)[0] for a in smooth], "k-", label="rigid body")
    right.plot(smooth, [exact(a)[1] for a in smooth], "k-", label="rigid body")
    marks = {"true": "o", "10 slices, model A": "x", "10 slices, model B": "+", "9 spheres": "s", "54 spheres": "^"}
    for name, mark in marks.items():
        left.plot(ANGLES, [f[0] for f in results[name]], mark, label=name, fillstyle="none")
        right.plot(ANGLES, [f[1] for f in results[name]], mark, label=name, fillstyle="none")
    left.set(xlabel="angle (degrees)", ylabel="velocity away from the wall after the impact (m/s)")
    right.set(xlabel="angle (degrees)", ylabel="angular velocity after the impact (rad/s)")
    left.legend(loc="lower center")
    figure.tight_layout()
    figure.savefig(HERE / "impact.png", dpi=110)


if __name__ == "__main__":
    main()
