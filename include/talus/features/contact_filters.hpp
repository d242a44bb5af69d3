#pragma once
// features<contact_filters>: which bodies touch each other, by groups and masks of bodies and of
// materials, and by rules for pairs.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <utility>
#include <vector>

#include "talus/body/column.hpp"
#include "talus/body/material.hpp"
#include "talus/core/error.hpp"
#include "talus/core/id.hpp"
#include "talus/core/type_list.hpp"

namespace talus {

/// Column: the groups of a body, one for each bit. Bodies are in group 0.
struct contact_groups {
  using value_type = std::uint32_t;
  static constexpr const char* name = "contact_groups";
  static constexpr std::uint32_t initial = 1;
  static constexpr talus::travels travel = talus::travels::when_changed;
};
/// Column: the groups that a body may touch, one for each bit. Bodies may touch all groups.
struct contact_mask {
  using value_type = std::uint32_t;
  static constexpr const char* name = "contact_mask";
  static constexpr std::uint32_t initial = ~std::uint32_t{0};
  static constexpr talus::travels travel = talus::travels::when_changed;
};

/// The number of a group of bodies, from 0 to 31. The bit of contact_group{3} in contact_groups and
/// contact_mask is 1u << 3.
enum class contact_group : std::uint8_t {};

namespace detail {

/// Rules for pairs of numbers: pairs that ignore each other, and numbers that have contacts only
/// with some others.
class contact_rules {
  using pair = std::pair<std::uint64_t, std::uint64_t>;

 public:
  [[nodiscard]] bool empty() const { return ignored_.empty() && only_.empty(); }
  [[nodiscard]] std::size_t size() const { return ignored_.size() + only_.size(); }
  [[nodiscard]] bool allow(std::uint64_t a, std::uint64_t b) const {
    if (empty()) return true;
    const pair both(std::min(a, b), std::max(a, b));
    if (has(ignored_, both)) return false;
    return has(only_, both) || !(has(bound_, a) || has(bound_, b));
  }
  /// False if the rule is there already.
  bool ignore(std::uint64_t a, std::uint64_t b) {
    return insert(ignored_, pair(std::min(a, b), std::max(a, b)));
  }
  bool only(std::uint64_t a, std::uint64_t b) {
    insert(bound_, a), insert(bound_, b);
    return insert(only_, pair(std::min(a, b), std::max(a, b)));
  }
  /// Whether there is a rule for this very pair.
  [[nodiscard]] bool ignored(std::uint64_t a, std::uint64_t b) const {
    return has(ignored_, pair(std::min(a, b), std::max(a, b)));
  }
  [[nodiscard]] bool bound(std::uint64_t a, std::uint64_t b) const {
    return has(only_, pair(std::min(a, b), std::max(a, b)));
  }
  void clear() { ignored_.clear(), only_.clear(), bound_.clear(); }
  /// The largest number that a rule names; 0 without rules.
  [[nodiscard]] std::uint64_t largest() const {
    std::uint64_t most = bound_.empty() ? 0 : bound_.back();
    for (const auto& [a, b] : ignored_) most = std::max(most, b);
    return most;
  }
  /// The numbers that rules name, each once, in ascending order.
  [[nodiscard]] std::vector<std::uint64_t> named() const {
    std::vector<std::uint64_t> all = bound_;
    for (const auto& [a, b] : ignored_) all.push_back(a), all.push_back(b);
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    return all;
  }
  /// Forgets rules for numbers that are gone, given in ascending order. What may touch such a
  /// number alone touches nothing from then on.
  void forget(const std::vector<std::uint64_t>& gone) {
    std::erase_if(ignored_,
                  [&](const pair& p) { return has(gone, p.first) || has(gone, p.second); });
    std::erase_if(only_, [&](const pair& p) { return has(gone, p.first) && has(gone, p.second); });
    bound_.clear();
    for (const auto& [a, b] : only_) insert(bound_, a), insert(bound_, b);
  }

  /// For checkpoints: the rules as numbers, and back.
  [[nodiscard]] std::vector<std::uint64_t> numbers() const {
    std::vector<std::uint64_t> all{ignored_.size()};
    for (const auto* list : {&ignored_, &only_})
      for (const auto& [a, b] : *list) all.push_back(a), all.push_back(b);
    return all;
  }
  void set(const std::vector<std::uint64_t>& all) {
    clear();
    for (std::size_t k = 1; k + 1 < all.size(); k += 2)
      if (k / 2 < all[0])
        ignore(all[k], all[k + 1]);
      else
        only(all[k], all[k + 1]);
  }

 private:
  template <class T>
  [[nodiscard]] static bool has(const std::vector<T>& sorted, const T& one) {
    return std::binary_search(sorted.begin(), sorted.end(), one);
  }
  template <class T>
  static bool insert(std::vector<T>& sorted, const T& one) {
    const auto at = std::lower_bound(sorted.begin(), sorted.end(), one);
    if (at != sorted.end() && *at == one) return false;
    sorted.insert(at, one);
    return true;
  }

  std::vector<pair> ignored_, only_;  ///< the lesser number first; sorted
  std::vector<std::uint64_t> bound_;  ///< the numbers in only_; sorted
};

}  // namespace detail

/// Feature: pairs of bodies that do not touch, docs/features.md. Two bodies touch if
/// - the mask of each, `contact_mask`, has one of the groups of the other, `contact_groups`;
/// - the same holds for their materials;
/// - no rule for their groups, materials or ids excludes it.
/// All ranks call the functions of the state, world.feature<contact_filters>(), alike.
struct contact_filters {
  using talus_part_of = roles::features;
  static constexpr const char* name = "contact_filters";
  using columns = type_list<contact_groups, contact_mask>;

  /// The rules, and the groups and masks of materials.
  class state {
   public:
    /// Bodies of the groups, or of the materials, `a` and `b` do not touch each other; a == b: nor
    /// themselves. A body in several groups touches if some other group of it may.
    void ignore(contact_group a, contact_group b) { rule(0, bit(a), bit(b), false); }
    void ignore(material_id a, material_id b) { rule(1, number(a), number(b), false); }
    /// These two bodies do not touch each other: what keep_apart(world, a, b) calls on all ranks.
    void ignore(system_id a, system_id b) { rule(2, value_of(a), value_of(b), false); }
    /// What is in `a` touches what is in `b` and nothing else, and the other way round. Further
    /// calls with `a` or `b` add partners.
    void only_between(contact_group a, contact_group b) { rule(0, bit(a), bit(b), true); }
    void only_between(material_id a, material_id b) { rule(1, number(a), number(b), true); }
    /// These two bodies touch each other, and nothing else: what only_between(world, a, b) calls.
    void only_between(system_id a, system_id b) { rule(2, value_of(a), value_of(b), true); }
    /// The groups of a material and those that it may touch, one for each bit. Without this call a
    /// material is in group 0 and may touch all. Groups of materials are not those of bodies.
    void of_material(material_id m, std::uint32_t groups, std::uint32_t mask) {
      const std::size_t k = number(m);
      const masks before = masks_of(m), now{groups, mask};
      if (before.groups == now.groups && before.mask == now.mask) return;
      if (materials_.size() <= k) materials_.resize(k + 1);
      materials_[k] = now;
      note();
    }
    /// Removes all rules, and the groups and masks of materials; those of bodies remain.
    void clear() {
      bool any = !materials_.empty();
      for (auto& rules : rules_) any = any || !rules.empty(), rules.clear();
      if (!any) return;
      materials_.clear();
      note();
    }

    /// Throws invalid_argument for a rule on a material that does not exist.
    void require_materials(std::size_t known) const {
      const std::uint64_t largest = std::max<std::uint64_t>(
          rules_[1].largest(), materials_.empty() ? 0 : materials_.size() - 1);
      if (largest > 0 && largest >= known)
        detail::fail<std::invalid_argument>(
            "contact_filters has a rule on material {}, which is unknown to this world, which has "
            "{}: pass what world.material(...) returned",
            largest, known);
    }
    /// The bodies that rules name, in ascending order of their ids, where these have become twice
    /// as many since the last call of forget_bodies(); else none.
    [[nodiscard]] std::vector<std::uint64_t> bodies_to_look_for() const {
      if (rules_[2].size() < next_look_) return {};
      return rules_[2].named();
    }
    /// The number of rules for pairs of bodies.
    [[nodiscard]] std::size_t rules_of_bodies() const { return rules_[2].size(); }
    /// Forgets the rules of bodies that do not exist any more, in ascending order.
    void forget_bodies(const std::vector<std::uint64_t>& gone) {
      rules_[2].forget(gone);
      next_look_ = 2 * rules_[2].size() + least_look;
    }

    /// Grows with each change. A call that changes nothing wakes no body.
    [[nodiscard]] std::uint64_t revision() const { return revision_; }
    /// Whether two bodies may touch.
    template <class A, class B>
    [[nodiscard]] bool allow(const A& a, const B& b) const {
      const std::uint32_t groups_a = a.template get<contact_groups>(),
                          groups_b = b.template get<contact_groups>();
      if ((groups_a & b.template get<contact_mask>()) == 0 ||
          (groups_b & a.template get<contact_mask>()) == 0)
        return false;
      if (!rules_[0].empty() && !groups_touch(groups_a, groups_b)) return false;
      const masks of_a = masks_of(a.material()), of_b = masks_of(b.material());
      return (of_a.groups & of_b.mask) != 0 && (of_b.groups & of_a.mask) != 0 &&
             rules_[1].allow(number(a.material()), number(b.material())) &&
             rules_[2].allow(value_of(a.id()), value_of(b.id()));
    }

    /// What a checkpoint holds.
    void each_list(auto& visit) {
      const auto through = [&](std::vector<std::uint64_t> numbers, auto&& set) {
        const auto before = numbers;
        visit.alike(numbers);
        if (numbers != before) set(numbers), note();
      };
      std::vector<std::uint64_t> of_materials;
      for (const masks& m : materials_)
        of_materials.push_back(std::uint64_t{m.groups} << 32 | m.mask);
      through(of_materials, [&](const auto& numbers) {
        materials_.clear();
        for (const std::uint64_t m : numbers)
          materials_.push_back(
              {static_cast<std::uint32_t>(m >> 32), static_cast<std::uint32_t>(m)});
      });
      for (auto& rules : rules_)
        through(rules.numbers(), [&](const auto& numbers) { rules.set(numbers); });
    }

   private:
    struct masks {
      std::uint32_t groups = 1, mask = ~std::uint32_t{0};
    };
    static std::uint64_t number(material_id m) { return static_cast<std::uint64_t>(m); }
    static std::uint64_t bit(contact_group g) {
      if (const auto k = static_cast<unsigned>(g); k > 31)
        detail::fail<std::invalid_argument>(
            "contact_filters has the groups 0 to 31, and {} is not one of them: number the groups "
            "from 0",
            k);
      return static_cast<std::uint64_t>(g);
    }
    [[nodiscard]] masks masks_of(material_id m) const {
      return number(m) < materials_.size() ? materials_[number(m)] : masks();
    }
    [[nodiscard]] bool groups_touch(std::uint32_t a, std::uint32_t b) const {
      for (std::size_t g = 0; g < 32; ++g)
        if ((a >> g & 1) != 0 && (touched_[g] & b) != 0) return true;
      return false;
    }
    void rule(std::size_t kind, std::uint64_t a, std::uint64_t b, bool only) {
      if (only ? rules_[kind].ignored(a, b) : rules_[kind].bound(a, b)) {
        constexpr const char* kinds[] = {"groups", "materials", "bodies"};
        detail::fail<std::invalid_argument>(
            "contact_filters was told that the {} {} and {} ignore each other, and that they touch "
            "each other and nothing else: leave one of the two rules out, or call clear() between "
            "them",
            kinds[kind], a, b);
      }
      if (only ? rules_[kind].only(a, b) : rules_[kind].ignore(a, b)) note();
    }
    void note() {
      ++revision_;
      for (std::size_t g = 0; g < 32; ++g) {
        touched_[g] = 0;
        for (std::size_t h = 0; h < 32; ++h)
          touched_[g] |= std::uint32_t{rules_[0].allow(g, h)} << h;
      }
    }

    std::array<detail::contact_rules, 3> rules_;  ///< of groups, materials and ids
    std::array<std::uint32_t, 32> touched_{};     ///< by the rules, for each group
    std::vector<masks> materials_;
    std::uint64_t revision_ = 0;
    static constexpr std::size_t least_look = 64;
    std::size_t next_look_ = least_look;  ///< number of rules at which gone bodies are looked for
  };

  struct hooks {
    static bool may_touch(const auto& pair) { return pair.state().allow(pair.a(), pair.b()); }
  };
};

}  // namespace talus
