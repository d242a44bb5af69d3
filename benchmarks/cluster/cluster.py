#!/usr/bin/env python3
"""PILE on two nodes of an emulated cluster: network namespaces joined by a veth pair, Open MPI over
TCP, one process and one core each, on links of several delays and rates.

cluster.py BUILD [--bodies N] [--settle N] [--measure N] [--turns N] [--from FILE] [--quick] [--json FILE]
  BUILD      folder of the benchmark programs
  --bodies   spheres of the pile (64,000)
  --settle   steps before the measured ones (30), --measure: these (30)
  --turns    runs of each, in turns, of which the fastest counts (3)
  --from     file with the settled pile; without it the pile settles first
  --quick    1,000 spheres, one turn, to see whether all works
  --json     write the rows here

Needs root, iproute2 and two cores. A delay needs the kernel's netem, a rate netem or tbf: what the
kernel does not have is left out, with a message. If no node can be made, nothing is measured, and the
exit code is 0.
"""
import argparse
import json
import os
import pathlib
import shlex
import shutil
import stat
import subprocess
import sys
import tempfile

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1]))
import beside  # noqa: E402

TIMEOUT = 1800
SUBNET = "10.231.7"
# Name, delay of each way in microseconds, rate in Gbit/s; 0: as the veth pair has it.
LINKS = [("veth", 0, 0), ("50 us, 10 Gbit/s", 50, 10), ("500 us, 1 Gbit/s", 500, 1)]
SOLVERS = ["nonlinear_gauss_seidel", "coloured_gauss_seidel"]


class Missing(Exception):
    """Something that the emulation needs is not there."""


def ran(*words):
    return subprocess.run(words, capture_output=True, text=True, timeout=60)


def must(*words):
    try:
        done = ran(*words)
    except FileNotFoundError:
        raise Missing(f"there is no {words[0]}") from None
    if done.returncode != 0:
        raise Missing(f"'{' '.join(words)}' fails: {(done.stderr or done.stdout).strip()}")


class Cluster:
    """Two nodes. A node is a network namespace with a host name and a core of its own."""

    def __init__(self, folder):
        self.nodes = [f"talus{os.getpid()}{k}" for k in "ab"]
        self.devices = [f"tv{os.getpid()}{k}" for k in "ab"]
        self.folder = folder
        try:
            for node in self.nodes:
                must("ip", "netns", "add", node)
            a, b = self.nodes
            must("ip", "link", "add", self.devices[0], "netns", a, "type", "veth", "peer", "name",
                 self.devices[1], "netns", b)
            for k, (node, device) in enumerate(zip(self.nodes, self.devices)):
                must("ip", "-n", node, "addr", "add", f"{SUBNET}.{k + 1}/24", "dev", device)
                must("ip", "-n", node, "link", "set", "lo", "up")
                must("ip", "-n", node, "link", "set", device, "up")
                must(*self.on(k, "true"))
        except Missing:
            self.close()
            raise
        self.agent = os.path.join(folder, "agent")
        with open(self.agent, "w") as file:
            file.write("#!/bin/sh\n# mpirun's remote shell: HOST COMMAND...\nhost=$1\nshift\n"
                       "case $host in\n" +
                       "".join(f"{SUBNET}.{k + 1}) exec {shlex.join(self.on(k))} sh -c \"$*\" ;;\n"
                               for k in range(2)) + "esac\n")
        os.chmod(self.agent, os.stat(self.agent).st_mode | stat.S_IXUSR)

    def on(self, k, *words):
        """A command on node k."""
        name = f"node{k + 1}"
        return ["ip", "netns", "exec", self.nodes[k], "unshare", "--uts", "taskset", "-c",
                str(sorted(os.sched_getaffinity(0))[k]), "sh", "-c",
                f"hostname {name} && exec \"$@\"", name, *words]

    def close(self):
        for node in self.nodes:
            ran("ip", "netns", "del", node)

    def shape(self, delay, rate):
        """Sets the link. Returns how, or None with a message if the kernel cannot."""
        for node, device in zip(self.nodes, self.devices):
            ran("tc", "-n", node, "qdisc", "del", "dev", device, "root")
        if not delay and not rate:
            return "plain"
        netem = ["netem", "limit", "100000", "delay", f"{delay}us", "rate", f"{rate}gbit"]
        tbf = ["tbf", "rate", f"{rate}gbit", "burst", "256kb", "latency", "100ms"]
        for how, words in (("netem", netem), ("tbf", tbf)):
            done = [ran("tc", "-n", node, "qdisc", "add", "dev", device, "root", *words)
                    for node, device in zip(self.nodes, self.devices)]
            if all(each.returncode == 0 for each in done):
                return how
            for node, device in zip(self.nodes, self.devices):
                ran("tc", "-n", node, "qdisc", "del", "dev", device, "root")
        return None

    def run(self, words):
        """A program on both nodes; what it says, or None."""
        interface = f"{SUBNET}.0/24"
        launch = ["mpirun", "-q", "--mca", "plm_rsh_agent", self.agent, "--mca", "pml", "ob1",
                  "--mca", "btl", "tcp,self", "--mca", "btl_tcp_if_include", interface,
                  "--mca", "oob_tcp_if_include", interface, "--bind-to", "none",
                  "--host", f"{SUBNET}.1:1,{SUBNET}.2:1", "-n", "2"]
        return output_of(self.on(0, *launch, *words))


def output_of(words):
    done = subprocess.run(words, capture_output=True, text=True, timeout=TIMEOUT)
    if done.returncode != 0:
        say(f"failed: {(done.stderr or done.stdout).strip()[-500:]}")
        return None
    return json.loads(done.stdout)


def say(text):
    print(f"cluster: {text}", file=sys.stderr, flush=True)


def require_all(build):
    if os.geteuid() != 0:
        raise Missing("only root may make network namespaces")
    for program in ("ip", "tc", "unshare", "taskset", "hostname", "mpirun"):
        if shutil.which(program) is None:
            raise Missing(f"there is no {program}")
    if "Open MPI" not in ran("mpirun", "--version").stdout:
        raise Missing("mpirun is not that of Open MPI")
    if len(os.sched_getaffinity(0)) < 2:
        raise Missing("two nodes need two cores")
    if not os.path.exists(os.path.join(build, "ranks")):
        raise Missing("the program ranks is not built")


def measure(given, cluster, start):
    program = [os.path.join(given.build, "ranks"), "--bodies", str(given.bodies),
               "--settle", str(given.settle), "--measure", str(given.measure)]
    if start:
        program += ["--from", start]
    best = {}

    def keep(key, row):
        if row and (key not in best or row["wall_ms_per_step_median"] <
                    best[key]["wall_ms_per_step_median"]):
            best[key] = row

    shaped = {}
    for turn in range(given.turns):
        for solver in SOLVERS:
            words = [*program, "--solver", solver]
            keep((solver, "one"), output_of(cluster.on(0, *words)))
            for name, delay, rate in LINKS:
                how = shaped[name] = cluster.shape(delay, rate)
                if turn == 0 and solver == SOLVERS[0]:
                    if how is None:
                        say(f"{name}: left out, the kernel has neither netem nor tbf")
                    elif how == "tbf":
                        say(f"{name}: the kernel has no netem, so this link has the rate only")
                if how:
                    keep((solver, name),
                         cluster.run([*words, "--cells-x", "2", "--cells-y", "1"]))
        say(f"turn {turn + 1} of {given.turns}")
    return [row_of(best[solver, name], best[solver, "one"], name, delay, rate, shaped[name])
            for solver in SOLVERS for name, delay, rate in LINKS
            if (solver, name) in best and (solver, "one") in best]


def row_of(row, one, name, delay, rate, how):
    """The exchange as measured, and as the model of docs/scaling.md has it: in each exchange the
    latency, and the bytes at the rate of the link, both as measured on the link itself."""
    latency = row["exchange_of_8_bytes_us"]
    bytes_per_us = (1 << 16) / max(1e-3, row["exchange_of_64_kib_us"] - latency)
    exchanges = row["messages_per_step_max"] / max(1, row["neighbours_max"])
    modelled = 1e-3 * (exchanges * latency + row["bytes_per_step_max"] / bytes_per_us)
    wall, alone = row["wall_ms_per_step_median"], one["wall_ms_per_step_median"]
    return {"label": name, "solver": row["solver"], "bodies": row["bodies"],
            "delay_us": delay if how == "netem" else 0,
            "rate_gbits": rate if how != "plain" else 0, "emulated_by": how,
            "wall_ms_per_step_median": wall, "one_wall_ms_per_step_median": alone,
            "efficiency": alone / wall / 2,
            "exchanges": exchanges, "bytes_per_step_max": row["bytes_per_step_max"],
            "latency_us": latency, "rate_gb_per_s": 1e-3 * bytes_per_us,
            "exchange_ms": 1e3 * row["exchange_seconds_mean"] / row["measure"],
            "modelled_exchange_ms": modelled,
            "modelled_efficiency": alone / (alone + 2 * modelled)}


def show(rows):
    print(f"{'link':18} {'solver':24} {'ms/step':>8} {'efficiency':>10} {'modelled':>8} "
          f"{'exchange ms':>11} {'modelled':>8} {'exchanges':>9} {'latency us':>10} {'GB/s':>6}")
    for r in rows:
        print(f"{r['label']:18} {r['solver']:24} {r['wall_ms_per_step_median']:8.2f} "
              f"{r['efficiency']:10.2f} {r['modelled_efficiency']:8.2f} {r['exchange_ms']:11.2f} "
              f"{r['modelled_exchange_ms']:8.2f} {r['exchanges']:9g} {r['latency_us']:10.1f} "
              f"{r['rate_gb_per_s']:6.2f}")


def main():
    options = argparse.ArgumentParser(usage=__doc__)
    options.add_argument("build")
    for name, default in (("bodies", 64000), ("settle", 30), ("measure", 30), ("turns", 3)):
        options.add_argument("--" + name, type=int, default=default)
    options.add_argument("--from", dest="start")
    options.add_argument("--quick", action="store_true")
    options.add_argument("--json", type=beside.file_for_rows, default="")
    given = options.parse_args()
    if given.quick:
        given.bodies, given.settle, given.measure, given.turns = 1000, 5, 5, 1
    os.environ["OMPI_ALLOW_RUN_AS_ROOT"] = os.environ["OMPI_ALLOW_RUN_AS_ROOT_CONFIRM"] = "1"
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        try:
            require_all(given.build)
            cluster = Cluster(folder)
        except Missing as what:
            say(f"nothing is measured: {what}")
        else:
            try:
                start = given.start
                if not start:
                    start = os.path.join(folder, "pile.bin")
                    say(f"a pile of {given.bodies:,} settles")
                    output_of([os.path.join(given.build, "ranks"), "--bodies", str(given.bodies),
                               "--settle", "60" if given.quick else "720", "--measure", "0",
                               "--iterations", "5", "--keep", start, "--solver", SOLVERS[1]])
                rows = measure(given, cluster, start)
            finally:
                cluster.close()
            show(rows)
    if given.json:
        beside.write_rows(rows, given.json, indent=1)


main()
