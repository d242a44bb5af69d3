"""An output as talus writes it, and a server that shows it, for tests without a program."""
import contextlib
import http.client
import json
import os
import pathlib
import subprocess
import sys

import h5py
import numpy as np

VIEW = [sys.executable, "-B", str(pathlib.Path(__file__).resolve().parents[2] / "viewer" / "view.py")]
BODIES, CONTACTS, SURFACES = "o_0000000001.hdf", "o_contacts_0000000001.hdf", "o_surfaces_0000000001.hdf"
COUNT = 8


def write_output(folder, count=COUNT):
    """An output of one frame with polyhedra, as talus writes it."""
    ids, three, libver = np.arange(count, dtype="u8"), np.arange(3.0 * count).reshape(-1, 3), {"libver": ("v108", "v110")}
    whole = lambda value, kind: np.full(count, value, kind)
    with h5py.File(folder / BODIES, "w", **libver) as f:
        f["VTKHDF/Points"], f["VTKHDF/FieldData/step"], f["VTKHDF/FieldData/time"] = three, np.array([1]), np.array([0.5])
        for name, values in {"id": ids, "shape": whole(4, "u1"), "fixed": whole(0, "u1"), "rank": whole(0, "u4"),
                             "material": whole(0, "u2"), "size": three * 0 + 1, "mass": whole(1, "f8"), "radius": whole(1, "f8"),
                             "velocity": three, "angular_velocity": three, "orientation": np.tile((1.0, 0, 0, 0), (count, 1))}.items():
            f["VTKHDF/PointData/" + name] = values
    with h5py.File(folder / CONTACTS, "w", **libver) as f:
        for name, values in {"id_a": ids, "id_b": ids[::-1].copy(), "point": three, "normal": three, "force": three, "normal_force": three[:, 0],
                             "tangential_force": three[:, 0], "rank": whole(0, "u4")}.items():
            f["VTKHDF/CellData/" + name] = values
    with h5py.File(folder / SURFACES, "w", **libver) as f:
        f["VTKHDF/CellData/id"], f["VTKHDF/CellData/shape"] = ids, whole(4, "u1")
        f["VTKHDF/Offsets"], f["VTKHDF/Connectivity"] = np.arange(0, 3 * count + 1, 3), np.arange(3 * count) % count
        f["VTKHDF/Points"] = three
    write_index(folder, BODIES)


def write_index(folder, *names, time=0.5):
    (folder / "o.hdf.series").write_text(json.dumps({"files": [{"name": n, "time": time} for n in names]}))


def with_array(file, name, make):
    """Replaces an array of a file by what make(group, name) puts there."""
    with h5py.File(file, "r+") as f:
        group, _, last = name.rpartition("/")
        if last in f[group]:
            del f[group][last]
        make(f[group], last)


class Server:
    """./dev view --serve."""

    def __init__(self, folder, *words, limit=lambda: None, **environment):
        self.process = subprocess.Popen([*VIEW, str(folder / "o"), "--serve", "0", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                        text=True, preexec_fn=limit, env={**os.environ, "TALUS_THREE": str(folder / "three.js"), **environment})
        self.host, _, self.token = self.process.stdout.readline().strip().removeprefix("http://").strip("/").partition("/")

    def end(self):
        self.process.kill()
        self.process.communicate()

    def ask(self, path="/heads/0", method="GET"):
        with contextlib.closing(http.client.HTTPConnection(self.host, timeout=20)) as connection:
            connection.request(method, f"/{self.token}{path}")
            answer = connection.getresponse()
            return answer.status, answer.read().decode(errors="replace")
