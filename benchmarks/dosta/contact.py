"""A single contact of Dosta and others (2024) in LIGGGHTS and in LAMMPS: one sphere against a plane,
or two spheres, the second at rest.

python3 benchmarks/dosta/contact.py [liggghts|lammps] CASE ...   prints the velocities after the contact
"""
import math
import os
import shutil
import subprocess
import sys
import tempfile

MATERIALS = {"M1": (1e9, 0.2, 2500), "M2": (0.5e9, 0.2, 2000), "steel": (210e9, 0.2, 7200)}
PAIRS = {frozenset(["M1"]): (0.5, 0.3), frozenset(["M1", "M2"]): (0.45, 0.2),
         frozenset(["M2"]): (0.4, 0.4), frozenset(["M1", "steel"]): (0.4, 0.2),
         frozenset(["M2", "steel"]): (0.4, 0.2), frozenset(["steel"]): (0.6, 0.5)}
NAMES = list(MATERIALS)


def pair(a, b):
    """Restitution and friction."""
    return PAIRS[frozenset([NAMES[a], NAMES[b]])]


def liggghts_properties(softness=1.0):
    """The lines for the three materials as types 1 to 3; `softness` divides the moduli of spheres."""
    moduli = " ".join(repr(e / (softness if n != "steel" else 1)) for n, (e, _, _) in MATERIALS.items())
    every = [pair(a, b) for a in range(3) for b in range(3)]
    return "\n".join([
        f"fix young all property/global youngsModulus peratomtype {moduli}",
        "fix poisson all property/global poissonsRatio peratomtype 0.2 0.2 0.2",
        "fix restitution all property/global coefficientRestitution peratomtypepair 3 "
        + " ".join(str(e) for e, _ in every),
        "fix friction all property/global coefficientFriction peratomtypepair 3 "
        + " ".join(str(f) for _, f in every)])


def restitution_for_tsuji(e):
    """What LAMMPS must be given for an impact to have the restitution e. Its damping is a polynomial
    of what it is given (Tsuji, Tanaka, Ishida 1992), and an impact then has a larger restitution."""
    wanted = math.sqrt(5) * -math.log(e) / math.hypot(math.log(e), math.pi)
    low, high = 0.0, 1.0
    for _ in range(60):
        x = (low + high) / 2
        alpha = (1.2728 - 4.2783 * x + 11.087 * x**2 - 22.348 * x**3 + 27.467 * x**4
                 - 18.022 * x**5 + 4.8218 * x**6)
        low, high = (x, high) if alpha > wanted else (low, x)
    return low


def lammps_law(a, b, softness=1.0):
    """hertz with the effective modulus of the pair, as talus combines it; 8 G* across."""
    (ea, nu, _), (eb, _, _) = MATERIALS[NAMES[a]], MATERIALS[NAMES[b]]
    ea, eb = (e / (softness if n != "steel" else 1) for e, n in ((ea, NAMES[a]), (eb, NAMES[b])))
    effective = 1 / ((1 - nu * nu) / ea + (1 - nu * nu) / eb)
    shear = 1 / (2 * (2 - nu) * (1 + nu) / ea + 2 * (2 - nu) * (1 + nu) / eb)
    e, friction = pair(a, b)
    return (f"hertz {4 / 3 * effective!r} {restitution_for_tsuji(e)!r} tangential mindlin {8 * shear!r} 1.0 {friction} "
            "damping tsuji")


# name: material and radius of the sphere, partner ("plane" or "sphere"), its material, velocity, dt
CASES = {
    "steel-steel/5": ("steel", 0.01, "plane", "steel", (0, 0, -5), 2e-8),
    "steel-steel/5/published dt": ("steel", 0.01, "plane", "steel", (0, 0, -5), 5e-7),
    "steel-steel/2": ("steel", 0.01, "plane", "steel", (0, 0, -2), 2e-8),
    "steel-steel/2/published dt": ("steel", 0.01, "plane", "steel", (0, 0, -2), 5e-7),
    "M1-steel/1": ("M1", 0.001, "plane", "steel", (0, 0, -1), 2e-8),
    "M1-steel/1/published dt": ("M1", 0.001, "plane", "steel", (0, 0, -1), 5e-7),
    "M1-steel/oblique": ("M1", 0.001, "plane", "steel", (1, 0, -1), 2e-8),
    "M1-steel/oblique/published dt": ("M1", 0.001, "plane", "steel", (1, 0, -1), 5e-7),
    "M1-steel/sticking": ("M1", 0.001, "plane", "steel", (0.2, 0, -1), 2e-8),
    "M1-M1/1": ("M1", 0.001, "sphere", "M1", (0, 0, -1), 2e-8),
    "M1-M1/1/published dt": ("M1", 0.001, "sphere", "M1", (0, 0, -1), 5e-7),
    "M1-M1/oblique": ("M1", 0.001, "sphere", "M1", (0.5, 0, -1), 2e-8),
    "steel-M1/5": ("steel", 0.01, "sphere", "M1", (0, 0, -5), 2e-8),
}

LIGGGHTS = """units si
hard_particles yes
soft_particles yes
atom_style granular
atom_modify map array
newton off
communicate single vel yes
boundary f f f
region all block -0.1 0.1 -0.1 0.1 -0.1 0.1 units box
create_box 3 all
{properties}
pair_style gran model hertz tangential history
pair_coeff * *
neighbor 0.0002 bin
neigh_modify delay 0 every 1 check yes
{atoms}
{wall}
timestep {dt}
fix move all nve/sphere
dump out all custom {steps} {folder}/out.dump id vx vy vz omegax omegay omegaz
dump_modify out format "%d %.12g %.12g %.12g %.12g %.12g %.12g" sort id
thermo 100000000
run {steps}
"""
LAMMPS = """units si
atom_style sphere
atom_modify map array
newton off
comm_modify vel yes
boundary f f f
region all block -0.1 0.1 -0.1 0.1 -0.1 0.1 units box
create_box 3 all
pair_style granular
{laws}
neighbor 0.0002 bin
neigh_modify delay 0 every 1 check yes
{atoms}
{wall}
timestep {dt}
fix move all nve/sphere
dump out all custom {steps} {folder}/out.dump id vx vy vz omegax omegay omegaz
dump_modify out format float %.12g sort id
thermo 100000000
run {steps}
"""


def execute(code, text, folder):
    """What the program prints; ends with its complaint if it fails."""
    deck = os.path.join(folder, "in.deck")
    with open(deck, "w") as file:
        file.write(text)
    program = shutil.which("liggghts" if code == "liggghts" else "lmp")
    if program is None:
        sys.exit(f"{code} is not installed (apt install {code})")
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "OMPI_ALLOW_RUN_AS_ROOT": "1",
                   "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
                   "OMPI_MCA_btl_vader_single_copy_mechanism": "none"}
    done = subprocess.run([program, "-in", deck, "-log", "none"], cwd=folder, env=environment,
                          capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(done.stdout[-2000:] + done.stderr[-2000:])
    return done.stdout


def cpu_seconds():
    """CPU time of the programs that have been run."""
    return sum(os.times()[2:4])


def run(code, case):
    material, radius, partner, other, velocity, dt = CASES[case]
    a, b = NAMES.index(material), NAMES.index(other)
    gap = 0.25 * dt * -velocity[2]
    density = MATERIALS[material][2]
    atoms = [f"create_atoms {a + 1} single 0 0 {radius + gap!r} units box",
             f"set atom 1 diameter {2 * radius!r} density {density}",
             "velocity all set {} {} {} units box".format(*velocity)]
    wall = ""
    if partner == "sphere":  # of the radius of M1, below
        atoms.insert(1, f"create_atoms {b + 1} single 0 0 -0.001 units box")
        atoms[-1] = "group one id 1\n" + atoms[-1].replace("all", "one")
        atoms.insert(3, f"set atom 2 diameter 0.002 density {MATERIALS[other][2]}")
    elif code == "liggghts":
        wall = f"fix wall all wall/gran model hertz tangential history primitive type {b + 1} zplane 0"
    else:
        wall = f"fix wall all wall/gran granular {lammps_law(a, b)} zplane 0 NULL"
    # LIGGGHTS wants an atom of the first type.
    bodies = 2 if partner == "sphere" else 1
    atoms += ["create_atoms 1 single 0.09 0.09 0.09 units box",
              f"set atom {bodies + 1} diameter 0.002 density 2500"]
    laws = "\n".join(f"pair_coeff {i + 1} {j + 1} {lammps_law(i, j)}"
                     for i in range(3) for j in range(i, 3))
    # Ten times the duration of an elastic impact of M1 at 1 m/s.
    steps = math.ceil(2.5e-4 / dt)
    with tempfile.TemporaryDirectory() as folder:
        text = (LIGGGHTS if code == "liggghts" else LAMMPS).format(
            properties=liggghts_properties(), laws=laws, atoms="\n".join(atoms), wall=wall, dt=dt,
            steps=steps, folder=folder)
        execute(code, text, folder)
        with open(os.path.join(folder, "out.dump")) as file:
            lines = file.read().splitlines()
    last = max(i for i, line in enumerate(lines) if line.startswith("ITEM: ATOMS"))
    return [[float(x) for x in line.split()[1:]] for line in lines[last + 1:last + 1 + bodies]]


def main():
    codes = [w for w in sys.argv[1:] if w in ("liggghts", "lammps")] or ["liggghts", "lammps"]
    cases = [w for w in sys.argv[1:] if w in CASES] or list(CASES)
    for case in cases:
        for code in codes:
            for n, (vx, _, vz, _, wy, _) in enumerate(run(code, case)):
                print(f"{case:32} {code:9} body {n + 1}: vx {vx:.6f} vz {vz:.6f} wy {wy:.4f}",
                      flush=True)


if __name__ == "__main__":
    main()
