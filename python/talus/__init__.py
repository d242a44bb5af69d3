"""Reads what talus writes: outputs, checkpoints, results and time series, as numpy arrays.

  frames = talus.open("heap.hdf.series")     frames[-1].positions, .velocities, .contacts["force"]
  state = talus.open("heap.h5")              state.bodies["sphere"].positions
  results = talus.open("heap.json")          a dictionary
  table = talus.open("heap.csv")             table["time"]; also tables of bodies and contacts

docs/python.md describes it, and how Python drives a compiled scenario.
"""
import builtins
import os

from .checkpoint import MARK, Checkpoint
from .errors import Error
from .series import Frame, Series
from .stored import require_regular
from .tables import Table, results

__all__ = ["Checkpoint", "Error", "Frame", "Series", "Table", "open"]


def open(path):
    """A file that talus wrote, by its content: a Series, a Frame, a Checkpoint, a dictionary of results, or a Table.
    `NAME` of --output stands for NAME.hdf.series. Raises Error."""
    path = os.fspath(path)
    if not os.path.exists(path) and os.path.exists(path + ".hdf.series"):
        return Series(path + ".hdf.series")
    require_regular(path)
    try:
        with builtins.open(path, "rb") as file:
            first = file.read(512)
    except OSError as e:
        raise Error(f"{path} cannot be read: {e.strerror}") from None
    if not first:
        raise Error(f"{path} is empty")
    if first.startswith(MARK[:31]):
        return Checkpoint(path)
    if first.startswith(b"\x89HDF\r\n\x1a\n"):
        return Frame(path)
    if path.endswith(".series"):
        return Series(path)
    if first.lstrip().startswith(b"{"):
        return results(path)
    if first.startswith((b"step", b"id,shape,position_x", b"id_a,id_b,shape_a")):
        return Table(path)
    raise Error(f"{path} is nothing that talus writes: neither an output nor a checkpoint, results or a table")
