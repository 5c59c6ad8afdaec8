"""Drag, lift and Strouhal number of a run of body.toml or wall.toml: `python3 cases/schaefer-turek/coefficients.py SERIES [FROM [DEPTH]]`, of what
comes after the time FROM (s), 1.5 by default, and of cells DEPTH (m) deep, 0.0025 by default."""
import csv
import sys

DENSITY, SPEED, DIAMETER = 1.0, 1.0, 0.1

path = sys.argv[1] if len(sys.argv) > 1 else "results/schaefer-turek/body/series.csv"
begin, depth = [float(x) for x in sys.argv[2:4] + ["1.5", "0.0025"][len(sys.argv[2:4]) :]]
with open(path) as file:
    rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
who = "cylinder_flow" if "cylinder_flow_fx" in rows[0] else "bodies"
unit = 0.5 * DENSITY * SPEED**2 * DIAMETER * depth
rows = [row for row in rows if float(row["time"]) > begin]
times = [float(row["time"]) for row in rows]
drag, lift = ([float(row[f"{who}_f{axis}"]) / unit for row in rows] for axis in "xy")
pairs = zip(zip(times, lift), zip(times[1:], lift[1:]))
rises = [t - (t - s) * b / (b - a) for (s, a), (t, b) in pairs if a < 0 <= b]
strouhal = DIAMETER / SPEED * (len(rises) - 1) / (rises[-1] - rises[0]) if len(rises) > 1 else float("nan")
print(f"{begin} to {times[-1]} s: drag {min(drag):.4f} to {max(drag):.4f}, lift {min(lift):.4f} to {max(lift):.4f}, Strouhal number {strouhal:.4f}")
