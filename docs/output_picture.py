"""Draws an output with VTK: python3 output_picture.py NAME_0000001000.hdf PICTURE.png
Spheres; all else if the run was given --output-surfaces."""
import os
import sys
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401, makes windows
from vtkmodules.vtkCommonCore import vtkLookupTable
from vtkmodules.vtkCommonDataModel import vtkDataObject
from vtkmodules.vtkFiltersCore import vtkCellDataToPointData, vtkThreshold, vtkTubeFilter
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkIOHDF import vtkHDFReader
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkRenderingCore import (
    vtkActor, vtkGlyph3DMapper, vtkPolyDataMapper, vtkRenderer, vtkRenderWindow,
    vtkWindowToImageFilter)

bodies, picture = sys.argv[1:3]
base, step = bodies.rsplit("_", 1)
renderer = vtkRenderer()
renderer.SetBackground(1, 1, 1)


def read(file):
    reader = vtkHDFReader()
    reader.SetFileName(file)
    return reader


def only(source, array, value, of=vtkDataObject.FIELD_ASSOCIATION_POINTS):
    """The points, or cells, whose array has this value."""
    part = vtkThreshold()
    part.SetInputConnection(source.GetOutputPort())
    part.SetInputArrayToProcess(0, 0, 0, of, array)
    part.SetThresholdFunction(vtkThreshold.THRESHOLD_BETWEEN)
    part.SetLowerThreshold(value)
    part.SetUpperThreshold(value)
    return part


def show(mapper, colour, high):
    mapper.SelectColorArray(colour)
    mapper.SetScalarRange(0, high)
    colours = vtkLookupTable()
    colours.SetHueRange(0.62, 0.0)
    colours.SetVectorModeToMagnitude()
    mapper.SetLookupTable(colours)
    mapper.UseLookupTableScalarRangeOff()
    actor = vtkActor()
    actor.SetMapper(mapper)
    renderer.AddActor(actor)
    return actor


def show_bodies(mapper, fixed):
    actor = show(mapper, "velocity", fastest)
    actor.GetProperty().SetOpacity(0.25)
    if fixed:
        mapper.ScalarVisibilityOff()
        actor.GetProperty().SetColor(0.6, 0.6, 0.6)


everything = read(bodies)
everything.Update()
speeds = everything.GetOutput().GetPointData().GetArray("velocity").GetRange(-1)
fastest = max(speeds[1], 1e-12)
ball = vtkSphereSource()
ball.SetThetaResolution(24)
ball.SetPhiResolution(16)
surfaces = f"{base}_surfaces_{step}"
for fixed in (0, 1):
    spheres = only(everything, "shape", 0)
    shown = only(spheres, "fixed", fixed)
    glyphs = vtkGlyph3DMapper()
    glyphs.SetInputConnection(shown.GetOutputPort())
    glyphs.SetSourceConnection(ball.GetOutputPort())
    glyphs.SetScaleArray("size")
    glyphs.SetScaleModeToScaleByVectorComponents()
    glyphs.SetScalarModeToUsePointFieldData()
    show_bodies(glyphs, fixed)
    if os.path.exists(surfaces):
        file = read(surfaces)
        some = only(file, "fixed", fixed, vtkDataObject.FIELD_ASSOCIATION_CELLS)
        skin, faces = vtkGeometryFilter(), vtkPolyDataMapper()
        skin.SetInputConnection(some.GetOutputPort())
        faces.SetInputConnection(skin.GetOutputPort())
        faces.SetScalarModeToUseCellFieldData()
        show_bodies(faces, fixed)

network_file = read(f"{base}_contacts_{step}")
network_file.Update()
if network_file.GetOutput().GetNumberOfCells() > 0:  # else nothing touches
    lines, points, tubes = vtkGeometryFilter(), vtkCellDataToPointData(), vtkTubeFilter()
    lines.SetInputConnection(network_file.GetOutputPort())
    points.SetInputConnection(lines.GetOutputPort())
    tubes.SetInputConnection(points.GetOutputPort())
    tubes.SetInputArrayToProcess(0, 0, 0, vtkDataObject.FIELD_ASSOCIATION_POINTS, "normal_force")
    tubes.SetVaryRadiusToVaryRadiusByAbsoluteScalar()
    tubes.Update()
    highest = points.GetOutput().GetPointData().GetArray("normal_force").GetRange()[1]
    tubes.SetVaryRadiusToVaryRadiusByScalar()
    tubes.SetRadius(0.02)
    tubes.SetRadiusFactor(10)
    network = vtkPolyDataMapper()
    network.SetInputConnection(tubes.GetOutputPort())
    network.SetScalarModeToUsePointFieldData()
    show(network, "normal_force", 0.5 * highest)

window = vtkRenderWindow()
window.SetOffScreenRendering(1)
window.SetMultiSamples(8)
window.SetSize(900, 800)
window.AddRenderer(renderer)
camera = renderer.GetActiveCamera()
camera.SetViewUp(0, 0, 1)
camera.SetFocalPoint(0, 0, 0)
camera.SetPosition(4, -44, 6)  # from this direction, as far away as it takes to see all
renderer.ResetCamera()
window.Render()
image, png = vtkWindowToImageFilter(), vtkPNGWriter()
image.SetInput(window)
png.SetInputConnection(image.GetOutputPort())
png.SetFileName(picture)
png.Write()
