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
  // are. `view` are the elements of the camera's view matrix, `pixels` those of a length 1 at distance 1.
  find(count, position_of, radius, view, width, height, pixels) {
    const { x, y, r, z, bucket, order, seen, starts } = this, p = [0, 0, 0];
    let near = Infinity, far = 0, sum = 0, here = 0;
    for (let i = 0; i < count; ++i) {
      position_of(i, p);
      const a = p[0], b = p[1], c = p[2];
      const depth = -(view[2] * a + view[6] * b + view[10] * c + view[14]);
      z[i] = -1;
      if (depth <= 0) continue;
      const scale = pixels / depth, size = radius[i] * scale;
      const u = width / 2 + (view[0] * a + view[4] * b + view[8] * c + view[12]) * scale;
      const v = height / 2 - (view[1] * a + view[5] * b + view[9] * c + view[13]) * scale;
      if (u < 0 || v < 0 || u > width || v > height) continue; // points go with their centres
      x[i] = u, y[i] = v, r[i] = Math.max(0.5, size), z[i] = depth;
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
