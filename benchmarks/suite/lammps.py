"""PILE in LAMMPS, as a process of its own: springs and dashpots with friction and history, so stiff
that the largest overlap is about one hundredth of the radius, the usual compromise."""
import json
import math
import os
import re
import shutil

from runs import output_of

OVERLAP = 0.01  # of the radius, where the pile is deepest
FORCE_CHAINS = 4  # times the weight of a column of bodies: the largest force at the bottom
STEPS_PER_CONTACT = 25  # of the time that two spheres touch in a collision
RADIUS, GRAVITY = 0.45, 9.81

INPUT = """
units si
atom_style sphere
atom_modify map array
newton off
comm_modify vel yes
boundary f f f
read_data {folder}/bodies.data
pair_style gran/hooke/history {kn} {kt} {gamma_n} {gamma_t} {friction} 1
pair_coeff * *
neighbor 0.1 bin
neigh_modify delay 0
timestep {dt}
fix weight all gravity {gravity} vector 0 0 -1
fix floor all wall/gran hooke/history {kn} {kt} {gamma_n} {gamma_t} {friction} 1 zplane 0 NULL
fix x all wall/gran hooke/history {kn} {kt} {gamma_n} {gamma_t} {friction} 1 xplane 0 {side}
fix y all wall/gran hooke/history {kn} {kt} {gamma_n} {gamma_t} {friction} 1 yplane 0 {side}
fix move all nve/sphere
thermo 1000000
run {settle}
run {measure}
write_dump all custom {folder}/final.dump id x y z vx vy vz modify sort id format float %.17g
"""


def program():
    return shutil.which("lmp") or shutil.which("lammps")


def measure(bench, part, bodies):
    """Adds one row, or says why not."""
    tags = {"label": "lammps", "bodies": bodies}
    if bench.keep and bench.results.row(part, **tags):
        return
    if program() is None:
        bench.results.say(f"{part}: LAMMPS left out, it is not installed (apt install lammps)")
        return
    folder = os.path.join(bench.states, "lammps")
    os.makedirs(folder, exist_ok=True)
    scene = os.path.join(folder, "bodies.txt")
    output_of(bench.command("judge", {"bodies": bodies, "write": scene}))
    sites = round(math.ceil(bodies ** (1 / 3) - 1e-9))
    write_bodies(scene, os.path.join(folder, "bodies.data"), 1.05 * sites)

    mass = 4 / 3 * math.pi * RADIUS ** 3
    kn = FORCE_CHAINS * sites * mass * GRAVITY / (OVERLAP * RADIUS)
    contact_time = math.pi * math.sqrt(mass / 2 / kn)
    # Damping such that a tenth of the velocity is left: zero would need a dashpot above critical.
    decay = -math.log(0.1) / contact_time
    dt = contact_time / STEPS_PER_CONTACT
    settle, counted = (0.5, 0.05) if bench.quick else (3, 0.5)
    values = {"side": 1.05 * sites, "folder": folder, "kn": kn, "kt": 2 / 7 * kn, "gamma_n": 2 * decay,
              "gamma_t": decay, "friction": 0.5, "gravity": GRAVITY, "dt": dt,
              "settle": round(settle / dt), "measure": round(counted / dt)}
    with open(os.path.join(folder, "in.pile"), "w") as file:
        file.write(INPUT.format(**values))
    said, complaint = output_of([program(), "-in", os.path.join(folder, "in.pile"), "-log", "none"],
                                env={**os.environ, "OMP_NUM_THREADS": "1"}, cwd=folder)
    if said is None:
        bench.results.say(f"{part}: LAMMPS failed: {complaint}")
        return
    loops = re.findall(r"Loop time of ([\d.e+-]+) on", said)
    used = re.findall(r"([\d.]+)% CPU use", said)
    cpu = float(loops[-1]) * float(used[-1]) / 100
    positions = os.path.join(folder, "final.txt")
    write_positions(os.path.join(folder, "final.dump"), positions)
    judged, complaint = output_of(bench.command("judge", {"bodies": bodies, "read": positions}))
    if judged is None:
        bench.results.say(f"{part}: what LAMMPS wrote cannot be judged: {complaint}")
        return
    row = json.loads(judged)
    row.update(engine="lammps", cpu_per_simulated_second=cpu / counted, time_step=dt, stiffness=kn,
               cpu_ms_per_step=1e3 * cpu / counted / 240,
               cpu_ms_per_step_median=1e3 * cpu / counted / 240)
    bench.results.add(part, {**row, **tags})
    bench.results.say(f"{part}: lammps bodies={bodies}, {cpu / counted:.2f} CPU s per simulated s")


def write_bodies(scene, path, side):
    with open(scene) as file:
        lines = [line.split() for line in file]
    with open(path, "w") as file:
        file.write(f"PILE\n\n{len(lines)} atoms\n1 atom types\n")
        file.write(f"-1 {side + 1} xlo xhi\n-1 {side + 1} ylo yhi\n-1 {2 * side + 3} zlo zhi\n")
        file.write("\nAtoms # sphere\n\n")
        for n, (x, y, z, radius) in enumerate(lines, 1):
            file.write(f"{n} 1 {2 * float(radius)!r} 1 {x} {y} {z}\n")


def write_positions(dump, path):
    with open(dump) as file:
        lines = file.read().splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith("ITEM: ATOMS")) + 1
    with open(path, "w") as file:
        for line in lines[first:]:
            file.write(" ".join(line.split()[1:]) + "\n")
