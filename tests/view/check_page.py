"""Pages of --view in a headless browser: what must be seen is at the pixels where it must be.

  check_page.py PROGRAM FOLDER     PROGRAM is view_scenes; ends with 77 where there is no chromium
"""
import json
import math
import os
import pathlib
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from browser import Browser, find_browser  # noqa: E402

WIDTH, HEIGHT = 640, 700
FAR = 20.0  # of the camera


def check(condition, text):
    if not condition:
        sys.exit("FAILED: " + text)


def page_of(program, folder, name, *options):
    file = os.path.join(folder, name + ".html")
    subprocess.run([program, "--quiet", "--scene", name, "--view", file, *options], check=True)
    return file


def opened(browser, file):
    browser.errors.clear(), browser.requests.clear()
    browser.open(pathlib.Path(file).resolve().as_uri())
    browser.wait("window.talus && talus.ready")


def look_along_y(browser):
    """A camera at (2, -FAR, 0) that looks along y."""
    browser.run(f"talus.control.target.set(2, 0, 0); talus.control.distance = {FAR}; talus.control.angle = -Math.PI / 2;"
                "talus.control.height = 0; talus.redraw()")


def drawn(browser):
    """Waits until the picture is up to date."""
    browser.run("(async () => { for (let k = 0; k < 3; ++k) await new Promise(requestAnimationFrame); })()")


def size_of_canvas(browser):
    return browser.run("[document.getElementById('canvas').clientWidth, document.getElementById('canvas').clientHeight]")


def projected(x, z, width, height):
    """The pixel of (x, 0, z) by that camera: an opening of 40 degrees from bottom to top."""
    scale = height / 2 / math.tan(math.radians(20)) / FAR
    return width / 2 + (x - 2) * scale, height / 2 - z * scale


def is_red(pixel):
    return pixel[0] > 70 and pixel[0] > 2 * pixel[1] and pixel[0] > 2 * pixel[2]


def check_sphere(browser, x, text):
    """The sphere of radius 1 at (x, 0, 0) is a red disc in the picture."""
    drawn(browser)
    width, height = size_of_canvas(browser)
    u, v = projected(x, 0, width, height)
    radius = height / 2 / math.tan(math.radians(20)) / math.sqrt(FAR**2 - 1)
    picture = browser.screenshot()
    row = [is_red(picture.at(k, round(v))) for k in range(width)]
    column = [is_red(picture.at(round(u), k)) for k in range(int(height))]
    for line, middle, name in ((row, u, "row"), (column, v, "column")):
        check(any(line), f"{text}: no red pixel in the {name} of the sphere")
        first, last = line.index(True), len(line) - 1 - line[::-1].index(True)
        check(abs((first + last + 1) / 2 - middle) < 1.6 and abs(last + 1 - first - 2 * radius) < 3,
              f"{text}: red from {first} to {last} in the {name}, expected {middle - radius:.1f} to {middle + radius:.1f}")
        check(all(line[first:last + 1]), f"{text}: a hole in the {name} of the sphere")
    return u, v


def check_quiet(browser, file):
    check(not browser.errors, "the console of the browser says:\n" + "\n".join(browser.errors))
    own = pathlib.Path(file).resolve().as_uri()
    foreign = [r for r in browser.requests if r != own and not r.startswith("data:")]
    check(not foreign, "the page asks for " + ", ".join(foreign))


def known(browser, program, folder):
    file = page_of(program, folder, "known", "--steps", "100", "--dt", "0.01", "--view-every", "10")
    opened(browser, file)
    check(browser.run("talus.frames()") == 11, "11 frames")
    look_along_y(browser)
    browser.run("talus.choose_colour('rank')")
    check_sphere(browser, 0, "the first frame")
    # The slider moves the body.
    slide = "(document.getElementById('slider').value = {0}, document.getElementById('slider').dispatchEvent(new Event('input')))"
    browser.run(slide.format(10))
    browser.wait("talus.state.frame.number === 10")
    check_sphere(browser, 4, "the last frame")
    browser.run(slide.format(5))
    browser.wait("talus.state.frame.number === 5")
    u, v = check_sphere(browser, 2, "the middle frame")
    browser.run("talus.show(5.5)")
    check_sphere(browser, 2.2, "between two frames")
    browser.run("talus.show(5)")
    # A click shows the data of the body, one beside it hides them.
    browser.click(u, v)
    shown = "document.getElementById('body').hidden ? '' : document.getElementById('body').innerText"
    browser.wait(f"({shown}).includes('radius')")
    facts = dict(line.split("\t") for line in browser.run(shown).split("\n") if "\t" in line)
    check(facts["shape"] == "sphere" and facts["radius"] == "1" and facts["rank"] == "0", f"facts of the body: {facts}")
    check(abs(float(facts["position"].split(",")[0]) - 2) < 1e-3, f"position of the body: {facts}")
    check(abs(float(facts["speed"]) - 4) < 1e-2, f"speed of the body: {facts}")
    drawn(browser)
    check(not is_red(browser.screenshot().at(round(u), round(v))), "a picked body has another colour")
    browser.click(u, v + 0.4 * (v - 20))
    browser.wait(f"({shown}) === ''")
    # A drag turns the camera, keys too, and the wheel of the mouse goes nearer.
    angle = browser.run("talus.control.angle")
    browser.drag(u, v + 60, 50, 0)
    check(abs(browser.run("talus.control.angle") - angle) > 0.1, "a drag turns the camera")
    angle = browser.run("talus.control.angle")
    for kind in ("keyDown", "keyUp"):
        browser.call("Input.dispatchKeyEvent", type=kind, key="ArrowLeft", code="ArrowLeft", windowsVirtualKeyCode=37)
    check(browser.run("talus.control.angle") != angle, "an arrow key turns the camera")
    browser.call("Input.dispatchMouseEvent", type="mouseWheel", x=u, y=v, deltaX=0, deltaY=-200)
    browser.wait(f"talus.control.distance < {FAR} * 0.9")
    # Play goes on to the end.
    browser.run("talus.show(0)")
    browser.run("document.getElementById('speed').value = '10', document.getElementById('speed').onchange(), "
                "document.getElementById('play').click()")
    browser.wait("!talus.state.playing && talus.state.frame.number === 10")
    titles = browser.run("[...document.querySelectorAll('figcaption')].map((x) => x.firstChild.textContent)")
    for title in ("Energy", "Largest speed", "Time per phase"):
        check(title in titles, f"a plot '{title}' among {titles}")
    check_quiet(browser, file)


def count_drawn(browser):
    """Pixels of the picture that have a body or a line: the canvas is clear elsewhere."""
    return browser.run("""(() => {
      const s = talus.stage, gl = s.renderer.getContext(), w = gl.drawingBufferWidth, h = gl.drawingBufferHeight;
      s.render(talus.control, talus.state.reach);
      const pixels = new Uint8Array(4 * w * h);
      gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
      let n = 0;
      for (let k = 3; k < pixels.length; k += 4) n += pixels[k] > 0;
      return n; })()""")


def shapes(browser, program, folder):
    file = page_of(program, folder, "shapes", "--steps", "300", "--ranks", "4", "--view-every", "100", "--view-contacts")
    opened(browser, file)
    check(browser.run("talus.run.heads[0].ranks") == 4, "4 ranks")
    browser.run("talus.show(3)")
    kinds = browser.run("talus.stage.kinds.map((k) => [k.kind.shape, k.wall])")
    for shape in range(5):
        check([shape, 0] in kinds, f"bodies of shape {shape} among {kinds}")
    for shape in (1, 5, 6):
        check([shape, 1] in kinds, f"a wall of shape {shape} among {kinds}")
    # Each group is seen when it is alone.
    for k, kind in enumerate(kinds):
        browser.run(f"talus.stage.groups.forEach((g, n) => (g.object.visible = n === {k})), "
                    "Object.values(talus.stage.lines).forEach((l) => l.hide())")
        check(count_drawn(browser) > 30, f"bodies of shape {kind} are drawn")
    browser.run("talus.stage.groups.forEach((g) => (g.object.visible = false))")
    check(count_drawn(browser) == 0, "nothing is drawn when all is hidden")
    for name in ("contacts", "joints", "domains"):
        browser.run(f"for (const other of ['contacts', 'joints', 'domains']) document.getElementById(other).checked = other === '{name}';"
                    "talus.state.relink = true; talus.show(2).then(() => talus.show(3))")
        browser.run("talus.show(3)")
        browser.run("talus.stage.groups.forEach((g) => (g.object.visible = false))")
        check(count_drawn(browser) > 30, f"lines of {name} are drawn")
    # Colours by all that there is, and a legend for numbers.
    modes = browser.run("[...document.getElementById('colour').options].map((o) => o.value)")
    check(modes == ["rank", "speed", "size", "material", "force"], f"colours by {modes}")
    seen = set()
    for mode in modes:
        browser.run(f"talus.choose_colour('{mode}')")
        colours = browser.run("(() => { const g = talus.stage.groups.find((x) => !x.wall); "
                              "return [...g.geometry.attributes.colour.array.subarray(0, 4 * g.count)]; })()")
        seen.add(json.dumps(colours))
        check(browser.run("document.getElementById('legend').hidden") == (mode in ("rank", "material")), f"legend of {mode}")
    check(len(seen) == len(modes), "each way to colour has colours of its own")
    # The ray through the centre of a body meets it, or one before it.
    far = browser.run("""(() => {
      const f = talus.state.frame, c = document.getElementById('canvas'), bad = [];
      for (let i = 0; i < f.count; ++i) {
        if (f.run.table.flags[f.rows[i]] & 1) continue;
        const p = new THREE.Vector3(...f.place(i, [0, 0, 0])), d = p.distanceTo(talus.stage.camera.position);
        const s = p.clone().project(talus.stage.camera);
        const k = talus.pick((s.x + 1) / 2 * c.clientWidth, (1 - s.y) / 2 * c.clientHeight);
        const q = k < 0 ? null : new THREE.Vector3(...f.place(k, [0, 0, 0]));
        if (k !== i && !(q && !(f.run.table.flags[f.rows[k]] & 1) && q.distanceTo(talus.stage.camera.position) < d + 1)) bad.push([i, k, f.run.table.shape[f.rows[i]]]);
      }
      return bad; })()""")
    check(not far, f"bodies that a click does not find: {far}")
    titles = browser.run("[...document.querySelectorAll('figcaption')].map((x) => x.firstChild.textContent)")
    for title in ("Overlap", "Contact residual", "Imbalance", "Time per rank: respond"):
        check(title in titles, f"a plot '{title}' among {titles}")
    check_quiet(browser, file)


def look(browser, program, folder):
    """The view of the program: its camera follows a body, and materials have names and colours."""
    file = page_of(program, folder, "look", "--steps", "100", "--dt", "0.01", "--ranks", "2", "--view-every", "10")
    opened(browser, file)
    check(browser.run("talus.state.mode") == "material", "materials are told apart from the beginning")
    names = browser.run("[...document.querySelectorAll('#names li')].map((x) => [x.textContent, x.querySelector('i').style.background])")
    check(browser.run("+document.getElementById('walls').value") == 0.35, "walls are as in pictures")
    check(["grass", "rgb(26, 204, 26)"] in names and ["sky <blue>", "rgb(26, 51, 230)"] in names, f"names {names}")
    check(["material 0 (walls)", "rgb(168, 160, 148)"] in names, f"walls are in the legend: {names}")

    captions = browser.run("[...document.querySelectorAll('figcaption')].map((x) => [x.firstChild.textContent, x.lastChild.textContent])")
    check(["Energy", "<kg> mm²/s²"] in captions and ["Largest speed", "mm/s"] in captions, f"units {captions}")
    check(["way", "mm s"] in captions, f"units of a value of the program: {captions}")

    def camera():
        drawn(browser)
        return browser.run("[...talus.stage.camera.position.toArray(), ...talus.control.target.toArray()]")

    def ball():
        return browser.run("(() => { const f = talus.state.frame; return f.place(f.index_of_id(talus.state.followed), [0, 0, 0]); })()")
    for frame in (0, 10, 4):
        browser.run(f"talus.show({frame})")
        x, y, z = ball()
        check(all(abs(a - b) < 1e-3 for a, b in zip(camera(), [x, y - 9, z + 4, x, y, z])), f"camera of frame {frame}: {camera()}")
    check(-1.6 < ball()[0] < -1.1, f"the ball moves: {ball()}")
    # The ball is in the middle of the picture, and green.
    drawn(browser)
    width, height = size_of_canvas(browser)
    pixel = browser.screenshot().at(round(width / 2), round(height / 2))
    check(pixel[1] > 80 and pixel[1] > 2 * pixel[0] and pixel[1] > 2 * pixel[2], f"the ball is {pixel}")
    # Without following, the camera stays; a picked body is followed on request.
    browser.click(width / 2, height / 2)
    browser.wait("!document.getElementById('body').hidden")
    check("grass" in browser.run("document.getElementById('body').innerText"), "the data of a body name its material")
    browser.run("document.getElementById('follow').click()")
    before = camera()
    browser.run("talus.show(8)")
    check(camera() == before, "the camera stays")
    browser.run("document.getElementById('follow').click()")
    browser.run("talus.show(9)")
    check(abs(camera()[0] - before[0] - 0.2 * 5 / 7) < 0.02, "the camera moves again with the ball, which rolls")
    # Planes are drawn from their front alone.
    plane = browser.run("talus.stage.kinds.findIndex((k) => k.kind.shape === 6)")
    for height, seen in (0.5, True), (-0.5, False):
        browser.run(f"talus.control.height = {height}; talus.stage.groups.forEach((g, n) => (g.object.visible = n === {plane}));"
                    "Object.values(talus.stage.lines).forEach((l) => l.hide())")
        check((count_drawn(browser) > 1000) == seen, f"a plane from the height {height}")
    check_quiet(browser, file)


def leaves(browser, program, folder):
    """Bodies that leave, and the units of the program."""
    file = page_of(program, folder, "leaves", "--steps", "100", "--dt", "0.01", "--view-every", "10")
    opened(browser, file)
    numbers = browser.run("talus.run.heads.map((h) => h.bodies).join(' ')").split()
    check(int(numbers[0]) > int(numbers[-1]), f"bodies leave: {numbers}")
    text = browser.run("document.getElementById('facts').textContent")
    check(text == f"{numbers[-1]} to {numbers[0]} bodies, 1 rank, 11 frames", f"the head of the page: {text}")
    browser.run("talus.show(3)")
    drawn(browser)
    text = browser.run("document.getElementById('time').textContent")
    check(text.startswith("t = 0.3 s "), f"the time has its unit: {text}")
    look_along_y(browser)
    width, height = size_of_canvas(browser)
    browser.click(*projected(1.2, 0, width, height))
    shown = "document.getElementById('body').innerText"
    browser.wait(f"({shown}).includes('radius')")
    facts = dict(line.split("\t") for line in browser.run(shown).split("\n") if "\t" in line)
    check(facts["radius"] == "1 m" and facts["speed"] == "4 m/s" and facts["mass"].endswith(" kg"), f"units: {facts}")
    check_quiet(browser, file)


def many(browser, program, folder):
    file = page_of(program, folder, "many", "--bodies", "21000", "--steps", "2", "--view-every", "1")
    opened(browser, file)
    check(browser.run("talus.stage.groups[0].points"), "many spheres are points")
    drawn(browser)
    check(count_drawn(browser) > 20000, "many spheres are drawn")
    browser.run("talus.show(1)")
    check(count_drawn(browser) > 20000, "many spheres are drawn in another frame")
    check_quiet(browser, file)


def main():
    program, folder = sys.argv[1:]
    if not find_browser():
        print("skipped: no chromium")
        sys.exit(77)
    if not os.path.exists(os.environ.get("TALUS_THREE") or "/usr/share/javascript/three/three.min.js"):
        print("skipped: no libjs-three")
        sys.exit(77)
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    browser = Browser(size=(WIDTH, HEIGHT))
    try:
        for scene in (known, shapes, look, leaves, many):
            scene(browser, program, folder)
            print(scene.__name__, "ok", flush=True)
    finally:
        browser.close()


if __name__ == "__main__":
    main()
