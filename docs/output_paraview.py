"""What docs/output.md does by hand, for ParaView's own Python:
xvfb-run pvpython output_paraview.py NAME.hdf.series TIME PICTURE.png"""
import os
import sys
from paraview.simple import *

series, time, picture = sys.argv[1], float(sys.argv[2]), sys.argv[3]
view = CreateRenderView(ViewSize=[900, 800], OrientationAxesVisibility=0)
view.ViewTime = time

bodies = OpenDataFile(series)
spheres = Threshold(bodies, Scalars=["POINTS", "shape"], LowerThreshold=0, UpperThreshold=0)
glyphs = Show(spheres, view)
glyphs.SetRepresentationType("3D Glyphs")
glyphs.GlyphType = "Sphere"
glyphs.Scaling = 1
glyphs.ScaleMode = "Vector Components"
glyphs.SelectScaleArray = "size"
glyphs.ScaleFactor = 1
ColorBy(glyphs, ("POINTS", "velocity", "Magnitude"))
glyphs.Opacity = 0.25

surfaces = series.replace(".hdf.series", "_surfaces.hdf.series")
if os.path.exists(surfaces):  # of --output-surfaces
    faces = Show(OpenDataFile(surfaces), view)
    ColorBy(faces, ("CELLS", "velocity", "Magnitude"))
    faces.Opacity = 0.25

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
