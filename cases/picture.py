"""Picture of the bodies of runs, one panel each: `python cases/picture.py OUT.png RUN[@TIME] ... [--from X,Y,Z]`, with
the Python that scripts/python-environment prints. A RUN is an output directory; the last state, if no time (s) is given.
Bodies are coloured by speed, or by what --by names, on one scale for all panels. With --surface FIELD=VALUE the panels
show where a field of the fluid has a value, such as void_fraction=0.75, instead of the bodies."""
import argparse
from pathlib import Path

import h5py
import numpy as np

# Registers the classes that draw, which are found by name alone.
import vtkmodules.vtkRenderingFreeType  # noqa: F401
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkLogger, vtkLookupTable
from vtkmodules.vtkCommonDataModel import vtkPolyData, vtkRectilinearGrid
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkFiltersCore import vtkContourFilter
from vtkmodules.vtkIOHDF import vtkHDFReader
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader
from vtkmodules.vtkRenderingCore import (
    vtkActor, vtkGlyph3DMapper, vtkPolyDataMapper, vtkRenderer, vtkRenderWindow, vtkTextActor, vtkWindowToImageFilter,
)

COLOURS = [(0.27, 0.00, 0.33), (0.23, 0.32, 0.55), (0.13, 0.57, 0.55), (0.37, 0.79, 0.38), (0.99, 0.91, 0.14)]


def state(run, time, by):
    """The stored particles of a run nearest to a time (s), that time, and what colours them."""
    reader = vtkHDFReader()
    reader.SetFileName(str(run / "particles.vtkhdf"))
    reader.UpdateInformation()
    times = np.array(reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS()))
    time = times[-1] if time is None else times[np.abs(times - time).argmin()]
    reader.UpdateTimeStep(float(time))
    data = vtkPolyData()
    data.ShallowCopy(reader.GetOutput())
    if by == "height":
        colour = vtk_to_numpy(data.GetPoints().GetData())[:, 2].astype(float)
    else:
        colour = vtk_to_numpy(data.GetPointData().GetArray("velocity" if by == "speed" else by)).astype(float)
        colour = np.linalg.norm(colour, axis=1) if colour.ndim > 1 else colour
    array = numpy_to_vtk(colour, deep=True)
    array.SetName("colour")
    data.GetPointData().AddArray(array)
    return data, float(time), colour


def bodies(run, data, table):
    """An actor for the bodies of each shape."""
    files = sorted((run / "shapes").glob("*.vtp"), key=lambda file: int(file.stem))
    mapper = vtkGlyph3DMapper()
    mapper.SetInputData(data)
    for number, file in enumerate(files):
        surface = vtkXMLPolyDataReader()
        surface.SetFileName(str(file))
        surface.Update()
        mapper.SetSourceData(number, surface.GetOutput())
    if len(files) > 1:
        mapper.SourceIndexingOn()
        mapper.SetSourceIndexArray("shape")
    mapper.SetOrientationArray("orientation_wxyz")
    mapper.SetOrientationModeToQuaternion()
    mapper.SetScaleArray("scale")
    mapper.SetScaleModeToScaleByMagnitude()
    mapper.SetScalarModeToUsePointFieldData()
    mapper.SelectColorArray("colour")
    mapper.SetLookupTable(table)
    mapper.UseLookupTableScalarRangeOn()
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetSpecular(0.1)
    return actor


def surface(run, time, field, value):
    """An actor for the surface on which a field of the fluid has a value nearest to a time (s), that time, and the bounds of
    the grid."""
    with h5py.File(run / "fluid.vtkhdf") as file:
        group = file["VTKHDF"]
        times = group["Steps/Values"][:]
        step = len(times) - 1 if time is None else np.abs(times - time).argmin()
        # Cells z, y, x; the outermost are repeated at the ends of the grid, which may be stretched.
        cells = np.pad(group["CellData"][field][step], 1, mode="edge")
        nodes = [file["grid"][axis][:] for axis in "xyz"]
    grid = vtkRectilinearGrid()
    grid.SetDimensions(*cells.shape[::-1])
    for put, x in zip((grid.SetXCoordinates, grid.SetYCoordinates, grid.SetZCoordinates), nodes):
        put(numpy_to_vtk(np.concatenate([x[:1], (x[1:] + x[:-1]) / 2, x[-1:]]), deep=True))
    grid.GetPointData().SetScalars(numpy_to_vtk(cells.ravel(), deep=True))
    contour = vtkContourFilter()
    contour.SetInputData(grid)
    contour.SetValue(0, value)
    mapper = vtkPolyDataMapper()
    mapper.SetInputConnection(contour.GetOutputPort())
    mapper.ScalarVisibilityOff()
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(0.85, 0.62, 0.30)
    return actor, float(times[step]), [end for x in nodes for end in (x[0], x[-1])]


def panel(actor, text, direction, bounds, aspect):
    """One run seen from a direction, at the scale of all."""
    renderer = vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    renderer.AddActor(actor)
    label = vtkTextActor()
    label.SetInput(text)
    label.GetTextProperty().SetColor(0, 0, 0)
    label.GetTextProperty().SetFontSize(20)
    label.SetPosition(12, 10)
    renderer.AddActor(label)
    low, high = np.array(bounds[::2]), np.array(bounds[1::2])
    direction = np.array(direction) / np.linalg.norm(direction)
    up = np.array([0.0, 0.0, 1.0]) if abs(direction[2]) < 0.99 else np.array([0.0, 1.0, 0.0])
    right = np.cross(up, direction) / np.linalg.norm(np.cross(up, direction))
    above = np.cross(direction, right)
    camera = renderer.GetActiveCamera()
    camera.ParallelProjectionOn()
    camera.SetFocalPoint(*(low + high) / 2)
    camera.SetPosition(*((low + high) / 2 + direction * 5 * np.linalg.norm(high - low)))
    camera.SetViewUp(*up)
    width, height = np.abs(right) @ (high - low), np.abs(above) @ (high - low)
    camera.SetParallelScale(0.54 * max(height, width / aspect))
    renderer.ResetCameraClippingRange()
    return renderer


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path)
    parser.add_argument("run", nargs="+", help="RUN[@TIME][=LABEL]")
    parser.add_argument("--from", dest="direction", default="0.5,-1,0.35", help="direction towards the eye: x,y,z")
    parser.add_argument("--by", default="speed", help="colour: speed, height, or an array such as id or coordination")
    parser.add_argument("--range", help="LOW,HIGH of the colours; 0 and nearly the largest by default")
    parser.add_argument("--surface", metavar="FIELD=VALUE", help="draw a surface of the fluid, not the bodies")
    parser.add_argument("--size", default="480,640", help="pixels of a panel")
    parser.add_argument("--columns", type=int, help="panels beside each other; all by default")
    options = parser.parse_args()
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    direction = [float(x) for x in options.direction.split(",")]
    width, height = (int(x) for x in options.size.split(","))
    shown = []
    for text in options.run:
        text, _, label = text.partition("=")
        run, _, time = text.partition("@")
        shown.append((Path(run), float(time) if time else None, label))
    if options.surface:
        field, _, value = options.surface.partition("=")
        panels = [(surface(run, time, field, float(value)), label) for run, time, label in shown]
        panels = [(actor, label or f"t = {time:.3g} s", box) for (actor, time, box), label in panels]
    else:
        panels = coloured(shown, options.by, [float(x) for x in options.range.split(",")] if options.range else None)
    boxes = np.array([box for *_, box in panels])
    bounds = np.where(np.arange(6) % 2 == 0, boxes.min(axis=0), boxes.max(axis=0))
    columns = options.columns or len(panels)
    rows = -(-len(panels) // columns)
    window = vtkRenderWindow()
    window.OffScreenRenderingOn()
    window.SetMultiSamples(4)
    window.SetSize(columns * width, rows * height)
    for k, (actor, label, _) in enumerate(panels):
        renderer = panel(actor, label, direction, bounds, width / height)
        column, row = k % columns, rows - 1 - k // columns
        renderer.SetViewport(column / columns, row / rows, (column + 1) / columns, (row + 1) / rows)
        window.AddRenderer(renderer)
    window.Render()
    grab = vtkWindowToImageFilter()
    grab.SetInput(window)
    writer = vtkPNGWriter()
    writer.SetFileName(str(options.out))
    writer.SetInputConnection(grab.GetOutputPort())
    writer.Write()


def coloured(shown, by, ends):
    """Actors, labels and bounds of the bodies of runs at times, coloured on one scale between two ends."""
    states = [(run, *state(run, time, by), label) for run, time, label in shown]
    if ends is None:
        high = max(np.quantile(colour, 0.98) for *_, colour, _ in states if len(colour))
        ends = [0, max(high, 1e-9)]
    table = vtkLookupTable()
    table.SetRange(*ends)
    table.SetNumberOfTableValues(256)
    for k in range(256):
        rgb = [np.interp(k / 255, np.linspace(0, 1, len(COLOURS)), c) for c in zip(*COLOURS)]
        table.SetTableValue(k, *rgb, 1)
    print(f"{by} from {ends[0]:.3g} to {ends[1]:.3g}")
    return [(bodies(run, data, table), label or f"t = {time:.3g} s", data.GetBounds()) for run, data, time, _, label in states]


if __name__ == "__main__":
    main()
