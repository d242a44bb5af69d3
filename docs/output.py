"""Reads a series that --output wrote: python3 output.py NAME.hdf.series"""
import json, os, sys
import h5py
import numpy as np

series = sys.argv[1]
print("time,bodies,kinetic_energy,contacts,normal_force_mean,coordination")
for entry in json.load(open(series))["files"]:
    path = os.path.join(os.path.dirname(series), entry["name"])
    base, step = path.rsplit("_", 1)
    with h5py.File(path) as f, h5py.File(f"{base}_contacts_{step}") as c:
        points, bodies = f["VTKHDF/Points"], f["VTKHDF/PointData"]
        contacts = c["VTKHDF/CellData"]
        free = bodies["fixed"][:] == 0
        speed = np.linalg.norm(bodies["velocity"][:], axis=1)
        energy = 0.5 * np.sum((bodies["mass"] * speed**2)[free])
        force = contacts["normal_force"][:]
        pairs = np.unique(np.stack([contacts["id_a"], contacts["id_b"]]), axis=1)
        touches = np.isin(pairs, bodies["id"][:][free]).sum()
        print(entry["time"], free.sum(), energy, len(force), force.mean() if len(force) else 0,
              touches / free.sum(), sep=",")
