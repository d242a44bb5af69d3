#pragma once
// talus: one cube on a plane, with all policies at their defaults.
#include <talus/parallel/serial.hpp>
#include <talus/world/world.hpp>

#include "protocol.hpp"

namespace bench::tosses {

/// A box with the measured moments of inertia, which are not those of an even density.
struct cube : talus::box {
  talus::real moment = 1;  ///< over the mass

  static constexpr const char* name = "cube";
  [[nodiscard]] talus::vec3 inertia() const { return {moment, moment, moment}; }
  friend bool operator==(const cube&, const cube&) = default;
};
template <class Sink>
void collide(const talus::plane& a, const talus::pose& pa, const cube& b, const talus::pose& pb,
             talus::real margin, Sink&& sink) {
  const talus::box& block = b;
  talus::collide(a, pa, block, pb, margin, sink);
}

inline talus::vec3 to(const vec& v) { return {v.x(), v.y(), v.z()}; }
inline vec from(const talus::vec3& v) { return {v[0], v[1], v[2]}; }

class talus_toss {
 public:
  static constexpr const char* name = "talus";

  talus_toss(const settings& how, const state& at) : dt_(how.dt) {
    const double edge = 2 * half_edge;
    const auto stuff = world_.material({.density = mass / (edge * edge * edge),
                                        .restitution = how.restitution,
                                        .friction = how.friction});
    world_.gravity({0, 0, -gravity});
    world_.global([&](auto& scope) { scope.add(talus::plane{}, stuff); });
    const turn& q = at.orientation;
    cube_ = world_.add(
        talus::body{.shape = cube{{.size = {edge, edge, edge}}, inertia / mass},
                    .position = to(at.position),
                    .material = stuff,
                    .velocity = to(at.velocity),
                    .angular_velocity = to(at.spin),
                    .orientation = talus::quat(q.w(), q.x(), q.y(), q.z()).normalized()});
  }

  void step() { world_.step(dt_); }
  [[nodiscard]] state now() {
    const auto b = world_[cube_];
    const talus::quat q = b.orientation();
    return {from(b.position()), turn(q.w(), q.x(), q.y(), q.z()), from(b.velocity()),
            from(b.angular_velocity())};
  }

 private:
  using scene = talus::scenario<talus::bodies<cube, talus::plane>, talus::transport<talus::serial>>;

  double dt_;
  talus::serial::link link_;
  talus::world<scene> world_{link_};
  talus::handle<cube> cube_;
};

}  // namespace bench::tosses
