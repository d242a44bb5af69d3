// The answers of docs/how_do_i.md, compiled and run: each does what the page says.
// timeout: 300
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <limits>
#include <talus/adhesion.hpp>
#include <talus/checkpoint.hpp>
#include <talus/events.hpp>
#include <talus/filters.hpp>
#include <talus/liquid.hpp>
#include <talus/mesh.hpp>
#include <talus/observe.hpp>
#include <talus/observe/bond_breaks.hpp>
#include <talus/queries.hpp>
#include <talus/talus.hpp>
#include <talus/vtk.hpp>
#include <vector>

#include "../../examples/own_shape/lens.hpp"
#include "../tutorial/ranks.hpp"

using namespace talus;
using tutorial::on_ranks;
using tutorial::sum_of;

namespace {

/// The program of most answers: two domains along x, a floor, and a few grains above it.
using grains = scenario<bodies<sphere, plane>, hard_contact<coulomb_friction, newton_restitution>,
                        solver<nonlinear_gauss_seidel, reproducible>, decomposition<grid<dynamic>>,
                        features<driven, forces, sleeping, energy_ledger, checkpoints, vtk_output>>;

struct my_options : options {
  double slope = 20;  // degrees

  my_options() { steps = 200; }
  void describe(auto& line) {
    options::describe(line);
    line.add("--slope", slope, "of the floor, in degrees", 0.0, 60.0);
  }
};

/// A folder of this process, in which the test runs; removed at the end.
struct scratch_folder {
  std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::path here = "/tmp/talus_how_do_i_" + std::to_string(getpid());
  scratch_folder() {
    std::filesystem::create_directory(here);
    std::filesystem::current_path(here);
  }
  ~scratch_folder() {
    std::filesystem::current_path(before);
    std::filesystem::remove_all(here);
  }
};

template <class World>
auto floor_and_grains(World& world) {
  if (world.ranks() > 1) world.decompose({.lower = {-3}, .upper = {3}});
  world.gravity({0, 0, -9.81});
  const auto stone = world.material({.density = 2.8, .restitution = 0.3, .friction = 0.5});
  handle<plane> floor;
  world.global([&](auto& scope) { floor = scope.add(plane{}, stone); });
  world.fill(simple_cubic{.spacing = 1} & box_region{{-1, -1, 0.5}, {1, 1, 1.5}},
             [&](const site& place) {
               return body{.shape = sphere{0.45}, .position = place.position, .material = stone};
             });
  return std::pair(stone, floor);
}
template <class World>
double lowest_of(World& world) {
  double z = 1e9;
  world.for_each_local([&](const auto& b) { z = std::min(z, b.position()[2]); });
  world.link().reduce(reduction::min, std::span(&z, 1));
  return z;
}

}  // namespace

TEST_CASE("build: which bodies touch") {
  using apart = scenario<bodies<sphere, plane>, hard_contact<>, decomposition<grid<dynamic>>,
                         features<contact_filters>>;
  on_ranks<apart>(2, [](auto& world) {
    world.decompose({.lower = {-3}, .upper = {3}});
    world.gravity({0, 0, -9.81});
    const auto stone = world.material({}), wood = world.material({}),
               floor_material = world.material({});
    world.global(
        [&](auto& scope) { scope.add(plane{}, floor_material), scope.add(plane{}, wood); });
    // Pairs, one above the other.
    const auto add = [&](real x, real z, material_id of) {
      return world.add_if_local(body{.shape = sphere{0.5}, .position = {x, 0, z}, .material = of});
    };
    const auto first = add(-2.4, 0.5, wood), second = add(-2.4, 1.7, wood);
    const auto of_one = add(-1.2, 0.5, wood), of_two = add(-1.2, 1.7, wood);
    const auto below = add(0.1, 0.5, stone), above = add(0.1, 1.7, stone);
    const auto unlike_third = add(1.3, 0.5, wood), third = add(1.3, 1.7, wood);
    const auto lower = add(2.5, 0.5, wood), upper = add(2.5, 1.7, wood);  // touch each other
    if (of_one) world[*of_one].template set<contact_groups>(1u << 1);
    if (of_two) world[*of_two].template set<contact_groups>(1u << 2);
    if (unlike_third) world[*unlike_third].template set<contact_mask>(~(1u << 3));
    world.synchronize();
    auto& filters = world.template feature<contact_filters>();
    filters.ignore(contact_group{1}, contact_group{2});
    filters.only_between(stone, floor_material);
    keep_apart(world, first, second);  // handles, or empty optional handles, on all ranks
    if (third) world[*third].template set<contact_groups>(1u << 3);
    world.simulate({.steps = 100, .dt = 0.01});
    const auto height = [&](const auto& of) {
      return sum_of(world, of ? world[*of].position()[2] : 0);
    };
    for (const auto& one : {second, of_two, above, third})
      CHECK(height(one) == doctest::Approx(0.5).epsilon(0.02));
    for (const auto& one : {first, of_one, below, unlike_third, lower})
      CHECK(height(one) == doctest::Approx(0.5).epsilon(0.02));
    CHECK(height(upper) == doctest::Approx(1.5).epsilon(0.02));
  });
}

TEST_CASE("measure: events") {
  using reporting = scenario<bodies<sphere, plane>, hard_contact<>, decomposition<grid<dynamic>>,
                             features<events>>;
  on_ranks<reporting>(2, [](auto& world) {
    world.decompose({.lower = {-3}, .upper = {3}});
    world.gravity({0, 0, -9.81});
    const auto stone = world.material({});
    world.global([&](auto& scope) { scope.add(plane{}, stone); });
    for (const real x : {-2., -0.5, 0.5})
      world.add_if_local(body{.shape = sphere{0.5}, .position = {x, 0, 1.5}, .material = stone});
    std::vector<system_id> passed;
    auto& of_events = world.template feature<events>();
    of_events.impacts({.speed = 2});
    const int middle = of_events.region(box_region{{-1, -1, 0}, {1, 1, 1}});
    world.after_each_step("events", [&] {
      for (const event& e : all_events(world))
        if (e.kind == event_kind::enters && e.region == middle) passed.push_back(e.a);
    });
    world.simulate({.steps = 100, .dt = 0.01});
    CHECK(passed.size() == 2);
    CHECK(total_events(world)[2] == 3);
  });
}

TEST_CASE("measure: what a ray meets, and whether a place is free") {
  using plain = scenario<bodies<sphere, plane>, hard_contact<>, decomposition<grid<dynamic>>>;
  on_ranks<plain>(2, [](auto& world) {
    world.decompose({.lower = {-3}, .upper = {3}});
    const auto stone = world.material({});
    world.global([&](auto& scope) { scope.add(plane{}, stone); });
    for (const real x : {-1.3, 0., 1.3})
      world.add_if_local(body{.shape = sphere{0.5}, .position = {x, 0, 0.5}, .material = stone});
    const std::array beams{ray{.from = {0, 0, 9}}, ray{.from = {2, 0, 9}}};
    const std::vector<query_hit> hits = cast_rays(world, beams);  // downwards by default
    const std::array places{pose{{0, 0, 0.8}}, pose{{0, 0, 3}}};
    const auto in_the_way = find_overlaps(world, sphere{0.4}, places);
    const bool is_free = in_the_way[1].empty();
    double highest = 0;
    const std::vector<shape_path> ways{{.from = {0, 0, 5}, .direction = {0, 0, -1}, .length = 10}};
    const query_hit landing = cast_shape(world, box{{0.2, 0.2, 0.2}}, ways)[0];
    if (landing) highest = landing.point[2];
    CHECK(hits[0].distance == doctest::Approx(8).epsilon(1e-12));
    CHECK(handle_of<sphere>(world, hits[0]).has_value());
    CHECK(hits[1].id != hits[0].id);
    CHECK(in_the_way[0].size() == 1);
    CHECK(in_the_way[0][0].distance == doctest::Approx(-0.6));
    CHECK(is_free);
    CHECK(highest == doctest::Approx(1));
  });
}

TEST_CASE("build: ellipsoids and blocky grains") {
  using sweets =
      scenario<bodies<ellipsoid, superellipsoid, lens, plane>, decomposition<grid<dynamic>>>;
  on_ranks<sweets>(2, [](auto& world) {
    world.decompose({.lower = {-6}, .upper = {6}});
    world.gravity({0, 0, -9.81});
    const auto stone = world.material({.density = 1.4});
    world.global([&](auto& scope) { scope.add(plane{}, stone); });
    const ellipsoid sweet{{0.3, 0.3, 0.2}};
    const superellipsoid cube{.radii = {0.2, 0.2, 0.2}, .n1 = 6, .n2 = 6};
    world.add_if_local(body{.shape = sweet, .position = {-1, 0, 0.5}, .material = stone});
    world.add_if_local(body{.shape = cube, .position = {1, 0, 0.5}, .material = stone});
    world.add_if_local(body{.shape = lens{}, .position = {4, 0, 1}, .material = stone});
    world.simulate({.steps = 300, .dt = 0.005});
    CHECK(sum_of(world, static_cast<double>(world.local_bodies())) == 3);
    world.for_each_local([](const auto& b) {
      const real half = b.shape().half_extents(pose{})[2];
      CHECK(b.position()[2] == doctest::Approx(half).epsilon(0.02));
    });
  });
}

TEST_CASE("build: a box of grains with a size distribution") {
  on_ranks<grains>(2, [](auto& world) {
    world.decompose({.lower = {-3}, .upper = {3}});
    world.gravity({0, 0, -9.81});
    const auto stone = world.material({.density = 2.8, .friction = 0.5});
    world.global([&](auto& scope) {
      scope.add(plane{}, stone);
      for (const vec3& n : {vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, -1, 0)})
        scope.add(plane{.normal = n, .offset = -3}, stone);
    });
    const lognormal_size sizes{.median = 0.35, .sigma = 0.2, .lower = 0.2, .upper = 0.45};
    world.fill(simple_cubic{.spacing = 1} & box_region{{-2, -2, 1}, {2, 2, 3}},
               [&](const site& place, random_stream& random) {
                 return body{
                     .shape = sphere{sizes(random)}, .position = place.position, .material = stone};
               });
    CHECK(sum_of(world, double(world.local_bodies())) == 75);
    world.simulate({.steps = 100, .dt = 0.005});
    CHECK(lowest_of(world) > 0.19);
    CHECK(measure_motion(world).bodies == 75);
  });
}

TEST_CASE("build: bodies of spheres that are glued together, and a mesh as a wall") {
  const scratch_folder folder;
  std::ofstream("chute.stl") << R"(solid chute
facet normal 0 0 1
outer loop
vertex -4000 -4000 0
vertex 4000 -4000 0
vertex 4000 4000 0
endloop
endfacet
facet normal 0 0 1
outer loop
vertex -4000 -4000 0
vertex 4000 4000 0
vertex -4000 4000 0
endloop
endfacet
endsolid chute
)";
  using clump = union_of<sphere>;
  using parts = scenario<bodies<sphere, clump, triangle_mesh>, features<driven>>;
  on_ranks<parts>(1, [](auto& world) {
    world.gravity({0, 0, -9.81});
    const auto stone = world.material({.density = 2.8, .friction = 0.5});
    const clump peanut{{{.shape = sphere{0.3}, .at = {{-0.2, 0, 0}}},
                        {.shape = sphere{0.3}, .at = {{0.2, 0, 0}}}}};
    world.fill(simple_cubic{.spacing = 1.2} & box_region{{-1.3, -1.3, 1}, {1.3, 1.3, 2}},
               [&](const site& place, random_stream& random) {
                 return body{.shape = peanut,
                             .position = place.position,
                             .material = stone,
                             .orientation = random.rotation()};
               });
    const auto before_toys = world.local_bodies();
    const auto heavy = world.add(body{.shape = sphere{0.5}, .position = {9, 0, 1}, .mass = 3});
    const clump ball{sphere{0.5}};  // a union_of<sphere>
    const auto hollow =
        world.add(body{.shape = ball, .position = {9, 2, 1}, .mass = 2, .inertia = 1. / 3});
    const auto tumbler = world.add(body{.shape = ball,
                                        .position = {9, 4, 1},
                                        .mass = 2,
                                        .inertia = {0.2, 0.2, 0.1},
                                        .centre = {0, 0, -0.2}});
    CHECK(world.local_bodies() == before_toys + 3);
    CHECK(world[heavy].mass() == doctest::Approx(3));
    CHECK(world[hollow].inertia()[2] == doctest::Approx(1. / 3));
    CHECK((world[tumbler].position() - vec3(9, 4, 0.8)).norm() < 1e-14);
    world.destroy(heavy), world.destroy(hollow), world.destroy(tumbler);
    const triangle_mesh chute = read_stl("chute.stl", 0.001);  // from millimetres to metres
    const pose at = placed(chute);
    world.global([&](auto& scope) { scope.add(chute, stone, at.position, at.orientation); });
    const auto before = world.local_bodies();
    CHECK(before == 9);
    world.simulate({.steps = 200, .dt = 0.005});
    CHECK(lowest_of(world) > 0.2);
    CHECK(lowest_of(world) < 1);
  });
  on_ranks<parts>(1, [](auto& world) {
    const auto stone = world.material({.density = 2.8, .friction = 0.5});
    world.gravity({0, -9.81, 0});
    const triangle_mesh drum = tube_surface({.radius = 3, .height = 4}, {.closed = true});
    const pose at = placed(drum);
    world.global([&](auto& scope) {
      const auto wall = scope.add(drum, stone, at.position, at.orientation);
      world.drive(wall, turning{.axis = {0, 0, 1}, .speed = 0.5});
    });
    const auto grain = world.add(sphere{0.4}, stone, {0, -2.5, 2});
    world.simulate({.steps = 100, .dt = 0.005});
    const vec3 x = world[grain].position();
    CHECK(std::hypot(x[0], x[1]) < 2.61);
    CHECK(x[0] > 0.01);  // carried along
  });
}

TEST_CASE("build: grains from a table") {
  const scratch_folder folder;
  std::ofstream("grains.csv") << "x,y,z,r\n0,0,1,0.4\n0,1,1,0.3\n";
  on_ranks<grains>(1, [](auto& world) {
    const auto stone = world.material({.density = 2.8});
    const packing table = read_packing("grains.csv");
    world.fill(table, [&](const site& place) {
      return body{.shape = sphere{table[place.index].radius},
                  .position = place.position,
                  .material = stone};
    });
    CHECK(world.local_bodies() == 2);
  });
}

TEST_CASE("build: periodic space") {
  using endless = scenario<bodies<sphere, plane>,
                           decomposition<periodic<grid<dynamic, dynamic>, along::x, along::y>>>;
  on_ranks<endless>(1, [](auto& world) {
    world.decompose({{.lower = {0, 0}, .upper = {12, 6}}});
    const double slope = 25 * pi / 180;
    world.gravity({9.81 * std::sin(slope), 0, -9.81 * std::cos(slope)});
    const auto stone = world.material({.density = 2.8, .friction = 0.5});
    world.global([&](auto& scope) { scope.add(plane{}, stone); });
    const auto grain =
        world.add(body{.shape = sphere{0.4}, .position = {11.9, 3, 0.4}, .velocity = {5, 0, 0}});
    world.simulate({.steps = 20, .dt = 0.005});
    CHECK(world[grain].position()[0] < 1);
  });
}

TEST_CASE("walls: moved, pressed, and their load") {
  on_ranks<grains>(2, [](auto& world) {
    const auto made = floor_and_grains(world);
    const auto stone = made.first;
    const auto floor = made.second;
    world.drive(floor, oscillation{.amplitude = {0, 0, 0.02}, .frequency = 2});
    world.simulate({.steps = 50, .dt = 0.005});
    CHECK(std::abs(world[floor].shape().offset) <= 0.0201);
    world.halt(floor);
    world.simulate({.steps = 300, .dt = 0.005});

    const vec3 load = contact_force(world, floor);  // of all ranks, on all ranks
    const double weight = 9.81 * measure_motion(world).mass;
    CHECK(load[2] == doctest::Approx(-weight).epsilon(0.05));
    handle<plane> lid;
    world.global([&](auto& scope) {
      lid = scope.add(plane{.normal = {0, 0, -1}, .offset = -2.2}, stone);
    });
    world.hold_force(lid, {.force = 50, .max_speed = 1});
    world.simulate({.steps = 700, .dt = 0.005});
    CHECK(contact_force(world, lid)[2] == doctest::Approx(50).epsilon(0.1));
    const std::vector<contact_load> loads = contact_forces(world, std::array{floor, lid});
    const vec3 on_lid = loads[1].force, about_its_position = loads[1].torque;
    CHECK((on_lid - contact_force(world, lid)).norm() < 1e-9);
    CHECK((about_its_position - contact_torque(world, lid, world[lid].position())).norm() < 1e-9);
  });
}

TEST_CASE("forces: a field, a fluid, and a push") {
  on_ranks<grains>(1, [](auto& world) {
    const auto stone = world.material({.density = 2.8});
    add_force_field(world, [](const vec3& x, real /*time*/) { return vec3(-0.5 * x); });
    add_fluid(world, fluid{.density = 1, .viscosity = 0.1, .velocity = vec3(0, 0, 1)});
    const auto grain = world.add(sphere{0.2}, stone, {1, 0, 0});
    world[grain].add_force({0, 3, 0});  // in the next step
    world.simulate({.steps = 1, .dt = 0.01});
    const vec3 v = world[grain].velocity();
    CHECK(v[0] < 0);
    CHECK(v[1] > 0);
    CHECK(v[2] > 0);
  });
}

TEST_CASE("bodies: read, added and removed while the run goes on, at a rate") {
  on_ranks<grains>(2, [](auto& world) {
    const auto stone = floor_and_grains(world).first;
    world.observe(every{100}, [&](auto& w) {
      w.add_if_local(body{.shape = sphere{0.3}, .position = {0, 0, 6}, .material = stone});
      w.destroy_if([](const auto& b) { return b.position()[2] < -1; });
    });
    const auto in = insert_by_rate(
        world, {.bodies = 20}, box_region{{-2, -2, 3}, {2, 2, 5}},
        [&](const site& place, random_stream& /*random*/) {
          return body{.shape = sphere{0.3}, .position = place.position, .material = stone};
        });
    const outflow out = remove_in(world, box_region{{-9, -9, -9}, {9, 9, 0.46}});
    world.simulate({.steps = 120, .dt = 0.005});
    const removed gone = out.total(world);

    std::array<double, 2> sums{};  // mass times height, mass
    world.for_each_local(
        [&](const auto& b) { sums[0] += b.mass() * b.position()[2], sums[1] += b.mass(); });
    world.link().reduce(reduction::sum, std::span<double>(sums));
    const double height = sums[0] / sums[1];
    CHECK(in->count >= 3);
    CHECK(gone.count > 0);
    CHECK(measure_motion(world).bodies == 9 + 1 + in->count - gone.count);
    CHECK(height > 0.5);
    CHECK(height < 6);
  });
}

TEST_CASE("contacts: friction of a pair, and the contacts one by one") {
  on_ranks<grains>(1, [](auto& world) {
    world.gravity({0, 0, -9.81});
    const auto steel = world.material({.density = 7.8, .friction = 0.3});
    const auto teflon = world.material({.density = 2.2, .friction = 0.05});
    world.material_pair(steel, teflon, {.restitution = 0.1, .friction = 0.04});
    CHECK(world.materials().pair(teflon, steel).friction == 0.04);
    const auto smooth = world.material({.friction = 0});
    world.pair_rules({.friction = pair_rule::least});
    CHECK(world.materials().pair(smooth, steel).friction == 0);
    CHECK(world.materials().pair(teflon, steel).friction == 0.04);
    world.global([&](auto& scope) { scope.add(plane{}, teflon); });
    world.add(sphere{0.5}, steel, {0, 0, 0.5});
    world.simulate({.steps = 50, .dt = 0.005});
    double largest = 0;
    for_each_contact(
        world, [&](const loaded_contact& c) { largest = std::max(largest, c.normal_force()); });
    CHECK(largest == doctest::Approx(9.81 * measure_motion(world).mass).epsilon(1e-3));
    const scratch_folder here;
    body_table(world).write_csv("bodies.csv");
    contact_table(world).write_csv("contacts.csv");
    CHECK(std::filesystem::exists("bodies.csv"));
    CHECK(contact_table(world).numbers("normal_force").at(0) == largest);
  });
}

namespace {

/// Pulls with a constant force, up to a gap.
struct sticky_film {
  using talus_part_of = roles::contact_law;
  static constexpr const char* name = "sticky_film";
  struct parameters {
    double force = 0, reach = 0;
    friend bool operator==(const parameters&, const parameters&) = default;
  };
  using memory = no_memory;

  static double range(const parameters& p, double /*radius*/) { return p.reach; }
  static interaction_force force(const contact_kinematics& c, const parameters& p, double /*dt*/,
                                 memory&) {
    interaction_force f;
    f.force = f.conserved = -p.force * c.normal;
    return f;
  }
  static stored_energy stored(const contact_kinematics& c, const parameters& p, const memory&) {
    return {.normal = p.force * (c.gap - p.reach)};
  }
  static double longest_step(const parameters&, double /*mass*/) {
    return std::numeric_limits<double>::infinity();
  }
  static double duration(const parameters&, const head_on_impact&) {
    return std::numeric_limits<double>::infinity();
  }
};

}  // namespace

TEST_CASE("contacts: soft ones with a law of one's own, and their time step") {
  using soft = scenario<bodies<sphere, plane>,
                        soft_contact<linear_spring_dashpot, coulomb_friction, sticky_film>,
                        integrator<velocity_verlet>>;
  on_ranks<soft>(1, [](auto& world) {
    world.gravity({0, 0, -9.81});
    const auto grain =
        world.material({.density = 2, .restitution = 0.4, .friction = 0.5, .stiffness = 1e4});
    world.interaction(grain, grain, sticky_film::parameters{.force = 5, .reach = 0.05});
    world.global([&](auto& scope) { scope.add(plane{.normal = {0, 0, -1}, .offset = -1}, grain); });
    const auto light = world.add(sphere{0.3}, grain, {0, 0, 0.7});    // 2.2 N hang
    const auto heavy = world.add(sphere{0.45}, grain, {2, 0, 0.55});  // 7.5 N fall
    const double dt = critical_dt(world) / 5;
    world.simulate({.steps = 800, .dt = dt});
    CHECK(world[light].position()[2] == doctest::Approx(0.7).epsilon(0.01));
    CHECK(world[heavy].position()[2] < 0.5);
  });
}

TEST_CASE("contacts: powders that stick") {
  using powder =
      scenario<bodies<sphere>, soft_contact<jkr_adhesion, coulomb_friction, rolling_resistance>>;
  on_ranks<powder>(1, [](auto& world) {
    const auto grain = world.material({.density = 1,
                                       .restitution = 0.5,
                                       .friction = 0.4,
                                       .youngs_modulus = 2e4,
                                       .rolling_friction = 0.05});
    world.interaction(grain, grain, jkr_adhesion::given{.work_of_adhesion = 2});
    const auto a = world.add(body{.shape = sphere{0.3}, .position = {-0.3, 0, 0}});
    const auto b =
        world.add(body{.shape = sphere{0.3}, .position = {0.31, 0, 0}, .velocity = {-0.2, 0, 0}});
    world.simulate({.steps = 4000, .dt = critical_dt(world) / 5});
    CHECK((world[a].position() - world[b].position()).norm() < 0.61);
  });
}

TEST_CASE("contacts: liquid bridges") {
  using wet =
      scenario<bodies<sphere>,
               soft_contact<linear_spring_dashpot, coulomb_friction, from_films<willett_bridge>>,
               features<surface_liquid>>;
  on_ranks<wet>(1, [](auto& world) {
    const auto grain =
        world.material({.density = 1, .restitution = 0.3, .friction = 0.4, .stiffness = 1e4});
    world.interaction(grain, grain,
                      willett_bridge::parameters{
                          .tension = 0.05, .angle = 0.2, .volume = 1e-3, .viscosity = 0.02});
    world.add(body{.shape = sphere{0.5}, .position = {-0.5, 0, 0}, .material = grain});
    world.add(body{.shape = sphere{0.5}, .position = {0.4999, 0, 0}, .material = grain});
    world.for_each_local([](auto&& b) { b.template set<liquid>(0.01 * b.shape().volume()); });
    world.simulate({.steps = 100, .dt = critical_dt(world) / 5});
    const liquid_content water = total_liquid(world);
    CHECK(water.count == 1);
    CHECK(water.bridges > 0);
    CHECK(water.total() == doctest::Approx(0.01 * 2 * 4 * pi / 3 * 0.125));
  });
}

TEST_CASE("contacts: bonds that break") {
  const scratch_folder folder;
  using rock = scenario<bodies<sphere>, soft_contact<linear_spring_dashpot, parallel_bond>>;
  on_ranks<rock>(1, [](auto& world) {
    const auto grain = world.material({.density = 1, .stiffness = 1e5});
    world.interaction(grain, grain,
                      parallel_bond::parameters{.youngs_modulus = 1e5,
                                                .poisson_ratio = 0.2,
                                                .range = 0.5,
                                                .tensile_strength = 1e3,
                                                .shear_strength = 1e3});
    for (const int side : {-1, 1})
      world.add(body{.shape = sphere{0.5},
                     .position = {0.5 * side, 0, 0},
                     .material = grain,
                     .velocity = {5.0 * side, 0, 0}});
    const auto bonds = bond_within(world, 0.01);  // the gap of the surfaces, a length
    record_breaks(world, "breaks.csv", every{20});
    world.simulate({.steps = 200, .dt = critical_dt(world) / 5});
    CHECK(bonds == 1);
    CHECK(count_bonds(world).intact == 0);
    CHECK(std::filesystem::exists("breaks.csv"));
  });
}

TEST_CASE("joints: a hinge with a motor") {
  using machine = scenario<bodies<box>, joints<hinge>>;
  on_ranks<machine>(1, [](auto& world) {
    const auto steel = world.material({.density = 7.8});
    const auto arm = world.add_if_local(
        body{.shape = box{{1, 0.2, 0.2}}, .position = {0.5, 0, 0}, .material = steel});
    auto pin = world.join(world_frame, arm,
                          hinge{.axis = {0, 1, 0}, .motor = {.velocity = 2, .largest_torque = 50}});
    world.simulate({.steps = 200, .dt = 0.005});
    const double turned = pin.angle(), load = pin.force().norm();
    pin.set_motor(torque_motor{.velocity = 0, .largest_torque = 50});  // a brake
    world.simulate({.steps = 200, .dt = 0.005});
    CHECK(turned == doctest::Approx(2).epsilon(0.1));
    CHECK(load > 0);
    CHECK(pin.angle() < 2.2);
  });
}

TEST_CASE("ranks: the domains") {
  using cells = scenario<bodies<sphere>, decomposition<hexagonal<1>>>;
  on_ranks<cells>(7, [](auto& world) {
    world.decompose({.spacing = 4, .axis = {0, 0, 1}});
    CHECK(world.connections().size() == (world.rank() == 0 ? 6 : 3));
    CHECK(world.contains({0, 0, 0}) == (world.rank() == 0));
  });
}

TEST_CASE("ranks: a load that moves") {
  using moving =
      scenario<bodies<sphere, plane>, decomposition<bisection<dynamic>>, features<balancing>>;
  on_ranks<moving>(2, [](auto& world) {
    world.decompose({.lower = {-10}, .upper = {10}});
    world.balance({.every = 500, .above = 1.2});
    world.material({.density = 1});
    for (int k = 0; k < 8; ++k)
      world.add_if_local(body{.shape = sphere{0.4}, .position = {1.0 + k, 0, 0}});
    world.simulate({.steps = 2, .dt = 0.005});
    CHECK(world.local_bodies() == 4);
  });
}

namespace {

/// Runs the program with these words on its command line; the results of its last rank 0.
int run_with(std::vector<std::string> words, auto&& set_up) {
  words.insert(words.begin(), "grains");
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  return run<grains, my_options>(static_cast<int>(arguments.size()), arguments.data(), set_up);
}

}  // namespace

TEST_CASE("a program: options, files, the end, and its measurements") {
  const scratch_folder folder;
  std::string digest;
  const auto program = [&](auto& world, const my_options& options) {
    if (world.ranks() > 1) world.decompose({.lower = {-3}, .upper = {3}});
    const double slope = options.slope * pi / 180;
    world.gravity({9.81 * std::sin(slope), 0, -9.81 * std::cos(slope)});
    const auto stone = world.material({.density = 2.8, .restitution = 0.3, .friction = 0.5});
    handle<plane> floor;
    world.global([&](auto& scope) { floor = scope.add(plane{}, stone); });
    world.fill(simple_cubic{.spacing = 1} & box_region{{-1, -1, 0.5}, {1, 1, 1.5}},
               [&](const site& place) {
                 return body{.shape = sphere{0.45}, .position = place.position, .material = stone};
               });
    world.sleeping({.speed = 0.01, .time = 0.2});
    world.stop_when(every{100}, [](auto& w) { return measure_motion(w).max_speed < 1e-3; });
    take_pictures(world, options, {.from = {6, -9, 5}, .at = {0, 0, 1}, .angle = 40});
    int impacts = 0;
    world.keep("impacts", impacts);
    world.observe(every{10}, [&](auto& w) {
      w.record("load on the floor", contact_force(w, floor)[2], "M L/T^2");
    });
    world.simulate({.steps = options.steps, .dt = options.dt});

    const energy_balance books = measure_energy(world);
    const double lost = books.total.friction + books.total.impact, error = books.worst;
    CHECK(error < 1e-10);
    CHECK(std::abs(lost) > 0);
    const coarse_fields fields =
        measure_fields(world, {.lower = {-2, -2, 0}, .upper = {2, 2, 2}, .cells = {1, 1, 4}});
    const double pressure = fields.pressure(0), fraction = fields.solid_fraction(0);
    CHECK(pressure > -1e-9);
    CHECK(fraction > 0);
    const stage_seconds t = world.stage_times();
    const double total = t.detect + t.respond + t.integrate + t.exchange;
    CHECK(total > 0);
    const std::string bits = state_digest(world);  // 16 digits, the same on any number of ranks
    if (world.rank() == 0) digest = bits;
  };

  CHECK(run_with({"--quiet", "--slope", "10", "--csv", "run.csv", "--frames", "pictures",
                  "--output", "bodies", "--output-every", "30", "--reproducible"},
                 program) == 0);
  const std::string on_one_rank = digest;
  for (const char* file :
       {"run.csv", "pictures/frame_00000.pov", "bodies.hdf.series", "bodies_0000000030.hdf"})
    CHECK_MESSAGE(std::filesystem::exists(file), file);

  digest.clear();
  CHECK(run_with({"--quiet", "--slope", "10", "--reproducible", "--ranks", "2"}, program) == 0);
  CHECK(digest == on_one_rank);

  CHECK(run_with({"--quiet", "--slope", "10", "--reproducible", "--steps", "100", "--checkpoint",
                  "half.h5"},
                 program) == 0);
  digest.clear();
  CHECK(run_with({"--quiet", "--slope", "10", "--reproducible", "--steps", "200", "--restart",
                  "half.h5", "--ranks", "2"},
                 program) == 0);
  CHECK(digest == on_one_rank);
}

TEST_CASE("a run stops at rest") {
  on_ranks<grains>(1, [](auto& world) {
    (void)floor_and_grains(world);
    world.sleeping({.speed = 0.05, .time = 0.2});
    world.stop_when(every{100}, [](auto& w) { return measure_motion(w).max_speed < 1e-3; });
    world.simulate({.steps = 5000, .dt = 0.005});
    CHECK(world.stopped());
    CHECK(world.steps() < 5000);
  });
}
