#pragma once
// What a rank shows of its world in the viewer's page: bodies, contacts, joints, its domain.
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <type_traits>

#include "talus/geometry/any_geometry.hpp"
#include "talus/io/detail/shape_numbers.hpp"
#include "talus/io/detail/shape_surface.hpp"
#include "talus/io/detail/view_part.hpp"
#include "talus/shape/frame.hpp"
#include "talus/shape/union_of.hpp"
#include "talus/world/each_contact.hpp"
#include "talus/world/world.hpp"

namespace talus::detail {

/// Whether the page has to contain the faces of a shape, because a size does not describe it.
template <class Shape>
inline constexpr bool view_needs_form = [] {
  constexpr std::string_view name = Shape::name;
  return has_surface<Shape> && name != "box" && name != "capsule" && name != "cylinder";
}();

/// Makes the contributions of one rank, frame after frame.
class view_writer {
 public:
  /// The present state. No rank waits for another.
  template <class Scenario>
  [[nodiscard, gnu::cold]] view_part part_of(world<Scenario>& w) {
    view_part out;
    numbers_ = shape_numbers(typename Scenario::shapes{});
    const auto& s = view_of(w);
    const stage_seconds t = w.stage_times();
    out.seconds = {t.detect, t.respond, t.integrate, t.exchange};
    s.each_shape([&](const auto& b) {
      const auto add = [&](const auto& store, std::size_t end, bool global) {
        for (std::size_t i = 0; i < end; ++i) {
          if (store.flags[i] & flag_invisible) continue;
          view_body one = body_of(store, i, w.rank(), global);
          one.mass = static_cast<float>(mass_of(store, i, s.materials));
          add_body(out, store, i, one);
        }
      };
      add(b.movable, b.movable.locals, false);
      if (w.rank() == 0) add(b.global, b.global.size(), true);
    });
    for_each_contact(w, [&](const loaded_contact& c) {
      out.contacts.push_back({c.a, c.b, c.feature, c.point, c.force});
    });
    if constexpr (world_state<Scenario>::has_joints) add_joints(out, s);
    if (w.ranks() > 1) add_domain(out, w);
    return out;
  }

 private:
  template <class Store>
  [[nodiscard]] static view_body body_of(const Store& store, std::size_t i, int rank, bool global) {
    view_body b;
    b.id = store.id[i], b.rank = static_cast<std::uint32_t>(rank);
    b.flags = global ? view_wall | view_global : store.fixed(i) ? view_wall : 0;
    b.asleep = store.asleep(i);
    b.material = static_cast<std::uint16_t>(store.material[i]);
    b.position = store.position[i];
    if (!global) b.velocity = store.velocity[i];
    return b;
  }
  template <class Store>
  void add_body(view_part& out, const Store& store, std::size_t i, view_body& b) {
    using shape = typename Store::shape_type;
    if constexpr (!shape::finite) {
      const vec3 n = store.shape[i].unit_normal();
      b.shape = view_shape::plane;
      b.position = store.shape[i].offset * n;
      b.orientation =
          n[2] > real(-0.999999) ? quat(1 + n[2], -n[1], n[0], 0).normalized() : quat(0, 1, 0, 0);
      out.bodies.push_back(b);
    } else if constexpr (is_union<shape>) {
      const vec3 v = b.velocity, centre = b.position, w = store.angular_velocity[i];
      store.shape[i].each_part([&](const auto& part, const pose& at) {
        const pose placed = combined(store.pose(i), at);
        b.position = placed.position, b.orientation = placed.orientation;
        if (!(b.flags & view_global)) b.velocity = v + w.cross(placed.position - centre);
        add_shape(out, b, part);
        b.mass = 0, ++b.part;
      });
    } else {
      b.orientation = store.pose(i).orientation;
      add_shape(out, b, store.shape[i]);
    }
  }
  template <class Shape>
  void add_shape(view_part& out, view_body& b, const Shape& shape) {
    const vec3 half = shape.half_extents(pose{});
    for (int k = 0; k < 3; ++k) b.size[k] = static_cast<float>(2 * half[k]);
    b.form = 0;
    if constexpr (view_needs_form<Shape>) {
      surface_.clear();
      add_surface(surface_, shape);
      b.form = add_form(out, sent_, surface_.points, surface_.corners, surface_.ends);
    }
    const std::uint8_t number = numbers_.number(Shape::name);
    b.shape = view_shape{static_cast<std::uint8_t>(number + (number >= shape_numbers::usual))};
    out.bodies.push_back(b);
  }
  template <class State>
  static void add_joints(view_part& out, const State& s) {
    s.joints.each_kind([&](const auto& of_kind) {
      for (const auto& r : of_kind.records)
        if constexpr (requires { vec3(r.anchors.frames.on_a); })
          out.joints.push_back(
              {r.key.a, r.key.b, r.key.number, r.anchors.frames.on_a, r.anchors.frames.on_b});
    });
  }
  /// The planes of the domain, if it is convex.
  template <class Scenario>
  static void add_domain(view_part& out, world<Scenario>& w) {
    const auto add = [&](const any_geometry& g) {
      if (!g.convex()) return false;
      for (const half_space& h : g.planes())
        out.domain.push_back({h.normal(), static_cast<double>(h.displacement())});
      return true;
    };
    const auto& domain = view_of(w).own;
    if constexpr (requires { domain.partition()->geometry(0); }) {
      if (domain.partition() != nullptr) {
        (void)add(any_geometry(domain.partition()->geometry(w.rank())));
        return;
      }
    }
    for (const connection& c : w.connections())
      if (!add(complement(c.geometry))) return out.domain.clear();
  }

  surface_faces surface_;  ///< of one body, in its frame
  shape_numbers numbers_;
  plain_vector<std::uint64_t> sent_;  ///< forms that rank 0 has, in order
};

}  // namespace talus::detail
