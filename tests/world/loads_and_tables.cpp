// Loads of many bodies at once, one body on any rank, and tables of bodies and contacts: the same
// as one by one, on any ranks, while bodies move and after a restart.
#include <doctest/doctest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <mutex>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/observe.hpp>
#include <talus/observe/force.hpp>
#include <talus/observe/loads.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/periodic.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/box.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <vector>

using namespace talus;

namespace {

using cells = grid<dynamic, dynamic>;
using parts = bodies<sphere, box, plane>;
using hard =
    scenario<parts, decomposition<cells>, transport<threads>, features<checkpoints, sleeping>>;
using reproduced = scenario<parts, solver<reproducible>, decomposition<cells>, transport<threads>,
                            features<checkpoints>>;
using soft =
    scenario<parts, soft_contact<linear_spring_dashpot, coulomb_friction, rolling_resistance>,
             decomposition<cells>, transport<threads>, features<checkpoints>>;

constexpr std::uint64_t spheres = 12, boxes = 4;

/// What a run has found at its end, the same for all ranks.
struct found {
  std::vector<contact_load> loads;
  std::vector<vec3> positions;
  std::string bodies, contacts;  ///< files
  std::size_t rows = 0;
};

double distance(const vec3& a, const vec3& b) { return (a - b).norm(); }

std::string text_of(const std::string& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Columns of two spheres, two of them on a fixed slab, and some boxes, which slide over the
/// boundaries of the ranks.
template <class World>
void fill_with_bodies(World& w) {
  w.gravity({0, 0, -10});
  w.global([&](auto& scope) { scope.add(plane{}, {}); });
  // Bodies of several ranks lie on the slab.
  w.add_if_local(body{.shape = box{{1, 3, 0.6}}, .position = {0.01, 0, 0.3}, .fixed = true});
  const vec3 feet[] = {{-2.4, 0, 0},     {-1.2, 0, 0}, {-0.02, -0.6, 0.6},
                       {0.05, 0.5, 0.6}, {1.3, 0, 0},  {2.35, 0, 0}};
  for (std::uint64_t k = 0; k < spheres; ++k) {
    const auto layer = static_cast<real>(k / 6);
    w.add_if_local(body{.shape = sphere{0.5},
                        .position = feet[k % 6] + vec3(0.05 * layer, 0, 0.4995 + 0.998 * layer),
                        .velocity = {0.8, 0.1, 0}});
  }
  for (std::uint64_t k = 0; k + 1 < boxes; ++k)
    w.add_if_local(body{.shape = box{{0.8, 0.8, 0.5}},
                        .position = {-1 + 1.05 * static_cast<real>(k), 2.2, 0.2499},
                        .velocity = {0.7, 0, 0}});
}

/// Compares everything with what the functions for one body say.
template <class World>
found examine(World& w, const std::string& name) {
  std::vector<system_id> all{system_id{0}};
  const handle<plane> ground = [&] {
    handle<plane> h;
    w.for_each_known([&](const auto& b) {
      if constexpr (std::is_same_v<typename std::remove_cvref_t<decltype(b)>::shape_type, plane>)
        h = b.handle();
    });
    return h;
  }();
  all[0] = ground.id;
  for (std::uint64_t k = 1; k <= spheres + boxes; ++k) all.push_back(detail::id_of_attempt(k));
  found f;
  // One body twice, and one that does not exist.
  std::vector<system_id> asked = all;
  asked.push_back(all[1]), asked.push_back(no_id);
  f.loads = contact_forces(w, asked);
  REQUIRE(f.loads.size() == asked.size());
  CHECK(f.loads.back().force.norm() == 0);
  CHECK(distance(f.loads[asked.size() - 2].force, f.loads[1].force) == 0);
  f.loads.resize(all.size());

  vec3 sum(0, 0, 0);
  double most = 0;
  const auto check = [&](const contact_load& load, auto h) {
    const body_reading b = measure_body(w, h);
    REQUIRE(b.exists);
    CHECK(distance(load.force, contact_force(w, h)) < 1e-9 * (1 + load.force.norm()));
    CHECK(distance(load.torque, contact_torque(w, h, b.position)) < 1e-9 * (1 + load.force.norm()));
    if (const auto here = w.find(h); here && !here->is_remote()) {
      CHECK(distance(b.position, here->position()) == 0);
      CHECK(distance(b.velocity, here->velocity()) == 0);
      CHECK(distance(b.angular_velocity, here->angular_velocity()) == 0);
      CHECK(b.orientation.coeffs() == here->orientation().coeffs());
      CHECK(b.fixed == here->is_fixed());
      CHECK(b.global == here->is_global());
      if (!b.global) CHECK(b.owner == w.rank());
    }
    f.positions.push_back(b.position);
    sum += load.force, most = std::max(most, static_cast<double>(load.force.norm()));
  };
  check(f.loads[0], ground);
  for (std::size_t k = 1; k < all.size(); ++k)
    if (k >= 2 && k < 2 + spheres)
      check(f.loads[k], handle<sphere>{all[k]});
    else
      check(f.loads[k], handle<box>{all[k]});
  CHECK(most > 10);
  CHECK(sum.norm() < 1e-9 * most);
  CHECK(f.loads[1].force[2] < -20);  // on the slab
  CHECK_FALSE(measure_body(w, handle<sphere>{no_id}).exists);
  // As add_if_local() returns them: other ranks have no handle.
  std::vector<std::optional<handle<sphere>>> some(3);
  for (std::size_t k = 0; k < 2; ++k)
    if (const auto here = w.find(handle<sphere>{all[2 + k]}); here && !here->is_remote())
      some[k] = handle<sphere>{all[2 + k]};
  const auto loads = contact_forces(w, some);
  for (std::size_t k = 0; k < 2; ++k) {
    CHECK(distance(loads[k].force, f.loads[2 + k].force) == 0);
    CHECK(distance(measure_body(w, some[k]).position, f.positions[2 + k]) == 0);
  }
  CHECK(loads[2].force.norm() == 0);
  CHECK_FALSE(measure_body(w, some[2]).exists);

  const data_table bodies = body_table(w), contacts = contact_table(w);
  if (w.rank() != 0) {
    CHECK(bodies.rows() == 0);
    CHECK(contacts.rows() == 0);
  } else {
    REQUIRE(bodies.rows() == all.size());
    f.rows = contacts.rows();
    std::map<std::uint64_t, std::size_t> row;
    for (std::size_t k = 0; k < bodies.rows(); ++k) row[bodies.whole_numbers("id")[k]] = k;
    for (std::size_t k = 0; k < all.size(); ++k) {
      const std::size_t at = row.at(value_of(all[k]));
      CHECK(bodies.numbers("position_x")[at] == f.positions[k][0]);
      CHECK(bodies.numbers("position_z")[at] == f.positions[k][2]);
      CHECK(bodies.words("shape")[at] == (k == 0 ? "plane" : k >= 2 && k < 14 ? "sphere" : "box"));
      CHECK(bodies.whole_numbers("fixed")[at] == (k < 2 ? 1 : 0));
      // The contacts of the table add up to the loads.
      vec3 force(0, 0, 0);
      for (std::size_t c = 0; c < contacts.rows(); ++c) {
        const vec3 on_a(contacts.numbers("force_x")[c], contacts.numbers("force_y")[c],
                        contacts.numbers("force_z")[c]);
        if (contacts.whole_numbers("id_a")[c] == value_of(all[k])) force += on_a;
        if (contacts.whole_numbers("id_b")[c] == value_of(all[k])) force -= on_a;
      }
      CHECK(distance(force, f.loads[k].force) < 1e-9 * most);
    }
    CHECK_THROWS_WITH_AS((void)bodies.numbers("height"),
                         doctest::Contains("no column of numbers 'height': it has position_x"),
                         std::invalid_argument);
  }
  f.bodies = name + "_bodies.csv", f.contacts = name + "_contacts.csv";
  bodies.write_csv(f.bodies), contacts.write_csv(f.contacts);
  return f;
}

/// A run over `before` ranks, of which a checkpoint goes on over `after` ranks.
template <class Scenario>
found run_over(int before, int after, real dt, int steps) {
  const std::string name = "/tmp/talus_tables_" + std::to_string(getpid());
  found last;
  const auto go = [&](int ranks, bool restarts) {
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      CAPTURE(ranks);
      world<Scenario> w(link, cells{.lower = {-4, -4}, .upper = {4, 4}});
      w.material({.density = 2, .friction = 0.4, .stiffness = 1e4, .rolling_friction = 0.02});
      if (!restarts) {
        fill_with_bodies(w);
      } else {
        w.gravity({0, 0, -10});
        w.global([&](auto& scope) { scope.add(plane{}, {}); });
        read_checkpoint(w, name + ".h5");
        (void)examine(w, name);  // before a step
      }
      for (int k = 0; k < steps; ++k) w.step(dt);
      const found f = examine(w, name);
      if (w.rank() == 0) last = f;
      if (!restarts) write_checkpoint(w, name + ".h5");
    });
  };
  go(before, false), go(after, true);
  last.bodies = text_of(name + "_bodies.csv"), last.contacts = text_of(name + "_contacts.csv");
  for (const char* end : {".h5", "_bodies.csv", "_contacts.csv"}) unlink((name + end).c_str());
  return last;
}

template <class Scenario>
void has_loads_and_tables(real dt, int steps, bool same_bits) {
  const found one = run_over<Scenario>(1, 1, dt, steps), two = run_over<Scenario>(4, 2, dt, steps);
  (void)run_over<Scenario>(2, 4, dt, steps);
  CHECK(one.rows > spheres);
  CHECK(one.bodies.starts_with("id,shape,position_x [L],"));
  CHECK(one.contacts.starts_with("id_a,id_b,shape_a,"));
  CHECK(static_cast<std::size_t>(std::count(two.contacts.begin(), two.contacts.end(), '\n')) ==
        two.rows + 1);
  if (!same_bits) return;
  CHECK(one.bodies == two.bodies);
  CHECK(one.contacts == two.contacts);
  for (std::size_t k = 0; k < one.loads.size(); ++k) {
    CHECK(distance(one.loads[k].force, two.loads[k].force) == 0);
    CHECK(distance(one.loads[k].torque, two.loads[k].torque) == 0);
  }
}

/// A pile between walls, at rest.
template <class Scenario>
void carries_its_weight(real dt, int steps, double tolerance) {
  for (const int ranks : {1, 2, 4})
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      CAPTURE(ranks);
      world<Scenario> w(link, cells{.lower = {-4, -4}, .upper = {4, 4}});
      w.material({.density = 2,
                  .restitution = 0,
                  .friction = 0.4,
                  .stiffness = 1e4,
                  .rolling_friction = 0.02});
      w.gravity({0, 0, -10});
      std::vector<system_id> walls, grains;
      w.global([&](auto& scope) {
        walls.push_back(scope.add(plane{}, {}).id);
        for (const vec3& n : {vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, -1, 0)})
          walls.push_back(scope.add(plane{.normal = n, .offset = -1.3}, {}).id);
      });
      for (std::uint64_t k = 0; k < 12; ++k) {
        const auto x = static_cast<real>(k % 2), y = static_cast<real>(k / 2 % 2),
                   z = static_cast<real>(k / 4);
        const vec3 at(1.1 * x - 0.5 + 0.1 * z, 1.1 * y - 0.6, 0.51 + 1.01 * z);
        w.add_if_local(body{.shape = sphere{0.5}, .position = at});
      }
      w.synchronize();
      for (int k = 0; k < steps; ++k) w.step(dt);
      for (std::uint64_t k = 0; k < 12; ++k) grains.push_back(detail::id_of_attempt(k + 5));
      const double weight = 2 * 10 * pi / 6;
      const auto on_walls = contact_forces(w, walls), on_grains = contact_forces(w, grains);
      vec3 sum(0, 0, 0);
      for (const contact_load& load : on_walls) sum += load.force;
      CHECK(distance(sum, {0, 0, -12 * weight}) < tolerance * 12 * weight);
      for (std::size_t k = 0; k < grains.size(); ++k) {
        const body_reading b = measure_body(w, handle<sphere>{grains[k]});
        REQUIRE(b.exists);
        CHECK(b.mass * 10 == doctest::Approx(weight));
        CHECK(distance(on_grains[k].force, {0, 0, weight}) < 12 * tolerance * weight);
        CHECK(on_grains[k].torque.norm() < 12 * tolerance * weight);
      }
    });
}

}  // namespace

TEST_CASE("hard contacts: loads of many bodies and tables are those of single bodies") {
  has_loads_and_tables<hard>(1.0 / 240, 20, false);
}

TEST_CASE("solver<reproducible>: loads and tables have the same bits on one rank and on several") {
  has_loads_and_tables<reproduced>(1.0 / 240, 20, true);
}

TEST_CASE("soft contacts: loads and tables have the same bits on one rank and on several") {
  has_loads_and_tables<soft>(1e-4, 400, true);
}

TEST_CASE("hard contacts: the loads of a pile at rest, asleep or awake, carry its weight") {
  carries_its_weight<hard>(1.0 / 240, 700, 1e-3);
  carries_its_weight<reproduced>(1.0 / 240, 700, 1e-3);
}

TEST_CASE("soft contacts: the loads of a pile at rest carry its weight") {
  carries_its_weight<soft>(2e-4, 20000, 1e-3);
}

TEST_CASE("a table replaces no file that is something else") {
  threads::launch({.ranks = 1}, [](threads::link& link) {
    world<hard> w(link, cells{.lower = {-4, -4}, .upper = {4, 4}});
    w.material({});
    fill_with_bodies(w);
    const std::string file = "/tmp/talus_table_" + std::to_string(getpid()) + ".csv";
    std::ofstream(file) << "a letter\n";
    CHECK_THROWS_WITH_AS(body_table(w).write_csv(file), doctest::Contains("is not a table of"),
                         std::runtime_error);
    CHECK(text_of(file) == "a letter\n");
    unlink(file.c_str());
  });
}

TEST_CASE("points of contacts across a periodic boundary are those of the owner on any ranks") {
  using endless = scenario<bodies<sphere>, solver<reproducible>,
                           decomposition<periodic<grid<dynamic>, along::x>>, transport<threads>>;
  std::vector<std::vector<double>> first;
  for (const int ranks : {1, 2, 4})
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<endless> w(link, {{.cells = {ranks}, .lower = {-4}, .upper = {4}}}, reach{1});
      w.material({.restitution = 0, .friction = 0.5});
      w.gravity({10, 0, 0});
      w.add_if_local(body{.shape = sphere{0.5}, .position = {-3.81, 0, 0}, .fixed = true});
      w.add_if_local(body{.shape = sphere{0.5}, .position = {3.2, 0.1, 0}});
      for (int k = 0; k < 6; ++k) w.step(0.005);
      const auto table = contact_table(w);
      const std::vector<system_id> both{detail::id_of_attempt(0), detail::id_of_attempt(1)};
      const auto loads = contact_forces(w, both);
      if (w.rank() != 0) return;
      REQUIRE(table.rows() == 1);
      std::vector<std::vector<double>> now;
      for (const char* name : {"point_x", "point_y", "gap", "force_x"})
        now.push_back(table.numbers(name));
      for (const auto& load : loads)
        for (int k = 0; k < 3; ++k)
          now.push_back(std::vector<double>{load.force[k], load.torque[k]});
      CHECK(now[3][0] != 0);
      if (ranks == 1) first = now;
      CHECK(now == first);
    });
}

TEST_CASE("the table of bodies has their radii, or those of balls of equal volume") {
  threads::launch({.ranks = 1}, [](threads::link& link) {
    world<hard> w(link, cells{.lower = {-4, -4}, .upper = {4, 4}});
    const material_id stone = w.material({});
    w.units({.length = "mm"});
    handle<plane> plate;
    w.global([&](auto& s) { plate = s.add(plane{{0, 0, 1}, -3}, stone); });
    const auto grain = w.add_if_local(body{.shape = sphere{0.3}, .position = {0, 1, 2}});
    const auto brick = w.add_if_local(body{.shape = box{{1, 2, 0.5}}, .position = {0, -1, 2}});
    const data_table bodies = body_table(w);
    const auto& ids = bodies.whole_numbers("id");
    const auto radius = [&](system_id id) {
      const auto at = std::find(ids.begin(), ids.end(), value_of(id));
      return bodies.numbers("radius")[static_cast<std::size_t>(at - ids.begin())];
    };
    CHECK(radius(plate.id) == 0);
    CHECK(radius(grain->id) == 0.3);
    CHECK(4 * pi / 3 * std::pow(radius(brick->id), 3) == doctest::Approx(1).epsilon(1e-14));
    for (const auto& c : bodies.columns())
      if (c.name == "radius") CHECK(c.dimension == "mm");
  });
}

TEST_CASE("zero has no sign in tables") {
  threads::launch({.ranks = 1}, [](threads::link& link) {
    world<hard> w(link, cells{.lower = {-4, -4}, .upper = {4, 4}});
    w.material({});
    w.add_if_local(body{.shape = sphere{0.5}, .position = {-0.0, 1, 2}, .velocity = {0, -0.0, 0}});
    const std::string file = "/tmp/talus_table_" + std::to_string(getpid()) + ".csv";
    const data_table bodies = body_table(w);
    CHECK_FALSE(std::signbit(bodies.numbers("position_x")[0]));
    CHECK_FALSE(std::signbit(bodies.numbers("velocity_y")[0]));
    bodies.write_csv(file);
    CHECK(text_of(file).find("-0") == std::string::npos);
    CHECK(detail::text(-0.0) == "0");
    unlink(file.c_str());
  });
}
