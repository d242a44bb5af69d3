"""How fast a page is drawn by a browser that renders by software.

  measure.py PAGE [PICTURE.png]

Prints pictures per second, and the processor time of all processes of the browser for each picture,
which depends less on what else the machine does.
"""
import os
import pathlib
import sys

from browser import Browser

TURN = """(async () => { let n = 0; const t = performance.now();
  while (performance.now() - t < 5000) { talus.control.turn(0.02, 0); await new Promise(requestAnimationFrame); ++n; }
  return [n, (performance.now() - t) / 1000]; })()"""
LOAD = "(async () => { for (let k = 0; k < talus.frames(); ++k) await talus.show(k); await talus.show(0); })()"
PLAY = """(async () => { const d = talus.state.drawn, t = performance.now(); talus.toggle();
  while (talus.state.playing && performance.now() - t < 9000) await new Promise(requestAnimationFrame);
  return [talus.state.drawn - d, (performance.now() - t) / 1000]; })()"""


def processor_seconds(root):
    """Of a process and its descendants."""
    children, used, total, todo = {}, {}, 0, [root]
    for p in filter(str.isdigit, os.listdir("/proc")):
        try:
            fields = pathlib.Path(f"/proc/{p}/stat").read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        children.setdefault(int(fields[1]), []).append(int(p))
        used[int(p)] = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    while todo:
        p = todo.pop()
        total += used.get(p, 0)
        todo += children.get(p, [])
    return total


def main():
    browser = Browser(size=(1200, 1000))
    try:
        browser.open(pathlib.Path(sys.argv[1]).resolve().as_uri())
        browser.wait("window.talus && talus.ready", 120)
        print(browser.run("document.getElementById('facts').textContent"), ", canvas ",
              browser.run("document.getElementById('canvas').width + ' x ' + document.getElementById('canvas').height"), sep="")
        for name, script in (("turning the view", TURN), ("playing", PLAY)):
            if script is PLAY:
                browser.run(LOAD)
            before = processor_seconds(browser.process.pid)
            pictures, seconds = browser.run(script)
            used = processor_seconds(browser.process.pid) - before
            print(f"{name}: {pictures / seconds:.1f} pictures/s, {1000 * used / pictures:.0f} ms of processor a picture, "
                  f"load of the machine {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors")
        if len(sys.argv) > 2:
            browser.screenshot(sys.argv[2])
    finally:
        browser.close()


if __name__ == "__main__":
    main()
