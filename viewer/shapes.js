// Forms that bodies with faces are drawn with: corners of triangles with normals, for a body of size 1.

const shape_names = ["sphere", "box", "capsule", "cylinder", "convex polyhedron", "triangle mesh", "plane"]; // of all runs
const shape = { sphere: 0, box: 1, capsule: 2, cylinder: 3, polyhedron: 4, mesh: 5, plane: 6 };

class form_builder {
  constructor() {
    this.points = [], this.normals = [], this.ends = [];
  }
  corner(point, normal, end = 0) {
    this.points.push(...point), this.normals.push(...normal), this.ends.push(end);
  }
  flat(a, b, c) {
    const u = b.map((x, k) => x - a[k]), v = c.map((x, k) => x - a[k]);
    const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const size = Math.hypot(...n) || 1, normal = n.map((x) => x / size);
    for (const p of [a, b, c]) this.corner(p, normal);
  }
  done() {
    return { points: new Float32Array(this.points), normals: new Float32Array(this.normals), ends: new Float32Array(this.ends) };
  }
}

function box_form() {
  const f = new form_builder();
  for (let axis = 0; axis < 3; ++axis)
    for (const side of [-0.5, 0.5]) {
      const p = (u, v) => {
        const x = [0, 0, 0];
        x[axis] = side, x[(axis + 1) % 3] = side < 0 ? v : u, x[(axis + 2) % 3] = side < 0 ? u : v;
        return x;
      };
      f.flat(p(-0.5, -0.5), p(0.5, -0.5), p(0.5, 0.5));
      f.flat(p(-0.5, -0.5), p(0.5, 0.5), p(-0.5, 0.5));
    }
  return f.done();
}

// A surface of revolution about z: `line` has [radius, z, normal across, normal along, end].
function turned_form(line, sides) {
  const f = new form_builder();
  const put = ([r, z, across, along, end], s) => {
    const angle = (2 * Math.PI * s) / sides, c = Math.cos(angle), n = Math.sin(angle);
    f.corner([r * c, r * n, z], [across * c, across * n, along], end);
  };
  for (let k = 0; k + 1 < line.length; ++k)
    for (let s = 0; s < sides; ++s) {
      const a = line[k], b = line[k + 1];
      for (const [p, side] of [[a, s], [a, s + 1], [b, s + 1], [a, s], [b, s + 1], [b, s]]) put(p, side);
    }
  return f.done();
}
const cylinder_form = () => turned_form([[0, -0.5, 0, -1, 0], [0.5, -0.5, 0, -1, 0], [0.5, -0.5, 1, 0, 0],
  [0.5, 0.5, 1, 0, 0], [0.5, 0.5, 0, 1, 0], [0, 0.5, 0, 1, 0]], 24);
function capsule_form() { // of radius 1, whose halves are moved apart
  const line = [];
  for (const end of [-1, 1])
    for (let k = 0; k <= 5; ++k) {
      const angle = (Math.PI / 10) * (end < 0 ? k - 5 : k), c = Math.cos(angle), s = Math.sin(angle);
      line.push([c, s, c, s, end]);
    }
  return turned_form(line, 16);
}
function plane_form() {
  const f = new form_builder();
  f.flat([-1, -1, 0], [1, -1, 0], [1, 1, 0]), f.flat([-1, -1, 0], [1, 1, 0], [-1, 1, 0]);
  return f.done();
}
// A surface of triangles that the run describes.
function surface_form({ points, corners }) {
  const f = new form_builder();
  const at = (i) => [points[3 * i], points[3 * i + 1], points[3 * i + 2]];
  for (let t = 0; t + 2 < corners.length; t += 3) f.flat(at(corners[t]), at(corners[t + 1]), at(corners[t + 2]));
  return f.done();
}
