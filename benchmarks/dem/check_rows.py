"""The rows of ./dev bench dem have the fields that readers need, and wrong arguments are refused."""
import json
import os
import subprocess
import sys
import tempfile

FIELDS = {"engine": str, "bodies": int, "ranks": int, "dt": float, "steps": int,
          "particle_steps_per_second": float, "contacts": int, "overlap_mean": float,
          "kinetic_energy_per_body": float}
WRONG = (["--bodies", "0"], ["--bodies", "many"], ["--rivals", "bullet"], ["--ranks", "1,none"],
         ["--unknown"], ["--json", "/no/such/folder/rows.json"])


def main():
    dev = sys.argv[1]
    faults = 0
    for words in WRONG:
        done = subprocess.run([dev, "bench", "dem", *words], capture_output=True, text=True)
        if done.returncode != 2:
            faults += 1
            print(f"'{' '.join(words)}' ends with {done.returncode}, not with 2")
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "rows.json")
        subprocess.run([dev, "bench", "dem", "--quick", "--ranks", "1", "--json", file], check=True)
        with open(file) as text:
            rows = json.load(text)
    if [row.get("engine") for row in rows] != ["talus"]:
        faults += 1
        print(f"the engines are {[row.get('engine') for row in rows]}, not talus alone")
    for row in rows:
        for name, kind in FIELDS.items():
            value = row.get(name)
            if not isinstance(value, kind) or (kind is not str and not value > 0):
                faults += 1
                print(f"{name} is {value!r}, not a positive {kind.__name__}" if kind is not str
                      else f"{name} is {value!r}, not a name")
    print(f"{faults} faults")
    sys.exit(faults > 0)


if __name__ == "__main__":
    main()
