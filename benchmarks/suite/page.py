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
    text += f". Load of the machine at its start: {number(known['load_before'])}"
    if known["load_before"] > 0.7:
        text += " (**busy**: times are too long and ratios uncertain)"
    if known.get("quick"):
        text += ". **A quick run: sizes are small and the figures mean nothing.**"
    text += "" if text.endswith("**") else "."
    for run in known.get("again", []):
        text += (f" Measured again since, at a load of {number(run['load_before'])}: "
                 f"{', '.join(run['parts'])}.")
    return text


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
