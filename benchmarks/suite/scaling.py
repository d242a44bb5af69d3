"""docs/scaling.md: messages and bytes as counted, and what a model of the network makes of them."""
import math
import os
import re

import plots
from results import replace
from text import count, number, table

HERE = os.path.dirname(os.path.abspath(__file__))

# Latency of a message in microseconds, overhead of each further one that a rank sends at once,
# bandwidth of a node in GB/s and what of its memory's a rank has, ranks of a node, GFlop/s of a rank
# (0: like the core that we measured on). See the page for the sources.
NETWORKS = {
    "InfiniBand HDR": {"latency": 1.5, "overhead": 0.3, "node_bandwidth": 25.0,
                       "memory_of_rank": 5.0, "ranks_per_node": 64, "gflops": 0},
    "Blue Gene/Q": {"latency": 2.5, "overhead": 0.6, "node_bandwidth": 20.0,
                    "memory_of_rank": 0.4, "ranks_per_node": 64, "gflops": 3.2},
}
NEIGHBOURS = {2: 8, 3: 26}
NOISE = 0.005  # mean of the delay of a rank by its system in a step, as part of the step; assumed
BODIES = [1000, 10000, 100000]  # of a rank
RANKS = [27, 1000, 10000, 100000, 458752, 1000000]


def counted(results):
    """What the thread ranks counted, in the order of their number."""
    rows = [r for r in results.rows("threads") if r["label"].isdigit()]
    return sorted(rows, key=lambda r: r["ranks"])


def per_body_and_copy(results):
    """Microseconds of one body in a step on one rank, and bytes that a shadow copy costs in a step."""
    alone = min(results.rows("ranks", label="one", scaling="strong"), key=us_per_body, default=None)
    two = results.row("ranks", label="two processes", scaling="strong")
    limits = results.row("limits")
    if not alone or not limits or not two or not two["shadow_copies_max"]:
        return None
    # Copies of the face of a cube of n bodies, over n^(2/3): one cut through the pile has them all.
    face = two["shadow_copies_max"] / two["bodies"] ** (2 / 3)
    return {"us_per_body": us_per_body(alone),
            "relaxations": alone["contacts_mean"] / alone["bodies"] * alone["iterations"] /
            us_per_body(alone),
            "bytes_per_copy": two["bytes_per_step_max"] / two["shadow_copies_max"],
            "copies_per_face": face, "waiting": waiting(results), "gflops": limits["gflops_one_core"]}


def us_per_body(row):
    """CPU time, which other programs on the machine change the least."""
    return 1e6 * row["cpu_seconds_mean"] / row["measure"] / row["bodies"]


def exchanges(row):
    """Exchanges of a step with each neighbour."""
    return row["messages_per_step_max"] / row["neighbours_max"]


def step_us(network, unit, bodies, rounds, dimension=3):
    """Microseconds of computing, and of exchanging: in each exchange a latency, an overhead for each
    neighbour, and the bytes (Hockney's model with the overhead of LogGP). The ranks of a node are a
    cube, so that of a rank's faces one in cbrt(ranks) leaves the node and shares its link; the bytes
    of the others are read and written once in memory. Nothing overlaps. A rank waits besides for the
    part of its computing that unit["waiting"] gives."""
    computing = bodies * unit["us_per_body"]
    if network["gflops"]:
        computing *= unit["gflops"] / network["gflops"]
    neighbours, node = NEIGHBOURS[dimension], network["ranks_per_node"]
    bytes_of_step = 6 * unit["copies_per_face"] * bodies ** (2 / 3) * unit["bytes_per_copy"]
    leaving = bytes_of_step / node ** (1 / 3)
    moving = leaving * node / (1e3 * network["node_bandwidth"]) + \
        2 * (bytes_of_step - leaving) / (1e3 * network["memory_of_rank"])
    latencies = rounds * (network["latency"] + neighbours * network["overhead"])
    return computing, latencies + moving + unit["waiting"] * computing, bytes_of_step


def on_two(results):
    """The fastest run on two MPI processes of this machine: its row, the latency of an exchange in
    microseconds, the rate in bytes per microsecond, and the microseconds of the exchanges of a step, as
    the messages alone would have it and as the clock of the library has it."""
    rows = [r for r in results.rows("ranks", label="two processes", scaling="strong")
            if r.get("exchange_of_8_bytes_us")]
    if not rows:
        return None
    row = min(rows, key=lambda r: r["wall_ms_per_step_median"])
    latency = row["exchange_of_8_bytes_us"]
    rate = (1 << 16) / max(1e-3, row["exchange_of_64_kib_us"] - latency)
    modelled = exchanges(row) * latency + row["bytes_per_step_max"] / rate
    return row, latency, rate, modelled, 1e6 * row["exchange_seconds_mean"] / row["measure"]


def waiting(results):
    """What an exchange takes besides its messages, as part of the computing of a step: waiting for the
    other rank, whose work differs from step to step, and making and reading the messages. Measured on two
    processes of one machine."""
    found = on_two(results)
    if not found:
        return 0
    row, _, _, modelled, clock = found
    step = clock / row["exchange_share"]  # the mean, as the clock has it
    return max(0, clock - modelled) / (step - clock)


def check_on_two(results):
    """The model against what two MPI processes of this machine take."""
    found = on_two(results)
    if not found:
        return "Not measured in this run."
    row, latency, rate, modelled, waited = found
    return (f"An exchange of eight bytes between two processes of this machine takes {number(latency)} "
            f"microseconds, and 64 KiB go at {number(1e-3 * rate)} GB/s. With these the model gives "
            f"{number(modelled)} microseconds for the exchanges of a step of the pile of "
            f"{count(row['bodies'])} on two processes; the library's clock says {number(waited)}, in "
            f"which making and reading the messages and waiting for the other rank are "
            f"included: {100 * row['exchange_share']:.1f} % of the step. The rest, {100 * waiting(results):.1f} % of "
            f"the computing, enters the model as waiting.")


def on_cluster(results):
    """The model against two nodes of an emulated cluster."""
    rows = results.rows("cluster")
    if not rows:
        return "Not measured in this run: it needs root, network namespaces and two cores."
    late = waiting(results)

    def corrected(r):
        """Milliseconds of the exchanges with the waiting, and the efficiency that follows."""
        alone = r["one_wall_ms_per_step_median"]
        exchange = r["modelled_exchange_ms"] + late * alone / 2
        return exchange, alone / (alone + 2 * exchange)

    lines = [[r["label"] + ("" if r["emulated_by"] != "tbf" else " (no delay)"), r["solver"],
              number(r["wall_ms_per_step_median"]), f"{r['exchanges']:g}",
              number(r["bytes_per_step_max"] / 1024), number(r["latency_us"]),
              number(r["rate_gb_per_s"]), number(r["exchange_ms"]),
              number(r["modelled_exchange_ms"]), number(corrected(r)[0]),
              f"{r['efficiency']:.2f}", f"{r['modelled_efficiency']:.2f}",
              f"{corrected(r)[1]:.2f}"] for r in rows]
    return table(["link", "solver", "ms per step", "exchanges", "KiB per rank and step",
                  "latency, microseconds", "GB/s", "exchange, ms", "messages alone", "with waiting",
                  "efficiency", "messages alone", "with waiting"], lines)


def noise(ranks):
    """The step waits for the slowest of all ranks, at worst: the largest of as many exponential
    delays is the logarithm of their number times their mean."""
    return NOISE * (math.log(ranks) + 0.5772)


def prediction(results, unit, rounds):
    lines, curves = [], []
    for name, network in NETWORKS.items():
        for bodies in BODIES:
            computing, exchanging, moved = step_us(network, unit, bodies, rounds)
            against_one = computing / (computing + exchanging)
            worst = 1 / (1 + noise(RANKS[-1]))
            lines.append([name, count(bodies), number(computing), number(exchanging),
                          number(moved / 1024), f"{100 * against_one:.1f} %", "100 %",
                          f"{100 * worst * (1 + noise(RANKS[0])):.1f} %"])
            if bodies == 1000 or name == "InfiniBand HDR":
                curves.append((f"{name}, {count(bodies)} bodies a rank",
                               COLOURS[len(curves) % len(COLOURS)],
                               [(p, against_one / (1 + noise(p))) for p in RANKS]))
    plots.against_ranks(results.output, "weak_scaling",
                        "Weak scaling as the model has it, against one rank alone",
                        "modelled from counted messages; with an assumed noise of 0.5 % of a step",
                        curves, "efficiency", top=1.05,
                        band=(0.91, 0.93, "Preclik and Rüde 2015, measured"))
    return table(["network", "bodies of a rank", "computing, microseconds", "exchanging",
                  "KiB per rank and step", "efficiency against one rank", "against 27 ranks",
                  "the same with noise, 10^6 ranks"], lines)


COLOURS = ["#0072B2", "#56B4E9", "#009E73", "#D55E00"]


def counts(results, values):
    rows = counted(results)
    values["counts"] = "Not measured in this run."
    if not rows:
        return
    rows += [r for r in results.rows("threads") if not r["label"].isdigit()]
    values["counts"] = table(
        ["ranks", "neighbours, most", "messages per rank and step, most", "mean",
         "KiB per rank and step, most", "mean", "KiB in use per rank, most", "mean",
         "resident KiB per rank", "collective calls"],
        [[r["label"], f"{r['neighbours_max']:g}", f"{r['messages_per_step_max']:g}",
          f"{r['messages_per_step_mean']:.1f}", f"{r['bytes_per_step_max'] / 1024:.1f}",
          f"{r['bytes_per_step_mean'] / 1024:.1f}", f"{r['bytes_in_use_max'] / 1024:.1f}",
          f"{r['bytes_in_use_mean'] / 1024:.1f}", f"{r['resident_bytes_per_rank'] / 1024:.0f}",
          f"{r['collectives_max']:g}"] for r in rows])
    flat = counted(results)
    full = [r["bytes_in_use_max"] for r in flat if r["ranks"] >= 16]
    if full:
        values["memory"] = f"{100 * (max(full) / min(full) - 1):.1f} %"
    plots.against_ranks(
        results.output, "flat", "Messages, bytes and memory of the busiest rank",
        "64 spheres a rank in a grid; flat is what scales",
        [("messages per step", "#0072B2", [(r["ranks"], r["messages_per_step_max"]) for r in flat]),
         ("KiB per step", "#D55E00", [(r["ranks"], r["bytes_per_step_max"] / 1024) for r in flat]),
         ("KiB in use", "#009E73", [(r["ranks"], r["bytes_in_use_max"] / 1024) for r in flat])],
        "per rank", ticks=[r["ranks"] for r in flat])


def write(results):
    """The page beside docs/performance/, if the counts are there."""
    values = {}
    counts(results, values)
    values["check"] = check_on_two(results)
    values["cluster"] = on_cluster(results)
    rows, unit = counted(results), per_body_and_copy(results)
    values["prediction"] = "Not measured in this run."
    if rows and unit:
        rounds = exchanges(rows[-1])
        values["prediction"] = prediction(results, unit, rounds)
        values.update(rounds=f"{rounds:g}", us=number(unit["us_per_body"]),
                      copy=number(unit["bytes_per_copy"]), face=number(unit["copies_per_face"]),
                      few=count(rows[0]["ranks"]), many=count(rows[-1]["ranks"]),
                      messages=f"{rows[-1]['messages_per_step_max']:g}",
                      relaxations=number(unit["relaxations"]))
    with open(os.path.join(HERE, "scaling.md")) as file:
        text = file.read()
    for key, value in values.items():
        text = text.replace("{{" + key + "}}", value)
    text = re.sub("{{[^}]*}}", "?", text)
    folder = os.path.basename(os.path.normpath(results.output))
    replace(os.path.join(results.output, "..", "scaling.md"), text.replace("FOLDER", folder))
