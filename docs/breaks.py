#!/usr/bin/env python3
"""Draws the broken bonds of a table of record_breaks as a PNG: breaks.py TABLE PICTURE."""
import csv
import math
import sys


def main(table, picture):
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    with open(table) as file:
        rows = list(csv.DictReader(file))
    if not rows:
        sys.exit(f"{table} has no broken bonds")
    figure, axes = pyplot.subplots(figsize=(6, 6))
    times = [float(row["time"]) for row in rows]
    colours = pyplot.get_cmap("viridis")
    for row, time in zip(rows, times):
        x, z = float(row["x"]), float(row["z"])
        nx, nz = float(row["normal_x"]), float(row["normal_z"])
        length = math.hypot(nx, nz) or 1
        half = 0.02 * max(abs(float(r["z"])) for r in rows)
        colour = colours((time - times[0]) / max(times[-1] - times[0], 1e-300))
        # The face of the crack, across the bond.
        axes.plot([x - half * nz / length, x + half * nz / length],
                  [z + half * nx / length, z - half * nx / length], color=colour, linewidth=2)
    axes.set_aspect("equal")
    axes.set_xlabel("x")
    axes.set_ylabel("z")
    figure.colorbar(pyplot.cm.ScalarMappable(pyplot.Normalize(times[0], times[-1]), colours),
                    ax=axes, label="time", shrink=0.7)
    figure.savefig(picture, dpi=100, bbox_inches="tight")


if __name__ == "__main__":
    main(*sys.argv[1:])
