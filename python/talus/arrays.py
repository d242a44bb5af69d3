"""Arrays of HDF5 files that are read when they are asked for."""
import h5py
import numpy as np

from .errors import Error

# Names of this package and of the files. Worlds of compiled scenarios use the same ones.
BODIES = {"ids": "id", "velocities": "velocity", "angular_velocities": "angular_velocity", "radii": "radius",
          "masses": "mass", "materials": "material"}


def open_hdf5(path, what):
    """The file. Raises Error where it is missing, truncated, or something else."""
    try:
        return h5py.File(path, "r")
    except FileNotFoundError:
        raise Error(f"{path} does not exist") from None
    except OSError as e:
        reason = str(e)
        if "truncated" in reason:
            raise Error(f"{path} is truncated: copy it again, or let the run write it again") from None
        if "signature" in reason:
            raise Error(f"{path} is no {what}: it is no HDF5 file, or its beginning is damaged") from None
        raise Error(f"{path} cannot be read: {reason}") from None


class Columns:
    """The arrays of a group of a file, with rows in the order `order` (None: as stored). Each is read when it
    is asked for, and kept."""

    def __init__(self, path, what, group, order=None):
        self._path, self._what, self._group, self._order = str(path), what, group, order
        self._read = {}
        with open_hdf5(path, what) as file:
            try:
                if group not in file:
                    raise Error(f"{path} is no {what}: it has no group {group}")
                self._names = [name for name, item in file[group].items() if isinstance(item, h5py.Dataset)]
            except (KeyError, OSError, RuntimeError) as e:
                if isinstance(e, Error):
                    raise
                raise Error(f"{path} is damaged: {group} cannot be read: {e}") from None

    def raw(self, dataset):
        """An array of the file in the stored order."""
        with open_hdf5(self._path, self._what) as file:
            try:
                return file[dataset][()]
            except (OSError, KeyError) as e:
                raise Error(f"{self._path} is damaged: {dataset} cannot be read: {e}") from None

    def __getitem__(self, name):
        if name not in self._names:
            raise KeyError(f"{self._path} has no {name}; there are {', '.join(self._names)}")
        if name not in self._read:
            values = self.raw(f"{self._group}/{name}")
            self._read[name] = values if self._order is None else values[self._order]
        return self._read[name]

    def __contains__(self, name):
        return name in self._names

    def __iter__(self):
        return iter(self._names)

    def __len__(self):
        return len(self._names)

    def keys(self):
        return list(self._names)

    def ordered(self, values):
        return values if self._order is None else values[self._order]


def by_id(ids):
    """The order of ascending ids; parts of one body stay in their order."""
    return np.argsort(ids, kind="stable")
