"""Files that somebody may have sent.

A file can lead its reader to other files (external storage, links, virtual datasets, names of other folders), claim a
size that it does not have, or be a pipe. talus writes nothing of that kind: an array of its files is contiguous, has
numbers, lies within the file and has hard links only. All else is refused, with a sentence that names the place.
"""
import contextlib
import math
import os
import stat

import h5py
import numpy as np

from .errors import Error

PIECE = 1 << 20  # bytes that are read at a time
MOST_PACKED = 1000  # bytes of an array for one on the disk
KINDS = {"u": "iu", "f": "f"}  # of a form: whole numbers, numbers of floating point


def require_regular(path):
    """Raises Error unless the path leads to a regular file: to read a pipe or a device may take for ever."""
    try:
        mode = os.stat(path).st_mode
    except FileNotFoundError:
        raise Error(f"{path} does not exist") from None
    except OSError as e:
        raise Error(f"{path} cannot be read: {e.strerror}") from None
    if stat.S_ISDIR(mode):
        raise Error(f"{path} is a folder: name a file in it")
    if not stat.S_ISREG(mode):
        raise Error(f"{path} is a device, a pipe or a socket: name a file")


def read_text(path):
    """The text of a file. Raises Error, or UnicodeDecodeError. A file with holes may be far larger than what was sent: it is
    read up to the first zero byte, which no text has."""
    require_regular(path)
    data = bytearray()
    try:
        with open(path, "rb") as file:
            while piece := file.read(PIECE):
                data += piece
                if 0 in piece:
                    raise Error(f"{path} is damaged: it has a zero byte after {data.index(0)} others, and is a text")
        return data.decode()
    except OSError as e:
        raise Error(f"{path} cannot be read: {e.strerror}") from None
    except MemoryError:
        raise Error(f"{path} cannot be read: it has {os.path.getsize(path)} bytes, more than there is memory") from None


def beside(path, name):
    """The path of a file in the folder of `path`, where a file has that name for it. Raises Error if it is that of
    another place, a symbolic link or a name with a folder, and if it commands the terminal otherwise than `path` does."""
    known = len(os.path.commonprefix([os.path.basename(path), name]))
    if not name[known:].isprintable() or name in ("", ".", "..") or name != os.path.basename(name):
        raise Error(f"{path} names {name!r}: files of an output lie in its folder, and have plain names")
    found = os.path.join(os.path.dirname(path), name)
    if os.path.islink(found):
        raise Error(f"{found} is a symbolic link, which no output has: put the file itself there")
    return found


@contextlib.contextmanager
def blaming(path, place):
    """Turns what damage causes into an Error that names the file and the place in it."""
    try:
        with np.errstate(all="ignore"):
            yield
    except Error:
        raise
    except Exception as e:  # h5py and numpy raise errors of a dozen types
        raise Error(f"{path} is damaged: {place} cannot be read: {e}") from None


class Stored:
    """An HDF5 file, in a `with`; `what` it is in words. All functions raise Error."""

    def __init__(self, path, what):
        self.path, self.what = os.fspath(path), what
        require_regular(path)
        with blaming(path, "it"):
            try:
                self._file = h5py.File(path, "r")
            except OSError as e:
                reason = str(e)
                if "truncated" in reason:
                    raise Error(f"{path} is truncated: copy it again, or let the run write it again") from None
                if "signature" in reason:
                    raise Error(f"{path} is no {what}: it is no HDF5 file, or its beginning is damaged") from None
                raise Error(f"{path} cannot be read: {reason}") from None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._file.close()

    def _find(self, name):
        """The object of that name, or None."""
        found = h5py.h5o.open(self._file.id, b".")
        for part in name.encode().split(b"/"):
            if not isinstance(found, h5py.h5g.GroupID) or not found.links.exists(part):
                return None
            if found.links.get_info(part).type != h5py.h5l.TYPE_HARD:
                raise Error(f"{self.path}: {name} leads to another place or file, which no {self.what} does")
            found = h5py.h5o.open(found, part)
        return found

    def has(self, name):
        with blaming(self.path, name):
            return self._find(name) is not None

    def names(self, group, kind=h5py.h5d.DatasetID):
        """Names of the arrays of a group, or of its groups."""
        with blaming(self.path, group):
            found = self._find(group)
            if not isinstance(found, h5py.h5g.GroupID):
                raise Error(f"{self.path} is no {self.what}: it has no group {group}")
            names = []
            # In this order HDF5 makes no table of the names: where it cannot be made, HDF5 1.10 ends the process.
            found.links.iterate(names.append, order=h5py.h5.ITER_NATIVE)
            names = sorted(name.decode() for name in names)
            for name in names:
                if not name.isprintable():  # it would command the terminal that shows it
                    raise Error(f"{self.path} is damaged: {group} has the name {name!r}")
            return [name for name in names if isinstance(self._find(f"{group}/{name}"), kind)]

    def array(self, name, form=None, rows=None):
        """An array, of a form such as "u" or "f3" (columns of whole numbers, three of floating point) and a number of rows, if
        they are given."""
        with blaming(self.path, name):
            found = self._find(name)
            if not isinstance(found, h5py.h5d.DatasetID):
                raise Error(f"{self.path} is no {self.what}: it lacks {name}")
            how = found.get_create_plist()
            if how.get_layout() != h5py.h5d.CONTIGUOUS or how.get_external_count():
                raise Error(f"{self.path}: {name} is virtual, lies in another file, or was packed by another program: "
                            "talus has its arrays unpacked within the file (h5repack -l CONTI -f NONE)")
            kind, shape, of_file = found.dtype, found.shape, os.stat(self.path)
            if kind.kind not in KINDS.get(form and form[0], "iuf") or kind.itemsize > 8 or len(shape) not in (1, 2) or \
                    (form and shape[1:] != tuple(map(int, form[1:]))):
                raise Error(f"{self.path} is damaged: {name} has the type {kind} and the shape {shape}")
            if rows is not None and shape[0] != rows:
                raise Error(f"{self.path} is damaged: {name} has {shape[0]} rows, and not {rows}")
            needs = math.prod(shape) * kind.itemsize
            # A file with holes may be far larger than what was sent; file systems that pack zeros save less than this.
            held = MOST_PACKED * max(512 * of_file.st_blocks, 1024)
            if needs and (found.get_offset() is None or found.get_offset() + needs > of_file.st_size or needs > held):
                raise Error(f"{self.path} is damaged: {name} would be of {needs} bytes, which are not within the file")
            values = np.empty(shape, kind)
            found.read(h5py.h5s.ALL, h5py.h5s.ALL, values)
            return values
