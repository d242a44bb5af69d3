"""Checkpoints: the files that --checkpoint wrote. docs/checkpoints.md describes the format."""
import pathlib
import struct

import h5py
import numpy as np

from .arrays import Columns, by_id
from .errors import Error
from .stored import Stored, blaming, require_regular

WHAT = "checkpoint of talus"
MARK = b"talus checkpoint, HDF5 follows\n\0"
VERSION = 1
GOLDEN = np.uint64(0x9E3779B97F4A7C15)


def mix(x):
    """The finaliser of splitmix64."""
    x = x + GOLDEN
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return x ^ (x >> np.uint64(31))


def checksum(data, place=0):
    """The checksum of talus of some bytes."""
    words = np.frombuffer(data + bytes(-len(data) % 8), dtype="<u8")
    with np.errstate(over="ignore"):
        start = np.uint64(place) * np.uint64(0xD1342543DE82EF95) + GOLDEN
        salt = start + np.arange(len(words), dtype=np.uint64) * GOLDEN
        return int(mix(np.uint64(len(data) ^ place)) + np.sum(mix(words ^ salt), dtype=np.uint64))


def require_whole(path):
    """Raises Error unless the first block of the file is that of a checkpoint, undamaged, and the file has the
    length that the block tells."""
    require_regular(path)
    try:
        with open(path, "rb") as file:
            head = file.read(56)
            if not head.startswith(MARK[:31]):
                raise Error(f"{path} is no {WHAT}, or its first bytes are damaged")
            if len(head) < 56:
                raise Error(f"{path} is truncated: it ends within its first block")
            version, block_bytes, file_bytes, _ = struct.unpack_from("<IIQQ", head, 32)
            if not 512 <= block_bytes <= 1 << 26:
                raise Error(f"{path} is damaged: its first block makes no sense")
            block = head + file.read(block_bytes - 56)
            length = file.seek(0, 2)
    except OSError as e:
        raise Error(f"{path} cannot be read: {e.strerror}") from None
    if len(block) < block_bytes:
        raise Error(f"{path} is truncated: it ends within its first block")
    if struct.unpack("<Q", block[-8:])[0] != checksum(block[:-8]):
        raise Error(f"{path} is damaged: the checksum of its first block is wrong")
    if version > VERSION:
        raise Error(f"{path} is of format {version}, but this package reads formats up to {VERSION}")
    if length != file_bytes:
        raise Error(f"{path} is {'truncated' if length < file_bytes else 'damaged'}: it has {length} bytes, but "
                    f"was written with {file_bytes}")


FORMS = {**dict.fromkeys(("id", "material", "flags"), "u"), **dict.fromkeys(("position", "velocity", "angular_velocity"), "f3"),
         "orientation": "f4", "inverse_mass": "f"}  # of columns (Stored.array)


class Bodies(Columns):
    """The bodies of one shape, in the order of their ids: positions, velocities, angular_velocities, orientations
    (x, y, z, w), ids, radii; ["..."] for all columns by their names in the file. `numbers` names the columns of
    "shape", which are attributes, too: radius, length."""

    WORDS = {"positions": "position", "velocities": "velocity", "angular_velocities": "angular_velocity",
             "orientations": "orientation", "ids": "id", "materials": "material"}

    def __init__(self, path, table):
        with Stored(path, WHAT) as file:
            order = by_id(file.array(f"{table}/id", "u"))
        super().__init__(path, WHAT, table, order, FORMS)
        self._names = [n for n in self._names if n not in ("pieces", "boxes", "extra")]
        self.shape = table.rpartition("/")[2]
        self.numbers = ()
        with Stored(path, WHAT) as file:
            if file.has(f"shapes/{self.shape}"):
                with blaming(path, f"shapes/{self.shape}"):
                    self.numbers = tuple(bytes(file.array(f"shapes/{self.shape}", "u")).decode().splitlines())

    def __getitem__(self, name):
        values = super().__getitem__(name)
        return values[:, 0] if values.ndim == 2 and values.shape[1] == 1 else values

    def __len__(self):
        return len(self["id"])

    def _number(self, k):
        """A column of "shape". Raises Error."""
        values = self["shape"]
        columns = values.reshape(len(values), 1) if values.ndim == 1 else values
        if columns.shape[1] < max(k + 1, len(self.numbers)):
            raise Error(f"{self._path} is damaged: {self._group}/shape has {columns.shape[1]} columns, and its bodies have more numbers")
        return columns[:, k]

    def __getattr__(self, name):
        shape = self.__dict__.get("shape", "body")
        if name == "radii" and shape in ("sphere", "capsule", "cylinder"):
            return self._number(0)
        numbers = self.__dict__.get("numbers", ())
        if name in numbers:
            return self._number(numbers.index(name))
        word = type(self).WORDS.get(name)
        if word is None or word not in self._names:
            raise AttributeError(f"a {shape} of this checkpoint has no {name}")
        return self[word]


class Checkpoint:
    """A checkpoint: step, time, ranks, policies; `bodies["sphere"].positions` and so on of the bodies, `globals`
    likewise; `contacts` with the arrays a, b, feature, impulse, ... The rows of tables are not compared with
    their checksums: a restart does that."""

    def __init__(self, path):
        require_whole(path)
        self.path = pathlib.Path(path)
        with Stored(path, WHAT) as file:
            self.step = int(file.array("run/steps", "u", 1)[0])
            self.time = float(file.array("run/time", "f", 1)[0])
            self.ranks = int(file.array("run/ranks", "u", 1)[0])
            with blaming(path, "scenario/policies"):
                self.policies = bytes(file.array("scenario/policies", "u")).decode()
            tables = {kind: file.names(kind, h5py.h5g.GroupID) for kind in ("bodies", "globals") if file.has(kind)}
        self.bodies = {shape: Bodies(path, f"bodies/{shape}") for shape in tables.get("bodies", ())}
        self.globals = {shape: Bodies(path, f"globals/{shape}") for shape in tables.get("globals", ())}

    @property
    def contacts(self):
        return Columns(self.path, WHAT, "contacts")

    def __getattr__(self, name):
        if name not in Bodies.WORDS and name != "radii":
            raise AttributeError(f"a checkpoint has no {name}")
        shapes = list(self.__dict__.get("bodies", ()))
        if len(shapes) != 1:
            raise AttributeError(f"this checkpoint has bodies of several shapes ({', '.join(shapes)}): write "
                                 f"bodies['{shapes[0] if shapes else ''}'].{name}")
        return getattr(self.bodies[shapes[0]], name)

    def __repr__(self):
        count = ", ".join(f"{len(b)} of shape {s}" for s, b in self.bodies.items())
        return f"<talus.Checkpoint {self.path}: step {self.step}, time {self.time:g}, bodies: {count}>"
