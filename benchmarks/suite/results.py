"""What the suite has measured: rows of flat numbers by part, kept as JSON and CSV after each run."""
import csv
import json
import os
import sys
import time


class Results:
    """Rows by part. A row has a `label`, and whatever its program said."""

    def __init__(self, output):
        self.output = output
        self.parts = {}
        self.machine = {}
        self.began = time.monotonic()
        path = os.path.join(output, "results.json")
        if os.path.exists(path):
            with open(path) as file:
                known = json.load(file)
            self.parts, self.machine = known["parts"], known["machine"]

    def rows(self, part, **wanted):
        """Rows of a part whose fields are as wanted."""
        return [r for r in self.parts.get(part, [])
                if all(r.get(key) == value for key, value in wanted.items())]

    def row(self, part, **wanted):
        """The first of them, or None."""
        return next(iter(self.rows(part, **wanted)), None)

    def forget(self, part):
        self.parts.pop(part, None)

    def add(self, part, row):
        self.parts.setdefault(part, []).append(row)
        self.save(part)

    def save(self, part):
        """At once, after each run: a suite that is broken off loses nothing."""
        os.makedirs(self.output, exist_ok=True)
        replace(os.path.join(self.output, "results.json"),
                json.dumps({"machine": self.machine, "parts": self.parts}, indent=1) + "\n")
        rows = self.parts.get(part, [])
        keys = list(dict.fromkeys(key for row in rows for key in row))
        path = os.path.join(self.output, part + ".csv")
        with open(path + ".new", "w", newline="") as file:
            table = csv.DictWriter(file, keys, lineterminator="\n")
            table.writeheader()
            table.writerows(rows)
        os.replace(path + ".new", path)

    def say(self, text):
        print(f"bench: {time.monotonic() - self.began:5.0f} s  {text}", file=sys.stderr, flush=True)


def replace(path, text):
    """Writes a file whole or not at all."""
    with open(path + ".new", "w") as file:
        file.write(text)
    os.replace(path + ".new", path)
