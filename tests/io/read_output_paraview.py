"""Reads a series with ParaView, for pvpython: read_output_paraview.py NAME OUTPUTS"""
import sys
from paraview.simple import OpenDataFile

name, outputs = sys.argv[1], int(sys.argv[2])
for kind, arrays, some in (("", "PointData", "velocity"), ("_contacts", "CellData", "normal_force"),
                           ("_surfaces", "CellData", "velocity")):
    reader = OpenDataFile(f"{name}{kind}.hdf.series")
    times = list(reader.TimestepValues)
    assert len(times) == outputs and times == sorted(set(times)), times
    reader.UpdatePipeline(time=times[-1])
    assert some in [array.GetName() for array in getattr(reader, arrays)], kind
    assert reader.GetDataInformation().GetNumberOfPoints() > 0
print("ParaView reads", outputs, "outputs")
