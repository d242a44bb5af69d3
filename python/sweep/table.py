"""The table of a sweep: a row for each run, in the order of the design."""
import csv
import io
import math

from whole_file import write_whole


def scalars(results):
    """The numbers, texts and truth values among the results of a program."""
    return {k: v for k, v in results.items() if v is None or isinstance(v, (str, int, float, bool))}


def text(value):
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(int(value))
    return repr(value) if isinstance(value, float) else str(value)


def collect(runs):
    """Names of the varied options, names of the results in the order in which programs write them, and a
    dictionary for each run: its folder, its state, its values, its results. A result that has the name of a
    varied option is left out, since the option has its column."""
    varied = list(runs[0].values) if runs else []
    rows, names = [], {}
    for run in runs:
        found = {k: v for k, v in scalars(run.results()).items() if k not in varied}
        names.update(dict.fromkeys(found))
        rows.append({"run": run.folder.name, "status": run.state, **run.values, **found})
    return varied, list(names), rows


def write(path, runs):
    """table.csv: run, status, the varied options, and all results; empty where a run has no such result."""
    varied, names, rows = collect(runs)
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    columns = ["run", "status", *varied, *[n for n in names if n not in ("run", "status")]]
    writer.writerow(columns)
    for row in rows:
        writer.writerow([text(row.get(c)) for c in columns])
    write_whole(path, out.getvalue())


def as_number(value):
    """A finite number, or None; of a text too, for values of options."""
    if isinstance(value, str):
        try:
            value = float(value)
        except ValueError:
            return None
    if value is None or isinstance(value, (list, dict)) or not math.isfinite(value):
        return None
    return float(value)
