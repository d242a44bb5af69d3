#pragma once
// The Open Dynamics Engine behind the protocol, as its manual advises for many bodies: QuickStep,
// hash space, friction proportional to the normal force, soft defaults, sleeping off.
#include <ode/ode.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <utility>
#include <vector>

#include "checker.hpp"
#include "report.hpp"

namespace bench {

class ode_engine {
 public:
  explicit ode_engine(const scene& s, int iterations = 0) : scene_(s) {
    dInitODE2(0);
    world_ = dWorldCreate();
    space_ = dHashSpaceCreate(nullptr);
    joints_ = dJointGroupCreate(0);
    dWorldSetGravity(world_, 0, 0, s.gravity);
    if (iterations > 0) dWorldSetQuickStepNumIterations(world_, iterations);
    for (const ball& b : s.balls) {
      const dGeomID geom = number(dCreateSphere(space_, b.radius));
      const dBodyID body = dBodyCreate(world_);
      dMass mass;
      dMassSetSphere(&mass, s.density, b.radius);
      dBodySetMass(body, &mass);
      dBodySetPosition(body, b.position[0], b.position[1], b.position[2]);
      dBodySetLinearVel(body, b.velocity[0], b.velocity[1], b.velocity[2]);
      dBodySetAngularVel(body, b.spin[0], b.spin[1], b.spin[2]);
      dBodySetAutoDisableFlag(body, 0);
      dGeomSetBody(geom, body);
      bodies_.push_back(body);
    }
    for (const wall& w : s.walls)
      fix(number(dCreatePlane(space_, w.normal[0], w.normal[1], w.normal[2], w.offset)));
    for (const block& b : s.blocks) {
      const dGeomID geom = number(dCreateBox(space_, b.size[0], b.size[1], b.size[2]));
      dGeomSetPosition(geom, b.centre[0], b.centre[1], b.centre[2]);
      const dQuaternion q = {b.orientation[0], b.orientation[1], b.orientation[2],
                             b.orientation[3]};
      dGeomSetQuaternion(geom, q);
      fix(geom);
    }
    for (const crate& c : s.crates) {
      const dGeomID geom = number(dCreateBox(space_, c.size[0], c.size[1], c.size[2]));
      const dBodyID body = dBodyCreate(world_);
      dMass mass;
      dMassSetBox(&mass, c.density, c.size[0], c.size[1], c.size[2]);
      dBodySetMass(body, &mass);
      dBodySetPosition(body, c.centre[0], c.centre[1], c.centre[2]);
      const dQuaternion q = {c.orientation[0], c.orientation[1], c.orientation[2],
                             c.orientation[3]};
      dBodySetQuaternion(body, q);
      dBodySetLinearVel(body, c.velocity[0], c.velocity[1], c.velocity[2]);
      dBodySetAngularVel(body, c.spin[0], c.spin[1], c.spin[2]);
      dBodySetAutoDisableFlag(body, 0);
      dGeomSetBody(geom, body);
      crates_.push_back(body);
    }
  }

  ~ode_engine() {
    dJointGroupDestroy(joints_);
    dSpaceDestroy(space_);
    dWorldDestroy(world_);
    dCloseODE();
  }
  ode_engine(const ode_engine&) = delete;
  ode_engine& operator=(const ode_engine&) = delete;

  void step() {
    dJointGroupEmpty(joints_);
    contacts_ = 0;
    dSpaceCollide(space_, this, [](void* self, dGeomID a, dGeomID b) {
      static_cast<ode_engine*>(self)->touch(a, b);
    });
    dWorldQuickStep(world_, scene_.dt);
  }

  /// A force on a crate in the next step.
  void push(std::size_t crate, const vec& force) {
    dBodyAddForce(crates_[crate], force[0], force[1], force[2]);
  }
  void watch_loads() { watch_ = true; }

  [[nodiscard]] std::vector<ball> balls() const {
    std::vector<ball> out(bodies_.size());
    const auto plain = [](const dReal* v) { return vec{v[0], v[1], v[2]}; };
    for (std::size_t i = 0; i < out.size(); ++i)
      out[i] = {plain(dBodyGetPosition(bodies_[i])), scene_.balls[i].radius,
                plain(dBodyGetLinearVel(bodies_[i])), plain(dBodyGetAngularVel(bodies_[i]))};
    return out;
  }

  [[nodiscard]] std::vector<crate> crates() const {
    std::vector<crate> out = scene_.crates;
    const auto plain = [](const dReal* v) { return vec{v[0], v[1], v[2]}; };
    for (std::size_t i = 0; i < out.size(); ++i) {
      const dReal* q = dBodyGetQuaternion(crates_[i]);
      out[i].centre = plain(dBodyGetPosition(crates_[i]));
      out[i].orientation = {q[0], q[1], q[2], q[3]};
      out[i].velocity = plain(dBodyGetLinearVel(crates_[i]));
      out[i].spin = plain(dBodyGetAngularVel(crates_[i]));
    }
    return out;
  }

  [[nodiscard]] std::size_t contacts() const { return contacts_; }

  [[nodiscard]] std::vector<loaded_pair> loaded() const {
    std::vector<loaded_pair> out;
    const auto balls = scene_.balls.size(), walls = scene_.walls.size();
    for (const auto& [a, b, feedback] : loads_) {
      const dReal* f = feedback.f1;
      if (f[0] * f[0] + f[1] * f[1] + f[2] * f[2] <= 0) continue;
      out.push_back(b < balls           ? loaded_pair{a, partner::ball, b}
                    : b < balls + walls ? loaded_pair{a, partner::wall, b - balls}
                                        : loaded_pair{a, partner::block, b - balls - walls});
    }
    return out;
  }

  [[nodiscard]] int iterations() const { return dWorldGetQuickStepNumIterations(world_); }

  void describe(record& out) const {
    out.add("precision", sizeof(dReal) == sizeof(float) ? "float" : "double");
    out.add("erp", dWorldGetERP(world_));
    out.add("cfm", dWorldGetCFM(world_));
    out.add("sor", dWorldGetQuickStepW(world_));
    out.add("settings",
            "dWorldQuickStep, dHashSpace, dContactApprox1 (friction pyramid scaled by the normal "
            "force), defaults, no sleeping");
  }

  static std::string name() { return "ode"; }

 private:
  struct load {
    std::size_t a, b;
    dJointFeedback feedback;
  };

  dGeomID number(dGeomID geom) {
    dGeomSetData(geom, reinterpret_cast<void*>(static_cast<std::uintptr_t>(numbered_++)));
    return geom;
  }

  static void fix(dGeomID geom) {  // fixed things do not meet each other
    dGeomSetCategoryBits(geom, 2);
    dGeomSetCollideBits(geom, 1);
  }

  void touch(dGeomID first, dGeomID second) {
    // One point where a sphere is involved; all that ODE offers between boxes and planes.
    const bool round =
        dGeomGetClass(first) == dSphereClass || dGeomGetClass(second) == dSphereClass;
    dContact contacts[8];  // of the surface ODE reads what the mode names
    const int count = dCollide(first, second, round ? 1 : 8, &contacts[0].geom, sizeof contacts[0]);
    for (int i = 0; i < count; ++i) touch_at(first, second, contacts[i]);
  }

  void touch_at(dGeomID first, dGeomID second, dContact& contact) {
    const bool free = dGeomGetBody(first) && dGeomGetBody(second);
    const pair_law& law = free ? scene_.between_balls : scene_.against_fixed;
    contact.surface.mode = dContactApprox1;
    contact.surface.mu = law.friction;
    if (law.restitution > 0) {
      contact.surface.mode |= dContactBounce;
      contact.surface.bounce = law.restitution;
      contact.surface.bounce_vel = 0.2;  // no default in ODE; Bullet's value
    }
    const dJointID joint = dJointCreateContact(world_, joints_, &contact);
    dJointAttach(joint, dGeomGetBody(first), dGeomGetBody(second));
    ++contacts_;
    if (!watch_) return;
    auto a = reinterpret_cast<std::uintptr_t>(dGeomGetData(first));
    auto b = reinterpret_cast<std::uintptr_t>(dGeomGetData(second));
    if (a > b) std::swap(a, b);
    loads_.push_back({a, b, {}});
    dJointSetFeedback(joint, &loads_.back().feedback);
  }

  scene scene_;
  dWorldID world_{};
  dSpaceID space_{};
  dJointGroupID joints_{};
  std::vector<dBodyID> bodies_, crates_;
  std::deque<load> loads_;  // joints keep pointers into it
  std::size_t contacts_ = 0, numbered_ = 0;
  bool watch_ = false;
};

}  // namespace bench
