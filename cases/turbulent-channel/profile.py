"""Mean velocity of a turbulent channel beside that of Moser, Kim & Mansour (1999): `python3 cases/turbulent-channel/profile.py RESULTS`."""
import csv
import sys
from pathlib import Path

import h5py
import numpy as np

REYNOLDS = 180

results = Path(sys.argv[1] if len(sys.argv) > 1 else "results/turbulent-channel")
with h5py.File(results / "fluid-mean.vtkhdf") as file:
    velocity = file["VTKHDF/CellData/velocity"][-1, :, :, :, 0].mean(axis=(1, 2))
    nodes = file["VTKHDF/ZCoordinates"][:]
z, width = 0.5 * (nodes[1:] + nodes[:-1]), np.diff(nodes)
half = len(z) // 2
print(f"bulk {(velocity * width).sum() / 2:.3f}, middle {velocity[half - 1 : half + 1].mean():.3f}, halves differ by up to "
      f"{np.abs(velocity[:half] - velocity[:half - 1 : -1]).max():.3f}")
y = REYNOLDS * (1 + z[:half])
u = 0.5 * (velocity[:half] + velocity[: half - 1 : -1])
with open(Path(__file__).parent / "mkm180.csv") as file:
    rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(line for line in file if line[0] != "#")]
off = []
for row in rows:
    found = np.interp(row["y"], y, u)
    off.append(found / row["u"] - 1)
    print(f"y+ {row['y']:8.2f}  {row['u']:7.3f}  here {found:7.3f}  {100 * off[-1]:+.1f} %")
print(f"largest {100 * max(off, key=abs):+.1f} %, rms {100 * np.sqrt(np.mean(np.square(off))):.1f} %")
