#!/usr/bin/env python3
"""The package talus reads what talus writes.  read.py ROOT MODULES   (MODULES: see drive.py)"""
import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

ROOT, MODULES = sys.argv.pop(1), sys.argv.pop(1)
sys.path[:0] = [str(pathlib.Path(ROOT) / "python"), MODULES]
import h5py
import numpy as np

import mechanism
import talus
from talus import checkpoint


class Read(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.work = pathlib.Path(tempfile.mkdtemp())
        cls.addClassCleanup(shutil.rmtree, cls.work)
        name = cls.work / "out"
        world = mechanism.World(steps=40, output=str(name), output_every=10, csv=str(name) + ".csv", csv_every=5,
                                json=str(name) + ".json", checkpoint=str(name) + ".h5")
        world.step(40)
        cls.spheres = {k: getattr(world.bodies["sphere"], k) for k in
                       ("ids", "positions", "velocities", "angular_velocities", "radii")}
        cls.box = {k: getattr(world.bodies["box"], k) for k in ("ids", "positions", "velocities", "orientations")}
        cls.body_table, cls.contact_table = world.body_table(), world.contact_table()
        world.write_body_table(f"{name}_bodies.csv")
        world.write_contact_table(f"{name}_contacts.csv")
        cls.contacts, cls.digest, cls.time = world.contacts, world.digest, world.time
        world.run()
        world.close()

    def file(self, end):
        return self.work / f"out{end}"

    def test_a_series_has_frames_with_the_arrays_of_the_world(self):
        series = talus.open(self.file(""))
        self.assertEqual([f.step for f in series], [0, 10, 20, 30, 40])
        self.assertTrue(np.allclose(series.times, [0, 0.1, 0.2, 0.3, 0.4]))
        self.assertEqual(series.at(0.24).step, 20)
        self.assertEqual([f.step for f in series[1:3]], [10, 20])
        last = series[-1]
        self.assertEqual((last.step, last.time, len(last)), (40, self.time, 4))
        order = np.argsort(self.spheres["ids"])
        ball = last.shapes == "sphere"
        self.assertEqual(ball.sum(), 3)
        self.assertTrue((last.ids[:-1] < last.ids[1:]).all())
        for name in self.spheres:
            self.assertTrue((getattr(last, name)[ball] == self.spheres[name][order]).all(), name)
        self.assertTrue((last.positions[~ball] == self.box["positions"]).all())
        self.assertTrue((last.orientations[~ball] == self.box["orientations"]).all())
        self.assertFalse(last.fixed.any())
        self.assertTrue((last.bodies["mass"] > 0).all())
        self.assertEqual(sorted(last.contacts["id_a"]), sorted(self.contacts["id_a"]))
        self.assertTrue(np.allclose(sorted(last.contacts["force"][:, 2]), sorted(self.contacts["force"][:, 2])))
        with self.assertRaisesRegex(KeyError, "has no colour; there are"):
            last.bodies["colour"]
        with self.assertRaises(IndexError):
            series[5]
        self.assertIn("5 frames", repr(series))

    def test_the_name_of_a_shape_may_have_two_words(self):
        path = self.work / "own_0000000040.hdf"
        shutil.copy(self.file("_0000000040.hdf"), path)
        with h5py.File(path, "r+") as file:
            names = np.frombuffer(b"round lens\nellipsoid\n", "u1")
            file.create_dataset("VTKHDF/FieldData/own_shapes", data=names)
            numbers = file["VTKHDF/PointData/shape"]
            numbers[...] = [6, 7, 6, 7]
        self.assertEqual(sorted(talus.open(path).shapes), ["ellipsoid", "ellipsoid", "round lens", "round lens"])

    def test_a_checkpoint_has_the_bodies_by_their_ids(self):
        state = talus.open(self.file(".h5"))
        self.assertEqual((state.step, state.time, state.ranks), (40, self.time, 1))
        order = np.argsort(self.spheres["ids"])
        for name in self.spheres:
            self.assertTrue((getattr(state.bodies["sphere"], name) == self.spheres[name][order]).all(), name)
        self.assertTrue((state.bodies["box"].orientations == self.box["orientations"]).all())
        self.assertEqual(state.bodies["box"]["shape"].shape, (1, 3))
        self.assertEqual(len(state.globals["plane"]["id"]), 1)
        self.assertIn("impulse", state.contacts)
        with self.assertRaisesRegex(AttributeError, "several shapes"):
            state.positions
        with self.assertRaisesRegex(AttributeError, "a box of this checkpoint has no radii"):
            state.bodies["box"].radii

    def test_results_and_time_series(self):
        results = talus.open(self.file(".json"))
        self.assertEqual((results["state_digest"], results["steps"], results["calls"]), (self.digest, 40, 40))
        table = talus.open(self.file(".csv"))
        self.assertEqual(table["step"].tolist(), list(range(0, 41, 5)))
        self.assertEqual(len(table), 9)
        self.assertIn("time", table)
        with self.assertRaisesRegex(KeyError, "has no column colour; it has step, time"):
            table["colour"]

    def test_tables_of_bodies_and_contacts(self):
        for end, made, ids in (("_bodies.csv", self.body_table, ("id",)), ("_contacts.csv", self.contact_table, ("id_a", "id_b"))):
            table = talus.open(self.file(end))
            self.assertEqual(list(table.keys()), list(made))
            self.assertGreater(len(table), 0)
            for name in table:
                self.assertEqual(table[name].dtype.kind, made[name].dtype.kind, name)
                self.assertTrue((table[name] == made[name]).all(), name)
            for name in ids:
                self.assertEqual(table[name].dtype, np.uint64)
        text = self.file("_bodies.csv").read_text()
        (self.work / "wrong_bodies.csv").write_text(text.replace("sphere,", "sphere,x", 1))
        with self.assertRaisesRegex(talus.Error, "position_x has a cell that is no number"):
            talus.open(self.work / "wrong_bodies.csv")

    def test_the_script_of_the_documentation_runs(self):
        told = subprocess.run([sys.executable, "-B", f"{ROOT}/docs/reading.py", self.file("")], check=True, text=True,
                              capture_output=True, env={**os.environ, "PYTHONPATH": f"{ROOT}/python"}).stdout
        self.assertIn("5 frames; in the last one 4 bodies around [", told)
        self.assertIn("step 40 has 3 spheres of radius 0.5\n", told)

    def test_a_line_that_is_not_complete_is_left_out(self):
        text = self.file(".csv").read_text()
        path = self.work / "cut.csv"
        path.write_text(text[:text.rstrip().rindex(",")])
        self.assertEqual(len(talus.open(path)), 8)
        path.write_text(text.rstrip()[:-1])  # all cells are there, but not all digits of the last one
        self.assertEqual(len(talus.open(path)), 8)

    def forged(self, name, change):
        """A checkpoint that somebody has changed, and has given the checksum of its first block."""
        sent = self.work / name
        shutil.copy(self.file(".h5"), sent)
        with h5py.File(sent, "r+") as file:
            change(file)
        block = bytearray(sent.read_bytes()[:struct.unpack_from("<I", sent.read_bytes(), 36)[0]])
        struct.pack_into("<Q", block, 40, sent.stat().st_size)
        struct.pack_into("<Q", block, len(block) - 8, checkpoint.checksum(bytes(block[:-8])))
        with open(sent, "r+b") as file:
            file.write(block)
        return sent

    def test_columns_of_a_checkpoint_have_their_forms(self):
        rows = {"sphere": 3, "box": 1}

        def put(name, values):
            def change(file):
                del file[name]
                file[name] = values
            return change

        for name, values, words in [
                ("bodies/box/shape", np.zeros((1, 2)), "box/shape"), ("bodies/box/shape", np.zeros((1, 0)), "box/shape"),
                ("bodies/box/shape", np.zeros(1), "box/shape"), ("bodies/sphere/shape", np.zeros((3, 0)), "sphere/shape"),
                ("shapes/box", np.frombuffer(b"a\nb\nc\nd\n", "u1"), "box/shape"),
                ("bodies/sphere/position", np.zeros(3), "sphere/position"), ("bodies/sphere/velocity", np.zeros((3, 3), int), "sphere/velocity"),
                ("bodies/box/orientation", np.zeros((1, 1)), "box/orientation"), ("bodies/box/material", np.zeros(1), "box/material")]:
            with self.subTest(name=name, shape=values.shape), self.assertRaisesRegex(talus.Error, f"forms.h5 is damaged: bodies/{words} has "):
                state = talus.open(self.forged("forms.h5", put(name, values)))
                for shape, bodies in state.bodies.items():
                    self.assertEqual(len(bodies), rows[shape])
                    for word in (*bodies.WORDS, *bodies.numbers):
                        getattr(bodies, word, None)

    def test_a_table_that_names_a_column_twice_is_refused(self):
        (self.work / "twice.csv").write_text("step [1],a [m],a [s],b\n1,2,3,4\n")
        with self.assertRaisesRegex(talus.Error, "twice.csv is damaged: its head names a twice"):
            talus.open(self.work / "twice.csv")

    def test_wrong_and_truncated_files_are_refused_in_words(self):
        def refused(path, words):
            with self.assertRaises(talus.Error, msg=str(path)) as told:
                found = talus.open(path)
                [f.positions for f in found] if isinstance(found, talus.Series) else found.positions
            self.assertIn(words, str(told.exception))
            self.assertIn(str(path), str(told.exception))

        def cut(end, part, name):
            data = self.file(end).read_bytes()
            path = self.work / name
            path.write_bytes(data[:int(len(data) * part)])
            return path

        refused(self.work / "none.hdf", "does not exist")
        refused(self.work, "is a folder")
        refused(cut(".h5", 0.7, "cut.h5"), "is truncated: it has")
        data = self.file(".h5").read_bytes()
        (self.work / "damaged.h5").write_bytes(data[:4096] + b"x" * (len(data) - 4096))
        refused(self.work / "damaged.h5", "damaged")
        refused(cut(".h5", 100 / self.file(".h5").stat().st_size, "cut2.h5"), "it ends within its first block")
        refused(cut("_0000000040.hdf", 0.7, "cut_0000000040.hdf"), "is truncated")
        refused(cut(".json", 0.7, "cut.json"), "is truncated: it is no JSON")
        refused(cut(".hdf.series", 0.7, "cut.hdf.series"), "is truncated: it is no JSON")
        refused(cut(".h5", 0, "empty.h5"), "is empty")
        os.mkfifo(self.work / "pipe.h5")
        refused(self.work / "pipe.h5", "is a device, a pipe or a socket")
        odd = self.work / "notes.txt"
        odd.write_text("a thesis")
        refused(odd, "is nothing that talus writes")
        wrong = bytearray(self.file(".h5").read_bytes())
        wrong[60] ^= 1
        (self.work / "wrong.h5").write_bytes(wrong)
        refused(self.work / "wrong.h5", "the checksum of its first block is wrong")

        def lead_away(file):
            del file["bodies/sphere/position"]
            file["bodies/sphere"].create_dataset("position", (3, 3), "f8", external=[(str(self.file(".csv")), 0, 72)])
        sent = self.forged("sent.h5", lead_away)
        with self.assertRaisesRegex(talus.Error, "sent.h5: bodies/sphere/position is virtual, lies in another file"):
            talus.open(sent).bodies["sphere"].positions
        (self.work / "list.json").write_text('{"ended_early": "exit(3) on rank 0"}')
        refused(self.work / "list.json", "of a run that ended early: exit(3)")
        shutil.copy(self.file("_contacts_0000000040.hdf"), self.work / "lines_0000000040.hdf")
        refused(self.work / "lines_0000000040.hdf", "with bodies")
        index = {"files": [{"name": "gone_0000000001.hdf", "time": 1}]}
        (self.work / "gone.hdf.series").write_text(json.dumps(index))
        with self.assertRaisesRegex(talus.Error, "gone_0000000001.hdf does not exist"):
            talus.open(self.work / "gone.hdf.series")[0]
        index["files"] *= 300000
        (self.work / "many.hdf.series").write_text(json.dumps(index))
        with self.assertRaisesRegex(talus.Error, "it lists 'gone_0000000001.hdf' 300000 times"):
            talus.open(self.work / "many.hdf.series")


if __name__ == "__main__":
    unittest.main()
