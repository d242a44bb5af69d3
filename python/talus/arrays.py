"""Arrays of HDF5 files that are read when they are asked for."""
import numpy as np

from .stored import Stored

# Names of this package and of the files. Worlds of compiled scenarios use the same ones.
BODIES = {"ids": "id", "velocities": "velocity", "angular_velocities": "angular_velocity", "radii": "radius",
          "masses": "mass", "materials": "material"}


class Columns:
    """The arrays of a group of a file, with rows in the order `order` (None: as stored). Each is read when it
    is asked for, and kept. `forms`: of those that have a certain form (Stored.array); `rows`: of all, if given."""

    def __init__(self, path, what, group, order=None, forms={}, rows=None):
        self._path, self._what, self._group, self._order = str(path), what, group, order
        self._forms, self._rows = forms, rows if order is None else len(order)
        self._read = {}
        with Stored(path, what) as file:
            self._names = file.names(group)

    def raw(self, dataset, form=None):
        """An array of the file in the stored order."""
        with Stored(self._path, self._what) as file:
            return file.array(dataset, form, self._rows)

    def __getitem__(self, name):
        if name not in self._names:
            raise KeyError(f"{self._path} has no {name}; there are {', '.join(self._names)}")
        if name not in self._read:
            self._read[name] = self.ordered(self.raw(f"{self._group}/{name}", self._forms.get(name)))
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
