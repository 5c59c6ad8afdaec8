"""Shows a run in ParaView: `paraview --script=view.py` in the folder of the results, or, for a picture without a
screen, `pvbatch view.py picture.png` (`xvfb-run pvbatch ...` if ParaView asks for a display).

The last state, gravity downwards, particles at their true sizes coloured by speed, walls transparent; of a fluid the
speed on the middle plane, behind the particles of the front half.
"""
import glob
import math
import os
import re
import sys
from paraview import simple as pv

here = os.path.dirname(os.path.abspath(__file__)) if "__file__" in globals() else os.getcwd()


def first(*names):
    """The first of the files that exists."""
    return next((p for p in (os.path.join(here, n) for n in names) if os.path.exists(p)), None)


def opened(path):
    """A file of the run; ParaView has several XDMF readers, and only this one shows these files."""
    return pv.XDMFReader(FileNames=[path]) if path.endswith(".xdmf") else pv.OpenDataFile(path)


def vector(key):
    """A vector of the case."""
    return [float(x) for x in re.search(rf"^{key} = \[([^\]]*)\]", case, re.MULTILINE).group(1).split(",")]


def range_of(arrays, name):
    """Zero and the largest magnitude of an array; ParaView colours one value alone badly."""
    array = arrays.GetArray(name)
    largest = array.GetRange(-1 if array.GetNumberOfComponents() > 1 else 0)[1] if array else 0.0
    return 0.0, largest if largest > 0 else 1.0


def colour(display, field, limits, title):
    """Colours by the magnitude of a field, with a bar, by limits that follow the state shown."""
    association, name = field
    # The velocity of cells has another scale than that of points.
    is_own = association == "CELLS"
    pv.ColorBy(display, (association, name, "Magnitude"), separate=is_own)
    table = pv.GetColorTransferFunction(name, display, separate=is_own)
    # Pale and blue for what lies behind the particles.
    table.ApplyPreset("Blues" if is_own else "Viridis (matplotlib)", True)
    table.RescaleTransferFunction(*limits)
    table.AutomaticRescaleRangeMode = "Clamp and update every timestep"
    bar = pv.GetScalarBar(table, view)
    bar.Title, bar.ComponentTitle = title, ""
    bar.WindowLocation = "Upper Right Corner" if is_own else "Lower Right Corner"
    # Zero as 0.0, not 0.0e+00; versions differ in how formats are written.
    bar.RangeLabelFormat = re.sub(r"\.\de", ".2g", bar.RangeLabelFormat)
    display.SetScalarBarVisibility(view, True)


def is_old():
    """Whether ParaView is older than 5.12 and cannot read the VTKHDF files, whose arrays the XDMF files show too."""
    return pv.GetParaViewVersion() < (5, 12) if hasattr(pv, "GetParaViewVersion") else False


with open(os.path.join(here, "case.resolved.toml"), encoding="utf-8") as file:
    case = file.read()
lower, upper, gravity = vector("lower"), vector("upper"), vector("gravity")
middle = [(a + b) / 2 for a, b in zip(lower, upper)]
size = [b - a for a, b in zip(lower, upper)]
pull = math.sqrt(sum(g * g for g in gravity))
up = [-g / pull for g in gravity] if pull > 0 else [0.0, 0.0, 1.0]
# Of the two axes across gravity, that along which the domain is shorter points to the viewer.
steepest = max(range(3), key=lambda a: abs(up[a]))
depth, side = sorted((a for a in range(3) if a != steepest), key=lambda a: (size[a], -a))
toward, aside = [0.0] * 3, [0.0] * 3
toward[depth], aside[side] = -1.0, 1.0

kinds = [".xdmf", ".vtkhdf"] if is_old() else [".vtkhdf", ".xdmf"]
pv.LoadPalette("WhiteBackground")
view = pv.GetActiveViewOrCreate("RenderView")
scene = pv.GetAnimationScene()
files = {name: first(*[name + kind for kind in kinds]) for name in ("particles", "walls")}
# The grid of cells of different widths is shown by the XDMF file alone.
files["fluid"] = first("fluid.xdmf", "fluid.vtkhdf")
sources = {name: opened(path) for name, path in files.items() if path}
scene.UpdateAnimationUsingDataTimeSteps()
scene.GoToLast()
last = max((t for source in sources.values() for t in source.TimestepValues), default=0.0)

if "particles" in sources:
    particles = sources["particles"]
    particles.UpdatePipeline(last)
    data = particles.PointData
    field = next((name for name in ("velocity", "radius") if data.GetArray(name)), "radius")
    title = {"velocity": "speed of particles (m/s)", "radius": "radius (m)"}[field]
    limits = range_of(data, field)
    for path in sorted(glob.glob(os.path.join(here, "shapes", "*.vtp"))):
        shape = int(os.path.splitext(os.path.basename(path))[0])
        chosen = pv.Threshold(Input=particles, Scalars=["POINTS", "shape"])
        # Given above, a 0 would count as not given, and all particles be chosen.
        chosen.LowerThreshold = chosen.UpperThreshold = shape
        display = pv.Show(chosen, view)
        display.SetRepresentationType("3D Glyphs")
        display.GlyphType = "Pipeline Connection"
        display.GlyphType.Input = pv.OpenDataFile(path)
        display.Orient, display.OrientationMode = 1, "Quaternion"
        display.SelectOrientationVectors = "orientation_wxyz"
        display.Scaling, display.ScaleMode, display.SelectScaleArray = 1, "Magnitude", "scale"
        # ParaView guesses a factor from the bounds, which would be the size of a particle of 1 m.
        display.ScaleFactor = 1.0
        colour(display, ("POINTS", field), limits, title)

if "walls" in sources:
    display = pv.Show(sources["walls"], view)
    display.ColorArrayName = ["POINTS", ""]
    display.Opacity, display.DiffuseColor, display.AmbientColor = 0.15, [0.4, 0.4, 0.4], [0.4, 0.4, 0.4]

if "fluid" in sources:
    plane = pv.Slice(Input=sources["fluid"], SliceType="Plane")
    plane.SliceType.Origin, plane.SliceType.Normal = middle, toward
    plane.UpdatePipeline(last)
    names = [plane.CellData.GetArray(k).Name for k in range(plane.CellData.GetNumberOfArrays())]
    field = next((name for name in ("fluid_velocity", "velocity") if name in names), names[0] if names else None)
    display = pv.Show(plane, view)
    # Without light, so that the colours are those of the bar.
    display.Ambient, display.Diffuse = 1.0, 0.0
    if field:
        title = "speed of fluid (m/s)" if "velocity" in field else field
        colour(display, ("CELLS", field), range_of(plane.CellData, field), title)

box = pv.Box(XLength=size[0], YLength=size[1], ZLength=size[2], Center=middle)
display = pv.Show(box, view)
display.SetRepresentationType("Outline")
display.ColorArrayName = ["POINTS", ""]
display.AmbientColor = display.DiffuseColor = [0.6, 0.6, 0.6]
time = pv.AnnotateTime(Format="t = {time:.6g} s")
pv.Show(time, view).WindowLocation = "Upper Left Corner"

# From the front, a little from the right and above, but straight at a slice or a thin layer.
is_flat = "fluid" in sources or size[depth] < 0.1 * max(size)
tilt = (0.0, 0.0) if is_flat else (0.45, 0.3)
direction = [toward[a] + tilt[0] * aside[a] + tilt[1] * up[a] for a in range(3)]
view.CameraFocalPoint, view.CameraViewUp = middle, up
view.CameraPosition = [middle[a] + max(size) * direction[a] for a in range(3)]
pv.ResetCamera(view)
pv.Render(view)
pictures = [name for name in sys.argv[1:] if name.endswith(".png")]
if pictures:
    view.ViewSize = [1200, 900]
    pv.SaveScreenshot(pictures[-1], view)
