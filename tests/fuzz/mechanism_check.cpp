// What is checked of a random mechanism, and the search for its smallest part that fails.
#include <algorithm>
#include <cmath>

#include "mechanism.hpp"

namespace fuzz {
namespace {

/// The largest difference of two ends: of positions and orientations, and of velocities over the
/// fastest one; infinite if other bodies or joints are there.
real difference(const mechanism_end& x, const mechanism_end& y) {
  constexpr real infinity = std::numeric_limits<real>::infinity();
  if (x.bodies.size() != y.bodies.size() || x.joints.size() != y.joints.size()) return infinity;
  real most = 0;
  const real fastest = std::max<real>({1, x.fastest, y.fastest});
  for (std::size_t k = 0; k < x.bodies.size(); ++k) {
    if (x.bodies[k].id != y.bodies[k].id) return infinity;
    for (std::size_t n = 0; n < 13; ++n) {
      const real d = std::abs(x.bodies[k].state[n] - y.bodies[k].state[n]);
      if (!(d <= most)) most = n < 7 ? d : std::max(most, d / fastest);
    }
  }
  for (std::size_t n = 0; n < x.joints.size(); ++n) {
    if (x.joints[n][0] != y.joints[n][0]) return infinity;
    for (const std::size_t c : {1u, 2u})
      most = std::max(most, std::abs(x.joints[n][c] - y.joints[n][c]));
  }
  return most;
}

bool any_body(const mechanism& m, mechanism_body::role how) {
  for (std::size_t k = 0; k < m.bodies.size(); ++k)
    if (m.has_body(static_cast<int>(k)) && m.bodies[k].how == how) return true;
  return false;
}
/// Whether there are contacts, and these or a limit or rope have a restitution.
bool rebounds(const mechanism& m, std::uint64_t contacts) {
  if (contacts == 0) return false;
  if (m.restitution > 0) return true;
  for (std::size_t k = 0; k < m.joints.size(); ++k) {
    const mechanism_joint& j = m.joints[k];
    if (m.has_joint(static_cast<int>(k)) &&
        std::max({j.first.restitution, j.second.restitution,
                  j.what == mechanism_joint::kind::rope ? j.restitution : 0}) > 0)
      return true;
  }
  return false;
}

/// What is wrong with one run, empty if nothing is.
std::string what_fails(const mechanism& m, const mechanism_end& end) {
  const auto text = [](real x) { return talus::detail::text(x, 3); };
  // Ranks that are not connected end a run with the reach that they need.
  const auto says = [&](const char* words) { return end.refused.find(words) != std::string::npos; };
  const bool of_domains = (says("reach") && m.reach < 9) || says("no space of its own");
  if (!end.refused.empty() && !m.wild && !of_domains) return "throws: " + end.refused;
  if (end.worst_closure > 1e-10) return "the ledger leaves " + text(end.worst_closure);
  if (m.wild) return "";
  // Contacts of `reproducible` and across ranks may add some, as may driven bodies.
  const real most = rebounds(m, end.contacts) ? 0.05 : 1e-9;
  if (end.gain > most && !any_body(m, mechanism_body::role::driven))
    return "impulses add " + text(end.gain) + " of the energy in step " +
           std::to_string(end.step_of_gain);
  // Arms are longer than 0.1; what is open by 0.01 of its arm is noted for a warning.
  if (end.gap > 5e-3 && end.opened == 0)
    return "a joint is open by " + text(end.gap) + " in step " + std::to_string(end.step_of_gap);
  return "";
}

/// What is wrong with a mechanism; `seen` gets the runs. A run on one rank may suffice.
std::string what_fails(const mechanism& m, mechanism_runner run, bool alone, outcome& seen) {
  const auto text = [](real x) { return talus::detail::text(x, 3); };
  mechanism_end one, many;
  for (auto [end, ranks] : {std::pair(&one, 1), std::pair(&many, m.ranks)}) {
    const std::string name = ranks == 1 ? "one rank: " : "ranks: ";
    try {
      *end = run(m, ranks, {});
    } catch (const broken& e) {
      return name + e.what();
    }
    seen.crossed += end->crossed;
    if (const std::string fails = what_fails(m, *end); !fails.empty()) return name + fails;
    if (alone) return "";
  }
  seen.contacts = one.contacts, seen.refused = one.refused.empty() ? many.refused : one.refused;
  if (!one.refused.empty() || !many.refused.empty()) return "";
  if (m.reproducible) {
    if (one.digest != many.digest || one.joints != many.joints) {
      const mechanism_options traced{.trace = true};
      const auto x = run(m, 1, traced).digests;
      const auto y = run(m, m.ranks, traced).digests;
      std::size_t k = 0;
      while (k < x.size() && k < y.size() && x[k] == y[k]) ++k;
      return k == x.size() ? std::string("angle or travel of a joint differs by ranks")
                           : "bits: the digest differs by ranks, from step " + std::to_string(k) +
                                 ", at the end by " + text(difference(one, many));
    }
    return "";
  }
  if (one.contacts > 0) return "";
  const real found = difference(one, many);
  if (found <= 1e-9) return "";
  const real sensitive = difference(one, run(m, 1, {.perturbation = 1e-13}));
  seen.chaotic = sensitive > 1e-10;
  if (seen.chaotic) return "";
  return "default: the end differs by ranks by " + text(found) +
         ", by a perturbation of 1e-13 by " + text(sensitive);
}

}  // namespace

outcome check_mechanism(const plan& p, bool around, mechanism_runner run) {
  mechanism m = draw_mechanism(p.seed, around);
  m.without = p.without;
  outcome seen;
  std::string fails = what_fails(m, run, false, seen);
  if (fails.empty()) return seen;
  // Items without which it fails alike.
  const auto kind = [](const std::string& s) { return s.substr(0, s.find_first_of("0123456789")); };
  const bool alone = fails.rfind("one rank", 0) == 0;
  for (bool smaller = p.shrinks; smaller;) {
    smaller = false;
    for (int k = m.items() - 1; k >= 0; --k) {
      if (!m.without.insert(k).second) continue;
      outcome ignored;
      const std::string same = what_fails(m, run, alone, ignored);
      if (kind(same) == kind(fails))
        smaller = true, fails = same;
      else
        m.without.erase(k);
    }
  }
  std::string numbers;
  for (const int k : m.without)
    numbers += (numbers.empty() ? " --without " : ",") + std::to_string(k);
  throw broken(fails + (p.shrinks && !numbers.empty() ? "\n  the same with" + numbers : "") +
               "\n  " + text(m) + "\n ");
}

}  // namespace fuzz
