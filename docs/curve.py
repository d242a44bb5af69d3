#!/usr/bin/env python3
"""Draws columns of a table of --csv over another one: curve.py TABLE PICTURE X Y [Y ...]"""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "python"))


def main(table, picture, x, *ys):
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot
    import talus

    columns = talus.Table(table)
    figure, panels = pyplot.subplots(len(ys), sharex=True, squeeze=False, figsize=(6, 1 + 2.5 * len(ys)))
    for axes, y in zip(panels[:, 0], ys):
        axes.plot(columns[x], columns[y], linewidth=1)
        axes.set_ylabel(y)
        axes.grid(alpha=0.3)
    panels[-1, 0].set_xlabel(x)
    figure.savefig(picture, dpi=100, bbox_inches="tight")


if __name__ == "__main__":
    if len(sys.argv) < 5:
        sys.exit(__doc__)
    main(*sys.argv[1:])
