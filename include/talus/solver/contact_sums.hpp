#pragma once
// What lists of contacts of all solvers sum over their contacts: the terms of the residual, the
// speeds of approach, and the number of contacts.
#include <cstddef>

#include "talus/constraint/approach.hpp"
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
  /// Adds the terms of the contacts to the residual scale for velocities `after` the step; `given`
  /// is the part of these velocities that impulses have added.
  void add_to(residual_scale_of<exact_sum>& scale, const state& after, const state& given) const;
  /// Raises the speeds at which bodies penetrate their contact partners; see approach.hpp.
  void add_approach(const state& after, plain_vector<real>& speeds) const;
  /// The number of contacts that count on this rank.
  [[nodiscard]] std::size_t counted() const;

 private:
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
void contact_sums<List, Contact>::add_to(residual_scale_of<exact_sum>& scale, const state& after,
                                         const state& given) const {
  list().each([&](const auto& c, bool counts_here) {
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
