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
