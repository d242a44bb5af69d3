// Bullet in double precision: rigid bodies with constraints, solved by 50 or 1,000 iterations
// of sequential impulses, with the error reduction of its default.
#include <btBulletDynamicsCommon.h>

#include <deque>
#include <memory>

#include "runner.hpp"

namespace {

using namespace bench::joints;

btVector3 to(const vec& v) { return {v.x(), v.y(), v.z()}; }
vec from(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

class bullet_joints {
 public:
  static constexpr const char* name = "bullet";
  static std::vector<plan> plans() {
    std::vector<plan> list;
    for (const char* integrator : {"sequential_impulses_50", "sequential_impulses_1000"}) {
      list.push_back({"A01", integrator, {1e-2, 1e-3, 1e-4}, {1e-2, 1e-3}});
      list.push_back({"A02_", integrator, {1e-2, 1e-3}, {1e-2}});
      list.push_back({"A03", integrator, {1e-4, 1e-5, 1e-6}, {1e-4, 1e-5}});
      list.push_back({"A04", integrator, {1e-2, 1e-3}, {1e-2}});
      list.push_back({"chain_", integrator, {1e-3}, {1e-2}});
    }
    list.push_back({"A05", "sequential_impulses_50", {1e-4, 1e-5}, {1e-4}});
    list.push_back({"grid_", "sequential_impulses_50", {1e-2}, {1e-2}});
    return list;
  }
  static std::vector<std::string> notes() { return {}; }

  bullet_joints(const scene& s, const std::string& integrator, double dt)
      : s_(s), now_(start_of(s)), dt_(dt) {
    world_.setGravity(to(s.gravity));
    world_.getSolverInfo().m_numIterations =
        std::stoi(integrator.substr(integrator.rfind('_') + 1));
    for (const body& b : s.bodies) {
      const state& at = b.start;
      const btTransform pose(
          {at.orientation.x(), at.orientation.y(), at.orientation.z(), at.orientation.w()},
          to(at.position));
      states_.emplace_back(pose);
      bodies_.push_back(std::make_unique<btRigidBody>(btRigidBody::btRigidBodyConstructionInfo(
          b.mass, &states_.back(), &shape_, to(b.inertia))));
      btRigidBody& body = *bodies_.back();
      body.setLinearVelocity(to(at.velocity));
      body.setAngularVelocity(to(at.spin));
      body.setActivationState(DISABLE_DEACTIVATION);
      world_.addRigidBody(&body, 0, 0);  // without collisions
    }
    for (const joint& j : s.joints) {
      btRigidBody& b = *bodies_[j.b];
      btRigidBody& a = j.a == ground ? btTypedConstraint::getFixedBody() : *bodies_[j.a];
      const auto place = [&](const btRigidBody& body, bool is_ground) {
        // z along the axis of a hinge, x along that of a slider
        const vec first = j.type == kind::slider ? vec::UnitX() : vec::UnitZ();
        const turn q = turn::FromTwoVectors(first, j.axis);
        const btTransform frame({q.x(), q.y(), q.z(), q.w()}, to(j.at));
        return is_ground ? frame : body.getWorldTransform().inverse() * frame;
      };
      const btTransform in_a = place(a, j.a == ground), in_b = place(b, false);
      if (j.type == kind::ball)
        joints_.push_back(
            std::make_unique<btPoint2PointConstraint>(a, b, in_a.getOrigin(), in_b.getOrigin()));
      else if (j.type == kind::hinge)
        joints_.push_back(std::make_unique<btHingeConstraint>(a, b, in_a, in_b));
      else {
        auto slider = std::make_unique<btSliderConstraint>(a, b, in_a, in_b, true);
        slider->setLowerLinLimit(1);  // lower above upper: free
        slider->setUpperLinLimit(-1);
        joints_.push_back(std::move(slider));
      }
      world_.addConstraint(joints_.back().get(), true);
    }
  }
  ~bullet_joints() {
    for (auto& j : joints_) world_.removeConstraint(j.get());
    for (auto& b : bodies_) world_.removeRigidBody(b.get());
  }

  void advance(long steps) {
    for (long i = 0; i < steps; ++i) {
      forces();
      world_.stepSimulation(dt_, 0);
    }
    read();
  }

  const std::vector<state>& states() const { return now_; }

 private:
  void read() {
    for (std::size_t i = 0; i < now_.size(); ++i) {
      const btRigidBody& b = *bodies_[i];
      const btQuaternion q = b.getOrientation();
      now_[i] = {from(b.getCenterOfMassPosition()), turn(q.w(), q.x(), q.y(), q.z()),
                 from(b.getLinearVelocity()), from(b.getAngularVelocity())};
    }
  }

  // Forces of springs are explicit: Bullet has no spring between two points.
  void forces() {
    if (!s_.springs.empty()) read();
    for (const spring& k : s_.springs) {
      const vec f = spring_force(s_, now_, k);
      bodies_[k.b]->applyForce(to(f), to(moved_point(s_, now_, k.b, k.at_b) - now_[k.b].position));
      if (k.a != ground)
        bodies_[k.a]->applyForce(to(-f),
                                 to(moved_point(s_, now_, k.a, k.at_a) - now_[k.a].position));
    }
    for (const drive& d : s_.drives) bodies_[d.on]->applyTorque(to(d.torque));
  }

  scene s_;
  std::vector<state> now_;
  double dt_;
  btDefaultCollisionConfiguration settings_;
  btCollisionDispatcher dispatcher_{&settings_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &settings_};
  btSphereShape shape_{0.01};
  std::deque<btDefaultMotionState> states_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<std::unique_ptr<btTypedConstraint>> joints_;
};

}  // namespace

int main(int argc, char** argv) { return bench::joints::run<bullet_joints>(argc, argv); }
