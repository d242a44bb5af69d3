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
  add({ title: "Imbalance", unit: "most work of a rank over the mean" },
    [{ name: "imbalance", values: heads.map((_, k) => {
      const all = work.map((w) => w[k]), m = mean(all);
      return m > 0 ? Math.max(...all) / m : NaN;
    }) }]);
}
