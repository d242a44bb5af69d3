"""BED in LIGGGHTS: pair_style gran model hertz tangential history."""
import os
import resource
import shutil

import lammps
import material

INPUT = """
units si
atom_style granular
atom_modify map array
newton off
communicate single vel yes
boundary f f f
read_data {folder}/bodies.data
fix young all property/global youngsModulus peratomtype {young}
fix poisson all property/global poissonsRatio peratomtype {poisson}
fix restitution all property/global coefficientRestitution peratomtypepair 1 {restitution}
fix friction all property/global coefficientFriction peratomtypepair 1 {friction}
pair_style gran model hertz tangential history
pair_coeff * *
neighbor {skin} bin
neigh_modify delay 0 every 1 check yes
timestep {dt}
fix weight all gravity {gravity} vector 0 0 -1
fix floor all wall/gran model hertz tangential history primitive type 1 zplane 0
fix x_low all wall/gran model hertz tangential history primitive type 1 xplane 0
fix x_high all wall/gran model hertz tangential history primitive type 1 xplane {width}
fix y_low all wall/gran model hertz tangential history primitive type 1 yplane 0
fix y_high all wall/gran model hertz tangential history primitive type 1 yplane {width}
fix move all nve/sphere
thermo 1000000
run 1
run {steps}
dump moved all custom 1000000 {folder}/moved.dump id x y z vx vy vz
dump_modify moved format "%d %.17g %.17g %.17g %.17g %.17g %.17g" first yes
run 0
"""


def program():
    return shutil.which("liggghts")


def run(scene, steps, folder, moved, output_of):
    """CPU seconds of the steps; the state after them is in `moved`."""
    values = {"folder": folder, "young": material.YOUNG, "poisson": material.POISSON,
              "restitution": material.RESTITUTION, "friction": material.FRICTION,
              "skin": material.SKIN, "dt": scene["dt"], "gravity": material.GRAVITY,
              "width": scene["width"], "steps": steps}
    lammps.write_bodies(scene, os.path.join(folder, "bodies.data"), "1 {diameter} {density} {place}")
    deck = os.path.join(folder, "in.bed")
    seconds = []
    # It reports the time that passes, which other programs lengthen: the CPU time of the steps is
    # that of two runs, without them and with them.
    for values["steps"] in (0, steps):
        with open(deck, "w") as file:
            file.write(INPUT.format(**values))
        before = children_seconds()
        output_of([program(), "-in", deck, "-log", "none"], folder)
        seconds.append(children_seconds() - before)
    lammps.write_moved(os.path.join(folder, "moved.dump"), moved)
    return max(seconds[1] - seconds[0], 1e-9)


def children_seconds():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
