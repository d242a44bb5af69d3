"""Outputs: the files that --output wrote."""
import collections
import collections.abc
import json
import math
import pathlib
import re

import numpy as np

from .arrays import BODIES, Columns, by_id
from .errors import Error
from .stored import Stored, beside, blaming, read_text

WHAT = "output of talus"
SHAPES = ("sphere", "box", "capsule", "cylinder", "polyhedron", "mesh", "own")
# The forms of arrays (Stored.array); scenarios may add others of their own.
FORMS = {**dict.fromkeys(("id", "shape", "fixed", "rank", "material", "part", "asleep"), "u"), "mass": "f", "radius": "f", "size": "f3",
         "velocity": "f3", "angular_velocity": "f3", "orientation": "f4"}
CONTACT_FORMS = {**dict.fromkeys(("id_a", "id_b", "rank"), "u"), **dict.fromkeys(("point", "normal", "force"), "f3"),
                 "normal_force": "f", "tangential_force": "f"}


def companion(path, kind):
    """The path of the contacts or surfaces of the same step. Raises Error."""
    return beside(path, re.sub(r"(_\d+)?(\.hdf)?$", rf"_{kind}\1\2", pathlib.Path(path).name, count=1))


def names_of_shapes(file):
    """The names of the shapes by number: those of all scenarios, then those of this one. Raises Error."""
    if not file.has("VTKHDF/FieldData/own_shapes"):
        return SHAPES
    with blaming(file.path, "VTKHDF/FieldData/own_shapes"):
        own = bytes(file.array("VTKHDF/FieldData/own_shapes", "u")).decode().splitlines()
    return SHAPES[:-1] + tuple(own)


def shapes_of(file, rows):
    """The numbers of the shapes of bodies. Raises Error."""
    shapes = file.array("VTKHDF/PointData/shape", "u", rows)
    if not np.isin(shapes, range(len(names_of_shapes(file)))).all():
        raise Error(f"{file.path} is damaged: VTKHDF/PointData/shape has numbers that no shape has")
    return shapes


class Frame:
    """One output: the bodies and the contacts of a step. Rows of bodies are in the order of their ids, so the
    rows of two frames belong together if no bodies came or went. Arrays are read when they are asked for.

    positions, velocities, angular_velocities, orientations (x, y, z, w), ids, radii, masses, materials; `bodies`
    has all arrays by their names in the file, `contacts` those of the contacts that carry a force."""

    def __init__(self, path):
        self.path = pathlib.Path(path)
        with Stored(path, f"{WHAT} with bodies") as file:
            self.step = int(file.array("VTKHDF/FieldData/step", "u", 1)[0])
            self.time = float(file.array("VTKHDF/FieldData/time", "f", 1)[0])
            order = by_id(file.array("VTKHDF/PointData/id", "u"))
            shapes_of(file, len(order))
            self._shapes = names_of_shapes(file)
            file.array("VTKHDF/PointData/fixed", "u", len(order))
        self.bodies = Columns(path, WHAT, "VTKHDF/PointData", order, FORMS)
        self._contacts = self._positions = None

    def __len__(self):
        return len(self.ids)

    @property
    def positions(self):
        if self._positions is None:
            self._positions = self.bodies.ordered(self.bodies.raw("VTKHDF/Points", "f3"))
        return self._positions

    @property
    def shapes(self):
        """The name of the shape of each body."""
        return np.array(self._shapes)[self.bodies["shape"]]

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
            path = companion(self.path, "contacts")
            with Stored(path, WHAT) as file:
                rows = len(file.array("VTKHDF/CellData/id_a", "u"))
            self._contacts = Columns(path, WHAT, "VTKHDF/CellData", forms=CONTACT_FORMS, rows=rows)
        return self._contacts

    def __repr__(self):
        return f"<talus.Frame {self.path}: step {self.step}, time {self.time:g}, {len(self)} bodies>"


class Series(collections.abc.Sequence):
    """The frames of NAME.hdf.series, in the order of time. A frame is opened when it is asked for."""

    def __init__(self, path):
        self.path = pathlib.Path(path)
        try:
            index = json.loads(read_text(path))
        except (ValueError, RecursionError):
            raise Error(f"{path} is no index of an {WHAT}, or is truncated: it is no JSON") from None
        try:
            self._files = [(entry["name"], float(entry["time"])) for entry in index["files"]]
            right = isinstance(index["files"], list) and all(
                isinstance(entry["name"], str) and type(entry["time"]) in (int, float) for entry in index["files"])
        except (TypeError, KeyError, ValueError, OverflowError):
            right = False
        if not right:
            raise Error(f"{path} is no index of an {WHAT}: it lists no files with times")
        if not all(math.isfinite(time) for _, time in self._files):
            raise Error(f"{path} is damaged: it lists times that are not finite")
        counts = collections.Counter(name for name, _ in self._files)
        if len(counts) < len(self._files):
            name, count = counts.most_common(1)[0]
            raise Error(f"{path} is damaged: it lists {name!r} {count} times")

    @property
    def times(self):
        return np.array([time for _, time in self._files])

    @property
    def files(self):
        """Paths and times of the frames. Raises Error."""
        return [(beside(self.path, name), time) for name, time in self._files]

    def __len__(self):
        return len(self._files)

    def __getitem__(self, index):
        if isinstance(index, slice):
            return [self[k] for k in range(*index.indices(len(self)))]
        try:
            name = self._files[index][0]
        except IndexError:
            raise IndexError(f"{self.path} has {len(self)} frames, and none of number {index}") from None
        return Frame(beside(self.path, name))

    def at(self, time):
        """The frame whose time is nearest."""
        if not self._files:
            raise Error(f"{self.path} lists no frames")
        return self[int(np.argmin(np.abs(self.times - time)))]

    def __repr__(self):
        span = f", times {self.times[0]:g} to {self.times[-1]:g}" if self._files else ""
        return f"<talus.Series {self.path}: {len(self)} frames{span}>"
