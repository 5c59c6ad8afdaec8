"""Shows a run in ParaView: run with `paraview --script=view.py` or from Tools > Python Shell."""
import glob
import os
from paraview import simple as pv

here = os.path.dirname(os.path.abspath(__file__)) if "__file__" in globals() else os.getcwd()


def first(*names):
    """The first of the files that exists."""
    return next((p for p in (os.path.join(here, n) for n in names) if os.path.exists(p)), None)


def opened(path):
    """A file of the run; ParaView has several XDMF readers, and only this one shows these files."""
    return pv.XDMFReader(FileNames=[path]) if path.endswith(".xdmf") else pv.OpenDataFile(path)


# ParaView before 5.12 cannot read the VTKHDF files: the XDMF files hold the same arrays by reference.
old = pv.GetParaViewVersion() < (5, 12) if hasattr(pv, "GetParaViewVersion") else False
names = ["particles.xdmf", "particles.vtkhdf"] if old else ["particles.vtkhdf", "particles.xdmf"]
particles = opened(first(*names))
view = pv.GetActiveViewOrCreate("RenderView")
for path in sorted(glob.glob(os.path.join(here, "shapes", "*.vtp"))):
    shape = int(os.path.splitext(os.path.basename(path))[0])
    chosen = pv.Threshold(Input=particles, Scalars=["POINTS", "shape"], LowerThreshold=shape, UpperThreshold=shape)
    display = pv.Show(chosen, view)
    display.SetRepresentationType("3D Glyphs")
    display.GlyphType = "Pipeline Connection"
    display.GlyphType.Input = pv.OpenDataFile(path)
    display.Orient, display.OrientationMode = 1, "Quaternion"
    display.SelectOrientationVectors = "orientation_wxyz"
    display.Scaling, display.ScaleMode, display.SelectScaleArray = 1, "Magnitude", "scale"
    pv.ColorBy(display, ("POINTS", "velocity", "Magnitude"))
walls = first(*[n.replace("particles", "walls") for n in names])
if walls:
    shown = pv.Show(opened(walls), view)
    shown.Opacity = 0.2
pv.ResetCamera()
pv.Render()
