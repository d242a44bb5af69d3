"""What a program of talus says of its options, and the check of a command line before any run."""
import re
import subprocess
import tempfile

from design import Wrong

# Options that the sweep sets itself.
OWN = {"json": "the sweep keeps the results of each run", "help": "use ./dev run NAME --help"}
LINE = re.compile(r"^  --([A-Za-z][\w.-]*)(?: (TEXT|UINT|INT|FLOAT))?(?=[=\s]|$)", re.M)
WHOLE = ("UINT", "INT")
CHECK = "--no-such-option-to-end-the-check"


def edits(a, b):
    """Insertions, deletions and changes of letters between two words (Levenshtein)."""
    row = list(range(len(b) + 1))
    for i, x in enumerate(a, 1):
        diagonal, row[0] = row[0], i
        for j, y in enumerate(b, 1):
            diagonal, row[j] = row[j], min(row[j] + 1, row[j - 1] + 1, diagonal + (x != y))
    return row[-1]


def nearest(word, words):
    """The word that the user may have meant, or None."""
    best = min(words, key=lambda w: (edits(word, w), w), default=None)
    return best if best is not None and edits(word, best) <= max(2, len(best) // 3) else None


class Program:
    """A program made with run<...>: its path, and its options with their types."""

    def __init__(self, path):
        self.path = str(path)
        try:
            told = subprocess.run([self.path, "--help"], capture_output=True, text=True, timeout=60,
                                  stdin=subprocess.DEVNULL, errors="replace")
        except (OSError, subprocess.TimeoutExpired) as e:
            raise Wrong(f"{self.path} --help does not work: {e}") from None
        if told.returncode:
            raise Wrong(f"{self.path} --help ended with {told.returncode}: {told.stderr.strip()[-300:]}")
        self.options = {m[1]: m[2] or "" for m in LINE.finditer(told.stdout)}
        if "json" not in self.options:
            raise Wrong(f"{self.path} has no option --json FILE for its results, so there is nothing to "
                        "collect: a program that is made with run<...> has it")

    def refuse_unknown(self, name, where):
        if name in OWN:
            raise Wrong(f"{where}: --{name} is not for a sweep: {OWN[name]}")
        if name not in self.options:
            near = nearest(name, [o for o in self.options if o not in OWN])
            raise Wrong(f"{where}: {self.path} has no option --{name}" +
                        (f"; did you mean {near}?" if near else "") + " See its --help")

    def check(self, varied, options):
        """Raises Wrong for an option that the program does not have, before any run."""
        for name in varied:
            self.refuse_unknown(name, f"--vary {name}")
        for word in options:
            if not word.startswith("--"):
                continue
            name = word[2:].partition("=")[0]
            self.refuse_unknown(name, f"the option {word}")
            if name in varied:
                raise Wrong(f"the option {word} is among those that vary: leave it out")

    def check_values(self, runs, options):
        """Raises Wrong for a value that the program refuses. The program reads the command line of each
        run, with an unknown option as its last word, so it reports the first mistake and makes no step."""
        seen = set()
        elsewhere = tempfile.TemporaryDirectory()  # runs work in their own folders, not in this one
        for run in runs:
            new = {(name, value) for name, value in run.items()} - seen
            if not new:
                continue
            seen |= new
            command = [self.path, *options, *arguments(run), CHECK]
            try:
                told = subprocess.run(command, capture_output=True, text=True, timeout=60,
                                      stdin=subprocess.DEVNULL, errors="replace", cwd=elsewhere.name)
            except subprocess.TimeoutExpired:
                raise Wrong(f"{self.path} takes an unknown option and starts: its options cannot be "
                            "checked") from None
            if CHECK not in told.stderr:
                raise Wrong(f"the program refuses {' '.join(arguments(run))}: {told.stderr.strip()[-300:]}")


def arguments(run):
    """The words of the command line for the values of a run."""
    return [f"--{name}={value}" for name, value in run.items()]
