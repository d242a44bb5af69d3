// What the first runs of a new user are told, by run(): on standard error, and in the summary. The
// table in docs/messages.md has them all.
// plain
#include <doctest/doctest.h>
#include <unistd.h>

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

/// What goes through a file descriptor while f() runs.
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
said program(std::vector<std::string> words, const set_up& f) {
  words.insert(words.begin(), "program");
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  said s;
  s.err = caught(stderr, [&] {
    s.out = caught(stdout,
                   [&] { s.code = run<scene>(static_cast<int>(words.size()), argv.data(), f); });
  });
  return s;
}

/// One ball that falls onto a floor; its radius, and where gravity points.
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
  CHECK(has(s.out, "on 4 rank(s), threads"));
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
  CHECK(has(program({"--frames", "no/such/folder", "--steps", "1"}, ball(0.5)).err,
            "program: this program takes no pictures: call take_pictures(world, options) before "
            "world.simulate(...), or leave out --frames\n"));
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
            " at (3, 3, 0.25) begins 0.25 deep in the plane 0x4000000000000000, 0.5 of half "
            "the thickness of the thinner one: contacts will push them apart, perhaps fast; leave "
            "room between bodies at the start\n"));
  const said across = at({-0.5, 2, 3}, {0.5, 2, 3});  // of two ranks: said once
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
