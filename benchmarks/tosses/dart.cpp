// DART: a box on a box, because its own detector has no planes; pyramid of friction, and its
// defaults. It gives a rebound from 0.1 m/s on only, a constant of its library.
#include <dart/collision/dart/DARTCollisionDetector.hpp>
#include <dart/constraint/ConstraintSolver.hpp>
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/BoxShape.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/dynamics/WeldJoint.hpp>
#include <dart/simulation/World.hpp>

#include "runner.hpp"

namespace {

using namespace bench::tosses;
using namespace dart::dynamics;

class dart_toss {
 public:
  static constexpr const char* name = "dart";

  dart_toss(const settings& how, const state& at) {
    world_->setGravity(vec(0, 0, -gravity));
    world_->setTimeStep(how.dt);
    world_->getConstraintSolver()->setCollisionDetector(
        dart::collision::DARTCollisionDetector::create());

    // Of two bodies the smaller coefficient of friction counts, and the product of restitutions.
    const double edge = 2 * half_edge, wide = 400 * half_edge;
    const auto floor = Skeleton::create("floor"), cube = Skeleton::create("cube");
    BodyNode* under = floor->createJointAndBodyNodePair<WeldJoint>().second;
    shape(*under, vec(wide, wide, edge), how.friction, 1)
        .setRelativeTranslation(vec(0, 0, -half_edge));
    cube_ = cube->createJointAndBodyNodePair<FreeJoint>().second;
    shape(*cube_, vec(edge, edge, edge), how.friction, how.restitution);
    cube_->setInertia(Inertia(mass, vec::Zero(), inertia * Eigen::Matrix3d::Identity()));
    world_->addSkeleton(floor);
    world_->addSkeleton(cube);

    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() = at.position;
    pose.linear() = at.orientation.toRotationMatrix();
    auto* joint = static_cast<FreeJoint*>(cube_->getParentJoint());
    joint->setTransform(pose);
    joint->setLinearVelocity(at.velocity);
    joint->setAngularVelocity(at.spin);
  }

  void step() { world_->step(); }
  [[nodiscard]] state now() const {
    const Eigen::Isometry3d& at = cube_->getWorldTransform();
    return {at.translation(), turn(at.linear()), cube_->getLinearVelocity(),
            cube_->getAngularVelocity()};
  }

 private:
  static ShapeNode& shape(BodyNode& on, const vec& size, double friction, double restitution) {
    ShapeNode* node =
        on.createShapeNodeWith<CollisionAspect, DynamicsAspect>(std::make_shared<BoxShape>(size));
    node->getDynamicsAspect()->setFrictionCoeff(friction);
    node->getDynamicsAspect()->setRestitutionCoeff(restitution);
    return *node;
  }

  dart::simulation::WorldPtr world_ = dart::simulation::World::create();
  BodyNode* cube_ = nullptr;
};

}  // namespace

int main(int argc, char** argv) { return bench::tosses::run<dart_toss>(argc, argv); }
