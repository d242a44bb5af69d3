"""Pages in headless Chromium, by its DevTools protocol over a pipe: no packages of Python are needed.

  with Browser() as browser:
      browser.open("file:///...")       # waits until the page is loaded
      browser.run("document.title")
      browser.errors                    # errors and warnings of its console, since the last open()
      browser.requests                  # addresses that it asked for, since the last open()
"""
import base64
import fcntl
import json
import os
import select
import shutil
import signal
import struct
import subprocess
import tempfile
import time
import zlib

NAMES = ("chromium", "chromium-browser", "google-chrome")


def find_browser():
    """The browser's path, or None."""
    return next((path for path in map(shutil.which, NAMES) if path), None)


class Failure(Exception):
    pass


def above_ten(descriptor):
    """The same file under a number that bash's redirections do not use."""
    copy = fcntl.fcntl(descriptor, fcntl.F_DUPFD, 10)
    os.close(descriptor)
    return copy


class Browser:
    def __init__(self, seconds=30, size=(1300, 900)):
        self.seconds, self.number, self.loaded, self.buffer = seconds, 0, False, b""
        self.errors, self.requests = [], []
        self.profile = tempfile.TemporaryDirectory(prefix="talus_browser_")
        # Chromium reads commands from descriptor 3 and writes answers to 4.
        theirs_in, mine_out = map(above_ten, os.pipe())
        mine_in, theirs_out = map(above_ten, os.pipe())
        self.out, self.into = mine_out, mine_in
        # Rendering by software: the same pixels on every machine. Root has no sandbox; the pages are our own.
        root = ["--no-sandbox"] if os.geteuid() == 0 else []
        self.process = subprocess.Popen(
            ["bash", "-c", f'exec "$@" 3<&{theirs_in} 4>&{theirs_out}', "bash", find_browser(), "--headless=new",
             *root, "--remote-debugging-pipe", "--use-gl=angle", "--use-angle=swiftshader",
             "--enable-unsafe-swiftshader", "--force-device-scale-factor=1", "--hide-scrollbars", "--disable-dev-shm-usage", "--no-first-run",
             "--disable-background-networking", "--disable-component-update", "--disable-sync", "--mute-audio",
             f"--user-data-dir={self.profile.name}", f"--window-size={size[0]},{size[1]}", "about:blank"],
            pass_fds=(theirs_in, theirs_out), stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL, start_new_session=True)
        os.close(theirs_in), os.close(theirs_out)
        self.session = None
        try:
            targets = self.call("Target.getTargets")["targetInfos"]
            page = next(t for t in targets if t["type"] == "page")
            self.session = self.call("Target.attachToTarget", targetId=page["targetId"], flatten=True)["sessionId"]
            for domain in ("Page", "Runtime", "Log", "Network"):
                self.call(f"{domain}.enable")
            self.call("Emulation.setDeviceMetricsOverride", width=size[0], height=size[1], deviceScaleFactor=1,
                      mobile=False)
        except BaseException:
            self.close()
            raise

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        try:
            os.killpg(self.process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        self.process.wait()
        os.close(self.out), os.close(self.into)
        for _ in range(20):  # its children may write until they end
            try:
                self.profile.cleanup()
                break
            except OSError:
                time.sleep(0.1)

    def call(self, method, **parameters):
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        try:
            os.write(self.out, json.dumps(message).encode() + b"\0")
        except BrokenPipeError:
            raise Failure(f"{method}: the browser has ended, with {self.process.wait()}") from None
        end = time.monotonic() + self.seconds
        while True:
            answer = self.receive(end, method)
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise Failure(f"{method}: {answer['error'].get('message')}")
                return answer.get("result", {})

    def receive(self, end, what):
        """The next message; events are noted on the way."""
        while b"\0" not in self.buffer:
            if not select.select([self.into], [], [], max(0.0, end - time.monotonic()))[0]:
                raise Failure(f"{what}: no answer of the browser within {self.seconds} s")
            more = os.read(self.into, 1 << 16)
            if not more:
                raise Failure(f"{what}: the browser has ended")
            self.buffer += more
        text, _, self.buffer = self.buffer.partition(b"\0")
        message = json.loads(text)
        self.note(message.get("method"), message.get("params", {}))
        return message

    def note(self, event, given):
        if event == "Page.loadEventFired":
            self.loaded = True
        elif event == "Runtime.exceptionThrown":
            details = given["exceptionDetails"]
            self.errors.append(details.get("exception", {}).get("description") or details["text"])
        elif event == "Log.entryAdded" and given["entry"]["level"] in ("error", "warning"):
            if "GPU stall due to ReadPixels" not in given["entry"]["text"]:  # of pictures of software rendering
                self.errors.append(f"{given['entry']['text']} {given['entry'].get('url', '')}")
        elif event == "Runtime.consoleAPICalled" and given["type"] in ("error", "warning", "assert"):
            self.errors.append(" ".join(str(a.get("value", a.get("description"))) for a in given["args"]))
        elif event == "Network.requestWillBeSent":
            self.requests.append(given["request"]["url"])
        elif event == "Network.loadingFailed" and not given.get("canceled"):
            self.errors.append(f"not loaded: {given.get('errorText')}")

    def open(self, address):
        self.errors, self.requests, self.loaded = [], [], False
        result = self.call("Page.navigate", url=address)
        if result.get("errorText"):
            raise Failure(f"{address}: {result['errorText']}")
        end = time.monotonic() + self.seconds
        while not self.loaded:
            self.receive(end, address)
        # The event may be that of the page before.
        page = json.dumps(address.partition("#")[0])
        if not self.wait_until(f"document.readyState === 'complete' && location.href.split('#')[0] === {page}"):
            raise Failure(f"{address}: not loaded within {self.seconds} s")

    def wait_until(self, condition, seconds=None):
        """Whether an expression of JavaScript becomes true in time, also while pages change."""
        end = time.monotonic() + (seconds or self.seconds)
        while time.monotonic() < end:
            try:
                if self.run(condition):
                    return True
            except Failure:
                if self.process.poll() is not None:
                    raise
            time.sleep(0.02)
        return False

    def wait(self, condition, seconds=60):
        if not self.wait_until(condition, seconds):
            raise Failure(f"the page never has: {condition}\n" + "\n".join(self.errors))

    def run(self, expression):
        """The value of an expression of JavaScript, of a promise when it is kept."""
        result = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in result:
            raise Failure(result["exceptionDetails"].get("exception", {}).get("description", "an exception"))
        return result["result"].get("value")

    def type_text(self, text):
        """Types into the element that has the focus."""
        self.call("Input.insertText", text=text)

    def dark(self, on=True):
        """Pages see a user who prefers dark colours."""
        self.call("Emulation.setEmulatedMedia",
                  features=[{"name": "prefers-color-scheme", "value": "dark" if on else "light"}])

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
