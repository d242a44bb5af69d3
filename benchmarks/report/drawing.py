"""How plots of this project look."""
import os

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt

# Label, colour and marker of an engine or solver, by the name of its curve.
LOOKS = {
    "talus": ("talus", "#0072B2", "o"),
    "talus_jacobi": ("talus, accelerated Jacobi", "#56B4E9", "P"),
    "talus_small": ("talus, small steps", "#009E73", "X"),
    "talus_mixed": ("talus, contacts solved in float", "#3A86C8", "d"),
    "talus_soft": ("talus, soft contacts", "#CC79A7", "v"),
    "bullet": ("Bullet, float", "#D55E00", "s"),
    "bullet64": ("Bullet, double", "#E69F00", "D"),
    "ode": ("ODE, double", "#555555", "^"),
    "lammps": ("LAMMPS granular", "#7A5195", "h"),
}

matplotlib.rcParams.update({"svg.hashsalt": "talus", "font.size": 9})


def frame(title, note, size=(7.2, 4.6)):
    """A figure with one pair of axes, a title and a line below it."""
    figure, axes = plt.subplots(figsize=size)
    axes.set_title(title, fontsize=11, loc="left", pad=20)
    axes.text(0, 1.02, note, transform=axes.transAxes, fontsize=8, color="#555555")
    axes.grid(True, which="major", color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    return figure, axes


def save(figure, output, name):
    figure.tight_layout()
    figure.savefig(os.path.join(output, name + ".svg"), metadata={"Date": None, "Creator": None})
    plt.close(figure)
