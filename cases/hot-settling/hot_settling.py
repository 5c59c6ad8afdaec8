"""Two hot discs that settle, with and without natural convection: `python3 cases/hot-settling/hot_settling.py` runs what is missing,
prints where the discs are and how warm, and draws hot-settling.png."""
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
import sweep

TIMES = (6, 12, 18, 24)


def main():
    text = (HERE / "pair.toml").read_text()
    folders = {name: sweep.RESULTS / "hot-settling" / name for name in ("cold", "warm")}
    cases = []
    for name, folder in folders.items():
        case = text.replace('"results/hot-settling/pair"', f'"{folder / "run"}"')
        # Without: the same but for the weight of what is warm.
        cases.append((case.replace("expansion = 4e-3", "expansion = 0") if name == "cold" else case, folder))
    sweep.run_all(cases)
    import h5py
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np

    figure, axes = plt.subplots(1, 2 * len(TIMES), figsize=(10, 6.4), sharey=True)
    for row, (name, folder) in enumerate(folders.items()):
        with h5py.File(folder / "run/particles.vtkhdf") as file:
            group = file["VTKHDF"]
            times, offsets = group["Steps/Values"][:], group["Steps/PointOffsets"][:]
            points, heat, ids = group["Points"][:], group["PointData/temperature"][:], group["PointData/id"][:]
        with h5py.File(folder / "run/fluid.vtkhdf") as file:
            of_fluid, field = file["VTKHDF/Steps/Values"][:], file["VTKHDF/CellData/temperature"][:]
        for column, time in enumerate(TIMES):
            axis = axes[row * len(TIMES) + column]
            state = int(np.argmin(abs(times - time)))
            first = offsets[state]
            order = np.argsort(ids[first : first + 2])
            at, warm = points[first : first + 2][order], heat[first : first + 2][order]
            axis.imshow(field[int(np.argmin(abs(of_fluid - time)))][:, 0], origin="lower", extent=[-2, 2, 0, 24], vmin=300, vmax=325, cmap="inferno")
            for place in at:
                axis.add_patch(plt.Circle((place[0], place[2]), 0.5, color="0.8"))
            axis.set_title(f"{time}", fontsize=9)
            axis.set_xticks([])
            print(f"{name} t = {times[state]:g}: heights {at[0][2]:.2f} {at[1][2]:.2f}, temperatures {warm[0]:.1f} {warm[1]:.1f} K")
    figure.text(0.3, 0.96, "without natural convection", ha="center")
    figure.text(0.72, 0.96, "with it", ha="center")
    figure.savefig(HERE / "hot-settling.png", dpi=70, bbox_inches="tight")


if __name__ == "__main__":
    main()
