// Programs of several stages: compact, measure, change, shear. A restart inside a later stage
// continues as the run that was not interrupted.
// timeout: 300
#include <doctest/doctest.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/flow.hpp>
#include <talus/observe/force.hpp>
#include <talus/observe/motion.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/scene/region.hpp>
#include <talus/scene/run.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

using cell =
    scenario<bodies<sphere, plane>, soft_contact<linear_spring_dashpot, coulomb_friction>,
             decomposition<grid<dynamic>>, transport<threads>, features<checkpoints, driven>>;

/// A file of this process, and what a program says, removed at the end.
struct scratch {
  std::string base = "/tmp/talus_stages_" + std::to_string(getpid());
  std::string file = base + ".h5", said = base + "_said";
  ~scratch() { unlink(file.c_str()), unlink(said.c_str()), unlink((file + ".lock").c_str()); }
};

struct ended {
  int code = 0;
  std::string said;
};
bool has(const std::string& text, const char* words) { return text.find(words) != text.npos; }

template <class SetUp>
ended program(const scratch& files, std::vector<std::string> words, SetUp&& set_up) {
  words.insert(words.begin(), {"program", "--quiet", "--checkpoint", files.file});
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  std::fflush(stderr);
  const int before = dup(2);
  std::FILE* const file = std::fopen(files.said.c_str(), "w");
  dup2(fileno(file), 2);
  ended e;
  e.code = run<cell>(static_cast<int>(words.size()), argv.data(), set_up);
  std::fflush(stderr);
  dup2(before, 2);
  close(before);
  std::fclose(file);
  std::stringstream text;
  text << std::ifstream(files.said).rdbuf();
  e.said = text.str();
  return e;
}

real top_of(world<cell>& w) {
  real top = 0;
  w.for_each_local([&](const auto& b) { top = std::max(top, b.position()[2] + b.shape().radius); });
  w.link().reduce(reduction::max, std::span(&top, 1));
  return top;
}

/// Compacts grains under gravity and a lid, removes the highest, adds a few and a wall at the
/// height, changes friction and gravity, and shears.
struct three_stages {
  std::string digest;
  real height = 0;
  flow fallen;            ///< through the height of 1, in all stages
  double approached = 0;  ///< the fastest approach of two bodies
  std::uint64_t counted_in_first = 0;
  real summed_in_first = 0;  ///< kept values, read after the first call
  std::uint64_t fails_in = 0;

  template <class World, class Options>
  void operator()(World& world, const Options& options) {
    world.decompose({.lower = {-2}, .upper = {2}});
    world.gravity({0, 0, -10});
    const auto stone = world.material({.density = 2, .friction = 0.1, .stiffness = 1e4});
    const auto wall = world.material({.density = 2, .friction = 0.5, .stiffness = 1e4});
    handle<plane> floor, lid;
    world.global([&](auto& scope) {
      floor = scope.add(plane{}, wall);
      lid = scope.add(plane{.normal = {0, 0, -1}, .offset = -3.5}, wall);
      for (const real s : {-1., 1.}) {
        scope.add(plane{.normal = {s, 0, 0}, .offset = -2}, wall);
        scope.add(plane{.normal = {0, s, 0}, .offset = -2}, wall);
      }
    });
    world.fill(simple_cubic{.spacing = 1} & box_region{{-2, -2, 0.5}, {2, 2, 3}},
               [&](const site& s, random_stream& random) {
                 return body{.shape = sphere{random.uniform(0.3, 0.48)},
                             .position = s.position,
                             .material = stone};
               });
    real summed = 0;
    std::uint64_t counted = 0;
    random_stream dice(7, 1);
    world.keep("summed", summed), world.keep_sum("counted", counted), world.keep("dice", dice);
    world.after_each_step([&] {
      summed += dice.uniform(0, 1), counted += world.local_bodies();
      if (world.steps() == fails_in) throw std::runtime_error("the machine is switched off");
    });
    world.hold_force(lid, {.pressure = [](real t) { return 20 * t; }, .max_speed = 0.5});
    const flow_meter level(world, plane{.normal = {0, 0, -1}, .offset = -1});
    world.simulate({.steps = 200, .dt = options.dt});

    const real top = world.once("top", [&] { return top_of(world); });
    const vec3 at = world.once("momentum", [&] { return measure_motion(world).momentum; });
    world.once("cut", [&] {
      world.destroy_if([&](const auto& b) { return b.position()[2] > 0.8 * top; });
      world.fill(
          simple_cubic{.spacing = 2, .origin = {1, 1, 0}} & box_region{{-2, -2, -0.1}, {2, 2, 0.1}},
          [&](const site& s) {
            return body{.shape = sphere{0.3},
                        .position = vec3(s.position + vec3(0, 0, top)),
                        .material = stone};
          });
    });
    world.destroy(lid);
    handle<plane> upper;
    world.global([&](auto& scope) {
      upper = scope.add(plane{.normal = {0, 0, -1}, .offset = -(top + 0.5)}, wall);
    });
    // Kept values are those after the call, also where a restart leaves it out.
    std::uint64_t all = counted;
    world.link().reduce(reduction::sum, std::span(&all, 1));
    const real summed_then = summed;
    world.gravity(
        {1 + 1e-3 * dice.uniform(0, 1), 1e-6 * static_cast<real>(all), -5 - 1e-3 * summed});
    world.material_pair(stone, wall, {.friction = 0.8});
    world.drive(upper, gliding{{0, 0, -0.2 + 1e-9 * at[0]}});
    world.drive(floor, belt{{1, 0, 0}});
    world.simulate({.steps = 210, .dt = options.dt});
    world.drive(upper, gliding{{0, 0, 0.1}});
    world.simulate({.steps = 100, .dt = options.dt});
    const std::string now = state_digest(world);
    const flow passed = level.total();
    const double fastest = summarize(world, 0, 0).impact_speed_max;
    if (world.rank() == 0) {
      digest = now, height = top, fallen = passed, approached = fastest;
      counted_in_first = all, summed_in_first = summed_then;
    }
  }
};

}  // namespace

TEST_CASE("a restart in any stage gives the bits of a run without interruption") {
  for (const char* ranks : {"1", "2", "4"}) {
    CAPTURE(ranks);
    const scratch files;
    for (const auto& [every, fails_in] : {std::pair{70, 100},
                                          {70, 230},
                                          {70, 300},
                                          {70, 450},
                                          {100, 210},
                                          {100, 430}}) {  // two at the ends of stages
      CAPTURE(fails_in);
      const std::vector<std::string> words{
          "--ranks", ranks, "--dt", "0.002", "--checkpoint-every", std::to_string(every)};
      three_stages whole;
      CHECK(program(files, words, whole).code == 0);
      CHECK(whole.height > 1);
      CHECK(whole.fallen.forward > 4);
      three_stages first, rest;
      first.fails_in = std::uint64_t(fails_in);
      CHECK(program(files, words, first).code == 1);
      auto more = words;
      more.insert(more.end(), {"--restart", files.file});
      const ended e = program(files, more, rest);
      CHECK(e.code == 0);
      CHECK(e.said.empty());
      if (!e.said.empty()) MESSAGE(e.said);
      CHECK(rest.digest == whole.digest);
      CHECK(rest.height == whole.height);
      CHECK(rest.fallen.mass_forward == whole.fallen.mass_forward);
      CHECK(rest.fallen.forward == whole.fallen.forward);
      CHECK(rest.fallen.backward == whole.fallen.backward);
      CHECK(rest.approached == whole.approached);
    }
  }
}

TEST_CASE("a restart on other ranks reads what was kept after the calls that it leaves out") {
  for (const auto& [before, after] : {std::pair{"1", "4"}, {"4", "2"}, {"2", "1"}}) {
    CAPTURE(before);
    CAPTURE(after);
    const scratch files;
    const auto with = [](const char* ranks) {
      return std::vector<std::string>{"--ranks", ranks, "--dt", "0.002", "--checkpoint-every",
                                      "70"};
    };
    three_stages whole, first, rest;
    CHECK(program(files, with(before), whole).code == 0);
    first.fails_in = 300;
    CHECK(program(files, with(before), first).code == 1);
    auto more = with(after);
    more.insert(more.end(), {"--restart", files.file});
    const ended e = program(files, more, rest);
    CHECK_MESSAGE(e.code == 0, e.said);
    CHECK(rest.counted_in_first == whole.counted_in_first);
    CHECK(rest.counted_in_first > 1000);
    CHECK(rest.summed_in_first == whole.summed_in_first);
    CHECK(rest.height == whole.height);
    CHECK(rest.fallen.forward == whole.fallen.forward);
  }
}

TEST_CASE("a run without signals writes its checkpoint at the ends of calls from --steps on") {
  for (const int part : {5, 60}) {  // --steps 50: less and more than the calls make
    CAPTURE(part);
    const scratch files;
    std::uint64_t at_second = 1;
    const auto set_up = [&](auto& world, const auto& options) {
      world.decompose({.lower = {-2}, .upper = {2}});
      const auto stone = world.material({.density = 2, .stiffness = 1e4});
      world.add_if_local(body{.shape = sphere{0.5}, .material = stone, .velocity = {0.1, 0, 0}});
      world.simulate({.steps = static_cast<std::size_t>(part), .dt = options.dt});
      at_second = access(files.file.c_str(), F_OK) == 0 ? 1 : 0;
      world.simulate({.steps = static_cast<std::size_t>(part), .dt = options.dt});
    };
    CHECK(program(files, {"--steps", "50", "--dt", "1e-3"}, set_up).code == 0);
    CHECK(at_second == (part < 50 ? 0 : 1));
    CHECK(access(files.file.c_str(), F_OK) == 0);
    std::uint64_t restarted_at = 0, steps = 0;
    const auto again = [&](auto& world, const auto& options) {
      set_up(world, options);
      restarted_at = world.restarted_at(), steps = world.steps();
    };
    const ended second =
        program(files, {"--steps", "50", "--dt", "1e-3", "--restart", files.file}, again);
    CHECK_MESSAGE(second.code == 0, second.said);
    CHECK(restarted_at == steps);
    CHECK(steps == static_cast<std::uint64_t>(2 * part));
  }
}

TEST_CASE("what looks at the bodies of the set-up in a restart is refused, with its place") {
  const scratch files;
  const auto two_stages = [&](auto&& between, std::vector<std::string> more) {
    more.insert(more.end(), {"--checkpoint-every", "30"});
    return program(files, more, [&](auto& world, const auto& options) {
      world.decompose({.lower = {-2}, .upper = {2}});
      const auto m = world.material({.density = 2, .stiffness = 1e4});
      const auto ball =
          world.add_if_local(body{.shape = sphere{0.5}, .position = {0.5, 0, 1}, .material = m});
      world.simulate({.steps = 20, .dt = options.dt});
      between(world, ball);
      world.simulate({.steps = 20, .dt = options.dt});
    });
  };
  const auto refused = [&](auto&& between, const char* what) {
    CAPTURE(what);
    CHECK(two_stages(between, {}).code == 0);
    const ended e = two_stages(between, {"--restart", files.file});
    CHECK(e.code == 1);
    CHECK(has(e.said, what));
    CHECK(has(e.said, "after call 1 of simulate()"));
    CHECK(has(e.said, "world.once"));
  };
  refused([](auto& w, auto&) { (void)measure_motion(w); }, "measure_motion looks");
  refused([](auto& w, auto&) { (void)w.local_bodies(); }, "world.local_bodies looks");
  refused([](auto& w, auto&) { w.for_each_local([](auto&) {}); }, "world.for_each_local looks");
  refused([](auto& w, auto& ball) { (void)w[*ball].position(); }, "world[...] looks");
  refused([](auto& w, auto&) { (void)w.overlaps(sphere{1}, {0, 0, 0}); }, "world.overlaps looks");
  refused([](auto& w, auto&) { (void)critical_dt(w); }, "critical_dt looks");
  refused([](auto& w, auto&) { (void)w.audit(); }, "world.audit looks");
  refused([](auto& w, auto&) { (void)w.convergence(); }, "world.convergence looks");
  refused([](auto& w, auto&) { (void)w.records(); }, "world.records looks");
  // A program that has named a value since: the file lacks it.
  CHECK(two_stages([](auto&, auto&) {}, {}).code == 0);
  const auto later = [](auto& w, auto&) { w.once("late", [] { return 1; }); };
  const ended e = two_stages(later, {"--restart", files.file});
  CHECK(e.code == 1);
  CHECK(has(e.said, "world.once(\"late\", f), of which the file has no value, looks"));
  // A name is given once, and add() has ids that depend on the ranks.
  CHECK(has(two_stages(
                [](auto& w, auto&) {
                  w.once("x", [] { return 1; });
                  w.once("x", [] { return 1; });
                },
                {})
                .said,
            "the name 'x' twice"));
  CHECK(has(two_stages(
                [](auto& w, auto&) {
                  w.once("x", [&] { w.add(sphere{0.1}, material_id{0}, {0, 0, 3}); });
                },
                {})
                .said,
            "add_if_local or fill"));
  CHECK(
      has(two_stages([](auto& w, auto&) { w.once("x", [&] {
                                            w.gravity({0, 0, -1});
                                          }); }, {}).said,
          "world.once for 'x' changes a parameter of the world"));
  // A value of one rank would be that of all after a restart.
  const auto on_two = [&](auto&& between) { return two_stages(between, {"--ranks", "2"}); };
  const char* const differ = "ranks have different values of world.once for 'x'";
  CHECK(has(on_two([](auto& w, auto&) { w.once("x", [&] { return w.local_bodies(); }); }).said,
            differ));
  CHECK(has(on_two([](auto& w, auto& ball) { w.once("x", [&] { return ball; }); }).said, differ));
  struct padded {
    char a;
    double b;
  };
  const auto part = [](auto& w, auto&) {
    w.once("x", [&] { return padded{'x', static_cast<double>(w.rank())}; });
  };
#if __has_builtin(__builtin_clear_padding)
  CHECK(has(on_two(part).said, differ));
#else
  (void)part;
#endif
  const ended alike = on_two([](auto& w, auto&) {
    w.once("x", [&] { return padded{'x', 1}; });
    w.once("y", [&] { return measure_motion(w).momentum; });
    w.once("z", [&] { return std::numeric_limits<double>::quiet_NaN(); });
  });
  CHECK(alike.code == 0);
  // A restart would take up the first call of simulate() at another step.
  CHECK(has(two_stages([](auto& w, auto&) { w.once("x", [&] { w.step(1e-4); }); }, {}).said,
            "world.once for 'x' makes steps"));
}
