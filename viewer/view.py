"""./dev view: a page that shows what --output has written. docs/view.md"""
import os
import signal
import sys

ENDS = [kind for kind in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP) if signal.getsignal(kind) != signal.SIG_IGN]  # as under nohup


def end_at_once(number, _):
    """What is being imported could take an exception for its own."""
    os.write(2, f"view: ended by {signal.Signals(number).name}\n".encode())
    os._exit(128 + number)


if __name__ == "__main__":
    for one in ENDS:
        signal.signal(one, end_at_once)

import csv  # noqa: E402
import fcntl  # noqa: E402
import glob  # noqa: E402
import pathlib  # noqa: E402
import re  # noqa: E402
import stat  # noqa: E402

sys.dont_write_bytecode = True
sys.path[:0] = [str(pathlib.Path(__file__).resolve().parent), str(pathlib.Path(__file__).resolve().parents[1] / "python")]
import page  # noqa: E402
from printable import Parser, printable  # noqa: E402

MARK = "<!-- talus view 1"


def options():
    p = Parser(prog="./dev view", description="Makes one HTML page of a run, or serves it.")
    p.add_argument("output", metavar="OUTPUT", help="NAME of --output NAME, or NAME.hdf.series")
    p.add_argument("--html", metavar="FILE", help="the page (default: NAME.html)")
    p.add_argument("--every", metavar="N", type=int, default=1, help="take every Nth output (1)")
    p.add_argument("--contacts", action="store_true", help="with each contact: a page up to four times as large")
    p.add_argument("--csv", metavar="FILE", help="a time series that --csv of the same run has written: more plots")
    p.add_argument("--force", action="store_true", help="replace a file that is no page of talus")
    p.add_argument("--serve", metavar="PORT", type=int, help="serve the page and new frames instead of writing a file; 0: any port")
    p.add_argument("--bind", metavar="ADDRESS", default="127.0.0.1", help="address to serve at (127.0.0.1)")
    o = p.parse_args()
    p.require_names(o, output="OUTPUT", html="--html", csv="--csv")
    if o.every < 1:
        p.error("--every takes 1 or more")
    if not o.bind:
        p.error("--bind takes an address of this machine; 0.0.0.0 stands for all of them")
    if o.serve is not None and o.html:
        p.error("--serve sends the page and writes no file: leave out --html")
    return o


def read_table(file):
    """Lines of a time series by step, and their names."""
    from talus.stored import read_text
    try:
        text = read_text(file)
        lines = list(csv.reader(text[:text.rfind("\n") + 1].splitlines()))  # the run may be writing the last line
    except (UnicodeDecodeError, csv.Error):
        lines = []
    if not lines or lines[0][:1] != ["step [1]"]:
        sys.exit(f"view: {file} is no time series of talus: name a file that --csv of the run has written")
    names = [n.split(" [")[0] for n in lines[0]]
    table = {}
    for line in lines[1:]:
        values = {}
        for name, text in zip(names, line):
            try:
                values[name] = float(text)
            except ValueError:
                pass
        if values.get("step", -1) >= 0 and values["step"] < float("inf"):
            table[int(values.pop("step"))] = {k: v for k, v in values.items() if k != "time" and abs(v) < float("inf")}
    return table, names


def add_table(head, table):
    """Adds the line of the same step, or of the last one before it."""
    if head["step"] in table:
        head["values"].update(table[head["step"]])


def is_locked(path):
    """Whether a run holds the lock of a file."""
    try:
        with os.fdopen(os.open(path + ".lock", os.O_RDONLY | os.O_NONBLOCK | os.O_NOFOLLOW), "rb") as file:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        pass
    return False


def require_replaceable(path, force):
    """Stops unless the file is absent, empty or a page of talus. With --force it may be another file or a symbolic link,
    but never a folder, a device, a pipe or a socket, a link that leads to one of these, the name of a stream, or what a run
    writes: as talus::detail::inspect_target of programs."""
    series = re.fullmatch(r"(.*)_[0-9]+(\.[^./]*)", path, re.DOTALL)
    if is_locked(path) or series and is_locked("".join(series.groups()) + ".series"):
        sys.exit(f"view: {path} is being written by a run: wait for its end or stop it, or name another file with --html")
    place = os.path.join(os.path.realpath(os.path.dirname(path) or "."), os.path.basename(path))
    if place in ("/dev/stdin", "/dev/stdout", "/dev/stderr") or place.startswith(("/dev/fd/", "/proc/")):
        sys.exit(f"view: {path} is a stream of this program, which a page must not replace: name a file")
    try:
        mode = os.lstat(path).st_mode
    except OSError:
        return  # absent, or writing it will fail
    if stat.S_ISLNK(mode) and os.path.exists(path) and not os.path.isfile(path):
        mode = os.stat(path).st_mode
    if stat.S_ISDIR(mode):
        sys.exit(f"view: {path} is a folder: name a file in it")
    if not stat.S_ISREG(mode) and not stat.S_ISLNK(mode):
        sys.exit(f"view: {path} is a device, a pipe or a socket, which a page must not replace: name a file")
    if force:
        return
    if stat.S_ISLNK(mode):
        sys.exit(f"view: {path} is a symbolic link to {os.readlink(path)}: name the file itself, or add --force, which replaces the link "
                 "and leaves what it leads to")
    try:
        with open(path, "rb") as f:
            start = f.read(4096)
    except OSError as error:
        sys.exit(f"view: {path} is there already and cannot be read ({error.strerror}): name another file with --html, or add --force")
    if start and MARK.encode() not in start:
        sys.exit(f"view: {path} is there already and is no page of talus: name another file with --html, or add --force")


def remove_leftovers(path):
    """Removes what killed processes have left of writing this page: parts that are not locked."""
    for part in glob.glob(glob.escape(path) + ".part-*"):
        if part.rpartition("-")[2].isdigit() and stat.S_ISREG(os.lstat(part).st_mode):
            with open(part) as file:
                try:
                    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                except OSError:
                    continue  # its process is alive
                os.unlink(part)


def begun_page(path):
    """An open file beside a page, and the name that it gets when it is whole. It has none before, so that nothing is left of a
    process that is killed; where the file system has no files without names, it has that name, and a lock. Raises OSError."""
    part = f"{path}.part-{os.getpid()}"
    try:
        return os.fdopen(os.open(os.path.dirname(path) or ".", os.O_TMPFILE | os.O_RDWR, 0o666), "w", encoding="utf-8"), part
    except OSError:
        beside = open(part, "x", encoding="utf-8")
        fcntl.flock(beside, fcntl.LOCK_EX)
        return beside, part


def write_page(o, base):
    import frames
    path = o.html or base + ".html"
    place = os.path.realpath(path)
    if o.csv and place == os.path.realpath(o.csv) or place.startswith(os.path.realpath(base)) and place.endswith((".hdf", ".series")):
        sys.exit(f"view: {path} is a file that the page is made of: name another one with --html")
    require_replaceable(path, o.force)
    files = frames.read_index(base)[::o.every]
    if not files:
        sys.exit(f"view: {base}.hdf.series lists no files: the run has written no output yet")
    table, names = read_table(o.csv) if o.csv else ({}, [])
    three = page.three()
    before, between, end = page.parts(pathlib.Path(__file__).resolve().parent)
    converter = frames.Converter(base, o.contacts)
    remove_leftovers(path)
    try:
        out, part = begun_page(path)
    except OSError as error:
        sys.exit(f"view: {path} cannot be written: {error.strerror}")
    try:
        with out:
            out.write(before + three + between)
            out.write(page.script_of("about", about(base, names)))
            for file, time in files:
                head, data = converter.frame(file, time)
                add_table(head, table)
                out.write(page.script_of("head", head))
                out.write(f'<script type="text/plain" class="talus-data">{frames.text_of(data)}</script>\n')
            out.write(page.script_of("end", {"notes": sorted(converter.notes)}))
            out.write(end)
            out.flush()
            if not os.path.exists(part):
                os.link(f"/proc/self/fd/{out.fileno()}", part, src_dir_fd=out.fileno(), follow_symlinks=True)
            os.replace(part, path)
    except BaseException as error:
        if os.path.exists(part):
            os.unlink(part)
        if isinstance(error, OSError):
            sys.exit(f"view: {path} cannot be written: {error.strerror}")
        raise
    try:
        os.write(2, f"view: {len(files)} frames in {printable(path)}, {os.path.getsize(path) / 1e6:.1f} MB\n".encode())
    except OSError:
        pass  # the page is there


def about(base, names, live=False):
    known = {"step", "time"}
    more = {"name": printable(os.path.basename(base)), "recorded": [n for n in names if n not in known]}
    more["notes"] = ["From the files of --output, which have no planes, domains and joints; --view of a program shows them."]
    if live:
        more["live"] = True
    return more


def on_signal(number, _):
    """Ends by an exception, so that no unfinished page is left."""
    print(f"view: ended by {signal.Signals(number).name}", file=sys.stderr)
    sys.exit(128 + number)


def main():
    o = options()
    try:
        import frames
    except ImportError as error:
        sys.exit(f"view: {error.name} is missing: install Debian's packages python3-h5py and python3-numpy")
    base = frames.series_of(o.output)
    try:
        if o.serve is None:
            for one in ENDS:
                signal.signal(one, on_signal)
            write_page(o, base)
        else:
            import serve
            if signal.SIGINT in ENDS:
                signal.signal(signal.SIGINT, signal.default_int_handler)  # the end of a server that a terminal holds
            serve.serve(o, base)
    except frames.Error as error:
        sys.exit(f"view: {error}")


if __name__ == "__main__":
    try:
        main()
    except SystemExit as end:
        sys.exit(printable(end.code) if isinstance(end.code, str) else end.code)
