"""Plots of a sweep: a file for each result, with a panel for each varied option."""
import collections
import io
import math
import re
import statistics

import table
from whole_file import write_whole

# Results of every program that are worth a plot if they vary; all that follow state_digest (monitors, and
# what the set-up returned) are, too.
USUAL = ("contacts", "penetration_mean", "penetration_max", "residual", "balance_borne_weight", "iterations_mean",
         "kinetic_energy", "potential_energy", "max_speed", "cpu_seconds")
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#555555", "#7A5195")
MOST_CURVES = len(COLOURS)
MOST_PLOTS = 24


def chosen(names, rows, wanted):
    """The results to draw: those wanted, or, of None, the usual ones and the program's own, where they vary."""
    if wanted is not None:
        return [n for n in names if n in wanted]
    own = names[names.index("state_digest") + 1:] if "state_digest" in names else []
    good = []
    for name in [*own, *[n for n in USUAL if n in names]]:
        values = [row[name] for row in rows if isinstance(row.get(name), (int, float))]
        if len({v for v in values if math.isfinite(v)}) > 1:
            good.append(name)
    return good[:MOST_PLOTS]


def spread(values, ratio):
    """Whether a logarithmic axis shows the values better."""
    return min(values) > 0 and max(values) / min(values) > ratio


def curves_of(rows, x, y, others):
    """{label: {x: [y, ...]}}: a curve for each combination of the other options, one for all if those are
    too many; and whether its means are worth a line. Seeds are repetitions, not an option of their own."""
    kept = [o for o in others if o != "seed"]
    many = len({tuple(row[o] for o in kept) for row in rows}) > MOST_CURVES
    if many:
        kept = []
    curves = collections.OrderedDict()
    for row in rows:
        at, value = table.as_number(row[x]), table.as_number(row.get(y))
        if value is None:
            continue
        label = ", ".join(f"{o} = {row[o]}" for o in kept)
        curves.setdefault(label, {}).setdefault(row[x] if at is None else at, []).append(value)
    return curves, not many or any(len(v) > 1 for curve in curves.values() for v in curve.values())


def draw_panel(axes, rows, x, y, others):
    curves, lines = curves_of(rows, x, y, others)
    words = any(isinstance(at, str) for curve in curves.values() for at in curve)
    places = {}
    if words:  # texts stand side by side, in the order of the design
        for row in rows:
            places.setdefault(row[x] if table.as_number(row[x]) is None else table.as_number(row[x]), len(places))
        axes.set_xticks(range(len(places)), [str(p) for p in places])
    everything = [v for curve in curves.values() for values in curve.values() for v in values]
    for k, (label, curve) in enumerate(curves.items()):
        points = list(curve.items()) if words else sorted(curve.items())
        at = [places[p] if words else p for p, _ in points]
        style = dict(color=COLOURS[k % MOST_CURVES], label=label)
        axes.plot([a for a, (_, values) in zip(at, points) for _ in values],
                  [v for _, values in points for v in values], "o", markersize=3, alpha=0.5,
                  color=style["color"])
        if lines:
            axes.plot(at, [statistics.fmean(values) for _, values in points], "-", linewidth=1.2, **style)
    axes.set_xlabel(x)
    axes.grid(True, color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    if everything and spread(everything, 100):
        axes.set_yscale("log")
    if not words and curves:
        where = [at for curve in curves.values() for at in curve]
        if spread(where, 30):
            axes.set_xscale("log")
    if 1 < len(curves) <= MOST_CURVES:
        axes.legend(fontsize=7, frameon=False)


def draw(folder, runs, wanted=None):
    """Writes folder/RESULT.svg; returns their names. The points are the runs, the lines their means. Without
    matplotlib nothing is drawn: returns None."""
    try:
        import matplotlib
    except ImportError:
        return None
    matplotlib.use("svg")
    import matplotlib.pyplot as plt
    matplotlib.rcParams.update({"svg.hashsalt": "talus", "font.size": 9})

    varied, names, rows = table.collect(runs)
    rows = [row for row in rows if row["status"] == "done"]
    panels = [v for v in varied if v != "seed"] or varied
    folder.mkdir(exist_ok=True)
    for old in (*folder.glob("*.svg"), *folder.glob("*.svg.*.new")):
        old.unlink()
    drawn = []
    for name in chosen(names, rows, wanted):
        figure, all_axes = plt.subplots(1, len(panels), figsize=(4.2 * len(panels), 3.4), squeeze=False)
        for axes, x in zip(all_axes[0], panels):
            draw_panel(axes, rows, x, name, [v for v in varied if v != x])
        all_axes[0][0].set_ylabel(name)
        figure.tight_layout()
        file = re.sub(r"[^\w.-]", "_", name) + ".svg"
        picture = io.StringIO()
        figure.savefig(picture, format="svg", metadata={"Date": None, "Creator": None})
        write_whole(folder / file, picture.getvalue())
        plt.close(figure)
        drawn.append(file)
    return drawn
