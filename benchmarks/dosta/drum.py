"""The rotating drum of Dosta and others (2024) in LIGGGHTS or YADE, on the published files.

python3 benchmarks/dosta/drum.py liggghts FOLDER SOFTNESS DT STEPS [POSITIONS]
prints the numbers of spheres in two quadrants every 0.05 s (as dosta_drum --curve) and the time of the
loop, and writes the positions after the last step.
"""
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
neighbor {skin} bin
neigh_modify delay 0 every 1 check yes
timestep {dt}
fix weight all gravity 9.8 vector 0 0 -1
fix shell all mesh/surface file {folder}/drum.stl type 3 curvature_tolerant yes
fix wall all wall/gran model hertz tangential history mesh n_meshes 1 meshes shell
fix turn all move/mesh mesh shell rotate origin 0 0 0 axis 0 -1 0 period 3.141592653589793
fix move all nve/sphere
dump out all custom {every} {folder}/out.dump id type x y z
dump_modify out format "%d %d %.17g %.17g %.17g" sort id
thermo 100000000
run {steps}
"""


def write_stl(table, path):
    with open(table) as file:
        rows = [[float(word) for word in line.split()] for line in file.readlines()[1:]]
    with open(path, "w") as file:
        file.write("solid wall\n")
        for row in rows:
            if len(row) != 9:
                continue
            a, b, c = row[:3], row[3:6], row[6:]
            u, v = [q - p for p, q in zip(a, b)], [q - p for p, q in zip(a, c)]
            n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
            size = sum(x * x for x in n) ** 0.5
            if size == 0:
                continue
            file.write("facet normal {} {} {}\nouter loop\n".format(*(x / size for x in n)))
            for p in (a, b, c):
                file.write("vertex {!r} {!r} {!r}\n".format(*p))
            file.write("endloop\nendfacet\n")
        file.write("endsolid wall\n")


def spheres_of(folder):
    """Type, radius and position of each sphere."""
    with open(os.path.join(folder, "drum_particles.txt")) as file:
        rows = [line.split() for line in file.readlines()[1:]]
    return [(2 if float(row[0]) > 0.0015 else 1, float(row[0]), row[1:4]) for row in rows if len(row) == 4]


def main():
    code, files, softness, dt, steps = sys.argv[1:6]
    softness, dt, steps = float(softness), float(dt), int(steps)
    every = min(steps, max(1, round(0.05 / dt)))
    spheres = spheres_of(files)
    with tempfile.TemporaryDirectory() as folder:
        write_stl(os.path.join(files, "drum_walls.txt"), os.path.join(folder, "drum.stl"))
        with open(os.path.join(folder, "bodies.data"), "w") as file:
            file.write(f"drum\n\n{len(spheres)} atoms\n3 atom types\n-0.11 0.11 xlo xhi\n"
                       "-0.04 0.04 ylo yhi\n-0.11 0.11 zlo zhi\n\nAtoms\n\n")
            for n, (kind, radius, place) in enumerate(spheres, 1):
                file.write(f"{n} {kind} {2 * radius!r} {(2500, 2000)[kind - 1]} {' '.join(place)}\n")
        text = LIGGGHTS.format(folder=folder, properties=contact.liggghts_properties(softness), dt=dt,
                               steps=steps, every=every, skin=os.environ.get("SKIN", "0.0004"))
        contact.execute(code, text.replace(f"run {steps}", "run 0"), folder)
        before = contact.cpu_seconds()
        contact.execute(code, text, folder)
        seconds = contact.cpu_seconds() - 2 * before  # of the steps, without reading
        print(f"# {1000 * seconds / steps:.4g} ms of CPU time a step, "
              f"{seconds / steps / len(spheres):.4g} s per particle and step")
        with open(os.path.join(folder, "out.dump")) as file:
            lines = file.read().splitlines()
    count = len(spheres)
    for at, line in enumerate(lines):
        if not line.startswith("ITEM: TIMESTEP"):
            continue
        rows = [words.split() for words in lines[at + 9:at + 9 + count]]
        seen = [0, 0, 0, 0]
        for _, kind, x, _, z in rows:
            x, z = float(x), float(z)
            if x > 0 and z > 0:
                seen[int(kind) - 1] += 1
            if x < 0 and z < 0:
                seen[1 + int(kind)] += 1
        print(f"{int(lines[at + 1]) * dt:.6g}", *seen)
    if len(sys.argv) > 6:
        with open(sys.argv[6], "w") as file:
            file.writelines(f"{r[2]} {r[3]} {r[4]}\n" for r in rows)


if __name__ == "__main__":
    main()
