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
        const item = document.createElement("li"), mark = document.createElement("i");
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
