#!/usr/bin/env python3
"""Sweeps of a stand-in for a program, of a real one if it is given, killed and continued.
  sweeps.py ROOT [PROGRAM]"""
import csv
import errno
import fcntl
import json
import os
import pathlib
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = pathlib.Path(sys.argv.pop(1) if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2]).resolve()
REAL = sys.argv.pop(1) if len(sys.argv) > 1 else ""
SWEEP = [sys.executable, "-B", str(ROOT / "python" / "sweep" / "sweep.py")]
PROGRAM = str(ROOT / "tests" / "sweep" / "program.py")


class Sweeps(unittest.TestCase):
    def setUp(self):
        self.made = tempfile.TemporaryDirectory()
        self.addCleanup(self.made.cleanup)
        self.work = pathlib.Path(self.made.name)
        self.starts = self.work / "starts"
        self.starts.touch()
        self.plots = ["--no-plots"]
        self.environment = {**os.environ, "STARTS": str(self.starts)}
        self.environment.pop("SLURM_JOB_ID", None)

    def command(self, *words, program=PROGRAM):
        return [*SWEEP, program, "--out", str(self.work / "out"), *self.plots, *words]

    def sweep(self, *words, code=0, program=PROGRAM):
        told = subprocess.run(self.command(*words, program=program), capture_output=True, text=True,
                              env=self.environment, cwd=self.work, timeout=100)
        self.assertEqual(told.returncode, code, told.stderr)
        return told.stderr

    def rows(self):
        with open(self.work / "out" / "table.csv", newline="") as file:
            return list(csv.DictReader(file))

    def started(self):
        return self.starts.read_text().splitlines()

    def test_a_sweep_makes_a_row_for_each_run_in_the_order_of_the_design(self):
        self.sweep("--vary", "friction=0.2,0.4", "--vary", "iterations=5,10", "--jobs", "2", "--", "--steps", "7")
        rows = self.rows()
        self.assertEqual([(r["friction"], r["iterations"]) for r in rows],
                         [("0.2", "5"), ("0.2", "10"), ("0.4", "5"), ("0.4", "10")])
        self.assertEqual(list(rows[0]), ["run", "status", "friction", "iterations", "scenario", "steps", "contacts",
                                         "residual", "state_digest", "angle", "flowing", "seed"])
        self.assertEqual([r["angle"] for r in rows], ["1.0", "2.0", "2.0", "4.0"])
        self.assertEqual({r["steps"] for r in rows}, {"7"})
        self.assertEqual([r["flowing"] for r in rows], ["1", "1", "0", "0"])
        self.assertEqual({(r["status"], r["residual"]) for r in rows}, {("done", "")})
        run = self.work / "out" / "runs" / "friction=0.2,iterations=5"
        self.assertIn("--friction=0.2 --iterations=5 --json results.json", (run / "command").read_text())

    def test_a_finished_run_is_not_made_again_and_more_values_may_follow(self):
        self.sweep("--vary", "friction=0.2,0.4")
        self.assertIn("2 of 2 runs are there already", self.sweep("--vary", "friction=0.2,0.4"))
        self.sweep("--vary", "friction=0.2,0.3,0.4")
        self.assertEqual(self.started(), ["0.2 10 1", "0.4 10 1", "0.3 10 1"])
        self.assertEqual([r["friction"] for r in self.rows()], ["0.2", "0.3", "0.4"])

    def test_repetitions_have_seeds(self):
        self.sweep("--vary", "friction=0.2,0.4", "--repeat", "2")
        self.assertEqual([(r["friction"], r["seed"]) for r in self.rows()],
                         [("0.2", "1"), ("0.2", "2"), ("0.4", "1"), ("0.4", "2")])

    def test_failed_runs_are_kept_with_their_message_and_made_again_on_request(self):
        words = ["--vary", "friction=0.2,0.4", "--", "--fail-at", "0.4"]
        said = self.sweep(*words, code=1)
        self.assertIn("failed: friction=0.4: program.py: body 7 is lost", said)
        self.assertEqual([r["status"] for r in self.rows()], ["done", "failed"])
        self.assertIn("body 7", (self.work / "out" / "runs" / "friction=0.4" / "log").read_text())
        self.sweep(*words, code=1)
        self.assertEqual(len(self.started()), 2)
        self.sweep("--retry", *words, code=1)
        self.assertEqual(self.started(), ["0.2 10 1", "0.4 10 1", "0.4 10 1"])

    def test_a_run_that_takes_too_long_fails_and_the_others_go_on(self):
        said = self.sweep("--limit", "5", "--vary", "seconds=60,0", code=1)
        self.assertIn("took longer than 5 s", said)
        self.assertEqual([r["status"] for r in self.rows()], ["failed", "done"])

    def test_a_sweep_that_was_killed_goes_on_and_makes_no_finished_run_again(self):
        words = ["--vary", "friction=0.1:0.6:6", "--jobs", "2", "--", "--seconds", "0.4"]
        first = subprocess.Popen(self.command(*words), env=self.environment, cwd=self.work,
                                 stderr=subprocess.DEVNULL)
        runs = self.work / "out" / "runs"
        end = time.monotonic() + 60
        while len(list(runs.glob("*/done.json"))) < 2 and time.monotonic() < end:
            time.sleep(0.01)
        first.kill()
        first.wait()
        done = {p.parent.name for p in runs.glob("*/done.json")}
        self.assertTrue(2 <= len(done) < 6, done)
        self.sweep(*words)
        rows = self.rows()
        self.assertEqual([r["status"] for r in rows], ["done"] * 6)
        for name in done:
            friction = name.removeprefix("friction=")
            self.assertEqual(self.started().count(f"{friction} 10 1"), 1, self.started())

    def test_a_program_of_a_killed_sweep_is_ended_and_never_runs_beside_its_successor(self):
        words = ["--vary", "seconds=30,31", "--jobs", "2"]
        first = subprocess.Popen(self.command(*words), env=self.environment, cwd=self.work,
                                 stderr=subprocess.DEVNULL)
        end = time.monotonic() + 60
        while len(self.started()) < 2 and time.monotonic() < end:
            time.sleep(0.01)
        first.kill()
        first.wait()
        began = time.monotonic()
        for lock in (self.work / "out" / "runs").glob("*/lock"):
            subprocess.run(["flock", str(lock), "true"], check=True, timeout=20)
        self.assertLess(time.monotonic() - began, 20)
        self.assertEqual(list((self.work / "out" / "runs").glob("*/failed.json")), [])

    def test_a_signal_ends_the_sweep_and_its_programs(self):
        first = subprocess.Popen(self.command("--vary", "seconds=30,31", "--jobs", "2"), env=self.environment,
                                 cwd=self.work, stderr=subprocess.PIPE, text=True)
        end = time.monotonic() + 60
        while len(self.started()) < 2 and time.monotonic() < end:
            time.sleep(0.01)
        first.send_signal(signal.SIGTERM)
        said = first.communicate(timeout=30)[1]
        self.assertEqual(first.returncode, 130)
        self.assertIn("ended by SIGTERM; the same command goes on", said)
        self.assertEqual([r["status"] for r in self.rows()], ["missing", "missing"])

    def test_a_results_file_without_the_mark_is_not_a_finished_run(self):
        self.sweep("--vary", "friction=0.2,0.4")
        (self.work / "out" / "runs" / "friction=0.4" / "done.json").unlink()
        self.sweep("--vary", "friction=0.2,0.4")
        self.assertEqual(self.started(), ["0.2 10 1", "0.4 10 1", "0.4 10 1"])

    def test_a_run_with_damaged_results_begins_anew(self):
        self.sweep("--vary", "friction=0.2,0.4")
        (self.work / "out" / "runs" / "friction=0.4" / "results.json").write_text("[1]")
        self.sweep("--vary", "friction=0.2,0.4")
        self.assertEqual(self.started(), ["0.2 10 1", "0.4 10 1", "0.4 10 1"])
        self.assertEqual([r["angle"] for r in self.rows()], ["2.0", "4.0"])

    def test_a_run_that_found_no_room_begins_anew_when_there_is_some(self):
        self.environment["LAST_WORDS"] = f"there is no room for 9 bytes more ({os.strerror(errno.ENOSPC)}), make room"
        words = ["--vary", "friction=0.2,0.4"]
        said = self.sweep(*words, "--", "--fail-at", "0.2", code=1)
        self.assertIn("friction=0.2/log: No space left on device; when that is mended the same command goes on", said)
        self.assertEqual(list((self.work / "out" / "runs").glob("*/failed.json")), [])
        self.environment["LAST_WORDS"] = "body 7 is lost"
        self.assertIn("1 of 2 runs are done, 1 failed", self.sweep(*words, "--", "--fail-at", "0.2", code=1))
        self.assertEqual(self.started(), ["0.2 10 1", "0.2 10 1", "0.4 10 1"])

    def test_mistakes_are_refused_before_the_first_run(self):
        for words, message in [
                (["--vary", "frictoin=1,2"], "has no option --frictoin; did you mean friction?"),
                (["--vary", "friction=1,2", "--", "--stps", "3"], "has no option --stps; did you mean steps?"),
                (["--vary", "friction=1,2", "--", "--friction=3"], "among those that vary"),
                (["--vary", "friction=1,2", "--", "--json", "x"], "the sweep keeps the results"),
                (["--vary", "friction=0.1,high"], "--friction: needs a number, but is 'high'"),
                (["--vary", "iterations=0:2:3"], "--iterations must be at least 1, but is 0"),
                (["--vary", "iterations=1:2:3"], "takes whole numbers, and one of the values is 1.5"),
                ([], "nothing varies")]:
            self.assertIn(message, self.sweep(*words, code=2), words)
        self.assertEqual(self.started(), [])
        self.assertFalse((self.work / "out").exists())

    def test_empty_names_are_refused_and_names_do_not_command_the_terminal(self):
        for words in (["--vary", "friction=0.2", "--out", ""], ["--collect", ""]):
            self.assertIn("takes a name, and is empty", self.sweep(*words, code=2))
        told = self.sweep("--vary", "friction=0.2", "--out", str(self.work / "red\x1b[31m"))
        self.assertIn("red\\x1b[31m", told)
        self.assertNotIn("\x1b", told + self.sweep("--vary", "\x1b[31m=1", code=2) + self.sweep("--red\x1b[31m", code=2))
        self.assertEqual(self.sweep(code=2, program="").count("is empty"), 1)

    def test_another_sweep_or_other_files_in_the_folder_are_left_alone(self):
        self.sweep("--vary", "friction=1,2")
        self.assertIn("a sweep with other options",
                      self.sweep("--vary", "friction=1,2", "--", "--steps", "3", code=2))
        self.assertIn("a sweep over friction", self.sweep("--vary", "steps=1,2", code=2))
        mine = self.work / "mine"
        mine.mkdir()
        (mine / "thesis.txt").write_text("words")
        self.assertIn("holds no sweep", self.sweep("--vary", "friction=1,2", "--out", str(mine), code=2))
        self.assertIn("is no folder", self.sweep("--vary", "friction=1,2", "--out", str(mine / "thesis.txt"), code=2))
        self.assertIn("cannot be made", self.sweep("--vary", "friction=1,2", "--out", "/proc/none", code=2))

    def test_a_damaged_sweep_is_refused_with_its_file(self):
        self.sweep("--vary", "friction=1,2")
        file = self.work / "out" / "sweep.json"
        whole = json.loads(file.read_text())
        for key, value in (("runs", None), ("runs", []), ("runs", [{}]), ("runs", [{"friction": 1}]), ("ranks", "2"),
                           ("program", 3), ("plot", 1)):
            file.write_text(json.dumps({**whole, key: value}))
            for words in (["--vary", "friction=1,2"], ["--collect", str(self.work / "out")]):
                self.assertIn("sweep.json is damaged", self.sweep(*words, code=2), (key, value))

    def test_records_that_are_no_files_or_too_deep_count_as_not_there(self):
        self.sweep("--vary", "friction=1,2")
        out, collect = self.work / "out", ["--collect", str(self.work / "out")]
        deep, pipe = lambda file: file.write_text('{"a":' * 100000), lambda file: os.mkfifo(file)
        for make in deep, pipe:
            for name, code, words in (("runs/friction=1/results.json", 1, "1 are missing"),
                                      ("runs/friction=1/done.json", 1, "1 are missing"), ("sweep.json", 2, "sweep.json is damaged")):
                file = out / name
                whole = file.read_bytes()
                file.unlink()
                make(file)
                self.assertIn(words, self.sweep(*collect, code=code))
                file.unlink()
                file.write_bytes(whole)
        (out / "runs" / "friction=1" / "done.json").unlink()
        (out / "runs" / "friction=1" / "lock").unlink()
        os.mkfifo(out / "runs" / "friction=1" / "done.json")
        self.sweep("--vary", "friction=1,2")
        self.assertEqual([r["status"] for r in self.rows()], ["done", "done"])

    def test_what_killed_sweeps_left_is_removed_and_nothing_else(self):
        out = self.work / "out"
        out.mkdir()
        left = out / "sweep.json.4194304.new"
        left.write_text("{")
        self.sweep("--vary", "friction=1,2")
        self.assertFalse(left.exists())
        for name, alive in (("thesis.1.new", False), ("sweep.json.new", False), ("sweep.json.7.new", True)):
            folder = self.work / name
            folder.mkdir()
            with open(folder / name, "w") as file:
                if alive:
                    fcntl.flock(file, fcntl.LOCK_EX)
                self.assertIn("holds no sweep", self.sweep("--vary", "friction=1,2", "--out", str(folder), code=2))
            self.assertTrue((folder / name).exists())

    def test_a_full_disk_is_told_with_the_file_and_the_sweep_goes_on_when_there_is_room(self):
        words = ["--vary", "seconds=0,1.5", "--jobs", "1"]
        full = lambda pid, size: resource.prlimit(pid, resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))
        first = subprocess.run(self.command(*words), env=self.environment, cwd=self.work, stderr=subprocess.PIPE, text=True,
                               preexec_fn=lambda: full(0, 10))
        self.assertEqual((first.returncode, first.stderr), (
            1, f"sweep: {self.work}/out/sweep.json: File too large; when that is mended the same command goes on from here\n"))
        self.assertEqual(list((self.work / "out").iterdir()), [])
        second = subprocess.Popen(self.command(*words), env=self.environment, cwd=self.work, stderr=subprocess.PIPE, text=True)
        end = time.monotonic() + 60
        while len(self.started()) < 2 and time.monotonic() < end:
            time.sleep(0.01)
        full(second.pid, 10)
        said = second.communicate(timeout=60)[1]
        self.assertEqual(second.returncode, 1)
        self.assertIn("runs/seconds=1.5/done.json: File too large; when that is mended", said)
        self.assertNotIn("Traceback", said)
        self.sweep(*words)
        self.assertEqual([r["status"] for r in self.rows()], ["done", "done"])
        self.assertEqual(len(self.started()), 3)

    def test_links_and_pipes_in_the_place_of_its_files_are_not_replaced(self):
        words = ["--vary", "friction=0.2,0.4"]
        self.sweep(*words)
        mine = self.work / "mine"
        for name in ("table.csv", "runs.txt", "sweep.json"):
            file = self.work / "out" / name
            text = file.read_text()
            mine.write_text(text)
            file.unlink()
            file.symlink_to(mine)
            self.assertIn(f"{file}: this is a symbolic link to {mine}, which a file must not replace; ", self.sweep(*words, code=1))
            self.assertEqual((file.is_symlink(), mine.read_text()), (True, text))
            file.unlink()
            if name != "sweep.json":  # that is read, too
                os.mkfifo(file)
                self.assertIn(f"{file}: this is a folder, a device, a pipe", self.sweep(*words, code=1))
                self.assertTrue(file.is_fifo())
                file.unlink()
            file.write_text(text)
        self.sweep(*words)
        self.assertEqual(len(self.started()), 2)

    def test_progress_that_cannot_be_written_ends_no_sweep(self):
        words = ["--vary", "friction=0.2,0.4"]
        with open("/dev/full", "w") as full:
            told = subprocess.run(self.command(*words), env=self.environment, cwd=self.work, stderr=full, timeout=60)
        self.assertEqual(told.returncode, 0)
        self.assertEqual([r["status"] for r in self.rows()], ["done", "done"])
        self.assertEqual(len(self.started()), 2)
        closed = subprocess.run(self.command("--vary", "friction=0.2,0.4,0.6"), env=self.environment, cwd=self.work, timeout=60,
                                preexec_fn=lambda: (os.close(1), os.close(2)))
        self.assertEqual(closed.returncode, 0)
        self.assertEqual(len(self.started()), 3)

    def test_the_script_for_slurm_makes_each_run_once_and_names_the_collection(self):
        said = self.sweep("--vary", "friction=0.2,0.4,0.6", "--slurm", "--time", "00:10:00", "--jobs", "2")
        script = self.work / "out" / "sweep.sh"
        self.assertIn(f"sbatch {script}", said)
        self.assertEqual(self.started(), [])
        subprocess.run(["bash", "-n", script], check=True)
        text = script.read_text()
        self.assertIn("#SBATCH --array=0-2%2\n", text)
        self.assertIn("#SBATCH --time=00:10:00\n", text)
        for task in (2, 0, 1, 1):  # in any order; the second time of a task changes nothing
            subprocess.run([script], check=True, env={**self.environment, "SLURM_ARRAY_TASK_ID": str(task)},
                           cwd="/", capture_output=True)
        self.assertEqual(self.started(), ["0.6 10 1", "0.2 10 1", "0.4 10 1"])
        wrong = subprocess.run([script], env={**self.environment, "SLURM_ARRAY_TASK_ID": "3"}, cwd="/",
                               capture_output=True, text=True)
        self.assertEqual(wrong.returncode, 2)
        self.assertIn("there is no task 3", wrong.stderr)
        collect = re.search(r"^#   (\S+/dev sweep --collect \S+)$", text, re.M)
        self.assertIsNotNone(collect, text)
        told = subprocess.run([*SWEEP, "--no-plots", "--collect", self.work / "out"], capture_output=True, text=True)
        self.assertEqual(told.returncode, 0, told.stderr)
        self.assertEqual([r["angle"] for r in self.rows()], ["2.0", "4.0", "6.0"])

    def test_a_task_of_slurm_on_several_ranks_is_started_by_srun(self):
        programs = self.work / "bin"
        programs.mkdir()
        (programs / "srun").write_text('#!/bin/bash\necho "$@" >"$CALLS"\nshift 3\nexec "$@"\n')
        (programs / "srun").chmod(0o755)
        self.sweep("--vary", "friction=0.2,0.4", "--slurm", "-n", "8")
        script = self.work / "out" / "sweep.sh"
        self.assertIn("#SBATCH --ntasks=8\n", script.read_text())
        environment = {**self.environment, "PATH": f"{programs}:{os.environ['PATH']}", "SLURM_JOB_ID": "1",
                       "SLURM_ARRAY_TASK_ID": "1", "CALLS": str(self.work / "calls")}
        subprocess.run([script], check=True, env=environment, capture_output=True)
        self.assertTrue((self.work / "calls").read_text().startswith("--cpu-bind=cores -n 8 " + PROGRAM))
        self.assertEqual(self.started(), ["0.4 10 1"])

    def test_plots_show_the_results_that_vary(self):
        try:
            import matplotlib  # noqa: F401
        except ImportError:
            self.skipTest("this Python has no matplotlib")
        self.plots = []
        self.sweep("--vary", "friction=0.2,0.4", "--vary", "iterations=5,10")
        drawn = {p.name for p in (self.work / "out" / "plots").glob("*")}
        self.assertEqual(drawn, {"angle.svg", "contacts.svg", "flowing.svg"})
        picture = (self.work / "out" / "plots" / "angle.svg").read_text()
        self.assertIn("<svg", picture)
        for word in ("iterations", "friction", "angle"):
            self.assertIn(f"<!-- {word} -->", picture)
        self.sweep("--plot", "contacts", "--vary", "friction=0.2,0.4", "--vary", "iterations=5,10")
        self.assertEqual([p.name for p in (self.work / "out" / "plots").glob("*")], ["contacts.svg"])

    def test_plots_are_those_that_are_named_also_when_collected(self):
        try:
            import matplotlib  # noqa: F401
        except ImportError:
            self.skipTest("this Python has no matplotlib")
        self.plots = []

        def drawn():
            return {p.name for p in (self.work / "out" / "plots").glob("*")}

        # A result that does not vary is drawn where it is named.
        vary = ("--vary", "friction=0.2,0.4")
        self.sweep("--plot", "steps, angle", *vary)
        self.assertEqual(drawn(), {"steps.svg", "angle.svg"})
        self.assertIn("<svg", (self.work / "out" / "plots" / "steps.svg").read_text())
        said = subprocess.run([*SWEEP, "--collect", self.work / "out"], capture_output=True, text=True)
        self.assertEqual((said.returncode, drawn()), (0, {"steps.svg", "angle.svg"}), said.stderr)
        subprocess.run([*SWEEP, "--plot", "contacts", "--collect", self.work / "out"], check=True, capture_output=True)
        self.assertEqual(drawn(), {"contacts.svg"})
        said = self.sweep("--plot", "scenario,angle,slope,residual", *vary, code=1)
        self.assertIn("--plot scenario: the results have no number as scenario", said)
        self.assertIn("--plot residual: the results have no number as residual", said)
        self.assertIn("--plot slope: the results have no slope", said)
        self.assertEqual(drawn(), {"angle.svg"})
        self.sweep(*vary)
        self.assertEqual(drawn(), {"contacts.svg", "angle.svg", "flowing.svg"})

    @unittest.skipUnless(REAL, "no real program is given")
    def test_a_real_program_is_swept(self):
        self.sweep("--vary", "iterations=2,5,10", "--", "--steps", "120", "--ranks", "1", program=REAL)
        rows = self.rows()
        self.assertEqual([r["iterations"] for r in rows], ["2", "5", "10"])
        self.assertEqual({(r["status"], r["bodies"], r["steps"]) for r in rows}, {("done", "729", "120")})
        self.assertEqual(len({r["state_digest"] for r in rows}), 3)
        said = self.sweep("--vary", "iteration=2,5", "--out", str(self.work / "other"), program=REAL, code=2)
        self.assertIn("did you mean iterations?", said)
        said = self.sweep("--vary", "iterations=0,5", "--out", str(self.work / "other"), program=REAL, code=2)
        self.assertIn("--iterations must be at least 1, but is 0", said)


if __name__ == "__main__":
    unittest.main()
