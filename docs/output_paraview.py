"""What docs/output.md does by hand, for ParaView's own Python:
xvfb-run pvpython output_paraview.py NAME.hdf.series TIME PICTURE.png"""
import sys
from paraview.simple import *

series, time, picture = sys.argv[1], float(sys.argv[2]), sys.argv[3]
view = CreateRenderView(ViewSize=[900, 800], OrientationAxesVisibility=0)
view.ViewTime = time

bodies = OpenDataFile(series)
for number, form in ((0, "Sphere"), (1, "Box")):
    only = Threshold(bodies, Scalars=["POINTS", "shape"], LowerThreshold=number,
                     UpperThreshold=number)
    glyphs = Show(only, view)
    glyphs.SetRepresentationType("3D Glyphs")
    glyphs.GlyphType = form
    glyphs.Scaling = 1
    glyphs.ScaleMode = "Vector Components"
    glyphs.SelectScaleArray = "size"
    glyphs.ScaleFactor = 1
    glyphs.Orient = 1
    glyphs.OrientationMode = "Quaternion"
    glyphs.SelectOrientationVectors = "orientation"
    ColorBy(glyphs, ("POINTS", "velocity", "Magnitude"))
    glyphs.Opacity = 0.25

contacts = OpenDataFile(series.replace(".hdf.series", "_contacts.hdf.series"))
tubes = Tube(ExtractSurface(CellDatatoPointData(contacts)), Scalars=["POINTS", "normal_force"],
             Radius=0.02, VaryRadius="By Scalar", RadiusFactor=10)
ColorBy(Show(tubes, view), ("POINTS", "normal_force"))
Render(view)
camera = GetActiveCamera()
camera.SetViewUp(0, 0, 1)
camera.SetFocalPoint(0, 2, 7.3)
camera.SetPosition(4, -42, 13)
camera.SetViewAngle(24)
SaveScreenshot(picture, view)
