#pragma once
// Bullet behind the protocol, as its manual and examples set up a rigid world: dynamic AABB tree,
// sequential impulse solver and its defaults, one variable step per call, sleeping off.
#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "checker.hpp"
#include "report.hpp"

namespace bench {

class bullet_engine {
 public:
  explicit bullet_engine(const scene& s, int iterations = 0)
      : scene_(s),
        construction_(pools(s.balls.size() + s.crates.size())),
        configuration_(construction_) {
    if (iterations > 0) world_.getSolverInfo().m_numIterations = iterations;
    world_.setGravity(btVector3(0, 0, btScalar(s.gravity)));
    // Bullet multiplies the coefficients of two bodies: choose the two factors so that the products
    // are the scene's pair coefficients.
    const auto factors = [](double between, double fixed) {
      const double ball = std::sqrt(between);
      return pair_law{ball, ball > 0 ? fixed / ball : 0};
    };
    const auto friction = factors(s.between_balls.friction, s.against_fixed.friction);
    const auto restitution = factors(s.between_balls.restitution, s.against_fixed.restitution);
    const pair_law ball_law{friction.friction, restitution.friction};
    const pair_law fixed_law{friction.restitution, restitution.restitution};

    bodies_.reserve(s.balls.size() + s.walls.size() + s.blocks.size() + s.crates.size());
    const btQuaternion upright(0, 0, 0, 1);
    for (const ball& b : s.balls) {
      auto* body = add(std::make_unique<btSphereShape>(btScalar(b.radius)),
                       s.density * 4 / 3 * std::acos(-1.0) * std::pow(b.radius, 3),
                       vector(b.position), upright, ball_law);
      body->setLinearVelocity(vector(b.velocity));
      body->setAngularVelocity(vector(b.spin));
      body->setActivationState(DISABLE_DEACTIVATION);
    }
    for (const wall& w : s.walls)
      add(std::make_unique<btStaticPlaneShape>(vector(w.normal), btScalar(w.offset)), 0,
          btVector3(0, 0, 0), upright, fixed_law);
    for (const block& b : s.blocks) {
      const auto [w, x, y, z] = b.orientation;
      add(std::make_unique<btBoxShape>(vector(b.size) * btScalar(0.5)), 0, vector(b.centre),
          btQuaternion(btScalar(x), btScalar(y), btScalar(z), btScalar(w)), fixed_law);
    }
    for (const crate& c : s.crates) {
      const auto [w, x, y, z] = c.orientation;
      auto* body = add(std::make_unique<btBoxShape>(vector(c.size) * btScalar(0.5)),
                       c.density * c.size[0] * c.size[1] * c.size[2], vector(c.centre),
                       btQuaternion(btScalar(x), btScalar(y), btScalar(z), btScalar(w)), ball_law);
      body->setLinearVelocity(vector(c.velocity));
      body->setAngularVelocity(vector(c.spin));
      body->setActivationState(DISABLE_DEACTIVATION);
    }
  }

  ~bullet_engine() {
    for (auto& body : bodies_) world_.removeRigidBody(body.get());
  }
  bullet_engine(const bullet_engine&) = delete;
  bullet_engine& operator=(const bullet_engine&) = delete;

  void step() { world_.stepSimulation(btScalar(scene_.dt), 0); }
  /// A force on a crate in the next step.
  void push(std::size_t crate, const vec& force) {
    bodies_[bodies_.size() - scene_.crates.size() + crate]->applyCentralForce(vector(force));
  }
  void watch_loads() {}

  [[nodiscard]] std::vector<ball> balls() const {
    std::vector<ball> out(scene_.balls.size());
    for (std::size_t i = 0; i < out.size(); ++i) {
      const btRigidBody& body = *bodies_[i];
      out[i] = {plain(body.getCenterOfMassPosition()), scene_.balls[i].radius,
                plain(body.getLinearVelocity()), plain(body.getAngularVelocity())};
    }
    return out;
  }

  [[nodiscard]] std::vector<crate> crates() const {
    std::vector<crate> out = scene_.crates;
    const auto first = bodies_.size() - out.size();
    for (std::size_t i = 0; i < out.size(); ++i) {
      const btRigidBody& body = *bodies_[first + i];
      const btQuaternion q = body.getWorldTransform().getRotation();
      out[i].centre = plain(body.getCenterOfMassPosition());
      out[i].orientation = {q.w(), q.x(), q.y(), q.z()};
      out[i].velocity = plain(body.getLinearVelocity());
      out[i].spin = plain(body.getAngularVelocity());
    }
    return out;
  }

  [[nodiscard]] std::size_t contacts() const {
    std::size_t sum = 0;
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i)
      sum += static_cast<std::size_t>(dispatcher_.getManifoldByIndexInternal(i)->getNumContacts());
    return sum;
  }

  [[nodiscard]] std::vector<loaded_pair> loaded() const {
    std::vector<loaded_pair> out;
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i) {
      const auto* manifold = dispatcher_.getManifoldByIndexInternal(i);
      bool loaded = false;
      for (int k = 0; k < manifold->getNumContacts(); ++k)
        loaded = loaded || manifold->getContactPoint(k).getAppliedImpulse() > 0;
      if (!loaded) continue;
      auto a = static_cast<std::size_t>(manifold->getBody0()->getUserIndex());
      auto b = static_cast<std::size_t>(manifold->getBody1()->getUserIndex());
      if (a > b) std::swap(a, b);  // balls have the lowest numbers, then walls, then blocks
      const auto balls = scene_.balls.size(), walls = scene_.walls.size();
      out.push_back(b < balls           ? loaded_pair{a, partner::ball, b}
                    : b < balls + walls ? loaded_pair{a, partner::wall, b - balls}
                                        : loaded_pair{a, partner::block, b - balls - walls});
    }
    return out;
  }

  [[nodiscard]] int iterations() const {
    return const_cast<btDiscreteDynamicsWorld&>(world_).getSolverInfo().m_numIterations;
  }

  void describe(record& out) const {
    out.add("precision", sizeof(btScalar) == sizeof(float) ? "float" : "double");
    out.add("version",
            std::to_string(btGetVersion() / 100) + "." + std::to_string(btGetVersion() % 100));
    out.add(
        "settings",
        "btDbvtBroadphase, btSequentialImpulseConstraintSolver, stepSimulation(dt, 0), defaults "
        "(warm start 0.85, split impulse, erp2 0.2), no sleeping, planes as btStaticPlaneShape");
  }

  static std::string name() { return sizeof(btScalar) == sizeof(float) ? "bullet" : "bullet64"; }

 private:
  static btVector3 vector(const vec& v) { return {btScalar(v[0]), btScalar(v[1]), btScalar(v[2])}; }
  static vec plain(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

  // Room in the pools for every pair near contact: beyond them Bullet falls back on malloc.
  static btDefaultCollisionConstructionInfo pools(std::size_t bodies) {
    btDefaultCollisionConstructionInfo info;
    info.m_defaultMaxPersistentManifoldPoolSize = static_cast<int>(4096 + 16 * bodies);
    info.m_defaultMaxCollisionAlgorithmPoolSize = static_cast<int>(4096 + 16 * bodies);
    return info;
  }

  btRigidBody* add(std::unique_ptr<btCollisionShape> shape, double mass, const btVector3& position,
                   const btQuaternion& orientation, pair_law law) {
    btVector3 inertia(0, 0, 0);
    if (mass > 0) shape->calculateLocalInertia(btScalar(mass), inertia);
    // This constructor carries the precision in its symbol: a wrong library fails to link.
    bodies_.push_back(std::make_unique<btRigidBody>(btScalar(mass), nullptr, shape.get(), inertia));
    btRigidBody* body = bodies_.back().get();
    body->setCenterOfMassTransform(btTransform(orientation, position));
    body->setInterpolationWorldTransform(body->getWorldTransform());
    body->setFriction(btScalar(law.friction));
    body->setRestitution(btScalar(law.restitution));
    body->setUserIndex(static_cast<int>(bodies_.size()) - 1);
    world_.addRigidBody(body);
    shapes_.push_back(std::move(shape));
    return body;
  }

  scene scene_;
  btDefaultCollisionConstructionInfo construction_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
};

}  // namespace bench
