"""Outputs: the files that --output wrote."""
import collections.abc
import json
import pathlib

import numpy as np

from .arrays import BODIES, Columns, by_id, open_hdf5
from .errors import Error

WHAT = "output of talus"
SHAPES = ("sphere", "box", "capsule", "cylinder", "polyhedron", "mesh")


class Frame:
    """One output: the bodies and the contacts of a step. Rows of bodies are in the order of their ids, so the
    rows of two frames belong together if no bodies came or went. Arrays are read when they are asked for.

    positions, velocities, angular_velocities, orientations (x, y, z, w), ids, radii, masses, materials; `bodies`
    has all arrays by their names in the file, `contacts` those of the contacts that carry a force."""

    def __init__(self, path):
        self.path = pathlib.Path(path)
        with open_hdf5(path, WHAT) as file:
            try:
                self.step = int(file["VTKHDF/FieldData/step"][0])
                self.time = float(file["VTKHDF/FieldData/time"][0])
                order = by_id(file["VTKHDF/PointData/id"][:])
            except KeyError:
                raise Error(f"{path} is no {WHAT} with bodies: it lacks VTKHDF/PointData/id or its step") from None
            except OSError as e:
                raise Error(f"{path} is damaged: {e}") from None
        self.bodies = Columns(path, WHAT, "VTKHDF/PointData", order)
        self._contacts = self._positions = None

    def __len__(self):
        return len(self.ids)

    @property
    def positions(self):
        if self._positions is None:
            self._positions = self.bodies.ordered(self.bodies.raw("VTKHDF/Points"))
        return self._positions

    @property
    def shapes(self):
        """The name of the shape of each body."""
        return np.array(SHAPES)[self.bodies["shape"]]

    @property
    def fixed(self):
        """Whether each body is fixed or global."""
        return self.bodies["fixed"] != 0

    def __getattr__(self, name):
        word = {**BODIES, "orientations": "orientation"}.get(name)
        if word is None or "bodies" not in self.__dict__:
            raise AttributeError(f"a frame has no {name}")
        if word not in self.bodies:
            raise AttributeError(f"the bodies of {self.path} have no {name}")
        values = self.bodies[word]
        return np.roll(values, -1, axis=1) if name == "orientations" else values  # the file has w, x, y, z

    @property
    def contacts(self):
        """id_a, id_b, point, normal, force, normal_force, tangential_force, rank, of each contact."""
        if self._contacts is None:
            base, _, step = str(self.path).rpartition("_")
            self._contacts = Columns(f"{base}_contacts_{step}" if base else
                                     str(self.path).replace(".hdf", "_contacts.hdf"), WHAT, "VTKHDF/CellData")
        return self._contacts

    def __repr__(self):
        return f"<talus.Frame {self.path}: step {self.step}, time {self.time:g}, {len(self)} bodies>"


class Series(collections.abc.Sequence):
    """The frames of NAME.hdf.series, in the order of time. A frame is opened when it is asked for."""

    def __init__(self, path):
        self.path = pathlib.Path(path)
        try:
            index = json.loads(self.path.read_text())
        except OSError as e:
            raise Error(f"{path} cannot be read: {e.strerror}") from None
        except ValueError:
            raise Error(f"{path} is no index of an {WHAT}, or is truncated: it is no JSON") from None
        try:
            self._files = [(str(entry["name"]), float(entry["time"])) for entry in index["files"]]
        except (TypeError, KeyError, ValueError):
            raise Error(f"{path} is no index of an {WHAT}: it lists no files with times") from None

    @property
    def times(self):
        return np.array([time for _, time in self._files])

    def __len__(self):
        return len(self._files)

    def __getitem__(self, index):
        if isinstance(index, slice):
            return [self[k] for k in range(*index.indices(len(self)))]
        try:
            name = self._files[index][0]
        except IndexError:
            raise IndexError(f"{self.path} has {len(self)} frames, and none of number {index}") from None
        return Frame(self.path.parent / name)

    def at(self, time):
        """The frame whose time is nearest."""
        if not self._files:
            raise Error(f"{self.path} lists no frames")
        return self[int(np.argmin(np.abs(self.times - time)))]

    def __repr__(self):
        span = f", times {self.times[0]:g} to {self.times[-1]:g}" if self._files else ""
        return f"<talus.Series {self.path}: {len(self)} frames{span}>"
