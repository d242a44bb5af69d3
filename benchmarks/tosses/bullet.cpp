// Bullet in double precision: a box on a plane, sequential impulses and its defaults. Restitution
// acts at all speeds, as in the other engines, not from 0.2 m/s on.
#include <btBulletDynamicsCommon.h>

#include "runner.hpp"

namespace {

using namespace bench::tosses;

btVector3 to(const vec& v) { return {v.x(), v.y(), v.z()}; }
vec from(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

class bullet_toss {
 public:
  static constexpr const char* name = "bullet";

  bullet_toss(const settings& how, const state& at) : dt_(how.dt) {
    world_.setGravity({0, 0, -gravity});
    world_.getSolverInfo().m_restitutionVelocityThreshold = 0;
    const turn& q = at.orientation;
    cube_.setCenterOfMassTransform(
        btTransform(btQuaternion(q.x(), q.y(), q.z(), q.w()), to(at.position)));
    cube_.setInterpolationWorldTransform(cube_.getWorldTransform());
    cube_.setLinearVelocity(to(at.velocity));
    cube_.setAngularVelocity(to(at.spin));
    cube_.setActivationState(DISABLE_DEACTIVATION);
    // Coefficients of the two bodies are multiplied.
    cube_.setFriction(how.friction);
    cube_.setRestitution(how.restitution);
    floor_.setFriction(1);
    floor_.setRestitution(1);
    world_.addRigidBody(&floor_);
    world_.addRigidBody(&cube_);
  }
  ~bullet_toss() {
    world_.removeRigidBody(&cube_);
    world_.removeRigidBody(&floor_);
  }

  void step() { world_.stepSimulation(dt_, 0); }
  [[nodiscard]] state now() const {
    const btQuaternion q = cube_.getWorldTransform().getRotation();
    return {from(cube_.getCenterOfMassPosition()), turn(q.w(), q.x(), q.y(), q.z()),
            from(cube_.getLinearVelocity()), from(cube_.getAngularVelocity())};
  }

 private:
  double dt_;
  btDefaultCollisionConfiguration settings_;
  btCollisionDispatcher dispatcher_{&settings_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &settings_};
  btBoxShape box_{btVector3(half_edge, half_edge, half_edge)};
  btStaticPlaneShape plane_{btVector3(0, 0, 1), 0};
  btRigidBody cube_{mass, nullptr, &box_, btVector3(inertia, inertia, inertia)};
  btRigidBody floor_{0, nullptr, &plane_};
};

}  // namespace

int main(int argc, char** argv) { return bench::tosses::run<bullet_toss>(argc, argv); }
