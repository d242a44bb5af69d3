"""Designs of experiments: which values the options of a program take in the runs of a sweep."""
import collections
import fractions
import math
import random
import re

# What one --vary says. `values`: texts, in the order given; `lower`, `upper`: the ends of a range without
# a number of values, for a Latin hypercube; `log`: a range with constant ratios.
Factor = collections.namedtuple("Factor", "name values lower upper log")
NUMBER = r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?"
MOST = 100000  # runs of a sweep


class Wrong(Exception):
    """What the user wrote makes no sweep: str() is one sentence for the user."""


def number(text, where):
    if not re.fullmatch(NUMBER, text):
        raise Wrong(f"{where}: '{text}' is no number")
    size = abs(float(text))  # a fraction of a large exponent has as many digits
    if math.isinf(size):
        raise Wrong(f"{where}: {text} is too large")
    return fractions.Fraction(text) if size else fractions.Fraction(0)


def written(value):
    """The shortest text of a number; whole numbers have no point."""
    return str(int(value)) if value == int(value) and abs(value) < 10**15 else repr(float(value))


def between(lower, upper, part, log):
    """The value at `part`, from 0 to 1, of a range. On a logarithmic scale it has six digits."""
    if not log:
        return written(lower + (upper - lower) * part)
    if part in (0, 1):
        return written(upper if part else lower)
    return written(fractions.Fraction(f"{float(lower) * (float(upper) / float(lower)) ** float(part):.6g}"))


def parse(text):
    """The factor that `--vary text` describes: NAME=A:B:N, NAME=A:B:N:log, NAME=A:B, or NAME=V,W,...
    Raises Wrong."""
    where = f"--vary {text}"
    name, sign, what = text.partition("=")
    name = name.removeprefix("--")
    if not sign or not what or not re.fullmatch(r"[A-Za-z][\w.-]*", name):
        raise Wrong(f"{where}: write NAME=A:B:N for N values from A to B, or NAME=V,W,...")
    words = what.split(":")
    if len(words) == 1 or not re.fullmatch(NUMBER, words[0]):  # a list; texts may contain colons
        values = what.split(",")
        if "" in values:
            raise Wrong(f"{where}: a value of the list is empty")
        twice = [v for v, n in collections.Counter(values).items() if n > 1]
        if twice:
            raise Wrong(f"{where}: the list has {twice[0]} twice; use --repeat N for runs with other seeds")
        return Factor(name, values, None, None, False)
    log = words[-1] == "log"
    words = words[:-1] if log else words
    if len(words) not in (2, 3):
        raise Wrong(f"{where}: a range is A:B:N, or A:B:N:log for constant ratios")
    lower, upper = number(words[0], where), number(words[1], where)
    if lower == upper:
        raise Wrong(f"{where}: both ends of the range are {words[0]}")
    if log and not (lower > 0 and upper > 0):
        raise Wrong(f"{where}: a logarithmic range needs ends above 0")
    if len(words) == 2:
        return Factor(name, None, lower, upper, log)
    if not re.fullmatch(r"\d+", words[2]) or not 2 <= int(words[2]) <= MOST:
        raise Wrong(f"{where}: a range needs a number of values between 2 and {MOST}, not '{words[2]}'")
    n = int(words[2])
    values = [between(lower, upper, fractions.Fraction(i, n - 1), log) for i in range(n)]
    if len(set(values)) < n:
        raise Wrong(f"{where}: the {n} values of the range are not all different")
    return Factor(name, values, lower, upper, log)


def full_factorial(factors):
    """All combinations; the last factor varies fastest."""
    size = 1
    for f in factors:
        if f.values is None:
            raise Wrong(f"--vary {f.name}: give the number of values of the range: "
                        f"{f.name}={written(f.lower)}:{written(f.upper)}:N (without it for --design latin:N only)")
        size *= len(f.values)
        if size > MOST:
            raise Wrong(f"the sweep has more than {MOST} runs: use fewer values, or --design latin:N")
    runs = [{}]
    for f in factors:
        runs = [{**run, f.name: value} for run in runs for value in f.values]
    return runs


def latin_hypercube(factors, count, seed, whole=()):
    """`count` runs (McKay, Beckman, Conover 1979): each range is divided into `count` intervals of equal
    length, of equal ratio if it is logarithmic, and each of these has one run, at a random place in it.
    The values of a list, or of a range with a number of values, occur equally often, up to one. Factors
    in `whole` take whole numbers. The same seed gives the same runs."""
    source = random.Random(seed)
    columns = {}
    for f in factors:
        order = list(range(count))
        source.shuffle(order)
        places = [fractions.Fraction((k + source.random()) / count) for k in order]
        if f.values is not None:
            columns[f.name] = [f.values[k * len(f.values) // count] for k in order]
            continue
        values = [float(between(f.lower, f.upper, p, f.log)) for p in places]
        columns[f.name] = [written(round(v)) if f.name in whole else written(fractions.Fraction(f"{v:.6g}"))
                           for v in values]
    runs = [{f.name: columns[f.name][i] for f in factors} for i in range(count)]
    return list({tuple(run.items()): run for run in runs}.values())  # rounding may make two alike


def make(factors, design="full", seed=1, repeat=0, whole=()):
    """The runs of a sweep, each a dictionary from options to texts. `design` is "full" or "latin:N";
    `repeat` runs of each have the seeds 1, 2, ... Raises Wrong."""
    names = [f.name for f in factors]
    for name in names:
        if names.count(name) > 1:
            raise Wrong(f"--vary {name} is given twice: write all its values in one")
    if not names and repeat < 1:
        raise Wrong("nothing varies: give --vary NAME=VALUES, or --repeat N")
    if repeat and "seed" in names:
        raise Wrong("--repeat N varies the seed, and --vary seed does too: leave one of them out")
    match = re.fullmatch(r"latin:(\d+)", design)
    if design == "full":
        runs = full_factorial(factors)
    elif match and 1 <= int(match[1]) <= MOST:
        runs = latin_hypercube(factors, int(match[1]), seed, whole)
    else:
        raise Wrong(f"--design is full or latin:N, with N from 1 to {MOST}, not '{design}'")
    count = len(runs) * max(repeat, 1)
    if count > MOST:
        raise Wrong(f"the sweep has {count} runs, more than {MOST}: use fewer values")
    return [{**run, "seed": str(k + 1)} for run in runs for k in range(repeat)] if repeat else runs
