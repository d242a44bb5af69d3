// Where the browser renders by software, each point costs as much as on the screen, seen or not. So
// spheres that others hide are left out before: from front to back, each is drawn unless nearer ones
// cover all of its disc. The result is the picture of all of them.

const renders_by_software = (gl) => {
  const names = gl.getExtension("WEBGL_debug_renderer_info");
  return Boolean(names) && /swiftshader|llvmpipe|software|basic render/i.test(gl.getParameter(names.UNMASKED_RENDERER_WEBGL));
};

class hidden_spheres {
  constructor(room) {
    this.room = room;
    for (const name of ["x", "y", "r", "z"]) this[name] = new Float32Array(room);
    this.bucket = new Uint16Array(room), this.order = new Uint32Array(room), this.seen = new Uint32Array(room);
    this.starts = new Uint32Array(4097);
    this.covered = new Uint8Array(0);
  }
  // Fills `seen` with the numbers of the spheres to be drawn, nearest first, and returns how many there
  // are. The place of sphere i before the camera is rest + A p + B q, where p and q are its stored
  // numbers in two frames, and A and B (three rows of three) contain cells, camera and mixture.
  // `pixels` are those of a length 1 at distance 1.
  find(count, p, A, q, B, rest, radius, width, height, pixels) {
    const { x, y, r, z, bucket, order, seen, starts } = this;
    const [a0, a1, a2, a3, a4, a5, a6, a7, a8] = A, [c0, c1, c2] = rest, middle = width / 2, centre = height / 2;
    const [b0, b1, b2, b3, b4, b5, b6, b7, b8] = B || [];
    let near = Infinity, far = 0, sum = 0, here = 0;
    for (let i = 0, k = 0; i < count; ++i, k += 3) {
      const p0 = p[k], p1 = p[k + 1], p2 = p[k + 2];
      let u = c0 + a0 * p0 + a1 * p1 + a2 * p2, v = c1 + a3 * p0 + a4 * p1 + a5 * p2, w = c2 + a6 * p0 + a7 * p1 + a8 * p2;
      if (B) {
        const q0 = q[k], q1 = q[k + 1], q2 = q[k + 2];
        u += b0 * q0 + b1 * q1 + b2 * q2, v += b3 * q0 + b4 * q1 + b5 * q2, w += b6 * q0 + b7 * q1 + b8 * q2;
      }
      const depth = -w;
      z[i] = -1;
      if (depth <= 0) continue;
      const scale = pixels / depth, size = radius[i] * scale;
      u = middle + u * scale, v = centre - v * scale;
      if (u < 0 || v < 0 || u > width || v > height) continue; // points go with their centres
      x[i] = u, y[i] = v, r[i] = size > 0.5 ? size : 0.5, z[i] = depth;
      if (depth < near) near = depth;
      if (depth > far) far = depth;
      sum += size, ++here;
    }
    if (here === 0) return 0;
    // In the order of their depth, in 4096 steps.
    const scale = far > near ? 4095 / (far - near) : 0;
    starts.fill(0);
    for (let i = 0; i < count; ++i) if (z[i] >= 0) ++starts[(bucket[i] = ((z[i] - near) * scale) | 0) + 1];
    for (let k = 0; k < 4096; ++k) starts[k + 1] += starts[k];
    for (let i = 0; i < count; ++i) if (z[i] >= 0) order[starts[bucket[i]]++] = i;
    // Squares of the screen that are covered, of a third of the usual radius.
    const cell = Math.max(1, Math.min(8, Math.round(sum / here / 3)));
    const columns = Math.ceil(width / cell), lines = Math.ceil(height / cell);
    if (this.covered.length < columns * lines) this.covered = new Uint8Array(columns * lines);
    const covered = this.covered.fill(0);
    let drawn = 0;
    for (let k = 0; k < here; ++k) {
      const i = order[k], cx = x[i] / cell, cy = y[i] / cell, size = (r[i] + 0.5) / cell, square = size * size;
      const first = Math.max(0, Math.floor(cy - size)), last = Math.min(lines - 1, Math.floor(cy + size));
      let hidden = true;
      for (let line = first; hidden && line <= last; ++line) {
        const off = line > cy ? line - cy : line + 1 < cy ? cy - line - 1 : 0, half = Math.sqrt(Math.max(0, square - off * off));
        const to = line * columns + Math.min(columns - 1, Math.floor(cx + half));
        for (let at = line * columns + Math.max(0, Math.floor(cx - half)); at <= to; ++at)
          if (covered[at] === 0) {
            hidden = false;
            break;
          }
      }
      if (hidden) continue;
      seen[drawn++] = i;
      const inner = (r[i] - 0.5) / cell, inner_square = inner * inner; // what it surely covers
      for (let line = first; line <= last; ++line) {
        const off = Math.max(Math.abs(line - cy), Math.abs(line + 1 - cy));
        if (off >= inner) continue;
        const half = Math.sqrt(inner_square - off * off), to = Math.min(columns, Math.floor(cx + half));
        for (let c = Math.max(0, Math.ceil(cx - half)); c < to; ++c) covered[line * columns + c] = 1;
      }
    }
    return drawn;
  }
}
