"""What a sweep says while it goes on."""
import os
import sys
import time

from printable import printable


def write(text):
    """Writes to standard error. What cannot be written ends no run: from then on nothing is said."""
    try:
        if sys.stderr is not None:  # it is closed
            print(text, end="", file=sys.stderr, flush=True)
    except OSError:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")


def say(words):
    write(f"sweep: {printable(words)}\n")


def duration(seconds):
    hours, rest = divmod(int(seconds + 0.5), 3600)
    return f"{hours}:{rest // 60:02}:{rest % 60:02}"


class Progress:
    """One line on a terminal, else one for each run, with an estimate of the time left."""

    def __init__(self, count, done, jobs):
        self.count, self.before, self.jobs = count, done, jobs
        self.began, self.finished, self.failed = time.monotonic(), 0, 0
        self.shown = sys.stderr is not None and sys.stderr.isatty()

    def left(self, running):
        """Seconds until the end, from the mean pace of this session, in which runs under way count half."""
        if not self.finished:
            return None
        pace = (time.monotonic() - self.began) / (self.finished + running / 2)
        return pace * (self.count - self.before - self.finished - running / 2)

    def note(self, run, state, running):
        self.finished += 1
        self.failed += state == "failed"
        if state == "failed":
            self.clear()
            say(f"{run.folder.name} failed: {run.failure()}")
        if not self.shown:
            left = self.left(running)
            say(f"run {self.before + self.finished} of {self.count}, {duration(time.monotonic() - self.began)}, "
                f"{duration(left or 0)} left: {run.folder.name}")

    def show(self, running):
        if self.shown:
            left = self.left(running)
            words = (f"{self.before + self.finished} of {self.count} runs, {running} under way" +
                     (f", {self.failed} failed" if self.failed else "") +
                     f", {duration(time.monotonic() - self.began)}" +
                     (f", {duration(left)} left" if left is not None else ""))
            write(f"\rsweep: {words} \x1b[K")

    def clear(self):
        if self.shown:
            write("\r\x1b[K")
