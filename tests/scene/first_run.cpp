// The output of run() for the first runs of a new user: on standard error, and in the summary. The
// table in docs/messages.md has all messages.
#include <doctest/doctest.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <talus/talus.hpp>

using namespace talus;

namespace {

using scene = scenario<bodies<sphere, plane>, decomposition<grid<2, 2>>>;
using set_up = std::function<void(world<scene>&, const options&)>;

struct said {
  int code;
  std::string out, err;
};

/// The output to a file descriptor while f() runs.
std::string caught(FILE* stream, const std::function<void()>& f) {
  std::FILE* const kept = std::tmpfile();
  std::fflush(stream);
  const int own = ::dup(::fileno(stream));
  ::dup2(::fileno(kept), ::fileno(stream));
  f();
  std::fflush(stream);
  ::dup2(own, ::fileno(stream));
  ::close(own);
  std::rewind(kept);
  std::string text;
  for (int c; (c = std::fgetc(kept)) != EOF;) text += static_cast<char>(c);
  std::fclose(kept);
  return text;
}

/// A program of that name with these words on its command line.
template <class Scene = scene, class SetUp = set_up>
said program(std::vector<std::string> words, const SetUp& f) {
  words.insert(words.begin(), "program");
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  said s;
  s.err = caught(stderr, [&] {
    s.out = caught(stdout,
                   [&] { s.code = run<Scene>(static_cast<int>(words.size()), argv.data(), f); });
  });
  return s;
}

/// One ball that falls onto a floor; its radius, and the direction of gravity.
set_up ball(real radius, real gravity = -9.81) {
  return [=](world<scene>& world, const options& options) {
    world.gravity({0, 0, gravity});
    const auto stone = world.material({.density = 2.8});
    world.global([&](auto& scope) { scope.add(plane{}, stone); });
    world.add_if_local(body{.shape = sphere{radius}, .position = {1, 1, 2 * radius}});
    world.simulate({.steps = options.steps, .dt = options.dt});
  };
}

bool has(const std::string& text, const char* words) { return text.find(words) != text.npos; }

}  // namespace

TEST_CASE("a run in which nothing is wrong is told nothing") {
  const said s = program({"--steps", "300"}, ball(0.5));
  CHECK(s.code == 0);
  CHECK(has(s.out, " on 4 ranks, threads, 300 steps of 0.005\n"));
  CHECK(has(s.out, "\n  traffic  a rank sends at most "));
  CHECK(!has(s.out, "warning"));
  CHECK(!has(s.err, ": "));
}

TEST_CASE("a misspelt option is refused in one line, with the nearest name") {
  const said s = program({"--stps", "3"}, ball(0.5));
  CHECK(s.code == 2);
  CHECK(s.err ==
        "program: '--stps' is not an option of this program; did you mean --steps? see --help\n");
}

TEST_CASE("a number of ranks that the decomposition does not fit is refused with both numbers") {
  const said s = program({"--ranks", "3"}, ball(0.5));
  CHECK(s.code == 1);
  CHECK(has(s.err,
            "program: a grid of 2 x 2 x 1 cells needs exactly 4 ranks, but there are 3: start "
            "the program with that many, or use grid<dynamic>, which fits any number\n"));
}

TEST_CASE("mpirun with a program whose ranks are threads is refused, with what to change") {
  ::setenv("OMPI_COMM_WORLD_SIZE", "4", 1);
  ::setenv("OMPI_COMM_WORLD_RANK", "0", 1);
  const said s = program({}, ball(0.5));
  ::unsetenv("OMPI_COMM_WORLD_SIZE");
  ::unsetenv("OMPI_COMM_WORLD_RANK");
  CHECK(s.code == 1);
  CHECK(has(s.err,
            "program: mpirun started 4 processes, but this program was built with the transport "
            "'threads', which does not connect them"));
  CHECK(has(s.err, "Include \"talus/mpi.hpp\" and choose the transport mpi or as_launched"));
}

TEST_CASE("options that this program has no use for are refused, with what to name in it") {
  CHECK(
      has(program({"--restart", "x.h5"}, ball(0.5)).err,
          "program: this program keeps no checkpoints: name features<checkpoints> in its scenario, "
          "#include <talus/checkpoint.hpp>, and link talus::hdf5\n"));
  CHECK(has(program({"--reproducible"}, ball(0.5)).err,
            "name solver<nonlinear_gauss_seidel, reproducible> in its scenario"));
  CHECK(has(program({"--max-iterations", "50"}, ball(0.5)).err,
            "program: --max-iterations needs --tolerance; see --help\n"));
  CHECK(has(program({"--show-domains"}, ball(0.5)).err,
            "program: --show-domains needs --frames DIR; see --help\n"));
  const std::string help = program({"--help"}, ball(0.5)).out;
  for (const char* name : {"--restart", "--checkpoint", "--output", "--reproducible"})
    CHECK(!has(help, name));
  CHECK(has(help, "--tolerance"));
}

TEST_CASE("--frames in a program without pictures is refused before the first step, quiet or not") {
  for (const char* how : {"--quiet", "--seed=1"}) {
    std::uint64_t steps = 0;
    // An existing folder does not make pictures either.
    const said s = program({"--frames", "/tmp", how}, [&](world<scene>& world, const options& o) {
      if (world.rank() == 0) world.after_each_step([&] { ++steps; });
      ball(0.5)(world, o);
    });
    CHECK(s.code == 2);
    CHECK(steps == 0);
    CHECK(s.err ==
          "program: this program takes no pictures: call take_pictures(world, options) before "
          "world.simulate(...), or leave out --frames\n");
  }
}

TEST_CASE("the name of a decomposition that does not exist is a mistake of the command line") {
  for (const char* name : {"", "gird"}) {
    const said s = program({}, [&](world<scene>&, const options&) {
      (void)named_decomposition(name, {0, 0, 0}, {1, 1, 0});
    });
    CHECK(s.code == 2);
    CHECK(s.err == "program: there is no decomposition '" + std::string(name) +
                       "' for a rectangle: choose grid, slabs, bisection or hexagonal\n");
  }
}

TEST_CASE("a program of soft contacts neither offers nor takes options of a solver") {
  using soft = scenario<bodies<sphere, plane>, soft_contact<hertz_mindlin, coulomb_friction>,
                        decomposition<grid<1, 1>>>;
  const auto fall = [](auto& world, const options& options) {
    world.gravity({0, 0, -9.81});
    const auto stone = world.material({.density = 2.8, .youngs_modulus = 1e6});
    world.global([&](auto& scope) { scope.add(plane{}, stone); });
    world.add_if_local(body{.shape = sphere{0.5}, .position = {0, 0, 0.5}});
    world.simulate({.steps = options.steps, .dt = 1.0 / 3000});
  };
  for (const char* name : {"--iterations", "--tolerance", "--max-iterations"}) {
    const said s = program<soft>({name, "20"}, fall);
    CHECK(s.code == 2);
    CHECK(has(s.err, "program: this program has nothing to iterate: its contacts are soft"));
    CHECK(!has(program<soft>({"--help"}, fall).out, name));
  }
  // One body is "1 body", not "1 bodies", and a length of a step has the significant digits.
  const std::string out = program<soft>({"--steps", "1"}, fall).out;
  CHECK(has(out, "program: 1 body (1 movable), 1 step of 0.000333333\n"));
  CHECK(!has(out, "1 contacts"));
  CHECK(!has(out, " rank"));
}

TEST_CASE("progress counts what simulate was asked for, whatever --steps says") {
  const auto steps = [](std::vector<std::size_t> parts) {
    return program({"--steps", "20"},
                   [=](world<scene>& world, const options& options) {
                     world.gravity({0, 0, -1});
                     world.material({});
                     world.add_if_local(body{.shape = sphere{0.5}});
                     for (const std::size_t n : parts)
                       world.simulate({.steps = n, .dt = options.dt});
                   })
        .err;
  };
  CHECK(has(steps({60}), "step 60 of 60 (100 %)"));
  CHECK(has(steps({12}), "step 12 of 12 (100 %)"));
  CHECK(has(steps({10, 10}), "step 20 of 20 (100 %)"));
  // Before its end a run prints the requested steps of the present call of simulate(), or --steps
  // if the calls are parts of that.
  threads::launch({.ranks = 1}, [](threads::link& link) {
    world<scenario<bodies<sphere>>> w(link);
    w.material({});
    const options o;  // 1000 steps
    std::vector<std::uint64_t> planned;
    w.observe(every{100}, [&](auto& world) { planned.push_back(detail::planned_steps(world, o)); });
    w.simulate({.steps = 100, .dt = 0.01});
    w.simulate({.steps = 100, .dt = 0.01});
    w.simulate({.steps = 1800, .dt = 0.01});
    REQUIRE(planned.size() == 20);
    CHECK(planned[0] == 100);
    CHECK(planned[1] == 1000);
    CHECK(planned[2] == 2000);
  });
}

TEST_CASE("the time of a world is its number of steps times dt, without the round-off of a sum") {
  threads::launch({.ranks = 1}, [](threads::link& link) {
    world<scenario<bodies<sphere>>> w(link);
    w.material({});
    for (int k = 0; k < 3000; ++k) w.step(0.005);
    CHECK(w.time() == 15);
    w.simulate({.steps = 1000, .dt = 0.001});
    CHECK(w.time() == 16);
  });
}

TEST_CASE("the summary counts consistently, and its percentages are 100 together") {
  summary r;
  r.scenario = "pile";
  r.ranks = 2;
  r.transport = "threads";
  r.steps = 1000;
  r.dt = 1.0 / 240;
  r.wall_seconds = 1;
  r.seconds = {0.06, 0.5, 0.06, 0.95};
  r.seconds_mean = {0.015, 0.475, 0, 0.485};
  r.functions_mean = r.functions = {{"other work of steps", 0.0101}, {"height of it", 0.004}};
  r.moving.bodies = r.moving.movable = 1;
  r.overlap.touching = 116;
  r.contacts = 115;
  r.messages_per_step_max = 1;
  r.digest = "0123456789abcdef";
  const std::string text = to_text(r);
  MESSAGE(text);
  CHECK(has(text, "pile: 1 body (1 movable) on 2 ranks, threads, 1000 steps of 0.00416667\n"));
  CHECK(has(text, "  time     1 s of wall time, 1 ms per step; 0 s of CPU time of all ranks, "));
  CHECK(
      has(text,
          "wall time of a rank: search for contacts 2 %, contact solver 47 %,\n"
          "           messages between ranks 49 %, other work of steps 1 %, set-up and the rest 1 "
          "%\n           (less than 1 % each: height of it)\n"));
  CHECK(has(text, "; 116 contacts touch\n"));
  CHECK(has(text, "a rank sends at most 1 message and 0 bytes in a step"));
  CHECK(has(text, "\n  state    digest 0123456789abcdef: "));
  CHECK(has(to_json(r), "\"seconds_height_of_it\": 0.004"));
}

TEST_CASE("a radius of zero and a missing material are refused by name") {
  CHECK(
      has(program({}, ball(0)).err,
          "program: the radius of a sphere must be positive and finite, but is 0; give a positive "
          "value\n"));
  const said s = program({}, [](world<scene>& world, const options&) {
    world.add_if_local(body{.shape = sphere{1}});
  });
  CHECK(has(s.err,
            "program: the world has no material yet: make one with world.material(...) before "
            "adding bodies\n"));
}

TEST_CASE("a body added on a rank that does not own its place is refused, with the owner") {
  const said s = program({}, [](world<scene>& world, const options&) {
    world.decompose({.lower = {-5, -5}, .upper = {5, 5}});
    world.material({});
    world.exclusive(0, [&] { world.add(body{.shape = sphere{1}, .position = {3, 3, 1}}); });
  });
  CHECK(s.code == 1);
  CHECK(has(s.err,
            "program: rank 0 cannot add a sphere at (3, 3, 1), which is in the domain of rank 3: "
            "ask world.contains(...) first, or use add_if_local or fill\n"));
}

TEST_CASE("a set-up that never simulates is told so") {
  const said s = program({}, [](world<scene>& world, const options&) {
    world.gravity({0, 0, -1});
  });
  CHECK(s.code == 0);
  CHECK(has(s.err,
            "program: no step was made: call world.simulate({.steps = options.steps, .dt = "
            "options.dt}) at the end of the set-up\n"));
  CHECK(has(s.out,
            "warning  there is no body: make some by world.fill, add_if_local or add before "
            "world.simulate\n"));
  CHECK(!has(program({"--steps", "0"}, ball(0.5)).err, "no step was made"));
}

TEST_CASE("results that differ between ranks are told, with the one that is reported") {
  const auto returned = [](auto value) {
    return program({}, [=](world<scene>& world, const options& options) {
      ball(0.5)(world, options);
      return value(world);
    });
  };
  const auto differ = returned([](world<scene>& world) {
    return results{{"alike", -2.5}, {"largest_pull", 3.0 - world.rank()}};
  });
  CHECK(differ.code == 0);
  CHECK(has(differ.err,
            "program: warning: ranks return different results, and those of rank 0 are reported: "
            "'largest_pull' is 3 on rank 0, and from 0 to 3 over all ranks; combine the values "
            "before they are returned, as by world.link().reduce(reduction::max, values)\n"));
  CHECK(has(differ.out, "largest_pull 3"));
  const auto some = returned([](world<scene>& world) {
    return world.rank() == 2 ? results{{"height", 1}} : results{};
  });
  CHECK(has(some.err,
            "program: warning: ranks return between 0 and 1 results, and those of rank 0 are "
            "reported: return the same results on all ranks\n"));
  const auto alike = returned([](world<scene>& world) {
    double pull = 3.0 - world.rank();
    world.link().reduce(reduction::max, {&pull, 1});
    return results{{"largest_pull", pull}, {"none", std::nan("")}};
  });
  CHECK(!has(alike.err, "warning"));
}

TEST_CASE("bodies that begin inside each other are told, on any rank, and where they are") {
  const auto at = [](vec3 first, vec3 second) {
    return program({"--steps", "1"}, [=](world<scene>& world, const options& options) {
      world.gravity({0, 0, -1});
      const auto stone = world.material({});
      world.global([&](auto& scope) { scope.add(plane{}, stone); });
      world.add_if_local(body{.shape = sphere{1}, .position = first});
      world.add_if_local(body{.shape = sphere{0.5}, .position = second});
      world.simulate({.steps = options.steps, .dt = options.dt});
    });
  };
  const said sunk = at({-3, -3, 1}, {3, 3, 0.25});
  CHECK(has(sunk.err, "program: warning: the sphere "));
  CHECK(has(sunk.err,
            " at (3, 3, 0.25) begins 0.25 deep in the plane 0x4000000000000000 with the normal "
            "(0, 0, 1), 0.5 of half the thickness of the thinner one: contacts will push them "
            "apart, perhaps fast; leave room between bodies at the start\n"));
  const said across = at({-0.5, 2, 3}, {0.5, 2, 3});  // of two ranks: printed once
  CHECK(has(across.err, "begins 0.5 deep in the sphere "));
  CHECK(across.err.find("warning") == across.err.rfind("warning"));
  CHECK(!has(at({-3, -3, 1}, {3, 3, 0.46}).err, "warning"));  // by less than a tenth
}

TEST_CASE("without gravity, where nothing moves, the summary says so") {
  const said s = program({"--steps", "10"}, ball(0.5, 0));
  CHECK(has(s.out,
            "warning  nothing moves, and there is no gravity: call world.gravity({0, 0, -9.81}) "
            "before world.simulate\n"));
}

TEST_CASE("a step that is far too long is called so, with how far things move in it") {
  CHECK(
      has(program({"--steps", "3", "--dt", "0.5"}, ball(0.5)).out,
          "warning  in one step of 0.5 gravity moves a body by 4.9 of the mean radius 0.5: take a "
          "smaller dt, or see whether lengths, gravity and dt have units that fit together\n"));
  const said fast = program({"--steps", "1"}, [](world<scene>& world, const options& options) {
    world.material({});
    world.add_if_local(body{.shape = sphere{0.5}, .velocity = {400, 0, 0}});
    world.simulate({.steps = options.steps, .dt = options.dt});
  });
  CHECK(has(fast.out,
            "warning  in one step of 0.005 the fastest body moves by 4 of the mean radius 0.5: "
            "take a smaller dt, or name features<continuous_collision>\n"));
}

TEST_CASE("lengths in millimetres and gravity in metres are noticed, either way round") {
  CHECK(has(
      program({"--steps", "1000"}, ball(500)).out,
      "warning  in all 1000 steps of 0.005 gravity moves a body by no more than 0.25 of the mean "
      "radius 500: see whether lengths, gravity and dt have units that fit together\n"));
  CHECK(has(program({"--steps", "3"}, ball(0.5, -9810)).out,
            "warning  in one step of 0.005 gravity moves a body by 0.49 of the mean radius 0.5"));
}

TEST_CASE("whoever sinks into light bodies under a heavy one is warned, whatever the residual is") {
  using table = scenario<bodies<sphere, box, plane>, decomposition<grid<1, 1>>>;
  for (const int iterations : {1, 10}) {
    real height = 0;
    std::uint64_t stopped_in = 0;
    // Of one layer of light spheres, loaded with 1e6 times their weight.
    const said s = program<table>(
        {"--steps", "40", "--iterations", std::to_string(iterations), "--dt", "0.01"},
        [&](auto& world, const options& options) {
          world.gravity({0, 0, -9.81});
          const auto light = world.material({.density = 1}),
                     heavy = world.material({.density = 1e5});
          world.global([&](auto& scope) { scope.add(plane{}, light); });
          for (int k = 0; k < 36; ++k)
            world.add(sphere{0.5}, light, {k % 6 + 0.5, k / 6 + 0.5, 0.5});
          const auto load = world.add(box{{6, 6, 1}}, heavy, {3, 3, 1.5});
          world.simulate({.steps = options.steps, .dt = options.dt});
          height = world[load].position()[2];
          stopped_in = world.steps();
        });
    CAPTURE(s.out);
    CHECK(stopped_in == 40);
    CHECK(has(s.out, "fixed bodies bear "));
    CHECK(has(s.out, "largest overlap "));
    CHECK(has(s.out, "warning  bodies overlap by up to ") == (height < 1.45));
    if (height > 1.499) CHECK(!has(s.out, "warning"));
  }
}

TEST_CASE("the summary and its JSON file have the momentum balance and the overlap, with bounds") {
  summary r;
  r.moving.bodies = r.moving.movable = 2;
  r.steps = 600;
  r.gravity = 9.81;
  r.dt = 0.005;
  r.overlap.mean_radius = r.moving.max_speed = 0.5;
  r.overlap.deepest = 0.049;
  r.balance_of_forces = {
      .known = true, .borne = 1.44, .change = 0.44, .error = 1e-15, .unstopped = 0.9};
  CHECK(!has(to_text(r), "warning"));
  CHECK(has(to_text(r),
            "fixed bodies bear 1.44 of the weight of the others (1 at rest); touching bodies still "
            "approach with 0.9 of the momentum that gravity gives in a step\n"));
  CHECK(has(to_text(r), "largest overlap at the end 0.049 of the radius of the smaller body; "));
  CHECK(has(to_json(r), "\"balance_borne_weight\": 1.44"));
  CHECK(has(to_json(r), "\"balance_beyond_bound\": false"));
  CHECK(has(to_json(r), "\"overlap_over_radius\": 0.049"));
  r.overlap.deepest = 0.53;
  r.balance_of_forces.unstopped = 34;
  CHECK(has(to_text(r),
            "warning  bodies overlap by up to 0.53 of their radius, more than 0.05, whatever the "
            "residual says: allow more iterations (--iterations, or --tolerance), take a smaller "
            "dt, or put less weight on light bodies\n"));
  CHECK(has(to_text(r),
            "warning  the momentum balance is wrong: bodies go on into those that they touch, with "
            "34 times the impulse of the weight in a step (at most 1), while what is fixed bears "
            "1.44 of the weight"));
  CHECK(has(to_json(r), "\"balance_beyond_bound\": true"));
  CHECK(has(to_json(r), "\"overlap_beyond_bound\": true"));
  r.balance_of_forces = {.known = true, .error = 1e-3};
  CHECK(has(to_text(r), "warning  the momentum balance does not close"));
}
