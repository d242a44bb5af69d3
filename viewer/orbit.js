// A camera that orbits about a point: by mouse, touch and keys.

class orbit {
  // `changed()` is called when the view has changed, `clicked(x, y)` for a click without a drag.
  constructor(canvas, camera, up, changed, clicked) {
    Object.assign(this, { canvas, camera, changed });
    this.target = new THREE.Vector3();
    this.distance = 10;
    this.angle = -0.7, this.height = 0.42; // radians: around `up` and above the horizon
    this.frame(up);
    const pointers = new Map();
    let moved = 0, spread = 0;
    const at = (e) => [e.clientX, e.clientY];
    canvas.addEventListener("pointerdown", (e) => {
      canvas.setPointerCapture(e.pointerId), canvas.focus({ preventScroll: true });
      pointers.set(e.pointerId, at(e)), spread = 0;
      if (pointers.size === 1) moved = 0;
    });
    canvas.addEventListener("pointermove", (e) => {
      const before = pointers.get(e.pointerId);
      if (!before) return;
      const [x, y] = at(e), dx = x - before[0], dy = y - before[1];
      pointers.set(e.pointerId, [x, y]), moved += Math.abs(dx) + Math.abs(dy);
      if (pointers.size === 2) {
        const [a, b] = [...pointers.values()], now = Math.hypot(a[0] - b[0], a[1] - b[1]);
        if (spread > 0 && now > 0) this.distance *= spread / now;
        spread = now;
        this.pan(dx / 2, dy / 2);
      } else if (e.shiftKey || e.ctrlKey || e.buttons & 6) this.pan(dx, dy);
      else this.turn(-dx * 0.006, dy * 0.006);
    });
    const release = (e) => {
      const one = pointers.size === 1 && pointers.has(e.pointerId);
      pointers.delete(e.pointerId), spread = 0;
      if (one && moved < 5 && e.type === "pointerup" && e.button === 0) {
        const box = canvas.getBoundingClientRect();
        clicked(e.clientX - box.left, e.clientY - box.top);
      }
    };
    canvas.addEventListener("pointerup", release);
    canvas.addEventListener("pointercancel", release);
    canvas.addEventListener("contextmenu", (e) => e.preventDefault());
    canvas.addEventListener("wheel", (e) => {
      e.preventDefault(), this.zoom(Math.exp(Math.max(-1, Math.min(1, e.deltaY * 0.002))));
    }, { passive: false });
    canvas.addEventListener("keydown", (e) => {
      const step = e.shiftKey ? 40 : 0.1;
      const act = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[e.key];
      if (act && e.shiftKey) this.pan(-act[0] * step, act[1] * step);
      else if (act) this.turn(act[0] * step, act[1] * step);
      else if (e.key === "+" || e.key === "=") this.zoom(0.85);
      else if (e.key === "-") this.zoom(1 / 0.85);
      else return;
      e.preventDefault();
    });
  }
  // Axes of the view for an upward direction.
  frame(up) {
    this.up = up.clone().normalize();
    const other = Math.abs(this.up.x) > 0.9 ? new THREE.Vector3(0, 1, 0) : new THREE.Vector3(1, 0, 0);
    this.side = other.sub(this.up.clone().multiplyScalar(other.dot(this.up))).normalize();
    this.front = this.up.clone().cross(this.side);
  }
  turn(around, over) {
    this.angle += around;
    this.height = Math.max(-1.55, Math.min(1.55, this.height + over));
    this.changed();
  }
  zoom(by) {
    this.distance *= by, this.changed();
  }
  pan(dx, dy) {
    const scale = (2 * this.distance * Math.tan((this.camera.fov * Math.PI) / 360)) / this.canvas.clientHeight;
    const e = this.camera.matrixWorld.elements;
    this.target.add(new THREE.Vector3(e[0], e[1], e[2]).multiplyScalar(-dx * scale));
    this.target.add(new THREE.Vector3(e[4], e[5], e[6]).multiplyScalar(dy * scale));
    this.changed();
  }
  // A camera at a place that looks at a point.
  look(from, at, up, fov) {
    this.frame(up);
    this.camera.fov = fov;
    const way = from.clone().sub(at);
    this.target.copy(at), this.distance = Math.max(way.length(), 1e-12);
    way.multiplyScalar(1 / this.distance);
    this.height = Math.max(-1.55, Math.min(1.55, Math.asin(Math.max(-1, Math.min(1, way.dot(this.up))))));
    this.angle = Math.atan2(way.dot(this.front), way.dot(this.side));
    this.changed();
  }
  move(x, y, z) {
    this.target.x += x, this.target.y += y, this.target.z += z;
    this.changed();
  }
  // Looks at a sphere, as near as it fits into the picture.
  fit(centre, radius) {
    const half = (this.camera.fov * Math.PI) / 360, wide = Math.atan(Math.tan(half) * Math.min(1, this.camera.aspect));
    this.target.copy(centre);
    this.distance = (1.02 * Math.max(radius, 1e-12)) / Math.sin(wide);
    this.changed();
  }
  apply() {
    const c = Math.cos(this.height), to = this.target, camera = this.camera;
    const way = new THREE.Vector3()
      .addScaledVector(this.side, c * Math.cos(this.angle))
      .addScaledVector(this.front, c * Math.sin(this.angle))
      .addScaledVector(this.up, Math.sin(this.height));
    camera.position.copy(to).addScaledVector(way, this.distance);
    camera.up.copy(this.up);
    camera.lookAt(to);
    camera.updateMatrixWorld();
  }
}
