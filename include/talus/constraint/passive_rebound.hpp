#pragma once
// The restitution of the impact of two bodies with friction, so that it adds no energy.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "talus/constraint/contact_work.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// Newton's law of restitution with friction can add energy to two bodies without any other contact
/// (Kane and Levinson 1985): friction may reverse the sliding that it does work on. The impact of
/// one pair is solved alone, from the velocities without contacts; if it adds energy, the target
/// velocities of its contacts become the largest part of themselves that does not. The result
/// depends on the two bodies and their contacts only.
template <class Contact>
class passive_rebound {
  using state = typename Contact::state;

 public:
  /// The contacts of one pair, whose impulses are not applied yet. Returns whether targets changed.
  [[nodiscard]] bool limit(std::span<Contact> contacts, state& s) {
    if (std::none_of(contacts.begin(), contacts.end(),
                     [](const Contact& c) { return c.target_velocity > 0; }))
      return false;
    const auto a = static_cast<std::size_t>(contacts[0].a);
    auto b = a;
    if constexpr (Contact::paired) b = static_cast<std::size_t>(contacts[0].b);
    const auto body_a = s.bodies[a], body_b = s.bodies[b];
    for (const auto& x : {body_a, body_b})  // a wall that moves may add energy
      if (x.inverse_mass == 0 && (v_of(x).squaredNorm() > 0 || w_of(x).squaredNorm() > 0))
        return false;
    vec3 fall = body_a.inverse_mass == 0 ? vec3(0, 0, 0) : s.fall;
    if (Contact::paired && body_b.inverse_mass != 0) fall -= s.fall;

    const auto adds_energy = [&](real part) {
      trial_.assign(contacts.size(), {});
      std::copy(contacts.begin(), contacts.end(), trial_.begin());
      const bool adds = solve(part, s, fall);
      s.bodies[a] = body_a, s.bodies[b] = body_b;
      return adds;
    };
    if (!adds_energy(1)) return false;
    real part = 0;
    for (real step = 0.5; step > precision; step /= 2)
      if (!adds_energy(part + step)) part += step;
    for (Contact& c : contacts)
      if (c.target_velocity > 0)
        c.target_velocity = static_cast<decltype(c.target_velocity)>(part * c.target_velocity);
    return true;
  }

 private:
  static constexpr real precision = 1e-3;
  static constexpr int most_sweeps = 40;

  /// Whether the impulses add energy, both to the velocities before the step and to those that the
  /// bodies would have at its end without them.
  bool solve(real part, state& s, const vec3& fall) {
    before_.clear();
    for (Contact& c : trial_) {
      c.set(c.since(c.impulse_in_frame()));
      if (c.target_velocity > 0)
        c.target_velocity = static_cast<decltype(c.target_velocity)>(part * c.target_velocity);
      c.prepare(s, 1, 1);
      before_.push_back(c.relative_velocity(s));
    }
    for (int k = 0; k < most_sweeps; ++k) {
      real change = 0, size = 0;
      for (Contact& c : trial_) {
        const auto d = c.relax(s);
        c.apply(s, d);
        change = std::max(change, c.speed_of(d)),
        size = std::max(size, std::abs(c.target_velocity));
      }
      if (change <= 1e-9 * size) break;
    }
    real work = 0, by_fall = 0, size = 0;
    for (std::size_t i = 0; i < trial_.size(); ++i) {
      const vec3 p = impulse_on_a(trial_[i]), u = trial_[i].relative_velocity(s);
      work += real(0.5) * p.dot(before_[i] + u);
      by_fall += real(0.5) * p.dot(fall);
      size += std::abs(p.dot(before_[i])) + std::abs(p.dot(u));
    }
    return std::min(work, work - by_fall) > 1e-9 * size;
  }

  plain_vector<Contact> trial_;
  plain_vector<vec3> before_;
};

}  // namespace talus::detail
