#pragma once
// The order in which pair forces are added to bodies: for each body by the id of its partner, so
// that the sums have the same bits on any number of ranks.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "talus/core/id.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/state/candidate_pairs.hpp"
#include "talus/state/periodic_ghosts.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// A pair of bodies as an edge of a graph, by the numbers of both and their ids. The second body is
/// `nobody` if no force is added to it.
struct pair_edge {
  std::uint32_t a = 0, b = 0;
  system_id id_a{}, id_b{};
};

/// Orders edges so that each body has its edges by ascending ids of their other ends. Sorting all
/// edges by both ids would do; this order follows the neighbourhood of the bodies instead: an edge
/// is next if it is the next one of both its bodies, and the search continues from there.
class edges_by_partner {
 public:
  /// The order: indices of the edges.
  [[nodiscard]] const plain_vector<std::uint32_t>& order(std::span<const pair_edge> edges,
                                                         std::size_t bodies) {
    list_edges_of_bodies(edges, bodies);
    order_.clear();
    next_.assign(bodies, 0);
    for (std::size_t body = 0; body < bodies; ++body) {
      open_.push_back(static_cast<std::uint32_t>(body));
      while (!open_.empty()) {
        const std::uint32_t v = open_.back();
        if (is_finished(v)) {
          open_.pop_back();
          continue;
        }
        const std::uint32_t e = next_of(v);
        const std::uint32_t other = edges[e].a == v ? edges[e].b : edges[e].a;
        const bool ready = other == nobody || other == v || next_of(other) == e;
        if (!ready) {
          open_.pop_back();  // revisited when the other body has reached this edge
          continue;
        }
        order_.push_back(e);
        ++next_[v];
        if (other != nobody && other != v) ++next_[other], open_.push_back(other);
      }
    }
    return order_;
  }

 private:
  struct end {
    system_id partner{};
    std::uint32_t edge = 0;
  };

  void list_edges_of_bodies(std::span<const pair_edge> edges, std::size_t bodies) {
    first_.assign(bodies + 1, 0);
    const auto each_end = [&](auto&& f) {
      for (std::size_t e = 0; e < edges.size(); ++e) {
        const pair_edge& edge = edges[e];
        f(edge.a, edge.id_b, e);
        if (edge.b != nobody && edge.b != edge.a) f(edge.b, edge.id_a, e);
      }
    };
    each_end([&](std::uint32_t v, system_id, std::size_t) { ++first_[v + 1]; });
    for (std::size_t v = 0; v < bodies; ++v) first_[v + 1] += first_[v];
    ends_.resize(first_[bodies]);
    next_.assign(bodies, 0);
    each_end([&](std::uint32_t v, system_id partner, std::size_t e) {
      ends_[first_[v] + next_[v]++] = {partner, static_cast<std::uint32_t>(e)};
    });
    for (std::size_t v = 0; v < bodies; ++v)
      std::sort(ends_.begin() + first_[v], ends_.begin() + first_[v + 1],
                [](const end& x, const end& y) {
                  return x.partner != y.partner ? x.partner < y.partner : x.edge < y.edge;
                });
  }
  [[nodiscard]] bool is_finished(std::uint32_t v) const {
    return first_[v] + next_[v] == first_[v + 1];
  }
  /// The next edge of a body; none if it is finished.
  [[nodiscard]] std::uint32_t next_of(std::uint32_t v) const {
    return is_finished(v) ? nobody : ends_[first_[v] + next_[v]].edge;
  }

  plain_vector<std::uint32_t> first_, next_, open_, order_;
  plain_vector<end> ends_;
};

/// Sorts the pairs of two shapes in that order.
template <class A, class B, bool Moving, class Scenario>
void order_pairs(const world_state<Scenario>& s, edges_by_partner& by_partner,
                 plain_vector<close_pair>& pairs) {
  const auto& a = s.template of<A>().movable;
  const auto& of_b = s.template of<B>();
  const auto& b = Moving ? of_b.movable : of_b.global;
  constexpr bool one_shape = Moving && std::is_same_v<A, B>;
  // An image of a body that is owned here stands for the body itself.
  const auto body = [&]<class Shape>(std::uint32_t i) {
    if constexpr (world_state<Scenario>::periodic)
      if (const image_copy* copy = copy_of<Shape>(s, i); copy && copy->own != image_copy::not_own)
        return copy->own;
    return i;
  };
  plain_vector<pair_edge> edges;
  edges.reserve(pairs.size());
  for (const close_pair& p : pairs) {
    pair_edge e{body.template operator()<A>(p.i), nobody, a.id[p.i], b.id[p.j]};
    if constexpr (Moving)
      e.b =
          body.template operator()<B>(p.j) + (one_shape ? 0 : static_cast<std::uint32_t>(a.size()));
    edges.push_back(e);
  }
  const std::size_t bodies = a.size() + (Moving && !one_shape ? b.size() : 0);
  plain_vector<close_pair> ordered;
  ordered.reserve(pairs.size());
  for (const std::uint32_t e : by_partner.order(edges, bodies)) ordered.push_back(pairs[e]);
  pairs.swap(ordered);
}

}  // namespace talus::detail
