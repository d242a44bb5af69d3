#!/usr/bin/env python3
"""What ./dev view replaces, and its server where descriptors, room or patience run out.

  served.py     ends with 77 without h5py"""
import contextlib
import errno
import json
import os
import pathlib
import resource
import signal
import socket
import subprocess
import tempfile
import time
import sys
import unittest

try:
    from sent_output import BODIES, VIEW, Server, write_output
except ImportError:
    print("skipped: no h5py")
    sys.exit(77)


def processor_time(pid):
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


class Case(unittest.TestCase):
    def setUp(self):
        made = tempfile.TemporaryDirectory()
        self.addCleanup(made.cleanup)
        self.folder = pathlib.Path(made.name)
        (self.folder / "three.js").write_text("THREE")
        write_output(self.folder)


class Replaced(Case):
    def view(self, page, *words, code):
        told = subprocess.run([*VIEW, self.folder / "o", "--html", page, *words], capture_output=True, text=True, timeout=60,
                              env={**os.environ, "TALUS_THREE": str(self.folder / "three.js")})
        self.assertEqual(told.returncode, code, told.stderr)
        return told.stderr

    def test_folders_devices_pipes_and_sockets_are_never_replaced(self):
        page = self.folder / "page.html"
        with contextlib.closing(socket.socket(socket.AF_UNIX)) as own:
            for make in (lambda: os.mkfifo(page), lambda: own.bind(str(page)), lambda: os.mknod(page, 0o20666, os.makedev(1, 3))):
                try:
                    make()
                except PermissionError:  # only root makes devices
                    continue
                kind = page.lstat().st_mode
                for words in ((), ("--force",)):
                    self.assertIn("is a device, a pipe or a socket", self.view(page, *words, code=1))
                    self.assertEqual(page.lstat().st_mode, kind)
                page.unlink()
        page.mkdir()
        self.assertIn("is a folder", self.view(page, "--force", code=1))

    def test_links_and_other_files_are_replaced_by_force_alone(self):
        page, other = self.folder / "page.html", self.folder / "other"
        other.write_text("precious")
        page.symlink_to(other)
        self.assertIn(f"is a symbolic link to {other}", self.view(page, code=1))
        self.view(page, "--force", code=0)
        self.assertEqual((page.is_symlink(), other.read_text()), (False, "precious"))
        self.view(page, code=0)
        self.assertIn("is no page of talus", self.view(other, code=1))
        self.view(other, "--force", code=0)
        self.assertNotIn("precious", other.read_text())


    def test_what_a_page_is_made_of_is_never_replaced(self):
        (self.folder / "t.csv").write_text("step [1],time [T]\n1,0.5\n")
        for name in "o.hdf.series", BODIES, "t.csv":
            before = (self.folder / name).read_bytes()
            for page in self.folder / name, self.folder / "." / name:
                told = self.view(page, "--force", "--csv", self.folder / "t.csv", code=1)
                self.assertIn("is a file that the page is made of", told)
            self.assertEqual((self.folder / name).read_bytes(), before)

    def test_empty_names_are_refused_and_names_do_not_command_the_terminal(self):
        self.assertIn("--html takes a name, and is empty", self.view("", code=2))
        self.assertIn("--csv takes a name, and is empty", self.view(self.folder / "page.html", "--csv", "", code=2))
        red = self.folder / "red\x1b[31m.html"
        red.mkdir()
        for page, words, code in (red, (), 1), (self.folder / "r\x1b.html", (), 0), (self.folder / "p.html", ("\x1b",), 2):
            self.assertNotIn("\x1b", self.view(page, *words, code=code))

    def test_a_page_whose_size_cannot_be_told_is_written_with_code_0(self):
        page = self.folder / "page.html"
        for errors in ("2>/dev/full", "2>&-"):
            with self.subTest(errors):
                ended = subprocess.run(["sh", "-c", f'exec "$@" {errors}', "sh", *VIEW, str(self.folder / "o"), "--html", str(page)],
                                       timeout=60, env={**os.environ, "TALUS_THREE": str(self.folder / "three.js")})
                self.assertEqual(ended.returncode, 0)
                self.assertIn("</html>", page.read_text())
                page.unlink()


    def test_a_server_whose_address_cannot_be_printed_ends_with_a_sentence(self):
        ended = subprocess.run(["sh", "-c", 'exec "$@" >/dev/full', "sh", *VIEW, str(self.folder / "o"), "--serve", "0"], text=True,
                               stderr=subprocess.PIPE, timeout=60,
                               env={**os.environ, "TALUS_THREE": str(self.folder / "three.js")})
        self.assertEqual(ended.returncode, 1)
        self.assertEqual(ended.stderr, f"view: the address cannot be printed: {os.strerror(errno.ENOSPC)}\n")


class Served(Case):
    def serve(self, *words, **more):
        server = Server(self.folder, *words, **more)
        self.addCleanup(server.end)
        server.place = tuple(server.host.split(":")) if server.host else None
        return server

    def connections(self, server, count):
        for _ in range(count):
            one = socket.create_connection(server.place, timeout=0.5)
            self.addCleanup(one.close)
            yield one

    def test_without_free_descriptors_it_waits(self):
        server = self.serve(limit=lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (24, 24)))
        waiting = list(self.connections(server, 40))
        time.sleep(0.5)
        before = processor_time(server.process.pid)
        time.sleep(2)
        self.assertLess(processor_time(server.process.pid) - before, 0.4)
        for one in waiting:
            one.close()
        self.assertEqual(server.ask()[0], 200)

    def test_many_browsers_may_knock_at_once(self):
        server = self.serve()
        server.process.send_signal(signal.SIGSTOP)
        self.assertEqual(len(list(self.connections(server, 100))), 100)
        server.process.send_signal(signal.SIGCONT)
        self.assertEqual(server.ask()[0], 200)

    def test_an_empty_address_is_refused(self):
        self.assertIn("--bind takes an address", self.serve("--bind", "").process.communicate(timeout=20)[1])
        said = self.serve("--bind", "a..b").process.communicate(timeout=20)[1]
        self.assertIn("cannot serve at a..b", said)
        self.assertNotIn("Traceback", said)

    def test_a_full_folder_of_temporary_files_is_told_until_there_is_room(self):
        server = self.serve()
        resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (200, resource.RLIM_INFINITY))
        for _ in range(2):
            code, said = server.ask()
            self.assertEqual(code, 500)
            self.assertIn(f"{BODIES} cannot be stored in ", said)
        resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
        heads = json.loads(server.ask()[1])["heads"]
        self.assertIn("new_id", heads[0]["blocks"])
        self.assertEqual(server.ask("/frame/0")[0], 200)

    def test_a_frame_that_is_mended_has_all_that_is_new(self):
        server = self.serve()
        contacts = self.folder / "o_contacts_0000000001.hdf"
        whole = contacts.read_bytes()
        contacts.write_bytes(whole[:3000])
        self.assertEqual(server.ask()[0], 500)
        contacts.write_bytes(whole)
        self.assertIn("new_id", json.loads(server.ask()[1])["heads"][0]["blocks"])

    def test_nothing_is_left_by_whatever_ends_it(self):
        for kind in (signal.SIGHUP, signal.SIGTERM, signal.SIGINT, signal.SIGKILL):
            temporary = self.folder / kind.name
            temporary.mkdir()
            server = self.serve(TMPDIR=str(temporary))
            self.assertEqual(server.ask()[0], 200)
            server.process.send_signal(kind)
            server.process.wait(20)
            self.assertEqual(list(temporary.iterdir()), [], kind.name)

    def test_head_has_no_body(self):
        server = self.serve()
        one = next(self.connections(server, 1))
        one.sendall(f"HEAD /{server.token}/ HTTP/1.1\r\nHost: x\r\n\r\n".encode())
        one.settimeout(20)
        said = b"".join(iter(lambda: one.recv(4096), b""))
        self.assertTrue(said.startswith(b"HTTP/1.1 405 ") and said.endswith(b"\r\n\r\n"), said)


if __name__ == "__main__":
    unittest.main()
