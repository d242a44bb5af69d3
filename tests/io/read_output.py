"""The files of a run with --output, as VTK and h5py read them: equal in both, and equal to the summary.
read_output.py NAME JSON; ends with 77 if VTK or h5py are missing."""
import json
import os
import subprocess
import sys

try:
    import h5py
    import numpy as np
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonDataModel import VTK_LINE, VTK_POLYGON, VTK_VERTEX
    from vtkmodules.vtkIOHDF import vtkHDFReader
except ImportError as missing:
    print("skipped:", missing)
    sys.exit(77)

name, said = sys.argv[1], json.load(open(sys.argv[2]))
bodies_columns = {"id", "rank", "shape", "fixed", "material", "mass", "radius", "size", "velocity",
                  "angular_velocity", "orientation"}
surface_columns = {"id", "rank", "shape", "fixed", "material", "velocity"}
contact_columns = {"id_a", "id_b", "rank", "normal_force", "tangential_force", "force", "normal",
                   "point"}


def check(what, holds):
    if not holds:
        sys.exit(f"FAILED: {what}")


def read(path, kind, group, columns):
    """Through both libraries; returns the arrays by name."""
    reader = vtkHDFReader()
    check(f"VTK takes {path}", reader.CanReadFile(path))
    reader.SetFileName(path)
    reader.Update()
    grid = reader.GetOutput()
    data = grid.GetPointData() if group == "PointData" else grid.GetCellData()
    arrays = {}
    with h5py.File(path) as f:
        root = f["VTKHDF"]
        rows = root["Types"].shape[0]
        check(f"{path} has cells", grid.GetNumberOfCells() == rows)
        check(f"{path} has points", grid.GetNumberOfPoints() == root["Points"].shape[0])
        check(f"{path} has columns", set(root[group]) == columns)
        check("time", root["FieldData/time"].shape == (1,))
        if rows:
            kinds = {grid.GetCellType(k) for k in range(rows)}
            check(f"kinds of cells {kinds}", kinds == {kind})
            arrays["Points"] = vtk_to_numpy(grid.GetPoints().GetData())
            check("points are alike", (arrays["Points"] == root["Points"][:]).all())
        for column in columns:
            array = data.GetArray(column)
            check(f"VTK has {column} of {path}", array is not None or not rows)
            arrays[column] = vtk_to_numpy(array) if rows else root[group][column][:]
            check(f"{column} is alike", (arrays[column] == root[group][column][:]).all())
        arrays["time"] = root["FieldData/time"][0]
        arrays["step"] = root["FieldData/step"][0]
    return arrays


index = json.load(open(name + ".hdf.series"))["files"]
check("as many contacts", len(index) ==
      len(json.load(open(name + "_contacts.hdf.series"))["files"]))
check("several outputs", len(index) > 2)
lines = 0
for entry in index:
    path = os.path.join(os.path.dirname(name), entry["name"])
    base, step = path.rsplit("_", 1)
    b = read(path, VTK_VERTEX, "PointData", bodies_columns)
    c = read(f"{base}_contacts_{step}", VTK_LINE, "CellData", contact_columns)
    check("time", b["time"] == entry["time"] == c["time"])
    check("step", b["step"] == int(step.split(".")[0]))
    check("ids are unique", len(np.unique(b["id"])) == len(b["id"]))
    free = b["fixed"] == 0
    check("bodies", free.sum() == said["bodies"])
    check("ranks", set(b["rank"]) <= set(range(said["ranks"])))
    lengths = np.linalg.norm(b["orientation"], axis=1)
    check("unit quaternions", np.allclose(lengths, 1))
    if len(c["id_a"]):
        place = dict(zip(b["id"][free].tolist(), b["Points"][free].tolist()))
        ends = c["Points"].reshape(-1, 2, 3)
        for k in range(len(ends)):
            for end, who in ((0, "id_a"), (1, "id_b")):
                there = place.get(c[who][k], c["point"][k])  # of what cannot move, the point
                check(f"line {k} ends in body {who}", (ends[k][end] == there).all())
        check("forces push", (c["normal_force"] > -1e-9 * c["normal_force"].max()).all())
    lines += len(c["id_a"])
    surfaces = f"{base}_surfaces_{step}"
    if os.path.exists(surfaces):
        f = read(surfaces, VTK_POLYGON, "CellData", surface_columns)
        check("step", f["step"] == b["step"])
        boxes = b["id"][b["shape"] == 1]
        check("boxes have six faces", sorted(f["id"]) == sorted(np.repeat(boxes, 6)))
        owner = dict(zip(b["id"], b["rank"]))
        check("owners", all(owner[i] == r for i, r in zip(f["id"], f["rank"])))
        middle = f["Points"].reshape(-1, 8, 3).mean(axis=1)  # in the order of ids within a rank
        check("boxes lie where they are", np.allclose(
            middle, b["Points"][b["shape"] == 1], rtol=0, atol=1e-9))
check("the heap has contacts", lines > 1000)
check("below the outlet", ((b["Points"][:, 2] <= 8) & free).sum() == said["bodies_out"])

# The script of the documentation, on the same files.
root = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "docs")
table = subprocess.run([sys.executable, "-B", os.path.join(root, "output.py"),
                        name + ".hdf.series"], capture_output=True, text=True, check=True).stdout
rows = [line.split(",") for line in table.splitlines()]
check("a line for each output", len(rows) == len(index) + 1)
last = dict(zip(rows[0], rows[-1]))
check("bodies", int(last["bodies"]) == said["bodies"])
check("coordination", abs(float(last["coordination"]) - said["coordination"]) < 1e-9)
check("contacts", int(last["contacts"]) == len(c["id_a"]))
print(len(index), "outputs,", lines, "contacts")
