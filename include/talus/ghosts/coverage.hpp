#pragma once
// Large bodies: whether the connections cover everything that a body can touch. Contacts between
// unconnected ranks would be lost silently.
#include <algorithm>
#include <limits>

#include "talus/detect/narrow.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// The smallest reach for which a partition makes ranks `a` and `b` neighbours, to 0.1 %.
template <class Partition>
[[nodiscard]] real reach_between(const Partition& cells, int a, int b) {
  const auto near = [&](real reach) {
    const auto all = cells.neighbours(a, reach);
    return std::binary_search(all.begin(), all.end(), b);
  };
  if (near(0)) return 0;
  real high = 1;
  while (!near(high) && high < 1e100) high *= 2;
  real low = high / 2;
  while (near(low) && low > 1e-100) low /= 2, high /= 2;
  while (high - low > 1e-3 * high) (near(0.5 * (low + high)) ? high : low) = 0.5 * (low + high);
  return high;
}

/// The advice that connects two ranks.
template <class Scenario>
[[nodiscard]] std::string way_to_connect(const rank_state<Scenario>& s, int a, int b) {
  if constexpr (requires { s.own.partition()->neighbours(0, real{}); })
    if (s.own.partition() != nullptr)
      return compose(
          "these ranks are {} apart, so give the decomposition a reach of that length, "
          "or call connect on both",
          text(reach_between(*s.own.partition(), a, b), 4));
  return "call connect on both";
}

/// Throws runtime_error if a body in this domain, which acts `range` beyond touch, reaches the
/// region of a rank that is not connected to this one. (With connections made by hand, such ranks
/// are unknown here.)
template <class Shape, class Scenario>
void require_reached(const rank_state<Scenario>& s, system_id id, const Shape& shape, const vec3& p,
                     real range = 0) {
  if constexpr (requires { s.own.partition()->neighbours(0, real{}); }) {
    const real reach = shape.bounding_radius() + range;
    if (reach <= s.own.covered() || !s.own.contains(p)) return;
    const int own = s.own.rank();
    for (const int other : s.own.partition()->neighbours(own, reach)) {
      if (s.own.find(other) != nullptr || s.own.closed_to(other)) continue;
      const real distance = -any_geometry(s.own.partition()->geometry(other)).value(p);
      if (distance > reach) continue;
      fail<std::runtime_error>(
          "the {} {} at {}, owned by rank {}, reaches {} far, into the domain of rank {}, and "
          "ranks {} and {} are not connected, so contacts there would be lost: {}",
          Shape::name, id, text(p), own, text(reach, 4), other, own, other,
          way_to_connect(s, own, other));
    }
  }
}

/// Neighbours exchange the lists of their connections. Collective among neighbours.
template <class Scenario>
void share_connections(rank_state<Scenario>& s) {
  std::vector<int> ranks;
  for (const auto& n : s.neighbours) ranks.push_back(n.rank);
  for (neighbour_message& p : s.neighbour_messages) {
    p.out.clear();
    byte_writer(p.out).put(std::span<const int>(ranks));
  }
  s.link->start(s.neighbour_messages);
  s.link->finish(s.neighbour_messages);
  for (std::size_t n = 0; n < s.neighbour_messages.size(); ++n)
    s.neighbours[n].connected = byte_reader(s.neighbour_messages[n].in).template get_all<int>();
  s.strangers = false;
  for (const auto& a : s.neighbours)
    for (const auto& b : s.neighbours)
      if (a.rank < b.rank && !std::binary_search(a.connected.begin(), a.connected.end(), b.rank))
        s.strangers = true;
}

/// The neighbour that owns a shadow copy.
template <class Shape, class Scenario>
[[nodiscard]] std::size_t neighbour_of_copy(const population<Scenario>& s, std::size_t copy) {
  using shapes = typename state_traits<Scenario>::finite_shapes;
  std::size_t last = s.template of<Shape>().movable.locals, n = 0;
  for (; n < s.neighbours.size(); ++n) {
    last += s.neighbours[n].copies[index_of<shapes, Shape>];
    if (copy < last) break;
  }
  return n;
}

/// Throws runtime_error if two shadow copies touch, or will touch in this step by motion of at most
/// `way`, and their owners are not connected.
template <class Scenario, class A, class B>
void require_acquainted(const world_state<Scenario>& s, std::size_t i, std::size_t j,
                        real way = 0) {
  const auto& a = s.template of<A>().movable;
  const auto& b = s.template of<B>().movable;
  const auto& owner_a = s.neighbours[neighbour_of_copy<A>(s, i)];
  const auto& owner_b = s.neighbours[neighbour_of_copy<B>(s, j)];
  if (owner_a.rank == owner_b.rank ||
      std::binary_search(owner_a.connected.begin(), owner_a.connected.end(), owner_b.rank))
    return;
  if (a.inverse_mass[i] == 0 && b.inverse_mass[j] == 0) return;
  const real slack = contact_slack * (a.shape[i].bounding_radius() + b.shape[j].bounding_radius());
  const real falls =
      2 * s.gravity.norm() * s.dt * s.dt + way_of_turning(a, i, s.dt) + way_of_turning(b, j, s.dt);
  const auto velocity = [](const auto& store, std::size_t k, const vec3& point) {
    return vec3(store.velocity[k] +
                store.angular_velocity[k].cross(vec3(point - store.position[k])));
  };
  collide_pair(a.shape[i], a.pose(i), b.shape[j], b.pose(j), std::max(slack, way),
               [&](const contact_geometry& g) {
                 const vec3 v = velocity(a, i, g.point) - velocity(b, j, g.point);
                 if (g.gap > slack && g.gap + s.dt * v.dot(g.normal) - falls > slack) return;
                 fail<std::runtime_error>(
                     "rank {} sees the {} {} of rank {} and the {} {} of rank {} meet at {}, but "
                     "these ranks "
                     "are not connected, so the contact would be lost: {}",
                     s.link->rank(), A::name, a.id[i], owner_a.rank, B::name, b.id[j], owner_b.rank,
                     text(g.point), way_to_connect(s, owner_a.rank, owner_b.rank));
               });
}

}  // namespace talus::detail
