"""BED in LAMMPS: pair_style granular."""
import os
import re
import shutil

import material

INPUT = """
units si
atom_style sphere
atom_modify map array
newton off
comm_modify vel yes
boundary f f f
read_data {folder}/bodies.data
pair_style granular
pair_coeff * * {law}
neighbor {skin} bin
neigh_modify delay 0 every 1 check yes
timestep {dt}
fix weight all gravity {gravity} vector 0 0 -1
fix floor all wall/gran granular {law} zplane 0 NULL
fix x all wall/gran granular {law} xplane 0 {width}
fix y all wall/gran granular {law} yplane 0 {width}
fix move all nve/sphere
thermo 1000000
run 1
run {steps}
write_dump all custom {folder}/moved.dump id x y z vx vy vz modify sort id format float %.17g
"""
LAW = "hertz/material {young} {restitution} {poisson} tangential mindlin NULL 1.0 {friction} damping tsuji"


def program():
    return shutil.which("lmp")


def run(scene, steps, folder, moved, output_of):
    """CPU seconds of the steps; the state after them is in `moved`."""
    values = {"young": material.YOUNG, "restitution": material.RESTITUTION,
              "poisson": material.POISSON, "friction": material.FRICTION}
    values = {"folder": folder, "law": LAW.format(**values), "skin": material.SKIN,
              "dt": scene["dt"], "gravity": material.GRAVITY, "width": scene["width"],
              "steps": steps}
    write_bodies(scene, os.path.join(folder, "bodies.data"), "1 {diameter} {density} {place}")
    deck = os.path.join(folder, "in.bed")
    with open(deck, "w") as file:
        file.write(INPUT.format(**values))
    said = output_of([program(), "-in", deck, "-log", "none"], folder)
    write_moved(os.path.join(folder, "moved.dump"), moved)
    return seconds_of(said)


def seconds_of(said):
    loop = float(re.findall(r"Loop time of ([\d.e+-]+) on", said)[-1])
    used = re.findall(r"([\d.]+)% CPU use", said)
    return loop * float(used[-1]) / 100 if used else loop


def write_bodies(scene, path, columns):
    """A data file; `columns` are those of an atom after its number."""
    width = scene["width"]
    with open(path, "w") as file:
        file.write(f"BED\n\n{len(scene['lines'])} atoms\n1 atom types\n")
        low, high = -0.1 * width, 1.1 * width
        file.write(f"{low!r} {high!r} xlo xhi\n{low!r} {high!r} ylo yhi\n")
        file.write(f"{low!r} {2 * width!r} zlo zhi\n\nAtoms\n\n")
        for n, line in enumerate(scene["lines"], 1):
            x, y, z, radius = line[:4]
            file.write(f"{n} " + columns.format(diameter=repr(2 * float(radius)),
                                                density=material.DENSITY,
                                                place=f"{x} {y} {z}") + "\n")
        file.write("\nVelocities\n\n")
        for n, line in enumerate(scene["lines"], 1):
            file.write(f"{n} {' '.join(line[4:])}\n")


def write_moved(dump, path):
    with open(dump) as file:
        lines = file.read().splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith("ITEM: ATOMS")) + 1
    atoms = sorted((line.split() for line in lines[first:]), key=lambda words: int(words[0]))
    with open(path, "w") as file:
        for words in atoms:
            file.write(" ".join(words[1:7]) + "\n")
