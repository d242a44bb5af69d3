// Simbody: joint coordinates, loops closed by constraints, Runge-Kutta-Merson and CPodes with error
// control. Its accuracy is in the name of the integrator; dt is the interval of the reports.
#include <Simbody.h>

#include <memory>

#include "runner.hpp"
#include "tree.hpp"

namespace {

using namespace bench::joints;

SimTK::Vec3 to(const vec& v) { return {v.x(), v.y(), v.z()}; }
vec from(const SimTK::Vec3& v) { return {v[0], v[1], v[2]}; }

class simbody_joints {
 public:
  static constexpr const char* name = "simbody";
  static std::vector<plan> plans() {
    std::vector<plan> list;
    for (const char* accuracy : {"1e-3", "1e-5", "1e-7", "1e-9"}) {
      const bool quick = std::string(accuracy) == "1e-5" || std::string(accuracy) == "1e-7";
      for (const char* scenes : {"A01", "A02_2", "A02_10", "A03", "A04"}) {
        const double dt = std::string(scenes) == "A03" ? 3e-4 : 0.1;
        list.push_back({scenes,
                        std::string("runge_kutta_merson_") + accuracy,
                        {dt},
                        quick ? std::vector{dt} : std::vector<double>{}});
      }
      list.push_back({"A05",
                      std::string("cpodes_") + accuracy,
                      {0.1},
                      quick ? std::vector{0.1} : std::vector<double>{}});
    }
    list.push_back({"A02_40", "runge_kutta_merson_1e-5", {0.1}, {}});
    list.push_back({"chain_", "runge_kutta_merson_1e-5", {0.01}, {}});
    return list;
  }
  static std::vector<std::string> notes() {
    return {"grid: the dense matrix of 29,700 loop rows is too large"};
  }

  simbody_joints(const scene& s, const std::string& integrator, double dt)
      : s_(s), now_(start_of(s)), dt_(dt), matter_(system_), forces_(system_) {
    using namespace SimTK;
    Force::UniformGravity(forces_, matter_, to(s.gravity));
    const tree t = tree_of(s);
    bodies_.resize(s.bodies.size());
    for (const int i : t.order) {
      const body& b = s.bodies[i];
      Body::Rigid rigid(MassProperties(b.mass, Vec3(0), Inertia(to(b.inertia))));
      const joint& j = s.joints[t.joint_of[i]];
      MobilizedBody& parent = t.parent_of[i] == ground
                                  ? static_cast<MobilizedBody&>(matter_.updGround())
                                  : bodies_[t.parent_of[i]];
      const Transform in_parent = frame(j, t.parent_of[i]), in_child = frame(j, i);
      if (j.type == kind::ball)
        bodies_[i] = MobilizedBody::Ball(parent, in_parent, rigid, in_child);
      else if (j.type == kind::hinge)
        bodies_[i] = MobilizedBody::Pin(parent, in_parent, rigid, in_child);
      else
        bodies_[i] = MobilizedBody::Slider(parent, in_parent, rigid, in_child);
    }
    for (const int i : t.loops) {
      const joint& j = s.joints[i];
      MobilizedBody &a = of(j.a), &b = of(j.b);
      const Transform in_a = frame(j, j.a), in_b = frame(j, j.b);
      Constraint::Ball(a, in_a.p(), b, in_b.p());
      // In plane mechanisms the axes stay parallel by the joints of the tree.
      if (s.name == "A04") {
        Constraint::ConstantAngle(a, in_a.x(), b, in_b.z());
        Constraint::ConstantAngle(a, in_a.y(), b, in_b.z());
      }
    }
    for (const spring& k : s.springs) {
      const Vec3 pa = local(k.a, k.at_a), pb = local(k.b, k.at_b);
      Force::TwoPointLinearSpring(forces_, of(k.a), pa, of(k.b), pb, k.stiffness, k.rest);
      if (k.damping > 0) Force::TwoPointLinearDamper(forces_, of(k.a), pa, of(k.b), pb, k.damping);
    }
    // In plane mechanisms, on a body that a hinge joins to the ground.
    for (const drive& d : s.drives)
      Force::MobilityConstantForce(forces_, bodies_[d.on], MobilizerUIndex(0), d.torque.z());
    State state = system_.realizeTopology();
    system_.realizeModel(state);
    for (const int i : t.order) {
      const vec w = s.bodies[i].start.spin;
      if (w.norm() == 0 && s.bodies[i].start.velocity.norm() == 0) continue;
      system_.realize(state, Stage::Position);
      bodies_[i].setUToFitVelocity(state, relative(state, t, i));
    }
    const double accuracy = std::stod(integrator.substr(integrator.rfind('_') + 1));
    if (begins(integrator, "cpodes"))
      integrator_ = std::make_unique<CPodesIntegrator>(system_, CPodes::BDF, CPodes::Newton);
    else
      integrator_ = std::make_unique<RungeKuttaMersonIntegrator>(system_);
    integrator_->setAccuracy(accuracy);
    integrator_->setConstraintTolerance(accuracy / 10);
    stepper_ = std::make_unique<TimeStepper>(system_, *integrator_);
    stepper_->initialize(state);
    time_ = 0;
  }

  void advance(long steps) {
    time_ += dt_ * static_cast<double>(steps);
    stepper_->stepTo(time_);
    const SimTK::State& state = stepper_->getState();
    system_.realize(state, SimTK::Stage::Velocity);
    for (std::size_t i = 0; i < now_.size(); ++i) {
      const SimTK::Quaternion q = bodies_[i].getBodyRotation(state).convertRotationToQuaternion();
      now_[i] = {from(bodies_[i].getBodyOriginLocation(state)), turn(q[0], q[1], q[2], q[3]),
                 from(bodies_[i].getBodyOriginVelocity(state)),
                 from(bodies_[i].getBodyAngularVelocity(state))};
    }
  }

  const std::vector<state>& states() const { return now_; }

 private:
  SimTK::MobilizedBody& of(int i) {
    return i == ground ? static_cast<SimTK::MobilizedBody&>(matter_.updGround()) : bodies_[i];
  }

  SimTK::Vec3 local(int i, const vec& at) const {
    if (i == ground) return to(at);
    const state& b = s_.bodies[i].start;
    return to(b.orientation.conjugate() * (at - b.position));
  }

  /// Frame of a joint in a body: z along the axis of a hinge, x along that of a slider.
  SimTK::Transform frame(const joint& j, int i) const {
    const vec first = j.type == kind::slider ? vec::UnitX() : vec::UnitZ();
    turn q = turn::FromTwoVectors(first, j.axis);
    if (i != ground) q = s_.bodies[i].start.orientation.conjugate() * q;
    return {SimTK::Rotation(SimTK::Quaternion(q.w(), q.x(), q.y(), q.z())), local(i, j.at)};
  }

  /// Velocity of the outer frame of the joint of a body in the inner one.
  SimTK::SpatialVec relative(const SimTK::State& state, const tree& t, int i) const {
    const joint& j = s_.joints[t.joint_of[i]];
    const auto at = [&](int of) -> std::pair<vec, vec> {
      if (of == ground) return {vec::Zero(), vec::Zero()};
      const bench::joints::state& b = s_.bodies[of].start;
      return {b.spin, b.velocity + b.spin.cross(j.at - b.position)};
    };
    const auto [wa, va] = at(t.parent_of[i]);
    const auto [wb, vb] = at(i);
    const vec first = j.type == kind::slider ? vec::UnitX() : vec::UnitZ();
    const turn back = turn::FromTwoVectors(first, j.axis).conjugate();
    static_cast<void>(state);
    return {to(back * (wb - wa)), to(back * (vb - va))};
  }

  scene s_;
  std::vector<state> now_;
  double dt_, time_ = 0;
  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_;
  SimTK::GeneralForceSubsystem forces_;
  std::vector<SimTK::MobilizedBody> bodies_;
  std::unique_ptr<SimTK::Integrator> integrator_;
  std::unique_ptr<SimTK::TimeStepper> stepper_;
};

}  // namespace

int main(int argc, char** argv) { return bench::joints::run<simbody_joints>(argc, argv); }
