// BED in talus, with Hertz's and Mindlin's forces and friction: settles it and writes its state,
// measures steps from such a state, or judges the state that another engine has reached.
#include <talus/core/clock.hpp>
#include <talus/mpi.hpp>
#include <talus/observe/digest.hpp>

#include "scenes/bed_scene.hpp"
#include "scenes/checker.hpp"
#include "scenes/protocol.hpp"

namespace {

using scenario = talus::scenario<talus::bodies<talus::sphere, talus::plane>,
                                 talus::soft_contact<talus::hertz_mindlin, talus::coulomb_friction>,
                                 talus::integrator<talus::velocity_verlet>,
                                 talus::decomposition<talus::grid<talus::dynamic>>,
                                 talus::transport<talus::as_launched>>;
using alone =
    talus::scenario<talus::bodies<talus::sphere, talus::plane>,
                    talus::soft_contact<talus::hertz_mindlin, talus::coulomb_friction>,
                    talus::integrator<talus::velocity_verlet>, talus::transport<talus::serial>>;

talus::vec3 vector(const bench::vec& v) { return {v[0], v[1], v[2]}; }

template <class World>
void fill(World& world, const bench::bed& bed) {
  const auto stuff = world.material({.density = bed.density,
                                     .restitution = bed.restitution,
                                     .friction = bed.friction,
                                     .youngs_modulus = bed.youngs_modulus,
                                     .poisson_ratio = bed.poisson_ratio});
  world.gravity({0, 0, -bed.gravity});
  world.global([&](auto& scope) {
    for (const bench::wall& w : bed.start.walls)
      scope.add(talus::plane{.normal = vector(w.normal), .offset = w.offset}, stuff);
  });
  for (const bench::ball& b : bed.start.balls)
    world.add_if_local(talus::body{.shape = talus::sphere{b.radius},
                                   .position = vector(b.position),
                                   .material = stuff,
                                   .velocity = vector(b.velocity),
                                   .angular_velocity = vector(b.spin)});
}

/// The bodies of a world of one rank, in the order of their creation.
template <class World>
void take_back(World& world, bench::bed& bed) {
  const auto array = [](const talus::vec3& v) { return bench::vec{v[0], v[1], v[2]}; };
  const auto& store = talus::detail::state_of(world).template of<talus::sphere>().movable;
  std::vector<std::size_t> order(store.locals);
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return store.id[a] < store.id[b]; });
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::size_t i = order[k];
    bed.start.balls[k] = {array(store.position[i]), store.shape[i].radius, array(store.velocity[i]),
                          array(store.angular_velocity[i])};
  }
}

/// Contacts are those among the spheres, as the judge of all engines finds them.
void add_state(bench::record& out, const bench::bed& bed) {
  const auto found = bench::check(bed.start.balls, {}, {});
  out.add("contacts", found.overlapping_pairs);
  out.add("overlap_mean", found.penetration_mean * found.mean_radius);
  out.add("kinetic_energy_per_body",
          bed.kinetic_energy() / static_cast<double>(bed.start.balls.size()));
}

struct timing {
  std::uint64_t steps = 0;
  double wall = 0, cpu = 0;  ///< s, the best of some parts of the run, for all steps

  /// The best of `parts` equal parts, so that other programs on the machine matter less.
  template <class Step>
  static timing of(std::uint64_t steps, std::uint64_t parts, Step&& step) {
    timing best{steps, INFINITY, INFINITY};
    for (std::uint64_t k = 0; k < parts; ++k) {
      const double started = talus::detail::wall_seconds(), used = bench::cpu_seconds();
      for (std::uint64_t n = 0; n < steps / parts; ++n) step();
      const double scale = static_cast<double>(steps) / static_cast<double>(steps / parts);
      best.wall = std::min(best.wall, scale * (talus::detail::wall_seconds() - started));
      best.cpu = std::min(best.cpu, scale * (bench::cpu_seconds() - used));
    }
    return best;
  }
};

void report(bench::record& out, const bench::bed& bed, int ranks, const timing& t) {
  const double work = static_cast<double>(bed.start.balls.size() * t.steps);
  out.add("engine", "talus");
  out.add("bodies", bed.start.balls.size());
  out.add("ranks", ranks);
  out.add("dt", bench::bed::time_step());
  out.add("steps", t.steps);
  // One rank is measured by its CPU time, several by the time that passes.
  out.add("particle_steps_per_second", work / (ranks == 1 ? t.cpu : t.wall));
  out.add("wall_seconds", t.wall);
}

void measure_alone(bench::record& out, bench::bed& bed, std::uint64_t steps, std::uint64_t parts) {
  talus::serial::link link;
  talus::world<alone> world(link);
  fill(world, bed);
  const double dt = bed.time_step();
  world.step(dt);
  const timing t = timing::of(steps, parts, [&] { world.step(dt); });
  const auto spent = world.stage_times();
  const double all = static_cast<double>(world.steps());
  take_back(world, bed);
  report(out, bed, 1, t);
  add_state(out, bed);
  out.add("detect_ms_per_step", 1e3 * spent.detect / all);
  out.add("respond_ms_per_step", 1e3 * spent.respond / all);
  out.add("integrate_ms_per_step", 1e3 * spent.integrate / all);
  out.add("digest", talus::state_digest(world));
}

template <class Link>
void measure_rank(Link& link, const bench::bed& bed, std::uint64_t steps, std::uint64_t parts,
                  bench::record& out) {
  talus::world<scenario> world(link);
  std::array<int, 3> cells{0, 1, 1};
  talus::detail::balance(cells, link.size());
  world.decompose({.cells = cells,
                   .lower = {.x = 0, .y = 0, .z = 0},
                   .upper = {.x = bed.width, .y = bed.width, .z = 2 * bed.width}});
  fill(world, bed);
  const double dt = bed.time_step();
  world.step(dt);
  link.barrier();
  const timing t = timing::of(steps, parts, [&] { world.step(dt); });
  std::array<double, 1> wall{t.wall};
  link.reduce(talus::reduction::max, wall);
  const auto digest = talus::state_digest(world);
  if (link.rank() != 0) return;
  report(out, bed, link.size(), {steps, wall[0], t.cpu});
  out.add("digest", digest);
}

}  // namespace

int main(int argc, char** argv) {
  return bench::guarded([&] {
    bench::arguments args(argc, argv);
    const auto bodies = args.count("bodies", 8000);
    const auto settle = args.count("settle", 0);  // this many steps, then --write
    const auto write = args.text("write", "");    // the state at the end
    const auto from = args.text("from", "");      // begin with a state that was written
    const auto judge = args.text("judge", "");    // a line for each body: x y z vx vy vz
    const auto steps = args.count("measure", 500);
    const auto parts = args.count("parts", 5);  // of which the fastest counts
    const auto ranks = static_cast<int>(args.count("ranks", 0));
    const auto file = args.json_file();
    if (!args.done()) return;
    if (parts == 0 || steps < parts)
      throw std::invalid_argument(
          "--measure needs at least as many steps as --parts, which needs 1");

    bench::bed bed(bodies);
    if (!from.empty()) bed.read(from, false);
    bench::record out;
    if (!judge.empty()) {
      bed.read(judge, true);
      add_state(out, bed);
      out.write(file);
      return;
    }
    if (settle > 0) {
      talus::serial::link link;
      talus::world<alone> world(link);
      fill(world, bed);
      for (std::uint64_t k = 0; k < settle; ++k) world.step(bed.time_step());
      take_back(world, bed);
      if (!write.empty()) bed.write(write);
      out.add("bodies", bodies);
      out.add("dt", bed.time_step());
      out.add("width", bed.width);
      add_state(out, bed);
      out.write(file);
      return;
    }
    if (ranks == 0 && talus::detail::find_launcher().size <= 1) {
      measure_alone(out, bed, steps, parts);
      out.write(file);
      return;
    }
    talus::mpi::settings settings;
    settings.argc = &argc, settings.argv = &argv;
    settings.ranks = ranks;
    talus::as_launched::launch(settings,
                               [&](auto& link) { measure_rank(link, bed, steps, parts, out); });
    if (talus::detail::find_launcher().rank == 0) out.write(file);
  });
}
