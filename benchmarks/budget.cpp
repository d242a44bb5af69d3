// Where the time of a step goes on a settled pile, beside the bytes and operations that each phase
// cannot do without. The library's own clocks tell detection from response; what an iteration costs
// follows from steps with more of them, in turns with the others.
#include <algorithm>
#include <string>
#include <vector>

#include "scenes/pile_protocol.hpp"
#include "scenes/talus_engine.hpp"

namespace {

using namespace talus;
using engine = bench::talus_engine<sphere, plane>;

/// Additions, multiplications, divisions and roots of one contact in one sweep, with friction,
/// counted in round_contact::relax() and apply(): relative velocity 8 (normal part 5), impulse 4,
/// velocity across 27, tangential impulse 6, clipping 13, change 4, new velocities 40. And in a
/// sweep of the correction: relax_push() and push_a(), push_b().
constexpr double flops_of_sweep = 105, flops_of_correction = 25;

/// CPU milliseconds per step with one pair of settings: a block for each turn.
struct setting {
  int iterations = 0, corrections = 0;
  std::vector<double> ms{};
  [[nodiscard]] double typical() {
    std::sort(ms.begin(), ms.end());
    return ms[ms.size() / 4];
  }
};

/// Whether the last step looked for pairs that may touch, or went on with those of the step before.
template <class State>
bool has_searched(const State& s) {
  if constexpr (requires { s.found.pause; })
    return s.found.steps == 0 || s.found.pause > 0;
  else
    return true;
}

/// The broad phase alone: sorting into the grid, then all pairs that it finds.
template <class World>
void time_broad_phase(World& w, std::uint64_t repeats, double& build_ms, double& pairs_ms,
                      double& pairs) {
  auto& s = talus::detail::state_of(w);
  std::vector<double> build, find;
  std::uint64_t count = 0;
  for (std::uint64_t k = 0; k < repeats; ++k) {
    const double start = bench::cpu_seconds();
    detail::prepare_detection(s);
    const double middle = bench::cpu_seconds();
    count = 0;
    detail::each_neighbour_pair(s, [&]<class A, class B, detail::partner P>() {
      return [&](std::size_t, std::size_t, real, real) { ++count; };
    });
    build.push_back(1e3 * (middle - start));
    find.push_back(1e3 * (bench::cpu_seconds() - middle));
  }
  std::sort(build.begin(), build.end()), std::sort(find.begin(), find.end());
  build_ms = build[build.size() / 4], pairs_ms = find[find.size() / 4];
  pairs = static_cast<double>(count);
}

}  // namespace

int main(int argc, char** argv) {
  return bench::guarded([&] {
    bench::arguments args(argc, argv);
    const bench::pile_run run(args);
    if (!args.done()) return;
    const auto [one, settle, measure, tiles, start, file] = run;
    const auto count = one * tiles * tiles;
    const bench::scene scene = run.scene();
    engine e(scene, 10);
    auto& w = e.world();
    for (std::uint64_t k = 0; k < settle; ++k) e.step();

    setting usual{.iterations = 10, .corrections = 3}, more{.iterations = 20, .corrections = 3},
        corrected{.iterations = 10, .corrections = 9};
    const std::uint64_t turn = 5, turns = std::max<std::uint64_t>(1, measure / turn);
    double detect = 0, respond = 0, integrate = 0, searches = 0, steps = 0;
    for (std::uint64_t t = 0; t < turns; ++t)
      for (setting* each : {&usual, &more, &corrected}) {
        w.solver().iterations = each->iterations;
        w.solver().correction_iterations = each->corrections;
        const auto before = w.stage_times();
        const double began = bench::cpu_seconds();
        for (std::uint64_t k = 0; k < turn; ++k) {
          e.step();
          searches += has_searched(talus::detail::state_of(w)), ++steps;
        }
        each->ms.push_back(1e3 * (bench::cpu_seconds() - began) / turn);
        if (each != &usual) continue;
        const auto now = w.stage_times();
        detect += now.detect - before.detect;
        respond += now.respond - before.respond;
        integrate += now.integrate - before.integrate;
      }
    const double total = usual.typical(), all = detect + respond + integrate;
    const double sweep = (more.typical() - total) / 10;
    const double correction = (corrected.typical() - total) / 6;
    double build = 0, find = 0, pairs = 0;
    time_broad_phase(w, std::max<std::uint64_t>(4, measure / 4), build, find, pairs);
    searches /= steps;
    build *= searches, find *= searches;
    // Clocks of the stages share out the CPU time: they are wall clocks.
    detect *= total / all, respond *= total / all, integrate *= total / all;

    const double n = static_cast<double>(count), c = static_cast<double>(e.contacts());
    const auto& s = talus::detail::state_of(w);
    // What a sweep reads of the contacts, what the correction reads, and all of it; eight in a
    // block.
    double swept = 0, corrected_bytes = 0, stored = 0;
    s.each_contact_list([&](const auto& list) {
      using contact = typename std::remove_cvref_t<decltype(list)>::contact_type;
      const auto blocks = static_cast<double>(list.size()) / 8;
      const double push = sizeof(detail::isotropic_correction<detail::wide_pack<real>>);
      const double bodies = sizeof(detail::isotropic_block<contact>::a) * (contact::paired ? 2 : 1);
      swept += blocks * sizeof(detail::isotropic_block<contact>);
      corrected_bytes += blocks * (6 * sizeof(detail::wide_pack<real>) + bodies + push);
      stored += blocks * (sizeof(detail::isotropic_block<contact>) + push);
    });
    const double body = sizeof(detail::solver_body), shift = sizeof(detail::body_shift);
    const auto& spheres = s.of<sphere>();
    const double columns = static_cast<double>(spheres.movable.bytes_per_body());
    const double grid = static_cast<double>(spheres.grid.bytes()) / n;
    const double history = static_cast<double>(s.history.bytes());
    const double keys = c * sizeof(detail::contact_key);

    std::string text;
    const auto add = [&](const std::string& phase, double times, double ms, double bytes,
                         double flops) {
      bench::record out;
      out.add("phase", phase);
      out.add("bodies", count);
      out.add("contacts", e.contacts());
      out.add("pairs", pairs);
      out.add("searches_per_step", searches);
      out.add("times_per_step", times);
      out.add("ms_per_step", ms);
      out.add("bytes_per_step", bytes);
      out.add("flops_per_step", flops);
      out.add("ms_of_step", total);
      out.add("working_set_bytes", swept + n * body);
      text += (text.empty() ? "[" : ",") + out.json();
    };
    add("broad phase: grid", searches, build,
        searches * n * (sizeof(vec3) + 2 * sizeof(real) + grid), 0);
    add("broad phase: pairs", searches, find, searches * (n * grid + 8 * pairs),
        searches * 9 * pairs);
    add("narrow phase, contacts", 1, detect - build - find, n * columns + stored + keys, 30 * c);
    add("gather, recall, remember", 1, respond - 10 * sweep - 3 * correction,
        2 * (history + keys) + n * (columns + body), 0);
    // A sweep reads each contact, writes its impulse, and reads and writes two bodies, which mostly
    // are where the last contact left them: each counts once.
    add("sweeps", 10, 10 * sweep, 10 * (swept + c * 4 * sizeof(real) + 2 * n * body),
        10 * c * flops_of_sweep);
    add("correction of overlaps", 3, 3 * correction,
        3 * (corrected_bytes + c * sizeof(real) + 2 * n * shift), 3 * c * flops_of_correction);
    add("positions", 1, integrate, n * (body + shift + 4 * sizeof(vec3)), 9 * n);
    bench::record::write_text(text + "]\n", file);
  });
}
