"""The rotating drum of Dosta and others (2024) in LIGGGHTS or YADE, on the published files.

python3 benchmarks/dosta/drum.py liggghts|yade FOLDER SOFTNESS DT STEPS [POSITIONS]
prints the numbers of spheres in two quadrants every 0.05 s (as dosta_drum --curve) and the time of the
loop, and writes the positions after the last step.
"""
import os
import shutil
import subprocess
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

# (YADE's e and friction angle of pairs: M1-M1, M1-M2, M2-M2, M1-steel, M2-steel, steel-steel.)
YADE = """import math, os
from yade import O, utils
stuff = [O.materials.append(FrictMat(young=e, poisson=0.2, density=d, frictionAngle=math.atan(0.3)))
         for e, d in {moduli}]
def of_pairs(values):
    return MatchMaker(matches=[(stuff[a], stuff[b], v) for (a, b), v in zip({pairs}, values)])
for kind, radius, place in {spheres}:
    O.bodies.append(utils.sphere(place, radius, material=stuff[kind - 1]))
count = len(O.bodies)
for t in {triangles}:
    O.bodies.append(utils.facet([Vector3(*t[k:k + 3]) for k in (0, 3, 6)], material=stuff[2]))
facets = list(range(count, len(O.bodies)))
bounce, angle = of_pairs({restitutions}), of_pairs([math.atan(f) for f in {frictions}])
O.dt = {dt}
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Facet_Aabb()], verletDist={skin} / 2),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom(), Ig2_Facet_Sphere_ScGeom()],
                    [Ip2_FrictMat_FrictMat_MindlinPhys(en=bounce, es=bounce, frictAngle=angle)],
                    [Law2_ScGeom_MindlinPhys_Mindlin()]),
    RotationEngine(ids=facets, rotationAxis=(0, 1, 0), angularVelocity=-2, rotateAroundZero=True,
                   zeroPoint=(0, 0, 0)),
    NewtonIntegrator(damping=0, gravity=(0, 0, -9.8))]
O.run(1, True)
began = sum(os.times()[:2])
O.run({steps} - 1, True)
seconds = sum(os.times()[:2]) - began
with open('{folder}/out.dump', 'w') as out:
    out.write('ITEM: TIMESTEP\\n{steps}' + 8 * '\\n')
    for n in range(count):
        p = O.bodies[n].state.pos
        out.write('%d %d %.17g %.17g %.17g\\n' % (n, 1 + (O.bodies[n].shape.radius > 0.0015), *p))
with open('{folder}/seconds', 'w') as out:
    out.write(repr(seconds))
os._exit(0)
"""


def table_of(path, count):
    with open(path) as file:
        rows = [[float(word) for word in line.split()] for line in file.readlines()[1:]]
    return [row for row in rows if len(row) == count]


def write_stl(table, path):
    with open(path, "w") as file:
        file.write("solid wall\n")
        for row in table_of(table, 9):
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
    return [(2 if row[0] > 0.0015 else 1, row[0], row[1:])
            for row in table_of(os.path.join(folder, "drum_particles.txt"), 4)]


def run_liggghts(folder, files, spheres, softness, dt, steps, every, skin):
    """CPU seconds of the steps."""
    write_stl(os.path.join(files, "drum_walls.txt"), os.path.join(folder, "drum.stl"))
    with open(os.path.join(folder, "bodies.data"), "w") as file:
        file.write(f"drum\n\n{len(spheres)} atoms\n3 atom types\n-0.11 0.11 xlo xhi\n"
                   "-0.04 0.04 ylo yhi\n-0.11 0.11 zlo zhi\n\nAtoms\n\n")
        for n, (kind, radius, (x, y, z)) in enumerate(spheres, 1):
            file.write(f"{n} {kind} {2 * radius!r} {(2500, 2000)[kind - 1]} {x!r} {y!r} {z!r}\n")
    text = LIGGGHTS.format(folder=folder, properties=contact.liggghts_properties(softness), dt=dt,
                           steps=steps, every=every, skin=skin)
    contact.execute("liggghts", text.replace(f"run {steps}", "run 0"), folder)
    reading = contact.cpu_seconds()
    contact.execute("liggghts", text, folder)
    return contact.cpu_seconds() - 2 * reading


def run_yade(folder, files, spheres, softness, dt, steps, _, skin):
    pairs = [(0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)]
    values = [contact.pair(a, b) for a, b in pairs]
    moduli = [(e / (softness if name != "steel" else 1), d)
              for name, (e, _, d) in contact.MATERIALS.items()]
    deck = os.path.join(folder, "drum.py")
    with open(deck, "w") as file:
        file.write(YADE.format(moduli=moduli, pairs=pairs, spheres=spheres,
                               triangles=table_of(os.path.join(files, "drum_walls.txt"), 9),
                               restitutions=[v[0] for v in values], frictions=[v[1] for v in values],
                               dt=dt, steps=steps, skin=skin, folder=folder))
    if shutil.which("yade") is None:
        sys.exit("yade is not installed (apt install yade)")
    subprocess.run(["yade", "-j1", "-n", "-x", deck], cwd=folder, capture_output=True, check=False)
    with open(os.path.join(folder, "seconds")) as file:
        return float(file.read())


def main():
    code, files, softness, dt, steps = sys.argv[1:6]
    softness, dt, steps = float(softness), float(dt), int(steps)
    every = min(steps, max(1, round(0.05 / dt)))
    spheres = spheres_of(files)
    with tempfile.TemporaryDirectory() as folder:
        run = {"liggghts": run_liggghts, "yade": run_yade}[code]
        seconds = run(folder, files, spheres, softness, dt, steps, every,
                      os.environ.get("SKIN", "0.0004"))
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
