#pragma once
// The bodies that a rank knows, by their ids.
#include <cstddef>
#include <cstdint>
#include <utility>

#include "talus/core/id_table.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// The index of the bodies known to this rank.
template <class Scenario>
class body_places {
 public:
  struct place {
    std::uint32_t shape = 0, index = 0;
    bool global = false;
  };

  explicit body_places(world_state<Scenario>& s) : s_(s) {
    std::size_t all = 0;
    s.each_shape([&](const auto& b) { all += b.movable.size() + b.global.size(); });
    ids_.reset(all);
    places_.reserve(all);
    std::uint32_t shape = 0;
    const auto add = [&](const auto& store, bool global) {
      for (std::size_t i = 0; i < store.size(); ++i) {
        ids_.add(store.id[i]);
        places_.push_back({shape, static_cast<std::uint32_t>(i), global});
      }
    };
    s.each_shape([&](const auto& b) { add(b.movable, false), add(b.global, true), ++shape; });
  }

  [[nodiscard]] const world_state<Scenario>& state() const { return s_; }
  /// Number of bodies known here.
  [[nodiscard]] std::size_t size() const { return places_.size(); }
  /// Index of a body among these, or id_table::unknown. If images of a body are known too, the
  /// index of the body itself.
  [[nodiscard]] std::uint32_t number_of(system_id id) const { return ids_.find(id); }
  /// Calls f(store, index, is global) for the body; false if it is unknown.
  template <class F>
  bool visit(system_id id, F&& f) const {
    const std::uint32_t at = ids_.find(id);
    if (at == id_table::unknown) return false;
    visit_number(at, f);
    return true;
  }
  /// Calls f(store, index, is global) for the body with this index among all bodies known here.
  template <class F>
  void visit_number(std::size_t number, F&& f) const {
    const place p = places_[number];
    std::uint32_t shape = 0;
    std::as_const(s_).each_shape([&](const auto& b) {
      if (shape++ == p.shape) f(p.global ? b.global : b.movable, std::size_t{p.index}, p.global);
    });
  }

 private:
  world_state<Scenario>& s_;
  id_table ids_;
  plain_vector<place> places_;
};

}  // namespace talus::detail
