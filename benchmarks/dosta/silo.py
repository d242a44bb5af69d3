"""The discharge of the silo of Dosta and others (2024) in LIGGGHTS, from a settled state.

python3 benchmarks/dosta/silo.py STATE WALLS LIP SOFTNESS DT STEPS   prints time and spheres above the lip

STATE is the table that the example silo writes with --settled; spheres are of M1.
"""
import csv
import os
import sys
import tempfile

import contact
import drum

RADIUS = 0.002
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
neighbor 0.0008 bin
neigh_modify delay 0 every 1 check yes
timestep {dt}
fix weight all gravity 9.8 vector 0 0 -1
fix shell all mesh/surface file {folder}/wall.stl type 3 curvature_tolerant yes
fix wall all wall/gran model hertz tangential history mesh n_meshes 1 meshes shell
fix move all nve/sphere
dump out all custom {every} {folder}/out.dump z
thermo_modify lost ignore
thermo 100000000
run {steps}
"""


def main():
    state, walls = sys.argv[1:3]
    lip, softness, dt = (float(word) for word in sys.argv[3:6])
    steps = int(sys.argv[6])
    with open(state, newline="") as file:
        table = [{name.split()[0]: value for name, value in row.items()} for row in csv.DictReader(file)]
    spheres = [row for row in table if row["shape"] == "sphere"]
    top = max(float(row["position_z"]) for row in spheres)

    def vectors(row, *names):
        return " ".join(row[f"{name}_{axis}"] for name in names for axis in "xyz")
    with tempfile.TemporaryDirectory() as folder:
        drum.write_stl(walls, os.path.join(folder, "wall.stl"))
        with open(os.path.join(folder, "bodies.data"), "w") as file:
            file.write(f"silo\n\n{len(spheres)} atoms\n3 atom types\n-0.105 0.105 xlo xhi\n"
                       f"-0.105 0.105 ylo yhi\n{lip - 0.02!r} {max(top + 0.01, 1.0)!r} zlo zhi\n\nAtoms\n\n")
            for n, row in enumerate(spheres, 1):
                file.write(f"{n} 1 {2 * RADIUS!r} 2500 {vectors(row, 'position')}\n")
            file.write("\nVelocities\n\n")
            for n, row in enumerate(spheres, 1):
                file.write(f"{n} {vectors(row, 'velocity', 'angular_velocity')}\n")
        text = LIGGGHTS.format(folder=folder, properties=contact.liggghts_properties(softness), dt=dt,
                               steps=steps, every=round(0.01 / dt))
        contact.execute("liggghts", text, folder)
        print(f"# CPU seconds, with reading: {contact.cpu_seconds():.2f}")
        with open(os.path.join(folder, "out.dump")) as file:
            lines = file.read().splitlines()
    at = 0
    while at < len(lines):
        step, count = int(lines[at + 1]), int(lines[at + 3])
        above = sum(float(line) > lip for line in lines[at + 9:at + 9 + count])
        print(f"{step * dt:.6g} {above}")
        at += 9 + count


if __name__ == "__main__":
    main()
