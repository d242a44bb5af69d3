"""Pages in headless Chromium, by its DevTools protocol over a pipe: no packages of Python are needed.

  with Browser() as browser:
      browser.open("file:///...")       # waits until the page is loaded
      browser.evaluate("document.title")
      browser.errors                    # what went to the console as an error, since the last open()
"""
import base64
import fcntl
import json
import os
import select
import shutil
import signal
import subprocess
import tempfile
import time

NAMES = ("chromium", "chromium-browser", "google-chrome")


def program():
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
        self.seconds, self.number, self.errors, self.loaded, self.buffer = seconds, 0, [], False, b""
        self.profile = tempfile.TemporaryDirectory(prefix="talus_browser_")
        # Chromium reads commands from descriptor 3 and writes answers to 4.
        theirs_in, mine_out = map(above_ten, os.pipe())
        mine_in, theirs_out = map(above_ten, os.pipe())
        self.out, self.into = mine_out, mine_in
        # Root has no sandbox; the pages are our own.
        root = ["--no-sandbox"] if os.geteuid() == 0 else []
        self.process = subprocess.Popen(
            ["bash", "-c", f'exec "$@" 3<&{theirs_in} 4>&{theirs_out}', "bash", program(), "--headless=new",
             *root, "--remote-debugging-pipe", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
             "--disable-background-networking", "--disable-component-update", "--disable-sync", "--mute-audio",
             f"--user-data-dir={self.profile.name}", f"--window-size={size[0]},{size[1]}", "about:blank"],
            pass_fds=(theirs_in, theirs_out), stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL, start_new_session=True)
        os.close(theirs_in), os.close(theirs_out)
        self.session = None
        try:
            targets = self.send("Target.getTargets")["targetInfos"]
            page = next(t for t in targets if t["type"] == "page")
            self.session = self.send("Target.attachToTarget", targetId=page["targetId"], flatten=True)["sessionId"]
            for domain in ("Page", "Runtime", "Log", "Network"):
                self.send(f"{domain}.enable")
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

    def send(self, method, **parameters):
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
        elif event == "Log.entryAdded" and given["entry"]["level"] == "error":
            self.errors.append(f"{given['entry']['text']} {given['entry'].get('url', '')}")
        elif event == "Runtime.consoleAPICalled" and given["type"] in ("error", "assert"):
            self.errors.append(" ".join(str(a.get("value", a.get("description"))) for a in given["args"]))
        elif event == "Network.loadingFailed" and not given.get("canceled"):
            self.errors.append(f"not loaded: {given.get('errorText')}")

    def open(self, address):
        self.errors, self.loaded = [], False
        result = self.send("Page.navigate", url=address)
        if result.get("errorText"):
            raise Failure(f"{address}: {result['errorText']}")
        end = time.monotonic() + self.seconds
        while not self.loaded:
            self.receive(end, address)
        # The event may be that of the page before.
        page = json.dumps(address.partition("#")[0])
        if not self.wait_until(f"document.readyState === 'complete' && location.href.split('#')[0] === {page}"):
            raise Failure(f"{address}: not loaded within {self.seconds} s")

    def wait_until(self, expression):
        """Whether an expression of JavaScript becomes true in time, also while pages change."""
        end = time.monotonic() + self.seconds
        while time.monotonic() < end:
            try:
                if self.evaluate(expression):
                    return True
            except Failure:
                if self.process.poll() is not None:
                    raise
            time.sleep(0.02)
        return False

    def evaluate(self, expression):
        """The value of an expression of JavaScript, of a promise when it is kept."""
        result = self.send("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in result:
            raise Failure(result["exceptionDetails"].get("exception", {}).get("description", "an exception"))
        return result["result"].get("value")

    def type_text(self, text):
        """Types into the element that has the focus."""
        self.send("Input.insertText", text=text)

    def dark(self, on=True):
        """Pages see a user who prefers dark colours."""
        self.send("Emulation.setEmulatedMedia",
                  features=[{"name": "prefers-color-scheme", "value": "dark" if on else "light"}])

    def picture(self):
        """The visible part as the bytes of a PNG file."""
        return base64.b64decode(self.send("Page.captureScreenshot", format="png")["data"])
