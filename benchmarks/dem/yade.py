"""BED in YADE: Law2_ScGeom_MindlinPhys_Mindlin."""
import os
import re
import shutil

import material

# Walls touch as flat surfaces of the spheres' material.
INPUT = """
import math, time
from yade import O, utils
stuff = O.materials.append(FrictMat(young={young}, poisson={poisson},
                                    frictionAngle=math.atan({friction}), density={density}))
for line in open('{state}'):
    x = [float(word) for word in line.split()]
    n = O.bodies.append(utils.sphere(x[:3], x[3], material=stuff))
    O.bodies[n].state.vel, O.bodies[n].state.angVel = x[4:7], x[7:10]
spheres = len(O.bodies)
O.bodies.append(utils.wall(0, axis=2, sense=1, material=stuff))
for axis in 0, 1:
    O.bodies.append(utils.wall(0, axis=axis, sense=1, material=stuff))
    O.bodies.append(utils.wall({width}, axis=axis, sense=-1, material=stuff))
O.dt = {dt}
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()], verletDist={skin} / 2),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()],
                    [Ip2_FrictMat_FrictMat_MindlinPhys(en={restitution}, es={restitution})],
                    [Law2_ScGeom_MindlinPhys_Mindlin()]),
    NewtonIntegrator(damping=0, gravity=(0, 0, -{gravity}))]
O.run(1, True)
began = sum(os.times()[:2])
O.run({steps}, True)
print('seconds of the steps:', sum(os.times()[:2]) - began)
with open('{moved}', 'w') as out:
    for n in range(spheres):
        out.write(' '.join('%.17g' % x for x in (*O.bodies[n].state.pos, *O.bodies[n].state.vel)) + chr(10))
"""


def program():
    return shutil.which("yade")


def run(scene, steps, folder, moved, output_of):
    """CPU seconds of the steps; the state after them is in `moved`."""
    deck = os.path.join(folder, "bed.py")
    with open(deck, "w") as file:
        file.write("import os\n" + INPUT.format(
            young=material.YOUNG, poisson=material.POISSON, friction=material.FRICTION,
            density=material.DENSITY, restitution=material.RESTITUTION, gravity=material.GRAVITY,
            skin=material.SKIN, dt=scene["dt"], width=scene["width"], steps=steps,
            state=scene["state"], moved=moved))
    said = output_of([program(), "-j1", "-n", "-x", deck], folder)
    return float(re.search(r"seconds of the steps: ([\d.e+-]+)", said)[1])
