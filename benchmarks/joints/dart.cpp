// DART: joint coordinates (Featherstone), semi-implicit Euler. Loops are closed by ball-joint
// constraints, two for a hinge that is not of a plane mechanism. Springs are explicit.
#include <dart/constraint/BallJointConstraint.hpp>
#include <dart/constraint/ConstraintSolver.hpp>
#include <dart/dynamics/BallJoint.hpp>
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/PrismaticJoint.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/simulation/World.hpp>
#include <memory>
#include <stdexcept>

#include "runner.hpp"
#include "tree.hpp"

namespace {

using namespace bench::joints;

class dart_joints {
 public:
  static constexpr const char* name = "dart";
  static std::vector<plan> plans() {
    return {{"A01", "semi_implicit_euler", {1e-2, 1e-3, 1e-4}, {1e-2, 1e-3}},
            {"A02_2", "semi_implicit_euler", {1e-2, 1e-3}, {1e-2}},
            {"A02_10", "semi_implicit_euler", {1e-2, 1e-3}, {1e-2}},
            {"A02_40", "semi_implicit_euler", {1e-2}, {}},
            {"A03", "semi_implicit_euler", {1e-4, 1e-5, 1e-6}, {1e-4, 1e-5}},
            {"A04", "semi_implicit_euler", {1e-2, 1e-3, 1e-4}, {1e-2, 1e-3}},
            {"A05", "semi_implicit_euler", {1e-4, 1e-5}, {1e-4}},
            {"chain_", "semi_implicit_euler", {1e-3}, {1e-2}}};
  }
  static std::vector<std::string> notes() {
    return {"grid: the dense matrix of 29,403 loop rows is too large"};
  }

  dart_joints(const scene& s, const std::string& integrator, double dt)
      : s_(s), now_(start_of(s)), nodes_(s.bodies.size()) {
    if (integrator != "semi_implicit_euler")
      throw std::invalid_argument("there is no integrator '" + integrator + "'");
    world_->setGravity(s.gravity);
    world_->setTimeStep(dt);
    const tree t = tree_of(s);
    const auto skeleton = dart::dynamics::Skeleton::create("mechanism");
    for (const int i : t.order) add(*skeleton, t, i);
    world_->addSkeleton(skeleton);
    for (const int i : t.order) start(s.joints[t.joint_of[i]], t.parent_of[i], i);
    for (const int i : t.loops) close(s.joints[i]);
  }

  void advance(long steps) {
    for (long i = 0; i < steps; ++i) {
      forces();
      world_->step();
    }
    read();
  }

  const std::vector<state>& states() const { return now_; }

 private:
  using transform = Eigen::Isometry3d;

  /// The frame of a joint in a body, or in the world; z along the axis.
  transform frame(const joint& j, int i) const {
    transform at = transform::Identity();
    at.translation() = j.at;
    at.linear() = turn::FromTwoVectors(vec::UnitZ(), j.axis).toRotationMatrix();
    return i == ground ? at : transform(pose(i).inverse() * at);
  }
  transform pose(int i) const {
    transform at = transform::Identity();
    at.translation() = s_.bodies[i].start.position;
    at.linear() = s_.bodies[i].start.orientation.toRotationMatrix();
    return at;
  }

  void add(dart::dynamics::Skeleton& skeleton, const tree& t, int i) {
    using namespace dart::dynamics;
    const body& b = s_.bodies[i];
    const joint& j = s_.joints[t.joint_of[i]];
    const int parent = t.parent_of[i];
    BodyNode* on = parent == ground ? nullptr : nodes_[parent];
    const auto make = [&](auto properties) {
      properties.mName = "joint" + std::to_string(i);
      properties.mT_ParentBodyToJoint = frame(j, parent);
      properties.mT_ChildBodyToJoint = frame(j, i);
      return properties;
    };
    if (j.type == kind::ball) {
      const auto p = make(BallJoint::Properties());
      nodes_[i] = skeleton.createJointAndBodyNodePair<BallJoint>(on, p).second;
    } else if (j.type == kind::hinge) {
      auto p = make(RevoluteJoint::Properties());
      p.mAxis = vec::UnitZ();
      nodes_[i] = skeleton.createJointAndBodyNodePair<RevoluteJoint>(on, p).second;
    } else {
      auto p = make(PrismaticJoint::Properties());
      p.mAxis = vec::UnitZ();
      nodes_[i] = skeleton.createJointAndBodyNodePair<PrismaticJoint>(on, p).second;
    }
    nodes_[i]->setInertia(Inertia(b.mass, vec::Zero(), b.inertia.asDiagonal()));
  }

  /// The first rate of the joint of a body.
  void start(const joint& j, int parent, int i) {
    const auto at = [&](int of) -> std::pair<vec, vec> {
      if (of == ground) return {vec::Zero(), vec::Zero()};
      const state& b = s_.bodies[of].start;
      return {b.spin, b.velocity + b.spin.cross(j.at - b.position)};
    };
    const auto [wa, va] = at(parent);
    const auto [wb, vb] = at(i);
    const turn back = turn::FromTwoVectors(vec::UnitZ(), j.axis).conjugate();
    const vec w = back * (wb - wa), v = back * (vb - va);
    auto* own = nodes_[i]->getParentJoint();
    if (j.type == kind::ball)
      own->setVelocities(w);
    else
      own->setVelocity(0, j.type == kind::hinge ? w.z() : v.z());
  }

  void close(const joint& j) {
    using dart::constraint::BallJointConstraint;
    const auto at = [&](const vec& point) {
      auto* solver = world_->getConstraintSolver();
      if (j.a == ground)
        solver->addConstraint(std::make_shared<BallJointConstraint>(nodes_[j.b], point));
      else
        solver->addConstraint(
            std::make_shared<BallJointConstraint>(nodes_[j.a], nodes_[j.b], point));
    };
    if (s_.name == "A04") {  // two points of the axis; in plane mechanisms one is enough
      at(j.at + j.axis / 2);
      at(j.at - j.axis / 2);
    } else
      at(j.at);
  }

  void forces() {
    if (!s_.springs.empty()) read();
    for (const spring& k : s_.springs) {
      const vec f = spring_force(s_, now_, k);
      nodes_[k.b]->addExtForce(f, moved_point(s_, now_, k.b, k.at_b), false, false);
      if (k.a != ground)
        nodes_[k.a]->addExtForce(-f, moved_point(s_, now_, k.a, k.at_a), false, false);
    }
    for (const drive& d : s_.drives) nodes_[d.on]->addExtTorque(d.torque, false);
  }

  void read() {
    for (std::size_t i = 0; i < now_.size(); ++i) {
      const transform& at = nodes_[i]->getWorldTransform();
      now_[i] = {at.translation(), turn(at.linear()), nodes_[i]->getLinearVelocity(),
                 nodes_[i]->getAngularVelocity()};
    }
  }

  scene s_;
  std::vector<state> now_;
  std::vector<dart::dynamics::BodyNode*> nodes_;
  dart::simulation::WorldPtr world_ = dart::simulation::World::create();
};

}  // namespace

int main(int argc, char** argv) { return bench::joints::run<dart_joints>(argc, argv); }
