// A rover with six wheels on rockers and bogies drives over loose ground, or with smooth wheels
// over a floor. A force pulls it back: drawbar pull against slip.
#include <algorithm>
#include <array>
#include <numeric>
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
using namespace talus;

using tyre_shape = union_of<cylinder, box>;
using rover =
    scenario<bodies<sphere, box, tyre_shape, plane>, joints<hinge, rod>,
             hard_contact<coulomb_friction>, solver<reproducible>, decomposition<grid<dynamic>>,
             transport<as_launched>, features<forces, user_ids, energy_ledger, checkpoints>>;

struct rover_options : options {
  int layers = 3;
  double pull = 0.1, length = 5;

  rover_options() { steps = 2500, dt = 0.002, iterations = 30; }  // metres, seconds, tonnes
  void describe(auto& line) {
    options::describe(line);
    line.add("--layers", layers, "of grains; 0: the rover drives on the floor", 0);
    line.add("--pull", pull, "drawbar pull over the weight of the rover", 0.0, 1.0);
    line.add_positive("--length", length, "of the ground");
  }
};

constexpr double wheel_radius = 0.25, speed = 2;  // of the wheels, radians per second

/// A wheel about the y axis, with lugs that grip loose ground.
tyre_shape make_tyre(bool lugs) {
  const double width = 0.22;
  const int number = lugs ? 12 : 0;
  std::vector<tyre_shape::part> parts{
      {cylinder{wheel_radius, width}, {{0, 0, 0}, rotation({1, 0, 0}, 0.5 * pi)}}};
  for (int k = 0; k < number; ++k) {
    const quat turn = rotation({0, 1, 0}, 2 * pi * k / number);
    parts.push_back({box{{0.02, width, 0.05}}, {rotated(turn, {0, 0, wheel_radius}), turn}});
  }
  return tyre_shape(parts);
}

enum : std::uint32_t { grain, hull_of_rover };  // user ids; the other parts have 2 to 12
constexpr std::size_t parts_of_rover = 12;
constexpr std::array names_of_wheels{"torque_right_front", "torque_right_middle",
                                     "torque_right_rear",  "torque_left_front",
                                     "torque_left_middle", "torque_left_rear"};

/// Adds a rover whose middle wheels are at x on ground of height z. Returns the hinges of its
/// wheels.
template <class World>
auto add_rover(World& world, double x, double z, material_id steel, material_id rubber,
               const tyre_shape& tyre) {
  std::uint32_t part = hull_of_rover;
  const auto add = [&](const auto& shape, const vec3& at, material_id stuff) {
    const pose p = placed(shape, {vec3(x, 0, z) + at});
    return world.add_if_local(body{.shape = shape,
                                   .position = p.position,
                                   .material = stuff,
                                   .orientation = p.orientation,
                                   .user_id = part++});
  };
  const auto place = [&](double px, double py, double pz) { return vec3(x + px, py, z + pz); };
  const vec3 across(0, 1, 0);
  const double axle = wheel_radius, beam = axle + 0.4;  // heights
  const auto hull = add(box{{1, 0.7, 0.3}}, {0, 0, beam}, steel);
  // A bar across the hull, with a rod to each rocker, keeps the hull at the mean of their angles.
  const auto bar = add(box{{0.06, 0.9, 0.06}}, {0.35, 0, beam + 0.25}, steel);
  (void)world.join(hull, bar, hinge{.at = place(0.35, 0, beam + 0.25)});
  std::vector<joint_handle<typename World::scenario_type, hinge>> motors;
  for (const double side : {-1, 1}) {
    const double y = 0.45 * side;
    const auto rocker = add(box{{1.4, 0.06, 0.06}}, {0.2, y, beam}, steel);
    const auto bogie = add(box{{0.9, 0.06, 0.06}}, {-0.45, y, beam - 0.15}, steel);
    (void)world.join(hull, rocker, hinge{.at = place(0, y, beam), .axis = across});
    (void)world.join(rocker, bogie, hinge{.at = place(-0.45, y, beam - 0.1), .axis = across});
    (void)world.join(bar, rocker,
                     rod{.from = place(0.35, y, beam + 0.25), .to = place(0.75, y, beam)});
    const auto wheel = [&](const auto& carrier, double at) {
      const auto one = add(tyre, {at, 0.63 * side, axle}, rubber);
      motors.push_back(world.join(carrier, one,
                                  hinge{.at = place(at, 0.63 * side, axle),
                                        .axis = across,
                                        .motor = {.largest_torque = no_limit}}));
    };
    wheel(rocker, 0.9), wheel(bogie, 0), wheel(bogie, -0.9);
  }
  return motors;
}

int main(int argc, char** argv) {
  return run<rover, rover_options>(argc, argv, [](auto& world, const rover_options& options) {
    const double L = options.length, W = 1, r = 0.06, pitch = 2.2 * r, g = 9.81;
    world.decompose({.lower = {0}, .upper = {L}}, reach{2});
    world.gravity({0, 0, -g});
    const auto sand = world.material({.density = 1.6, .friction = 0.7});
    const auto rubber = world.material({.density = 1, .friction = 0.7});
    const auto steel = world.material({.density = 0.5, .friction = 0.3});
    world.global([&](auto& scope) {
      scope.add(plane{}, sand);
      if (options.layers == 0) return;
      for (const double side : {-1, 1}) {
        scope.add(plane{.normal = {-side, 0, 0}, .offset = side > 0 ? -L : 0}, steel);
        scope.add(plane{.normal = {0, -side, 0}, .offset = -W}, steel);
      }
    });
    const double height = options.layers == 0 ? 0 : options.layers * pitch + 0.03;  // with lugs
    world.fill(simple_cubic{.spacing = pitch, .origin = {r, r - W, 1.05 * r}} &
                   box_region{{r, r - W, 0}, {L - r, W - r, options.layers * pitch}},
               [&](const site& place, random_stream& random) {
                 return body{.shape = sphere{random.uniform(0.8 * r, 1.05 * r)},
                             .position = place.position,
                             .material = sand};
               });
    auto motors = add_rover(world, 1.3, height, steel, rubber, make_tyre(options.layers > 0));
    take_pictures(world, options,
                  {.from = {0.75 * L, -6, 2.6},
                   .at = {0.5 * L, 0, 0.3},
                   .angle = 42,
                   .ground = options.layers == 0});

    // The place of the centre of the rover.
    const auto centre = [&] {
      std::array<double, 2> s{};
      world.for_each_local([&](const auto& b) {
        if (b.user_id() != grain) s[0] += b.mass(), s[1] += b.mass() * b.position()[0];
      });
      world.link().reduce(reduction::sum, s);
      return s[1] / s[0];
    };
    world.synchronize();
    // One rank has each part, and all ranks add them in this order: the same bits on any number.
    std::array<double, parts_of_rover> masses{};
    world.for_each_local([&](const auto& b) {
      if (b.user_id() != grain) masses.at(b.user_id() - hull_of_rover) = b.mass();
    });
    world.link().reduce(reduction::sum, masses);
    const double weight = std::accumulate(masses.begin(), masses.end(), 0.0) * g;
    const auto settled = options.steps / 5, measured = options.steps / 2;
    double start = 0;
    world.keep("start", start);
    const auto act = [&] {
      if (world.steps() == settled)
        for (auto& m : motors)
          m.set_motor(torque_motor{.velocity = speed, .largest_torque = no_limit});
      if (world.steps() == measured) start = centre();
      if (world.steps() >= settled)
        world.for_each_local([&](auto& b) {
          if (b.user_id() == hull_of_rover) b.add_force({-options.pull * weight, 0, 0});
        });
      if (world.steps() % options.csv_every != 0) return;
      double torque = 0, power = 0;
      for (std::size_t k = 0; k < motors.size(); ++k) {
        const joint_load wheel = measure_joint(world, motors[k]).motor;
        torque += wheel.load, power += wheel.power;
        world.record(names_of_wheels[k], wheel.load, "M L^2/T^2");
      }
      world.record("wheel_torque", torque, "M L^2/T^2");
      world.record("wheel_power", power, "M L^2/T^3");
    };
    act();
    world.after_each_step(act);
    world.simulate({.steps = options.steps, .dt = options.dt});

    // What motors bear at the end: together the pull, and as nearly alike as statics allows.
    double least = no_limit, most = -no_limit, sum = 0, power = 0;
    for (const auto& m : motors) {
      const joint_load wheel = measure_joint(world, m).motor;
      least = std::min(least, wheel.load), most = std::max(most, wheel.load);
      sum += wheel.load, power += wheel.power;
    }
    const double time = static_cast<double>(options.steps - measured) * options.dt;
    const double v = (centre() - start) / time, rolling = speed * wheel_radius;
    return results{{"speed", v},
                   {"slip", 1 - v / rolling},
                   {"pull", options.pull},
                   {"joint_gap", measure_joints(world).gap},
                   {"torque", sum / (weight * wheel_radius)},  // of all wheels
                   {"torque_differs", (most - least) / (weight * wheel_radius)},
                   {"power", power / (weight * rolling)},
                   {"work", measure_energy(world).total.motors},
                   {"ledger", measure_energy(world).worst}};
  });
}
