"""The cylinder in a channel for OpenFOAM (icoFoam, version 1912): `python3 cases/schaefer-turek/openfoam.py FOLDER [N [STEP [END]]]` writes the case
with N cells along a quarter of the cylinder (40), a time step (s) and an end (s); then, in FOLDER, `blockMesh` and `icoFoam`. With the argument
`--coefficients FOLDER` it prints drag, lift and Strouhal number of the run, from 1.5 s before its end on."""
import math
import sys
from pathlib import Path

DIAMETER, SPEED, DEPTH = 0.1, 1.0, 0.01
HEADER = 'FoamFile {{ version 2.0; format ascii; class {}; object {}; }}\n'


def mesh(n):
    """blockMeshDict: rings of cells from the cylinder to a square about it, and a grid of blocks around that."""
    xs, ys = [0.0, 0.1, 0.3, 2.2], [0.0, 0.1, 0.3, 0.41]
    corners = [(x, y) for y in ys for x in xs]
    r = DIAMETER / 2 / math.sqrt(2)
    corners += [(0.2 + a * r, 0.2 + b * r) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    count = len(corners)
    vertices = "\n".join(f"({x} {y} {z})" for z in (0, DEPTH) for x, y in corners)
    outer = [5, 6, 10, 9]
    blocks, cells = [], 0

    def block(a, b, c, d, nx, ny, grading):
        nonlocal cells
        top = [v + count for v in (a, b, c, d)]
        blocks.append(f"hex ({a} {b} {c} {d} {' '.join(map(str, top))}) ({nx} {ny} 1) simpleGrading ({grading})")
        cells += nx * ny

    # As wide as the cells of the square's edge, wider downstream.
    along = {0: n // 2, 1: n, 2: 5 * n}
    across = {0: n // 2, 1: n, 2: n // 2}
    for j in range(3):
        for i in range(3):
            if (i, j) == (1, 1):
                continue
            a = 4 * j + i
            block(a, a + 1, a + 5, a + 4, along[i], across[j], "4 1 1" if i == 2 else "1 1 1")
    for k in range(4):
        m = (k + 1) % 4
        block(16 + m, 16 + k, outer[k], outer[m], n, n * 3 // 4, "1 3 1")
    edges = ""
    for k in range(4):
        m, middle = (k + 1) % 4, (k - 1) * math.pi / 2
        x, y = 0.2 + DIAMETER / 2 * math.cos(middle), 0.2 + DIAMETER / 2 * math.sin(middle)
        edges += f"arc {16 + k} {16 + m} ({x} {y} 0)\narc {16 + k + count} {16 + m + count} ({x} {y} {DEPTH})\n"
    side = lambda pairs: " ".join(f"({a} {b} {b + count} {a + count})" for a, b in pairs)
    patches = {
        "inlet": ("patch", [(0, 4), (4, 8), (8, 12)]),
        "outlet": ("patch", [(3, 7), (7, 11), (11, 15)]),
        "walls": ("wall", [(0, 1), (1, 2), (2, 3), (12, 13), (13, 14), (14, 15)]),
        "cylinder": ("wall", [(16 + k, 16 + (k + 1) % 4) for k in range(4)]),
    }
    boundary = "\n".join(f"{name} {{ type {kind}; faces ({side(pairs)}); }}" for name, (kind, pairs) in patches.items())
    text = (
        f"scale 1;\nvertices\n(\n{vertices}\n);\nblocks\n(\n" + "\n".join(blocks) + f"\n);\nedges\n(\n{edges});\n"
        f"boundary\n(\n{boundary}\n);\ndefaultPatch {{ name sides; type empty; }}\n"
    )
    return text, cells


def parabola(n):
    """Velocities of the faces of the inlet, in the order of its blocks."""
    heights = [y0 + (y1 - y0) * (j + 0.5) / m for y0, y1, m in ((0, 0.1, n // 2), (0.1, 0.3, n), (0.3, 0.41, n // 2)) for j in range(m)]
    return f"{len(heights)} (" + " ".join(f"({6 * y * (0.41 - y) / 0.41**2} 0 0)" for y in heights) + ")"


def write(folder, n, step, end):
    """The files of a case."""
    blocks, cells = mesh(n)
    fields = {
        "0/U": (
            "volVectorField",
            "dimensions [0 1 -1 0 0 0 0]; internalField uniform (1 0.3 0);\nboundaryField {\n"
            f"inlet {{ type fixedValue; value nonuniform List<vector> {parabola(n)}; }}\n"
            "outlet { type zeroGradient; } walls { type noSlip; } cylinder { type noSlip; } sides { type empty; } }\n",
        ),
        "0/p": (
            "volScalarField",
            "dimensions [0 2 -2 0 0 0 0]; internalField uniform 0;\nboundaryField { inlet { type zeroGradient; }"
            " outlet { type fixedValue; value uniform 0; } walls { type zeroGradient; } cylinder { type zeroGradient; } sides { type empty; } }\n",
        ),
    }
    dictionaries = {
        "system/blockMeshDict": blocks,
        "constant/transportProperties": "transportModel Newtonian;\nnu [0 2 -1 0 0 0 0] 1e-3;\n",
        "system/controlDict": (
            f"application icoFoam; startFrom startTime; startTime 0; stopAt endTime; endTime {end}; deltaT {step};\n"
            f"writeControl runTime; writeInterval {end}; writePrecision 10; timePrecision 8; runTimeModifiable no;\n"
            "functions { coefficients { type forceCoeffs; libs (forces); patches (cylinder); rho rhoInf; rhoInf 1; writeControl timeStep;"
            f" writeInterval 1; log no; dragDir (1 0 0); liftDir (0 1 0); pitchAxis (0 0 1); CofR (0.2 0.2 0); magUInf {SPEED};"
            f" lRef {DIAMETER}; Aref {DIAMETER * DEPTH}; }} }}\n"
        ),
        "system/fvSchemes": (
            "ddtSchemes { default backward; } gradSchemes { default Gauss linear; } divSchemes { default none; div(phi,U) Gauss linear; }\n"
            "laplacianSchemes { default Gauss linear corrected; } interpolationSchemes { default linear; } snGradSchemes { default corrected; }\n"
        ),
        "system/fvSolution": (
            "solvers { p { solver GAMG; smoother GaussSeidel; tolerance 1e-9; relTol 0.01; } pFinal { $p; relTol 1e-3; }\n"
            "U { solver smoothSolver; smoother symGaussSeidel; tolerance 1e-9; relTol 0; } }\n"
            "PISO { nCorrectors 2; nNonOrthogonalCorrectors 1; }\n"
        ),
    }
    for name, text in dictionaries.items():
        fields[name] = ("dictionary", text)
    for name, (kind, text) in fields.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(HEADER.format(kind, path.name) + text)
    print(f"{cells} cells in {folder}")


def coefficients(folder):
    """Prints what a run found."""
    path = sorted(folder.glob("postProcessing/coefficients/*/coefficient*.dat"))[-1]
    lines = path.read_text().splitlines()
    names = next(line for line in reversed(lines) if line.startswith("# Time")).lstrip("# ").split()
    rows = [dict(zip(names, map(float, line.split()))) for line in lines if not line.startswith("#")]
    rows = [row for row in rows if row["Time"] > rows[-1]["Time"] - 1.5]
    drag, lift, times = ([row[key] for row in rows] for key in ("Cd", "Cl", "Time"))
    pairs = zip(zip(times, lift), zip(times[1:], lift[1:]))
    rises = [t - (t - s) * b / (b - a) for (s, a), (t, b) in pairs if a < 0 <= b]
    strouhal = DIAMETER / SPEED * (len(rises) - 1) / (rises[-1] - rises[0])
    print(f"drag {min(drag):.4f} to {max(drag):.4f}, lift {min(lift):.4f} to {max(lift):.4f}, Strouhal number {strouhal:.4f}")


if __name__ == "__main__":
    if sys.argv[1] == "--coefficients":
        coefficients(Path(sys.argv[2]))
    else:
        given = [float(x) for x in sys.argv[2:]] + [40, 5e-4, 5][len(sys.argv[2:]) :]
        write(Path(sys.argv[1]), int(given[0]), *given[1:])
