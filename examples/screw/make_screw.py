#!/usr/bin/env python3
"""Writes screw.stl, as a drawing program might: a shaft along x with one flight around it.
  make_screw.py screw.stl
"""
import math
import struct
import sys

PITCH, TURNS = 4.0, 6
SHAFT, FLIGHT = 0.7, 3.0  # radii
STEPS = 24  # of a turn

triangles = []


def quad(a, b, c, d):
    triangles.extend([(a, b, c), (a, c, d)])


def at(radius, step, x):
    angle = -2 * math.pi * step / STEPS
    return (x, radius * math.cos(angle), radius * math.sin(angle))


for k in range(TURNS * STEPS):
    x, y = PITCH * k / STEPS, PITCH * (k + 1) / STEPS
    radii = [SHAFT, 0.5 * (SHAFT + FLIGHT), FLIGHT]
    for r, s in zip(radii, radii[1:]):
        quad(at(r, k, x), at(s, k, x), at(s, k + 1, y), at(r, k + 1, y))
for k in range(STEPS):
    quad(at(SHAFT, k, 0), at(SHAFT, k + 1, 0), at(SHAFT, k + 1, PITCH * TURNS), at(SHAFT, k, PITCH * TURNS))

with open(sys.argv[1], "wb") as out:
    out.write(b"screw".ljust(80) + struct.pack("<I", len(triangles)))
    for triangle in triangles:  # normals are zero: readers find them from the corners
        out.write(struct.pack("<12fH", 0, 0, 0, *[u for corner in triangle for u in corner], 0))
