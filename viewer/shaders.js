// How bodies and lines are drawn. Positions come as whole numbers of cells, as the page holds them,
// and two frames are mixed for the moments between them.

const shader_head = "precision highp float;\n";
const uniforms_of_view = "uniform mat4 viewMatrix, projectionMatrix;\n";
const shader_of_place = `
uniform vec3 lower, span, lower_next, span_next;
uniform float between;
attribute vec3 place, place_next;
vec3 centre() { return mix(lower + span * place, lower_next + span_next * place_next, between); }
`;
const shader_of_light = `
uniform float opacity;
vec3 lit(vec3 colour, vec3 normal) {
  float front = max(dot(normal, vec3(0.32, 0.55, 0.77)), 0.0);
  float gloss = max(dot(normal, vec3(0.17, 0.31, 0.935)), 0.0);
  gloss *= gloss, gloss *= gloss, gloss *= gloss, gloss *= gloss, gloss *= gloss;
  return colour * (0.42 + 0.62 * front) + 0.10 * gloss;
}
`;

// Spheres as points with the shading of a sphere: the fastest way, for many bodies. Their depth is
// that of their centre, and a sphere whose centre is outside of the picture is not drawn.
const points_shader = {
  vertex: shader_head + uniforms_of_view + shader_of_place + `
attribute float radius;
attribute vec4 colour;
uniform float pixels;
varying vec3 shade;
void main() {
  vec4 eye = viewMatrix * vec4(centre(), 1.0);
  gl_Position = projectionMatrix * eye;
  gl_PointSize = max(1.0, 2.0 * radius * pixels / max(-eye.z, 1e-12));
  shade = colour.rgb;
}`,
  fragment: "precision mediump float;\n" + `
uniform float opacity;
varying vec3 shade;
void main() {
  vec2 p = 2.0 * gl_PointCoord - 1.0;
  float rest = 1.0 - p.x * p.x - p.y * p.y;
  if (rest < 0.0) discard;
  float front = max(0.32 * p.x - 0.55 * p.y + 0.77 * sqrt(rest), 0.0);
  gl_FragColor = vec4(shade * (0.42 + 0.68 * front), opacity);
}`,
};

// Exact spheres: the ray of each pixel is cut with the sphere, and its depth is that of the surface.
const spheres_shader = {
  vertex: shader_head + uniforms_of_view + shader_of_place + `
attribute vec3 position;
attribute float radius;
attribute vec4 colour;
varying vec3 shade, middle, at;
varying float size;
void main() {
  vec4 eye = viewMatrix * vec4(centre(), 1.0);
  float d2 = dot(eye.xyz, eye.xyz), r2 = radius * radius;
  // A square across the line of sight that covers the outline of the sphere.
  vec3 front = normalize(eye.xyz), right = normalize(cross(front, vec3(0.0, 1.0, 0.0001)));
  float cover = radius * sqrt(d2 / max(d2 - r2, 0.01 * r2));
  at = eye.xyz + cover * (position.x * right + position.y * cross(right, front));
  shade = colour.rgb, middle = eye.xyz, size = radius;
  gl_Position = projectionMatrix * vec4(at, 1.0);
}`,
  fragment: "#extension GL_EXT_frag_depth : enable\n" + shader_head +
    "uniform mat4 projectionMatrix;\n" + shader_of_light + `
varying vec3 shade, middle, at;
varying float size;
void main() {
  vec3 ray = normalize(at);
  float along = dot(ray, middle), left = along * along - dot(middle, middle) + size * size;
  if (left < 0.0) discard;
  vec3 hit = (along - sqrt(left)) * ray;
  gl_FragColor = vec4(lit(shade, (hit - middle) / size), opacity);
#ifdef GL_EXT_frag_depth
  vec4 clip = projectionMatrix * vec4(hit, 1.0);
  gl_FragDepthEXT = clamp(0.5 + 0.5 * clip.z / clip.w, 0.0, 1.0);
#endif
}`,
};

// Bodies with faces. A point is scaled by \`extent\` and then moved along the axis of the body by
// \`stretch\`, which makes capsules from one form.
const solids_shader = {
  vertex: shader_head + uniforms_of_view + shader_of_place + `
attribute vec3 position, normal;
attribute float end;
attribute vec4 turn, turn_next, extent, colour;
uniform float gridded;
varying vec3 shade, facing, eye;
varying vec2 on_grid;
vec3 turned(vec4 q, vec3 v) { return v + 2.0 * cross(q.xyz, cross(q.xyz, v) + q.w * v); }
void main() {
  vec4 other = dot(turn, turn_next) < 0.0 ? -turn_next : turn_next;
  vec4 q = normalize(mix(turn, other, between));
  vec3 local = position * extent.xyz + vec3(0.0, 0.0, end * extent.w);
  vec4 e = viewMatrix * vec4(centre() + turned(q, local), 1.0);
  eye = e.xyz;
  facing = mat3(viewMatrix) * turned(q, normalize(normal / max(extent.xyz, vec3(1e-20))));
  shade = colour.rgb;
  on_grid = 10.0 * position.xy * gridded;
  gl_Position = projectionMatrix * e;
}`,
  fragment: "#extension GL_OES_standard_derivatives : enable\n" + shader_head + shader_of_light + `
uniform float gridded;
varying vec3 shade, facing, eye;
varying vec2 on_grid;
void main() {
  vec3 normal = normalize(facing);
  if (dot(normal, eye) > 0.0) {
    if (gridded > 0.5) discard; // a plane from behind would hide what it bears
    normal = -normal;
  }
  float solid = opacity;
#ifdef GL_OES_standard_derivatives
  if (gridded > 0.5) {
    vec2 near = abs(fract(on_grid + 0.5) - 0.5) / max(fwidth(on_grid), vec2(1e-6));
    solid = mix(opacity, min(1.0, opacity + 0.35), 1.0 - min(1.0, min(near.x, near.y)));
  }
#endif
  gl_FragColor = vec4(lit(shade, normal), solid);
}`,
};

// Lines of any width in pixels: a strip of two triangles along each.
const lines_shader = {
  vertex: shader_head + uniforms_of_view + `
attribute vec3 position, from, to;
attribute float width;
attribute vec4 colour;
uniform vec2 picture;
varying vec3 shade;
void main() {
  vec4 a = projectionMatrix * viewMatrix * vec4(from, 1.0), b = projectionMatrix * viewMatrix * vec4(to, 1.0);
  float near = 1e-6;
  if (a.w < near && b.w >= near) a = mix(b, a, (b.w - near) / (b.w - a.w));
  if (b.w < near && a.w >= near) b = mix(a, b, (a.w - near) / (a.w - b.w));
  vec2 way = (b.xy / b.w - a.xy / a.w) * picture;
  float length_of_way = length(way);
  vec2 across = length_of_way > 0.0 ? vec2(-way.y, way.x) / length_of_way : vec2(0.0, 1.0);
  vec4 p = position.x < 0.5 ? a : b;
  p.xy += across * position.y * width * p.w / picture;
  shade = colour.rgb;
  gl_Position = p;
}`,
  fragment: shader_head + `
uniform float opacity;
varying vec3 shade;
void main() { gl_FragColor = vec4(shade, opacity); }`,
};
