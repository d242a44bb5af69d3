#pragma once
// What lists of contacts of all solvers sum over their contacts: the terms of the residual, the
// speeds of approach, and the number of contacts.
#include <cstddef>
#include <cstdint>

#include "talus/constraint/approach.hpp"
#include "talus/constraint/joint_in_list.hpp"
#include "talus/constraint/residual.hpp"
#include "talus/core/exact_sum.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// Base of a `List` that has each(f), with f(contact, counts_here).
template <class List, class Contact>
class contact_sums {
 public:
  using contact_type = Contact;
  using state = typename Contact::state;

  // The terms of the contact residual, in double or in sums that do not depend on an order.

  void add_to(residual_scale_of<double>& scale, const state& s) const;
  void add_to(residual_scale_of<exact_sum>& scale, const state& s) const;
  void add_to(residual_sums_of<double>& sums, const state& s, double rho) const;
  void add_to(residual_sums_of<exact_sum>& sums, const state& s, double rho) const;
  /// The same as the first for velocities `after` the step, of which `given` is the part from
  /// impulses.
  void add_to(residual_scale_of<double>& scale, const state& after, const state& given) const;
  /// Raises the speeds at which bodies penetrate their contact partners; see approach.hpp.
  void add_approach(const state& after, plain_vector<real>& speeds) const;
  /// The number of contacts that count on this rank.
  [[nodiscard]] std::size_t counted() const;

  // Strikes follow the solution of a step (see step/strike_contacts.hpp). The residual is that of
  // the solution.

  /// Called before contact number `i` of each() is struck, and the state with it.
  void note(state& s, std::size_t i, const Contact& c) {
    if (s.unstruck.empty()) s.unstruck = s.bodies;
    if constexpr (is_joint<Contact>)
      struck_.push_back({i, c.impulse_in_frame(), 0});
    else
      struck_.push_back({i, c.impulse_in_frame(), real(c.target_velocity)});
  }
  /// The same for all.
  void note_all(state& s) {
    if (!struck_.empty()) return;
    std::size_t i = 0;
    list().each([&](const Contact& c, bool) { note(s, i++, c); });
  }
  void forget_strikes() { struck_.clear(); }
  /// Calls f(contact, counts_here) for all contacts, as they were before.
  template <class F>
  void each_unstruck(F&& f) const {
    if (struck_.empty()) return list().each(f);
    plain_vector<std::uint32_t> first(list().size(), 0);
    for (std::size_t k = struck_.size(); k-- > 0;)
      first[struck_[k].contact] = static_cast<std::uint32_t>(k + 1);
    std::size_t i = 0;
    list().each([&](const Contact& now, bool counts_here) {
      const std::uint32_t k = first[i++];
      if (k == 0) return f(now, counts_here);
      Contact c = now;
      c.set(struck_[k - 1].impulse);
      if constexpr (!is_joint<Contact>)
        c.target_velocity = static_cast<decltype(c.target_velocity)>(struck_[k - 1].target);
      f(c, counts_here);
    });
  }

 private:
  struct before_strike {
    std::size_t contact;
    typename Contact::change impulse;
    real target;
  };
  plain_vector<before_strike> struck_;

  [[nodiscard]] const List& list() const { return static_cast<const List&>(*this); }
};

template <class List, class Contact>
void contact_sums<List, Contact>::add_to(residual_scale_of<double>& scale, const state& s) const {
  add_contacts(scale, list(), s);
}
template <class List, class Contact>
void contact_sums<List, Contact>::add_to(residual_scale_of<exact_sum>& scale,
                                         const state& s) const {
  add_contacts(scale, list(), s);
}
template <class List, class Contact>
void contact_sums<List, Contact>::add_to(residual_sums_of<double>& sums, const state& s,
                                         double rho) const {
  add_contacts(sums, list(), s, rho);
}
template <class List, class Contact>
void contact_sums<List, Contact>::add_to(residual_sums_of<exact_sum>& sums, const state& s,
                                         double rho) const {
  add_contacts(sums, list(), s, rho);
}
template <class List, class Contact>
void contact_sums<List, Contact>::add_to(residual_scale_of<double>& scale, const state& after,
                                         const state& given) const {
  each_unstruck([&](const auto& c, bool counts_here) {
    if (counts_here) scale.add(c, after, violation(c, after) - c.relative_velocity(given));
  });
}
template <class List, class Contact>
void contact_sums<List, Contact>::add_approach(const state& after,
                                               plain_vector<real>& speeds) const {
  list().each([&](const auto& c, bool) { detail::add_approach(c, after, speeds); });
}
template <class List, class Contact>
std::size_t contact_sums<List, Contact>::counted() const {
  std::size_t n = 0;
  list().each([&](const auto&, bool counts_here) { n += counts_here; });
  return n;
}

}  // namespace talus::detail
