// A bucket on a hinge digs through grains in a trough. Its motor holds the speed; the torque over
// the angle is recorded with --csv FILE, and the work of the motor is in the energy ledger.
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
using namespace talus;

using bucket_shape = union_of<box>;
using excavator =
    scenario<bodies<sphere, bucket_shape, plane>, joints<hinge>, hard_contact<coulomb_friction>,
             solver<reproducible>, decomposition<grid<dynamic>>, transport<as_launched>,
             features<energy_ledger, checkpoints>>;

struct excavator_options : options {
  int grains = 600;
  double speed = 0.6;

  excavator_options() {
    steps = 2400, dt = 0.0025, iterations = 40;
  }  // the mean grain has the radius 0.12
  void describe(auto& line) {
    options::describe(line);
    line.add("--grains", grains, "number of grains", 0);
    line.add_positive("--speed", speed, "of the bucket, radians per unit of time");
  }
};

/// A bucket at the end of an arm of length R; the hinge is at the origin, the blade below it.
bucket_shape make_bucket(double R, double width) {
  const double d = 0.2 * R, t = 0.06;  // depth, thickness of the steel
  std::vector<bucket_shape::part> parts{
      {box{{0.1 * R, 0.1, R - d}}, {{0, 0, -0.5 * (R - d)}}},
      {box{{t, width, d}}, {{-0.5 * d, 0, -R + 0.5 * d}}},             // back
      {box{{d, width, t}}, {{0, 0, -R + d}}},                          // top
      {box{{d, width, t}}, {{0, 0, -R}, rotation({0, 1, 0}, 0.15)}}};  // blade
  for (const double side : {-0.5, 0.5})
    parts.push_back({box{{d, t, d}}, {{0, side * width, -R + 0.5 * d}}});
  return bucket_shape(parts);
}

int main(int argc, char** argv) {
  return run<excavator, excavator_options>(
      argc, argv, [](auto& world, const excavator_options& options) {
        // The trough grows with the number of grains, twice as long as wide.
        const double r = 0.12, pitch = 2.3 * r, g = 9.81;
        const double layers = std::max(4., std::round(0.6 * std::cbrt(options.grains)));
        const double W = std::max(std::sqrt(options.grains / layers / 8) * pitch, 8 * r), L = 2 * W;
        const double bed = layers * pitch;
        const double R = 0.75 * L, from = -1.2,
                     to = 1.2;  // of the bucket: radius, angles from the vertical
        world.decompose({.lower = {-L}, .upper = {L}}, reach{1.5 * R});
        world.units({.length = "m", .mass = "t", .time = "s"});
        world.gravity({0, 0, -g});
        const auto sand = world.material({.density = 2.5, .friction = 0.5});
        const auto steel = world.material({.density = 7.8, .friction = 0.3});
        world.global([&](auto& scope) {
          scope.add(plane{}, sand);
          for (const double side : {-1, 1}) {
            scope.add(plane{.normal = {-side, 0, 0}, .offset = -L}, steel);
            scope.add(plane{.normal = {0, -side, 0}, .offset = -W}, steel);
          }
        });
        const vec3 pivot(0, 0, 0.45 * bed + R), axis(0, -1, 0);  // positive angles dig towards +x
        // The bucket keeps more than two grains away from the walls. In a narrower gap grains jam,
        // and the torque of a motor without a bound is then that of crushing them.
        const bucket_shape shape = make_bucket(R, 0.8 * W);
        const pose at = placed(shape, {pivot, rotation(axis, from)});
        const auto bucket = world.add_if_local(body{.shape = shape,
                                                    .position = at.position,
                                                    .material = steel,
                                                    .orientation = at.orientation});
        const torque_motor rest{.largest_torque = no_limit};
        auto pin = world.join(world_frame, bucket, hinge{.at = pivot, .axis = axis, .motor = rest});
        world.fill((simple_cubic{.spacing = pitch, .origin = {0, 0, 1.05 * r}} &
                    box_region{{-L + r, -W + r, 0}, {L - r, W - r, 1000}})
                       .first(options.grains),
                   [&](const site& place, random_stream& random) {
                     return body{.shape = sphere{random.uniform(0.9 * r, 1.1 * r)},
                                 .position = place.position,
                                 .material = sand};
                   });
        take_pictures(world, options,
                      {.from = {0.6 * L, -3.4 * L, 1.5 * L},
                       .at = {0, 0, 0.4 * R},
                       .angle = 40,
                       .ground = false});

        // The grains settle, the bucket digs, and stands again. What digging takes is the torque of
        // the motor on the bucket without that of its weight.
        const auto settled = static_cast<std::uint64_t>(std::lround(1.5 / options.dt));
        const double way = to - from, weight = 7.8 * shape.volume() * g;
        const vec3 arm = at.position - pivot;
        std::array<double, 2> angles{};  // of the last steps
        double torque = 0, work = 0, most = 0, sum = 0, speed = 0;
        world.keep("angles", angles), world.keep("speed", speed), world.keep("work", work);
        world.keep("most", most), world.keep("sum", sum);
        world.after_each_step("torque of the bucket", [&] {
          const joint_reading now = measure_joint(world, pin);
          angles = {now.angle, angles[0]};
          torque = -now.torque.dot(axis);
          const double before = speed;
          speed = 0;
          world.for_each_local([&](const auto& b) {
            if constexpr (std::is_same_v<std::remove_cvref_t<decltype(b.shape())>, bucket_shape>)
              speed = b.angular_velocity().dot(axis);
          });
          world.link().reduce(reduction::sum, std::span(&speed, 1));
          work += 0.5 * torque * (before + speed) * options.dt;  // at the mean speed of the step
          const vec3 pull = rotated(rotation(axis, now.angle), arm).cross(vec3(0, 0, -weight));
          const double digging = torque + pull.dot(axis);
          if (world.steps() > settled + 2 && now.angle > 0 && now.angle < way) {
            most = std::max(most, std::abs(digging));
            sum += digging * (angles[0] - angles[1]) / way;
          }
          world.record("angle", from + now.angle);
          world.record("digging_torque", digging, "M L^2/T^2");
          if (world.steps() == settled)
            pin.set_motor(torque_motor{.velocity = options.speed, .largest_torque = no_limit});
          if (now.angle >= way) pin.set_motor(rest);
        });
        world.simulate({.steps = options.steps, .dt = options.dt});
        const energy_balance energy = measure_energy(world);
        const double scale = weight * arm.norm();
        return results{
            {"angle", from + angles[0]},
            {"digging_torque", sum / scale},  // mean, over the largest of the weight
            {"largest_torque", most / scale},
            {"work", work},
            {"work_error", std::abs(energy.total.motors / work - 1)},  // against the ledger
            {"ledger", energy.worst}};
      });
}
