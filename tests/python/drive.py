#!/usr/bin/env python3
"""Python drives compiled scenes.  drive.py MODULES DROP_PROGRAM
  MODULES       folder of the modules drop (from examples/drop/drop.cpp) and mechanism
  DROP_PROGRAM  the example drop"""
import gc
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

MODULES, PROGRAM = sys.argv.pop(1), sys.argv.pop(1)
sys.path.insert(0, MODULES)
import numpy as np

import drop
import mechanism


class Worlds(unittest.TestCase):
    def setUp(self):
        made = tempfile.TemporaryDirectory()
        self.addCleanup(made.cleanup)
        self.work = pathlib.Path(made.name)

    def test_the_scene_has_the_digest_of_its_program(self):
        for options in ({"steps": 300}, {"steps": 120, "iterations": 4, "seed": 7, "dt": 0.004}):
            words = [f"--{name}={value}" for name, value in options.items()]
            subprocess.run([PROGRAM, *words, "--ranks", "1", "--quiet", "--json", "drop.json"], check=True,
                           cwd=self.work)
            said = json.loads((self.work / "drop.json").read_text())
            world = drop.World(**options)
            while world.steps < options["steps"]:
                world.step(50)
            self.assertEqual(world.digest, said["state_digest"])
            mine = world.results()
            for name in ("bodies", "contacts", "kinetic_energy", "penetration_max", "residual", "transport"):
                self.assertEqual(mine[name], said[name], name)
            self.assertEqual(world.kinetic_energy, said["kinetic_energy"])

    def test_events_are_those_of_each_step(self):
        world = mechanism.World(steps=600)
        reported = []
        while world.steps < 250:
            world.step()
            events = world.event_table()
            reported += zip(events["kind"].tolist(), events["id_a"].tolist(), events["id_b"].tolist())
            for k, kind in enumerate(events["kind"]):
                if kind == "impact":
                    self.assertGreaterEqual(events["speed"][k], 2)
        kinds = [kind for kind, _, _ in reported]
        self.assertEqual(kinds.count("impact"), 2)  # the first sphere lies on the ground
        touching = set()
        for kind, a, b in reported:
            if kind == "contact_begins":
                self.assertNotIn((a, b), touching)
                touching.add((a, b))
            elif kind == "contact_ends":
                touching.remove((a, b))
        contacts = world.contact_table()
        self.assertEqual({tuple(sorted(pair)) for pair in zip(contacts["id_a"].tolist(), contacts["id_b"].tolist())},
                         touching)

    def test_tables_have_columns_of_one_dimension(self):
        world = mechanism.World(steps=600)
        empty = world.contact_table()
        self.assertEqual({len(column) for column in empty.values()}, {0})
        self.assertEqual((empty["id_a"].dtype, empty["shape_a"].dtype.kind, empty["gap"].dtype),
                         (np.uint64, "U", np.float64))
        for steps in (15, 285):  # while the spheres fall, and at rest
            world.step(steps)
            bodies, contacts = world.body_table(), world.contact_table()
            self.assertEqual({(c.ndim, len(c)) for c in bodies.values()}, {(1, 5)})
            self.assertEqual(sorted(bodies["shape"]), ["box", "plane", "sphere", "sphere", "sphere"])
            self.assertTrue((bodies["id"][:-1] < bodies["id"][1:]).all())
            self.assertEqual((bodies["global"] == 1).tolist(), (bodies["shape"] == "plane").tolist())
            spheres = world.bodies["sphere"]
            row = {i: k for k, i in enumerate(bodies["id"])}
            for k, i in enumerate(spheres.ids):
                there = [bodies[f"position_{axis}"][row[i]] for axis in "xyz"]
                self.assertEqual(there, spheres.positions[k].tolist())
            self.assertEqual({len(c) for c in contacts.values()}, {len(world.contacts["gap"])})
            force, torque = world.contact_forces(list(bodies["id"]) + [2**60])
            self.assertEqual((force.shape, torque.shape), ((6, 3), (6, 3)))
            self.assertTrue((force[5] == 0).all())
            self.assertLess(np.abs(force.sum(axis=0)).max(), 1e-9)
            for axis, name in enumerate(("force_x", "force_y", "force_z")):
                total = np.zeros(5)
                np.add.at(total, [row[i] for i in contacts["id_a"]], contacts[name])
                np.add.at(total, [row[i] for i in contacts["id_b"]], -contacts[name])
                self.assertTrue(np.allclose(total, force[:5, axis]))
        ball = bodies["shape"] == "sphere"
        self.assertTrue(np.allclose(force[:5][ball][:, 2], 10 * bodies["mass"][ball], rtol=1e-3))
        (self.work / "letter.csv").write_text("a letter\n")
        with self.assertRaisesRegex(RuntimeError, "is not a table of bodies or contacts"):
            world.write_body_table(str(self.work / "letter.csv"))
        try:
            import pandas
        except ImportError:
            return
        self.assertEqual(len(pandas.DataFrame(bodies)), 5)

    def test_columns_are_views_of_the_bodies(self):
        world = drop.World()
        self.assertEqual((world.steps, world.time), (0, 0.0))
        self.assertEqual(world.positions.shape, (729, 3))
        self.assertEqual(world.velocities.dtype, np.float64)
        self.assertTrue(((0.3 <= world.radii) & (world.radii <= 0.5)).all())
        self.assertEqual(len(set(world.ids)), 729)
        self.assertFalse(world.positions.flags.owndata)
        one, two = world.positions, world.positions
        self.assertTrue(np.shares_memory(one, two))
        with self.assertRaises(ValueError):
            one[0, 0] = 1
        energy = world.step(10) and world.kinetic_energy
        mass = 2.8 * 4 / 3 * np.pi * world.radii**3
        spin = 0.4 * mass * world.radii**2 * (world.angular_velocities**2).sum(axis=1)
        self.assertAlmostEqual(energy, 0.5 * (mass * (world.velocities**2).sum(axis=1) + spin).sum())

    def test_a_view_that_is_kept_shows_the_state_in_which_it_was_taken(self):
        world = drop.World(steps=600)
        before = world.positions
        copied, part, ids = before.copy(), before[10:20, 2], world.ids
        again = world.positions
        world.step(300)  # bodies are sorted in between
        self.assertTrue((before == copied).all())
        self.assertTrue((again == copied).all())
        after = world.positions
        self.assertFalse((after == copied).all(axis=1).any())
        self.assertFalse(np.shares_memory(before, after))
        del before, again
        gc.collect()
        self.assertTrue((part == copied[10:20, 2]).all())
        moved = dict(zip(world.ids, after))
        self.assertTrue(all(moved[i][2] < z for i, z in zip(ids[10:20], part)))
        del world
        gc.collect()
        self.assertTrue((part == copied[10:20, 2]).all())
        self.assertTrue(np.isfinite(after).all())

    def test_a_step_copies_nothing_where_no_view_is_kept(self):
        world = drop.World()
        place = world.positions.__array_interface__["data"][0]
        world.step(3)
        self.assertEqual(world.positions.__array_interface__["data"][0], place)
        kept = world.positions
        world.step(1)
        self.assertEqual(kept.__array_interface__["data"][0], place)
        self.assertNotEqual(world.positions.__array_interface__["data"][0], place)

    def test_views_do_not_change_the_trajectory(self):
        one, other = drop.World(steps=300), drop.World(steps=300)
        kept = []
        for _ in range(30):
            kept += [one.positions, one.velocities, one.radii, one.ids]
            one.step(10)
        other.step(300)
        self.assertEqual(one.digest, other.digest)

    def test_contacts_carry_the_weight(self):
        world = drop.World(steps=600)
        world.step(600)
        contacts = world.contacts
        self.assertEqual(set(contacts), {"id_a", "id_b", "point", "normal", "force", "gap"})
        n = len(contacts["id_a"])
        self.assertEqual(contacts["force"].shape, (n, 3))
        self.assertTrue(np.allclose(np.linalg.norm(contacts["normal"], axis=1), 1))
        floor = np.abs(contacts["normal"][:, 2]) > 0.999
        on_floor = floor & ~np.isin(contacts["id_b"], world.ids)
        weight = 9.81 * 2.8 * 4 / 3 * np.pi * (world.radii**3).sum()
        self.assertAlmostEqual(contacts["force"][on_floor, 2].sum() / weight, 1, delta=0.1)

    def test_several_shapes_are_named(self):
        world = mechanism.World()
        self.assertEqual(list(world.bodies), ["sphere", "box"])
        self.assertEqual(len(world.bodies["sphere"]), 3)
        self.assertEqual(world.bodies["box"].positions.tolist(), [[0, 0, 8]])
        self.assertEqual(world.bodies["box"].orientations.tolist(), [[0, 0, 0, 1]])
        with self.assertRaisesRegex(AttributeError, r"several shapes \(sphere, box\): write world.bodies"):
            world.positions
        with self.assertRaisesRegex(AttributeError, "a box has no radii"):
            world.bodies["box"].radii
        with self.assertRaisesRegex(AttributeError, "a sphere has no orientations: name features"):
            drop.World().orientations

    def test_a_motor_is_set(self):
        world = mechanism.World(speed=2)
        (joint,) = world.joints
        self.assertEqual(joint.kind, "hinge")
        self.assertEqual(joint.id_b, world.bodies["box"].ids[0])
        world.step(10)
        self.assertAlmostEqual(world.bodies["box"].angular_velocities[0, 1], 2, places=6)
        joint.set_motor(velocity=-3, largest_torque=1000)
        world.step(2)
        self.assertAlmostEqual(world.bodies["box"].angular_velocities[0, 1], -3, places=6)
        self.assertGreater(joint.angle, 0)
        self.assertEqual(joint.force.shape, (3,))
        with self.assertRaisesRegex(AttributeError, "a hinge has no travel"):
            joint.travel
        with self.assertRaisesRegex(TypeError, "set_motor has no argument torque: it takes velocity, largest_torque"):
            joint.set_motor(torque=1)
        with self.assertRaises(ValueError):
            joint.set_motor(velocity=float("nan"), largest_torque=1)
        joint.release()
        self.assertEqual(world.joints, [])

    def test_the_set_up_goes_on_where_its_simulations_end(self):
        world = mechanism.World(steps=30)
        self.assertEqual(world.gravity, (0, 0, -10))
        self.assertEqual(world.step(16), 16)  # across the end of the first simulate
        self.assertEqual(world.gravity, (0, 0, -5))
        self.assertFalse(world.finished)
        self.assertEqual(world.step(100), 14)
        self.assertTrue(world.finished)
        self.assertEqual(world.results()["calls"], 30)
        self.assertEqual(world.results()["steps"], 30)
        with self.assertRaisesRegex(RuntimeError, r"the set-up has ended after 30 steps.*World\(steps=60\)"):
            world.step()
        self.assertEqual(mechanism.World(steps=30).run(), 30)

    def test_a_loop_over_steps_ends_with_the_set_up(self):
        world, steps = mechanism.World(steps=30), 0
        while not world.finished:
            steps += world.step()
        self.assertEqual((steps, world.steps), (30, 30))
        self.assertEqual(world.results()["calls"], 30)

    def test_a_world_without_steps_to_make_is_finished(self):
        file = str(self.work / "complete.h5")
        drop.World(steps=20, checkpoint=file).run()
        for world in (drop.World(steps=0), mechanism.World(steps=0), drop.World(steps=20, restart=file)):
            self.assertTrue(world.finished)
            while not world.finished:
                world.step()
            self.assertEqual(world.run(), 0)
            with self.assertRaisesRegex(RuntimeError, f"the set-up has ended after {world.steps} steps"):
                world.step()
        world = mechanism.World(steps=1)  # its first simulate makes no step
        self.assertFalse(world.finished)
        self.assertEqual((world.step(), world.finished), (1, True))

    def test_threads_may_work_with_worlds_while_python_ends(self):
        for work in ("while True: w.step(20)", "w.run()", "while True: drop.World(steps=10)"):
            for wait in ("0", "0.01", "0.1"):
                script = (f"import sys, threading, time; sys.path.insert(0, {MODULES!r})\n"
                          "import drop\nw = drop.World(steps=1000000)\nother = drop.World()\n"
                          "w.observe(7, lambda w: w.steps)\n"
                          f"def work():\n    {work}\n"
                          f"threading.Thread(target=work, daemon=True).start()\ntime.sleep({wait})\n")
                run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60)
                self.assertEqual(run.returncode, 0, run.stderr)
                # Python may stop the thread while that prints its exception.
                for error in re.findall(r"^\w*Error: .*", run.stderr, re.M):
                    self.assertTrue(error.startswith("RuntimeError: Python ends") or
                                    "RuntimeError: Python ends".startswith(error), run.stderr)

    def test_python_ends_where_an_observer_of_another_thread_does_not(self):
        for work in ("while True: pass", "time.sleep(1000)"):
            began = time.monotonic()
            run = subprocess.run([sys.executable, "-c", f"import sys, threading, time; sys.path.insert(0, {MODULES!r})\n"
                                  f"import drop\nw = drop.World(steps=1000000)\ndef f(w):\n    {work}\n"
                                  "w.observe(1, f)\nthreading.Thread(target=w.run, daemon=True).start()\ntime.sleep(0.2)\n"],
                                 capture_output=True, text=True, timeout=60)
            self.assertEqual((run.returncode, run.stderr), (0, ""), work)
            self.assertLess(time.monotonic() - began, 20)

    def test_threads_may_take_their_first_arrays_at_once(self):
        script = (f"import sys, threading; sys.path.insert(0, {MODULES!r})\nimport drop\n"
                  "worlds = [drop.World() for _ in range(4)]\n"
                  "threads = [threading.Thread(target=lambda w=w: w.positions.sum()) for w in worlds]\n"
                  "for t in threads: t.start()\nfor t in threads: t.join()\n")
        told = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60)
        self.assertEqual((told.returncode, told.stderr), (0, ""))

    def test_a_signal_writes_the_checkpoint_of_a_world(self):
        for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGINT):
            file = self.work / f"{number}.h5"
            world = drop.World(steps=1000000000, checkpoint=file)
            threading.Timer(0.2, lambda: os.kill(os.getpid(), signal.SIGUSR1)).start()
            threading.Timer(0.6, lambda: os.kill(os.getpid(), number)).start()
            with self.assertRaisesRegex(RuntimeError, f"ended by signal {int(number)}; its checkpoint is"):
                world.run()
            self.assertTrue(file.exists())

    def test_bodies_are_added_changed_and_removed(self):
        world = mechanism.World(steps=60)
        world.step(3)
        spheres, before = world.bodies["sphere"], world.bodies["sphere"].positions
        new = spheres.add(0.25, position=(0, -5, 3), velocity=(1, 0, 0))
        self.assertEqual(len(spheres), 4)
        self.assertEqual(before.shape, (3, 3))
        row = list(spheres.ids).index(new)
        self.assertEqual(spheres.radii[row], 0.25)
        world.step(10)
        row = list(spheres.ids).index(new)
        self.assertAlmostEqual(spheres.positions[row, 0], 0.1)
        spheres.set_velocity(new, (0, 2, 0))
        self.assertEqual(spheres.velocities[row].tolist(), [0, 2, 0])
        crate = world.bodies["box"].add(1, 2, 3, position=(0, -9, 4), mass=7)
        table = world.body_table()
        self.assertEqual(table["mass"][table["id"].tolist().index(crate)], 7)
        world.step(1)
        world.bodies["box"].remove(crate)
        spheres.remove(new)
        self.assertEqual((len(spheres), len(world.bodies["box"])), (3, 1))
        self.assertEqual(world.run(), 46)  # and the audit finds all bodies
        for add, words in [(lambda: spheres.add(position=(0, 0, 9)), "a sphere is given by radius: add takes 1 numbers"),
                           (lambda: spheres.add(-1, position=(0, 0, 9)), "radius"),
                           (lambda: spheres.add(1, position=(0, 0, float("nan"))), "position"),
                           (lambda: spheres.add(1, position=(0, 0, 9), material=7), "material"),
                           (lambda: spheres.add(1, position=(0, 0, 9), mass=0), "the mass of a sphere .* is 0"),
                           (lambda: spheres.add(1, position=(0, 0, 9), mass=2, density=3), "leave one of the two out"),
                           (lambda: spheres.remove(new), "sphere"),
                           (lambda: spheres.set_velocity(new, (0, 0, 0)), "does not know the sphere")]:
            with self.assertRaisesRegex(ValueError, words):
                add()

    def test_what_is_no_number_is_refused(self):
        spheres = mechanism.World(steps=60).bodies["sphere"]
        for call in (spheres.add, spheres.find_overlaps):
            with self.assertRaisesRegex(TypeError, "a shape is given by numbers"):
                call("wide", position=(0, 0, 9))
        with self.assertRaisesRegex(TypeError, "an orientation needs four numbers"):
            spheres.find_overlaps(1, position=(0, 0, 9), orientation="up")

    def test_what_was_made_without_its_init_is_refused(self):
        for kind in (drop.World, drop.Bodies, mechanism.World, mechanism.Bodies, mechanism.Joint):
            empty = kind.__new__(kind)
            names = [n for n in vars(kind) if not n.startswith("__") or n == "__len__"]
            self.assertGreater(len(names), 5)
            for name in names:
                with self.subTest(kind=kind, name=name), self.assertRaisesRegex(TypeError, "without its __init__|incompatible function arguments"):
                    found = getattr(empty, name)
                    found()
        with self.assertRaisesRegex(TypeError, "World was made without its __init__"):
            drop.World.__new__(drop.World).step()

    def test_bodies_are_found_by_rays_points_and_regions(self):
        world = mechanism.World()
        spheres = world.bodies["sphere"]
        ball = spheres.add(0.5, position=(50, 0, 3))
        rays = world.cast_rays([(50, 0, 9), (50, 4, 9), (54, 0, 3)], [(0, 0, -1), (0, 0, 1), (-2, 0, 0)])
        self.assertEqual(rays["found"].tolist(), [True, False, True])
        self.assertEqual(rays["id"].tolist(), [ball, 0, ball])
        self.assertTrue(np.allclose(rays["distance"], [5.5, np.inf, 3.5]))
        self.assertTrue(np.allclose(rays["normal"], [(0, 0, 1), (0, 0, 0), (1, 0, 0)]))
        self.assertTrue(np.allclose(rays["point"][2], (50.5, 0, 3)))
        self.assertFalse(world.cast_rays([(50, 0, 9)], [(0, 0, -1)], length=5)["found"][0])
        near = world.nearest_bodies([(50, 2, 3), (50, 0, 3.1)], within=2)
        self.assertEqual(near["id"].tolist(), [ball, ball])
        self.assertTrue(np.allclose(near["distance"], [1.5, 0]))
        self.assertEqual(world.bodies_within((49, -1, 2), (51, 1, 4)).tolist(), [ball])
        self.assertEqual(spheres.find_overlaps(1, position=(50, 1.4, 3)).tolist(), [ball])
        self.assertEqual(spheres.find_overlaps(1, position=(50, 1.6, 3)).tolist(), [])
        for ask, words in [(lambda: world.cast_rays([(0, 0, 1)], [(0, 0, 0)]), "direction"),
                           (lambda: world.cast_rays([(0, 0, 1)], []), "rows of three numbers"),
                           (lambda: world.cast_rays([(0, 0, 1)], [(0, 0, 1)] * 2), "1 origins and 2 directions"),
                           (lambda: world.nearest_bodies([(0, 0)]), "rows of three numbers"),
                           (lambda: world.nearest_bodies([(0, 0, 1)], within=-1), "distance of 0 or more"),
                           (lambda: spheres.find_overlaps(1, 2, position=(0, 0, 1)), "is given by radius")]:
            with self.assertRaisesRegex(ValueError, words):
                ask()

    def test_gravity_is_set(self):
        world = mechanism.World()
        world.gravity = (0, 0, 0)
        world.step(10)
        self.assertEqual(world.bodies["sphere"].velocities.tolist()[2], [0, 0, 0])
        with self.assertRaises(ValueError):
            world.gravity = (0, 0, float("inf"))

    def test_options_are_those_of_the_program(self):
        with self.assertRaisesRegex(ValueError, "'--iteratoins=5' is not an option.*did you mean --iterations"):
            drop.World(iteratoins=5)
        with self.assertRaisesRegex(ValueError, "--iterations must be at least 1, but is 0"):
            drop.World(iterations=0)
        with self.assertRaisesRegex(ValueError, "4 ranks are asked for, but Python drives worlds of one rank"):
            drop.World(ranks=4)
        with self.assertRaisesRegex(ValueError, r'json needs a text without zero bytes, but is "a.u0000b"'):
            drop.World(json="a\0b")
        with self.assertRaisesRegex(TypeError, "an option is given a text that is no Unicode"):
            drop.World(json="\ud800")
        world = drop.World()
        for write in (world.write_checkpoint, world.write_body_table, world.write_contact_table):
            for name in ("", str(self.work / "a\0b")):
                with self.assertRaisesRegex(ValueError, f"{write.__name__} needs the name of a file, but is given"):
                    write(name)
        self.assertEqual(list(self.work.iterdir()), [])
        self.assertEqual(drop.World(reproducible=True, csv=None).step(2), 2)
        self.assertIn("--iterations", drop.World.__doc__)
        with self.assertRaisesRegex(ValueError, "the bar has its own mass"):
            mechanism.World(bar_mass=2)

    def test_a_pipe_is_refused_as_python_could_not_end_the_wait_for_its_reader(self):
        pipe = str(self.work / "pipe")
        os.mkfifo(pipe)
        for option in ("csv", "json", "log", "config"):
            with self.assertRaisesRegex(ValueError, f"{option} names the pipe .*: name a file"):
                drop.World(**{option: pipe})
        world = drop.World()
        for write in (world.write_checkpoint, world.write_body_table, world.write_contact_table):
            with self.assertRaisesRegex(ValueError, f"{write.__name__} names the pipe .*: name a file"):
                write(pipe)

    def test_an_option_is_no_bytes(self):
        for name in (b"t.csv", bytearray(b"t.csv")):
            with self.assertRaisesRegex(TypeError, "csv needs a text, but is given bytes"):
                drop.World(csv=name)

    def test_exceptions_of_the_scene_arrive(self):
        with self.assertRaisesRegex(ValueError, "the set-up has no wood"):
            mechanism.World(fail_first=True)
        world = mechanism.World(fail_at=5)
        kept = world.bodies["sphere"].positions
        with self.assertRaisesRegex(RuntimeError, "the bar broke in step 5"):
            world.step(10)
        self.assertEqual(kept[2, 2], 2.5)
        with self.assertRaisesRegex(RuntimeError, "was ended by an error: the bar broke in step 5"):
            world.step(1)
        with self.assertRaisesRegex(RuntimeError, "was ended by an error"):
            world.time

    def test_observers_are_called_between_steps(self):
        world, seen = drop.World(), []
        world.observe(10, lambda w: seen.append((w.steps, w.positions[:, 2].mean())))
        self.assertEqual(world.step(35), 35)
        self.assertEqual([s for s, _ in seen], [10, 20, 30])
        self.assertTrue(seen[0][1] > seen[1][1] > seen[2][1])

        def fail(w):
            raise KeyError(w.steps)
        world.observe(7, fail)
        with self.assertRaises(KeyError):
            world.step(100)
        self.assertEqual(world.steps, 42)
        with self.assertRaises(ValueError):
            world.observe(0, fail)
        again = drop.World()
        again.observe(1, lambda w: w.step(1))
        with self.assertRaisesRegex(RuntimeError, "it may only look"):
            again.step(1)
        more = drop.World()
        more.observe(1, lambda w: w.observe(1, fail))
        with self.assertRaisesRegex(RuntimeError, "an observer added an observer"):
            more.step(1)

    def test_worlds_are_independent_and_close(self):
        one, other = drop.World(seed=1), drop.World(seed=2)
        one.step(5)
        self.assertEqual((one.steps, other.steps), (5, 0))
        self.assertNotEqual(one.digest, other.digest)
        kept = one.positions
        copied = kept.copy()
        one.close()
        one.close()
        self.assertTrue((kept == copied).all())
        with self.assertRaisesRegex(RuntimeError, "this world was closed"):
            one.step(1)
        with drop.World() as third:
            third.step(1)
        with self.assertRaisesRegex(RuntimeError, "this world was closed"):
            third.steps

    def test_other_threads_run_during_steps_and_are_refused_the_same_world(self):
        world, counted, refused = drop.World(), [], []

        def count():
            while not done.is_set():
                counted.append(1)
                try:
                    world.step(1)
                except RuntimeError as e:
                    refused.append(str(e))
                done.wait(0.001)
        done = threading.Event()
        busy = threading.Thread(target=lambda: (world.step(400), done.set()))
        other = threading.Thread(target=count)
        busy.start()
        other.start()
        busy.join()
        other.join()
        self.assertGreater(len(counted), 3)
        self.assertTrue(any("another thread works with this world" in r for r in refused), refused[:3])

    def test_an_interrupt_ends_a_step_and_leaves_the_world_whole(self):
        world = drop.World(steps=1000000)
        threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        with self.assertRaises(KeyboardInterrupt):
            world.step(1000000)
        there = world.steps
        self.assertTrue(0 < there < 1000000)
        world.step(1)
        self.assertEqual(world.steps, there + 1)

    def test_a_checkpoint_continues(self):
        first = drop.World(steps=60)
        first.step(30)
        first.write_checkpoint(str(self.work / "half.h5"))
        first.step(30)
        second = drop.World(steps=60, restart=str(self.work / "half.h5"))
        self.assertEqual(second.steps, 30)
        second.step(30)
        self.assertEqual(second.digest, first.digest)
        with self.assertRaisesRegex(RuntimeError, "nowhere.h5"):
            drop.World(restart="nowhere.h5")

    def test_a_fork_is_refused_the_world_and_ends(self):
        world = drop.World()
        world.step(1)
        child = os.fork()
        if child == 0:
            try:
                world.step(1)
            except RuntimeError as e:
                os._exit(7 if "a fork cannot use it" in str(e) else 8)
            os._exit(9)
        self.assertEqual(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), 7)
        child = os.fork()
        if child == 0:
            world.close()
            os._exit(5)
        self.assertEqual(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), 5)
        self.assertEqual(world.step(1), 1)

    def test_a_fork_ends_as_usual_while_worlds_are_open(self):
        for end in ("sys.exit(6)", "del world; sys.exit(6)", "world = None; drop.World().step(1); sys.exit(6)",
                    "own = drop.World(); own.step(1); del world; own.step(1); del own; sys.exit(6)"):
            told = subprocess.run([sys.executable, "-c", f"import os, sys; sys.path.insert(0, {MODULES!r})\n"
                                   "import drop\nworld = drop.World()\nworld.step(3)\nchild = os.fork()\n"
                                   f"if child == 0: {end}\n"
                                   "print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), world.step(1))\n"],
                                  capture_output=True, text=True, timeout=60)
            self.assertEqual((told.returncode, told.stdout, told.stderr), (0, "6 1\n", ""), end)

    def test_a_fork_ends_while_a_thread_of_its_parent_makes_steps(self):
        told = subprocess.run([sys.executable, "-c", f"import os, signal, sys, threading, time; sys.path.insert(0, {MODULES!r})\n"
                               "import drop\nworld = drop.World(steps=1000000)\n"
                               "threading.Thread(target=world.run, daemon=True).start()\ntime.sleep(0.2)\nchild = os.fork()\n"
                               "if child == 0:\n"
                               "    signal.alarm(15)\n"
                               "    try: world.step()\n"
                               "    except RuntimeError as e: print(e, flush=True)\n"
                               "    own = drop.World(steps=3)\n"
                               "    sys.exit(own.run())\n"
                               "print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)\nos._exit(0)\n"],
                              capture_output=True, text=True, timeout=20)
        self.assertEqual((told.returncode, told.stderr), (0, ""))
        self.assertRegex(told.stdout, "a fork cannot use it.*\n3\n$")

    def test_python_ends_without_a_word_while_worlds_are_open(self):
        told = subprocess.run([sys.executable, "-c", f"import sys; sys.path.insert(0, {MODULES!r})\n"
                               "import drop\nworld = drop.World()\nworld.step(3)\nkept = world.positions\n"
                               "world.observe(1, lambda w: world)\n"], capture_output=True, text=True, timeout=60)
        self.assertEqual((told.returncode, told.stdout, told.stderr), (0, "", ""))


if __name__ == "__main__":
    unittest.main()
