#pragma once
// The own bodies of a rank that contacts connect, and which of them may form an island on which
// sweeps stall.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "talus/core/disjoint_sets.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/solver/colouring.hpp"
#include "talus/solver/contact_access.hpp"
#include "talus/solver/direct/clusters.hpp"
#include "talus/solver/direct/stalled_figures.hpp"

namespace talus::detail {

/// Finds groups of own bodies, and leaves out what cannot be an island that is solved: one pass
/// over the pairs says that of a pile. What it leaves out may depend on the rank and on the order
/// of the bodies; that it may be left out does not.
template <class State>
class groups_in_contact {
 public:
  struct group {
    std::uint32_t root = 0;
    bool tied = false;        ///< a body touches one of another rank
    stalled_figures figures;  ///< with pairs in place of contacts
  };
  static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

  void find(colouring& pairs, const State& s) {
    limits_ = s.limits;
    groups_.clear(), units_.clear(), ties_.clear(), of_body_.clear();
    pairs.islands().shorten();
    sets_ = &pairs.islands();
    if (!pairs.lines.empty())
      for (std::uint32_t k = 0; k < pairs.size(); ++k)
        if (pairs.unit(k).line >= 0) ties_.push_back(k);
    find_sizes(pairs);
    compare_masses(s);
    find_heavy(pairs, s);
    for (const sizes& of : sizes_)
      if (may_be_solved(of)) {
        group& one = groups_.emplace_back();
        one.root = of.root, one.tied = of.tied;
        one.figures.overloaded = of.overloaded;
        one.figures.contacts = of.pairs, one.figures.bodies = of.bodies;
      }
    large_ties_.clear();
    for (const std::uint32_t k : ties_)
      if (size_of(pairs.unit(k).a).pairs > limits_.contacts) large_ties_.push_back(k);
    number_groups();
    if (groups_.empty()) return;
    collect_units(pairs, s);
    find_rows(pairs);
    leave_out_wide_ones();
    of_body_.resize(number_.size());
    for (std::uint32_t i = 0; i < number_.size(); ++i) of_body_[i] = number_[sets_->parent(i)];
  }
  [[nodiscard]] const plain_vector<group>& all() const { return groups_; }
  /// The pairs of these groups, among others.
  [[nodiscard]] const plain_vector<std::uint32_t>& units() const { return units_; }
  /// The pairs of own bodies with those of other ranks.
  [[nodiscard]] const plain_vector<std::uint32_t>& ties() const { return ties_; }
  /// The number of the group of an own body; none for other bodies.
  [[nodiscard]] std::uint32_t group_of(std::int32_t body) const {
    return body < 0 || at(body) >= of_body_.size() ? none : of_body_[at(body)];
  }
  /// The number of the group of the bodies of a contact, or none.
  [[nodiscard]] std::uint32_t group_of(std::int32_t a, std::int32_t b) const {
    return std::min(group_of(a), group_of(b));
  }
  /// The pairs of bodies of too large groups with those of other ranks.
  [[nodiscard]] const plain_vector<std::uint32_t>& large_ties() const { return large_ties_; }

 private:
  /// Groups of so few bodies may be long in any case.
  static constexpr std::uint32_t few = 100;
  /// The numbers of bodies with one root, and of their pairs.
  struct sizes {
    std::uint32_t root = 0, pairs = 0, bodies = 0;
    bool tied = false, overloaded = false;
  };
  [[nodiscard]] static std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

  /// Counts the pairs and bodies of each root; number_ is the place of a root.
  void find_sizes(const colouring& pairs) {
    const plain_vector<std::uint32_t>& count = pairs.units_of_bodies();
    const std::size_t n = count.size();
    sizes_.clear(), number_.resize(n);
    std::uint32_t* const number = number_.data();
    std::uint32_t last = none, sum = 0, bodies = 0;
    const auto add = [&] {
      if (last != none) sizes_[number[last]].pairs += sum, sizes_[number[last]].bodies += bodies;
      sum = bodies = 0;
    };
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t root = sets_->parent(i);
      if (root == i) {
        number[i] = static_cast<std::uint32_t>(sizes_.size());
        sizes_.push_back({i, count[i], 1});
      } else {
        if (root != last) add(), last = root;
        sum += count[i], ++bodies;
      }
    }
    add();
    for (const std::uint32_t k : ties_) size_of(pairs.unit(k).a).tied = true;
  }
  [[nodiscard]] sizes& size_of(std::int32_t body) {
    return sizes_[number_[sets_->parent(at(body))]];
  }
  /// From then on, number_ is the number of the group of a root.
  void number_groups() {
    for (const sizes& of : sizes_) number_[of.root] = none;
    for (std::uint32_t k = 0; k < groups_.size(); ++k) number_[groups_[k].root] = k;
  }
  /// The least and the largest inverse mass of what moves.
  void compare_masses(const State& s) {
    real least = std::numeric_limits<real>::max(), most = 0;
    for (const auto& b : s.bodies)
      if (const real inverse = real(b.inverse_mass); inverse != 0)
        least = std::min(least, inverse), most = std::max(most, inverse);
    least_ = least, most_ = most;
  }
  [[nodiscard]] bool may_be_solved(const sizes& of) const {
    if (of.pairs == 0 || of.pairs > limits_.contacts) return false;
    if (of.tied || of.overloaded) return true;
    stalled_figures longest;
    longest.bodies = longest.in_a_row = of.bodies;
    longest.least_mass = 1 / most_, longest.most_mass = 1 / least_;
    return of.pairs <= limits_.many && longest.may_be_narrow();
  }
  /// The pairs of the groups, and the range of their masses.
  void collect_units(const colouring& pairs, const State& s) {
    plain_vector<plain_pair<real, real>> inverse(groups_.size(), {most_, least_});
    units_.resize(pairs.size());
    std::uint32_t count = 0;
    for (std::uint32_t n = 0; n < pairs.size(); ++n) {
      const std::uint32_t k = number_[sets_->parent(at(pairs.unit(n).a))];
      if (k == none) continue;
      const contact_unit& u = pairs.unit(n);
      units_[count++] = n;
      auto& [least, most] = inverse[k];
      const auto add = [&](std::int32_t body) {
        const real one = real(s.bodies[at(body)].inverse_mass);
        least = std::min(least, one), most = std::max(most, one);
      };
      add(u.a);
      if (u.b >= 0 && u.line < 0) add(u.b);
    }
    units_.resize(count);
    for (std::uint32_t k = 0; k < groups_.size(); ++k)
      groups_[k].figures.add_mass(1 / inverse[k].first),
          groups_[k].figures.add_mass(1 / inverse[k].second);
  }
  /// Bodies in a row between any two of a group: at most twice those from one to the farthest.
  void find_rows(const colouring& pairs) {
    if (std::all_of(groups_.begin(), groups_.end(),
                    [](const group& g) { return g.figures.bodies <= few; })) {
      for (group& of : groups_) of.figures.in_a_row = of.figures.bodies;
      return;
    }
    const auto each = [&](auto&& f) {
      for (const std::uint32_t n : units_) {
        const contact_unit& u = pairs.unit(n);
        if (u.line < 0 && u.b >= 0) f(u.a, u.b), f(u.b, u.a);
      }
    };
    first_.assign(number_.size() + 2, 0);
    each([&](std::int32_t body, std::int32_t) { ++first_[at(body) + 2]; });
    for (std::size_t k = 2; k < first_.size(); ++k) first_[k] += first_[k - 1];
    touching_.resize(first_.back());
    each([&](std::int32_t body, std::int32_t other) {
      touching_[first_[at(body) + 1]++] = static_cast<std::uint32_t>(other);
    });
    met_.assign(number_.size(), 0), queue_.resize(number_.size() + 1);
    for (group& of : groups_) {
      of.figures.in_a_row = of.figures.bodies;
      if (of.figures.bodies <= few) continue;
      if (of.figures.contacts > limits_.many && !of.figures.overloaded) continue;
      of.figures.in_a_row = 2 * levels_from(of.root) + 1;
    }
  }
  /// How many contacts in a row lead to the farthest body of its group.
  [[nodiscard]] std::uint32_t levels_from(std::uint32_t body) {
    std::uint32_t levels = 0, size = 1;
    std::uint32_t* const queue = queue_.data();
    queue[0] = body, met_[body] = 1;
    for (std::uint32_t k = 0, end = 1; k < size; ++k) {
      if (k == end) end = size, ++levels;
      for (std::size_t e = first_[queue[k]]; e < first_[queue[k] + 1]; ++e) {
        const std::uint32_t other = touching_[e];
        queue[size] = other;
        if (met_[other] == 0) met_[other] = 1, ++size;
      }
    }
    return levels;
  }
  void leave_out_wide_ones() {
    const auto is_wide = [](const group& g) {
      return !g.tied && !g.figures.overloaded && !g.figures.may_be_narrow();
    };
    std::uint32_t kept = 0;
    for (const group& g : groups_) {
      number_[g.root] = is_wide(g) ? none : kept;
      if (!is_wide(g)) groups_[kept++] = g;
    }
    groups_.resize(kept);
  }
  /// Clusters of heavy bodies on light ones. The owner of a heavy body sees all that it touches.
  void find_heavy(const colouring& pairs, const State& s) {
    if (4 * least_ >= most_) return;  // no body has five times the mass of another one
    masses_.clear();
    for (const auto& b : s.bodies)
      masses_.push_back(b.inverse_mass != 0 ? 1 / real(b.inverse_mass) : 0);
    if (!may_overload(pairs)) return;
    plain_vector<contact_ends> ends;
    for (std::size_t n = 0; n < pairs.size(); ++n)
      if (const contact_unit& u = pairs.unit(n); u.b >= 0 && size_of(u.a).pairs <= limits_.contacts)
        ends.push_back({u.a, u.b});
    clusters_.find_possible(ends, masses_, [&](std::uint32_t i) { return !is_own(i); });
    for (const contact_ends& c : ends)
      for (const std::int32_t body : {c.a, c.b})
        if (clusters_.of(body) != overloaded_clusters::none) size_of(body).overloaded = true;
  }
  /// Whether a body that touches others is an own one.
  [[nodiscard]] bool is_own(std::uint32_t body) {
    return size_of(static_cast<std::int32_t>(body)).pairs > 0;
  }
  /// Whether the lighter bodies that some own one touches do not carry its load.
  [[nodiscard]] bool may_overload(const colouring& pairs) {
    light_.assign(masses_.size(), 0);
    for (std::size_t n = 0; n < pairs.size(); ++n) {
      const contact_unit& u = pairs.unit(n);
      if (u.b < 0) continue;
      const real a = masses_[at(u.a)], b = masses_[at(u.b)];
      if (a != b) light_[at(a > b ? u.a : u.b)] += std::min(a, b);
    }
    constexpr real part = 1 - real(2e-9);  // sums in another order
    for (std::uint32_t i = 0; i < light_.size(); ++i)
      if (light_[i] > 0 && part * overloaded_clusters::heavy * light_[i] < masses_[i] &&
          is_own(i) && size_of(static_cast<std::int32_t>(i)).pairs <= limits_.contacts)
        return true;
    return false;
  }

  island_limits limits_;
  real least_ = 0, most_ = 0;  ///< inverse masses of what moves
  const disjoint_sets* sets_ = nullptr;
  plain_vector<std::uint32_t> number_;   ///< in sizes_, or groups_, of each root
  plain_vector<std::uint32_t> of_body_;  ///< in groups_
  plain_vector<sizes> sizes_;            ///< of all roots
  plain_vector<group> groups_;
  plain_vector<std::uint32_t> units_, ties_, large_ties_;
  plain_vector<real> masses_, light_;  ///< of bodies
  overloaded_clusters clusters_;
  plain_vector<std::uint32_t> first_, touching_;  ///< of each body
  plain_vector<std::uint32_t> queue_;
  plain_vector<char> met_;
};

}  // namespace talus::detail
