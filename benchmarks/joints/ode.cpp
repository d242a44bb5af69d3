// Open Dynamics Engine: the big-matrix step (dWorldStep) for mechanisms, the iterative QuickStep
// for the chain and the grid. Error reduction and constraint force mixing are those of its manual.
#include <ode/ode.h>

#include <cmath>

#include "runner.hpp"

namespace {

using namespace bench::joints;

class ode_joints {
 public:
  static constexpr const char* name = "ode";
  static std::vector<plan> plans() {
    return {{"A01", "step", {1e-2, 1e-3, 1e-4}, {1e-2, 1e-3}},
            {"A02_", "step", {1e-2, 1e-3}, {1e-2}},
            {"A03", "step", {1e-4, 1e-5, 1e-6}, {1e-4, 1e-5}},
            {"A04", "step", {1e-2, 1e-3, 1e-4}, {1e-2, 1e-3}},
            {"A05", "step", {1e-4, 1e-5}, {1e-4}},
            {"chain_", "quickstep_100", {1e-3}, {1e-2}},
            {"grid_", "quickstep_100", {1e-3}, {1e-2}}};
  }
  static std::vector<std::string> notes() {
    return {
        "dWorldStep in chain and grid, where it grows with the cube of the rows; QuickStep runs "
        "them"};
  }

  ode_joints(const scene& s, const std::string& integrator, double dt)
      : s_(s), now_(start_of(s)), dt_(dt), quick_(integrator != "step") {
    dInitODE();
    world_ = dWorldCreate();
    dWorldSetGravity(world_, s.gravity.x(), s.gravity.y(), s.gravity.z());
    dWorldSetERP(world_, 0.2);
    dWorldSetCFM(world_, 1e-10);
    dWorldSetQuickStepNumIterations(world_, 100);
    for (const body& b : s.bodies) {
      const dBodyID id = dBodyCreate(world_);
      dMass m;
      dMassSetParameters(&m, b.mass, 0, 0, 0, b.inertia.x(), b.inertia.y(), b.inertia.z(), 0, 0, 0);
      dBodySetMass(id, &m);
      const state& at = b.start;
      const dQuaternion q{at.orientation.w(), at.orientation.x(), at.orientation.y(),
                          at.orientation.z()};
      dBodySetPosition(id, at.position.x(), at.position.y(), at.position.z());
      dBodySetQuaternion(id, q);
      dBodySetLinearVel(id, at.velocity.x(), at.velocity.y(), at.velocity.z());
      dBodySetAngularVel(id, at.spin.x(), at.spin.y(), at.spin.z());
      bodies_.push_back(id);
    }
    for (const joint& j : s.joints) {
      const dBodyID a = j.a == ground ? nullptr : bodies_[j.a], b = bodies_[j.b];
      if (j.type == kind::ball) {
        const dJointID id = dJointCreateBall(world_, nullptr);
        dJointAttach(id, a, b);
        dJointSetBallAnchor(id, j.at.x(), j.at.y(), j.at.z());
      } else if (j.type == kind::hinge) {
        const dJointID id = dJointCreateHinge(world_, nullptr);
        dJointAttach(id, a, b);
        dJointSetHingeAnchor(id, j.at.x(), j.at.y(), j.at.z());
        dJointSetHingeAxis(id, j.axis.x(), j.axis.y(), j.axis.z());
      } else {
        const dJointID id = dJointCreateSlider(world_, nullptr);
        dJointAttach(id, a, b);
        dJointSetSliderAxis(id, j.axis.x(), j.axis.y(), j.axis.z());
      }
    }
  }
  ~ode_joints() { dWorldDestroy(world_); }

  void advance(long steps) {
    for (long i = 0; i < steps; ++i) {
      forces();
      if (quick_)
        dWorldQuickStep(world_, dt_);
      else
        dWorldStep(world_, dt_);
    }
    read();
  }

  const std::vector<state>& states() const { return now_; }

 private:
  void read() {
    for (std::size_t i = 0; i < now_.size(); ++i) {
      const dReal *p = dBodyGetPosition(bodies_[i]), *q = dBodyGetQuaternion(bodies_[i]),
                  *v = dBodyGetLinearVel(bodies_[i]), *w = dBodyGetAngularVel(bodies_[i]);
      now_[i] = {
          {p[0], p[1], p[2]}, {q[0], q[1], q[2], q[3]}, {v[0], v[1], v[2]}, {w[0], w[1], w[2]}};
    }
  }

  // Forces of springs are explicit: ODE has no spring between two points.
  void forces() {
    if (!s_.springs.empty()) read();
    for (const spring& k : s_.springs) {
      const vec f = spring_force(s_, now_, k);
      const vec pa = moved_point(s_, now_, k.a, k.at_a), pb = moved_point(s_, now_, k.b, k.at_b);
      dBodyAddForceAtPos(bodies_[k.b], f.x(), f.y(), f.z(), pb.x(), pb.y(), pb.z());
      if (k.a != ground)
        dBodyAddForceAtPos(bodies_[k.a], -f.x(), -f.y(), -f.z(), pa.x(), pa.y(), pa.z());
    }
    for (const drive& d : s_.drives)
      dBodyAddTorque(bodies_[d.on], d.torque.x(), d.torque.y(), d.torque.z());
  }

  scene s_;
  std::vector<state> now_;
  std::vector<dBodyID> bodies_;
  dWorldID world_;
  double dt_;
  bool quick_;
};

}  // namespace

int main(int argc, char** argv) { return bench::joints::run<ode_joints>(argc, argv); }
