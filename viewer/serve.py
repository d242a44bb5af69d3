"""Shows a run while it goes on: the page, and frames as the run writes them. Read only."""
import http.server
import json
import os
import pathlib
import secrets
import signal
import sys
import tempfile
import threading

import frames
import page
import view


def changed(file):
    """When a file was written; a run replaces its files, and does not change them."""
    try:
        return os.stat(file).st_mtime_ns
    except OSError:
        return None


class Source:
    """The frames of a series so far. Their bytes lie in a temporary folder, not in memory."""

    def __init__(self, base, every, csv_file):
        self.base, self.every, self.csv_file = base, every, csv_file
        self.folder = tempfile.TemporaryDirectory(prefix="talus-view-")
        self.lock = threading.Lock()
        self.series = 0
        self.begin()

    def begin(self):
        self.converter = frames.Converter(self.base)
        self.series += 1
        self.files, self.heads = [], []

    def update(self):
        """Takes what the index lists beyond the last time. Another run may have begun the series again."""
        if not os.path.exists(self.base + ".hdf.series"):
            return
        listed = [(file, time, changed(file)) for file, time in frames.read_index(self.base)[::self.every]]
        if listed[:len(self.files)] != self.files:
            self.begin()
        table = view.read_table(self.csv_file)[0] if self.csv_file and os.path.exists(self.csv_file) else {}
        for file, time, when in listed[len(self.files):]:
            head, data = self.converter.frame(file, time)
            view.add_table(head, table)
            with open(self.path(len(self.heads)), "wb") as f:
                f.write(data)
            self.files.append((file, time, when))
            self.heads.append(head)

    def path(self, k):
        return os.path.join(self.folder.name, str(k))


class Server(http.server.ThreadingHTTPServer):
    daemon_threads = True

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
            self.wfile.write(body)

        def do_GET(self):
            way = self.path.split("?")[0].split("/")[1:]
            if not way or not secrets.compare_digest(way[0].encode(), token.encode()):
                return self.answer(403, b"The address lacks the token that ./dev view has printed.\n")
            if way[1:] == [""]:
                return self.answer(200, whole_page, "text/html; charset=utf-8")
            if len(way) == 3 and way[2].isascii() and way[2].isdigit() and len(way[2]) < 10:
                with source.lock:  # not while it answers: a browser may read slowly, or not at all
                    found = self.found(way[1], int(way[2]))
                if found:
                    return self.answer(*found)
            self.answer(404, b"There is no such page.\n")

        def found(self, what, k):
            if what == "heads":
                try:
                    source.update()
                except SystemExit as error:
                    return 500, (str(error) + "\n").encode()
                more = {"heads": source.heads[k:], "series": source.series}
                return 200, json.dumps(more, allow_nan=False).encode(), "application/json"
            if what == "frame" and k < len(source.heads):
                with open(source.path(k), "rb") as f:
                    return 200, f.read(), "application/octet-stream"
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
    source = Source(base, o.every, o.csv)
    try:
        server = Server((o.bind, o.serve), handler_of(source, token, whole))
    except OSError as error:
        sys.exit(f"view: cannot serve at {o.bind}, port {o.serve}: {error.strerror}; name another port, or 0 for any")
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # the temporary folder is removed, too
    print(f"http://{o.bind}:{server.server_port}/{token}/", flush=True)
    print("view: open that address; Ctrl-C ends the server", file=sys.stderr)
    try:
        server.serve_forever()
    except KeyboardInterrupt:
        pass
    finally:
        source.folder.cleanup()
