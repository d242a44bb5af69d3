"""The penetration of Dosta and others (2024) in LIGGGHTS or LAMMPS, from a state of the bed.

python3 benchmarks/dosta/penetration.py CODE STATE SPHERE_Z SPHERE_VZ SHIFT DT STEPS   prints time and height

STATE has lines of radius, position, velocity and angular velocity of the beads, or only radius and
position (the published file); SHIFT moves the steel sphere along x.
"""
import math
import os
import sys
import tempfile

import contact

LIGGGHTS = """units si
hard_particles yes
soft_particles yes
atom_style granular
atom_modify map array
newton off
communicate single vel yes
boundary f f f
read_data {folder}/bodies.data
{properties}
pair_style gran model hertz tangential history
pair_coeff * *
neighbor 0.0004 bin
neigh_modify delay 0 every 1 check yes
timestep {dt}
fix weight all gravity 9.8 vector 0 0 -1
fix floor all wall/gran model hertz tangential history primitive type 3 zplane -0.0902431
fix x_low all wall/gran model hertz tangential history primitive type 3 xplane -0.049
fix x_high all wall/gran model hertz tangential history primitive type 3 xplane 0.049
fix y_low all wall/gran model hertz tangential history primitive type 3 yplane -0.03
fix y_high all wall/gran model hertz tangential history primitive type 3 yplane 0.03
fix move all nve/sphere
group ball type 3
dump out ball custom {every} {folder}/out.dump z vz
dump_modify out format "%.12g %.12g"
thermo 100000000
run {steps}
"""
LAMMPS = """units si
atom_style sphere
atom_modify map array
newton off
comm_modify vel yes
boundary f f f
read_data {folder}/bodies.data
pair_style granular
{laws}
neighbor 0.0004 bin
neigh_modify delay 0 every 1 check yes
timestep {dt}
group beads type 1
group ball type 3
fix weight all gravity 9.8 vector 0 0 -1
fix floor beads wall/gran granular {bead_law} zplane -0.0902431 NULL
fix floor_of_ball ball wall/gran granular {ball_law} zplane -0.0902431 NULL
fix x beads wall/gran granular {bead_law} xplane -0.049 0.049
fix y beads wall/gran granular {bead_law} yplane -0.03 0.03
fix move all nve/sphere
dump out ball custom {every} {folder}/out.dump z vz
dump_modify out format float %.12g
thermo 100000000
run {steps}
"""


def main():
    code, state = sys.argv[1:3]
    z, vz, shift, dt = (float(word) for word in sys.argv[3:7])
    steps = int(sys.argv[7])
    with open(state) as file:
        rows = [line.split() for line in file]
    beads = [row for row in rows if len(row) in (4, 10) and row[0][0].isdigit()]
    every = round(1e-4 / dt)
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "bodies.data"), "w") as file:
            file.write(f"penetration\n\n{len(beads) + 1} atoms\n3 atom types\n-0.052 0.052 xlo xhi\n"
                       "-0.032 0.032 ylo yhi\n-0.095 0.075 zlo zhi\n\nAtoms\n\n")
            for n, row in enumerate(beads, 1):
                file.write(f"{n} 1 {2 * float(row[0])!r} 2500 {' '.join(row[1:4])}\n")
            file.write(f"{len(beads) + 1} 3 0.02 7200 {shift!r} 0 {z!r}\n\nVelocities\n\n")
            for n, row in enumerate(beads, 1):
                file.write(f"{n} {' '.join(row[4:] or ['0'] * 6)}\n")
            file.write(f"{len(beads) + 1} 0 0 {vz!r} 0 0 0\n")
        laws = "\n".join(f"pair_coeff {i + 1} {j + 1} {contact.lammps_law(i, j)}"
                         for i in range(3) for j in range(i, 3))
        text = (LIGGGHTS if code == "liggghts" else LAMMPS).format(
            folder=folder, properties=contact.liggghts_properties(), laws=laws, dt=dt, every=every,
            steps=steps, bead_law=contact.lammps_law(0, 2), ball_law=contact.lammps_law(2, 2))
        contact.execute(code, text, folder)
        print(f"# CPU seconds, with reading: {contact.cpu_seconds():.2f}")
        with open(os.path.join(folder, "out.dump")) as file:
            lines = file.read().splitlines()
    for at, line in enumerate(lines):
        if line.startswith("ITEM: TIMESTEP"):
            print(f"{int(lines[at + 1]) * dt:.6f} {lines[at + 9]}")


if __name__ == "__main__":
    main()
