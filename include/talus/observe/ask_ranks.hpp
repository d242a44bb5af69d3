#pragma once
// How questions travel: to the ranks whose bodies they may meet, in one message between each two
// ranks, and the answers back in another.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/core/neighbour_message.hpp"
#include "talus/detect/narrow.hpp"
#include "talus/observe/asked_bodies.hpp"
#include "talus/world/state_of.hpp"
#include "talus/world/world.hpp"

namespace talus::detail {

enum class query_kind { first, all, overlaps, nearest };

// What a question is asked with: a point or a shape. `meets` is what it meets of a body.
struct point_probe {
  [[nodiscard]] vec3 reach(const question&) const { return {0, 0, 0}; }
  template <class B>
  [[nodiscard]] surface_hit meets(const B& b, const pose& at, const vec3& from, const question& q,
                                  real length) const {
    return ray_meets(b, at, from, q.direction, length);
  }
};
template <class Shape>
struct shape_probe {
  Shape shape;
  [[nodiscard]] vec3 reach(const question& q) const {
    return shape.half_extents(pose{{0, 0, 0}, q.turn});
  }
  template <class B>
  [[nodiscard]] surface_hit meets(const B& b, const pose& at, const vec3& from, const question& q,
                                  real length) const {
    return shape_meets(shape, pose{from, q.turn}, b, at, q.direction, length);
  }
};
template <class Shape>
struct overlap_probe {
  Shape shape;
  [[nodiscard]] vec3 reach(const question& q) const {
    return shape.half_extents(pose{{0, 0, 0}, q.turn});
  }
  template <class B>
  [[nodiscard]] surface_hit meets(const B& b, const pose& at, const vec3& from, const question& q,
                                  real) const {
    surface_hit deepest;
    if constexpr (collidable<Shape, B>)
      collide_pair(shape, pose{from, q.turn}, b, at, 0, [&](const contact_geometry& c) {
        if (c.gap < 0 && c.gap < deepest.distance) deepest = {c.gap, c.point, c.normal, false};
      });
    return deepest;
  }
};

struct numbered_hit {
  std::uint32_t number = 0;
  query_hit hit;
};
/// The box around the bodies of a rank, and their number.
struct asked_rank {
  bounds_tree::bounds around;
  std::uint64_t bodies = 0;
};

/// Collective: the bytes of each rank. All ranks throw alike if one has a fault, or calls another
/// query.
template <class Scenario>
[[nodiscard]] std::vector<byte_buffer> agree_on_query(world<Scenario>& w, std::string_view what,
                                                      const std::string& fault,
                                                      const byte_buffer& mine) {
  byte_buffer bytes;
  byte_writer out(bytes);
  out.put(std::span<const char>(what)), out.put(std::span<const char>(fault));
  out.put(std::span<const std::byte>(mine));
  std::vector<byte_buffer> all;
  std::string first_fault, first_name;
  for (const byte_buffer& theirs : w.link().gather_all(bytes)) {
    byte_reader in(theirs);
    const auto text = [&] {
      const auto letters = in.template get_all<char>();
      return std::string(letters.begin(), letters.end());
    };
    const std::string name = text(), said = text();
    if (all.empty()) first_name = name;
    if (name != first_name)
      fail<std::runtime_error>(
          "rank 0 called {} while rank {} called {}: all ranks call a query together, those "
          "without "
          "questions with an empty list",
          first_name, all.size(), name);
    if (first_fault.empty()) first_fault = said;
    const auto content = in.template get_all<std::byte>();
    all.emplace_back(content.begin(), content.end());
  }
  if (!first_fault.empty()) throw std::invalid_argument(first_fault);
  return all;
}

/// The answer of the bodies of this rank, or of the global ones.
template <query_kind What, class Probe, class Bodies>
void answer(const Probe& probe, Bodies& bodies, const question& q, const query_filter& filter,
            bool global, std::vector<query_hit>& out) {
  constexpr bool single = What == query_kind::first || What == query_kind::nearest;
  query_hit best;
  const std::size_t before = out.size();
  const auto take = [&](const query_hit& hit) -> real {
    if constexpr (single) {
      if (hit < best) best = hit;
      return std::min(q.length, best.distance);
    } else {
      if constexpr (What ==
                    query_kind::overlaps)  // of images of a body that both overlap, the deeper
        for (std::size_t k = before; k < out.size(); ++k)
          if (out[k].id == hit.id) {
            if (hit < out[k]) out[k] = hit;
            return q.length;
          }
      out.push_back(hit);
      return q.length;
    }
  };
  if constexpr (What == query_kind::nearest) {
    bodies.near(
        q, filter, global,
        [](const auto& b, const pose& at, const vec3& from, real within) {
          return nearest_on_shape(b, at, from, within);
        },
        take);
  } else {
    const auto meet = [&](const auto& b, const pose& at, const vec3& from, real length) {
      return probe.meets(b, at, from, q, length);
    };
    if (global)
      bodies.global_along(q, filter, probe.reach(q), meet, take);
    else
      bodies.own_along(q, filter, probe.reach(q), meet, take);
  }
  if (single && best) out.push_back(best);
}

/// Which ranks may have what a question looks for.
template <query_kind What, class Bodies>
class asked_ranks {
 public:
  asked_ranks(const Bodies& bodies, const std::vector<asked_rank>& ranks, bool all_pass)
      : bodies_(bodies), ranks_(ranks), all_pass_(all_pass) {}

  /// Calls f(rank) for each.
  template <class F>
  void each(const question& q, const vec3& reach, F&& f) const {
    const real limit = What == query_kind::nearest ? farthest(q) : 0;
    for (std::size_t r = 0; r < ranks_.size(); ++r) {
      const auto& box = ranks_[r].around;
      if (box.empty()) continue;
      if (What == query_kind::nearest ? away(q, box) <= limit : on_the_way(q, box, reach)) f(r);
    }
  }

 private:
  /// Some body is as near as this: a rank has a body that the filter lets through somewhere in its
  /// box.
  [[nodiscard]] real farthest(const question& q) const {
    real least = q.length;
    const vec3 home = bodies_.wrapped(q.from);
    if (all_pass_)
      for (const asked_rank& r : ranks_)
        if (r.bodies > (q.except == no_id ? 0u : 1u))
          least = std::min(least, (home - r.around.lower)
                                      .cwiseAbs()
                                      .cwiseMax((home - r.around.upper).cwiseAbs())
                                      .norm());
    return (1 + cast_tolerance) * least;
  }
  [[nodiscard]] real away(const question& q, const bounds_tree::bounds& box) const {
    real least = endless;
    const vec3 home = bodies_.wrapped(q.from);
    bodies_.each_image_beside([&](const vec3& shift) {
      least = std::min(least, square_to_bounds(box.lower, box.upper, home - shift));
    });
    return std::sqrt(least);
  }
  [[nodiscard]] bool on_the_way(const question& q, const bounds_tree::bounds& box,
                                const vec3& reach) const {
    bool met = false;
    const vec3 lower = box.lower - reach, upper = box.upper + reach;
    each_image_along(bodies_.period(), q.from, q.direction, q.length, lower, upper,
                     [&](const vec3& shift, real, real) {
                       const chord c = chord_of_bounds(lower, upper, q.from - shift, q.direction);
                       met = met || (c.from <= c.to && c.to >= 0 && c.from <= q.length);
                     });
    return met;
  }

  const Bodies& bodies_;
  const std::vector<asked_rank>& ranks_;
  bool all_pass_;
};

/// Collective: the answers to the questions of this rank, numbered from 0, each sorted.
template <query_kind What, class Probe, class Scenario>
[[nodiscard]] std::vector<std::vector<query_hit>> ask(world<Scenario>& w, const char* what,
                                                      const query_filter& filter,
                                                      const Probe& probe,
                                                      const std::vector<question>& questions,
                                                      const std::string& fault) {
  w.require_all_ranks(what);
  asked_bodies<Scenario> bodies(view_of(w));
  byte_buffer mine;
  byte_writer(mine).put(asked_rank{bodies.around(), bodies.owned()});
  std::vector<asked_rank> ranks;
  for (const byte_buffer& theirs : agree_on_query(w, what, fault, mine)) {
    byte_reader in(theirs);
    ranks.push_back(in.template get<asked_rank>());
  }

  std::vector<std::vector<question>> of_rank(ranks.size());
  const asked_ranks<What, asked_bodies<Scenario>> where(bodies, ranks, filter == query_filter{});
  for (const question& q : questions)
    where.each(q, probe.reach(q), [&](std::size_t r) { of_rank[r].push_back(q); });
  const auto here = static_cast<std::size_t>(w.rank());
  std::vector<neighbour_message> messages;
  for (std::size_t r = 0; r < ranks.size(); ++r) {
    if (r == here) continue;
    messages.push_back({.rank = static_cast<int>(r)});
    if (of_rank[r].empty()) continue;
    byte_writer out(messages.back().out);
    out.put(filter);
    if constexpr (requires { probe.shape; }) out.put(probe.shape);
    out.put(std::span<const question>(of_rank[r]));
  }
  const auto exchange = [&] {
    if (messages.empty()) return;
    w.link().start(messages);
    w.link().finish(messages);
  };
  exchange();

  for (neighbour_message& m : messages) {
    if (m.in.empty()) continue;
    byte_reader in(m.in);
    const auto theirs = in.template get<query_filter>();
    Probe asked = probe;
    if constexpr (requires { probe.shape; })
      asked.shape = in.template get<std::remove_cvref_t<decltype(probe.shape)>>();
    std::vector<numbered_hit> found;
    std::vector<query_hit> hits;
    for (const question& q : in.template get_all<question>()) {
      hits.clear();
      answer<What>(asked, bodies, q, theirs, false, hits);
      for (const query_hit& hit : hits) found.push_back({q.number, hit});
    }
    if (!found.empty()) byte_writer(m.out).put(std::span<const numbered_hit>(found));
  }
  exchange();

  std::vector<std::vector<query_hit>> all(questions.size());
  for (const question& q : of_rank[here])
    answer<What>(probe, bodies, q, filter, false, all[q.number]);
  for (const question& q : questions) answer<What>(probe, bodies, q, filter, true, all[q.number]);
  for (neighbour_message& m : messages) {
    if (m.in.empty()) continue;
    byte_reader in(m.in);
    for (const numbered_hit& one : in.template get_all<numbered_hit>())
      all[one.number].push_back(one.hit);
  }
  for (auto& hits : all) std::sort(hits.begin(), hits.end());
  return all;
}

}  // namespace talus::detail
