// The picture: bodies in groups of one form, lines, and the camera.

const point_mode_above = 20000; // spheres: beyond this they are points

function material_of(shader, more = {}) {
  const uniforms = { opacity: { value: 1 } };
  for (const name of ["lower", "span", "lower_next", "span_next"]) uniforms[name] = { value: new THREE.Vector3() };
  for (const name of ["between", "gridded", "pixels"]) uniforms[name] = { value: 0 };
  uniforms.picture = { value: new THREE.Vector2(1, 1) };
  return new THREE.RawShaderMaterial({ vertexShader: shader.vertex, fragmentShader: shader.fragment, uniforms,
    side: THREE.DoubleSide, ...more });
}

// Bodies of one form, all walls or none.
class body_group {
  constructor(stage, kind, wall, count, spheres) {
    Object.assign(this, { stage, kind, wall });
    this.points = spheres && count > point_mode_above;
    this.spheres = spheres, this.room = Math.max(16, Math.ceil(1.2 * count));
    const shader = this.points ? points_shader : spheres ? spheres_shader : solids_shader;
    this.material = material_of(shader, { extensions: { fragDepth: spheres && !this.points, derivatives: !spheres } });
    this.material.uniforms.gridded.value = kind.shape === shape.plane ? 1 : 0;
    const g = (this.geometry = this.points ? new THREE.BufferGeometry() : new THREE.InstancedBufferGeometry());
    // three.js counts points by an attribute of this name, which no shader reads.
    if (this.points) this.put_fixed("position", new Uint8Array(this.room), 1);
    else {
      const form = spheres ? { points: new Float32Array([-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, -1, 0, 1, 1, 0, -1, 1, 0]) } : stage.form(kind);
      this.put_fixed("position", form.points, 3);
      if (!spheres) this.put_fixed("normal", form.normals, 3), this.put_fixed("end", form.ends, 1);
    }
    this.attribute("colour", new Uint8Array(4 * this.room), 4, true);
    if (spheres) this.attribute("radius", new Float32Array(this.room), 1);
    else this.attribute("extent", new Float32Array(4 * this.room), 4);
    this.object = new (this.points ? THREE.Points : THREE.Mesh)(g, this.material);
    this.object.frustumCulled = false;
    stage.scene.add(this.object);
  }
  put_fixed(name, values, width) {
    this.set_attribute(name, new THREE.BufferAttribute(values, width));
  }
  attribute(name, values, width, normalized = false) {
    const made = this.points ? new THREE.BufferAttribute(values, width, normalized)
      : new THREE.InstancedBufferAttribute(values, width, normalized);
    if (made.setUsage) made.setUsage(THREE.DynamicDrawUsage);
    this.set_attribute(name, made);
    return made;
  }
  set_attribute(name, made) {
    if (this.geometry.setAttribute) this.geometry.setAttribute(name, made);
    else this.geometry.addAttribute(name, made);
  }
  // Copies values into an attribute, which is made again if the type of number has changed.
  fill(name, values, width, normalized) {
    let a = this.geometry.attributes[name];
 const shared = name.endsWith("_next") && a === this.geometry.attributes[name.slice(0, -5)];
    if (!a || shared || a.array.constructor !== values.constructor)
      a = this.attribute(name, new values.constructor(width * this.room), width, normalized);
    a.array.set(values);
    this.update(a, values.length);
  }
  update(a, count) {
    if (a.updateRange) a.updateRange.offset = 0, a.updateRange.count = count;
    a.needsUpdate = true;
  }
  // Shows bodies [first, first + count) of a frame, mixed with those of `next`, if there is one.
  show(frame, next, first, count, part) {
    const u = this.material.uniforms, g = this.geometry;
    this.first = first, this.count = count;
    if (this.points) g.setDrawRange(0, g.index ? g.drawRange.count : count);
    else g.maxInstancedCount = g.instanceCount = count;
    const scale = (f, lower, span) => {
      const whole = f.blocks.position instanceof Uint16Array ? 65535 : 1;
      lower.value.fromArray(f.head.lower), span.value.fromArray(f.head.cell).multiplyScalar(whole);
    };
    u.between.value = next ? part : 0;
    // What came next is shown now: its positions are there already.
    if (this.shown !== frame && this.shown_next === frame && g.attributes.place_next !== g.attributes.place) {
      for (const name of this.spheres ? ["place"] : ["place", "turn"]) {
        const before = g.attributes[name];
        this.set_attribute(name, g.attributes[name + "_next"]), this.set_attribute(name + "_next", before);
      }
      scale(frame, u.lower, u.span);
      this.shown = frame, this.shown_next = null;
    }
    if (this.shown !== frame) {
      scale(frame, u.lower, u.span);
      const p = frame.blocks.position;
      this.fill("place", p.subarray(3 * first, 3 * (first + count)), 3, p instanceof Uint16Array);
      if (!this.spheres) this.fill("turn", this.turns(frame), 4, true);
      this.set_sizes(frame);
    }
    if (next && this.shown_next !== next) {
      scale(next, u.lower_next, u.span_next);
      const p = next.blocks.position;
      this.fill("place_next", p.subarray(3 * first, 3 * (first + count)), 3, p instanceof Uint16Array);
      if (!this.spheres) this.fill("turn_next", this.turns(next), 4, true);
    } else if (!next && g.attributes.place_next !== g.attributes.place) {
      this.set_attribute("place_next", g.attributes.place);
      if (!this.spheres) this.set_attribute("turn_next", g.attributes.turn);
    }
    this.shown = frame, this.shown_next = next;
  }
  turns(frame) {
    const at = frame.turned(this.first);
    return frame.blocks.orientation.subarray(4 * at, 4 * (at + this.count));
  }
  set_sizes(frame) {
    const rows = frame.rows;
    if (this.sized === rows && this.sized_first === this.first) return;
    this.sized = rows, this.sized_first = this.first;
    const size = frame.run.table.size;
    const a = this.geometry.attributes[this.spheres ? "radius" : "extent"];
    for (let k = 0; k < this.count; ++k) {
      const r = 3 * rows[this.first + k];
      if (this.spheres) a.array[k] = 0.5 * size[r];
      else a.array.set(this.stage.extent(this.kind, size[r], size[r + 1], size[r + 2]), 4 * k);
    }
    this.update(a, a.array.length);
  }
  // Leaves out the points that others hide. Positions are mixed as in the shader.
  hide(view, width, height, pixels) {
    const g = this.geometry, u = this.material.uniforms, a = g.attributes;
    // Where most are seen, as in a thin cloud, the search does not pay: it pauses for some pictures.
    if (this.pause > 0) --this.pause;
    if (this.material.transparent || this.pause > 0) {
      if (g.index) g.setIndex(null), g.setDrawRange(0, this.count);
      return;
    }
    this.hidden ??= new hidden_spheres(this.room);
    const place = a.place.array, next = a.place_next.array, t = u.between.value, rest = [view[12], view[13], view[14]];
    const rows = (values, lower, span, part) => {
      const scale = part * (values instanceof Uint16Array ? 1 / 65535 : 1), l = lower.toArray(), s = span.toArray(), out = [];
      for (let k = 0; k < 3; ++k)
        for (let c = 0; c < 3; ++c) rest[k] += part * view[4 * c + k] * l[c], out.push(scale * view[4 * c + k] * s[c]);
      return out;
    };
    const A = rows(place, u.lower.value, u.span.value, 1 - t), B = t > 0 ? rows(next, u.lower_next.value, u.span_next.value, t) : null;
    const drawn = this.hidden.find(this.count, place, A, next, B, rest, a.radius.array, width, height, pixels);
    if (drawn > 0.4 * this.count) this.pause = 60;
    if (!g.index) {
      const made = new THREE.BufferAttribute(new Uint32Array(this.room), 1);
      if (made.setUsage) made.setUsage(THREE.DynamicDrawUsage);
      g.setIndex(made);
    }
    g.index.array.set(this.hidden.seen.subarray(0, drawn));
    this.update(g.index, drawn), g.setDrawRange(0, drawn);
  }
  dispose() {
    this.stage.scene.remove(this.object);
    this.geometry.dispose(), this.material.dispose();
  }
}

// Lines between points.
class line_group {
  constructor(stage) {
    this.stage = stage, this.room = 0;
    this.material = material_of(lines_shader, { depthTest: true });
  }
  show(count, from, to, width, colour, front) {
    if (count > this.room || !this.object) {
      if (this.object) this.stage.scene.remove(this.object), this.geometry.dispose();
      this.room = Math.max(16, Math.ceil(1.3 * count));
      const g = (this.geometry = new THREE.InstancedBufferGeometry());
      const put = (name, made) => (g.setAttribute ? g.setAttribute(name, made) : g.addAttribute(name, made));
      put("position", new THREE.BufferAttribute(new Float32Array([0, -1, 0, 1, -1, 0, 1, 1, 0, 0, -1, 0, 1, 1, 0, 0, 1, 0]), 3));
      put("from", new THREE.InstancedBufferAttribute(new Float32Array(3 * this.room), 3));
      put("to", new THREE.InstancedBufferAttribute(new Float32Array(3 * this.room), 3));
      put("width", new THREE.InstancedBufferAttribute(new Float32Array(this.room), 1));
      put("colour", new THREE.InstancedBufferAttribute(new Uint8Array(4 * this.room), 4, true));
      this.object = new THREE.Mesh(g, this.material);
      this.object.frustumCulled = false;
      this.stage.scene.add(this.object);
    }
    const g = this.geometry, a = g.attributes;
    g.maxInstancedCount = g.instanceCount = count;
    for (const [name, values] of Object.entries({ from, to, width, colour }))
      a[name].array.set(values), (a[name].needsUpdate = true);
    this.material.depthTest = !front;
    this.object.renderOrder = front ? 3 : 1;
    this.object.visible = count > 0;
  }
  hide() {
    if (this.object) this.object.visible = false;
  }
}

class picture_stage {
  constructor(canvas, run) {
    Object.assign(this, { canvas, run });
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: !run.heads.some((h) => h.bodies > point_mode_above), alpha: true, preserveDrawingBuffer: false });
    this.renderer.setClearColor(0, 0);
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(40, 1, 0.1, 1000);
    this.groups = [], this.forms = new Map();
    this.lines = { contacts: new line_group(this), joints: new line_group(this), domains: new line_group(this) };
  }
  form(kind) {
    const key = kind.form >= 0 ? "run " + kind.form : kind.shape;
    if (!this.forms.has(key)) {
      const made = kind.form >= 0 ? surface_form(this.run.forms[kind.form])
        : { [shape.capsule]: capsule_form, [shape.cylinder]: cylinder_form, [shape.plane]: plane_form }[kind.shape]?.() || box_form();
      this.forms.set(key, made);
    }
    return this.forms.get(key);
  }
  // Scale of the form along its three axes, and half the distance of a capsule's ends.
  extent(kind, x, y, z) {
    if (kind.form >= 0) return [1, 1, 1, 0];
    if (kind.shape === shape.capsule) return [x / 2, y / 2, x / 2, (z - x) / 2];
    if (kind.shape === shape.plane) return [x / 2, y / 2, 1, 0];
    return [x, y, z, 0];
  }
  // The runs of bodies of one kind, in the order of the frame.
  static kinds(frame) {
    const t = frame.run.table, all = [];
    let last = null;
    for (let i = 0; i < frame.count; ++i) {
      const r = frame.rows[i], wall = t.flags[r] & 1, s = t.shape[r], f = t.form[r];
      if (last && last.wall === wall && last.kind.shape === s && last.kind.form === f) ++last.count;
      else all.push((last = { kind: { shape: s, form: f }, wall, first: i, count: 1 }));
    }
    return all;
  }
  show(frame, next, part) {
    if (this.rows !== frame.rows) {
      this.rows = frame.rows;
      this.kinds = picture_stage.kinds(frame);
      const keep = new Map(this.groups.map((g) => [g.key, g]));
      this.groups = this.kinds.map((k) => {
        const key = [k.kind.shape, k.kind.form, k.wall, k.first].join();
        const spheres = k.kind.shape === shape.sphere && k.kind.form < 0;
        let g = keep.get(key);
        if (g && (g.room < k.count || g.points !== (spheres && k.count > point_mode_above))) g = null;
        if (g) keep.delete(key), (g.shown = g.shown_next = null);
        else g = new body_group(this, k.kind, k.wall, k.count, spheres), (g.key = key);
        return g;
      });
      for (const g of keep.values()) g.dispose();
    }
    this.groups.forEach((g, n) => g.show(frame, next, this.kinds[n].first, this.kinds[n].count, part));
  }
  // Colours of all bodies: four bytes each.
  paint(colours) {
    for (const g of this.groups) {
      const a = g.geometry.attributes.colour;
      a.array.set(colours.subarray(4 * g.first, 4 * (g.first + g.count)));
      g.update(a, 4 * g.count);
    }
  }
  look({ walls, ghost, background }) {
    for (const g of this.groups) {
      const opacity = g.wall ? walls : ghost ? 0.25 : 1, clear = opacity < 1;
      g.material.uniforms.opacity.value = opacity;
      if (g.material.transparent !== clear) g.material.transparent = clear, (g.material.needsUpdate = true);
      g.material.depthWrite = !clear;
      g.object.visible = opacity > 0;
      g.object.renderOrder = clear ? 2 : 0;
    }
  }
  render(control, radius) {
    const width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    const ratio = Math.min(2, window.devicePixelRatio || 1);
    if (width !== this.width || height !== this.height) {
      this.width = width, this.height = height;
      this.renderer.setPixelRatio(ratio), this.renderer.setSize(width, height, false);
      this.camera.aspect = width / Math.max(1, height);
    }
    control.apply();
    // Near and far planes hold the scene, as close as its depth allows.
    const away = this.camera.position.distanceTo(this.centre), far = away + 1.5 * radius;
    this.camera.far = far * 1.01, this.camera.near = Math.max(away - 1.5 * radius, far * 2e-4);
    this.camera.updateProjectionMatrix();
    const pixels = (ratio * height) / 2 / Math.tan((this.camera.fov * Math.PI) / 360);
    for (const g of this.groups) g.material.uniforms.pixels.value = pixels;
    if (this.by_software === undefined) this.by_software = renders_by_software(this.renderer.getContext());
    if (this.by_software) {
      this.camera.matrixWorldInverse.getInverse(this.camera.matrixWorld);
      for (const g of this.groups)
        if (g.points && g.object.visible) g.hide(this.camera.matrixWorldInverse.elements, ratio * width, ratio * height, pixels);
    }
    for (const l of Object.values(this.lines)) l.material.uniforms.picture.value.set((ratio * width) / 2, (ratio * height) / 2);
    this.renderer.render(this.scene, this.camera);
  }
}
