#!/usr/bin/env python3
"""The files of ./dev bench --json: whole or not there, and never in the place of something else.  bench_files.py ROOT"""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(sys.argv.pop(1)).resolve()
sys.path.insert(0, str(ROOT / "benchmarks"))


def made(*words, text="", **more):
    return subprocess.run([sys.executable, "-B", str(ROOT / "python/whole_file.py"), *words], input=text, capture_output=True, text=True,
                          timeout=60, **more)


class Files(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.work = pathlib.Path(folder.name)

    def test_rows_replace_rows(self):
        for text in ("[\n1\n]\n", "[\n2\n]\n"):
            self.assertEqual(made("--check", "rows.json", cwd=self.work).returncode, 0)
            self.assertEqual(made("rows.json", text=text, cwd=self.work).returncode, 0)
            self.assertEqual((self.work / "rows.json").read_text(), text)
        self.assertEqual(os.listdir(self.work), ["rows.json"])

    def test_nothing_else_is_replaced(self):
        (self.work / "diary").write_text("a day\n")
        (self.work / "link").symlink_to("diary")
        os.mkfifo(self.work / "pipe")
        before = sorted(os.listdir(self.work))
        for file, words in (("diary", "no JSON"), ("link", "symbolic link"), ("pipe", "a pipe"), (".", "a folder"), ("none/rows", "no folder"),
                            ("/dev/full", "a device"), ("", "no name")):
            for first in (["--check"], []):
                with self.subTest(file=file, first=first):
                    end = made(*first, file, text="[]\n", cwd=self.work)
                    self.assertEqual(end.returncode, 1, end.stderr)
                    self.assertRegex(end.stderr, f"^dev: .*cannot be written: .*{words}")
        self.assertEqual(sorted(os.listdir(self.work)), before)
        self.assertEqual((self.work / "diary").read_text(), "a day\n")

    def test_what_does_not_fit_leaves_the_earlier_rows(self):
        (self.work / "rows.json").write_text("[]\n")
        end = subprocess.run(["bash", "-c", 'ulimit -f 1; exec "$0" -B "$1" rows.json', sys.executable, str(ROOT / "python/whole_file.py")],
                             input="[" + 4000 * " " + "]", capture_output=True, text=True, cwd=self.work)
        self.assertEqual(end.returncode, 1)
        self.assertIn("dev: rows.json cannot be written: File too large", end.stderr)
        self.assertEqual(os.listdir(self.work), ["rows.json"])
        self.assertEqual((self.work / "rows.json").read_text(), "[]\n")

    def test_the_benchmarks_of_python_take_the_same_files(self):
        import argparse
        import beside
        (self.work / "diary").write_text("a day\n")
        with self.assertRaisesRegex(argparse.ArgumentTypeError, "no JSON"):
            beside.file_for_rows(str(self.work / "diary"))
        beside.write_rows([{"a": 1}], beside.file_for_rows(str(self.work / "rows.json")))
        self.assertEqual((self.work / "rows.json").read_text(), '[\n{"a": 1}\n]\n')


if __name__ == "__main__":
    unittest.main()
