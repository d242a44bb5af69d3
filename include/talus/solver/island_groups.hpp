#pragma once
// Sweeps that go through groups of islands one after the other, all sweeps of a group at once.
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <type_traits>

#include "talus/constraint/joint_in_list.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/core/each.hpp"
#include "talus/solver/contact_list.hpp"

namespace talus::detail {

template <class List>
inline constexpr bool grouped_list = grouped<typename std::remove_cvref_t<List>::contact_type>;
/// Whether some of a tuple of lists can be swept by groups.
template <class Lists>
inline constexpr bool has_grouped = false;
template <class... List>
inline constexpr bool has_grouped<std::tuple<List...>> = (grouped_list<List> || ...);

/// Islands do not act on each other, so that the order in which they are swept changes no bit. The
/// data of a group stay in the cache during its sweeps; those of all contacts of a large scene are
/// read from memory once in each sweep. Only on a single rank without joints, and while all
/// contacts are of kinds that are swept in manifolds.
template <class Lists, class State, bool Alone>
class island_groups {
  static constexpr bool possible = Alone && !has_joints<Lists> && has_grouped<Lists>;

 public:
  /// Finds the groups, before the contacts are prepared.
  static void find(const Lists& lists, State& s) {
    s.groups.clear();
    if constexpr (possible) {
      std::size_t contacts = 0, others = 0;
      each_of(lists, [&]<class List>(const List& list) {
        (grouped_list<List> ? contacts : others) += list.size();
      });
      if (others > 0 || contacts < least_contacts) return;
      const auto moves = [&](std::int32_t i) {
        return s.bodies[static_cast<std::size_t>(i)].inverse_mass != 0;
      };
      s.groups.find(s.bodies.size(), manifolds, [&](auto&& f) {
        each_grouped(lists, [&](const auto& list) {
          list.each_manifold([&](const auto& c) {
            const bool a = moves(c.a), b = paired(c) && moves(c.b);
            a ? f(c.a, b ? c.b : -1) : f(c.b, -1);
          });
        });
      });
      if (s.groups.size() < 2) s.groups.clear();
    }
  }
  /// The sweeps [first, last). Returns whether there are groups.
  static bool sweep(Lists& lists, State& s, int first, int last) {
    if constexpr (possible)
      for (std::size_t g = 0; g < s.groups.size(); ++g)
        for (int k = first; k < last; ++k)
          each_grouped(lists, [&](auto& list) { list.sweep_group(g, k % 2 == 0, s); });
    return s.groups.size() > 0;
  }
  /// All sweeps of the position correction. Returns whether there are groups.
  static bool correct(Lists& lists, State& s, int sweeps) {
    if constexpr (possible)
      for (std::size_t g = 0; g < s.groups.size(); ++g)
        for (int k = 0; k < sweeps; ++k)
          each_grouped(lists, [&](auto& list) { list.correct_group(g, k == 0, s); });
    return s.groups.size() > 0;
  }

 private:
  /// The prepared contacts of fewer fit the second-level cache of one core.
  static constexpr std::size_t least_contacts = 4000;
  static constexpr std::uint32_t manifolds = 256;  ///< of a group, about a thousand contacts

  template <class Each, class F>
  static void each_grouped(Each& lists, F&& f) {
    each_of(lists, [&]<class List>(List& list) {
      if constexpr (grouped_list<List>)
        if (list.size() > 0) f(list);
    });
  }
  template <class Contact>
  static constexpr bool paired(const Contact&) {
    return Contact::paired;
  }
};

}  // namespace talus::detail
