// talus: joints solved exactly, springs implicit, with its two integrators; and, for the grid, by
// one sweep in each of many substeps. Bodies have no surface: the scenes are mechanisms.
#include <map>
#include <memory>
#include <talus/constraint/ball_joint.hpp>
#include <talus/constraint/hinge.hpp>
#include <talus/constraint/slider.hpp>
#include <talus/constraint/strut.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/solver/substepping.hpp>
#include <talus/world/world.hpp>

#include "runner.hpp"

namespace bench::joints {

/// A body with given moments of inertia that touches nothing.
struct solid {
  talus::vec3 moments{1, 1, 1};  ///< over the mass
  talus::real radius = 1;

  static constexpr bool finite = true;
  static constexpr bool isotropic = false;
  static constexpr const char* name = "solid";
  static constexpr bool homogeneous = false;  // any moments
  void validate() const {}
  [[nodiscard]] talus::real bounding_radius() const { return radius; }
  [[nodiscard]] talus::real volume() const { return 1; }
  [[nodiscard]] talus::vec3 inertia() const { return moments; }
  [[nodiscard]] talus::vec3 support(const talus::vec3& d) const { return radius * talus::unit(d); }
  [[nodiscard]] talus::vec3 half_extents(const talus::pose&) const {
    return {radius, radius, radius};
  }
  friend bool operator==(const solid&, const solid&) = default;
};
template <class Sink>
void collide(const solid&, const talus::pose&, const solid&, const talus::pose&, talus::real,
             Sink&&) {}

namespace {

talus::vec3 to(const vec& v) { return {v.x(), v.y(), v.z()}; }
vec from(const talus::vec3& v) { return {v[0], v[1], v[2]}; }

/// A scene in a world of talus, with any integrator.
struct machine {
  virtual ~machine() = default;
  virtual void step(double dt) = 0;
  virtual void read(std::vector<state>& now) = 0;
};

template <class... Policies>
class machine_with final : public machine {
  using scene_type =
      talus::scenario<talus::bodies<solid>,
                      talus::joints<talus::ball_joint, talus::hinge, talus::slider, talus::strut>,
                      talus::transport<talus::serial>, talus::features<talus::forces>, Policies...>;

 public:
  explicit machine_with(const scene& s, int iterations = 1) : drives_(s.drives), world_(link_) {
    world_.gravity(to(s.gravity));
    world_.solver().iterations = iterations;
    std::map<double, talus::material_id> of_mass;  // the volume is 1
    for (const body& b : s.bodies) {
      const turn& q = b.start.orientation;
      if (!of_mass.contains(b.mass)) of_mass[b.mass] = world_.material({.density = b.mass});
      bodies_.push_back(world_.add(
          talus::body{.shape = solid{to(b.inertia / b.mass), 0.1 * s.length},
                      .position = to(b.start.position),
                      .material = of_mass[b.mass],
                      .velocity = to(b.start.velocity),
                      .angular_velocity = to(b.start.spin),
                      .orientation = talus::quat(q.w(), q.x(), q.y(), q.z()).normalized()}));
    }
    for (const joint& j : s.joints) {
      const talus::vec3 at = to(j.at), axis = to(j.axis);
      if (j.type == kind::ball)
        join(j.a, j.b, talus::ball_joint{.at = at});
      else if (j.type == kind::hinge)
        join(j.a, j.b, talus::hinge{.at = at, .axis = axis});
      else
        join(j.a, j.b, talus::slider{.at = at, .axis = axis});
    }
    for (const spring& k : s.springs)
      join(k.a, k.b,
           talus::strut{.from = to(k.at_a),
                        .to = to(k.at_b),
                        .spring = {.stiffness = k.stiffness,
                                   .damping = k.damping,
                                   .rest = k.rest - (k.at_b - k.at_a).norm()}});
  }
  void step(double dt) override {
    for (const drive& d : drives_) world_[bodies_[d.on]].add_torque(to(d.torque));
    world_.step(dt);
  }
  void read(std::vector<state>& now) override {
    for (std::size_t i = 0; i < now.size(); ++i) {
      const auto b = world_[bodies_[i]];
      const talus::quat q = b.orientation();
      now[i] = {from(b.position()), turn(q.w(), q.x(), q.y(), q.z()), from(b.velocity()),
                from(b.angular_velocity())};
    }
  }

 private:
  template <class Kind>
  void join(int a, int b, const Kind& how) {
    if (a == ground)
      (void)world_.join(talus::world_frame, bodies_[b], how);
    else
      (void)world_.join(bodies_[a], bodies_[b], how);
  }

  std::vector<drive> drives_;
  talus::serial::link link_;
  talus::world<scene_type> world_;
  std::vector<talus::handle<solid>> bodies_;
};

class talus_joints {
 public:
  static constexpr const char* name = "talus";
  static std::vector<plan> plans() {
    std::vector<plan> list;
    for (const char* integrator : {"semi_implicit_euler", "moreau_midpoint"}) {
      list.push_back({"A01", integrator, {1e-2, 1e-3, 1e-4}, {1e-2, 1e-3}});
      list.push_back({"A02_2", integrator, {1e-2, 1e-3, 1e-4}, {1e-2, 1e-3}});
      list.push_back({"A02_10", integrator, {1e-2, 1e-3}, {1e-2}});
      list.push_back({"A02_40", integrator, {1e-2, 1e-3}, {1e-2}});
      list.push_back({"A03", integrator, {1e-4, 1e-5, 1e-6}, {1e-4, 1e-5}});
      list.push_back({"A04", integrator, {1e-2, 1e-3, 1e-4}, {1e-2, 1e-3}});
      list.push_back({"A05", integrator, {1e-2, 1e-3, 1e-4}, {1e-2, 1e-3}});
      list.push_back({"chain_", integrator, {1e-3}, {1e-3}});
    }
    list.push_back({"grid_", "substepping_10", {1e-2}, {1e-2}});
    list.push_back({"grid_", "substepping_50", {1e-2}, {1e-2}});
    list.push_back({"grid_", "semi_implicit_euler", {1e-2}, {}});
    return list;
  }
  static std::vector<std::string> notes() { return {}; }

  talus_joints(const scene& s, const std::string& integrator, double dt)
      : now_(start_of(s)), dt_(dt) {
    if (integrator == "semi_implicit_euler")
      machine_ = std::make_unique<machine_with<>>(s);
    else if (integrator == "moreau_midpoint")
      machine_ = std::make_unique<machine_with<talus::integrator<talus::moreau_midpoint>>>(s);
    else if (begins(integrator, "substepping_"))
      machine_ = std::make_unique<machine_with<talus::solver<talus::substepping>>>(
          s, std::stoi(integrator.substr(integrator.rfind('_') + 1)));
    else
      throw std::invalid_argument("there is no integrator '" + integrator + "'");
  }

  void advance(long steps) {
    for (long i = 0; i < steps; ++i) machine_->step(dt_);
    machine_->read(now_);
  }

  const std::vector<state>& states() const { return now_; }

 private:
  std::vector<state> now_;
  double dt_;
  std::unique_ptr<machine> machine_;
};

}  // namespace
}  // namespace bench::joints

int main(int argc, char** argv) {
  return bench::joints::run<bench::joints::talus_joints>(argc, argv);
}
