"""The runs of a sweep: each in a folder of its own, from which its state follows at any time.

  command      what was started
  log          what the program printed
  results.json what it wrote for --json
  done.json    the run is complete, if its results can be read; written last, by a rename, so that it is
               whole or not there
  failed.json  the run failed: the exit code and the message; likewise
  lock         locked as long as a program runs here

A run with neither done.json nor failed.json was interrupted, and begins anew.
"""
import ctypes
import errno
import fcntl
import hashlib
import json
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import time

from program import arguments
from whole_file import write_whole

LIBC = ctypes.CDLL(None, use_errno=True)
SET_PARENT_DEATH_SIGNAL = 1  # prctl(2), of Linux
OUT_OF_TIME = 75  # exit code of a program that its --time-limit has ended
KEPT = {"lock"}


def read(path):
    """The object in a JSON file, or None if there is none. A pipe is no file: its writer may never come."""
    try:
        value = json.loads(path.read_text()) if path.is_file() else None
    except (OSError, ValueError, RecursionError, MemoryError):
        return None
    return value if isinstance(value, dict) else None


def name_of(run):
    """The folder of a run, which depends on its values alone."""
    plain = ",".join(f"{name}={value}" for name, value in run.items())
    name = re.sub(r"[^\w.,=+-]", "_", plain)
    if name != plain or len(name) > 150:
        name = f"{name[:140]}_{hashlib.sha256(plain.encode()).hexdigest()[:8]}"
    return name


def launch(ranks):
    """The words before a program on several ranks: srun within a job of Slurm, else mpirun."""
    if not ranks:
        return [], {}
    if "SLURM_JOB_ID" in os.environ and shutil.which("srun"):
        return ["srun", "--cpu-bind=cores", "-n", str(ranks)], {}
    words = ["mpirun", "-q", "-n", str(ranks), "--oversubscribe"]
    # In containers processes may not read each other's memory.
    environment = {"OMPI_MCA_btl_vader_single_copy_mechanism": "none"}
    if os.geteuid() == 0:
        environment.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    # Several runs at a time must not share the cores to which ranks are bound.
    words += ["--bind-to", "none"]
    if ranks > len(os.sched_getaffinity(0)):
        words += ["--mca", "mpi_yield_when_idle", "1"]
    return words, environment


class Run:
    """One run of a sweep: its values, its folder, and while it is under way its process."""

    def __init__(self, folder, values, setup):
        self.folder = pathlib.Path(folder) / "runs" / name_of(values)
        self.values, self.setup = values, setup
        self.process = self.lock = None
        self.began = 0.0

    @property
    def state(self):
        """done, failed or missing."""
        if read(self.folder / "done.json") is not None and read(self.folder / "results.json") is not None:
            return "done"
        return "failed" if read(self.folder / "failed.json") is not None else "missing"

    def results(self):
        return (read(self.folder / "results.json") or {}) if self.state == "done" else {}

    def failure(self):
        return (read(self.folder / "failed.json") or {}).get("message", "")

    def take(self):
        """Whether this process may begin the run: no other one runs in its folder."""
        self.folder.mkdir(parents=True, exist_ok=True)
        lock = os.open(self.folder / "lock", os.O_RDWR | os.O_CREAT, 0o644)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            os.close(lock)
            return False
        self.lock = lock
        return True

    def leave(self):
        os.close(self.lock)
        self.lock = None

    def start(self):
        """Starts the program, after take(). The program inherits the lock, so the folder is taken until it
        has ended, even if this process is killed; then the program gets SIGTERM."""
        for old in self.folder.iterdir():
            if old.name not in KEPT:
                shutil.rmtree(old) if old.is_dir() and not old.is_symlink() else old.unlink()
        words, environment = launch(self.setup["ranks"])
        command = [*words, self.setup["program"], *self.setup["options"], *arguments(self.values),
                   "--json", "results.json"]
        write_whole(self.folder / "command", shlex.join(command) + "\n")
        parent = os.getpid()

        def end_with_parent():
            LIBC.prctl(SET_PARENT_DEATH_SIGNAL, signal.SIGTERM)
            if os.getppid() != parent:
                os.kill(os.getpid(), signal.SIGTERM)

        self.began = time.monotonic()
        with open(self.folder / "log", "wb") as log:
            try:
                self.process = subprocess.Popen(
                    command, cwd=self.folder, stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                    env={**os.environ, **environment}, pass_fds=[self.lock], preexec_fn=end_with_parent)
            except OSError as e:
                log.write(f"{command[0]} cannot be started: {e}\n".encode())
        if self.process is None:
            self.finish(127)

    def finish(self, code, why=""):
        """Records the end of the program; returns done or failed. Raises OSError if the program found no room on the
        disk, after which the run counts as interrupted."""
        seconds = round(time.monotonic() - self.began, 3)
        results = read(self.folder / "results.json")
        record = {"values": self.values, "program": self.setup["digest"], "seconds": seconds}
        if code == 0 and results is not None:
            write_whole(self.folder / "done.json", json.dumps(record, indent=1) + "\n")
        else:
            self.require_room()
            record["exit_code"] = code
            if code == OUT_OF_TIME:
                why = why or "its --time-limit ended it before its last step"
            record["message"] = why or self.last_words() or (
                "it wrote no results" if code == 0 else f"it ended with code {code} and without a message")
            write_whole(self.folder / "failed.json", json.dumps(record, indent=1) + "\n")
        self.process = None
        self.leave()
        return self.state

    def require_room(self):
        for number in (errno.ENOSPC, errno.EDQUOT):
            if os.strerror(number) in self.last_words():
                self.process = None
                self.leave()
                raise OSError(number, os.strerror(number), str(self.folder / "log"))

    def last_words(self):
        """The message of a program that failed: the last line of its log that is no progress."""
        try:
            with open(self.folder / "log", "rb") as log:
                log.seek(max(0, log.seek(0, os.SEEK_END) - 4000))
                text = log.read().decode(errors="replace")
        except OSError:
            return ""
        lines = [line.split("\r")[-1].strip() for line in text.splitlines()]
        own = [l for l in lines if l.startswith(os.path.basename(self.setup["program"]) + ":")]
        return (own or [l for l in lines if l] or [""])[-1][:500]

    def end(self):
        """Ends the program, with SIGKILL if it does not end by itself within 10 s."""
        self.process.terminate()
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()

    def stop(self):
        """Ends the program; the run counts as interrupted."""
        if self.process is not None:
            self.end()
            self.process = None
            self.leave()
