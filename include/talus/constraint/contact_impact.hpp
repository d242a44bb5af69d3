#pragma once
// The data of a contact that may rebound within the step; see constraint/impact_terms.hpp.

namespace talus::detail {

/// With a law without restitution nothing is stored.
template <class Real, class Impulse, bool Restitution>
struct contact_impact {
  Real restitution{};     ///< of an impact within the step, where it may be one
  Real limit{};           ///< the least velocity by which surfaces do not overlap
  Real slowest{};         ///< the normal velocity below which the contact is an impact
  Impulse held = none();  ///< the impulse of impacts that are over

 private:
  static Impulse none() {
    if constexpr (requires { Impulse::Zero(); })
      return Impulse::Zero();
    else
      return {};
  }
};
template <class Real, class Impulse>
struct contact_impact<Real, Impulse, false> {};

/// A kind of contact that may rebound.
template <class Contact>
concept may_rebound = requires(Contact& c) {
  c.restitution;
  c.limit;
  c.held;
};

/// Whether an impact of this contact rebounds in this step.
template <class Contact>
[[nodiscard]] bool strikes(const Contact& c) {
  if constexpr (!may_rebound<Contact>)
    return (void)c, false;
  else if constexpr (requires { c.held.n; })
    return c.target_velocity > 0 || c.held.n != 0;
  else
    return c.target_velocity > 0 || !(c.held == decltype(c.held)::Zero());
}

}  // namespace talus::detail
