#!/usr/bin/env python3
"""Outputs that somebody has sent, damaged or made to harm: the package talus, ./dev view and its server refuse them in words.

  foreign.py     ends with 77 without h5py"""
import fcntl
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.request

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "python"))
try:
    import h5py
    import numpy as np
except ImportError:
    print("skipped: no h5py")
    sys.exit(77)
import talus
from sent_output import BODIES, CONTACTS, COUNT, SURFACES, VIEW, Server, with_array, write_index, write_output

SECRET = b"the diary of the reader, which belongs to nobody else " * 20


def read_all(path):
    for frame in talus.open(path):
        for columns in (frame.bodies, frame.contacts):
            for name in columns:
                columns[name]
        frame.positions, frame.shapes, frame.fixed, frame.orientations, repr(frame)


def has_files_without_names(folder):
    try:
        os.close(os.open(folder, os.O_TMPFILE | os.O_RDWR))
        return True
    except OSError:
        return False


class Foreign(unittest.TestCase):
    def setUp(self):
        made = tempfile.TemporaryDirectory()
        self.addCleanup(made.cleanup)
        self.outer = pathlib.Path(made.name)
        self.folder = self.outer / "sent"
        self.folder.mkdir()
        (self.folder / "three.js").write_text("THREE")
        (self.outer / "secret").write_bytes(SECRET)
        write_output(self.folder)
        self.server = Server(self.folder)
        self.addCleanup(self.server.end)

    def view(self, *words, code=None, **more):
        told = subprocess.run([*VIEW, str(self.folder / "o"), *words], capture_output=True, text=True, timeout=20,
                              env={**os.environ, "TALUS_THREE": str(self.folder / "three.js")}, **more)
        self.assertNotIn("Traceback", told.stderr)
        if code is not None:
            self.assertEqual(told.returncode, code, told.stderr)
        return told

    def refused(self, words, reader=True):
        """All three of them say so, and go on where they serve."""
        if reader:
            with self.assertRaises(talus.Error, msg=words) as told:
                read_all(self.folder / "o")
            self.assertIn(words, str(told.exception))
        self.assertIn(words, self.view(code=1).stderr)
        self.assertEqual([p.name for p in self.folder.glob("*.html*")], [])
        code, said = self.server.ask()
        self.assertEqual((code, words in said), (500, True), said)

    def test_a_whole_output_is_read(self):
        read_all(self.folder / "o")
        self.view(code=0)
        heads = json.loads(self.server.ask()[1])["heads"]
        self.assertEqual((len(heads), heads[0]["bodies"], heads[0]["contacts_of"], len(heads[0]["forms"])), (1, COUNT, COUNT, COUNT))
        self.assertEqual(self.server.ask("/frame/0")[0], 200)

    def test_bodies_have_the_sum_of_their_contact_forces_and_contacts_are_there_on_request(self):
        size = np.linalg.norm(np.arange(3.0 * COUNT).reshape(-1, 3), axis=1)
        asked = Server(self.folder, "--contacts")
        self.addCleanup(asked.end)
        for server, each in (self.server, False), (asked, True):
            head = json.loads(server.ask()[1])["heads"][0]
            self.assertEqual("contact_a" in head["blocks"], each)
            with urllib.request.urlopen(f"http://{server.host}/{server.token}/frame/0") as answer:
                data = answer.read()
            at = head["blocks"]["force"][1]
            force = np.frombuffer(data[at:at + 2 * COUNT], "<u2") * head["body_force_cell"]
            np.testing.assert_allclose(force, size + size[::-1], rtol=1e-4)
            at = head["blocks"]["touching"][1]
            self.assertEqual(set(data[at:at + COUNT]), {2})

    def test_shapes_of_ones_own_have_a_number_too(self):
        for file, name in (BODIES, "VTKHDF/PointData/shape"), (SURFACES, "VTKHDF/CellData/shape"):
            with_array(self.folder / file, name, lambda g, n: g.__setitem__(n, np.full(COUNT, 6, "u1")))
        self.assertEqual(set(talus.open(self.folder / "o")[0].shapes), {"own"})
        head = json.loads(self.server.ask()[1])["heads"][0]
        self.assertEqual((len(head["forms"]), head["shapes"]), (COUNT, "own\n"))
        with urllib.request.urlopen(f"http://{self.server.host}/{self.server.token}/frame/0") as answer:
            begin = head["blocks"]["new_shape"][1]
            self.assertEqual(set(answer.read()[begin:begin + COUNT]), {7})

    def test_shapes_of_ones_own_keep_their_names_in_pages(self):
        numbers = np.array([6, 7] * (COUNT // 2), "u1")
        for file, name in (BODIES, "VTKHDF/PointData/shape"), (SURFACES, "VTKHDF/CellData/shape"):
            with_array(self.folder / file, name, lambda g, n: g.__setitem__(n, numbers))
        with_array(self.folder / BODIES, "VTKHDF/FieldData/own_shapes", lambda g, n: g.__setitem__(n, np.frombuffer(b"lens\nwheel_nut\n", "u1")))
        head = json.loads(self.server.ask()[1])["heads"][0]
        self.assertEqual((head["shapes"], len(head["forms"])), ("lens\nwheel_nut\n", COUNT))
        with urllib.request.urlopen(f"http://{self.server.host}/{self.server.token}/frame/0") as answer:
            begin = head["blocks"]["new_shape"][1]
            self.assertEqual(sorted(answer.read()[begin:begin + COUNT]), sorted(numbers + 1))

    def test_what_leads_to_other_files_is_refused(self):
        other = self.outer / "other.hdf"
        with h5py.File(other, "w") as f:
            f["x"] = np.frombuffer(SECRET[:24 * COUNT], "f8").reshape(-1, 3)
        layout = h5py.VirtualLayout((COUNT, 3), "f8")
        layout[:] = h5py.VirtualSource(str(other), "x", (COUNT, 3))
        ways = [lambda g, n: g.create_dataset(n, (COUNT, 3), "f8", external=[(str(self.outer / "secret"), 0, 24 * COUNT)]),
                lambda g, n: g.__setitem__(n, h5py.ExternalLink(str(other), "x")),
                lambda g, n: g.__setitem__(n, h5py.SoftLink("/VTKHDF")),
                lambda g, n: g.create_virtual_dataset(n, layout)]
        for file, name, reader in [(BODIES, "VTKHDF/Points", True), (BODIES, "VTKHDF/PointData/velocity", True),
                                   (CONTACTS, "VTKHDF/CellData/force", True), (SURFACES, "VTKHDF/Points", False)]:
            for way in ways:
                write_output(self.folder)
                with_array(self.folder / file, name, way)
                self.refused(f"{file}: {name} ", reader)

    def test_names_that_lead_out_of_the_folder_are_refused(self):
        for name in ("../sent/" + BODIES, str(self.folder / BODIES), "", ".", "..", "a\0b", "a\x1bb", "\ud800"):
            write_index(self.folder, name)
            self.refused(f"names {name!r}")
        for file in (BODIES, CONTACTS, SURFACES):
            write_output(self.folder)
            (self.folder / file).rename(self.outer / file)
            (self.folder / file).symlink_to(self.outer / file)
            self.refused(f"{file} is a symbolic link", file != SURFACES)
            (self.folder / file).unlink()

    def test_names_that_command_a_terminal_are_refused(self):
        with_array(self.folder / BODIES, "VTKHDF/PointData/a\x1b[2Jb", lambda g, n: g.__setitem__(n, h5py.SoftLink("/VTKHDF")))
        self.refused("VTKHDF/PointData has the name 'a\\x1b[2Jb'")

    def test_names_that_a_run_has_written_are_read_and_shown_escaped(self):
        odd = "a \t\x1b[2J\u202e<b"
        for file in (BODIES, CONTACTS, SURFACES, "o.hdf.series"):
            (self.folder / file).rename(self.folder / (odd + file[1:]))
        (self.folder / (odd + ".hdf.series")).write_text(json.dumps({"files": [{"name": odd + BODIES[1:], "time": 0.5}]}))
        read_all(self.folder / odd)
        told = subprocess.run([*VIEW, str(self.folder / odd)], capture_output=True, text=True, timeout=20,
                              env={**os.environ, "TALUS_THREE": str(self.folder / "three.js")})
        self.assertEqual(told.returncode, 0, told.stderr)
        for text in told.stderr, (self.folder / (odd + ".html")).read_text():
            self.assertTrue("\x1b" not in text and "\u202e" not in text and "\\u202e" in text, text[:2000])
        (self.folder / (odd + ".hdf.series")).write_text(json.dumps({"files": [{"name": odd + "\x1b" + BODIES[1:], "time": 0.5}]}))
        with self.assertRaisesRegex(talus.Error, "plain names"):
            read_all(self.folder / odd)

    def test_pipes_and_devices_are_refused(self):
        for file in (BODIES, CONTACTS, SURFACES, "o.hdf.series"):
            write_output(self.folder)
            (self.folder / file).unlink()
            os.mkfifo(self.folder / file)
            self.refused(f"{file} is a device, a pipe or a socket", file != SURFACES)
            (self.folder / file).unlink()
        write_output(self.folder)
        self.assertIn("is a device", self.view("--csv", "/dev/zero", code=1).stderr)
        for path in ("/dev/stdout", "//dev/stdout", "/dev/./stderr", "/dev/fd/1", "/proc/self/fd/2", "/proc/thread-self/fd/1"):  # as links, they would be replaced
            self.assertIn(f"{path} is a stream", self.view("--html", path, "--force", code=1).stderr)
        for path in ("/dev/zero", "/dev/null"):
            with self.assertRaisesRegex(talus.Error, "is a device"):
                talus.open(path)

    def test_links_that_lead_to_no_file_stay(self):
        write_output(self.folder)
        os.mkfifo(self.folder / "pipe")
        (self.folder / "to_pipe").symlink_to("pipe")
        (self.folder / "to_folder").symlink_to(self.outer)
        self.assertIn("to_pipe is a device, a pipe or a socket", self.view("--html", self.folder / "to_pipe", "--force", code=1).stderr)
        self.assertIn("to_folder is a folder", self.view("--html", self.folder / "to_folder", "--force", code=1).stderr)
        self.assertTrue((self.folder / "to_pipe").is_symlink() and (self.folder / "to_folder").is_symlink())

    def test_what_a_run_writes_stays(self):
        write_output(self.folder)
        for lock, page in (("page.html.lock", "page.html"), ("page.hdf.series.lock", "page_0000000012.hdf"), ("frame.pov.series.lock", "frame_00001.pov")):
            (self.folder / page).write_text("of a run")
            with open(self.folder / lock, "w") as held:
                fcntl.flock(held, fcntl.LOCK_EX)
                self.assertIn(f"{page} is being written by a run", self.view("--html", self.folder / page, "--force", code=1).stderr)
            self.assertEqual((self.folder / page).read_text(), "of a run")
            self.view("--html", self.folder / page, "--force", code=0)  # the run has ended

    def test_sizes_are_those_of_the_file(self):
        huge = lambda g, n: g.create_dataset(n, (1 << 50, 3), "f8", chunks=(1024, 3))
        late = lambda g, n: g.create_dataset(n, (1 << 26, 3), "f8")
        for way in (huge, late):
            write_output(self.folder)
            with_array(self.folder / BODIES, "VTKHDF/Points", way)
            self.refused(f"{BODIES}")

    def test_other_types_and_shapes_are_refused(self):
        text = h5py.string_dtype()
        for file, name, values in [
                (BODIES, "VTKHDF/PointData/id", np.arange(1.0 * COUNT)), (BODIES, "VTKHDF/PointData/shape", np.full(COUNT, 77, "u1")),
                (BODIES, "VTKHDF/PointData/fixed", np.zeros(COUNT - 1, "u1")), (BODIES, "VTKHDF/Points", np.zeros((COUNT, 2))),
                (BODIES, "VTKHDF/Points", 1.0), (BODIES, "VTKHDF/Points", np.zeros((COUNT, 3), np.longdouble)), (BODIES, "VTKHDF/PointData/velocity", np.zeros((COUNT, 3, 3))),
                (BODIES, "VTKHDF/FieldData/step", np.zeros(0, int)), (BODIES, "VTKHDF/PointData/size", np.zeros((COUNT, 3), "c16")),
                (BODIES, "VTKHDF/PointData/mass", np.array(["x"] * COUNT, dtype=text)),
                (CONTACTS, "VTKHDF/CellData/id_b", np.zeros(COUNT + 1, "u8")), (CONTACTS, "VTKHDF/CellData/force", np.zeros(COUNT)),
                (SURFACES, "VTKHDF/Connectivity", np.full(3 * COUNT, 99)), (SURFACES, "VTKHDF/Offsets", np.zeros(2, int)),
                (SURFACES, "VTKHDF/Offsets", np.array([0, 24] * (COUNT // 2) + [24]))]:
            write_output(self.folder)
            with_array(self.folder / file, name, lambda g, n: g.__setitem__(n, values))
            with self.subTest(file=file, name=name):
                self.refused(name.rpartition("/")[2], file != SURFACES)
        for index in ("[" * 100000, "1", '{"files": {}}', '{"files": [{"name": 3, "time": 0}]}', '{"files": [{"name": "o", "time": true}]}',
                      '{"files": [{"name": "o", "time": "0"}]}', '{"files": [1]}', '{"files": [{"name": "o", "time": 1e999}]}',
                      f'{{"files": [{{"name": "o", "time": {"9" * 400}}}]}}', "\xff"):
            (self.folder / "o.hdf.series").write_text(index, encoding="latin-1")
            self.refused("o.hdf.series is ")

    def test_a_file_with_holes_is_refused_at_the_first(self):
        for file in self.folder / "o.hdf.series", self.folder / "t.csv":
            file.write_text("step [1],a [1]\n1,2\n")
            os.truncate(file, 1 << 42)
            with self.assertRaisesRegex(talus.Error, f"{file.name} is damaged: it has a zero byte after 19 others"):
                talus.open(file)
        self.refused("o.hdf.series is damaged")
        write_output(self.folder)
        self.assertIn("t.csv is damaged", self.view("--csv", self.folder / "t.csv", code=1).stderr)

    def test_an_array_that_the_file_does_not_hold_is_refused_before_it_takes_memory(self):
        def empty(group, name):
            how = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
            how.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
            how.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
            h5py.h5d.create(group.id, name.encode(), h5py.h5t.STD_U64LE, h5py.h5s.create_simple((10 ** 8,)), how)
        with_array(self.folder / BODIES, "VTKHDF/PointData/id", empty)
        with self.assertRaisesRegex(talus.Error, "id would be of 800000000 bytes, which are not within the file"):
            read_all(self.folder / "o")
        self.refused("id has 100000000 rows, and not 8", reader=False)

    def test_numbers_without_a_square_make_a_page(self):
        for name in ("VTKHDF/Points", "VTKHDF/PointData/velocity", "VTKHDF/PointData/size"):
            for value in (1e300, np.nan, -np.inf):
                with_array(self.folder / BODIES, name, lambda g, n: g.__setitem__(n, np.full((COUNT, 3), value)))
                self.view(code=0)
            write_output(self.folder)
        for file, name, values in [(CONTACTS, "VTKHDF/CellData/normal_force", np.full(COUNT, np.nan)),
                                   (CONTACTS, "VTKHDF/CellData/normal_force", np.full(COUNT, 1e308)),  # have no sum
                                   (CONTACTS, "VTKHDF/CellData/force", np.full((COUNT, 3), 3e38, "f4")),
                                   (BODIES, "VTKHDF/PointData/velocity", np.full((COUNT, 3), 3e38, "f4"))]:
            write_output(self.folder)
            with_array(self.folder / file, name, lambda g, n: g.__setitem__(n, values))
            with self.subTest(name=name, type=values.dtype):
                self.view(code=0)
                code, said = self.server.ask()
                self.assertEqual(code, 200, said)
                json.loads(said)

    def begun(self, process):
        """Whether the process has an open file for the page."""
        for link in pathlib.Path(f"/proc/{process}/fd").glob("*"):
            try:
                to = os.readlink(link)
            except OSError:
                continue
            if to.startswith(str(self.folder.resolve())) and (to.endswith("(deleted)") or ".part-" in to):
                return True
        return False

    def test_a_signal_in_the_first_moments_ends_with_a_sentence(self):
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            for wait in (0.1, 0.2, 0.3, 0.4):
                made = subprocess.Popen([*VIEW, str(self.folder / "none")], stderr=subprocess.PIPE, text=True,
                                        preexec_fn=lambda n=number: signal.signal(n, signal.SIG_DFL))
                time.sleep(wait)
                if made.poll() is None:
                    made.send_signal(number)
                said = made.communicate(timeout=20)[1]
                self.assertIn(made.returncode, (1, 128 + number, -number), said)  # -number: before its first line
                self.assertNotIn("Traceback", said)

    def test_a_signal_leaves_no_unfinished_page(self):
        body = (self.folder / BODIES).read_bytes()
        names = [f"many_{k}.hdf" for k in range(3000)]
        for name in names:
            (self.folder / name).write_bytes(body)
        (self.folder / "many.hdf.series").write_text(json.dumps({"files": [{"name": n, "time": k} for k, n in enumerate(names)]}))
        for number in (signal.SIGTERM, signal.SIGKILL, signal.SIGHUP, signal.SIGINT):
            for attempt in range(10):  # on a busy machine, the page may be whole before the signal comes
                made = subprocess.Popen([*VIEW, str(self.folder / "many")], stderr=subprocess.PIPE, text=True,
                                        preexec_fn=lambda n=number: n == signal.SIGKILL or signal.signal(n, signal.SIG_DFL),  # not as in the background
                                        env={**os.environ, "TALUS_THREE": str(self.folder / "three.js")})
                end = time.monotonic() + 20
                while not self.begun(made.pid) and made.poll() is None and time.monotonic() < end:
                    time.sleep(0.005)
                time.sleep(0.05 / 2**attempt)
                made.send_signal(number)
                said = made.communicate(timeout=20)[1]
                if made.returncode != 0:
                    break
            if number == signal.SIGKILL:
                if has_files_without_names(self.folder):
                    self.assertEqual(list(self.folder.glob("*.part-*")), [])
                continue  # otherwise the next one removes it
            self.assertEqual((made.returncode, said.splitlines()[-1]), (128 + number, f"view: ended by {number.name}"))
            self.assertNotIn("Traceback", said)
            self.assertEqual(list(self.folder.glob("*.part-*")), [])

    def test_random_damage_ends_in_a_sentence_and_in_time(self):
        random = np.random.default_rng(7)
        damaged = 0
        for k in range(60):
            write_output(self.folder)
            file = self.folder / (BODIES, CONTACTS, SURFACES)[k % 3]
            data = bytearray(file.read_bytes())
            if k % 5 == 0:
                data = data[:random.integers(len(data))]
            else:
                for place in random.integers(len(data), size=random.integers(1, 30)):
                    data[place] = random.integers(256)
            file.write_bytes(data)
            child = os.fork()
            if child == 0:  # HDF5 itself may end the process
                signal.alarm(20)
                code = 1
                try:
                    read_all(self.folder / "o")
                    code = 0
                except talus.Error:
                    code = 0
                finally:
                    os._exit(code)
            self.assertEqual(os.waitpid(child, 0)[1], 0, f"damage {k}")
            if k % 4 == 0:
                damaged += self.view("--html", str(self.folder / "page.html")).returncode
        self.assertGreater(damaged, 5)


if __name__ == "__main__":
    unittest.main()
