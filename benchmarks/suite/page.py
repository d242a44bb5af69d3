"""Writes the performance page from the rows of all parts."""
import os
import re

import budget
import judgement
import scaling
import tables
from results import replace
from text import number, table

HERE = os.path.dirname(os.path.abspath(__file__))


def machine(results):
    known = results.machine
    if not known:
        return "Nothing has been measured yet."
    text = f"{known['processor']}, {known['cores']} cores, {known['system']}"
    if "minutes" in known:
        text += f"; the last run took {number(known['minutes'])} minutes"
    text += f". {others(known)}"
    if known.get("quick"):
        text += ". **A quick run: sizes are small and the figures mean nothing.**"
    text += "" if text.endswith("**") else "."
    for run in known.get("again", []):
        text += f" Measured again since: {', '.join(run['parts'])}. {others(run)}."
    return text


BUSY = 0.15  # cores


def others(run):
    """What other programs, the system and the host used, before the run and while it went on."""
    if run.get("others_during") is None or run.get("others_before") is None:
        return "What other programs used was not recorded"
    text = (f"Other programs used {number(run['others_before'])} cores before the run and "
            f"{number(run['others_during'])} on average during it")
    return text + (" (**busy**: times are too long and ratios uncertain)"
                   if max(run["others_before"], run["others_during"]) > BUSY else "")


def pace(results):
    """How much the machine's pace changed while it measured: the same runs of talus, early and late."""
    changes = []
    for part in ("pile", "boxes", "pyramid"):
        for row in results.rows(part, label="talus", when="before"):
            again = results.row(part, label="talus", when="after", asked=row["asked"],
                                bodies=row["bodies"])
            if again:
                changes.append(again["cpu_ms_per_step_median"] / row["cpu_ms_per_step_median"])
    if not changes:
        return "-"
    return f"{min(changes):.2f} to {max(changes):.2f}"


def write(results):
    os.makedirs(results.output, exist_ok=True)
    values = {"machine": machine(results), "pace": pace(results)}
    for fill in (tables.pile, tables.precision, tables.growth_words, tables.scenes, tables.ranks, tables.features,
                 tables.compile_cost, budget.write):
        fill(results, values)
    values["judgement"] = table(["what", "target", "measured", "met"], judgement.judge(results))
    with open(os.path.join(HERE, "page.md")) as file:
        text = file.read()
    for key, value in values.items():
        text = text.replace("{{" + key + "}}", value)
    text = re.sub("{{[^}]*}}", "?", text)
    replace(os.path.join(results.output, "README.md"), text)
    scaling.write(results)
