#pragma once
// The contacts of some pairs of bodies in the step under way, without a search for pairs.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>
#include <vector>

#include "talus/core/id.hpp"
#include "talus/core/type_list.hpp"
#include "talus/step/soft_step.hpp"
#include "talus/world/each_contact.hpp"

namespace talus::detail {

/// Pairs of bodies in ascending order, each once and with the lesser id first.
using chosen_pairs = std::vector<std::pair<system_id, system_id>>;

/// Evaluates soft contacts of pairs by the indices of their bodies. A body and its images are
/// several.
template <class Scenario, class Observer>
class chosen_forces {
  using state_type = world_state<Scenario>;
  struct place {
    system_id id = no_id;
    std::uint32_t shape = 0, index = 0;
    bool global = false;
  };

 public:
  chosen_forces(state_type& s, const chosen_pairs& pairs, Observer& observer)
      : s_(s), observer_(observer) {
    std::vector<system_id> ids;
    for (const auto& [a, b] : pairs) ids.push_back(a), ids.push_back(b);
    std::sort(ids.begin(), ids.end());
    std::uint32_t shape = 0;
    const auto note = [&](const auto& store, bool global) {
      for (std::size_t i = 0; i < store.size(); ++i)
        if (std::binary_search(ids.begin(), ids.end(), store.id[i]))
          places_.push_back({store.id[i], shape, static_cast<std::uint32_t>(i), global});
    };
    s.each_shape([&](const auto& b) { note(b.movable, false), note(b.global, true), ++shape; });
    std::stable_sort(places_.begin(), places_.end(),
                     [](const place& x, const place& y) { return x.id < y.id; });
    for (const auto& [a, b] : pairs)
      each_of(a, [&](const place& one) {
        each_of(b, [&](const place& other) { evaluate(one, other); });
      });
  }

 private:
  template <class F>
  void each_of(system_id id, F&& f) const {
    auto at = std::lower_bound(places_.begin(), places_.end(), id,
                               [](const place& p, system_id wanted) { return p.id < wanted; });
    for (; at != places_.end() && at->id == id; ++at) f(*at);
  }
  template <class F>
  void with_shape(std::uint32_t number, F&& f) {
    std::uint32_t k = 0;
    s_.each_shape([&](auto& b) {
      if (k++ == number)
        f.template operator()<typename std::remove_cvref_t<decltype(b)>::shape_type>();
    });
  }
  void evaluate(const place& x, const place& y) {
    with_shape(x.shape, [&]<class X>() {
      with_shape(y.shape, [&]<class Y>() {
        constexpr bool in_order =
            index_of<typename Scenario::shapes, X> <= index_of<typename Scenario::shapes, Y>;
        if (!x.global && !y.global) {
          if constexpr (X::finite && Y::finite) {
            if constexpr (in_order)
              add<X, Y, partner::moving>(x, y);
            else
              add<Y, X, partner::moving>(y, x);
          }
        } else if (!x.global) {
          if constexpr (X::finite) add<X, Y, partner::immovable>(x, y);
        } else if (!y.global) {
          if constexpr (Y::finite) add<Y, X, partner::immovable>(y, x);
        }
      });
    });
  }
  template <class A, class B, partner P>
  void add(const place& a, const place& b) {
    force_adder<Scenario, A, B, P, Observer>(s_, observer_)(a.index, b.index, 0, 0);
  }

  state_type& s_;
  Observer& observer_;
  std::vector<place> places_;
};

/// At after_solve: calls f(contact, counts_here), as each_loaded_contact(), for the contacts of
/// these pairs. No rank waits for another.
template <class Scenario, class F>
void each_chosen_contact(world_state<Scenario>& s, const body_places<Scenario>& places,
                         const chosen_pairs& pairs, F&& f) {
  if (pairs.empty()) return;
  if constexpr (Scenario::contact_law::soft) {
    auto observer = soft_reporter(s, places, f);
    chosen_forces<Scenario, decltype(observer)>(s, pairs, observer);
  } else {
    each_loaded_contact(s, places, f, [&](const contact_key& k) {
      return std::binary_search(pairs.begin(), pairs.end(),
                                std::pair(std::min(k.a, k.b), std::max(k.a, k.b)));
    });
  }
}

}  // namespace talus::detail
