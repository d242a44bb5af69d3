// timeout: 300
// Bodies with a mass, an inertia and a centre of their own: they move as closed forms say, on any
// ranks, and impossible values are refused.
#include <doctest/doctest.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <mutex>
#include <set>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/constraint/ball_joint.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/motion.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/scene/region.hpp>
#include <talus/shape/triangle_mesh.hpp>
#include <talus/shape/union_of.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

using ball = union_of<sphere>;
using brick = union_of<box>;
using toys =
    scenario<bodies<sphere, box, ball, brick, plane>, joints<ball_joint>, solver<reproducible>,
             decomposition<grid<dynamic, dynamic>>, transport<threads>, features<checkpoints>>;
using toy_world = world<toys>;

constexpr real g = 9.81;

/// Calls f(world, material) on one rank, with gravity and a rough floor.
template <class F>
void on_floor(const vec3& gravity, F&& f) {
  threads::launch({.ranks = 1}, [&](auto& link) {
    toy_world w(link);
    w.gravity(gravity);
    w.solver().iterations = 50;
    const auto stuff = w.material({.density = 2, .restitution = 0, .friction = 5});
    w.global([&](auto& s) { s.add(plane{}, stuff); });
    f(w, stuff);
  });
}

/// The period of a value that swings about zero, from its first and last rise through it.
struct period_of_swings {
  real before = 0, first = 0, last = 0;
  int rises = 0;
  void add(real time, real dt, real value) {
    if (time > 0 && before < 0 && value >= 0) {
      last = time - dt * value / (value - before);
      if (rises++ == 0) first = last;
    }
    before = value;
  }
  [[nodiscard]] real value() const { return (last - first) / (rises - 1); }
};

std::string refusal(const std::function<void()>& f) {
  try {
    f();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a mass of its own scales the inertia of the shape") {
  on_floor({0, 0, 0}, [](toy_world& w, material_id) {
    const auto heavy = w.add(body{.shape = sphere{0.5}, .position = {0, 0, 5}, .mass = 3});
    CHECK(w[heavy].mass() == doctest::Approx(3).epsilon(1e-15));
    CHECK(w[heavy].inertia()[1] == doctest::Approx(3 * 0.4 * 0.25).epsilon(1e-15));
    const auto light = w.add(body{.shape = box{{1, 2, 3}}, .position = {5, 0, 5}, .density = 0.5});
    CHECK(w[light].mass() == doctest::Approx(3).epsilon(1e-15));
    const auto usual = w.add(body{.shape = box{{1, 2, 3}}, .position = {9, 0, 5}});
    CHECK(w[usual].mass() == 12);
    CHECK(measure_motion(w).mass == doctest::Approx(18).epsilon(1e-14));
    // Fixed and released, it has the mass that it had.
    w[heavy].fix();
    CHECK(w[heavy].mass() == doctest::Approx(3).epsilon(1e-15));
    w[heavy].fix();
    w.step(1e-3);
    CHECK(w[heavy].position() == vec3(0, 0, 5));
    w[heavy].release();
    w[heavy].release();
    CHECK(w[heavy].mass() == doctest::Approx(3).epsilon(1e-15));
    w[heavy].set_velocity({1, 2, 3});
    CHECK(measure_motion(w).momentum[0] == doctest::Approx(3).epsilon(1e-14));
    w[heavy].set_velocity({0, 0, 0});
    // A mass that differs in the last bit from density times volume.
    const real usual_mass = 2 * sphere{0.3}.volume();
    const auto close = w.add(
        body{.shape = sphere{0.3}, .position = {-5, 0, 5}, .mass = std::nextafter(usual_mass, 9.)});
    w[close].fix();
    w[close].release();
    CHECK(w[close].mass() == doctest::Approx(usual_mass).epsilon(1e-15));
    w.destroy(close);
    const auto held =
        w.add(body{.shape = sphere{0.5}, .position = {-5, 0, 5}, .fixed = true, .mass = 7});
    CHECK(w[held].mass() == doctest::Approx(7).epsilon(1e-15));
    w[held].release();
    CHECK(w[held].mass() == doctest::Approx(7).epsilon(1e-15));
    w.destroy(held);
    w[usual].fix();
    w[usual].release();
    CHECK(w[usual].mass() == 12);
  });
}

TEST_CASE("an inertia or a centre of its own moves no point of a body") {
  on_floor({0, 0, 0}, [](toy_world& w, material_id) {
    // Its frame is neither at the origin of its coordinates nor along their axes.
    const ball u({{.shape = sphere{0.5}, .at = {{1, 2, 3}}},
                  {.shape = sphere{0.4}, .at = {{1.7, 2.2, 3.3}}},
                  {.shape = sphere{0.3}, .at = {{1, 1.4, 3.2}}}});
    const vec3 at(3, 4, 9);
    const quat turn = rotation({1, 2, 3}, 0.8);
    const auto usual = w.add(body{.shape = u, .position = at, .orientation = turn});
    const pose expected = given_frame(w[usual].shape(), w[usual].pose());
    CHECK(w[usual].position() == at);
    const auto check = [&](const body<ball>& b, const vec3& centre) {
      const auto h = w.add(b);
      const pose now = given_frame(w[h].shape(), w[h].pose());
      CHECK((now.position - expected.position).norm() < 1e-13);
      CHECK(std::abs(now.orientation.dot(expected.orientation)) ==
            doctest::Approx(1).epsilon(1e-14));
      CHECK((w[h].position() - expected.to_world(centre)).norm() < 1e-13);
    };
    const vec3 own = u.frame().position, moved = own + vec3(0.1, -0.2, 0.05);
    check({.shape = u, .position = at, .orientation = turn, .mass = 2}, own);
    check({.shape = u, .position = at, .orientation = turn, .inertia = {1, 1.5, 2}}, own);
    check({.shape = u, .position = at, .orientation = turn, .centre = moved}, moved);
    check({.shape = u,
           .position = at,
           .orientation = turn,
           .mass = 2,
           .inertia = mat3(1, 0.1, 0, 0.1, 1.5, 0.2, 0, 0.2, 2),
           .centre = moved},
          moved);
  });
}

TEST_CASE("bodies of one form with different masses share one union") {
  on_floor({0, 0, 0}, [](toy_world& w, material_id) {
    w.seed(3);
    const real r = 0.4;
    std::set<const sphere*> forms;
    w.fill(
        simple_cubic{.spacing = 1, .origin = {0.5, 0.5, 0.5}} & box_region{{0, 0, 0}, {10, 10, 3}},
        [&](const site& place, random_stream& random) {
          const real m = random.uniform(0.1, 9);
          return body{.shape = ball{sphere{r}},
                      .position = place.position,
                      .mass = m,
                      .inertia = mat3(0.4, 0.1, 0, 0.1, 0.5, 0.03, 0, 0.03, 0.3) * (m * r * r)};
        });
    std::size_t bodies = 0;
    w.for_each_local([&](auto& b) {
      if constexpr (requires { b.shape().parts(); }) {
        ++bodies;
        b.shape().each_part([&](const auto& s, const pose&) {
          if constexpr (std::is_same_v<std::remove_cvref_t<decltype(s)>, sphere>) forms.insert(&s);
        });
        CHECK(detail::trace(detail::diagonal_matrix(b.inertia())) ==
              doctest::Approx(1.2 * b.mass() * r * r).epsilon(1e-13));
      }
    });
    CHECK(bodies == 300);
    // More than one where a number is close to the middle between two roundings.
    CHECK(forms.size() <= 8);
  });
}

TEST_CASE(
    "a hollow ball rolls down a slope at three fifths of g sin, a full one at five sevenths") {
  const real slope = 0.3, m = 0.7, r = 0.5;
  on_floor({g * std::sin(slope), 0, -g * std::cos(slope)}, [&](toy_world& w, material_id) {
    const auto hollow = w.add(body{
        .shape = ball{sphere{r}}, .position = {0, 0, r}, .mass = m, .inertia = 2. / 3 * m * r * r});
    const auto full = w.add(body{.shape = ball{sphere{r}}, .position = {0, 5, r}, .mass = m});
    for (int k = 0; k < 1000; ++k) w.step(1e-3);
    const real fall = g * std::sin(slope) * w.time();
    MESSAGE("hollow ", w[hollow].velocity()[0] / fall, ", full ", w[full].velocity()[0] / fall);
    CHECK(w[hollow].velocity()[0] == doctest::Approx(0.6 * fall).epsilon(1e-6));
    CHECK(w[full].velocity()[0] == doctest::Approx(5. / 7 * fall).epsilon(1e-6));
    CHECK(w[hollow].angular_velocity()[1] == doctest::Approx(0.6 * fall / r).epsilon(1e-6));
  });
}

TEST_CASE("a sphere with a low centre swings on a plane at the frequency of the closed form") {
  // w^2 = m g h / (I + m (r - h)^2) for the centre h below that of the sphere.
  const real m = 1.3, r = 0.5, h = 0.2, moment = 0.09;
  const real expected = 2 * pi / std::sqrt(m * g * h / (moment + m * (r - h) * (r - h)));
  on_floor({0, 0, -g}, [&](toy_world& w, material_id) {
    const real tilt = 0.01, dt = 1e-4;
    const auto toy = w.add(body{.shape = ball{sphere{r}},
                                .position = {0, 0, r},
                                .orientation = rotation({0, 1, 0}, tilt),
                                .mass = m,
                                .inertia = {moment, moment, 0.07},
                                .centre = {0, 0, -h}});
    CHECK((w[toy].position() - vec3(-h * std::sin(tilt), 0, r - h * std::cos(tilt))).norm() <
          1e-15);
    period_of_swings swings;
    for (int k = 0; k < 60000; ++k) {
      w.step(dt);
      swings.add(w.time(), dt, w[toy].angular_velocity()[1]);
    }
    MESSAGE("period ", swings.value(), " of ", expected, ", relative error ",
            swings.value() / expected - 1, ", swings ", swings.rises);
    CHECK(swings.rises >= 3);
    CHECK(swings.value() == doctest::Approx(expected).epsilon(1e-4));
    const pose sphere_at = given_frame(w[toy].shape(), w[toy].pose());
    CHECK(sphere_at.position[2] == doctest::Approx(r).epsilon(1e-4));
  });
}

TEST_CASE("a tumbler rights itself, and a sphere with its centre in the middle does not") {
  on_floor({0, 0, -g}, [&](toy_world& w, material_id) {
    const auto up = [&](auto h) {
      return rotated(given_frame(w[h].shape(), w[h].pose()).orientation, vec3(0, 0, 1))[2];
    };
    const auto one = [&](real x, real centre) {
      return w.add(body{.shape = ball{sphere{0.5}},
                        .position = {x, 0, 0.5},
                        .orientation = rotation({1, 0, 0}, 2.5),
                        .mass = 1,
                        .inertia = 0.08,
                        .centre = {0, 0, centre}});
    };
    const auto tumbler = one(0, -0.25), even = one(5, 0);
    CHECK(up(tumbler) < -0.8);
    const real start = up(even);
    // The air slows it down.
    for (int k = 0; k < 40000; ++k) {
      w.step(1e-3);
      w[tumbler].set_velocity(0.9995 * w[tumbler].velocity());
      w[tumbler].set_angular_velocity(0.9995 * w[tumbler].angular_velocity());
    }
    CHECK(up(tumbler) > 0.999);
    CHECK(up(even) == doctest::Approx(start).epsilon(1e-6));
  });
}

TEST_CASE("a loaded die on a slope topples where its centre passes the edge") {
  // A cube of edge 1 with its centre of mass 0.3 upslope: tan = (0.5 + 0.3) / 0.5, not 1.
  for (const real off : {-0.3, 0., 0.3})
    for (const bool beyond : {false, true}) {
      CAPTURE(off);
      CAPTURE(beyond);
      const real slope = std::atan((0.5 - off) / 0.5) + (beyond ? 0.01 : -0.01);
      on_floor({g * std::sin(slope), 0, -g * std::cos(slope)}, [&](toy_world& w, material_id) {
        const auto die = w.add(
            body{.shape = brick{box{{1, 1, 1}}}, .position = {0, 0, 0.5}, .centre = {off, 0, 0}});
        for (int k = 0; k < 1500; ++k) w.step(1e-3);
        const real turned = given_frame(w[die].shape(), w[die].pose())
                                .orientation.angularDistance(quat(1, 0, 0, 0));
        CHECK((std::abs(turned) > 0.3) == beyond);
      });
    }
}

TEST_CASE("a body with its centre aside falls and spins about that centre") {
  on_floor({0, 0, -g}, [&](toy_world& w, material_id) {
    const auto thrown = w.add(body{.shape = ball{sphere{0.5}},
                                   .position = {0, 0, 50},
                                   .velocity = {1, 2, 3},
                                   .angular_velocity = {0, 0, 4},
                                   .mass = 2,
                                   .inertia = {0.2, 0.3, 0.35},
                                   .centre = {0.3, 0, 0}});
    CHECK(w[thrown].position() == vec3(0.3, 0, 50));
    const auto [e0, l0] = [&] {
      const auto m = measure_motion(w);
      return std::pair{m.kinetic_energy, m.potential_energy};
    }();
    CHECK(e0 == doctest::Approx(0.5 * 2 * 14 + 0.5 * 0.35 * 16).epsilon(1e-14));
    CHECK(l0 == doctest::Approx(2 * g * 50).epsilon(1e-14));
    const int n = 1000;
    for (int k = 0; k < n; ++k) w.step(1e-3);
    const vec3 at = w[thrown].position();
    CHECK(at[0] == doctest::Approx(1.3).epsilon(1e-12));
    CHECK(at[1] == doctest::Approx(2).epsilon(1e-12));
    const vec3 middle = given_frame(w[thrown].shape(), w[thrown].pose()).position;
    CHECK((middle - at - 0.3 * vec3(-std::cos(4.), -std::sin(4.), 0)).norm() < 1e-9);
  });
}

TEST_CASE("a pendulum that hangs from the middle of its shape swings by its own centre") {
  // w^2 = m g h / (I + m h^2) about the middle of the cube, h above the centre of mass.
  const real m = 2, h = 0.25, moment = 0.3;
  const real expected = 2 * pi / std::sqrt(m * g * h / (moment + m * h * h));
  on_floor({0, 0, -g}, [&](toy_world& w, material_id) {
    const real tilt = 0.01, dt = 5e-4;
    std::optional<handle<box>> post;
    w.global([&](auto& s) {
      post = s.add(body{.shape = box{{0.1, 0.1, 0.1}}, .position = {0, 0, 9}});
    });
    const auto bob = w.add(body{.shape = brick{box{{1, 1, 1}}},
                                .position = {0, 0, 5},
                                .orientation = rotation({0, 1, 0}, tilt),
                                .mass = m,
                                .inertia = {moment, moment, 0.4},
                                .centre = {0, 0, -h}});
    w.join(post, std::optional(bob), ball_joint{.at = {0, 0, 5}});
    period_of_swings swings;
    for (int k = 0; k < 30000; ++k) {
      w.step(dt);
      swings.add(w.time(), dt, w[bob].angular_velocity()[1]);
    }
    MESSAGE("period ", swings.value(), " of ", expected, ", relative error ",
            swings.value() / expected - 1, ", swings ", swings.rises);
    CHECK(swings.rises > 4);
    CHECK(swings.value() == doctest::Approx(expected).epsilon(1e-4));
  });
}

TEST_CASE("the centre of mass owns the body, and ranks and restarts do not change it") {
  const std::string file = "/tmp/talus_own_mass_" + std::to_string(getpid()) + ".h5";
  std::mutex mutex;
  std::string whole, at_once;
  const auto run = [&](int ranks, std::uint64_t from, std::uint64_t to, std::uint64_t write_after) {
    std::string digest;
    threads::launch({.ranks = ranks}, [&](auto& link) {
      toy_world w(link);
      const int across = ranks == 4 ? 2 : 1;
      w.decompose({.cells = {ranks / across, across}, .lower = {-2, -2}, .upper = {2, 2}});
      w.gravity({0, 0, -g});
      const auto stuff = w.material({.density = 2, .restitution = 0.2, .friction = 0.5});
      w.global([&](auto& s) { s.add(plane{}, stuff); });
      // Centres up to 0.3 from the sites, so many are with another rank.
      w.seed(5);
      const auto made =
          w.fill(simple_cubic{.spacing = 1, .origin = {0.02, 0.02, 0.5}} &
                     box_region{{-2, -2, 0.4}, {2, 2, 3}},
                 [&](const site& place, random_stream& random) {
                   const real r = random.uniform(0.3, 0.48);
                   return body{.shape = ball{sphere{r}},
                               .position = place.position,
                               .material = stuff,
                               .orientation = random.rotation(),
                               .mass = random.uniform(0.5, 2),
                               .inertia = mat3(0.1, 0.01, 0, 0.01, 0.09, 0.02, 0, 0.02, 0.08),
                               .centre = {0.6 * r, 0, 0}};
                 });
      (void)made;
      const bool fresh = from == 0;
      if (!fresh) CHECK(read_checkpoint(w, file).empty());
      if (fresh) {
        w.synchronize();
        w.for_each_local([&](auto& b) { CHECK(w.contains(b.position())); });
        CHECK(w.audit().bodies == 48);
      }
      for (std::uint64_t k = from; k < to; ++k) {
        w.step(0.005);
        // Some are fixed for a while, in which a checkpoint is written.
        w.for_each_local([&](auto& b) {
          if (value_of(b.id()) % 5 != 0) return;
          if (w.steps() == 20) b.fix();
          if (w.steps() == 110) {
            CHECK(b.is_fixed());
            CHECK(b.mass() >= 0.5);
            b.release();
          }
        });
        if (w.steps() == write_after) write_checkpoint(w, file);
      }
      CHECK(w.audit().bodies == 48);
      real least = 9, most = 0;
      w.for_each_local([&](auto& b) {
        least = std::min(least, b.mass()), most = std::max(most, b.mass());
        if constexpr (requires { b.shape().parts(); }) {
          const real tensor = b.inertia()[0] + b.inertia()[1] + b.inertia()[2];
          CHECK(tensor == doctest::Approx(0.27).epsilon(1e-12));
        }
      });
      CHECK(least >= 0.5);
      CHECK(most <= 2);
      const std::string d = state_digest(w);
      const std::lock_guard lock(mutex);
      if (link.rank() == 0) digest = d;
    });
    return digest;
  };
  const std::string one = run(1, 0, 200, 0);
  CHECK(run(2, 0, 200, 0) == one);
  CHECK(run(4, 0, 200, 100) == one);
  CHECK(run(4, 100, 200, 0) == one);
  CHECK(run(2, 100, 200, 0) == one);
  unlink(file.c_str());
}

TEST_CASE("impossible masses are refused with their numbers") {
  on_floor({0, 0, 0}, [](toy_world& w, material_id) {
    const real nan = std::nan("");
    const auto says = [&](const auto& b, std::initializer_list<const char*> words) {
      const std::string message = refusal([&] { w.add(b); });
      for (const char* word : words) {
        INFO(message);
        CHECK(message.find(word) != std::string::npos);
      }
    };
    const sphere s{0.5};
    const vec3 at(1, 2, 3);
    says(body{.shape = s, .position = at, .mass = 0},
         {"the mass of a sphere at (1, 2, 3) must be a finite number above 0, but is 0: leave "
          ".mass out "
          "for "
          "density times volume"});
    says(body{.shape = s, .position = at, .mass = 1e-320},
         {"the mass of a sphere at (1, 2, 3) is", "beyond what numbers can hold"});
    says(body{.shape = s, .position = at, .mass = 3e-308},
         {"a moment of inertia of a sphere", "beyond what numbers can hold"});
    // A shape that nothing can move gets no advice about unions.
    const auto says_of_mesh = [&](const body<triangle_mesh>& b, const char* words) {
      const std::string message = refusal([&] { detail::require_sane(b, w.materials()); });
      INFO(message);
      CHECK(message == words);
    };
    const triangle_mesh sheet(
        std::vector<triangle_mesh::triangle>{{vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 1, 0)}});
    says_of_mesh({.shape = sheet, .position = at, .fixed = true, .mass = 1},
                 "a triangle_mesh at (1, 2, 3) is given a .mass of its own, but nothing can move a "
                 "triangle_mesh: leave it out");
    says_of_mesh({.shape = sheet, .position = at, .fixed = true, .centre = {0, 0, 0}},
                 "a triangle_mesh at (1, 2, 3) is given a .centre of its own, but nothing can move "
                 "a triangle_mesh: leave it out");
    w.global([&](auto& scope) {
      CHECK(refusal([&] {
              scope.add(body{.shape = plane{}, .density = 2});
            }).find("nothing can move a plane") != std::string::npos);
    });
    says(body{.shape = s, .position = at, .mass = nan}, {"the mass of a sphere", "nan"});
    says(body{.shape = s, .position = at, .mass = -1}, {"is -1", "leave .mass out"});
    says(body{.shape = s, .position = at, .density = 0}, {"the density of a sphere", "is 0"});
    says(body{.shape = s, .position = at, .density = 2, .mass = 3},
         {"a sphere at (1, 2, 3) is given the mass 3 and the density 2: leave one of the two out"});
    says(body{.shape = s, .position = at, .inertia = 1},
         {"a sphere at (1, 2, 3) is given an .inertia of its own, and only unions have one: make a "
          "union of one part, union_of<sphere>(shape), and name it among the bodies of the "
          "scenario"});
    says(body{.shape = s, .position = at, .centre = {0, 0, 0.1}},
         {"a .centre of its own", "union_of<sphere>"});
    const ball u{s};
    says(body{.shape = u, .position = at, .inertia = {1, 0, 1}}, {"(1, 0, 1)", "above 0"});
    says(body{.shape = u, .position = at, .inertia = {1, -2, 1}},
         {"principal moments", "-2", "above 0"});
    says(
        body{.shape = u, .position = at, .inertia = {1, 2, 3.5}},
        {"the inertia of a union_of at (1, 2, 3) has the principal moments (1, 2, 3.5), and 3.5 is "
         "more than the sum 3 of the other two, which no distribution of mass has: correct the "
         "largest one, or leave .inertia out for that of the shape"});
    says(body{.shape = u, .position = at, .inertia = mat3(1, 0.2, 0, 0.1, 1, 0, 0, 0, 1)},
         {"not symmetric", "0 and 1", "0.2 and 0.1"});
    says(body{.shape = u, .position = at, .inertia = mat3(1, 2, 0, 2, 1, 0, 0, 0, 1)},
         {"principal moments", "above 0"});
    says(body{.shape = u, .position = at, .inertia = nan}, {"finite"});
    says(body{.shape = u, .position = at, .centre = {0, nan, 0}}, {"the centre of mass", "nan"});
    says(body{.shape = u, .position = at, .centre = {0, 0, -300}},
         {"the centre of mass (0, 0, -300) of a union_of at (1, 2, 3) is 600 radii from the middle "
          "of the shape, where the body has no mass: give .centre in the coordinates of the shape, "
          "not in those of the world"});
    // Of a shape whose coordinates begin elsewhere.
    const ball far({{.shape = s, .at = {{7, 0, 0}}}});
    says(body{.shape = far, .position = at, .centre = {0, 0, 0}}, {"14 radii"});
    CHECK(refusal([&] {
            w.add(body{.shape = far, .position = {9, 9, 9}, .centre = {7.4, 0, 0}});
          }).empty());
    w.global([&](auto& scope) {
      CHECK(refusal([&] { scope.add(body{.shape = s, .mass = 2}); }).find("is global and") !=
            std::string::npos);
    });
    // A flat plate is possible.
    CHECK(refusal([&] { w.add(body{.shape = u, .position = at, .inertia = {1, 2, 3}}); }).empty());
  });
}
