"""Reads what a run wrote with --output NAME --checkpoint NAME.h5 --json NAME.json --csv NAME.csv:
PYTHONPATH=python python3 docs/reading.py NAME"""
import sys

import talus

name = sys.argv[1]
frames = talus.open(name)                     # of --output: NAME.hdf.series
last = frames[-1]
print(len(frames), "frames; in the last one", len(last), "bodies around", last.positions.mean(axis=0))
print("largest force of a contact:", last.contacts["normal_force"].max())

state = talus.open(name + ".h5")              # of --checkpoint
spheres = state.bodies["sphere"]
print("step", state.step, "has", spheres.positions.shape[0], "spheres of radius", spheres.radii.mean())

results = talus.open(name + ".json")          # of --json: a dictionary
table = talus.open(name + ".csv")             # of --csv
print("overlap", results["penetration_max"], "after", table["time"][-1])
