// Inflow, outflow, sizes, packings from files, and force fields.
#include <doctest/doctest.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <fstream>
#include <map>
#include <mutex>
#include <sstream>
#include <string>
#include <talus/observe/digest.hpp>
#include <talus/observe/penetration.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/fluid.hpp>
#include <talus/scene/force_field.hpp>
#include <talus/scene/inflow.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/scene/outflow.hpp>
#include <talus/scene/packing.hpp>
#include <talus/scene/region.hpp>
#include <talus/scene/sizes.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

using scene = scenario<bodies<sphere, plane>, solver<reproducible>, transport<threads>,
                       decomposition<grid<dynamic, dynamic>>, features<forces>>;

/// Runs program(world) on each of `ranks` ranks that divide the square from -4 to 4.
template <class Program>
void on(int ranks, Program&& program) {
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<scene> w(link, {.lower = {-4, -4}, .upper = {4, 4}});
    w.material({.density = 2, .restitution = 0.3, .friction = 0.3});
    program(w);
  });
}
template <class World>
double sum_of(World& w, double mine) {
  w.link().reduce(reduction::sum, std::span(&mine, 1));
  return mine;
}

struct scratch_file {
  std::string name = "/tmp/talus_packing_" + std::to_string(getpid()) + ".csv";
  explicit scratch_file(const std::string& text) { std::ofstream(name) << text; }
  ~scratch_file() { unlink(name.c_str()); }
};
std::string refusal_of(const std::string& text) {
  const scratch_file file(text);
  try {
    (void)read_packing(file.name);
  } catch (const std::runtime_error& e) {
    return std::string(e.what()).substr(file.name.size());
  }
  return "none";
}

}  // namespace

TEST_CASE("sizes have the moments of their distributions") {
  random_stream random(7);
  const int n = 100000;
  real sum = 0, squares = 0;
  const uniform_size flat{.lower = 1, .upper = 3};
  for (int k = 0; k < n; ++k) {
    const real x = flat(random);
    sum += x, squares += x * x;
  }
  CHECK(sum / n == doctest::Approx(2).epsilon(0.005));
  CHECK(squares / n == doctest::Approx(4 + 1.0 / 3).epsilon(0.005));

  // Bounds two sigma away on either side: the variance of the logarithm is 0.7737 sigma^2.
  const lognormal_size crushed{
      .median = 2, .sigma = 0.3, .lower = 2 * std::exp(-0.6), .upper = 2 * std::exp(0.6)};
  sum = squares = 0;
  for (int k = 0; k < n; ++k) {
    const real size = crushed(random), x = std::log(size / 2);
    REQUIRE(size >= crushed.lower);
    REQUIRE(size <= crushed.upper);
    sum += x, squares += x * x;
  }
  CHECK(std::abs(sum / n) < 0.003);
  CHECK(squares / n == doctest::Approx(0.7737 * 0.09).epsilon(0.01));

  const sieve_curve sand(
      {{.size = 1, .mass = 10}, {.size = 2, .mass = 60}, {.size = 4, .mass = 30}});
  std::map<real, real> mass;
  real all = 0;
  for (int k = 0; k < n; ++k) {
    const real x = sand(random);
    mass[x] += x * x * x, all += x * x * x;
  }
  CHECK(mass[1] / all == doctest::Approx(0.1).epsilon(0.03));
  CHECK(mass[2] / all == doctest::Approx(0.6).epsilon(0.03));
  CHECK(mass[4] / all == doctest::Approx(0.3).epsilon(0.06));

  CHECK_THROWS_AS((uniform_size{.lower = 2, .upper = 1}(random)), std::invalid_argument);
  CHECK_THROWS_AS((lognormal_size{.median = 1, .sigma = 0.1, .lower = 50, .upper = 60}(random)),
                  std::invalid_argument);
  CHECK_THROWS_AS(sieve_curve({}), std::invalid_argument);
  CHECK_THROWS_AS(sieve_curve({{.size = 1, .mass = 0}}), std::invalid_argument);
}

TEST_CASE("packings are read, and bad rows are refused by their number") {
  const scratch_file file(
      "# made elsewhere\nr, x, y,z, vz,colour\n0.5,1,2,3,-1,red\n\n1e-1,-1,0,0,0,\n");
  const packing heap = read_packing(file.name);
  REQUIRE(heap.size() == 2);
  CHECK(heap[0].radius == 0.5);
  CHECK(heap[0].velocity == vec3(0, 0, -1));
  on(4, [&](auto& w) {
    w.fill(heap, [&](const site& s) {
      return body{.shape = sphere{heap[s.index].radius},
                  .position = s.position,
                  .velocity = heap[s.index].velocity};
    });
    CHECK(sum_of(w, static_cast<double>(w.local_bodies())) == 2);
  });
  // As other programs write them.
  for (const char* text :
       {"R;X;Y;Z;VX;Colour\n0.5;1;2;3;-1;red\n0.1;-1;0;0;0;\n",
        "\"r\",\"x\",\"y\",\"z\",\"vx\"\n\"0.5\",\"1\",\"2\",\"3\",\"-1\"\n0.1,-1,0,0,0\n",
        "r,x,y,z,vx,name\n.5,1,2,3,-1,\"a, b\"\n.1,-1,0,0,0, \"\"\"c\"\", d\" \n",
        "name,r,x,y,z,vx\n\"5\",.5,1,2,3,-1\n5\",.1,-1,0,0,0\n",
        "name,r,x,y,z,vx\n\"a,.5,1,2,3,-1\n'70s,.1,-1,0,0,0\n",
        "\"size, m\";r;x;y;z;vx\n1;.5;1;2;3;-1\n\"1; 2\";.1;-1;0;0;0\n",
        "r x y z vx name\n.5 1 2 3 -1 \"a b\"\n.1 -1 0 0 0 c\n",
        "'r';'x';'y';'z';'vx'\n'0.5';1;2;3;-1\n0.1;-1;0;0;0\n",
        "r\tx\ty\tz\tvx\tcolour\n0.5\t1\t2\t3\t-1\tdark red\n0.1\t-1\t0\t0\t0\t\n",
        "r  x y z   vx\n0.5 1   2 3\t-1\n 0.1 -1 0 0 0 \n",
        "r [m], x [m], y [m], z [m], vx [m/s]\n0.5,1,2,3,-1\n0.1,-1,0,0,0\n",
        "r x y z vx |v|\n0.5 1 2 3 -1 1\n0.1 -1 0 0 0 0\n",
        "r | x | y | z | vx\n0.5 | 1 | 2 | 3 | -1\n0.1|-1|0|0|0\n",
        "r,x,y,z,vx\r0.5,1,2,3,-1\r0.1,-1,0,0,0",
        "r,x,y,z,vx\r\n0.5,1,2,3,-1\r\n\r\n0.1,-1,0,0,0\r\n"}) {
    const scratch_file other(text);
    const packing same = read_packing(other.name);
    REQUIRE(same.size() == 2);
    CHECK(same[0].position == vec3(1, 2, 3));
    CHECK(same[0].velocity == vec3(-1, 0, 0));
    CHECK(same[1].radius == 0.1);
  }
  CHECK(refusal_of("x;y;z;r\n0;1,5;0;1\n") ==
        ", line 2: y is '1,5', which is no finite number: decimals stand behind a point");
  CHECK(refusal_of("").find("is empty") != std::string::npos);
  CHECK(refusal_of("x,y,z\n") ==
        ", line 1: there is no column r among the 3 of the first line, which names them, of which "
        "x, y, z and r are needed, with commas between them");
  CHECK(refusal_of("x:y:z:r\n").find("column x among the 1 of the first line") !=
        std::string::npos);
  CHECK(refusal_of("x,y,z,r,x\n") == ", line 1: the column x is there twice");
  CHECK(refusal_of("x,y,z,r\n0,0,0,1\n0,0,0\n") ==
        ", line 3: it has 3 fields, with commas between them, and the first line 4 columns");
  CHECK(refusal_of("x,y,z,r\n0,1.5x,0,1\n") == ", line 2: y is '1.5x', which is no finite number");
  CHECK(refusal_of("x,y,z,r\n0,,0,1\n") == ", line 2: y is '', which is no finite number");
  CHECK(refusal_of("x,y,z,r\n0,0,0,nan\n") == ", line 2: r is 'nan', which is no finite number");
  CHECK(refusal_of("x,y,z,r\r\r0,0,0,0\r") == ", line 3: the radius r is 0, and must be positive");
  CHECK(refusal_of("\xff\xfex").find("is in UTF-16: save it as UTF-8") != std::string::npos);
  CHECK(refusal_of("x,y,z,r\n\n0,0,0,0\n") == ", line 3: the radius r is 0, and must be positive");
  CHECK_THROWS_AS(read_packing("/tmp/no such file"), std::runtime_error);
  CHECK_THROWS_WITH(read_packing("/tmp"), "the packing /tmp is a folder: name the file in it");
}

TEST_CASE("packings from spreadsheets are read: a byte order mark, and lines that end with CR LF") {
  for (const std::string end : {"\n", "\r\n"}) {
    const scratch_file file("\xef\xbb\xbfx,y,z,r" + end + "1,2,3,0.5" + end + end + "4,5,6,0.25" +
                            end);
    const packing heap = read_packing(file.name);
    REQUIRE(heap.size() == 2);
    CHECK(heap[0].position == vec3(1, 2, 3));
    CHECK(heap[1].radius == 0.25);
    const scratch_file commented("\xef\xbb\xbf# from a table" + end + "r,x,y,z" + end + "1,2,3,4" +
                                 end);
    CHECK(read_packing(commented.name)[0].position == vec3(2, 3, 4));
  }
}

TEST_CASE("packings that are written are read with the same values, alike from any ranks") {
  const scratch_file file("");
  unlink(file.name.c_str());
  std::string first;
  for (const int ranks : {1, 4}) {
    std::map<std::uint64_t, packed_sphere> have;
    std::mutex together;
    on(ranks, [&](auto& w) {
      w.gravity({0, 0, -10});
      w.global([](auto& s) { s.add(plane{}, {}); });
      w.fill(simple_cubic{.spacing = 1} & box_region{{-3, -3, 0.6}, {3, 3, 3}},
             [](const site& place, random_stream& random) {
               return body{.shape = sphere{random.uniform(0.3, 0.6)},
                           .position = place.position,
                           .velocity = random.uniform(vec3(-5, -5, -5), vec3(5, 5, 5))};
             });
      w.add_if_local(body{.shape = sphere{0.2}, .position = {0.1, 0, 9}, .fixed = true});
      for (int n = 0; n < 100; ++n) w.step(0.005);
      w.for_each_local([&](const auto& b) {
        if (b.is_fixed()) return;
        const std::lock_guard<std::mutex> one(together);
        have[value_of(b.id())] = {b.position(), b.shape().radius, b.velocity()};
      });
      write_packing(w, file.name);
      write_packing(w, file.name);  // replaces it
    });
    const packing heap = read_packing(file.name);
    REQUIRE(heap.size() == have.size());
    std::size_t i = 0, same = 0;
    for (const auto& [id, b] : have) {
      const packed_sphere& s = heap[i++];
      same += s.position == b.position && s.radius == b.radius && s.velocity == b.velocity;
    }
    CHECK(same == have.size());
    CHECK(same > 70);
    std::ostringstream text;
    text << std::ifstream(file.name).rdbuf();
    if (ranks == 1) first = text.str();
    CHECK(text.str() == first);
  }
}

TEST_CASE("packings that cannot be written are refused alike on all ranks") {
  const scratch_file file("these are my notes\n");
  std::atomic<int> refused{0};
  on(4, [&](auto& w) {
    w.add_if_local(body{.shape = sphere{0.2}, .position = {1, 1, 1}});
    const auto refusal = [&](const std::string& name) {
      try {
        write_packing(w, name);
      } catch (const std::runtime_error& e) {
        return std::string(e.what());
      }
      return std::string("none");
    };
    refused += refusal(file.name) == "the packing " + file.name +
                                         " is there already and is not a packing of talus: name "
                                         "another file or remove this one";
    refused += refusal("/tmp").starts_with("the packing /tmp is ");
    refused += refusal("/no such folder/heap.csv").starts_with("the packing /no such folder/");
  });
  CHECK(refused == 12);
  std::string kept;
  std::getline(std::ifstream(file.name) >> std::ws, kept);
  CHECK(kept == "these are my notes");
  threads::launch({.ranks = 2}, [&](threads::link& link) {
    using mixed = scenario<bodies<sphere, box>, transport<threads>, decomposition<grid<dynamic>>>;
    world<mixed> w(link, {.lower = {-4}, .upper = {4}});
    w.material({.density = 2});
    w.add_if_local(body{.shape = sphere{0.2}, .position = {1, 1, 1}});
    w.add_if_local(body{.shape = box{{1, 1, 1}}, .position = {-2, 1, 1}, .fixed = true});
    write_packing(w, file.name + "_mixed");
    w.add_if_local(body{.shape = box{{1, 1, 1}}, .position = {2, 1, 1}});
    CHECK_THROWS_WITH_AS(write_packing(w, file.name + "_mixed"),
                         doctest::Contains("of the bodies that can move 1 have other shapes"),
                         std::runtime_error);
  });
  CHECK(read_packing(file.name + "_mixed").size() == 1);
  unlink((file.name + "_mixed").c_str());
}

TEST_CASE("bodies come in at their rate, without overlap, and go, alike on any ranks") {
  std::string digest;
  removed out;
  for (const int ranks : {1, 4})
    on(ranks, [&](auto& w) {
      w.seed(3);
      w.gravity({0, 0, -10});
      w.global([&](auto& s) { s.add(plane{.normal = {0, 0.6, 0.8}, .offset = -1}, {}); });
      const lognormal_size sizes{.median = 0.25, .sigma = 0.4, .lower = 0.1, .upper = 0.6};
      const auto in =
          insert_by_rate(w, {.bodies = 60.5, .from = 0.1}, box_region{{-3, -3, 3}, {2, 3, 6}},
                         [&](const site& place, random_stream& random) {
                           return body{.shape = sphere{sizes(random)}, .position = place.position};
                         });
      const auto heavy = insert_by_rate(
          w, {.mass = 2, .most = 3, .name = "heavy"}, ball_region{.radius = 1, .centre = {3, 3, 3}},
          [&](const site& place, random_stream&) {
            return body{.shape = sphere{0.4}, .position = place.position};
          });
      const auto gone = remove_in(w, box_region{{-9, -9, -9}, {9, 9, 1}});
      double overlap = 0;
      w.after_each_step([&] { overlap = std::max(overlap, measure_penetration(w).max); });
      w.simulate({.steps = 220, .dt = 0.005});
      CHECK(in->count == 60);
      CHECK(heavy->count == 3);  // of mass 0.536 each; four would be due
      CHECK(heavy->mass == doctest::Approx(3 * 2 * 0.064 * 4 / 3 * pi));
      CHECK(overlap < 0.02);
      const removed all = gone.total(w);
      CHECK(all.count > 10);
      CHECK(sum_of(w, static_cast<double>(w.local_bodies())) + static_cast<double>(all.count) ==
            63);
      CHECK(all.mass < in->mass + heavy->mass);
      const std::string mine = state_digest(w);
      if (w.rank() != 0) return;
      if (ranks == 1) digest = mine, out = all;
      CHECK(mine == digest);
      CHECK(all.count == out.count);
      CHECK(all.mass == doctest::Approx(out.mass));
    });
}

TEST_CASE("an outflow leaves fixed bodies where they are") {
  on(1, [](auto& w) {
    for (const bool fixed : {false, true})
      w.add_if_local(
          body{.shape = sphere{0.4}, .position = {fixed ? 1. : -1., 0, 0}, .fixed = fixed});
    const auto gone = remove_in(w, box_region{{-2, -2, -2}, {2, 2, 2}});
    w.simulate({.steps = 3, .dt = 0.005});
    CHECK(gone.total(w).count == 1);
    CHECK(w.local_bodies() == 1);
    w.for_each_local([](const auto& b) { CHECK(b.is_fixed()); });
  });
}

TEST_CASE("where there is no room the flow waits, and sizes keep their distribution") {
  on(1, [](auto& w) {
    const sieve_curve two({{.size = 0.2, .mass = 1}, {.size = 0.4, .mass = 8}});
    const auto in =
        insert_by_rate(w, {.bodies = 1000}, box_region{{-1, -1, -1}, {1, 1, 1}},
                       [&](const site& place, random_stream& random) {
                         return body{.shape = sphere{two(random)}, .position = place.position};
                       });
    w.simulate({.steps = 60, .dt = 0.005});
    CHECK(in->count > 20);
    CHECK(in->count < 60);
    std::uint64_t large = 0;
    w.for_each_local([&](const auto& b) { large += b.shape().radius == 0.4; });
    CHECK(large > in->count / 3);
    CHECK(large < in->count * 2 / 3);
    CHECK(measure_penetration(w).max == 0);
    insert_by_rate(w, {.bodies = 1000, .name = "elsewhere"}, box_region{{3, 3, 3}, {5, 5, 5}},
                   [](const site&, random_stream&) { return body{.shape = sphere{0.1}}; });
    CHECK_THROWS_WITH_AS(
        w.simulate({.steps = 1, .dt = 0.005}),
        doctest::Contains(
            "body 0 of the inflow 'elsewhere' is made at (0, 0, 0), away from its site at ("),
        std::invalid_argument);
    CHECK_THROWS_AS(
        insert_by_rate(w, {}, box_region{},
                       [](const site&, random_stream&) { return body{.shape = sphere{1}}; }),
        std::invalid_argument);
    CHECK_THROWS_AS(
        insert_by_rate(w, {.bodies = 1}, vertical_cylinder{},
                       [](const site&, random_stream&) { return body{.shape = sphere{1}}; }),
        std::invalid_argument);
  });
}

TEST_CASE("a step of an inflow without room costs the same however many bodies wait") {
  for (const bool by_mass : {false, true})
    on(1, [&](auto& w) {
      std::uint64_t made = 0, before = 0, most = 0;
      inflow how{.bodies = 1e6, .tries = 20};
      if (by_mass) how.bodies = 0, how.mass = 1e9;
      const auto in =
          insert_by_rate(w, how, box_region{{-0.2, -0.2, -0.2}, {0.2, 0.2, 0.2}},
                         [&](const site& place, random_stream&) {
                           ++made;
                           return body{.shape = sphere{0.5}, .position = place.position};
                         });
      w.after_each_step([&] {
        if (w.steps() > 2) most = std::max(most, made - before);
        before = made;
      });
      w.simulate({.steps = 300, .dt = 0.005});
      CHECK(in->count == 1);
      CHECK(most <= 20);  // the places of the first body that waits
    });
}

TEST_CASE("many bodies that are due at once come in at once, alike on any ranks") {
  std::string digest;
  for (const int ranks : {1, 4})
    on(ranks, [&](auto& w) {
      const auto in = insert_by_rate(w, {.bodies = 1e5}, box_region{{-4, -4, -4}, {4, 4, 4}},
                                     [&](const site& place, random_stream& random) {
                                       return body{.shape = sphere{random.uniform(0.05, 0.1)},
                                                   .position = place.position};
                                     });
      w.simulate({.steps = 1, .dt = 0.005});
      CHECK(in->count == 500);
      CHECK(measure_penetration(w).max == 0);
      const std::string mine = state_digest(w);
      if (ranks == 1) digest = mine;
      if (w.rank() == 0) CHECK(mine == digest);
    });
}

TEST_CASE("bodies go round a centre that attracts them, across ranks") {
  std::string digest;
  for (const int ranks : {1, 4})
    on(ranks, [&](auto& w) {
      (void)w.add_if_local(
          body{.shape = sphere{0.1}, .position = {2, 0, 0}, .velocity = {0, 1, 0}});
      (void)w.add_if_local(
          body{.shape = sphere{0.1}, .position = {0, 3, 0}, .velocity = {0, 0, 0.9}});
      add_force_field(w, [](const vec3& x, real) {
        const real r = x.norm();
        return (-2 / (r * r * r)) * x;
      });
      w.simulate({.steps = 500, .dt = 2 * pi / 1000});
      w.simulate({.steps = 500, .dt = 2 * pi / 1000});
      w.for_each_local([&](const auto& b) {  // half of the orbit of 2 * 2 pi
        if (std::abs(b.position()[2]) > 0) return;
        CHECK((b.position() - vec3(-2, 0, 0)).norm() < 0.02);
        CHECK(b.velocity().norm() == doctest::Approx(1).epsilon(0.005));
      });
      const std::string mine = state_digest(w);
      if (ranks == 1) digest = mine;
      if (w.rank() == 0) CHECK(mine == digest);
    });
}

TEST_CASE("a field acts in a step outside of simulate() as in one of simulate()") {
  std::string digests[2];
  for (const bool alone : {false, true})
    on(2, [&](auto& w) {
      (void)w.add_if_local(body{.shape = sphere{0.1}, .position = {2, 0, 0}});
      add_force_field(
          w, [](const vec3& x, real t) { return vec3(-x[0], t, 1); }, "a wind");
      for (int k = 0; alone && k < 5; ++k) w.step(0.01);
      if (!alone) w.simulate({.steps = 5, .dt = 0.01});
      const std::string mine = state_digest(w);
      if (w.rank() == 0) digests[alone] = mine;
    });
  CHECK(digests[0] == digests[1]);
}

namespace {

/// The largest error of a body in a trap after three seconds, in steps of 3/n.
template <class Integrator>
real error_in_trap(int n) {
  using trap =
      scenario<bodies<sphere>, transport<serial>, integrator<Integrator>, features<forces>>;
  serial::link link;
  world<trap> w(link);
  (void)w.material({.density = 1});
  const auto ball = w.add(body{.shape = sphere{0.1}, .position = {1, 0, 0}});
  add_force_field(w, [](const vec3& x, real t) { return vec3(-4 * x[0], std::sin(t), 0); });
  w.simulate({.steps = static_cast<std::uint64_t>(n), .dt = 3. / n});
  return (w[ball].position() - vec3(std::cos(6.), 3 - std::sin(3.), 0)).norm();
}

}  // namespace

TEST_CASE("in a field of place and time a step of the midpoint is of second order") {
  for (const int n : {100, 200, 400}) {
    const real order =
        std::log2(error_in_trap<moreau_midpoint>(n) / error_in_trap<moreau_midpoint>(2 * n));
    CHECK(order == doctest::Approx(2).epsilon(0.02));
  }
  CHECK(error_in_trap<moreau_midpoint>(800) < error_in_trap<semi_implicit_euler>(800) / 20);
}

TEST_CASE("a sphere in a fluid relaxes as Stokes says, with any time step") {
  threads::launch({.ranks = 1}, [&](threads::link& link) {
    const double radius = 0.1, density = 2, viscosity = 0.3, gravity = 9.81;
    const double tau = density * 4 * radius * radius / (18 * viscosity);
    const double terminal = -(density - 0.5) / density * gravity * tau;
    for (const double ratio : {1e-3, 0.1, 1.0, 1e4}) {
      INFO("dt / tau = ", ratio);
      world<scene> w(link, {.lower = {-4, -4}, .upper = {4, 4}});
      w.material({.density = density});
      w.gravity({0, 0, -gravity});
      const auto ball =
          w.add(body{.shape = sphere{radius}, .position = {0, 0, 0}, .velocity = {0, 0, 2}});
      add_fluid(w, fluid{.density = 0.5, .viscosity = viscosity}, stokes_drag{});
      const auto after = [&](double time) {
        return terminal + (2 - terminal) * std::exp(-time / tau);
      };
      w.simulate({.steps = 7, .dt = ratio * tau});
      CHECK(w[ball].velocity()[2] == doctest::Approx(after(7 * ratio * tau)).epsilon(1e-11));
      w.simulate({.steps = 3, .dt = 2 * ratio * tau});  // another step after the forces were added
      CHECK(w[ball].velocity()[2] == doctest::Approx(after(13 * ratio * tau)).epsilon(1e-11));
    }
  });
}

TEST_CASE("drag laws balance the weight at the terminal velocity of their formulas") {
  const double radius = 0.002, density = 2500, rho = 1000, mu = 1e-3, gravity = 9.81;
  const double weight = (density - rho) * 4 * pi / 3 * radius * radius * radius * gravity;
  const auto terminal = [&](auto law, double free) {
    double fall = 0;
    threads::launch({.ranks = 1}, [&](threads::link& link) {
      world<scene> w(link, {.lower = {-4, -4}, .upper = {4, 4}});
      w.material({.density = density});
      w.gravity({0, 0, -gravity});
      const auto ball = w.add(body{.shape = sphere{radius}});
      add_fluid(w,
                fluid{.density = rho,
                      .viscosity = mu,
                      .void_fraction = [free](const vec3&, real) { return free; }},
                law);
      w.simulate({.steps = 3000, .dt = 1e-3});
      fall = -w[ball].velocity()[2];
    });
    return fall;
  };
  const double area = pi * radius * radius;
  {
    const double v = terminal(schiller_naumann_drag{}, 1), re = rho * 2 * radius * v / mu;
    const double cd = re < 1000 ? 24 / re * (1 + 0.15 * std::pow(re, 0.687)) : 0.44;
    CHECK(0.5 * rho * cd * area * v * v == doctest::Approx(weight).epsilon(1e-9));
  }
  for (const double free : {1.0, 0.7, 0.4}) {
    const double v = terminal(di_felice_drag{}, free), re = free * rho * 2 * radius * v / mu;
    const double cd = std::pow(0.63 + 4.8 / std::sqrt(re), 2);
    const double chi = 3.7 - 0.65 * std::exp(-0.5 * std::pow(1.5 - std::log10(re), 2));
    CHECK(0.5 * rho * cd * area * v * v * std::pow(free, 2 - chi) ==
          doctest::Approx(weight).epsilon(1e-9));
  }
}

TEST_CASE("buoyancy alone carries a body of the density of the fluid, and lifts a lighter one") {
  threads::launch({.ranks = 1}, [&](threads::link& link) {
    for (const double density : {1000.0, 500.0}) {
      world<scene> w(link, {.lower = {-4, -4}, .upper = {4, 4}});
      w.material({.density = density});
      w.gravity({0, 0, -9.81});
      const auto ball = w.add(body{.shape = sphere{0.1}});
      add_fluid(w, fluid{.density = 1000}, no_drag{});
      w.simulate({.steps = 100, .dt = 0.01});
      CHECK(w[ball].velocity()[2] == doctest::Approx(9.81 * (1000 / density - 1)).epsilon(1e-12));
    }
  });
}

TEST_CASE("spheres in a vortex have the same bits on any number of ranks") {
  std::string digest;
  for (const int ranks : {1, 2, 4})
    on(ranks, [&](auto& w) {
      for (int k = 0; k < 20; ++k)
        (void)w.add_if_local(body{.shape = sphere{0.1},
                                  .position = {0.15 * k - 1.5, 0.3 * (k % 3) - 0.2, 0},
                                  .velocity = {0, 0.1 * k, 0}});
      add_fluid(w, fluid{.density = 1,
                         .viscosity = 0.1,
                         .velocity = [](const vec3& x, real) { return vec3(-x[1], x[0], 0); },
                         .void_fraction = 0.8});
      w.simulate({.steps = 200, .dt = 0.01});
      const std::string mine = state_digest(w);
      if (ranks == 1) digest = mine;
      if (w.rank() == 0) CHECK(mine == digest);
    });
}

TEST_CASE("a fluid that makes no sense is refused with its value") {
  on(1, [&](auto& w) {
    CHECK_THROWS_WITH_AS(add_fluid(w, fluid{.density = -1, .viscosity = 1}),
                         doctest::Contains("not negative, but is -1"), std::invalid_argument);
    CHECK_THROWS_WITH_AS(add_fluid(w, fluid{.density = 1}), doctest::Contains("viscosity"),
                         std::invalid_argument);
    (void)w.add(body{.shape = sphere{0.1}});
    add_fluid(w, fluid{.density = 1, .viscosity = 1, .void_fraction = 1.5});
    CHECK_THROWS_WITH_AS(w.simulate({.steps = 1, .dt = 0.1}),
                         doctest::Contains("the void fraction of the fluid is 1.5"),
                         std::runtime_error);
  });
}
