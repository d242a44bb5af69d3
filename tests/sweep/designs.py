#!/usr/bin/env python3
"""Designs of sweeps: what --vary says, and which runs follow.  designs.py ROOT"""
import pathlib
import sys
import unittest

ROOT = pathlib.Path(sys.argv.pop(1) if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2]).resolve()
sys.path.insert(0, str(ROOT / "python" / "sweep"))
sys.path.append(str(ROOT / "python"))
import design
import program
import slurm
from design import Wrong


class Parsed(unittest.TestCase):
    def values(self, text):
        return design.parse(text).values

    def test_a_range_has_both_ends_and_no_rounding_of_its_own(self):
        self.assertEqual(self.values("friction=0.1:0.9:9"),
                         ["0.1", "0.2", "0.3", "0.4", "0.5", "0.6", "0.7", "0.8", "0.9"])
        self.assertEqual(self.values("steps=10:40:4"), ["10", "20", "30", "40"])
        self.assertEqual(self.values("x=1:-1:3"), ["1", "0", "-1"])
        self.assertEqual(self.values("x=1e-3:2e-3:2"), ["0.001", "0.002"])
        self.assertEqual(self.values("x=0e9999999999:1:2"), ["0", "1"])
        self.assertEqual(self.values("x=1e-9999999999:1:2"), ["0", "1"])

    def test_a_logarithmic_range_has_constant_ratios(self):
        self.assertEqual(self.values("dt=1e-4:1e-2:3:log"), ["0.0001", "0.001", "0.01"])
        self.assertEqual(self.values("dt=1:8:4:log"), ["1", "2", "4", "8"])

    def test_a_list_keeps_its_order_and_its_texts(self):
        self.assertEqual(self.values("iterations=20,5,10"), ["20", "5", "10"])
        self.assertEqual(self.values("--colour=rank,speed"), ["rank", "speed"])
        self.assertEqual(self.values("grid=a:b,c"), ["a:b", "c"])
        self.assertEqual(self.values("n=7"), ["7"])
        self.assertEqual(design.parse("stone.friction=0.1,0.2").name, "stone.friction")

    def test_what_makes_no_sense_is_refused_with_its_words(self):
        for text, words in [("friction", "write NAME="), ("=1,2", "write NAME="), ("a=", "write NAME="),
                            ("a=1,,2", "is empty"), ("a=1,2,1", "1 twice"), ("a=1:2:1", "between 2 and"),
                            ("a=1:2:x", "between 2 and"), ("a=1:1:3", "both ends"), ("a=0:1:3:log", "above 0"),
                            ("a=1:2:3:4", "a range is"), ("a=1:b:3", "'b' is no number"),
                            ("a=1:1e999:3", "too large"), ("a=1:-1e9999999999:3", "too large"), ("a=1:1.0000001:9:log", "not all different")]:
            with self.assertRaises(Wrong, msg=text) as told:
                self.values(text)
            self.assertIn(words, str(told.exception))
            self.assertIn(text, str(told.exception))


class Made(unittest.TestCase):
    def test_a_full_design_has_all_combinations_and_the_last_option_varies_fastest(self):
        runs = design.make([design.parse("a=1,2"), design.parse("b=x,y,z")])
        self.assertEqual([(r["a"], r["b"]) for r in runs],
                         [("1", "x"), ("1", "y"), ("1", "z"), ("2", "x"), ("2", "y"), ("2", "z")])

    def test_repetitions_are_seeds(self):
        self.assertEqual(design.make([design.parse("a=1,2")], repeat=2),
                         [{"a": "1", "seed": "1"}, {"a": "1", "seed": "2"},
                          {"a": "2", "seed": "1"}, {"a": "2", "seed": "2"}])
        self.assertEqual(design.make([], repeat=1), [{"seed": "1"}])

    def test_a_latin_hypercube_has_one_run_in_each_interval_of_each_option(self):
        factors = [design.parse("a=0:1"), design.parse("b=1:1024:log"), design.parse("c=x,y")]
        runs = design.make(factors, "latin:10")
        self.assertEqual(sorted(int(float(r["a"]) * 10) for r in runs), list(range(10)))
        import math
        self.assertEqual(sorted(int(math.log2(float(r["b"]))) for r in runs), list(range(10)))
        self.assertEqual(sorted(r["c"] for r in runs), ["x"] * 5 + ["y"] * 5)
        self.assertEqual(runs, design.make(factors, "latin:10"))
        self.assertNotEqual(runs, design.make(factors, "latin:10", seed=2))

    def test_a_latin_hypercube_rounds_options_that_take_whole_numbers(self):
        runs = design.make([design.parse("n=1:100")], "latin:7", whole=["n"])
        self.assertTrue(all(r["n"].isdigit() for r in runs), runs)

    def test_contradictions_are_refused(self):
        a = design.parse("a=1,2")
        for make, words in [(lambda: design.make([]), "nothing varies"), (lambda: design.make([a, a]), "twice"),
                            (lambda: design.make([design.parse("seed=1,2")], repeat=2), "--repeat"),
                            (lambda: design.make([a], repeat=10**15), "more than 100000"),
                            (lambda: design.make([a], "latin"), "--design is full or latin:N"),
                            (lambda: design.make([a], "latin:0"), "--design is full or latin:N"),
                            (lambda: design.make([design.parse("a=0:1")]), "number of values"),
                            (lambda: design.make([design.parse(f"{x}=0:1:100") for x in "abc"]), "more than")]:
            with self.assertRaises(Wrong) as told:
                make()
            self.assertIn(words, str(told.exception))


class Helped(unittest.TestCase):
    def test_the_options_and_their_types_are_read_from_the_help(self):
        p = program.Program(ROOT / "tests" / "sweep" / "program.py")
        self.assertEqual(p.options["friction"], "FLOAT")
        self.assertEqual(p.options["fail-at"], "FLOAT")
        self.assertEqual(p.options["reproducible"], "")
        self.assertEqual(p.options["iterations"], "INT")

    def test_the_nearest_option_is_the_one_with_the_fewest_changes(self):
        self.assertEqual(program.nearest("frictoin", ["steps", "friction", "fail-at"]), "friction")
        self.assertIsNone(program.nearest("viscosity", ["steps", "friction"]))


class Shared(unittest.TestCase):
    def test_the_tasks_of_a_job_array_make_each_run_once(self):
        for count in (1, 7, 1000, 2500):
            tasks = min(count, slurm.MOST)
            made = [i for t in range(tasks) for i in slurm.share(count, t, tasks)]
            self.assertEqual(sorted(made), list(range(count)))

    def test_times_are_those_of_sbatch(self):
        for text in ("90", "10:30", "02:00:00", "1-12", "1-12:00:00"):
            self.assertTrue(slurm.valid_time(text), text)
        for text in ("", "2h", "1:2:3:4", "02:00:00; rm x"):
            self.assertFalse(slurm.valid_time(text), text)


if __name__ == "__main__":
    unittest.main()
