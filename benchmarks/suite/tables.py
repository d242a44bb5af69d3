"""The tables and plots of the performance page, from the rows of the parts."""
import json
import os

import plots
from drawing import LOOKS
from judgement import cheapest, efficiency, fastest, growth, settings, sizes_of
from text import count, number, table

TALUS, GREY = LOOKS["talus"][1], "#9aa5ad"
MISSING = "Not measured in this run."


def ms(row):
    return number(row["cpu_ms_per_step_median"])


def pile(results, values):
    lines, curves_of_error = [], {}
    for bodies in sizes_of(results):
        own = settings(results, size=bodies)
        rivals = [fastest(results.rows("pile", label=r, size=bodies))
                  for r in ("bullet", "bullet64", "ode")]
        rivals += results.rows("pile", label="lammps", bodies=bodies)
        for row in [*own, *(r for r in rivals if r)]:
            talus = row["label"] == "talus"
            lines.append([
                count(bodies), LOOKS[row["label"]][0], row.get("iterations", "-"), ms(row),
                number(row["ns_per_contact_iteration"]) if "iterations" in row else "-",
                number(1e3 * row["cpu_ms_per_step_median"] / row["bodies"]),
                number(row["penetration_mean"]), number(row["penetration_max"]),
                f"{row['bytes_stored_per_body']:.0f}" if talus else "-",
                f"{row['bytes_in_use_per_body']:.0f}" if talus else "-",
                f"{row['resident_bytes_per_body']:.0f}" if "resident_bytes_per_body" in row else "-"])
        curves_of_error[bodies] = [
            (r["label"], [(r["cpu_ms_per_step_median"], r["penetration_mean"],
                           r.get("iterations", ""))]) for r in rivals if r]
        mixed = results.rows("precision", label="mixed", size=bodies)
        for look, rows in (("talus_mixed", mixed), ("talus", own)):
            if look == "talus_mixed" and not rows:
                continue
            curves_of_error[bodies].insert(0, (look, [
                (r["cpu_ms_per_step_median"], r["penetration_mean"], r["iterations"])
                for r in rows]))
    values["pile"] = table(["bodies", "engine", "iterations", "ms per step",
                            "ns per contact and iteration", "microseconds per body", "mean overlap",
                            "largest", "bytes stored", "in use", "resident"], lines) \
        if lines else MISSING
    shown = [n for n in sizes_of(results) if len(curves_of_error[n]) > 1]
    for bodies in shown:
        plots.cost_against_error(results.output, f"error_{bodies}",
                                 f"Pile of {count(bodies)}: cost against error",
                                 curves_of_error[bodies])
    values["error plots"] = "\n\n".join(
        f"![cost against error](error_{bodies}.svg)" for bodies in shown)


def precision(results, values):
    rows = results.rows("precision")
    values["precision"] = table(
        ["solved in", "iterations", "ms per step", "mean overlap", "largest", "contact residual",
         "bytes in use per body", "of which contacts"],
        [["float" if r["label"] == "mixed" else "double", r["iterations"], ms(r),
          number(r["penetration_mean"]), number(r["penetration_max"]),
          number(r["contact_residual"]), f"{r['bytes_in_use_per_body']:.0f}",
          f"{r['bytes_of_contacts_per_body']:.0f}"]
         for r in sorted(rows, key=lambda r: (r["iterations"], r["label"]))]) if rows else MISSING


def curve(results):
    """Points (bodies, ms) of talus at fixed iterations and at a fixed error, and of the rivals."""
    sizes = sizes_of(results)
    curves = []
    for iterations, dashed in ((10, False), (5, False)):
        points = [(r["bodies"], r["cpu_ms_per_step_median"]) for n in sizes
                  for r in settings(results, size=n) if r["iterations"] == iterations]
        curves.append(("talus" if iterations == 10 else "talus_jacobi",
                       f"talus, {iterations} iterations", points, dashed))
    least = [min((r["penetration_mean"] for r in settings(results, size=n)), default=0)
             for n in sizes]
    if sizes:
        error = max(least)
        points = [cheapest(settings(results, size=n), error) for n in sizes]
        curves.append(("talus_small", f"talus, mean overlap at most {number(error)}",
                       [(r["bodies"], r["cpu_ms_per_step_median"]) for r in points], True))
    for rival in ("bullet", "bullet64", "ode", "lammps"):
        rows = [fastest(results.rows("pile", label=rival, bodies=n)) for n in sizes]
        curves.append((rival, LOOKS[rival][0], [(r["bodies"], r["cpu_ms_per_step_median"])
                                                for r in rows if r], False))
    return [c for c in curves if c[2]]


def growth_words(results, values):
    curves = curve(results)
    if not curves:
        values["growth"] = MISSING
        return
    plots.cost_against_bodies(results.output, curves)
    lines = [[c[1], f"{plots.slope(c[2]):.3f}", f"{count(c[2][0][0])} to {count(c[2][-1][0])}"]
             for c in curves if len(c[2]) > 1]
    text = "![cost against bodies](cost.svg)\n\n" + table(["curve", "exponent", "bodies"], lines)
    for iterations in (5, 10):
        found = growth(results, iterations)
        if found:
            text += f"\n\nAt {iterations} iterations a body of {count(found[1])} costs " \
                    f"{found[2]:.2f} times one of {count(found[0])}."
    values["growth"] = text


def scenes(results, values):
    """Everything that is not the pile: a line for each engine and setting."""
    lines = []

    def line(name, row, error, kind):
        lines.append([name, LOOKS.get(row["label"], (row["label"],))[0], row["iterations"],
                      count(row["bodies"]), ms(row), count(row["contacts"]), number(error), kind])

    for part, name in (("boxes", "boxes"), ("pyramid", "pyramid")):
        error = "penetration_mean" if part == "boxes" else "top_drift"
        kind = "mean overlap / edge" if part == "boxes" else "drift of the top / edge"
        for row in settings(results, part):
            line(name, row, row[error], kind)
        for rival in ("bullet", "bullet64", "ode"):
            row = fastest(results.rows(part, label=rival))
            if row:
                line(name, row, row[error], kind)
    for row in results.rows("grains"):
        lines.append([row["scene"], "talus", row["iterations"], count(row["bodies"]), ms(row),
                      count(row["contacts"]), number(row["penetration_mean"]),
                      "mean overlap / bounding radius"])
    for row in results.rows("well"):
        line("well", row, row["penetration_mean"], "mean overlap / radius")
    for row in results.rows("gas"):
        line("dilute gas", row, abs(row["energy_error"]), "relative change of energy")
    values["scenes"] = table(["scene", "engine", "iterations", "bodies", "ms per step", "contacts",
                              "error", "which is"], lines) if lines else MISSING
    sizes = []
    for label in dict.fromkeys(r["label"] for r in results.rows("sizes")):
        row, base = (fastest(results.rows("sizes", label=x)) for x in (label, "planes"))
        times = row["cpu_ms_per_step_median"] / base["cpu_ms_per_step_median"]
        sizes.append([label, ms(row), f"{times:.2f}",
                      f"{row['contacts'] / row['bodies']:.2f}", count(row["escaped"]),
                      number(row["penetration_mean"])])
    values["sizes"] = table(["vessel", "ms per step", "against planes", "contacts per body",
                             "escaped", "mean overlap"], sizes) if sizes else MISSING


def extra_work(results, label, scaling):
    """CPU time of all ranks over that of one, for as much work: what copies and contacts that two
    ranks compute cost. Threads sleep while they wait; processes do not, so theirs says nothing."""
    if label != "two threads":
        return "-"
    used = [min(r["cpu_seconds_mean"] * r["ranks"] / r["measure"] / r["bodies"]
                for r in results.rows("ranks", label=each, scaling=scaling))
            for each in ("one", label)]
    return f"{used[1] / used[0]:.2f}"


def ranks(results, values):
    lines = []
    for scaling in ("strong", "weak"):
        for label in dict.fromkeys(r["label"] for r in results.rows("ranks", scaling=scaling)):
            row = min(results.rows("ranks", scaling=scaling, label=label),
                      key=lambda r: r["wall_ms_per_step_median"])
            value = efficiency(results, label, scaling)
            lines.append([scaling, label, count(row["bodies"]),
                          number(row["wall_ms_per_step_median"]),
                          "-" if label == "one" or not value else f"{value:.2f}",
                          extra_work(results, label, scaling),
                          f"{100 * row['exchange_share']:.1f} %",
                          f"{row['messages_per_step_max']:g}",
                          f"{row['bytes_per_step_max'] / 1024:.0f}"])
    strong = results.row("ranks", scaling="strong")
    alone = [r for r in settings(results, size=strong["bodies"]) if r["iterations"] == 10] \
        if strong else []
    for row in alone:
        lines.insert(1, ["strong", "one, without ranks", count(row["bodies"]), ms(row), "-", "-", "-",
                         "-", "-"])
    values["ranks"] = table(["scaling", "ranks", "bodies", "wall ms per step", "efficiency",
                             "CPU time against one", "exchange and waiting", "messages per rank and step",
                             "KiB per rank and step"], lines) if lines else MISSING


def features(results, values):
    rows = results.rows("features")
    if not rows:
        values["features"] = MISSING
        return
    base = rows[0]["cpu_ms_per_step_median"]
    values["features"] = "![cost of features](features.svg)\n\n" + table(
        ["world", "ms per step", "against the first", "bytes stored", "bytes in use"],
        [[r["policies"], ms(r), f"{r['cpu_ms_per_step_median'] / base:.2f}",
          f"{r['bytes_stored_per_body']:g}", f"{r['bytes_in_use_per_body']:.0f}"] for r in rows])
    plots.bars(results.output, "features", "What features cost", "the same settled pile",
               [(r["policies"], r["cpu_ms_per_step_median"], TALUS if r is rows[0] else GREY,
                 f"{r['cpu_ms_per_step_median'] / base:.2f}") for r in rows],
               "CPU milliseconds per step")


def compile_cost(results, values):
    path = os.path.join(results.output, "compile.json")
    if not os.path.exists(path):
        values["compile"] = "Not measured: there is no compile.json beside this page."
        return
    with open(path) as file:
        rows = json.load(file)
    keys = list(dict.fromkeys(key for row in rows for key in row))
    values["compile"] = table([key.replace("_", " ") for key in keys],
                              [[number(row[key]) if isinstance(row.get(key), float)
                                else row.get(key, "-") for key in keys] for row in rows])


__all__ = ["pile", "growth_words", "scenes", "ranks", "features", "compile_cost"]
