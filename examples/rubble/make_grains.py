#!/usr/bin/env python3
"""Writes grains.csv, as a code for planetesimals might: two lobes of spheres of many sizes that do not
overlap, the larger one as in Itokawa's body and head, turning about z as one.
  make_grains.py > grains.csv
"""
import math
import random

random.seed(25143)
LOBES = [((-6.5, 0, 0), 7.0), ((7.5, 1.5, 0), 5.0)]  # centres, radii
SMALLEST, LARGEST, SLOPE = 0.45, 1.6, 2.5  # as many are larger than r as r to the minus SLOPE tells
SPIN = 0.05  # radians per unit of time

grains = []
for centre, radius in LOBES:
    misses = 0
    while misses < 3000:
        u = random.random()
        r = (SMALLEST**-SLOPE + u * (LARGEST**-SLOPE - SMALLEST**-SLOPE)) ** (-1 / SLOPE)
        at = tuple(c + random.uniform(-radius, radius) for c in centre)
        free = math.dist(at, centre) < radius - r and all(
            math.dist(at, other) > r + s + 0.01 for *other, s in grains)
        misses = 0 if free else misses + 1
        if free:
            grains.append((*at, r))

mass = sum(r**3 for *_, r in grains)
middle = [sum(g[k] * g[3] ** 3 for g in grains) / mass for k in range(3)]
print(f"# {len(grains)} spheres, made by examples/rubble/make_grains.py")
print("x,y,z,r,vx,vy,vz")
for x, y, z, r in grains:
    x, y, z = x - middle[0], y - middle[1], z - middle[2]
    print(f"{x:.3f},{y:.3f},{z:.3f},{r:.3f},{-SPIN * y:.4f},{SPIN * x:.4f},0")
