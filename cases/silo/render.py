#!/usr/bin/env python3
"""Picture of the silo when filled, half empty and at the end, from the files of a run.

Needs vtk 9.3 or later; draws off screen.
"""

import numpy as np

# Registers the classes that draw, which are found by name alone.
import vtkmodules.vtkRenderingFreeType  # noqa: F401
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkLogger, vtkLookupTable
from vtkmodules.vtkCommonDataModel import vtkCompositeDataSet, vtkPolyData
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkFiltersCore import vtkAppendPolyData, vtkCleanPolyData, vtkFeatureEdges
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkIOHDF import vtkHDFReader
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkRenderingAnnotation import vtkScalarBarActor
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkGlyph3DMapper,
    vtkPolyDataMapper,
    vtkRenderer,
    vtkRenderWindow,
    vtkTextActor,
    vtkWindowToImageFilter,
)

from silo import arguments, read_series, read_silo, time_when_passed

PANEL = (520, 1300)  # pixels
BAR = 130  # pixels for the colour bar
VIEW = (0.45, -1.0, 0.35)  # direction from the silo to the camera
# Samples of the colour map viridis.
COLOURS = [
    (0.267, 0.005, 0.329),
    (0.229, 0.322, 0.546),
    (0.128, 0.567, 0.551),
    (0.369, 0.789, 0.383),
    (0.993, 0.906, 0.144),
]


class Snapshots:
    """The time steps of a VTKHDF file of surfaces or particles."""

    def __init__(self, path):
        if not path.is_file():
            raise SystemExit(f"{path}: not found; run the case first, or give --results")
        self.path = path
        self.reader = vtkHDFReader()
        self.reader.SetFileName(str(path))
        self.reader.UpdateInformation()
        information = self.reader.GetOutputInformation(0)
        key = vtkStreamingDemandDrivenPipeline.TIME_STEPS()
        self.times = np.array(information.Get(key) if information.Has(key) else [0.0])

    def nearest(self, time):
        """The stored time nearest to `time` (s)."""
        return float(self.times[np.abs(self.times - time).argmin()])

    def last_before(self, time):
        """The last stored time up to `time` (s), or the first one."""
        return float(self.times[max(np.searchsorted(self.times, time, side="right") - 1, 0)])

    def at(self, time):
        """The whole data at the last stored time up to `time`; ranks may have written it in pieces."""
        self.reader.UpdateTimeStep(self.last_before(time + 1e-9))
        output = self.reader.GetOutputDataObject(0)
        whole = vtkPolyData()
        if not isinstance(output, vtkCompositeDataSet):
            whole.ShallowCopy(output)
            return whole
        append = vtkAppendPolyData()
        iterator = output.NewIterator()
        while not iterator.IsDoneWithTraversal():
            piece = vtkPolyData()
            piece.ShallowCopy(iterator.GetCurrentDataObject())
            append.AddInputData(piece)
            iterator.GoToNextItem()
        if append.GetNumberOfInputConnections(0) > 0:
            append.Update()
            whole.ShallowCopy(append.GetOutput())
        return whole


def point_array(data, *names):
    """The first of the named point arrays that is there, or None."""
    for name in names:
        array = data.GetPointData().GetArray(name)
        if array is not None:
            return vtk_to_numpy(array)
    return None


def add_point_array(data, name, values):
    array = numpy_to_vtk(np.ascontiguousarray(values, dtype=float), deep=True)
    array.SetName(name)
    data.GetPointData().AddArray(array)


def diameters(data, radius):
    """Diameters (m) of the beads: their own radii if written, or their scales times `radius` (m)."""
    radii = point_array(data, "radius", "bounding_radius")
    if radii is None:
        scales = point_array(data, "scale")
        radii = radius if scales is None else radius * scales
    return np.broadcast_to(2.0 * (radii[:, 0] if np.ndim(radii) == 2 else radii), data.GetNumberOfPoints())


def speeds(data, path):
    """Speeds (m/s) of the beads."""
    velocities = point_array(data, "velocity", "velocities")
    if velocities is None:
        raise SystemExit(f"{path}: the particles have no array velocity")
    return np.linalg.norm(velocities, axis=1)


def colour_map(fastest):
    """Colours for speeds from 0 to `fastest` (m/s)."""
    table = vtkLookupTable()
    table.SetNumberOfTableValues(256)
    table.SetRange(0.0, fastest)
    shares = np.linspace(0.0, 1.0, len(COLOURS))
    for i in range(256):
        rgb = [np.interp(i / 255, shares, channel) for channel in zip(*COLOURS)]
        table.SetTableValue(i, *rgb, 1.0)
    table.Build()
    return table


def beads_actor(data, table):
    sphere = vtkSphereSource()
    sphere.SetRadius(0.5)
    sphere.SetThetaResolution(20)
    sphere.SetPhiResolution(14)
    mapper = vtkGlyph3DMapper()
    mapper.SetInputData(data)
    mapper.SetSourceConnection(sphere.GetOutputPort())
    mapper.SetScaleModeToScaleByMagnitude()
    mapper.SetScaleArray("diameter_of_glyph")
    mapper.SetScalarModeToUsePointFieldData()
    mapper.SelectColorArray("speed")
    mapper.SetLookupTable(table)
    mapper.SetScalarRange(table.GetRange())
    actor = vtkActor()
    actor.SetMapper(mapper)
    return actor


def wall_actors(data):
    """Transparent faces, and the edges between them."""
    faces = vtkPolyDataMapper()
    faces.SetInputData(data)
    faces.ScalarVisibilityOff()
    face_actor = vtkActor()
    face_actor.SetMapper(faces)
    face_actor.GetProperty().SetColor(0.55, 0.62, 0.70)
    face_actor.GetProperty().SetOpacity(0.12)

    clean = vtkCleanPolyData()
    clean.SetInputData(data)
    edges = vtkFeatureEdges()
    edges.SetInputConnection(clean.GetOutputPort())
    edges.SetFeatureAngle(5.0)
    edges.ColoringOff()
    lines = vtkPolyDataMapper()
    lines.SetInputConnection(edges.GetOutputPort())
    lines.ScalarVisibilityOff()
    line_actor = vtkActor()
    line_actor.SetMapper(lines)
    line_actor.GetProperty().SetColor(0.25, 0.28, 0.32)
    line_actor.GetProperty().SetLineWidth(1.5)
    return face_actor, line_actor


def label(text, size, position):
    actor = vtkTextActor()
    actor.SetInput(text)
    actor.GetTextProperty().SetFontSize(size)
    actor.GetTextProperty().SetColor(0.1, 0.1, 0.1)
    actor.SetPosition(*position)
    return actor


def aim(renderer, bounds):
    """Looks at the whole of `bounds` (m) in parallel projection."""
    lower, upper = np.array(bounds[::2]), np.array(bounds[1::2])
    centre, direction = 0.5 * (lower + upper), np.array(VIEW) / np.linalg.norm(VIEW)
    right = np.cross((0, 0, 1), direction)
    right /= np.linalg.norm(right)
    extents = [np.abs(axis) @ (upper - lower) for axis in (right, np.cross(direction, right))]
    camera = renderer.GetActiveCamera()
    camera.ParallelProjectionOn()
    camera.SetFocalPoint(*centre)
    camera.SetPosition(*(centre + 5.0 * np.linalg.norm(upper - lower) * direction))
    camera.SetViewUp(0, 0, 1)
    # The scale is half the height in view; a margin leaves room for the label.
    camera.SetParallelScale(0.5 * 1.08 * max(extents[1], extents[0] * PANEL[1] / PANEL[0]))
    renderer.ResetCameraClippingRange()


def colour_bar(table):
    bar = vtkScalarBarActor()
    bar.SetLookupTable(table)
    bar.SetTitle("speed (m/s)\n ")
    bar.SetNumberOfLabels(5)
    bar.SetLabelFormat("%.1f" if "%" in bar.GetLabelFormat() else "{:.1f}")
    bar.UnconstrainedFontSizeOn()
    for text in (bar.GetTitleTextProperty(), bar.GetLabelTextProperty()):
        text.SetColor(0.1, 0.1, 0.1)
        text.SetFontSize(18)
        text.BoldOff()
        text.ItalicOff()
        text.ShadowOff()
    bar.SetPosition(0.1, 0.25)
    bar.SetWidth(0.85)
    bar.SetHeight(0.5)
    return bar


def default_times(silo, snapshots):
    """The last snapshot with the plate, the one nearest to half of the beads passed, the last one."""
    series = read_series(silo)
    half = time_when_passed(series, silo.beads / 2)
    times = [snapshots.last_before(silo.removal)]
    if half is not None:
        times.append(snapshots.nearest(half))
    return sorted({*times, float(snapshots.times[-1])})


def draw(silo, particles, walls, times, path):
    panels = [(time, particles.at(time), walls.at(time)) for time in times]
    fastest = 0.0
    for _, beads, _ in panels:
        add_point_array(beads, "diameter_of_glyph", diameters(beads, silo.radius))
        speed = speeds(beads, particles.path)
        add_point_array(beads, "speed", speed)
        fastest = max(fastest, speed.max(initial=0.0))
    table = colour_map(max(fastest, 1e-3))

    # All panels show the same space, so that they can be compared.
    shown = [data for _, *both in panels for data in both if data.GetNumberOfPoints() > 0]
    boxes = np.array([data.GetBounds() for data in shown])
    bounds = np.where(np.arange(6) % 2 == 0, boxes.min(axis=0), boxes.max(axis=0))

    window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    width = len(panels) * PANEL[0] + BAR
    window.SetSize(width, PANEL[1])
    for k, (time, beads, surfaces) in enumerate(panels):
        renderer = vtkRenderer()
        renderer.SetViewport(k * PANEL[0] / width, 0, (k + 1) * PANEL[0] / width, 1)
        renderer.SetBackground(1, 1, 1)
        renderer.SetUseDepthPeeling(1)
        renderer.SetUseFXAA(True)
        renderer.AddActor(beads_actor(beads, table))
        for actor in wall_actors(surfaces):
            renderer.AddActor(actor)
        since = f"{time - silo.removal:+.2f} s since the opening"
        renderer.AddViewProp(label(f"t = {time:.2f} s\n{since}", 22, (18, PANEL[1] - 70)))
        window.AddRenderer(renderer)
        aim(renderer, bounds)
    side = vtkRenderer()
    side.SetViewport(1 - BAR / width, 0, 1, 1)
    side.SetBackground(1, 1, 1)
    side.AddViewProp(colour_bar(table))
    window.AddRenderer(side)

    window.Render()
    image = vtkWindowToImageFilter()
    image.SetInput(window)
    image.ReadFrontBufferOff()
    writer = vtkPNGWriter()
    writer.SetFileName(str(path))
    writer.SetInputConnection(image.GetOutputPort())
    writer.Write()


def main():
    parser = arguments(__doc__.splitlines()[0], "silo.png")
    parser.add_argument("--times", type=float, nargs="+", help="times to draw (s), one panel each")
    options = parser.parse_args()
    # Without a display vtk warns before it finds another way to draw.
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)
    silo = read_silo(options.case, options.results)
    particles = Snapshots(silo.results / "particles.vtkhdf")
    walls = Snapshots(silo.results / "walls.vtkhdf")
    wanted = options.times or default_times(silo, particles)
    times = [particles.nearest(time) for time in wanted]
    path = options.output or silo.results / "silo.png"
    draw(silo, particles, walls, times, path)
    print(f"times {', '.join(f'{time:g}' for time in times)} s in {path}")


if __name__ == "__main__":
    main()
