// The stair: spheres roll down a spiral stair around a column, emitted at its top and removed at
// its foot (pe tutorial, section 6). Sectors around the column, slabs at the foot.
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
using namespace talus;

using stone = union_of<box, sphere, capsule>;
using stair =
    scenario<bodies<sphere, stone, plane>, hard_contact<coulomb_friction, newton_restitution>,
             solver<nonlinear_gauss_seidel, reproducible>,
             decomposition<join<ring<dynamic>, slabs<dynamic>>>, transport<as_launched>,
             features<checkpoints>>;

struct stair_options : options {
  int sectors = 6, slabs = 2;  // ranks around the column, and at the foot
  int columns = 20, rows = 3;  // of emitters, side by side and one above the other

  stair_options() {
    steps = 12000;
    dt = 0.01;
  }
  void describe(auto& line) {
    options::describe(line);
    line.add("--sectors", sectors, "ranks around the column", 2);
    line.add("--slabs", slabs, "ranks at the foot; sectors and slabs make all ranks", 1);
    line.add("--columns", columns, "emitters side by side", 1);
    line.add("--rows", rows, "emitters one above the other", 1);
  }
};

const double w = 30, d = 5, h = 1;                         // a step: width, depth, height
const double wrail = 1, hrail = 3;                         // the handrail: width, height
const double turn = std::atan(d / w);                      // from one step to the next
const int N = static_cast<int>(std::ceil(pi / turn)) + 2;  // steps

/// The column and all steps with their rail, as one body.
stone steps_around_the_column() {
  std::vector<stone::part> parts{{capsule{d + 1, N * h}, {{0, 0, 0.5 * N * h}}}};
  for (int i = 0; i < N; ++i) {
    const quat q = rotation({0, 0, 1}, i * turn);
    const auto add = [&](const auto& shape, double radius, double height) {
      parts.push_back({shape, {i * h * vec3::UnitZ() + rotated(q, vec3(radius, 0, height)), q}});
    };
    add(box{{0.25 * w, d, h}}, 0.125 * w, 0.5 * h);
    add(box{{0.65 * w, d, h}}, 0.575 * w, 0.5 * h);
    add(box{{0.1 * w, d, h}}, 0.95 * w, 0.5 * h);
    add(box{{wrail, d, hrail}}, w + 0.5 * wrail, 0.5 * hrail);
    add(sphere{0.5 * wrail}, w + 0.5 * wrail, hrail + 0.5 * wrail);
  }
  return stone(parts);
}

int main(int argc, char** argv) {
  return run<stair, stair_options>(argc, argv, [](auto& world, const stair_options& options) {
    // From the top at -x over +y to +x, then down along -y. Rank 0 also has the quarter x < 0, y <
    // 0. The column stands on the axis, where all ranks meet.
    const half_space right(1, 0, 0, 0), front(0, -1, 0, 0);
    const auto around = ring<dynamic>{
        .sectors = options.sectors, .axis = {0, 0, -1}, .start = {-1, 0, 0}, .angle = pi};
    const slabs<dynamic> foot{.count = options.slabs, .axis = {0, -1, 0}, .lower = 0, .upper = 20};
    world.decompose(join(around, within(intersect(right, front), foot))
                        .closed(intersect(right, complement(right), front, complement(front))));
    world.gravity({0, 0, -2});
    const auto granite = world.material(materials::granite);
    const auto granular = world.material({.density = 1, .restitution = 0.5, .friction = 0.05});

    world.global([&](auto& scope) {
      scope.add(plane{.normal = {0, 0, 1}, .offset = 0}, granite);
      scope.add(plane{.normal = {0, -1, 0}, .offset = -(w + wrail + 5)}, granite);
      const stone all = steps_around_the_column();
      const pose at = placed(all);
      scope.add(all, granite, at.position, at.orientation);
    });
    take_pictures(world, options,
                  {.from = {-25, -70, 70},
                   .at = {0, 6, 5},
                   .angle = 46,
                   .colour = picture::colouring::rank,
                   .walls = 1});

    const double space = 0.65 * w / options.columns, radius = 0.4 * space;
    const auto every = static_cast<std::uint64_t>(std::ceil(2.2 * radius / options.dt));
    double emitted = 0, removed = 0;
    random_stream random(options.seed, 0);  // only rank 0 draws
    world.keep_sum("emitted", emitted);
    world.keep_sum("removed", removed);
    world.keep("random", random);
    const auto emit = [&] {
      for (int i = 0; i < options.rows; ++i)
        for (int j = 0; j < options.columns; ++j) {
          const vec3 place{-0.25 * w - radius - j * space, 0, (N + 0.5) * h + (i + 2) * space};
          const vec3 velocity{0, random.uniform(2.0, 2.2), 0};
          if (world.overlaps(sphere{radius}, place)) continue;
          world.add(body{.shape = sphere{radius},
                         .position = place,
                         .material = granular,
                         .velocity = velocity});
          ++emitted;
        }
    };
    const auto tend = [&] {
      if (world.steps() % every == 0) world.exclusive(0, emit);
      removed += world.destroy_if([](const auto& b) { return b.position()[1] < -20.5; });
    };
    tend();
    world.after_each_step(tend);
    world.simulate({.steps = options.steps, .dt = options.dt});

    std::array<double, 3> sums{emitted, removed, static_cast<double>(world.local_bodies())};
    world.link().reduce(reduction::sum, sums);
    return results{{"emitted", sums[0]},
                   {"removed", sums[1]},
                   {"present", sums[2]},
                   {"unaccounted", sums[0] - sums[1] - sums[2]}};
  });
}
