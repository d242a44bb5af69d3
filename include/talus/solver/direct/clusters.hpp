#pragma once
// Heavy bodies with the light ones that bear them: the parts of a large island on which sweeps
// stall.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "talus/core/disjoint_sets.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/solver/contact_access.hpp"

namespace talus::detail {

/// The load of a body may reach what carries it through the bodies lighter than itself that touch
/// it, directly or through others of them. They end at bodies that are at least as heavy, and at
/// immovable ones. If the body has a multiple of the mass of all of these together, each sweep
/// transmits the inverse of that, over the square of the bodies in a row. So a plate on spheres on
/// a floor needs many sweeps, and a grain of a heap does not, whatever touches it: its load spreads
/// over more than its own mass. The heavy body and these light ones are a cluster; clusters with
/// common bodies are one.
class overloaded_clusters {
 public:
  /// A body of no cluster.
  static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
  /// A body with this multiple of the mass of the light ones is heavy.
  static constexpr real heavy = 5;
  /// With that many sweeps the error of a heap is as small as elsewhere in a few steps.
  static constexpr real most_sweeps = 50;

  /// Among the contacts that are in question. The mass of immovable bodies is 0.
  template <class InQuestion>
  void find(const plain_vector<contact_ends>& contacts, InQuestion&& in_question,
            const plain_vector<real>& masses) {
    part_ = 1;
    find_those(contacts, in_question, masses, [](std::uint32_t) { return false; });
  }
  /// Also those that may be clusters: not all contacts of a body with is_copy(body) are here, and
  /// the order of the contacts is not that of others who look.
  template <class IsCopy>
  void find_possible(const plain_vector<contact_ends>& contacts, const plain_vector<real>& masses,
                     IsCopy&& is_copy) {
    part_ = 1 - real(1e-9);
    find_those(
        contacts, [](std::size_t) { return true; }, masses, is_copy);
  }
  /// The number of its cluster: that of one of its bodies.
  [[nodiscard]] std::uint32_t of(std::int32_t body) {
    return found_ && body >= 0 && in_cluster_[at(body)] ? sets_.root(body) : none;
  }
  [[nodiscard]] bool found() const { return found_; }

 private:
  static std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] real mass(std::int32_t i) const { return (*masses_)[at(i)]; }

  template <class InQuestion, class IsCopy>
  void find_those(const plain_vector<contact_ends>& contacts, InQuestion&& in_question,
                  const plain_vector<real>& masses, IsCopy&& is_copy) {
    masses_ = &masses;
    found_ = false;
    plain_vector<char> above(masses.size(), 0);  // heavier than a body that it touches
    first_.assign(masses.size() + 1, 0);
    const auto each = [&](auto&& f) {
      for (std::size_t i = 0; i < contacts.size(); ++i) {
        const auto [a, b] = contacts[i];
        if (b >= 0 && mass(a) > 0 && mass(b) > 0 && in_question(i))
          f(at(a), at(b)), f(at(b), at(a));
      }
    };
    each([&](std::size_t body, std::size_t other) {
      above[body] |= masses[body] > heavy * masses[other];
      ++first_[body + 1];
    });
    plain_vector<std::uint32_t> candidates;
    for (std::uint32_t i = 0; i < masses.size(); ++i)
      if (above[i]) candidates.push_back(i);
    if (candidates.empty()) return;
    for (std::size_t k = 1; k < first_.size(); ++k) first_[k] += first_[k - 1];
    touching_.resize(first_.back());
    plain_vector<std::uint32_t> next = first_;
    each([&](std::size_t body, std::size_t other) {
      touching_[next[body]++] = static_cast<std::uint32_t>(other);
    });
    sets_.reset(masses.size());
    in_cluster_.assign(masses.size(), 0);
    met_.assign(masses.size(), none);
    for (const std::uint32_t i : candidates)
      if (!is_copy(i) && is_heavy(i, is_copy)) {
        found_ = true;
        for (const std::uint32_t body : reached_) in_cluster_[body] = 1, sets_.join(i, body);
      }
  }

  /// Reaches the body and the lighter ones, as long as these together are light. Returns whether
  /// sweeps fail there.
  template <class IsCopy>
  bool is_heavy(std::uint32_t body, IsCopy& is_copy) {
    const real own = (*masses_)[body];
    real light = 0;
    bool open = false;
    std::size_t level_end = 1;
    int rows = 0;
    reached_.assign(1, body);
    met_[body] = body;
    for (std::size_t k = 0; k < reached_.size(); ++k) {
      if (k == level_end) level_end = reached_.size(), ++rows;
      for (std::size_t e = first_[reached_[k]]; e < first_[reached_[k] + 1]; ++e) {
        const std::uint32_t other = touching_[e];
        if (met_[other] == body || (*masses_)[other] >= own) continue;
        met_[other] = body;
        light += (*masses_)[other];
        if (part_ * heavy * light >= own) return false;
        open |= is_copy(other);
        reached_.push_back(other);
      }
    }
    return open || own * rows * rows > part_ * most_sweeps * light;
  }

  const plain_vector<real>* masses_ = nullptr;
  plain_vector<std::uint32_t> first_, touching_;  ///< of each body
  plain_vector<std::uint32_t> met_;               ///< the last body from which it was reached
  plain_vector<std::uint32_t> reached_;
  plain_vector<char> in_cluster_;
  disjoint_sets sets_;
  bool found_ = false;
  real part_ = 1;  ///< of the mass of light bodies that counts
};

}  // namespace talus::detail
