"""How the engine is judged: each target beside what this run measured, and whether it is met."""
from text import count, number


def fastest(rows):
    """The row of the shortest typical step; the same program may have run several times."""
    return min(rows, key=lambda r: r["cpu_ms_per_step_median"], default=None)


def settings(results, part="pile", **wanted):
    """talus' rows on a scene, one for each number of iterations. What ran before and after the rivals
    counts with the mean of both: the faster one alone would be luck that rivals, who run once, do
    not have."""
    rows = results.rows(part, label="talus", **wanted)
    by_iterations = {}
    for row in rows:
        by_iterations.setdefault(row["iterations"], []).append(row)
    return [{**rows[0], **{key: sum(r[key] for r in rows) / len(rows)
                           for key in ("cpu_ms_per_step_median", "ns_per_contact_iteration")
                           if key in rows[0]}}
            for _, rows in sorted(by_iterations.items())]


def cheapest(rows, error):
    """The cheapest of talus' settings whose error is no larger."""
    return fastest([r for r in rows if r["penetration_mean"] <= error])


def sizes_of(results):
    return sorted({r["size"] for r in results.rows("pile", label="talus") if "size" in r})


class Verdicts:
    """Lines of the table: what, target, measured, met (None: not measured)."""

    def __init__(self):
        self.lines = []

    def add(self, what, target, measured, met):
        verdict = "not measured" if met is None else "yes" if met else "**no**"
        self.lines.append([what, target, measured or "-", verdict])

    def at_least(self, what, value, least, measured):
        self.add(what, f"at least {least}", measured, None if value is None else value >= least)


def against_rival(verdicts, what, rows, rival, least, error=None):
    """How many times less time talus takes at the cheapest setting within the error allowed."""
    if rival is None or not rows:
        verdicts.at_least(what, None, least, "")
        return
    allowed = min(error or float("inf"), rival["penetration_mean"])
    own = cheapest(rows, allowed)
    if own is None:
        best = min(rows, key=lambda r: r["penetration_mean"])
        verdicts.add(what, f"at least {least}", "no setting is within "
                     f"{number(allowed)}; least error {number(best['penetration_mean'])}", False)
        return
    value = rival["cpu_ms_per_step_median"] / own["cpu_ms_per_step_median"]
    verdicts.at_least(
        what, value, least,
        f"{value:.1f} ({number(rival['cpu_ms_per_step_median'])} ms at "
        f"{number(rival['penetration_mean'])}; talus, {own['iterations']} iterations: "
        f"{number(own['cpu_ms_per_step_median'])} ms at {number(own['penetration_mean'])})")


def judge_speed(results, verdicts):
    sizes = sizes_of(results)
    quick = results.machine.get("quick") and len(sizes) > 2  # its own sizes instead
    for at, bodies, rival, name, least in (
            (0, 1000, "bullet", "Bullet", 8), (1, 8000, "bullet", "Bullet", 15),
            (1, 8000, "ode", "ODE", 25), (2, 64000, "bullet", "Bullet", 15)):
        bodies = sizes[at] if quick else bodies
        against_rival(verdicts, f"Pile of {count(bodies)}: times less CPU time than {name}",
                      settings(results, size=bodies),
                      fastest(results.rows("pile", label=rival, size=bodies)), least,
                      1e-4 if bodies <= 8000 else None)
    against_rival(verdicts, "Pile of boxes: times less than Bullet", settings(results, "boxes"),
                  fastest(results.rows("boxes", label="bullet")), 4)
    judge_pyramid(results, verdicts)
    for row in results.rows("pile", label="lammps"):
        against_rival(verdicts, f"Pile of {count(row['bodies'])}: times less CPU time per simulated "
                      "second than LAMMPS granular", settings(results, size=row["bodies"]), row, 4)


def judge_pyramid(results, verdicts):
    rival = fastest(results.rows("pyramid", label="bullet"))
    own = [r for r in settings(results, "pyramid") if rival and r["top_drift"] < rival["top_drift"]]
    what = "Pyramid of 20: times less than Bullet, with less drift of the top"
    if rival is None or not own:
        verdicts.add(what, "at least 3", "no setting drifts less" if rival else "",
                     False if rival and settings(results, "pyramid") else None)
        return
    best = fastest(own)
    value = rival["cpu_ms_per_step_median"] / best["cpu_ms_per_step_median"]
    verdicts.at_least(what, value, 3,
                      f"{value:.1f} ({number(rival['cpu_ms_per_step_median'])} ms, drift "
                      f"{number(rival['top_drift'])}; talus, {best['iterations']} iterations: "
                      f"{number(best['cpu_ms_per_step_median'])} ms, {number(best['top_drift'])})")


def growth(results, iterations):
    """Cost per body of the largest pile over that of 8,000 (a quick run: of the second smallest)."""
    sizes = sizes_of(results)
    if len(sizes) < 3:
        return None
    few, many = (8000 if 8000 in sizes else sizes[1]), sizes[-1]
    rows = [next((r for r in settings(results, size=n) if r["iterations"] == iterations), None)
            for n in (few, many)]
    if None in rows:
        return None
    per_body = [r["cpu_ms_per_step_median"] / r["bodies"] for r in rows]
    return few, many, per_body[1] / per_body[0]


def judge_growth(results, verdicts):
    for iterations in (10, 5):
        found = growth(results, iterations)
        if found:
            few, many, value = found
            verdicts.add(f"Cost per body from {count(few)} to {count(many)}, {iterations} iterations",
                         "below 1.6 times", f"{value:.2f}", value < 1.6)
    base = fastest(results.rows("sizes", label="planes"))
    for ratio in (100, 1000):
        row = fastest(results.rows("sizes", label=f"1:{ratio}"))
        value = row["cpu_ms_per_step_median"] / base["cpu_ms_per_step_median"] if row and base \
            else None
        verdicts.add(f"Cost per body at a size ratio of 1:{ratio}, against one size",
                     "below 2 times", f"{value:.2f}" if value else "", value and value < 2)


def efficiency(results, label, scaling="strong"):
    """Of two ranks against one: wall times of the fastest turn of each."""
    walls = [min((r["wall_ms_per_step_median"] for r in
                  results.rows("ranks", label=each, scaling=scaling)), default=None)
             for each in ("one", label)]
    if None in walls:
        return None
    return walls[0] / walls[1] / (2 if scaling == "strong" else 1)


def judge_ranks(results, verdicts):
    for label, what in (("two processes", "MPI processes"), ("two threads", "threads")):
        value = efficiency(results, label)
        bodies = results.row("ranks", scaling="strong")
        verdicts.at_least(f"Parallel efficiency of two {what} on "
                          f"{count(bodies['bodies']) if bodies else '64,000'} spheres", value, 0.9,
                          f"{value:.2f}" if value else "")
    few, many = (results.row("threads", label=n) for n in ("64", "1024"))
    met = None if None in (few, many) else \
        few["messages_per_step_max"] == many["messages_per_step_max"]
    verdicts.add("Messages of the busiest rank per step at 64 and 1,024 ranks", "the same",
                 f"{few['messages_per_step_max']:g} and {many['messages_per_step_max']:g}"
                 if met is not None else "", met)


def judge_memory(results, verdicts):
    row = next((r for r in results.rows("pile", label="talus") if "bytes_stored_per_body" in r),
               None)
    verdicts.add("Bytes stored per sphere, without contacts", "at most 160",
                 f"{row['bytes_stored_per_body']:g}" if row else "",
                 row["bytes_stored_per_body"] <= 160 if row else None)


def judge(results):
    verdicts = Verdicts()
    judge_speed(results, verdicts)
    judge_growth(results, verdicts)
    judge_ranks(results, verdicts)
    judge_memory(results, verdicts)
    return verdicts.lines
