"""The parts of the suite: what is run, in which order, with which settings."""
import json
import os
import sys

import lammps
from runs import output_of

ITERATIONS = [1, 2, 3, 5, 10]
RANKS = [4, 16, 64, 256, 1024]


def limits(bench):
    bench.run("limits", "machine", "limits",
              **({"milliseconds": 50, "megabytes": 64} if bench.quick else {}))


def pile(bench):
    """talus before and after its rivals, so that a change of the machine's pace shows."""
    sizes = [200, 500] if bench.quick else [1000, 8000]
    rivals = ["bullet", "bullet64", "ode"]
    short = {"settle": 60, "measure": 20} if bench.quick else {}
    for bodies in sizes:
        for when in ("before", "after"):
            for iterations in ITERATIONS:
                bench.run("pile", "talus", "pile", bodies=bodies, iterations=iterations,
                          tags={"asked": iterations, "size": bodies, "when": when}, **short)
            if when == "before":
                for rival in rivals:
                    if rival == "bullet64" and bodies > 1000 and not bench.full:
                        continue
                    bench.run("pile", rival, f"pile_{rival}", bodies=bodies,
                              tags={"size": bodies}, **short)
        lammps.measure(bench, "pile", bodies)
    large_pile(bench)
    if bench.full:
        # They would settle for hours: from where talus has settled, with time to find their own rest.
        bodies = 1000 if bench.quick else 64000
        for rival in rivals:
            bench.run("pile", rival, f"pile_{rival}", bodies=bodies, settle=90, measure=12,
                      tags={"size": bodies}, **{"from": bench.settled(bodies)})


def precision(bench):
    """Contacts solved in double and in float, in turns."""
    bodies = 500 if bench.quick else 8000
    short = {"settle": 60, "measure": 20} if bench.quick else {"settle": 720, "measure": 120}
    for iterations in [1, 5, 20] if bench.quick else [1, 2, 5, 10, 20, 50]:
        for numbers in ("double", "mixed"):
            bench.run("precision", numbers, "pile", bodies=bodies, iterations=iterations,
                      precision=numbers, tags={"asked": iterations, "size": bodies}, **short)


def large_pile(bench):
    """Each number of iterations settles for itself here too: what a tall pile overlaps by depends on
    the iterations that it was settled with. Half a million bodies settle once, at least as long as
    they fall."""
    few, many = (1000, 2000) if bench.quick else (64000, 512000)
    settle, relax, measure = (60, 10, 5) if bench.quick else (720, 30, 40)
    for iterations in (3, 5, 10):
        keep = {"keep": bench.state(few)} if iterations == 5 else {}
        bench.run("pile", "talus", "pile", bodies=few, iterations=iterations, settle=settle,
                  relax=relax, measure=measure,
                  tags={"asked": iterations, "size": few, "when": "once"}, **keep)
    if os.path.exists(bench.state(few)):
        bench.settled_here.add(bench.state(few))
    if not (bench.keep and bench.results.rows("pile", size=many)):
        start = bench.settled(many, settle=settle * 2 // 3, longest=settle)
        bench.run("pile", "talus", "pile", bodies=many, iterations="5,10", settle=relax,
                  relax=relax, measure=min(measure, 12),
                  tags={"size": many, "when": "once"}, **{"from": start})
        os.remove(start)


def sizes(bench):
    bodies = 500 if bench.quick else 8000
    short = {"settle": 60, "measure": 20} if bench.quick else {"settle": 720, "measure": 60}
    for when in ("first", "second"):
        for ratio in (0, 100, 1000):
            bench.run("sizes", f"1:{ratio}" if ratio else "planes", "pile", bodies=bodies,
                      ratio=ratio, iterations=10, tags={"when": when}, **short)


def shapes(bench):
    short = {"settle": 60, "measure": 10} if bench.quick else {}
    scenes = (("boxes", "boxpile", 64 if bench.quick else 1000),
              ("pyramid", "pyramid", 6 if bench.quick else 20))
    for table, scene, bodies in scenes:
        for engine, iterations in [("talus", 2), ("talus", 3), ("talus", 5), ("talus", 10), ("bullet", 0),
                                   ("bullet64", 0), ("ode", 0), ("talus", 10)]:
            first = not bench.results.row(table, label=engine, asked=iterations)
            bench.run(table, engine, "crates" + ("" if engine == "talus" else "_" + engine),
                      scene=scene, bodies=bodies, iterations=iterations,
                      tags={"asked": iterations, "when": "before" if first else "after"}, **short)
    for shape in ("capsule", "ellipsoid", "union"):
        bench.run("grains", shape, "grains", shape=shape, bodies=64 if bench.quick else 1000,
                  **short)


def well(bench):
    short = {"bodies": 300, "steps": 300, "measure": 50} if bench.quick else {}
    for engine in ("talus", "bullet") if bench.full or bench.quick else ("talus",):
        bench.run("well", engine, "well" if engine == "talus" else f"well_{engine}", **short)


def gas(bench):
    few, many = (500, 1000) if bench.quick else (8000, 64000)
    for label, bodies in (("talus", few), ("bullet", few), ("talus", many)):
        bench.run("gas", label, "gas" if label == "talus" else "gas_bullet", bodies=bodies,
                  tags={"size": bodies})


def ranks(bench):
    """One rank and two, in turns, on one pile: as MPI processes and as threads. And the same number
    of bodies for each rank."""
    bodies = 1000 if bench.quick else 64000
    steps = {"settle": 5, "measure": 5} if bench.quick else {"settle": 30, "measure": 30}
    start = bench.settled(bodies)
    for turn in range(1 if bench.quick else 3):
        tags = {"turn": turn, "scaling": "strong"}
        two = {"cells_x": 2, "cells_y": 1}
        common = {"bodies": bodies, "from": start, **steps}
        bench.run("ranks", "one", "ranks", tags=tags, **common)
        bench.run("ranks", "two processes", "ranks", processes=2, tags=tags, **two, **common)
        bench.run("ranks", "two threads", "ranks", tags=tags, ranks=2, **two, **common)
    bed = {"columns_per_rank": 8 if bench.quick else 32,
           "bodies_per_rank": 512 if bench.quick else 32000}
    states = [bench.settle(os.path.join(bench.states, f"bed_{n}.bin"), f"a bed for {n} ranks",
                           {**bed, "ranks": n, "cells_x": n, "cells_y": 1}) for n in (1, 2)]
    for turn in range(1 if bench.quick else 2):
        tags = {"turn": turn, "scaling": "weak"}
        bench.run("ranks", "one", "ranks", tags=tags, **bed, **steps, **{"from": states[0]})
        bench.run("ranks", "two processes", "ranks", processes=2, tags=tags, **two, **bed, **steps,
                  **{"from": states[1]})
    side_by_side(bench, {**bed, **steps, "from": states[0]})


def side_by_side(bench, beds):
    """What two cores do for two programs that know nothing of each other: no ranks can do better."""
    tags = {"label": "two programs", "scaling": "weak"}
    if bench.keep and bench.results.row("ranks", **tags):
        return
    words = bench.command("ranks", beds)
    said = bench.together([words, words])
    if said is None:
        bench.results.say("ranks: two programs beside each other failed")
        return
    rows = [json.loads(each) for each in said]
    bench.results.add("ranks", {**max(rows, key=lambda r: r["wall_ms_per_step_median"]), **tags})
    bench.results.say("ranks: two programs beside each other")


def cluster(bench):
    """Two nodes of an emulated cluster, where this machine can emulate one."""
    if bench.keep and bench.results.rows("cluster"):
        return
    program = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "cluster", "cluster.py")
    file = os.path.join(bench.states, "cluster.json")
    words = [sys.executable, program, bench.build, "--turns", "2", "--json", file,
             "--from", bench.settled(1000 if bench.quick else 64000)]
    said, complaint = output_of([*words, "--quick"] if bench.quick else words)
    if said is None:
        bench.results.say(f"cluster: failed: {complaint}")
        return
    with open(file) as rows:
        bench.add("cluster", rows.read(), {})
    bench.results.say("cluster: two nodes" if bench.results.rows("cluster") else
                      "cluster: left out, this machine cannot emulate one")


def threads(bench):
    for ranks in RANKS[:3] if bench.quick else RANKS:
        bench.run("threads", f"{ranks}", "ranks", ranks=ranks, bodies_per_rank=64,
                  columns_per_rank=4, settle=60 if bench.quick else 150, measure=10)
    bench.run("threads", "64 in three dimensions", "ranks", ranks=64, bodies_per_rank=64,
              columns_per_rank=4, cells_x=4, cells_y=4, cells_z=4,
              settle=60 if bench.quick else 150, measure=10)


def features(bench):
    bodies = 500 if bench.quick else 8000
    start = bench.settled(bodies)
    if not (bench.keep and bench.results.rows("features")):
        bench.run("features", "talus", "features", bodies=bodies, settle=60,
                  measure=20 if bench.quick else 120, **{"from": start})


def budget(bench):
    for bodies in [500] if bench.quick else [8000, 64000]:
        if bench.keep and bench.results.rows("budget", size=bodies):
            continue
        bench.run("budget", "talus", "budget", bodies=bodies, settle=60, tags={"size": bodies},
                  measure=20 if bench.quick else 120 if bodies < 10000 else 30,
                  **{"from": bench.settled(bodies)})


PARTS = {each.__name__: each for each in
         (limits, pile, precision, sizes, shapes, well, gas, ranks, cluster, threads, features, budget)}
# The tables that each part fills, where they are not called as the part is.
TABLES = {"shapes": ["boxes", "pyramid", "grains"]}

# What each part runs. A settled pile, where one is needed, comes from `ranks`.
PROGRAMS = {
    "limits": ["limits"],
    "pile": ["pile", "pile_bullet", "pile_bullet64", "pile_ode", "judge"],
    "precision": ["pile"],
    "sizes": ["pile"],
    "shapes": ["crates", "crates_bullet", "crates_bullet64", "crates_ode", "grains"],
    "well": ["well", "well_bullet"],
    "gas": ["gas", "gas_bullet"],
    "ranks": ["ranks"],
    "cluster": ["ranks"],
    "threads": ["ranks"],
    "features": ["ranks", "features"],
    "budget": ["ranks", "budget"],
}
