"""A headless Chromium for tests of pages: by the DevTools protocol, with the standard library alone."""
import base64
import json
import os
import shutil
import socket
import struct
import subprocess
import tempfile
import time
import zlib


def find_browser():
    for name in ("chromium", "chromium-browser", "google-chrome"):
        if shutil.which(name):
            return name
    return None


class Browser:
    """One page. `errors` has what its console and its scripts complain of, `requests` the addresses that it asks for."""

    def __init__(self, width=900, height=1000):
        self.folder = tempfile.mkdtemp(prefix="talus-browser-")
        # Rendering by software: the same pixels on every machine.
        self.process = subprocess.Popen(
            [find_browser(), "--headless=new", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader",
             "--enable-unsafe-swiftshader", "--remote-debugging-port=0", f"--user-data-dir={self.folder}",
             "--force-device-scale-factor=1", f"--window-size={width},{height}", "--hide-scrollbars", "--no-first-run",
             "--disable-background-networking", "--disable-component-update", "--disable-dev-shm-usage", "about:blank"],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        port_file = os.path.join(self.folder, "DevToolsActivePort")
        until = time.monotonic() + 60
        while not (os.path.exists(port_file) and open(port_file).read().count("\n")):
            if self.process.poll() is not None or time.monotonic() > until:
                raise RuntimeError("the browser does not start")
            time.sleep(0.05)
        port, path = open(port_file).read().split("\n")[:2]
        self.socket = socket.create_connection(("127.0.0.1", int(port)), timeout=120)
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall(f"GET {path} HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                            f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n".encode())
        self.buffer = b""
        while b"\r\n\r\n" not in self.buffer:
            self.buffer += self.socket.recv(4096)
        self.buffer = self.buffer.split(b"\r\n\r\n", 1)[1]
        self.number, self.session = 0, None
        self.errors, self.requests = [], []
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(domain + ".enable")
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    # --- The protocol ----------------------------------------------------------------------------

    def take(self, n):
        while len(self.buffer) < n:
            more = self.socket.recv(1 << 20)
            if not more:
                raise RuntimeError("the browser has ended")
            self.buffer += more
        taken, self.buffer = self.buffer[:n], self.buffer[n:]
        return taken

    def receive(self):
        text = b""
        while True:
            first, second = self.take(2)
            size = second & 127
            if size == 126:
                size = struct.unpack(">H", self.take(2))[0]
            elif size == 127:
                size = struct.unpack(">Q", self.take(8))[0]
            text += self.take(size)
            if first & 128:
                return json.loads(text)

    def call(self, method, **parameters):
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        data = json.dumps(message).encode()
        size = struct.pack(">BB", 0x81, 128 | len(data)) if len(data) < 126 else \
            struct.pack(">BBH", 0x81, 254, len(data)) if len(data) < 65536 else struct.pack(">BBQ", 0x81, 255, len(data))
        self.socket.sendall(size + bytes(4) + data)  # masked with zeros
        while True:
            answer = self.receive()
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]
            self.note(answer)

    def note(self, event):
        p, method = event.get("params", {}), event.get("method")
        if method == "Runtime.exceptionThrown":
            d = p["exceptionDetails"]
            self.errors.append(d.get("exception", {}).get("description") or d["text"])
        elif method == "Runtime.consoleAPICalled" and p["type"] in ("error", "warning", "assert"):
            self.errors.append(" ".join(str(a.get("value", a.get("description"))) for a in p["args"]))
        elif method == "Log.entryAdded" and p["entry"]["level"] in ("error", "warning"):
            text = p["entry"]["text"]
            if "GPU stall due to ReadPixels" not in text:  # of the screenshots of software rendering
                self.errors.append(text + " " + p["entry"].get("url", ""))
        elif method == "Network.requestWillBeSent":
            self.requests.append(p["request"]["url"])

    # --- What tests do ---------------------------------------------------------------------------

    def open(self, address):
        self.call("Page.navigate", url=address)

    def run(self, script):
        """The value of an expression in the page, also of a promise."""
        r = self.call("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in r:
            d = r["exceptionDetails"]
            raise RuntimeError(d.get("exception", {}).get("description") or d["text"])
        return r["result"].get("value")

    def wait(self, condition, seconds=60):
        until = time.monotonic() + seconds
        while not self.run(condition):
            if time.monotonic() > until:
                raise RuntimeError(f"the page never has: {condition}\n" + "\n".join(self.errors) + "\n" +
                                   str(self.run("document.getElementById('message')?.textContent")))
            time.sleep(0.05)

    def screenshot(self, file=None):
        data = base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])
        if file:
            with open(file, "wb") as f:
                f.write(data)
        return Picture(data)

    def click(self, x, y):
        for kind in ("mousePressed", "mouseReleased"):
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1,
                      buttons=1 if kind == "mousePressed" else 0)

    def drag(self, x, y, dx, dy):
        mouse = lambda kind, x, y, held: self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left",
                                                   buttons=held, clickCount=1)
        mouse("mousePressed", x, y, 1)
        for k in range(1, 6):
            mouse("mouseMoved", x + dx * k / 5, y + dy * k / 5, 1)
        mouse("mouseReleased", x + dx, y + dy, 0)

    def close(self):
        try:
            self.session = None
            self.call("Browser.close")
        except (OSError, RuntimeError):
            pass
        self.socket.close()
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        shutil.rmtree(self.folder, ignore_errors=True)


class Picture:
    """The pixels of a PNG file with 8 bits a channel."""

    def __init__(self, data):
        assert data[:8] == b"\x89PNG\r\n\x1a\n"
        at, packed = 8, b""
        while at < len(data):
            size, kind = struct.unpack(">I4s", data[at:at + 8])
            body = data[at + 8:at + 8 + size]
            if kind == b"IHDR":
                self.width, self.height, depth, colours, _, _, interlaced = struct.unpack(">IIBBBBB", body)
                assert depth == 8 and colours in (2, 6) and interlaced == 0
            elif kind == b"IDAT":
                packed += body
            at += 12 + size
        step = 3 if colours == 2 else 4
        raw, line_bytes = zlib.decompress(packed), self.width * step
        self.lines, before = [], bytearray(line_bytes)
        for y in range(self.height):
            start = y * (line_bytes + 1)
            how, line = raw[start], bytearray(raw[start + 1:start + 1 + line_bytes])
            if how == 1:
                for i in range(step, line_bytes):
                    line[i] = (line[i] + line[i - step]) & 255
            elif how == 2:
                line = bytearray((a + b) & 255 for a, b in zip(line, before))
            elif how == 3:
                for i in range(line_bytes):
                    left = line[i - step] if i >= step else 0
                    line[i] = (line[i] + (left + before[i]) // 2) & 255
            elif how == 4:
                for i in range(line_bytes):
                    a, b, c = (line[i - step] if i >= step else 0), before[i], (before[i - step] if i >= step else 0)
                    p = a + b - c
                    pa, pb, pc = abs(p - a), abs(p - b), abs(p - c)
                    line[i] = (line[i] + (a if pa <= pb and pa <= pc else b if pb <= pc else c)) & 255
            self.lines.append(line)
            before = line
        self.step = step

    def at(self, x, y):
        i = int(x) * self.step
        return tuple(self.lines[int(y)][i:i + 3])
