// What a feature costs: the same settled pile in worlds that differ by one policy. All of them live
// at once and are stepped in turns, so that whatever else the machine does hits all alike.
#include <memory>
#include <string>
#include <vector>

#include "scenes/pile_protocol.hpp"
#include "scenes/talus_engine.hpp"

namespace {

using namespace talus;

/// One world on the pile, whatever its type.
struct contender {
  virtual ~contender() = default;
  virtual void step() = 0;
  virtual void report(bench::record& out) = 0;
  std::string name;
  std::vector<double> block_ms;  ///< per step, of each turn
};

template <class Engine>
struct contender_of final : contender {
  Engine engine;
  explicit contender_of(const bench::scene& s) : engine(s) {}
  void step() override { engine.step(); }
  void report(bench::record& out) override {
    const auto found = bench::check(engine.balls(), engine.start().walls, {});
    out.add("contacts", engine.contacts());
    out.add("penetration_mean", found.penetration_mean);
    engine.describe(out);
  }
};

using contenders = std::vector<std::unique_ptr<contender>>;

template <class... Policies>
void enter(contenders& all, const bench::scene& s, const std::string& name) {
  all.push_back(std::make_unique<contender_of<bench::talus_engine_with<Policies...>>>(s));
  all.back()->name = name;
}

}  // namespace

int main(int argc, char** argv) {
  return bench::guarded([&] {
    bench::arguments args(argc, argv);
    const bench::pile_run run(args);
    if (!args.done()) return;
    const auto [one, settle, measure, tiles, start, file] = run;
    const auto count = one * tiles * tiles;
    const bench::scene s = run.scene();
    using round = bodies<sphere, plane>;
    contenders all;
    enter<round>(all, s, "spheres with friction");
    enter<round, hard_contact<newton_restitution>>(all, s, "without friction");
    enter<round, precision<mixed_precision>>(all, s, "contacts solved in float");
    enter<round, features<orientation>>(all, s, "orientation kept");
    enter<bodies<sphere, box, plane>>(all, s, "boxes named, none there");
    enter<round, features<energy_ledger>>(all, s, "energy ledger");
    enter<round, features<momentum_balance>>(all, s, "momentum balance");
    enter<round, features<penetration_monitor>>(all, s, "penetration monitor");
    enter<round, features<residual_monitor>>(all, s, "residual monitor");
    enter<round, soft_contact<linear_spring_dashpot>>(all, s, "soft contacts, no history");
    enter<round, soft_contact<linear_spring_dashpot, coulomb_friction>>(
        all, s, "soft contacts, friction with history");

    for (auto& each : all)
      for (std::uint64_t k = 0; k < settle; ++k) each->step();
    const std::uint64_t turn = 10, turns = std::max<std::uint64_t>(1, measure / turn);
    for (std::uint64_t t = 0; t < turns; ++t)
      for (auto& each : all) {
        const double began = bench::cpu_seconds();
        for (std::uint64_t k = 0; k < turn; ++k) each->step();
        each->block_ms.push_back(1e3 * (bench::cpu_seconds() - began) / turn);
      }

    std::string text;
    for (auto& each : all) {
      auto& ms = each->block_ms;
      std::sort(ms.begin(), ms.end());
      bench::record out;
      out.add("policies", each->name);
      out.add("bodies", count);
      out.add("cpu_ms_per_step_median", ms[ms.size() / 2]);
      out.add("cpu_ms_per_step_fastest", ms.front());
      each->report(out);
      text += (text.empty() ? "[" : ",") + out.json();
    }
    bench::record::write_text(text + "]\n", file);
  });
}
