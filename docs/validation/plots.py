#!/usr/bin/env python3
"""Draws docs/validation/*.svg from the curves beside it, and from the array of ./dev bench validation.

python3 docs/validation/plots.py [VALIDATION.json]
"""
import json
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

HERE = pathlib.Path(__file__).resolve().parent
STYLE = {"talus": ("C0", "-"), "liggghts": ("C1", "--"), "lammps": ("C2", ":")}
NAMES = {"talus": "talus", "liggghts": "LIGGGHTS 3.8", "lammps": "LAMMPS 2022"}
plt.rcParams.update({"svg.hashsalt": "talus", "font.size": 9, "figure.figsize": (5.4, 3.4)})


def table(name):
    """Rows of numbers of a file beside this one, in order of time; none if there is no such file."""
    path = HERE / name
    if not path.exists():
        return []
    lines = path.read_text().splitlines()
    rows = [[float(word) for word in line.split()] for line in lines if line and line[0] != "#"]
    return sorted(rows, key=lambda row: row[0])


def save(figure, name):
    figure.tight_layout()
    figure.savefig(HERE / name, metadata={"Date": None})
    plt.close(figure)


def curves(stem, columns, name, labels, title):
    """A panel for each column of <stem>_<code>.txt, with a line for each code."""
    figure, axes = plt.subplots(1, len(columns), squeeze=False, figsize=(5.4 * len(columns) ** 0.6, 3.4))
    for axis, (column, scale, heading) in zip(axes[0], columns):
        for code, (colour, dash) in STYLE.items():
            rows = table(f"{stem}_{code}.txt")
            if rows:
                axis.plot([row[0] for row in rows], [scale * row[column] for row in rows], dash,
                          color=colour, label=NAMES[code])
        axis.set_xlabel(labels[0])
        axis.set_ylabel(labels[1])
        axis.set_title(heading, fontsize=9)
        axis.legend(frameon=False)
    figure.suptitle(title, fontsize=10)
    save(figure, name)


def chung_ooi(cases):
    """Tests 4 and 5: expected and found tangential velocity and rotation."""
    figure, axes = plt.subplots(1, 2, figsize=(8.4, 3.4))
    for axis, test, label in ((axes[0], "4", "angle of incidence (degrees)"),
                              (axes[1], "5", "tangential speed before (m/s)")):
        for quantity, marker in (("tangential velocity over normal velocity", "o"),
                                 ("velocity by rotation over normal velocity", "s")):
            for number, stuff in enumerate(sorted({c["case"].split("/")[2] for c in cases
                                                   if c["case"].startswith(f"chung_ooi/{test}/")})):
                points = sorted((float(c["case"].split("/")[3]), c["expected"], c["found"])
                                for c in cases
                                if c["case"].startswith(f"chung_ooi/{test}/{stuff}/")
                                and c["quantity"] == quantity)
                x = [p[0] for p in points]
                axis.plot(x, [p[1] for p in points], "-", color=f"C{number}", linewidth=0.8)
                axis.plot(x, [p[2] for p in points], marker, color=f"C{number}", markersize=4,
                          fillstyle="none", label=f"{stuff}, {quantity.split(' over')[0]}")
        axis.set_xlabel(label)
        axis.set_title(f"test {test}: lines expected, markers talus", fontsize=9)
        axis.legend(frameon=False, fontsize=6.5)
    axes[1].set_xscale("log")
    axes[0].set_ylabel("over the normal velocity before")
    for axis in axes:
        axis.set_ylim(-2, 6)
    save(figure, "chung_ooi.svg")


def shifted():
    """The penetration with the steel sphere shifted by some 1e-7 m."""
    rows = table("penetration_shifted.txt")
    figure, axis = plt.subplots()
    times = [1000 * row[0] for row in rows]
    for column in range(1, 9):
        axis.plot(times, [1000 * row[column] for row in rows], "C0", linewidth=0.8,
                  label="talus, shifts of 0 to 0.7 µm" if column == 1 else None)
    axis.plot(times, [1000 * row[9] for row in rows], "C1--", label="LIGGGHTS 3.8, no shift")
    axis.set_xlabel("time (ms)")
    axis.set_ylabel("height of the steel sphere (mm)")
    axis.set_title("Penetration from one state at 20.2 ms, dt = 1e-6 s", fontsize=9)
    axis.legend(frameon=False)
    save(figure, "penetration_shifted.svg")


def main():
    shifted()
    curves("discharge", [(1, 1, "100,000 spheres of M1, soft")], "discharge.svg",
           ("time (s)", "spheres above the lip"), "Silo from one settled state, dt = 1e-4 s")
    if len(sys.argv) > 1:
        chung_ooi(json.loads(pathlib.Path(sys.argv[1]).read_text()))
    curves("penetration", [(1, 1000, "height of the steel sphere")], "penetration.svg",
           ("time (s)", "z (mm)"), "Penetration: 25,000 spheres, dt = 5e-7 s")
    curves("drum", [(1, 1, "M1, x > 0, z > 0"), (2, 1, "M2, x > 0, z > 0"),
                    (3, 1, "M1, x < 0, z < 0"), (4, 1, "M2, x < 0, z < 0")], "drum.svg",
           ("time (s)", "spheres"), "Drum, soft: 38,000 spheres, dt = 1e-4 s")
    figure, axis = plt.subplots()
    for path in sorted(HERE.glob("silo_*.txt")):
        rows = table(path.name)
        axis.plot([row[0] for row in rows], [row[1] for row in rows],
                  label=path.stem[5:].replace("_", ", ").replace("mm", " mm"))
    if axis.lines:
        axis.set_xlabel("time (s)")
        axis.set_ylabel("spheres above the lip")
        axis.legend(frameon=False)
        save(figure, "silo.svg")


if __name__ == "__main__":
    main()
