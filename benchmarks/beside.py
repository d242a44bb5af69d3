"""What the benchmarks beside other engines share: their options, their rows, their pictures."""
import argparse
import json
import pathlib
import sys

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "python"))
from whole_file import require_place_of_json, write_whole  # noqa: E402


def rivals(benchmark, known):
    """The type of --rivals: a list of names, of which each must be known."""
    def names(text):
        found = [word for word in text.split(",") if word]
        for name in found:
            if name not in known:
                raise argparse.ArgumentTypeError(
                    f"no '{name}' runs '{benchmark}'; its rivals are: {', '.join(known)}")
        return found
    return names


def positive(text):
    """The type of an option that is a whole number from 1."""
    if not text.isdigit() or int(text) == 0:
        raise argparse.ArgumentTypeError(f"needs a whole number from 1, not '{text}'")
    return int(text)


def file_for_rows(text):
    """The type of --json: a file that rows may replace."""
    try:
        require_place_of_json(text)
    except OSError as e:
        raise argparse.ArgumentTypeError(f"{text} cannot be written: {e.strerror}")
    return text


def write_rows(rows, file, indent=None):
    """The rows as JSON, in the file or on the standard output."""
    text = "[\n" + ",\n".join(json.dumps(row, indent=indent) for row in rows) + "\n]\n"
    try:
        if file:
            write_whole(pathlib.Path(file), text)
        else:
            print(text, end="", flush=True)
    except OSError as e:
        sys.exit(f"{file or 'the standard output'} cannot be written: {e.strerror}")


def pyplot():
    """matplotlib.pyplot for files, or None if it is not installed."""
    try:
        import matplotlib
    except ImportError:
        return None
    matplotlib.use("Agg")
    from matplotlib import pyplot as found
    found.rcParams["svg.hashsalt"] = "talus"
    return found
