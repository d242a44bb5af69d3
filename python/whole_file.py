"""Files that are there as a whole or not at all, for ./dev sweep and ./dev bench.

  whole_file.py --check FILE    fails with a sentence if FILE must not become a file of JSON, or cannot
  whole_file.py FILE            makes it one, of the standard input"""
import errno
import fcntl
import os
import pathlib
import stat
import sys


def require_replaceable(path):
    """Raises OSError, with the path, if there is something else than a file."""
    try:
        mode = os.lstat(path).st_mode
    except OSError:
        return  # absent, or writing it will fail
    if stat.S_ISLNK(mode):
        raise OSError(errno.EEXIST, f"this is a symbolic link to {os.readlink(path)}, which a file must not replace", str(path))
    if not stat.S_ISREG(mode):
        raise OSError(errno.EEXIST, "this is a folder, a device, a pipe or a socket, which a file must not replace", str(path))


def write_whole(path, text):
    """The file has its old content or the new one, whenever the process or the machine stops. Raises OSError, with the path.
    The new file is locked until it has its name: what a killed process has left is not."""
    require_replaceable(path)
    new = path.with_name(f"{path.name}.{os.getpid()}.new")
    try:
        new.unlink(missing_ok=True)  # a killed process had the same number
        with open(new, "x") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
            os.replace(new, path)
        folder = os.open(path.parent, os.O_RDONLY)
        os.fsync(folder)
        os.close(folder)
    except OSError as e:
        new.unlink(missing_ok=True)
        raise OSError(e.errno, e.strerror, str(path)) from None


def remove_leftovers(folder, names):
    """Removes what killed processes have left of writing files of these names."""
    for new in folder.glob("*.new"):
        name, _, process = new.name.removesuffix(".new").rpartition(".")
        if name in names and process.isdigit() and new.is_file():
            with open(new) as file:
                try:
                    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                except OSError:
                    continue  # its process is alive
                new.unlink(missing_ok=True)


def require_place_of_json(file):
    """Raises OSError, with the file, if it must not be replaced by one of JSON, or cannot be."""
    path = pathlib.Path(file)
    if not file:
        raise OSError(errno.ENOENT, "it has no name", "a file")
    require_replaceable(path)
    if not path.parent.is_dir():
        raise OSError(errno.ENOENT, f"there is no folder {path.parent}", file)
    if not os.access(path.parent, os.W_OK):
        raise OSError(errno.EACCES, f"the folder {path.parent} must not be written to", file)
    if path.exists():
        with open(path, "rb") as there:
            head = there.read(4096).lstrip()
        if head and head[:1] not in (b"[", b"{"):
            raise OSError(errno.EEXIST, "there is a file already that is no JSON: name another one, or remove this one", file)


def main(words):
    file = words[-1]
    try:
        require_place_of_json(file)
        if words[0] != "--check":
            write_whole(pathlib.Path(file), sys.stdin.read())
    except OSError as e:
        from printable import printable
        sys.exit(printable(f"dev: {e.filename or file} cannot be written: {e.strerror}"))


if __name__ == "__main__":
    main(sys.argv[1:])
