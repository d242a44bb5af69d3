// Open Dynamics Engine: a box on a plane, the big-matrix step (dWorldStep), friction proportional
// to the normal force. Error reduction and constraint force mixing are those of its manual.
#include <ode/ode.h>

#include "runner.hpp"

namespace {

using namespace bench::tosses;

class ode_toss {
 public:
  static constexpr const char* name = "ode";

  ode_toss(const settings& how, const state& at) : how_(how) {
    static const bool ready = dInitODE2(0) != 0;
    if (!ready) throw std::runtime_error("ODE does not start");
    world_ = dWorldCreate();
    joints_ = dJointGroupCreate(0);
    dWorldSetGravity(world_, 0, 0, -gravity);
    dWorldSetERP(world_, 0.2);
    dWorldSetCFM(world_, 1e-10);
    floor_ = dCreatePlane(nullptr, 0, 0, 1, 0);
    box_ = dCreateBox(nullptr, 2 * half_edge, 2 * half_edge, 2 * half_edge);
    cube_ = dBodyCreate(world_);
    dMass m;
    dMassSetParameters(&m, mass, 0, 0, 0, inertia, inertia, inertia, 0, 0, 0);
    dBodySetMass(cube_, &m);
    const turn& o = at.orientation;
    const dQuaternion q{o.w(), o.x(), o.y(), o.z()};
    dBodySetPosition(cube_, at.position.x(), at.position.y(), at.position.z());
    dBodySetQuaternion(cube_, q);
    dBodySetLinearVel(cube_, at.velocity.x(), at.velocity.y(), at.velocity.z());
    dBodySetAngularVel(cube_, at.spin.x(), at.spin.y(), at.spin.z());
    dGeomSetBody(box_, cube_);
  }
  ~ode_toss() {
    dJointGroupDestroy(joints_);
    dGeomDestroy(box_);
    dGeomDestroy(floor_);
    dWorldDestroy(world_);
  }
  ode_toss(const ode_toss&) = delete;
  ode_toss& operator=(const ode_toss&) = delete;

  void step() {
    dContact contacts[8] = {};
    const int n = dCollide(box_, floor_, 8, &contacts[0].geom, sizeof(dContact));
    for (int i = 0; i < n; ++i) {
      dSurfaceParameters& surface = contacts[i].surface;
      surface.mode = dContactApprox1 | dContactBounce;
      surface.mu = how_.friction;
      surface.bounce = how_.restitution;
      surface.bounce_vel = 0;
      dJointAttach(dJointCreateContact(world_, joints_, &contacts[i]), cube_, nullptr);
    }
    dWorldStep(world_, how_.dt);
    dJointGroupEmpty(joints_);
  }
  [[nodiscard]] state now() const {
    const dReal *p = dBodyGetPosition(cube_), *q = dBodyGetQuaternion(cube_),
                *v = dBodyGetLinearVel(cube_), *w = dBodyGetAngularVel(cube_);
    return {{p[0], p[1], p[2]}, {q[0], q[1], q[2], q[3]}, {v[0], v[1], v[2]}, {w[0], w[1], w[2]}};
  }

 private:
  settings how_;
  dWorldID world_ = nullptr;
  dJointGroupID joints_ = nullptr;
  dGeomID floor_ = nullptr;
  dGeomID box_ = nullptr;
  dBodyID cube_ = nullptr;
};

}  // namespace

int main(int argc, char** argv) { return bench::tosses::run<ode_toss>(argc, argv); }
