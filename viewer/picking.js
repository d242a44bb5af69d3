// Which body is under the pointer: the ray through a pixel against the bodies of a frame.

// Where a ray, in the frame of a body, meets its form; Infinity if it does not.
function ray_meets(kind, form, size, from, way) {
  if (kind.shape === shape.plane && way.z >= 0) return Infinity; // from behind it is not drawn
  if (kind.form >= 0) {
    let best = Infinity;
    const { points: p, corners: c } = form;
    const a = new THREE.Vector3(), b = new THREE.Vector3(), d = new THREE.Vector3(), hit = new THREE.Vector3();
    const ray = new THREE.Ray(from, way);
    for (let t = 0; t + 2 < c.length; t += 3) {
      a.fromArray(p, 3 * c[t]), b.fromArray(p, 3 * c[t + 1]), d.fromArray(p, 3 * c[t + 2]);
      if (ray.intersectTriangle(a, b, d, false, hit)) best = Math.min(best, hit.distanceTo(from));
    }
    return best;
  }
  let enter = 0, leave = Infinity;
  const f = from.toArray(), w = way.toArray();
  for (let k = 0; k < 3; ++k) {
    const half = kind.shape === shape.plane && k === 2 ? 0 : size[k] / 2;
    const s = (-half - f[k]) / w[k], t = (half - f[k]) / w[k];
    enter = Math.max(enter, Math.min(s, t)), leave = Math.min(leave, Math.max(s, t));
  }
  return enter <= leave ? enter : Infinity;
}

// Index of the body in `frame` that the ray meets first, or -1. Walls only where nothing else is met.
function body_on_ray(frame, forms, from, way, with_walls) {
  const t = frame.run.table, p = [0, 0, 0];
  const best = [Infinity, Infinity], found = [-1, -1];
  const centre = new THREE.Vector3(), turn = new THREE.Quaternion(), local = new THREE.Vector3(), along = new THREE.Vector3();
  for (let i = 0; i < frame.count; ++i) {
    const r = frame.rows[i], wall = t.flags[r] & 1;
    if (wall && !with_walls) continue;
    frame.place(i, p);
    const kind = { shape: t.shape[r], form: t.form[r] }, size = t.size.subarray(3 * r, 3 * r + 3);
    const reach = kind.shape === shape.sphere ? size[0] / 2 : kind.form >= 0 ? Infinity : 0.5 * Math.hypot(size[0], size[1], size[2]);
    const x = p[0] - from.x, y = p[1] - from.y, z = p[2] - from.z, near = x * way.x + y * way.y + z * way.z;
    const left = near * near - (x * x + y * y + z * z) + reach * reach;
    if (left < 0) continue;
    let at;
    if (kind.shape === shape.sphere && kind.form < 0) {
      at = near - Math.sqrt(left);
      if (at < 0) continue;
    } else {
      turn.fromArray(frame.turn(i)).conjugate();
      local.copy(from).sub(centre.fromArray(p)).applyQuaternion(turn);
      along.copy(way).applyQuaternion(turn);
      at = ray_meets(kind, forms[kind.form], size, local, along);
    }
    if (at < best[wall]) (best[wall] = at), (found[wall] = i);
  }
  return found[0] >= 0 ? found[0] : found[1];
}

// What the page says of a body.
function facts_of(frame, i) {
  const run = frame.run, t = run.table, r = frame.rows[i], rows = [];
  const put = (name, value) => rows.push([name, value]);
  const vector = (v) => v.map((x) => short_number(+x.toPrecision(5))).join(", ");
  const unit = (dimension) => unit_behind(dimension, run.about.units);
  const size = [...t.size.subarray(3 * r, 3 * r + 3)];
  put("body", "0x" + t.id[r].toString(16) + (t.part[r] > 0 ? ", part " + t.part[r] : ""));
  put("shape", run.name_of_shape(t.shape[r]) + (t.flags[r] & 2 ? ", global" : t.flags[r] & 1 ? ", fixed" : ""));
  if (t.shape[r] === shape.sphere) put("radius", short_number(size[0] / 2) + unit("L"));
  else if (t.shape[r] !== shape.plane) put("size", vector(size) + unit("L"));
  if (t.mass[r] > 0 && !(t.flags[r] & 1)) put("mass", short_number(+t.mass[r].toPrecision(5)) + unit("M"));
  put("material", run.name_of_material(t.material[r]).replace(/^material /, ""));
  if (!(t.flags[r] & 2)) put("rank", frame.rank[i]);
  put("position", vector(frame.place(i, [0, 0, 0])) + unit("L"));
  const error = frame.head.position_error;
  if (error > 0) put("", "± " + short_number(+error.toPrecision(2)) + " as stored");
  const v = frame.blocks.velocity;
  if (v && !(t.flags[r] & 2)) {
    put("velocity", vector([0, 1, 2].map((k) => v[3 * i + k] * frame.head.speed_cell)) + unit("L/T"));
    put("speed", short_number(+frame.speed(i).toPrecision(4)) + unit("L/T"));
  }
  if (frame.blocks.asleep && frame.blocks.asleep[i]) put("state", "asleep");
  if (frame.blocks.force) {
    const touching = frame.blocks.touching[i];
    put("contacts", touching < 255 ? touching : "255 or more");
    put("force", short_number(+frame.force(i).toPrecision(4)) + unit("M L/T^2") + " in all");
  }
  return rows;
}
