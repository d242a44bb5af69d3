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
