"""Results (--json), time series (--csv), and tables of bodies and contacts."""
import collections
import csv
import json

import numpy as np

from .errors import Error
from .stored import read_text


def results(path):
    """The results that --json wrote, as a dictionary."""
    try:
        found = json.loads(read_text(path))
    except (ValueError, RecursionError):
        raise Error(f"{path} holds no results of talus, or is truncated: it is no JSON") from None
    if not isinstance(found, dict):
        raise Error(f"{path} holds no results of talus: it is JSON, but no object")
    if "ended_early" in found:
        raise Error(f"{path} is of a run that ended early: {found['ended_early']}")
    return found


NAMES = ("shape", "shape_a", "shape_b")  # columns of words
WHOLE = ("id", "id_a", "id_b", "feature", "material", "fixed", "global")
FIRST = ("step", "id", "id_a")


class Table:
    """A time series that --csv wrote, or a table of bodies or contacts: table["time"] is a column as a numpy array;
    the unit in the head of a column is not part of its name. Cells that are empty are NaN."""

    def __init__(self, path):
        self.path = str(path)
        try:
            text = read_text(path)
            # Behind the last end of a line is one that the run is still writing, or that a kill has cut.
            rows = list(csv.reader(text[:text.rfind("\n") + 1].splitlines()))
        except (csv.Error, UnicodeDecodeError):
            raise Error(f"{path} is no table of talus: it is no CSV") from None
        if not rows or not rows[0] or rows[0][0].partition(" [")[0] not in FIRST:
            raise Error(f"{path} is no table of talus: its first column is none of {', '.join(FIRST)}")
        head = rows[0]
        for number, row in enumerate(rows[1:], 2):
            if len(row) != len(head):
                raise Error(f"{path} is damaged: line {number} has {len(row)} cells, and its head {len(head)}")
        names = collections.Counter(h.partition(" [")[0] for h in head)
        if len(names) < len(head):
            raise Error(f"{path} is damaged: its head names {names.most_common(1)[0][0]} twice")
        self.units = {h.partition(" [")[0]: h.partition(" [")[2].rstrip("]") for h in head}
        series = head[0].startswith("step")
        self._columns = {}
        for k, name in enumerate(self.units):
            cells = [row[k] for row in rows[1:]]
            try:
                if series or name not in NAMES + WHOLE:
                    self._columns[name] = np.array([float(cell) if cell else np.nan for cell in cells])
                elif name in WHOLE:
                    self._columns[name] = np.array([int(cell) for cell in cells], dtype=np.uint64)
                else:
                    self._columns[name] = np.array(cells, dtype=str)
            except (ValueError, OverflowError):
                raise Error(f"{path} is damaged: its column {name} has a cell that is no number") from None

    def __getitem__(self, name):
        if name not in self._columns:
            raise KeyError(f"{self.path} has no column {name}; it has {', '.join(self._columns)}")
        return self._columns[name]

    def __iter__(self):
        return iter(self._columns)

    def __len__(self):
        return len(next(iter(self._columns.values())))

    def keys(self):
        return self._columns.keys()

    def __repr__(self):
        return f"<talus.Table {self.path}: {len(self)} lines of {', '.join(self)}>"
