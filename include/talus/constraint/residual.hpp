#pragma once
// The contact residual, directly from the contacts: no operator is assembled.
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <tuple>

#include "talus/constraint/impact_terms.hpp"
#include "talus/constraint/joint_in_list.hpp"
#include "talus/constraint/natural_map.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/core/math.hpp"

namespace talus::detail {

/// Whether contacts of this kind obey Coulomb's law, so that a residual is defined for them.
template <class Contact>
concept has_residual = requires(const Contact& c, const typename Contact::state& s) {
  c.relative_velocity(s);
  c.delassus_trace(s);
};

/// Calls f(contact) for each contact that obeys Coulomb's law and counts on this rank.
template <class Lists, class F>
void each_counted(const Lists& lists, F&& f) {
  const auto of_list = [&](const auto& list) {
    list.each([&](const auto& c, bool counts_here) {
      if constexpr (has_residual<std::remove_cvref_t<decltype(c)>>)
        if (counts_here) f(c);
    });
  };
  each_of(lists, of_list);
}

/// The relative velocity, minus the target of gap and restitution; the violation of a joint.
template <class Contact>
[[nodiscard]] auto violation(const Contact& c, const typename Contact::state& s) {
  if constexpr (is_joint<Contact>) {
    return c.relative_velocity(s);
  } else {
    vec3 u = c.relative_velocity(s) - c.target_velocity * c.axis();
    if constexpr (Contact::biased) u -= c.bias;
    return u;
  }
}

/// The size of a violation counts from the limit of a contact: impacts change its target in the
/// course of the step, see impact_terms.hpp.
template <class Contact, class Values>
[[nodiscard]] Values from_limit(const Contact& c, const Values& u) {
  if constexpr (may_rebound<Contact>)
    if (c.restitution > 0) return u + real(c.target_velocity - c.limit) * c.axis();
  return u;
}

/// The impulse of impacts that are over; see impact_terms.hpp.
template <class Contact>
[[nodiscard]] vec3 held_impulse(const Contact& c) {
  if constexpr (may_rebound<Contact>) {
    if (!(c.restitution > 0)) return {0, 0, 0};
    Contact held = c;
    held.set(c.held);
    return held.impulse();
  } else {
    return {0, 0, 0};
  }
}

/// The parts of the residual that no iteration changes, summed over all contacts and over the
/// ranks, in double or exactly.
template <class Sum>
struct residual_scale_of {
  std::array<Sum, 3> sums{};  ///< the diagonal of the Delassus operator, its rows, |q|^2

  template <class Contact, class Values>
  void add(const Contact& c, const typename Contact::state& s, const Values& q) {
    sums[0] += c.delassus_trace(s);
    sums[1] += Contact::rows;
    sums[2] += from_limit(c, q).squaredNorm();
  }
  /// The mass that converts velocities to impulses: 1 / mean diagonal.
  [[nodiscard]] double rho() const {
    const double diagonal = sums[0];
    return diagonal > 0 ? sums[1] / diagonal : 0;
  }
};

/// The parts that each iteration changes.
template <class Sum>
struct residual_sums_of {
  std::array<Sum, 4> sums{};  ///< |natural map|^2, |r|^2, |u|^2, number of contacts
  double largest = 0;         ///< of the squares of the natural maps

  template <class Contact>
  void add(const Contact& c, const typename Contact::state& s, double rho) {
    double square = 0;
    if constexpr (is_joint<Contact>) {
      const auto u = c.relative_velocity(s);
      square = rho * rho * u.squaredNorm();
      sums[0] += square;
      sums[1] += c.impulse_in_frame().squaredNorm();
      sums[2] += u.squaredNorm();
    } else {
      vec3 r = c.impulse();
      const vec3 u = violation(c, s);
      if (s.impacts_ended) r -= held_impulse(c);
      square = natural_map(r, u, c.axis(), c.mu(), rho).squaredNorm();
      sums[0] += square;
      sums[1] += r.squaredNorm();
      sums[2] += from_limit(c, u).squaredNorm();
    }
    sums[3] += 1;
    if (!(square <= largest)) largest = square;  // keeps a NaN
  }
  /// |natural map| / max(|r|, rho |q|, rho |u|); 0 without contacts.
  [[nodiscard]] double value(const residual_scale_of<Sum>& scale) const {
    const double square = sums[0];
    return square == 0 ? 0 : std::sqrt(square / square_of(scale));
  }
  /// The largest natural map of a contact over the root mean square of the same scale: the residual
  /// is the root mean square of such values.
  [[nodiscard]] double worst(const residual_scale_of<Sum>& scale) const {
    return largest == 0 ? 0 : std::sqrt(largest * sums[3] / square_of(scale));
  }

 private:
  [[nodiscard]] double square_of(const residual_scale_of<Sum>& scale) const {
    const double rho = scale.rho(), r = sums[1], q = scale.sums[2], u = sums[2];
    return std::max({r, rho * rho * q, rho * rho * u});
  }
};

/// Adds the terms of each contact of a list that obeys Coulomb's law and counts on this rank.
template <class Sum, class List>
void add_contacts(residual_scale_of<Sum>& scale, const List& list,
                  const typename List::contact_type::state& s) {
  if constexpr (has_residual<typename List::contact_type>)
    list.each([&](const auto& c, bool counts_here) {
      if (counts_here) scale.add(c, s, violation(c, s));
    });
}
template <class Sum, class List>
void add_contacts(residual_sums_of<Sum>& sums, const List& list,
                  const typename List::contact_type::state& s, double rho) {
  if constexpr (has_residual<typename List::contact_type>)
    list.each([&](const auto& c, bool counts_here) {
      if (counts_here) sums.add(c, s, rho);
    });
}
/// The residual scale of all contacts of a tuple of lists.
template <class Sum = double, class... Lists, class State>
[[nodiscard]] residual_scale_of<Sum> scale_of(const std::tuple<Lists...>& lists, const State& s) {
  residual_scale_of<Sum> scale;
  each_of(lists, [&](const auto& list) { list.add_to(scale, s); });
  return scale;
}
template <class Sum = double, class... Lists, class State>
[[nodiscard]] residual_sums_of<Sum> sums_of(const std::tuple<Lists...>& lists, const State& s,
                                            double rho) {
  residual_sums_of<Sum> sums;
  each_of(lists, [&](const auto& list) { list.add_to(sums, s, rho); });
  return sums;
}

}  // namespace talus::detail
