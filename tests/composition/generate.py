"""Scenarios in which each pair of policies occurs, unless the two are refused together.

    generate.py --out DIR [--seed N] [--list]

Writes DIR/scene_NN.cpp, one for each scenario, and prints the seed and the pairs that no scenario
can have. The same seed gives the same scenarios. Those of lowest number cover the most pairs.
"""
import argparse
import functools
import itertools
import pathlib
import random

ON_OFF = ["orientation", "forces", "user_ids", "visibility", "damping", "continuous_collision",
          "sleeping", "balancing", "vtk_output", "driven", "energy_ledger", "momentum_balance",
          "penetration_monitor", "residual_monitor", "contact_filters", "events"]
FACTORS = {
    "shapes": ["spheres", "boxes", "rounded", "compound", "smooth"],
    "law": ["hard", "hard_smooth", "hard_overlapping", "soft_linear", "soft_hertz"],
    "solver": ["nonlinear_gauss_seidel", "reproducible", "accelerated_jacobi", "substepping", "none"],
    "broad_phase": ["linear_hash_grid", "sweep_and_prune"],
    "integrator": ["semi_implicit_euler", "velocity_verlet", "moreau_midpoint"],
    "decomposition": ["grid", "ring", "hexagonal", "bisection", "periodic", "cells"],
    "transport": ["threads", "serial"],
    "precision": ["double", "mixed_precision"],
    **{name: ["off", "on"] for name in ON_OFF},
}
NAMES = list(FACTORS)


def refused(a, b):
    """Whether two values of two factors contradict each other; docs/policies/features.md has the reasons."""
    def pair(factor, values, other, others):
        return any(x[0] == factor and x[1] in values and y[0] == other and y[1] in others
                   for x, y in ((a, b), (b, a)))
    soft, hard = ["soft_linear", "soft_hertz"], ["hard", "hard_smooth", "hard_overlapping"]
    return (pair("law", soft, "solver", FACTORS["solver"][:4]) or
            pair("law", hard, "solver", ["none"]) or
            pair("law", soft, "continuous_collision", ["on"]) or
            pair("law", soft, "sleeping", ["on"]) or
            pair("law", soft, "precision", ["mixed_precision"]) or
            pair("law", soft, "integrator", ["moreau_midpoint"]) or
            pair("law", hard, "integrator", ["velocity_verlet"]) or
            pair("solver", ["accelerated_jacobi", "substepping", "none"], "precision", ["mixed_precision"]) or
            pair("integrator", ["moreau_midpoint"], "solver", ["substepping"]) or
            pair("decomposition", ["periodic"], "transport", ["serial"]) or
            pair("balancing", ["on"], "decomposition", ["grid", "ring", "hexagonal", "periodic", "cells"]))


# Values by number; a set of values is an integer with their bits.
VALUES = [(name, value) for name in NAMES for value in FACTORS[name]]
BIT = {value: 1 << k for k, value in enumerate(VALUES)}
APART = {a: sum(BIT[b] for b in VALUES if a[0] != b[0] and refused(a, b)) for a in VALUES}


BOUND = [name for name in NAMES if any(APART[name, value] for value in FACTORS[name])]
OF_BOUND = sum(BIT[name, value] for name in BOUND for value in FACTORS[name])


@functools.cache
def complete_bound(chosen):
    name = next((n for n in BOUND if not any(chosen & BIT[n, v] for v in FACTORS[n])), None)
    return name is None or any(not chosen & APART[name, value] and complete_bound(chosen | BIT[name, value])
                               for value in FACTORS[name])


def complete(chosen):
    """Whether there is a scenario with these values; those of factors that contradict none always fit."""
    return complete_bound(chosen & OF_BOUND)


def pairs_of(row):
    return {frozenset(p) for p in itertools.combinations(row.items(), 2)}


def covering(rng):
    wanted, impossible = set(), []
    for f, g in itertools.combinations(NAMES, 2):
        for x, y in itertools.product(FACTORS[f], FACTORS[g]):
            if APART[f, x] & BIT[g, y]:
                continue
            if complete(BIT[f, x] | BIT[g, y]):
                wanted.add(frozenset({(f, x), (g, y)}))
            else:
                impossible.append(((f, x), (g, y)))
    rows, open_pairs = [], set(wanted)
    while open_pairs:
        best, gain = None, 0
        open_with = {value: 0 for value in VALUES}
        for a, b in open_pairs:
            open_with[a] |= BIT[b]
            open_with[b] |= BIT[a]
        choices = sorted(open_pairs, key=sorted)
        for _ in range(60):
            start = dict(sorted(rng.choice(choices)))
            # Each further factor takes the value with which it covers most open pairs.
            row, names = dict(start), [n for n in NAMES if n not in start]
            rng.shuffle(names)
            chosen = sum(BIT[value] for value in row.items())
            for name in names:
                values = FACTORS[name][:]
                rng.shuffle(values)
                values.sort(key=lambda value: (open_with[name, value] & chosen).bit_count(), reverse=True)
                for value in values:
                    with_it = chosen | BIT[name, value]
                    if not chosen & APART[name, value] and complete(with_it):
                        row[name], chosen = value, with_it
                        break
            if len(row) == len(NAMES) and (now := len(pairs_of(row) & open_pairs)) > gain:
                best, gain = row, now
        rows.append({name: best[name] for name in NAMES})
        open_pairs -= pairs_of(best)
    return rows, wanted, impossible


SHAPES = {"spheres": "sphere", "boxes": "sphere, box", "rounded": "sphere, capsule, cylinder",
          "compound": "sphere, convex_polyhedron, dumbbell", "smooth": "sphere, ellipsoid, superellipsoid"}
MORE = {
    "rounded": "f(capsule{real(0.6) * r, r}), f(cylinder{real(0.8) * r, r});",
    "compound": """f(convex_polyhedron({{r, 0, 0}, {-r, 0, 0}, {0, r, 0}, {0, -r, 0}, {0, 0, r}, {0, 0, -r}}));
    f(dumbbell({{.shape = sphere{real(0.6) * r}, .at = {{-real(0.3) * r, 0, 0}}},
                {.shape = sphere{real(0.6) * r}, .at = {{real(0.3) * r, 0, 0}}}}));""",
    "smooth": """f(ellipsoid{{r, real(0.8) * r, real(0.5) * r}});
    f(superellipsoid{{real(0.7) * r, real(0.6) * r, real(0.5) * r}, 4, 3});"""}
LAWS = {"hard": "hard_contact<coulomb_friction, newton_restitution, split_correction>",
        "hard_smooth": "hard_contact<newton_restitution, split_correction>",
        "hard_overlapping": "hard_contact<coulomb_friction, no_correction>",
        "soft_linear": "soft_contact<linear_spring_dashpot, coulomb_friction>",
        "soft_hertz": "soft_contact<hertz_mindlin, coulomb_friction, rolling_resistance>"}
DECOMPOSITIONS = {
    "grid": ("grid<dynamic, dynamic>", """const int n = variant == 0 ? 2 : 1;
    return std::pair(n * n, type{.cells = {n, n}, .lower = {-4, -4}, .upper = {4, 4}});"""),
    "ring": ("ring<dynamic>", "return std::pair(variant == 0 ? 3 : 1, type{});"),
    "hexagonal": ("hexagonal<dynamic>", "return std::pair(variant == 0 ? 7 : 1, type{.width = 8});"),
    "bisection": ("bisection<dynamic>",
                  "return std::pair(variant == 0 ? 4 : 1, type{.lower = {-4, -4}, .upper = {4, 4}});"),
    "periodic": ("periodic<grid<dynamic, dynamic>, along::x, along::y>", """const int n = variant == 0 ? 2 : 1;
    return std::pair(n * n, type{{.cells = {n, n}, .lower = {-4, -4}, .upper = {4, 4}}});"""),
    "cells": ("any_decomposition", """const half_space side = variant == 0 ? half_space(0.3, 0.8, 0.2, 0.1) : half_space(1, 0.1, 0, -0.4);
    return std::pair(2, type(cells(side, complement(side))));""")}
HEADERS = ["shape/sphere", "shape/box", "shape/capsule", "shape/cylinder", "shape/plane",
           "shape/convex_polyhedron", "shape/ellipsoid", "shape/superellipsoid", "shape/union_of",
           "solver/coloured_gauss_seidel", "solver/accelerated_jacobi", "solver/substepping", "detect/sweep_and_prune",
           "parallel/any_decomposition", "parallel/bisection", "parallel/cells", "parallel/grid",
           "parallel/hexagonal", "parallel/periodic", "parallel/ring", "parallel/serial",
           "parallel/threads"]


def source(number, row, seed):
    policies = [f"bodies<{SHAPES[row['shapes']]}, plane>", LAWS[row["law"]]]
    if row["solver"] != "none":
        policies.append(f"solver<{row['solver']}>")
    for role in ("broad_phase", "integrator", "transport", "precision"):
        policies.append(f"{role}<{row[role]}>")
    decomposition, decompose = DECOMPOSITIONS[row["decomposition"]]
    policies.append(f"decomposition<{decomposition}>")
    features = ["checkpoints"] + [f for f in ON_OFF if row[f] == "on"]
    policies.append(f"features<{', '.join(features)}>")
    headers = HEADERS + (["vtk"] if row["vtk_output"] == "on" else [])
    more = MORE.get(row["shapes"])
    shapes = ""
    if (row["decomposition"], row["transport"]) == ("cells", "serial"):  # one has to be chosen
        shapes = "\n  type alone() const { return grid<dynamic>{}; }"
    if more:
        shapes += f"""
  using more_shapes = void;
  template <class F>
  static void each_more_shape(real r, F&& f) {{
    {more}
  }}"""
    return f"""// Written by tests/composition/generate.py, seed {seed}.
{chr(10).join(f'#include <talus/{h}.hpp>' for h in headers)}

#include "scene.hpp"

namespace {{
using namespace talus;
[[maybe_unused]] inline constexpr int number = {number};
using dumbbell = union_of<sphere>;
using chosen = scenario<
    {(',' + chr(10) + '    ').join(policies)}>;

struct decompose {{
  using type = {decomposition};
  auto operator()([[maybe_unused]] int variant) const {{
    {decompose}
  }}{shapes}
}};
}}  // namespace

TEST_CASE("composition {number}: {', '.join(v if v not in ('on', 'off') else k for k, v in row.items() if v != 'off')}") {{
  composition::scene<chosen, decompose>({number}, {{}}).check();
}}
"""


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("--out", type=pathlib.Path)
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--list", action="store_true", help="print the scenarios")
    given = arguments.parse_args()
    rows, wanted, impossible = covering(random.Random(given.seed))
    covered = set().union(*(pairs_of(r) for r in rows))
    assert wanted <= covered
    print(f"composition: seed {given.seed}, {len(rows)} scenarios, {len(wanted)} pairs, "
          f"{len(impossible)} that others exclude")
    if given.list:
        for k, row in enumerate(rows):
            print(k, *(v if v not in ("on", "off") else n for n, v in row.items() if v != "off"))
        for a, b in impossible:
            print("excluded by others:", "=".join(a), "=".join(b))
    if given.out:
        given.out.mkdir(parents=True, exist_ok=True)
        for k, row in enumerate(rows):
            file = given.out / f"scene_{k:02}.cpp"
            text = source(k, row, given.seed)
            if not file.exists() or file.read_text() != text:
                file.write_text(text)
        for file in given.out.glob("scene_*.cpp"):
            if int(file.stem[6:]) >= len(rows):
                file.unlink()


if __name__ == "__main__":
    main()
