// PILE over ranks, as threads of one process or as MPI processes: times, the share of the exchange,
// messages, bytes and memory of a rank and step.
#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <limits>
#include <string>
#include <talus/core/clock.hpp>
#include <talus/mpi.hpp>
#include <talus/observe/memory.hpp>
#include <talus/observe/penetration.hpp>

#include "scenes/pile_scene.hpp"
#include "scenes/protocol.hpp"
#include "scenes/settled.hpp"

namespace {

template <class Solver>
using scenario = talus::scenario<talus::bodies<talus::sphere, talus::plane>, talus::solver<Solver>,
                                 talus::decomposition<talus::grid<talus::dynamic>>,
                                 talus::transport<talus::as_launched>>;

struct run_of_ranks {
  bench::scene scene;
  std::array<int, 3> cells{};
  int iterations = 0;
  std::uint64_t settle = 0, longest = 0, measure = 0;
  std::string keep;
};

/// Largest and mean value of all ranks.
struct spread {
  double max = 0, mean = 0;

  template <class Link>
  static spread of(Link& link, double value) {
    std::array<double, 1> most{value}, sum{value};
    link.reduce(talus::reduction::max, most);
    link.reduce(talus::reduction::sum, sum);
    return {most[0], sum[0] / link.size()};
  }
  void add(bench::record& out, const std::string& name) const {
    out.add(name + "_max", max), out.add(name + "_mean", mean);
  }
};

template <class Scenario>
void fill(talus::world<Scenario>& world, const run_of_ranks& run) {
  const bench::scene& s = run.scene;
  const auto vector = [](const bench::vec& v) { return talus::vec3(v[0], v[1], v[2]); };
  const auto [low, high] = std::pair(-s.walls[1].offset, -s.walls[2].offset);
  world.decompose({.cells = run.cells,
                   .lower = {.x = low, .y = -s.walls[3].offset, .z = 0},
                   .upper = {.x = high, .y = -s.walls[4].offset, .z = high}});
  const auto stuff = world.material({.density = s.density,
                                     .restitution = s.between_balls.restitution,
                                     .friction = s.between_balls.friction});
  world.gravity({0, 0, s.gravity});
  world.global([&](auto& scope) {
    for (const bench::wall& w : s.walls)
      scope.add(talus::plane{.normal = vector(w.normal), .offset = w.offset}, stuff);
  });
  for (const bench::ball& b : s.balls)
    world.add_if_local(talus::body{.shape = talus::sphere{b.radius},
                                   .position = vector(b.position),
                                   .material = stuff,
                                   .velocity = vector(b.velocity),
                                   .angular_velocity = vector(b.spin)});
  if (run.iterations > 0) world.solver().iterations = run.iterations;
}

/// Collective: all bodies in the order of their creation, on rank 0.
template <class Scenario>
std::vector<bench::ball> collect(talus::world<Scenario>& world) {
  struct entry {
    talus::system_id id;
    bench::ball ball;
  };
  const auto array = [](const talus::vec3& v) { return bench::vec{v[0], v[1], v[2]}; };
  talus::detail::byte_buffer mine;
  talus::detail::byte_writer out(mine);
  const auto& store = talus::detail::state_of(world).template of<talus::sphere>().movable;
  for (std::size_t i = 0; i < store.locals; ++i)
    out.put(entry{store.id[i],
                  {array(store.position[i]), store.shape[i].radius, array(store.velocity[i]),
                   array(store.angular_velocity[i])}});
  std::vector<entry> all;
  for (const auto& bytes : world.link().gather(mine)) {
    all.resize(all.size() + bytes.size() / sizeof(entry));
    std::memcpy(all.data() + all.size() - bytes.size() / sizeof(entry), bytes.data(), bytes.size());
  }
  std::sort(all.begin(), all.end(), [](const auto& x, const auto& y) { return x.id < y.id; });
  std::vector<bench::ball> balls;
  for (const entry& e : all) balls.push_back(e.ball);
  return balls;
}

template <class Scenario>
void settle(talus::world<Scenario>& world, const run_of_ranks& run) {
  for (std::uint64_t k = 0; k < run.settle; ++k) world.step(run.scene.dt);
  if (run.keep.empty()) return;
  // As PILE asks: beyond 64,000 bodies until the median one rests.
  const bench::scene& s = run.scene;
  const double still = 1e-3 * s.density * 4 / 3 * std::numbers::pi * std::pow(0.45, 4) * -s.gravity;
  for (std::uint64_t done = run.settle;; done += 120) {
    const auto balls = collect(world);
    std::array<double, 1> restless{0};
    if (world.rank() == 0 && balls.size() > 64000 && done < run.longest)
      restless[0] = bench::kinetic_energy(balls, s.density).median > still;
    world.link().reduce(talus::reduction::max, restless);
    if (restless[0] == 0) {
      if (world.rank() == 0) bench::save_state(balls, run.keep);
      return;
    }
    for (int k = 0; k < 120; ++k) world.step(s.dt);
  }
}

/// Microseconds of an exchange of so many bytes each way between two ranks, at best.
double exchange_us(talus::as_launched::link& link, std::size_t bytes) {
  std::vector<talus::neighbour_message> neighbour_messages(1);
  neighbour_messages[0].rank = 1 - link.rank();
  double best = std::numeric_limits<double>::infinity();
  for (int round = 0; round < 20; ++round) {
    const int repeats = 50;
    link.barrier();
    const double start = talus::detail::wall_seconds();
    for (int k = 0; k < repeats; ++k) {
      neighbour_messages[0].out.resize(bytes), neighbour_messages[0].in.resize(bytes);
      link.start_fixed(neighbour_messages);
      link.finish_fixed(neighbour_messages);
    }
    best = std::min(best, 1e6 * (talus::detail::wall_seconds() - start) / repeats);
  }
  return best;
}

template <class Solver>
void run_rank(talus::as_launched::link& link, const run_of_ranks& run, bench::record& out) {
  talus::world<scenario<Solver>> world(link);
  fill(world, run);
  settle(world, run);
  const talus::traffic before = link.counters();
  const talus::stage_seconds clocks = world.stage_times();
  link.barrier();
  const double cpu = talus::detail::thread_seconds(), start = talus::detail::wall_seconds();
  std::vector<double> walls;
  for (std::uint64_t k = 0; k < run.measure; ++k) {
    const double began = talus::detail::wall_seconds();
    world.step(run.scene.dt);
    walls.push_back(talus::detail::wall_seconds() - began);
  }
  const double steps = static_cast<double>(std::max<std::uint64_t>(1, run.measure));
  const double own_wall = talus::detail::wall_seconds() - start;
  const auto spread_of = [&](double value) { return spread::of(link, value); };
  const spread seconds = spread_of(talus::detail::thread_seconds() - cpu);
  const spread wall = spread_of(own_wall);
  std::nth_element(walls.begin(), walls.begin() + walls.size() / 2, walls.end());
  const spread median = spread_of(walls.empty() ? 0 : walls[walls.size() / 2]);
  const talus::stage_seconds now = world.stage_times();
  const spread detect = spread_of(now.detect - clocks.detect);
  const spread respond = spread_of(now.respond - clocks.respond);
  const spread exchange = spread_of(now.exchange - clocks.exchange);
  const talus::traffic sent = link.counters() - before;
  // The barrier before the steps is the only collective that is not the library's.
  const spread messages = spread_of(static_cast<double>(sent.messages) / steps);
  const spread bytes = spread_of(static_cast<double>(sent.bytes) / steps);
  const spread memory = spread_of(static_cast<double>(talus::bytes_in_use(world)));
  const spread bodies = spread_of(static_cast<double>(world.local_bodies()));
  const spread neighbours = spread_of(static_cast<double>(world.connections().size()));
  std::uint64_t contact_count = 0, copies = 0;
  talus::detail::state_of(world).each_contact_list(
      [&](const auto& list) { contact_count += list.size(); });
  talus::detail::state_of(world).each_finite_shape(
      [&](const auto& b) { copies += b.movable.size() - b.movable.locals; });
  const spread contacts = spread_of(static_cast<double>(contact_count));
  const spread shadows = spread_of(static_cast<double>(copies));
  const spread collectives = spread_of(static_cast<double>(world.step_messages().collectives));
  const auto overlap = talus::measure_penetration(world);
  const bool pair = link.size() == 2;
  const double short_us = pair ? exchange_us(link, 8) : 0;
  const double long_us = pair ? exchange_us(link, 1 << 16) : 0;
  if (link.rank() != 0) return;

  out.add("engine", "talus");
  out.add("scene", run.scene.name);
  out.add("ranks", link.size());
  out.add("transport", link.transport_name());
  out.add("bodies", run.scene.balls.size());
  out.add("solver", Solver::name);
  out.add("iterations", world.solver().iterations);
  out.add("correction_iterations", world.solver().correction_iterations);
  out.add("steps", world.steps());
  out.add("measure", run.measure);
  out.add("wall_ms_per_step", 1e3 * wall.max / steps);
  out.add("wall_ms_per_step_median", 1e3 * median.max);
  seconds.add(out, "cpu_seconds");
  detect.add(out, "detect_seconds");
  respond.add(out, "respond_seconds");
  exchange.add(out, "exchange_seconds");
  out.add("exchange_share", exchange.mean / wall.max);
  bodies.add(out, "bodies");
  shadows.add(out, "shadow_copies");
  contacts.add(out, "contacts");
  neighbours.add(out, "neighbours");
  messages.add(out, "messages_per_step");
  bytes.add(out, "bytes_per_step");
  memory.add(out, "bytes_in_use");
  out.add("collectives_max", collectives.max);
  out.add("penetration_mean", overlap.mean);
  out.add("penetration_max", overlap.max);
  out.add("exchange_of_8_bytes_us", short_us);
  out.add("exchange_of_64_kib_us", long_us);
}

}  // namespace

int main(int argc, char** argv) {
  return bench::guarded([&] {
    bench::arguments args(argc, argv);
    const auto ranks = static_cast<int>(args.count("ranks", 0));
    run_of_ranks run;
    // A bed of columns by rows sites for each cell of the grid, or a pile that all cells share.
    const auto each = args.count("bodies-per-rank", 0);
    const auto columns = args.count("columns-per-rank", 4);
    const auto bodies = args.count("bodies", 8000);
    for (std::size_t k = 0; k < 3; ++k)
      run.cells[k] = static_cast<int>(args.count(std::string("cells-") + "xyz"[k], k == 2));
    run.iterations = static_cast<int>(args.count("iterations", 0));
    run.settle = args.count("settle", 720);
    run.longest = args.count("longest", 20 * run.settle);
    run.measure = args.count("measure", 120);
    const auto start = args.text("from", "");
    run.keep = args.text("keep", "");
    const auto file = args.json_file();
    const auto solver = args.text("solver", talus::nonlinear_gauss_seidel::name);
    if (!args.done()) return;
    const bool coloured = solver == talus::coloured_gauss_seidel::name;
    if (!coloured && solver != talus::nonlinear_gauss_seidel::name)
      throw std::invalid_argument("there is no solver '" + solver + "'");

    const int started = talus::detail::find_launcher().size;
    const int all = std::max({1, ranks, started});
    auto cells = run.cells;
    if (!talus::detail::balance(cells, all))
      throw std::invalid_argument("the grid does not have as many cells as there are ranks");
    run.cells = cells;
    run.scene = each > 0 ? bench::bed_scene(columns * cells[0], columns * cells[1], each * all)
                         : bench::pile_scene(bodies);
    if (!start.empty()) bench::load_state(run.scene, start);

    bench::record out;
    const double before = bench::resident_bytes();
    talus::mpi::settings settings;
    settings.argc = &argc, settings.argv = &argv;
    settings.ranks = ranks;
    double resident = 0;
    talus::as_launched::launch(settings, [&](auto& link) {
      coloured ? run_rank<talus::coloured_gauss_seidel>(link, run, out)
               : run_rank<talus::nonlinear_gauss_seidel>(link, run, out);
      link.barrier();
      if (link.rank() == 0) resident = bench::resident_bytes() - before;
      link.barrier();
    });
    if (talus::detail::find_launcher().rank > 0) return;
    // Threads share a process; of MPI processes this is the first one's.
    out.add("resident_bytes_per_rank", resident / (started > 1 ? 1 : all));
    out.write(file);
  });
}
