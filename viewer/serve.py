"""Shows a run while it goes on: the page, and frames as the run writes them. Read only."""
import http.server
import json
import os
import pathlib
import secrets
import sys
import tempfile
import threading
import time

import frames
import page
import view
from printable import printable


def changed(file):
    """When a file was written; a run replaces its files, and does not change them."""
    try:
        return os.stat(file).st_mtime_ns
    except OSError:
        return None


class Source:
    """The frames of a series so far. Their bytes lie in a temporary file without a name, not in memory: it is gone with the
    process, however that ends."""

    def __init__(self, base, every, csv_file, each_contact=False):
        self.base, self.every, self.csv_file, self.each_contact = base, every, csv_file, each_contact
        self.store = tempfile.TemporaryFile(buffering=0)
        self.lock = threading.Lock()
        self.series = 0
        self.begin()

    def begin(self):
        self.converter = frames.Converter(self.base, self.each_contact)
        self.series += 1
        self.files, self.heads, self.places = [], [], [0]
        self.ready = None  # a frame that is converted, but not stored
        self.store.truncate(0)

    def update(self):
        """Takes what the index lists beyond the last time. Another run may have begun the series again."""
        if not os.path.exists(self.base + ".hdf.series"):
            return
        listed = [(file, time, changed(file)) for file, time in frames.read_index(self.base)[::self.every]]
        if listed[:len(self.files)] != self.files or (self.ready and self.ready[0] not in listed[len(self.files):][:1]):
            self.begin()
        table = view.read_table(self.csv_file)[0] if self.csv_file and os.path.exists(self.csv_file) else {}
        for one in listed[len(self.files):]:
            if not self.ready:
                self.ready = one, *self.converter.frame(*one[:2])
            _, head, data = self.ready
            view.add_table(head, table)
            done = 0
            try:
                while done < len(data):
                    done += os.pwrite(self.store.fileno(), data[done:], self.places[-1] + done)
            except OSError as error:
                raise frames.Error(f"{one[0]} cannot be stored in {tempfile.gettempdir()} ({error.strerror}): make room there, or "
                                   "serve with another folder in TMPDIR") from None
            self.places.append(self.places[-1] + len(data))
            self.files.append(one)
            self.heads.append(head)
            self.ready = None

    def data(self, k):
        return os.pread(self.store.fileno(), self.places[k + 1] - self.places[k], self.places[k])


class Server(http.server.ThreadingHTTPServer):
    daemon_threads = True
    request_queue_size = 128  # connections that wait for their turn

    def get_request(self):
        try:
            return super().get_request()
        except OSError:  # without a free descriptor the connection stays, and so does the reason to ask again
            time.sleep(0.2)
            raise

    def handle_error(self, request, address):
        if not isinstance(sys.exc_info()[1], OSError):  # a browser that closes a connection is no fault
            super().handle_error(request, address)


def handler_of(source, token, whole_page):
    class Handler(http.server.BaseHTTPRequestHandler):
        server_version, sys_version, protocol_version = "talus", "", "HTTP/1.1"
        timeout = 60  # of a connection that neither asks nor reads

        def answer(self, code, body, kind="text/plain; charset=utf-8"):
            self.send_response(code)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(body)))
            self.send_header("Cache-Control", "no-store")
            self.send_header("Referrer-Policy", "no-referrer")
            self.send_header("X-Content-Type-Options", "nosniff")
            if code == 405:
                self.send_header("Allow", "GET")
            self.end_headers()
            if self.command != "HEAD":
                self.wfile.write(body)

        def do_GET(self):
            way = self.path.split("?")[0].split("/")[1:]
            if not way or not secrets.compare_digest(way[0].encode(), token.encode()):
                return self.answer(403, b"The address lacks the token that ./dev view has printed.\n")
            if way[1:] == [""]:
                return self.answer(200, whole_page, "text/html; charset=utf-8")
            if len(way) == 3 and way[2].isascii() and way[2].isdigit() and len(way[2]) < 10:
                with source.lock:  # not while it answers: a browser may read slowly, or not at all
                    try:
                        found = self.found(way[1], int(way[2]))
                    except (SystemExit, OSError, frames.Error) as error:
                        found = 500, f"{printable(error)}\n".encode()
                if found:
                    return self.answer(*found)
            self.answer(404, b"There is no such page.\n")

        def found(self, what, k):
            if what == "heads":
                source.update()
                more = {"heads": source.heads[k:], "series": source.series}
                return 200, json.dumps(more, allow_nan=False).encode(), "application/json"
            if what == "frame" and k < len(source.heads):
                return 200, source.data(k), "application/octet-stream"
            return None

        def refuse(self):
            self.close_connection = True
            self.answer(405, b"This server is read only.\n")

        do_POST = do_PUT = do_DELETE = do_PATCH = do_OPTIONS = do_HEAD = refuse

        def log_message(self, *_):
            pass
    return Handler


def serve(o, base):
    if not 0 <= o.serve <= 65535:
        sys.exit(f"view: --serve takes a port from 0 to 65535, not {o.serve}")
    names = view.read_table(o.csv)[1] if o.csv and os.path.exists(o.csv) else []
    before, between, end = page.parts(pathlib.Path(__file__).resolve().parent)
    whole = (before + page.three() + between + page.script_of("about", view.about(base, names, live=True)) + end).encode()
    token = secrets.token_urlsafe(16)
    try:
        source = Source(base, o.every, o.csv, o.contacts)
    except OSError as error:
        sys.exit(f"view: no temporary file can be made ({error.strerror}): name another folder in TMPDIR")
    try:
        server = Server((o.bind, o.serve), handler_of(source, token, whole))
    except (OSError, UnicodeError) as error:
        sys.exit(f"view: cannot serve at {o.bind}, port {o.serve}: {getattr(error, 'strerror', error)}; name another port, or 0 for any")
    try:
        print(f"http://{o.bind}:{server.server_port}/{token}/", flush=True)
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # what is left would be written at the end
        sys.exit(f"view: the address cannot be printed: {error.strerror}")
    print("view: open that address; Ctrl-C ends the server", file=sys.stderr)
    try:
        server.serve_forever()
    except KeyboardInterrupt:
        pass
