"""The budget of a step: what each phase takes, and how far that is from what the machine can do."""
import math

import plots
from drawing import LOOKS
from text import count, number, table

# Sizes that the triad was measured at, in bytes; "memory" stands for whatever is larger.
SIZES = {"24_kib": 24 << 10, "1_mib": 1 << 20, "4_mib": 4 << 20, "24_mib": 24 << 20,
         "memory": 768 << 20}


def bandwidth(limits, working_set):
    """GB/s for a working set, on a straight line between the sizes measured (on log axes)."""
    points = [(math.log(size), math.log(limits[f"gb_per_s_{name}_one_core"]))
              for name, size in SIZES.items() if f"gb_per_s_{name}_one_core" in limits]
    at = min(max(math.log(working_set), points[0][0]), points[-1][0])
    for (x0, y0), (x1, y1) in zip(points, points[1:]):
        if at <= x1:
            return math.exp(y0 + (y1 - y0) * (at - x0) / (x1 - x0))
    return math.exp(points[-1][1])


def rows_of(results, bodies):
    """(phase, ms, share, ns per contact and time, least ms by bytes, by operations) of one pile."""
    limits = results.row("limits")
    rows = results.rows("budget", size=bodies)
    if not limits or not rows:
        return []
    rate = bandwidth(limits, rows[0]["working_set_bytes"])
    found = []
    for row in rows:
        if row["ms_per_step"] <= 0 or row["times_per_step"] == 0:
            continue  # too little to be told from the rest
        by_bytes = 1e-6 * row["bytes_per_step"] / rate
        by_flops = 1e-6 * row["flops_per_step"] / limits["gflops_one_core"]
        found.append({
            "phase": row["phase"], "ms": row["ms_per_step"],
            "share": row["ms_per_step"] / row["ms_of_step"],
            "ns": 1e6 * row["ms_per_step"] / row["contacts"] / row["times_per_step"],
            "bytes": row["bytes_per_step"] / row["contacts"] / row["times_per_step"],
            "flops": row["flops_per_step"] / row["contacts"] / row["times_per_step"],
            "by_bytes": by_bytes, "by_flops": by_flops, "limit": max(by_bytes, by_flops)})
    return found


def write(results, values):
    limits = results.row("limits")
    values["limits"] = "Not measured in this run."
    values["budget"] = values["limits"]
    if not limits:
        return
    values["limits"] = table(
        ["what", "one core", f"{limits['cores']} cores"],
        [[f"multiply-adds in registers of {limits['vector_bits']} bits, GFlop/s",
          number(limits["gflops_one_core"]), "-"]] +
        [[f"triad, {name.replace('_', ' ').replace('kib', 'KiB').replace('mib', 'MiB')}, GB/s",
          number(limits[f"gb_per_s_{name}_one_core"]), number(limits[f"gb_per_s_{name}_all_cores"])]
         for name in SIZES if f"gb_per_s_{name}_one_core" in limits])
    texts = []
    for bodies in dict.fromkeys(r["size"] for r in results.rows("budget")):
        first = results.row("budget", size=bodies)
        rows = rows_of(results, bodies)
        rate = bandwidth(limits, first["working_set_bytes"])
        texts.append(
            f"### {count(bodies)} bodies, {count(first['contacts'])} contacts\n\n"
            f"{number(first['ms_of_step'])} ms per step with 10 iterations; the neighbour list is rebuilt in "
            f"{100 * first['searches_per_step']:.0f} % of the steps. The sweeps work on "
            f"{number(first['working_set_bytes'] / 2**20)} MiB, for which the triad has {number(rate)} "
            f"GB/s (between the sizes measured).\n\n" + table(
                ["phase", "ms", "share", "ns per contact and time", "bytes", "operations",
                 "least ms by bytes", "by operations", "times its limit"],
                [[r["phase"], number(r["ms"]), f"{100 * r['share']:.0f} %", number(r["ns"]),
                  f"{r['bytes']:.0f}", f"{r['flops']:.0f}", number(r["by_bytes"]),
                  number(r["by_flops"]), f"{r['ms'] / r['limit']:.1f}"] for r in rows]))
        plots.bars(results.output, f"budget_{bodies}", f"Where a step goes: {count(bodies)} bodies",
                   "in brackets: how many times its limit a phase takes",
                   [(r["phase"], r["ms"], LOOKS["talus"][1],
                     f"{number(r['ms'])} ms ({r['ms'] / r['limit']:.1f})") for r in rows],
                   "CPU milliseconds per step")
        texts.append(f"![budget](budget_{bodies}.svg)")
    if texts:
        values["budget"] = "\n\n".join(texts)
