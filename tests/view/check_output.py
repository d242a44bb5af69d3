"""Pages that ./dev view makes of the files of --output, and what it serves.

  check_output.py PROGRAM FOLDER ROOT     PROGRAM is the example hopper; ends with 77 without h5py or chromium
"""
import glob
import http.client
import json
import os
import pathlib
import shutil
import socket
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from browser import Browser, find_browser  # noqa: E402
from check_page import check, check_quiet, count_drawn, opened

READER = "/usr/bin/python3"  # Debian's h5py belongs to Debian's Python
TRUTH = """
import h5py, json, sys
with h5py.File(sys.argv[1]) as f:
    d, p = f["VTKHDF/PointData"], f["VTKHDF/Points"][:]
    print(json.dumps({"id": [str(i) for i in d["id"][:]], "x": p.tolist(), "v": d["velocity"][:].tolist()}))
"""


def view(root, *options, **more):
    environment = {**os.environ, "TALUS_NO_APT": "1"}
    return subprocess.run([os.path.join(root, "dev"), "view", *options], capture_output=True, text=True, env=environment, **more)


def page(browser, root):
    made = view(root, "two.hdf.series", "--csv", "two.csv")
    check(made.returncode == 0, "view: " + made.stderr)
    opened(browser, "two.html")
    check(browser.run("talus.frames()") == 4, "4 frames")
    browser.run("talus.show(3)")
    check(count_drawn(browser) > 1000, "bodies are drawn")
    truth = json.loads(subprocess.run([READER, "-c", TRUTH, sorted(glob.glob("two_0*.hdf"))[-1]], check=True, capture_output=True).stdout)
    shown = browser.run("""(() => { const f = talus.state.frame, t = f.run.table, all = {};
      for (let i = 0; i < f.count; ++i) all[t.id[f.rows[i]].toString()] = [f.place(i, [0, 0, 0]), f.speed(i)];
      return { error: f.head.position_error, all }; })()""")
    check(len(shown["all"]) == len(truth["id"]), "all bodies are in the page")
    for body, x, v in zip(truth["id"], truth["x"], truth["v"]):
        place, speed = shown["all"][body]
        check(max(abs(a - b) for a, b in zip(place, x)) <= shown["error"] * 1.0001, f"place of body {body}")
        check(abs(speed - sum(a * a for a in v) ** 0.5) < 1e-3, f"speed of body {body}")
    titles = browser.run("[...document.querySelectorAll('figcaption')].map((x) => x.firstChild.textContent)")
    for title in ("Energy", "Overlap", "Normal force"):
        check(title in titles, f"a plot '{title}' among {titles}")
    check_quiet(browser, "two.html")


def refusals(root):
    def refused(words, *options):
        made = view(root, *options)
        check(made.returncode != 0 and words in made.stderr and "Traceback" not in made.stderr,
              f"view {' '.join(options)} says: {made.stderr}")
    refused("there is no absent.hdf.series", "absent")
    with open("empty.hdf.series", "w") as f:
        f.write('{"file-series-version":"1.0","files":[]}')
    refused("lists no files", "empty")
    with open("broken.hdf.series", "w") as f:
        f.write("{")
    refused("is no index of an output", "broken")
    refused("cannot be written", "two", "--html", "no/page.html")
    with open("mine.html", "w") as f:
        f.write("precious")
    refused("is no page of talus", "two", "--html", "mine.html")
    refused("is no time series of talus", "two", "--csv", "mine.html")
    refused("--every takes 1 or more", "two", "--every", "0")
    refused("takes a port from 0 to 65535", "two", "--serve", "70000")
    check(open("mine.html").read() == "precious", "a file of the user stays")
    check(not glob.glob("*.part-*"), "nothing temporary is left")


ODD = """
import glob, h5py, numpy
bodies, contacts = (sorted(glob.glob(name)) for name in ("odd_0*.hdf", "odd_contacts_*.hdf"))
with h5py.File(bodies[0], "r+") as f:
    for name in ["Points"] + ["PointData/" + n for n in f["VTKHDF/PointData"]]:
        values = f["VTKHDF"][name][:0]
        del f["VTKHDF"][name]
        f["VTKHDF"][name] = values
for file, change in (contacts[-2], lambda x: numpy.concatenate([x[:1] * numpy.nan, x[1:]])), (contacts[-1], lambda x: 0 * x):
    with h5py.File(file, "r+") as f:
        force = f["VTKHDF/CellData/force"]
        force[...] = change(force[:])
"""


def odd(browser, root):
    """No bodies yet, forces that are not finite or all 0, and a line of the time series that is half written."""
    for file in glob.glob("two*.hdf*"):
        shutil.copyfile(file, "odd" + file[3:])
    with open("two.hdf.series") as f, open("odd.hdf.series", "w") as to:
        to.write(f.read().replace('"two_', '"odd_'))
    with open("two.csv") as f, open("odd.csv", "w") as to:
        to.write(f.read() + "10")
    subprocess.run([READER, "-c", ODD], check=True)
    made = view(root, "odd", "--csv", "odd.csv")
    check(made.returncode == 0, "view: " + made.stderr)
    opened(browser, "odd.html")
    for k, bodies in (0, False), (1, True), (3, True):
        browser.run(f"talus.show({k})")
        check(browser.run("talus.state.frame.count > 0") == bodies, f"bodies of frame {k}")
    check_quiet(browser, "odd.html")


def serving(browser, program, root):
    environment = {**os.environ, "TALUS_NO_APT": "1"}
    for file in glob.glob("live*"):
        os.unlink(file)
    server = subprocess.Popen([os.path.join(root, "dev"), "view", "live", "--serve", "0"], stdout=subprocess.PIPE, text=True,
                              env=environment)
    run = None
    try:
        address = server.stdout.readline().strip()
        check(address.startswith("http://127.0.0.1:") and address.endswith("/"), f"the address {address}")
        host, token = address.removeprefix("http://").strip("/").split("/")

        def ask(path, method="GET"):
            connection = http.client.HTTPConnection(host, timeout=60)
            connection.putrequest(method, path, skip_host=True)  # the path as it is
            connection.putheader("Host", host)
            connection.endheaders()
            answer = connection.getresponse()
            body = answer.read()
            connection.close()
            return answer.status, body
        check(ask("/")[0] == 403 and ask("/wrong/heads/0")[0] == 403 and ask("/")[1].find(token.encode()) < 0, "no token: 403")
        for path in ("/../live.hdf.series", "/frame/../../etc/passwd", "/frame/%2e%2e", "/heads/-1", "/heads/x", "/live.hdf.series",
                     "/frame/999", "//", "/heads/0/"):
            check(ask("/" + token + path)[0] == 404, f"{path}: 404")
        for method in ("POST", "PUT", "DELETE", "HEAD", "OPTIONS"):
            check(ask("/" + token + "/", method)[0] == 405, f"{method}: 405")
        check(ask("/" + token + "/heads/0") == (200, b'{"heads": [], "series": 1}'), "no frames yet")
        browser.errors.clear(), browser.requests.clear()
        browser.open(address)
        browser.wait("document.getElementById('message')?.textContent.includes('Waiting for the first frame')")
        run = subprocess.Popen([program, "--quiet", "--steps", "4000", "--bodies", "200", "--output", "live", "--output-every", "20"])
        browser.wait("window.talus && talus.ready && talus.frames() > 2", 120)
        frames = browser.run("talus.frames()")
        browser.wait(f"talus.frames() > {frames} && talus.state.frame.number > {frames - 1}", 120)
        check(count_drawn(browser) > 200, "a run under way is drawn")
        # Some that ask and do not read keep nobody else from reading.
        port = int(host.split(":")[1])
        stalled = [socket.create_connection(("127.0.0.1", port)) for _ in range(3)]
        for one in stalled:
            one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            one.sendall(f"GET /{token}/frame/0 HTTP/1.1\r\nHost: {host}\r\n\r\n".encode() * 400)
        time.sleep(0.5)
        check(ask("/" + token + "/heads/0")[0] == 200, "others are served")
        for one in stalled:
            one.close()
        foreign = [r for r in browser.requests if not r.startswith(address) and not r.startswith("data:")]
        check(not foreign and not browser.errors, f"requests {foreign}, errors {browser.errors}")
        run.kill(), run.wait()
        # The series begins again: the page does too.
        run = subprocess.Popen([program, "--quiet", "--steps", "40", "--bodies", "100", "--output", "live", "--output-every", "20"])
        run.wait()
        browser.wait("window.talus && talus.ready && talus.frames() === 3", 60)
    finally:
        if run:
            run.kill(), run.wait()
        server.terminate(), server.wait()


def main():
    program, folder, root = sys.argv[1:]
    if not find_browser() or not os.path.exists("/usr/share/javascript/three/three.min.js") or \
            subprocess.run([READER, "-c", "import h5py"], capture_output=True).returncode:
        print("skipped: no chromium, libjs-three or python3-h5py")
        sys.exit(77)
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    os.chdir(folder)
    subprocess.run([program, "--quiet", "--steps", "300", "--bodies", "300", "--output", "two", "--output-every", "100", "--output-surfaces",
                    "--csv", "two.csv", "--csv-every", "100"], check=True)
    refusals(root)
    print("refusals ok", flush=True)
    browser = Browser(size=(640, 700))
    try:
        page(browser, root)
        print("page ok", flush=True)
        odd(browser, root)
        print("odd files ok", flush=True)
        serving(browser, program, root)
        print("serving ok", flush=True)
    finally:
        browser.close()


if __name__ == "__main__":
    main()
