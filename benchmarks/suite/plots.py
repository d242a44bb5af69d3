"""The plots of the performance page."""
import math

from drawing import LOOKS, frame, save


def slope(points):
    """Exponent of a power law through points on log axes, by least squares."""
    logs = [(math.log(x), math.log(y)) for x, y in points]
    mx = sum(x for x, _ in logs) / len(logs)
    my = sum(y for _, y in logs) / len(logs)
    return sum((x - mx) * (y - my) for x, y in logs) / sum((x - mx) ** 2 for x, _ in logs)


def logarithmic(axes, xlabel, ylabel):
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel(xlabel)
    axes.set_ylabel(ylabel)


def cost_against_bodies(output, curves):
    """`curves`: name of a look, label, points (bodies, ms), dashed."""
    figure, axes = frame("Pile: cost against number of bodies",
                         "in brackets: exponent; 1 is linear; lower is better")
    for look, label, points, dashed in curves:
        if not points:
            continue
        _, colour, marker = LOOKS[look]
        exponent = f" ({slope(points):.2f})" if len(points) > 1 else ""
        axes.plot(*zip(*points), marker=marker, color=colour, linestyle="--" if dashed else "-",
                  label=label + exponent, linewidth=2.2 if look.startswith("talus") else 1.4)
    logarithmic(axes, "bodies", "CPU milliseconds per step, one core")
    axes.legend(fontsize=8, frameon=False)
    save(figure, output, "cost")


def cost_against_error(output, name, title, curves):
    """`curves`: name of a look, points (ms, error, setting)."""
    figure, axes = frame(title, "numbers: iterations; lower left is better")
    for look, points in curves:
        if not points:
            continue
        label, colour, marker = LOOKS[look]
        axes.plot([p[0] for p in points], [max(p[1], 1e-9) for p in points], marker=marker,
                  color=colour, label=label, linewidth=2.2 if look == "talus" else 1.4)
        for ms, error, setting in points:
            axes.annotate(f"{setting}", (ms, max(error, 1e-9)), fontsize=7.5, color=colour,
                          xytext=(5, 5), textcoords="offset points")
    axes.axhline(1e-4, color="#999999", linewidth=0.8, linestyle=":")
    axes.text(0.995, 1.1e-4, "1e-4 of the radius", transform=axes.get_yaxis_transform(),
              fontsize=8, color="#777777", ha="right")
    logarithmic(axes, "CPU milliseconds per step, one core", "mean overlap / mean radius")
    axes.legend(fontsize=8.5, frameon=False)
    save(figure, output, name)


def bars(output, name, title, note, entries, xlabel, logs=False):
    """Horizontal bars: (label, value, colour, text at the end)."""
    figure, axes = frame(title, note, (7.2, 1.2 + 0.34 * len(entries)))
    places = range(len(entries))[::-1]
    axes.barh(list(places), [e[1] for e in entries], color=[e[2] for e in entries], height=0.66)
    for place, (_, value, _, text) in zip(places, entries):
        axes.text(value, place, " " + text, va="center", fontsize=8, color="#444444")
    axes.set_yticks(list(places), [e[0] for e in entries])
    if logs:
        axes.set_xscale("log")
    axes.margins(x=0.18)
    axes.set_xlabel(xlabel)
    axes.grid(False, axis="y")
    save(figure, output, name)


def against_ranks(output, name, title, note, curves, ylabel, ticks=None, top=None, band=None):
    """`curves`: label, colour, points (ranks, value); `band`: from, to, label, for comparison."""
    figure, axes = frame(title, note)
    for label, colour, points in curves:
        axes.plot(*zip(*points), marker="o", color=colour, label=label, linewidth=1.8)
    if band:
        axes.axhspan(band[0], band[1], color="#cccccc", label=band[2], zorder=0)
    axes.set_xscale("log")
    if ticks:
        axes.set_xticks(ticks, [f"{n:,}" for n in ticks])
        axes.minorticks_off()
    axes.set_xlabel("ranks")
    axes.set_ylabel(ylabel)
    axes.set_ylim(0, top)
    axes.legend(fontsize=8.5, frameon=False, loc="lower left")
    save(figure, output, name)
