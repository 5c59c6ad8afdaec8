"""Coefficients of Morison's equation from the force on a swinging cylinder, over the last two periods of a run.

F = −½ ρ D c_d U |U| − ¼ π D² ρ c_i dU/dt, per length, least squares for c_d and c_i (Dütsch et al. 1998, eq. 3).
"""
import csv
import math
import sys

FREQUENCY, DIAMETER, SPEED, DENSITY = 0.2, 1.0, 1.0, 1.0

path = sys.argv[1] if len(sys.argv) > 1 else "results/oscillating-cylinder/series.csv"
with open(path) as file:
    rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
end = float(rows[-1]["time"])
rows = [row for row in rows if float(row["time"]) > end - 2 / FREQUENCY + 1e-9]
sums = [0.0] * 5
forces = []
for row in rows:
    # The force is the mean over the last step of the fluid.
    angle = 2 * math.pi * FREQUENCY * (float(row["time"]) - 0.5 * float(row["fluid_dt"]))
    speed = -SPEED * math.cos(angle)
    acceleration = SPEED * 2 * math.pi * FREQUENCY * math.sin(angle)
    drag = -0.5 * DENSITY * DIAMETER * speed * abs(speed)
    inertia = -0.25 * math.pi * DIAMETER**2 * DENSITY * acceleration
    force = float(row["insert_cylinder_flow_fx"])
    forces.append((force, drag, inertia))
    for k, term in enumerate((drag * drag, drag * inertia, inertia * inertia, drag * force, inertia * force)):
        sums[k] += term
a, b, c, p, q = sums
determinant = a * c - b * b
c_d, c_i = (p * c - q * b) / determinant, (a * q - b * p) / determinant
rest = math.sqrt(sum((f - c_d * d - c_i * i) ** 2 for f, d, i in forces) / sum(f * f for f, _, _ in forces))
print(f"{len(rows)} rows: c_d = {c_d:.3f} (2.09 of Dütsch et al.), c_i = {c_i:.3f} (1.45); {100 * rest:.1f} % of the force is in neither")
