#!@PYTHON@
"""Drives the scene of scene.hpp. The cells, each after a line of %%, run one by one in editors that
know notebooks, and one after the other here: @PYTHON@ drive.py"""
# %% The module, from the folder into which CMake builds it.
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent / "build"))
import numpy as np

import @NAME@

# %% A world: its arguments are the options of the program (see help(@NAME@.World)).
world = @NAME@.World(steps=600, friction=0.4, seed=1)
print(len(world.ids), "spheres of radius", world.radii.min(), "to", world.radii.max())

# %% Steps. The arrays are views of the world's memory, without a copy.
height = []
for _ in range(12):
    world.step(50)
    height.append(world.positions[:, 2].mean())
    print(f"step {world.steps}: mean height {height[-1]:.3f}, kinetic energy {world.kinetic_energy:.4g}")

# %% The heap that remains: its slope from the outer spheres, and the forces in its contacts.
x, y, z = world.positions.T
r = np.hypot(x, y)
force = np.linalg.norm(world.contacts["force"], axis=1)
print(f"the heap is {z.max():.2f} high and {np.quantile(r, 0.9):.2f} wide; {len(force)} contacts carry "
      f"{force.mean():.3g} on average")
print("digest", world.digest)

# %% The same picture in a notebook, where matplotlib is installed.
try:
    import matplotlib.pyplot as plt
except ImportError:
    plt = None
if plt and hasattr(sys, "ps1"):
    plt.scatter(r, z, c=np.linalg.norm(world.velocities, axis=1), s=4)
    plt.xlabel("distance from the axis")
    plt.ylabel("height")
    plt.show()
