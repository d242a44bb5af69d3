#pragma once
// The page of --view, from the files of viewer/: written by viewer/page.py.

// clang-format off
namespace talus::detail {

inline constexpr const char* view_page_before_three[] = {
    R"page(<!doctype html>
<html lang="en">
<!-- talus view 1: a page that shows a run of talus; docs/view.md -->
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:; connect-src 'self'">
<title>talus</title>
<link rel="icon" href="data:,">
<style>
:root { --ink: #1c2530; --soft: #5d6b7a; --line: #d8dee6; --paper: #f5f7fa; --card: #fff; --accent: #1f6fb2; }
* { box-sizing: border-box; }
[hidden] { display: none !important; }
html, body { margin: 0; background: var(--paper); color: var(--ink); font: 14px/1.4 system-ui, "DejaVu Sans", sans-serif; }
#stage { position: relative; height: 68vh; min-height: 320px; background: linear-gradient(#e9eff6, #fbfcfe); overflow: hidden; }
#canvas { position: absolute; inset: 0; width: 100%; height: 100%; display: block; outline: none; touch-action: none; cursor: grab; }
#canvas:active { cursor: grabbing; }
aside { position: absolute; background: rgba(255, 255, 255, .88); border: 1px solid var(--line); border-radius: 8px; padding: 10px 12px; }
#options { top: 10px; left: 10px; width: 190px; display: flex; flex-direction: column; gap: 6px; }
#options h1 { font-size: 16px; margin: 0; overflow-wrap: anywhere; }
#options p { margin: 0; color: var(--soft); font-size: 12px; }
#options label { display: flex; align-items: center; gap: 6px; }
#options select, #options input[type=range] { flex: 1; min-width: 0; }
#legend div { display: flex; justify-content: space-between; font-size: 11px; color: var(--soft); font-variant-numeric: tabular-nums; }
#names { list-style: none; margin: 0; padding: 0; max-height: 130px; overflow-y: auto; font-size: 12px; color: var(--soft); overflow-wrap: anywhere; }
#names i { display: inline-block; width: 10px; height: 10px; margin-right: 6px; border-radius: 2px; }
#ramp { width: 100%; height: 10px; display: block; border-radius: 3px; }
#body { top: 10px; right: 10px; min-width: 210px; max-width: 300px; font-variant-numeric: tabular-nums; }
#body tr:first-child td { padding-right: 18px; }
#body table { border-collapse: collapse; font-size: 13px; width: 100%; }
#body th { text-align: left; font-weight: 500; color: var(--soft); padding: 1px 10px 1px 0; vertical-align: top; white-space: nowrap; }
#body td { overflow-wrap: anywhere; }
#follow { margin-top: 6px; font-size: 12px; padding: 2px 8px; }
#follow[aria-pressed=true] { background: var(--accent); color: #fff; }
#close { position: absolute; top: 4px; right: 4px; border: 0; background: none; font-size: 18px; line-height: 1; padding: 4px 8px; }
#rate { position: absolute; right: 10px; bottom: 6px; margin: 0; font-size: 11px; color: var(--soft); font-variant-numeric: tabular-nums; pointer-events: none; }
#message { position: absolute; left: 50%; bottom: 30px; transform: translateX(-50%); margin: 0; background: #fff3cd; border: 1px solid #e6cf7a; border-radius: 6px; padding: 6px 12px; max-width: 80%; }
#bar { position: sticky; bottom: 0; z-index: 2; display: flex; align-items: center; gap: 8px; padding: 8px 12px; background: var(--card); border-block: 1px solid var(--line); }
#slider { flex: 1; min-width: 80px; accent-color: var(--accent); }
#time { font-variant-numeric: tabular-nums; white-space: nowrap; min-width: 15em; }
button { font: inherit; border: 1px solid var(--line); background: var(--card); border-radius: 6px; padding: 4px 10px; cursor: pointer; color: var(--ink); }
button:hover { border-color: var(--accent); }
select { font: inherit; border: 1px solid var(--line); border-radius: 6px; background: var(--card); padding: 2px 4px; color: var(--ink); }
:focus-visible { outline: 2px solid var(--accent); outline-offset: 1px; }
#canvas:focus-visible { outline: none; }
#plots { display: grid; grid-template-columns: repeat(auto-fill, minmax(320px, 1fr)); gap: 12px; padding: 12px; }
figure { margin: 0; background: var(--card); border: 1px solid var(--line); border-radius: 8px; padding: 10px 12px 6px; }
figcaption { font-weight: 600; font-size: 13px; display: flex; justify-content: space-between; gap: 8px; }
figcaption span { font-weight: 400; color: var(--soft); }
figure svg { width: 100%; height: 170px; display: block; }
figure svg text { font-size: 10px; fill: var(--soft); font-variant-numeric: tabular-nums; }
figure ul { display: flex; flex-wrap: wrap; gap: 2px 12px; margin: 2px 0 0; padding: 0; list-style: none; font-size: 11px; color: var(--soft); font-variant-numeric: tabular-nums; }
figure i { display: inline-block; width: 10px; height: 3px; margin-right: 4px; vertical-align: middle; border-radius: 1px; }
#notes { padding: 0 14px 24px; color: var(--soft); font-size: 12px; max-width: 100ch; }
#notes p { margin: 4px 0; overflow-wrap: anywhere; }
@media (max-width: 700px) { #options { width: 150px; font-size: 12px; } #time { min-width: 0; } }
</style>
</head>
<body>
<main>
  <section id="stage">
    <canvas id="canvas" tabindex="0" aria-label="The bodies of the run in space"></canvas>
    <aside id="options">
      <h1 id="name">talus</h1>
      <p id="facts"></p>
      <label>Colour <select id="colour"></select></label>
      <ul id="names" hidden></ul>
      <div id="legend" hidden><canvas id="ramp" width="160" height="10"></canvas><div><span id="least"></span><span id="most"></span></div></div>
      <label id="walls_row">Walls <input id="walls" type="range" min="0" max="1" step="0.05" value="0.25"></label>
      <label id="contacts_row"><input id="contacts" type="checkbox"> Contact forces</label>
      <label id="joints_row"><input id="joints" type="checkbox" checked> Joints</label>
      <label id="domains_row"><input id="domains" type="checkbox"> Domains</label>
      <label id="ghost_row"><input id="ghost" type="checkbox"> Bodies half transparent</label>
      <button id="home" title="Show everything (Home)">Fit view</button>
    </aside>
    <aside id="body" hidden><button id="close" aria-label="Close">&times;</button><table></table><button id="follow" title="The camera moves with the body">Follow</button></aside>
    <p id="rate" aria-hidden="true"></p>
    <p id="message" hidden></p>
  </section>
  <nav id="bar">
    <button id="back" title="One frame back (,)">&#8249;</button>
    <button id="play" title="Play or pause (space)">&#9654;</button>
    <button id="forth" title="One frame on (.)">&#8250;</button>
    <input id="slider" type="range" min="0" max="0" value="0" step="1" aria-label="Frame">
    <output id="time"></output>
    <label>Speed <select id="speed"></select></label>
  </nav>
  <section id="plots"></section>
  <section id="notes"></section>
</main>
<script>
)page",
};

inline constexpr const char* view_page_before_data[] = {
    R"page(
</script>
<script>
const talus_view = (() => {
"use strict";
// Colours of bodies: ramps for numbers, a list of hues for ranks and materials.

// From HSV, each in [0, 1], to bytes.
function colour_of_hue(hue, saturation = 0.75, brightness = 0.9) {
  const part = (n) => {
    const k = (n + hue * 6) % 6;
    return Math.round(255 * brightness * (1 - saturation * Math.max(0, Math.min(k, 4 - k, 1))));
  };
  return [part(5), part(3), part(1)];
}
// Colours of neighbouring numbers differ: steps of the golden ratio around the circle of hues.
const colour_of_number = (n) => colour_of_hue((n * 0.6180339887498949) % 1);

// A ramp of 256 colours through the given ones.
function ramp_through(stops) {
  const table = new Uint8Array(256 * 3);
  for (let i = 0; i < 256; ++i) {
    const at = (i / 255) * (stops.length - 1), k = Math.min(stops.length - 2, Math.floor(at));
    for (let c = 0; c < 3; ++c) table[3 * i + c] = stops[k][c] + (at - k) * (stops[k + 1][c] - stops[k][c]);
  }
  return table;
}
const viridis = ramp_through([[68, 1, 84], [71, 45, 123], [59, 82, 139], [44, 114, 142], [33, 145, 140],
  [40, 174, 128], [94, 201, 98], [173, 220, 48], [253, 231, 37]]);
const heat = ramp_through([[86, 130, 176], [126, 110, 170], [190, 70, 110], [226, 70, 45], [240, 140, 20], [250, 200, 40]]);
const grey_of_wall = [168, 160, 148];

const colour_of_material = (run, k) => run.materials[k]?.colour?.map((x) => Math.round(255 * x)) || colour_of_number(k);

// The first of these that a run has: what the program tells apart, ranks, other materials.
const usual_modes = (run) => [...(run.materials.some((m) => m.name || m.colour) ? ["material"] : []),
  ...(run.most("ranks") > 1 ? ["rank"] : []), "material", "speed"];

// What bodies may be coloured by. `value(frame, i)` is a number; `range(run)` its least and largest
// value; modes without a range have one colour for each number, which the legend lists.
const colour_modes = {
  rank: { label: "rank", fits: (run) => run.has("rank"), value: (f, i) => f.rank[i],
    colour: (run, k) => colour_of_number(k), name: (run, k) => "rank " + k,
    listed: (run) => [...Array(run.most("ranks")).keys()] },
  speed: { label: "speed", fits: (run) => run.has("velocity"), ramp: viridis, value: (f, i) => f.speed(i),
    range: (run) => [0, run.look?.fastest || run.most("speed_max")] },
  size: { label: "size", fits: () => true, ramp: viridis, value: (f, i) => f.run.reach(f.rows[i]),
    range: (run) => run.sizes() },
  material: { label: "material", fits: (run) => run.has("material"), value: (f, i) => f.run.table.material[f.rows[i]],
    colour: (run, k) => (k < 0 ? grey_of_wall : colour_of_material(run, k)),
    name: (run, k) => (k < 0 ? run.name_of_material(-1 - k) + " (walls)" : run.name_of_material(k)), listed: (run) => run.materials_in_use(),
    own_colour: (run, k) => Boolean(run.materials[k]?.colour) },
  force: { label: "force", fits: (run) => run.has("forces"), ramp: heat, value: (f, i) => f.force(i),
    range: (run) => [0, 6 * run.most("force_mean")] },
};

// The run in the page: frames with their heads, decoded when they are shown.
// docs/view.md describes the blocks of a frame.

const number_types = { u8: Uint8Array, u16: Uint16Array, i16: Int16Array, u32: Uint32Array, i32: Int32Array,
  f32: Float32Array, u64: BigUint64Array };
const none = 0xffffffff; // in place of a body: a contact's or joint's partner that has no row

function bytes_of_base64(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const chars = atob(text), bytes = new Uint8Array(chars.length);
  for (let i = 0; i < chars.length; ++i) bytes[i] = chars.charCodeAt(i);
  return bytes;
}

// Properties of bodies that do not change; frames add rows and refer to them.
const columns_of_table = { id: ["u64", 1], shape: ["u8", 1], flags: ["u8", 1], material: ["u16", 1], part: ["u32", 1],
  form: ["i32", 1], size: ["f32", 3], mass: ["f32", 1] };
class body_table {
  constructor() {
    this.length = 0;
    for (const [name, [type, width]] of Object.entries(columns_of_table))
      this[name] = new number_types[type](width * 16);
  }
  append(blocks) {
    const n = blocks.new_id.length;
    for (const [name, [type, width]] of Object.entries(columns_of_table)) {
      const needs = width * (this.length + n);
      if (this[name].length < needs) {
        const larger = new number_types[type](2 * needs);
        larger.set(this[name]);
        this[name] = larger;
      }
      this[name].set(blocks["new_" + name], width * this.length);
    }
    this.length += n;
  }
}

// One moment of the run.
class moment {
  constructor(run, number, head, blocks, rows, rank) {
    Object.assign(this, { run, number, head, blocks, rows, rank });
    this.count = rows.length;
  }
  // Position of body i, into `to`.
  place(i, to) {
    const p = this.blocks.position, l = this.head.lower, c = this.head.cell;
    for (let k = 0; k < 3; ++k) to[k] = l[k] + c[k] * p[3 * i + k];
    return to;
  }
  speed(i) {
    const v = this.blocks.velocity;
    const x = v[3 * i], y = v[3 * i + 1], z = v[3 * i + 2];
    return Math.sqrt(x * x + y * y + z * z) * this.head.speed_cell;
  }
  // The number of body i among those with an orientation, i.e. all that are no spheres; -1: none.
  turned(i) {
    if (!this.turns) {
      this.turns = new Int32Array(this.count);
      let n = 0;
      for (let k = 0; k < this.count; ++k) this.turns[k] = this.run.table.shape[this.rows[k]] === 0 ? -1 : n++;
    }
    return this.turns[i];
  }
  // Quaternion x, y, z, w of body i.
  turn(i) {
    const n = this.turned(i), q = this.blocks.orientation;
    return n < 0 || !q ? [0, 0, 0, 1] : [0, 1, 2, 3].map((k) => q[4 * n + k] / 32767);
  }
  // Sum of the sizes of the contact forces on body i.
  force(i) {
    const f = this.blocks.force;
    if (!f) return 0;
    return f[i] * (this.run.table.flags[this.rows[i]] & 1 ? this.head.wall_force_cell : this.head.body_force_cell);
  }
  // Index of a body, of a union its first part, by its id, or -1.
  index_of_id(id) {
    const { id: ids, part } = this.run.table;
    return this.rows.findIndex((r) => ids[r] === id && part[r] === 0);
  }
  // Index of a body by its row, or -1.
  index_of(row) {
    return this.rows.indexOf(row);
  }
}

class run_data {
  // `heads` of the frames; `fetch(k)` gives the bytes that belong to head k, or a promise of them. Some
  // heads only add rows to the table: `all` has them, too, and `places` tells where those of frames are.
  constructor(about, heads, fetch) {
    Object.assign(this, { about, fetch });
    this.all = [], this.heads = [], this.places = [];
    this.add(heads);
    const told = { ...about, ...about.end };
    this.materials = told.materials || [], this.look = told.look, this.colour = told.colour || told.look?.colour;
    this.table = new body_table();
    this.forms = [];
    this.filled = 0; // heads whose rows are in the table
    this.cache = new Map();
    this.room = 256 << 20; // bytes of decoded frames that are kept
    this.held = 0;
  }
  add(heads) {
    for (const h of heads) {
      if (!h.table) this.heads.push(h), this.places.push(this.all.length);
      this.all.push(h);
    }
  }
  // Whether any frame has such data.
  has(what) {
    const block = { contacts: "contact_a", joints: "joint_a", forces: "force" }[what] || what;
    if (what === "material") return this.materials.some((m) => m.name || m.colour) ||
      new Set(this.table.material.subarray(0, this.table.length)).size > 1;
    if (what === "rank") return this.heads.some((h) => h.blocks.rank) || this.heads.every((h) => h.ranks === 1);
    return this.heads.some((h) => (block === "domains" ? h.domains && h.domains.length > 1 : h.blocks[block] && h.blocks[block][2] > 0));
  }
  most(name) {
    return Math.max(0, ...this.heads.map((h) => h[name] || 0));
  }
  // The shapes that the run has beside those of all runs have the numbers after them.
  name_of_shape(k) {
    if (k < shape_names.length) return shape_names[k];
    const told = { ...this.about, ...this.about.end }, own = told.shapes || this.heads.find((h) => h.shapes)?.shapes || "";
    return own.split("\n")[k - shape_names.length]?.replaceAll("_", " ") || "own";
  }
  name_of_material(k) {
    return this.materials[k]?.name || "material " + k;
  }
  // The numbers of the materials in the table, and after them -1 - k for each material k of walls that
  // has no colour of its own: such walls are grey.
  materials_in_use() {
    const t = this.table, used = new Set(), grey = new Set();
    for (let r = 0; r < t.length; ++r) {
      const k = t.material[r];
      if (t.flags[r] & 1 && !this.materials[k]?.colour) grey.add(-1 - k);
      else used.add(k);
    }
    return [...[...used].sort((a, b) => a - b), ...[...grey].sort((a, b) => b - a)];
  }
  // Least and largest size of the movable bodies.
  sizes() {
    let least = Infinity, most = 0;
    for (let r = 0; r < this.table.length; ++r) {
      if (this.table.flags[r] & 1) continue;
      const s = this.reach(r);
      least = Math.min(least, s), most = Math.max(most, s);
    }
    return least > most ? [0, 1] : [least, most];
  }
  // Half of the largest length of a row's body.
  reach(row) {
    const s = this.table.size;
    return 0.5 * Math.max(s[3 * row], s[3 * row + 1], s[3 * row + 2]);
  }
  async blocks_of(k) {
    const kept = this.cache.get(k);
    if (kept) {
      this.cache.delete(k), this.cache.set(k, kept);
      return kept;
    }
    const bytes = await this.fetch(k), blocks = {};
    for (const [name, [type, at, n]] of Object.entries(this.all[k].blocks))
      blocks[name] = new number_types[type](bytes.buffer, bytes.byteOffset + at, n);
    this.cache.set(k, blocks), this.held += bytes.byteLength;
    blocks.bytes = bytes.byteLength;
    for (const [old, other] of this.cache) {
      if (this.held <= this.room || old === k) break;
      this.cache.delete(old), this.held -= other.bytes;
    }
    return blocks;
  }
  // Frame k with all that it shares with earlier ones.
  async load(k) {
    const place = this.places[k];
    for (; this.filled <= place; ++this.filled) {
      const head = this.all[this.filled];
      if (!head.blocks.new_id) continue;
      const blocks = await this.blocks_of(this.filled);
      this.table.append(blocks);
      for (const form of head.forms || [])
        this.forms.push({ points: blocks["form_points_" + form], corners: blocks["form_corners_" + form] });
    }
    const blocks = await this.blocks_of(place);
    let at = place;
    while (!this.all[at].blocks.rows) --at;
    const rows = at === place ? blocks.rows : (await this.blocks_of(at)).rows;
    const rank = blocks.rank || new Uint16Array(rows.length);
    return new moment(this, k, this.heads[k], blocks, rows, rank);
  }
  domains_at(k) {
    let at = this.places[k];
    while (at >= 0 && !this.all[at].domains) --at;
    return at < 0 ? [] : this.all[at].domains;
  }
}

// The run that the page contains, or that its server sends.
function read_run() {
  const elements = (name) => [...document.querySelectorAll("script." + name)];
  const about = JSON.parse(document.querySelector("script.talus-about").textContent);
  const last = document.querySelector("script.talus-end");
  if (last) about.end = JSON.parse(last.textContent);
  if (about.live)
    return new run_data(about, [], async (k) => {
      const answer = await fetch("frame/" + k);
      if (!answer.ok) throw new Error("the server does not send frame " + k + " (" + answer.status + ")");
      return new Uint8Array(await answer.arrayBuffer());
    });
  const heads = elements("talus-head").map((e) => JSON.parse(e.textContent)), data = elements("talus-data");
  return new run_data(about, heads, (k) => bytes_of_base64(data[k].textContent.trim()));
}

// A camera that orbits about a point: by mouse, touch and keys.

class orbit {
  // `changed()` is called when the view has changed, `clicked(x, y)` for a click without a drag.
  constructor(canvas, camera, up, changed, clicked)page",
    R"page() {
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
    const [a0, a1, a2, a3, a)page",
    R"page(4, a5, a6, a7, a8] = A, [c0, c1, c2] = rest, middle = width / 2, centre = height / 2;
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
    if (this.sized === rows && this.sized_first === this.first) return;)page",
    R"page(
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
  )page",
    R"page(if (t.shape[r] === shape.sphere) put("radius", short_number(size[0] / 2) + unit("L"));
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

// Plots of the run over time, as SVG.

const svg_space = "http://www.w3.org/2000/svg";
const line_colours = ["#1f6fb2", "#d1495b", "#2a9d5c", "#e08e0b", "#7a4fb5", "#2bb3c0", "#8c6d46", "#c2549d"];

function svg_element(name, attributes, parent, text) {
  const e = document.createElementNS(svg_space, name);
  for (const [key, value] of Object.entries(attributes)) e.setAttribute(key, value);
  if (text !== undefined) e.textContent = text;
  if (parent) parent.appendChild(e);
  return e;
}
function short_number(x) {
  if (x === 0 || !Number.isFinite(x)) return String(x);
  const size = Math.abs(x);
  return size >= 1e5 || size < 1e-3 ? x.toExponential(size >= 1e5 ? 2 : 1) : String(+x.toPrecision(4));
}
// Round numbers between two limits.
function ticks_between(low, high, about) {
  const rough = (high - low) / about, power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((k) => k * power >= rough), all = [];
  for (let x = Math.ceil(low / step) * step; x <= high + 1e-9 * step; x += step) all.push(Math.abs(x) < 1e-9 * step ? 0 : x);
  return all;
}

// What is plotted: names of values in the heads, by figure. What a run has not is left out.
const figures = [
  { title: "Energy", unit: "M L²/T²", names: { kinetic_energy: "kinetic", potential_energy: "potential", energy_elastic: "elastic (contacts)",
    energy_of_motion: "kinetic + potential", total_energy: "sum" } },
  { title: "Energy book", unit: "M L²/T²", names: { energy_work: "work", energy_friction: "friction", energy_impact: "impacts",
    energy_damping: "damping", energy_correction: "position correction", energy_scheme: "time stepping", energy_sleep: "sleep",
    energy_motors: "motors", energy_springs: "springs of joints", energy_joint_friction: "friction of joints" } },
  { title: "Error of the energy book", unit: "", log: true, names: { energy_error: "error" } },
  { title: "Overlap", unit: "mean radii", log: true, names: { penetration_mean: "mean", penetration_max: "largest" } },
  { title: "Overlap by the monitor", unit: "mean radii", log: true,
    names: { overlap_mean: "mean", overlap_max: "largest", overlap_worst: "worst step" } },
  { title: "Contact residual", unit: "", log: true, names: { contact_residual: "all contacts", contact_residual_max: "worst contact",
    contact_residual_worst: "worst step" } },
  { title: "Momentum balance", unit: "", log: true, names: { momentum_error: "error" } },
  { title: "Weight borne by contacts", unit: "over the weight", names: { borne_weight: "borne" } },
  { title: "Largest speed", unit: "L/T", names: { max_speed: "speed" } },
  { title: "Bodies and contacts", unit: "", names: { bodies: "bodies", contacts: "contacts" } },
  { title: "Normal force", unit: "M L/T²", names: { normal_force_mean: "mean", normal_force_max: "largest" } },
];

// A dimension in the units that the program names.
const in_units = (dimension, units) => dimension.replace(/\b[MLT]\b/g, (letter) => units?.[letter] || letter);
// The unit behind a number; empty if the program names none.
const unit_behind = (dimension, units) => {
  const unit = in_units(dimension, units);
  return unit === dimension ? "" : " " + unit;
};

class plot {
  constructor(parent, { title, unit, log }, times, lines) {
    Object.assign(this, { times, lines });
    const positive = lines.flatMap((l) => l.values).filter((v) => v > 0);
    this.log = Boolean(log) && positive.length > 0;
    const figure = document.createElement("figure");
    const caption = document.createElement("figcaption");
    caption.append(title);
    const after = document.createElement("span");
    after.textContent = unit;
    caption.append(after);
    this.width = 360, this.height = 170;
    const svg = svg_element("svg", { viewBox: "0 0 " + this.width + " " + this.height, role: "img", "aria-label": title });
    this.box = { left: 54, right: 352, top: 8, bottom: 148 };
    this.scale();
    this.draw(svg);
    this.cursor = svg_element("line", { y1: this.box.top, y2: this.box.bottom, stroke: "#5d6b7a", "stroke-dasharray": "3 3" }, svg);
    this.list = document.createElement("ul");
    this.values = lines.map((l) => {
      const item = document.createElement("li"), mark = document.createElement("i"), value = document.createElement("span");
      mark.style.background = l.colour, item.append(mark, l.name + " ", value), this.list.append(item);
      return value;
    });
    figure.append(caption, svg, this.list), parent.append(figure);
    svg.addEventListener("click", (e) => {
      const r = svg.getBoundingClientRect(), scale = Math.min(r.width / this.width, r.height / this.height);
      const x = (e.clientX - r.left - (r.width - scale * this.width) / 2) / scale, b = this.box;
      this.chosen?.(this.first + ((x - b.left) / (b.right - b.left)) * (this.last - this.first));
    });
  }
  scale() {
    const finite = this.lines.flatMap((l) => l.values).filter((v) => Number.isFinite(v) && (!this.log || v > 0));
    this.low = Math.min(...finite), this.high = Math.max(...finite);
    if (this.log) {
      this.low = Math.max(this.low, this.high * 1e-12);
      if (this.high / this.low < 10) this.low /= 3, this.high *= 3;
    } else {
      const room = 0.04 * (this.high - this.low) || Math.abs(this.high) * 0.1 || 1;
      this.low -= this.low === 0 ? 0 : room, this.high += room;
    }
    this.first = this.times[0], this.last = this.times[this.times.length - 1];
    if (!(this.last > this.first)) this.last = this.first + 1;
  }
  x(time) {
    return this.box.left + ((time - this.first) / (this.last - this.first)) * (this.box.right - this.box.left);
  }
  y(value) {
    const part = this.log ? Math.log(Math.max(value, this.low) / this.low) / Math.log(this.high / this.low)
      : (value - this.low) / (this.high - this.low);
    return this.box.bottom - part * (this.box.bottom - this.box.top);
  }
  draw(svg) {
    const b = this.box;
    const decades = (Math.log10(this.high / this.low) || 1) / 4;
    const levels = this.log
      ? ticks_between(Math.log10(this.low), Math.log10(this.high), 4).filter((t) => decades < 0.25 || Number.isInteger(t)).map((t) => 10 ** t)
      : ticks_between(this.low, this.high, 4);
    for (const v of levels) {
      const y = this.y(v);
      svg_element("line", { x1: b.left, x2: b.right, y1: y, y2: y, stroke: "#e3e8ee" }, svg);
      svg_element("text", { x: b.left - 5, y: y + 3, "text-anchor": "end" }, svg, short_number(+v.toPrecision(6)));
    }
    for (const t of ticks_between(this.first, this.last, 5)) {
      svg_element("line", { x1: this.x(t), x2: this.x(t), y1: b.bottom, y2: b.bottom + 3, stroke: "#aab4c0" }, svg);
      svg_element("text", { x: this.x(t), y: b.bottom + 13, "text-anchor": "middle" }, svg, short_number(+t.toPrecision(6)));
    }
    svg_element("line", { x1: b.left, x2: b.right, y1: b.bottom, y2: b.bottom, stroke: "#aab4c0" }, svg);
    for (const l of this.lines) {
      let path = "", open = false;
      l.values.forEach((v, k) => {
        const drawn = Number.isFinite(v) && (!this.log || v > 0);
        if (drawn) path += (open ? "L" : "M") + this.x(this.times[k]).toFixed(1) + " " + this.y(v).toFixed(1);
        open = drawn;
      });
      svg_element("path", { d: path, fill: "none", stroke: l.colour, "stroke-width": 1.6, "stroke-linejoin": "round" }, svg);
    }
  }
  show(k) {
    const x = this.x(this.times[k]);
    this.cursor.setAttribute("x1", x), this.cursor.setAttribute("x2", x);
    this.lines.forEach((l, n) => (this.values[n].textContent = Number.isFinite(l.values[k]) ? short_number(l.values[k]) : "–"));
  }
}

// All plots that the run has values for.
function draw_plots(parent, run) {
  parent.replaceChildren();
  const heads = run.heads.map((h) => h.values || {}), times = run.heads.map((h) => h.time), all = [];
  if (heads.length < 2) return all;
  for (const v of heads)
    if (v.kinetic_energy !== undefined && v.potential_energy !== undefined) {
      // Without the energy of springs in contacts the sum of the two is not what a run conserves.
      const sum = v.kinetic_energy + v.potential_energy, elastic = v.energy_elastic;
      v[elastic === undefined && run.about.soft !== false ? "energy_of_motion" : "total_energy"] = sum + (elastic || 0);
    }
  const known = new Set([...figures.flatMap((f) => Object.keys(f.names)), "momentum_x", "momentum_y", "momentum_z",
    "energy_initial", "energy_changes"]);
  const present = [...new Set(heads.flatMap((v) => Object.keys(v)))];
  const add = (figure, lines) => {
    const drawn = lines.filter((l) => l.values.some((v) => Number.isFinite(v)));
    if (drawn.length === 0 || (figure.log && !drawn.some((l) => l.values.some((v) => v > 0)))) return;
    drawn.forEach((l, n) => (l.colour = line_colours[n % line_colours.length]));
    all.push(new plot(parent, { ...figure, unit: in_units(figure.unit, run.about.units) }, times, drawn));
  };
  const line_of = (name, key) => ({ name, values: heads.map((v) => (typeof v[key] === "number" ? v[key] : NaN)) });
  for (const f of figures)
    add(f, Object.entries(f.names).filter(([key]) => present.includes(key)).map(([key, name]) => line_of(name, key)));
  const told = { ...run.about, ...run.about.end };
  for (const key of told.recorded || [])
    if (present.includes(key) && !known.has(key)) add({ title: key, unit: told.dimensions?.[key] || "" }, [line_of(key, key)]);
  draw_times(add, run);
  return all;
}

// Time of each phase, from one frame to the next, in milliseconds per step: the mean over the ranks;
// work of each rank; and how much more the busiest rank works than the mean.
function draw_times(add, run) {
  const heads = run.heads;
  if (!heads.every((h) => h.seconds)) return;
  const ranks = heads[0].seconds.length;
  const per_step = (k, rank, phase) => {
    if (k === 0) return NaN;
    const steps = heads[k].step - heads[k - 1].step;
    return steps > 0 ? (1000 * (heads[k].seconds[rank][phase] - heads[k - 1].seconds[rank][phase])) / steps : NaN;
  };
  const numbers = [...Array(ranks).keys()], mean = (values) => values.reduce((a, b) => a + b, 0) / values.length;
  const phases = ["detect", "respond", "integrate", "exchange"].slice(0, ranks > 1 ? 4 : 3);
  add({ title: "Time per phase", unit: ranks > 1 ? "ms a step, mean of the ranks" : "ms a step" },
    phases.map((name, p) => ({ name, values: heads.map((_, k) => mean(numbers.map((r) => per_step(k, r, p)))) })));
  if (ranks === 1) return;
  const work = numbers.map((r) => heads.map((_, k) => per_step(k, r, 0) + per_step(k, r, 1) + per_step(k, r, 2)));
  for (const [p, name] of phases.entries())
    if (ranks <= 16) add({ title: "Time per rank: " + name, unit: "ms a step" },
      numbers.map((r) => ({ name: "rank " + r, values: heads.map((_, k) => per_step(k, r, p)) })));
  add({ title: "Imbalance", unit: "most work of a)page",
    R"page( rank over the mean" },
    [{ name: "imbalance", values: heads.map((_, k) => {
      const all = work.map((w) => w[k]), m = mean(all);
      return m > 0 ? Math.max(...all) / m : NaN;
    }) }]);
}

// The page: what is shown, when it is drawn, and what the controls do.

function talus_view() {
  const $ = (id) => document.getElementById(id);
  const say = (text) => {
    $("message").textContent = text, $("message").hidden = !text;
  };
  const run = read_run();
  let stage;
  try {
    stage = new picture_stage($("canvas"), run);
  } catch (error) {
    say("This browser draws no WebGL: " + error.message);
  }
  const state = { at: 0, mode: null, playing: false, speed: 1, picked: null, followed: null, followed_at: null, frame: null, next: null, dirty: true, drawn: 0 };
  let plots = [], control, wanted = 0, loading = null, colours = new Uint8Array(0), written = 0;
  const api = (window.talus = { run, state, stage, frames: () => run.heads.length });

  // --- What is drawn ---------------------------------------------------------------------------

  const redraw = () => {
    state.dirty = true;
  };
  const mode = () => colour_modes[state.mode];
  function colour_bodies() {
    const f = state.frame, m = mode(), flags = run.table.flags, rows = f.rows, n = f.count;
    if (colours.length < 4 * n) colours = new Uint8Array(8 * n);
    const to = new Uint32Array(colours.buffer), word = ([r, g, b]) => (255 << 24) | (b << 16) | (g << 8) | r;
    const wall = word(grey_of_wall), picked = word([255, 40, 220]);
    if (m.ramp) {
      const [low, high] = m.range(run), scale = high > low ? 255 / (high - low) : 0, ramp = new Uint32Array(256);
      for (let k = 0; k < 256; ++k) ramp[k] = word(m.ramp.subarray(3 * k, 3 * k + 3));
      for (let i = 0; i < n; ++i)
        to[i] = flags[rows[i]] & 1 ? wall : ramp[Math.max(0, Math.min(255, ((m.value(f, i) - low) * scale) | 0))];
    } else {
      const hues = [];
      for (let i = 0; i < n; ++i) {
        const k = m.value(f, i);
        to[i] = flags[rows[i]] & 1 && !m.own_colour?.(run, k) ? wall : hues[k] ?? (hues[k] = word(m.colour(run, k)));
      }
    }
    if (state.picked !== null && f.index_of(state.picked) >= 0) to[f.index_of(state.picked)] = picked;
    stage.paint(colours);
  }
  // Lines from the centres of bodies to the points of contacts or joints.
  function show_links(name, group, look) {
    const f = state.frame, { [name + "_a"]: a, [name + "_b"]: b, [name + "_point"]: at } = f.blocks;
    if (!a || !$(name + "s").checked) return group.hide();
    const t = run.table, from = [], to = [], width = [], colour = [], p = [0, 0, 0], other = f.blocks[name + "_other"];
    const point_of = (list, k) => [0, 1, 2].map((c) => f.head.lower[c] + f.head.cell[c] * list[3 * k + c]);
    for (let k = 0; k < a.length; ++k) {
      const points = [point_of(at, k), point_of(other || at, k)], [thick, hue] = look(k);
      const line = (x, y) => (from.push(...x), to.push(...y), width.push(thick), colour.push(...hue, 255));
      if (other) line(...points);
      for (const [i, point] of [[a[k], points[0]], [b[k], points[1]]]) {
        if (i === none) continue;
        const r = f.rows[i];
        if (t.flags[r] & 1) continue;
        f.place(i, p);
        // A body seen through a periodic boundary is far from its contact.
        if (name === "contact" && Math.hypot(p[0] - point[0], p[1] - point[1], p[2] - point[2]) > 4 * run.reach(r)) continue;
        line(p, point);
      }
    }
    group.show(width.length, from, to, width, colour, true);
  }
  function show_lines() {
    const f = state.frame, most = 6 * run.most("force_mean") || 1;
    show_links("contact", stage.lines.contacts, (k) => {
      const part = Math.min(1, (f.blocks.contact_force[k] * f.head.force_cell) / most), c = 3 * Math.round(255 * part);
      return [1 + 5 * part, [heat[c], heat[c + 1], heat[c + 2]]];
    });
    show_links("joint", stage.lines.joints, () => [2, [20, 20, 20]]);
    const domains = $("domains").checked ? run.domains_at(state.frame.number) : [];
    const from = [], to = [], width = [], colour = [];
    for (const d of domains)
      for (const [a, b] of edges_of_domain(d.planes, stage.lower, stage.upper)) {
        from.push(...a), to.push(...b), width.push(1.5), colour.push(...colour_of_number(d.rank), 255);
      }
    if (width.length) stage.lines.domains.show(width.length, from, to, width, colour, false);
    else stage.lines.domains.hide();
  }
  // Where the followed body is between two frames, or null.
  function place_of_followed() {
    const f = state.frame, i = f.index_of_id(state.followed);
    if (i < 0) return null;
    const p = f.place(i, [0, 0, 0]), q = state.next ? state.next.place(i, [0, 0, 0]) : p, part = state.at - f.number;
    return state.next ? p.map((x, k) => x + part * (q[k] - x)) : p;
  }
  function move_camera() {
    const at = state.followed === null ? null : place_of_followed();
    if (at && state.followed_at) control.move(...at.map((x, k) => x - state.followed_at[k]));
    if (at) state.followed_at = at;
  }
  function follow_body(id) {
    state.followed = id, state.followed_at = null;
    if (state.frame) move_camera(), show_body();
  }
  function show_frame(frame, next, part) {
    const new_frame = frame !== state.frame;
    Object.assign(state, { frame, next });
    stage.show(frame, next, part);
    move_camera();
    if (new_frame || state.recolour) colour_bodies(), (state.recolour = false);
    if (state.listed !== run.table.length) (state.listed = run.table.length), show_legend(); // bodies may come later
    if (new_frame || state.relink) show_lines(), (state.relink = false);
    stage.look({ walls: +$("walls").value, ghost: $("ghost").checked || $("contacts").checked });
    if (!new_frame) return;
    // While it plays, texts and plots change some times a second: they cost more than the picture.
    if (state.playing && performance.now() - written < 250) return;
    write_frame();
  }
  function write_frame() {
    const frame = state.frame;
    written = performance.now();
    $("slider").value = frame.number;
    $("time").textContent = "t = " + short_number(+frame.head.time.toPrecision(6)) + unit_behind("T", run.about.units) + "  (step " + frame.head.step + ", frame " +
      (frame.number + 1) + " of " + run.heads.length + ")";
    for (const p of plots) p.show(frame.number);
    show_body();
  }
  function show_body() {
    const i = state.picked === null ? -1 : state.frame.index_of(state.picked);
    $("body").hidden = i < 0;
    if (i < 0) return;
    $("follow").hidden = Boolean(run.table.flags[state.picked] & 1);
    $("follow").setAttribute("aria-pressed", run.table.id[state.picked] === state.followed);
    const table = $("body").querySelector("table");
    table.replaceChildren(...facts_of(state.frame, i).map(([name, value]) => {
      const row = document.createElement("tr"), head = document.createElement("th"), cell = document.createElement("td");
      head.textContent = name, cell.textContent = value, row.append(head, cell);
      return row;
    }));
  }
  const same_rows = (k, next) => run.all.slice(run.places[k] + 1, run.places[next] + 1).every((h) => !h.blocks.rows);
  // Loads the frame before `at`, and the one after it, and shows the moment between them.
  async function show(at) {
    state.at = Math.max(0, Math.min(run.heads.length - 1, at));
    const k = Math.floor(state.at + 1e-9), part = state.at - k;
    const frame = state.frame && state.frame.number === k ? state.frame : await run.load(k);
    let next = null;
    if (part > 1e-6 && k + 1 < run.heads.length && same_rows(k, k + 1))
      next = state.next && state.next.number === k + 1 ? state.next : await run.load(k + 1);
    if (stage) show_frame(frame, next, part);
    redraw();
  }
  function require(at) { // one at a time: the last that was wanted
    wanted = at;
    if (loading) return loading;
    loading = (async () => {
      try {
        for (let now = null; now !== wanted; ) await show((now = wanted));
      } catch (error) {
        say(error.message), stop();
        throw error;
      } finally {
        loading = null;
      }
    })();
    return loading;
  }
  const stop = () => {
    if (!state.playing) return;
    state.playing = false, ($("play").innerHTML = "&#9654;");
    if (state.frame) write_frame();
  };

  // --- The bounds of the scene -----------------------------------------------------------------

  function measure() {
    const f = state.frame, t = run.table, p = [0, 0, 0];
    const bounds = (walls) => {
      const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
      for (let i = 0; i < f.count; ++i) {
        const r = f.rows[i];
        if (t.shape[r] === shape.plane || (!walls && t.flags[r] & 1)) continue;
        f.place(i, p);
        const reach = run.reach(r);
        for (let k = 0; k < 3; ++k) low[k] = Math.min(low[k], p[k] - reach), high[k] = Math.max(high[k], p[k] + reach);
      }
      return low[0] <= high[0] ? [low, high] : null;
    };
    const size = (l, h) => Math.hypot(h[0] - l[0], h[1] - l[1], h[2] - l[2]);
    const [first_low, first_high] = bounds(false) || bounds(true) || [[-1, -1, -1], [1, 1, 1]];
    let [low, high] = [first_low.slice(), first_high.slice()];
    for (const h of run.heads) {
      if (!h.box) continue;
      for (let k = 0; k < 3; ++k) low[k] = Math.min(low[k], h.box[k]), high[k] = Math.max(high[k], h.box[k + 3]);
    }
    // Bodies that fly away do not make all others too small to see.
    if (size(low, high) > 6 * size(first_low, first_high)) [low, high] = [first_low, first_high];
    const walls = bounds(true) || [low, high];
    const all_low = low.map((x, k) => Math.min(x, walls[0][k])), all_high = high.map((x, k) => Math.max(x, walls[1][k]));
    stage.lower = all_low.map((x, k) => x - 0.02 * (all_high[k] - x)), stage.upper = all_high.map((x, k) => x + 0.02 * (x - all_low[k]));
    // Walls that are far larger than what moves would make it invisible.
    const [l, h] = size(all_low, all_high) < 3 * size(low, high) ? [all_low, all_high] : [low, high];
    state.centre = new THREE.Vector3(...l).add(new THREE.Vector3(...h)).multiplyScalar(0.5), state.radius = 0.5 * size(l, h);
    stage.centre = new THREE.Vector3(...all_low).add(new THREE.Vector3(...all_high)).multiplyScalar(0.5);
    state.reach = 0.5 * size(all_low, all_high);
    for (let i = 0; i < f.count; ++i) // planes are drawn as finite pieces
      if (t.shape[f.rows[i]] === shape.plane) state.reach = Math.max(state.reach, 1.5 * run.reach(f.rows[i]));
  }
  const fit = () => control.fit(state.centre, state.radius);
  // The view of the program, whose angle is that of the width of a picture of 4 by 3; without one, everything.
  function first_view() {
    const look = run.look, vector = (v) => new THREE.Vector3(...v);
    if (!look) return fit();
    $("walls").value = look.walls;
    const from = vector(look.from), at = vector(look.at);
    if (look.follow !== undefined) {
      follow_body(BigInt(look.follow));
      if (state.followed_at) from.add(vector(state.followed_at)), at.add(vector(state.followed_at));
    }
    control.look(from, at, vector(look.up), (360 / Math.PI) * Math.atan(0.75 * Math.tan((look.angle * Math.PI) / 360)));
  }

  // --- Controls --------------------------------------------------------------------------------

  function list_modes() {
    const names = Object.keys(colour_modes).filter((n) => colour_modes[n].fits(run));
    if (!names.includes(state.mode)) state.mode = [run.colour, ...usual_modes(run), names[0]].find((n) => names.includes(n));
    $("colour").replaceChildren(...names.map((n) => new Option(colour_modes[n].label, n, false, n === state.mode)));
  }
  function show_legend() {
    const m = mode();
    $("legend").hidden = !m.ramp, $("names").hidden = Boolean(m.ramp);
    if (!m.ramp) {
      $("names").replaceChildren(...m.listed(run).slice(0, 256).map((k) => {
        const item = document.createEle)page",
    R"page(ment("li"), mark = document.createElement("i");
        mark.style.background = "rgb(" + m.colour(run, k) + ")", item.append(mark, m.name(run, k));
        return item;
      }));
      return;
    }
    const [low, high] = m.range(run), pen = $("ramp").getContext("2d");
    for (let x = 0; x < 160; ++x) {
      const k = 3 * Math.floor((255 * x) / 159);
      pen.fillStyle = "rgb(" + [m.ramp[k], m.ramp[k + 1], m.ramp[k + 2]] + ")", pen.fillRect(x, 0, 1, 10);
    }
    $("least").textContent = short_number(+low.toPrecision(3)), $("most").textContent = short_number(+high.toPrecision(3));
  }
  const again = (what) => () => {
    state[what] = true;
    if (state.frame && !loading) show_frame(state.frame, state.next, state.at - Math.floor(state.at + 1e-9));
    redraw();
  };
  function choose_colour(name) {
    state.mode = name, ($("colour").value = name);
    show_legend(), again("recolour")();
  }
  function pick(x, y) {
    const c = $("canvas"), at = new THREE.Vector3((2 * x) / c.clientWidth - 1, 1 - (2 * y) / c.clientHeight, 0.5);
    control.apply(); // the view may have changed since the last picture
    const from = stage.camera.position, way = at.unproject(stage.camera).sub(from).normalize();
    const i = body_on_ray(state.frame, run.forms, from, way, +$("walls").value > 0);
    state.picked = i < 0 ? null : state.frame.rows[i];
    show_body(), again("recolour")();
    return i;
  }
  function toggle() {
    if (state.playing) return stop();
    if (state.at >= run.heads.length - 1) state.at = 0, require(0);
    state.playing = true, ($("play").innerHTML = "&#10074;&#10074;"), (state.clock = performance.now());
  }
  const step = (by) => (stop(), require(Math.round(state.at) + by));
  function connect() {
    $("play").onclick = toggle;
    $("back").onclick = () => step(-1), $("forth").onclick = () => step(1);
    $("slider").oninput = () => {
      const at = +$("slider").value;
      stop(), require(at);
    };
    $("speed").replaceChildren(...[0.1, 0.25, 0.5, 1, 2, 4, 10].map((s) => new Option(s + "×", s, false, s === 1)));
    $("speed").onchange = () => (state.speed = +$("speed").value);
    $("colour").onchange = () => choose_colour($("colour").value);
    for (const id of ["contacts", "joints", "domains"]) $(id).onchange = again("relink");
    $("walls").oninput = $("ghost").onchange = again("look");
    $("home").onclick = fit;
    $("follow").onclick = () => {
      const id = run.table.id[state.picked];
      follow_body(state.followed === id ? null : id);
    };
    $("close").onclick = () => (state.picked = null, show_body(), again("recolour")());
    window.addEventListener("resize", redraw);
    window.addEventListener("keydown", (e) => {
      if (/^(INPUT|SELECT|BUTTON)$/.test(e.target.tagName) && e.key === " ") return;
      const act = { " ": toggle, ",": () => step(-1), ".": () => step(1), Home: fit, Escape: $("close").onclick }[e.key];
      if (act) e.preventDefault(), act();
    });
  }
  // The time that one second of playing shows: the whole run takes ten.
  const pace = () => Math.max(1, run.heads.length - 1) / 10;

  // --- The loop --------------------------------------------------------------------------------

  let since = performance.now(), count = 0;
  function loop(now) {
    requestAnimationFrame(loop);
    if (state.playing && !loading) {
      const elapsed = Math.min(0.25, (now - state.clock) / 1000);
      state.clock = now;
      const at = state.at + elapsed * state.speed * pace();
      if (at >= run.heads.length - 1 && !run.about.live) stop();
      require(at);
    }
    if (state.dirty && state.frame && stage) {
      state.dirty = false, stage.render(control, state.reach), ++count, ++state.drawn;
    }
    if (now - since > 1000) {
      $("rate").textContent = count > 1 ? Math.round((1000 * count) / (now - since)) + " pictures/s" : "";
      since = now, count = 0;
    }
  }

  // --- Beginning, and frames that arrive later --------------------------------------------------

  function describe() {
    const about = run.about, head = run.heads[run.heads.length - 1];
    document.title = about.name + " – talus";
    $("name").textContent = about.name;
    const numbers = run.heads.map((h) => h.bodies), least = Math.min(...numbers), most = Math.max(...numbers);
    $("facts").textContent = [(least < most ? least + " to " : "") + most + (least === 1 && most === 1 ? " body" : " bodies"), head.ranks ? head.ranks + (head.ranks > 1 ? " ranks" : " rank") : "",
      run.heads.length + (run.heads.length === 1 ? " frame" : " frames")].filter(Boolean).join(", ");
    for (const name of ["contacts", "joints", "domains"]) $(name + "_row").hidden = !run.has(name);
    $("walls_row").hidden = !run.table.flags.subarray(0, run.table.length).some((x) => x & 1);
    $("slider").max = run.heads.length - 1;
    const notes = [], error = Math.max(...run.heads.map((h) => h.position_error || 0));
    if (about.policies) notes.push(about.policies);
    notes.push("Positions are stored to ± " + short_number(+error.toPrecision(2)) + ", velocities to ± " +
      short_number(+(Math.max(...run.heads.map((h) => h.speed_cell || 0)) / 2).toPrecision(2)) + ".");
    const short = run.heads.filter((h) => h.blocks.contact_a && h.contacts_of > h.blocks.contact_a[2]);
    if (short.length) notes.push("Of up to " + Math.max(...short.map((h) => h.contacts_of)) +
      " contacts per frame the strongest are drawn.");
    for (const h of run.heads) for (const n of h.notes || []) notes.push("Step " + h.step + ": " + n);
    for (const n of [...(about.notes || []), ...((about.end && about.end.notes) || [])]) notes.push(n);
    $("notes").replaceChildren(...notes.slice(0, 50).map((n) => Object.assign(document.createElement("p"), { textContent: n })));
    plots = draw_plots($("plots"), run);
    for (const p of plots)
      p.chosen = (time) => {
        let best = 0;
        run.heads.forEach((h, k) => Math.abs(h.time - time) < Math.abs(run.heads[best].time - time) && (best = k));
        stop(), require(best);
      };
    if (state.frame) for (const p of plots) p.show(state.frame.number);
  }
  async function begin() {
    await run.load(0);
    const g = run.heads[0].gravity || [0, 0, 0], size = Math.hypot(...g);
    const up = size > 0 ? new THREE.Vector3(...g).multiplyScalar(-1 / size) : new THREE.Vector3(0, 0, 1);
    if (!stage) return describe();
    control = new orbit($("canvas"), stage.camera, up, redraw, pick);
    stage.camera.aspect = $("canvas").clientWidth / Math.max(1, $("canvas").clientHeight);
    list_modes(), describe(), connect(), show_legend();
    state.frame = await run.load(0), measure(), first_view(), (state.frame = null);
    await require(0);
    Object.assign(api, { control, show: require, pick, fit, choose_colour, toggle, redraw });
    requestAnimationFrame(loop);
    api.ready = true;
  }
  // Of a run under way: asks for the heads of new frames.
  async function follow() {
    try {
      const answer = await fetch("heads/" + run.heads.length);
      if (!answer.ok) throw new Error("the server answers " + answer.status);
      const more = await answer.json(), first = run.heads.length === 0, at_end = state.at >= run.heads.length - 1;
      if ((run.series ??= more.series) !== more.series) return location.reload(); // another run
      run.add(more.heads);
      say(run.heads.length ? "" : "Waiting for the first frame.");
      if (run.heads.length && first) await begin(), require(run.heads.length - 1);
      else if (more.heads.length) {
        describe(), list_modes(), show_legend();
        if (at_end && !state.playing) require(run.heads.length - 1);
      }
    } catch (error) {
      say("No news from the run: " + error.message);
    }
    setTimeout(follow, 1000);
  }
  const failed = (error) => say("The page cannot be shown: " + error.message);
  if (run.about.live) follow();
  else if (run.heads.length === 0) say("The run has no frames.");
  else begin().catch((error) => (failed(error), console.error(error)));
}

// The edges of an intersection of half-spaces n.x >= d, cut by a box.
function edges_of_domain(planes, lower, upper) {
  const walls = [];
  for (let k = 0; k < 3; ++k) {
    const n = [0, 0, 0], m = [0, 0, 0];
    n[k] = 1, m[k] = -1;
    walls.push([...n, lower[k]], [...m, -upper[k]]);
  }
  const all = [...planes, ...walls], edges = [], dot = (p, x) => p[0] * x[0] + p[1] * x[1] + p[2] * x[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  for (let i = 0; i < all.length; ++i)
    for (let j = i + 1; j < all.length; ++j) {
      if (i >= planes.length) continue; // the edges of the box alone are left out
      // The line in which two planes meet, cut by all others.
      const a = all[i], b = all[j], way = cross(a, b), size = dot(way, way);
      if (size < 1e-12) continue;
      const p = cross(b, way), q = cross(way, a), at = [0, 1, 2].map((k) => (a[3] * p[k] + b[3] * q[k]) / size);
      let first = -Infinity, last = Infinity;
      for (let k = 0; k < all.length && first < last; ++k) {
        if (k === i || k === j) continue;
        const speed = dot(all[k], way), rest = all[k][3] - dot(all[k], at);
        if (Math.abs(speed) < 1e-12) {
          if (rest > 1e-9 * (1 + Math.abs(all[k][3]))) first = Infinity;
        } else if (speed > 0) first = Math.max(first, rest / speed);
        else last = Math.min(last, rest / speed);
      }
      if (first < last && Number.isFinite(first) && Number.isFinite(last))
        edges.push([at.map((x, k) => x + first * way[k]), at.map((x, k) => x + last * way[k])]);
    }
  return edges;
}

return talus_view;
})();
</script>
)page",
};

inline constexpr const char* view_page_end[] = {
    R"page(
<script>talus_view();</script>
</body>
</html>
)page",
};

}  // namespace talus::detail
