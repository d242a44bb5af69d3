#pragma once
// Adding, finding and removing bodies. Member functions of world.
#include <variant>

#include "talus/world/world.hpp"

namespace talus {

template <class Scenario>
template <class Shape>
void world<Scenario>::write(detail::body_store<Shape, typename Scenario::features>& store,
                            std::size_t i, const body<Shape>& b, system_id id, bool fixed) {
  using store_type = detail::body_store<Shape, typename Scenario::features>;
  store.id[i] = id;
  store.position[i] = b.position;
  store.velocity[i] = fixed ? vec3(0, 0, 0) : b.velocity;
  store.angular_velocity[i] = fixed ? vec3(0, 0, 0) : b.angular_velocity;
  store.shape[i] = b.shape;
  store.material[i] = b.material;
  store.flags[i] = fixed ? detail::flag_fixed : 0;
  store.inverse_mass[i] = 0;
  if constexpr (Shape::finite)
    if (!fixed || b.mass || b.density) {
      const real inverse = 1 / detail::mass_of(b, state_.materials);
      if constexpr (!std::is_same_v<typename Scenario::precision, double>)
        detail::require_mass_for_float(1 / inverse, Shape::name);
      if (fixed)
        store.keep_mass(i, inverse);
      else
        store.inverse_mass[i] = inverse;
    }
  if constexpr (store_type::oriented) store.orientation_of[i] = b.orientation.normalized();
  if constexpr (store_type::forced) {
    store.force[i] = vec3(0, 0, 0);
    store.torque[i] = vec3(0, 0, 0);
  }
  if constexpr (store_type::numbered) store.user_id[i] = b.user_id;
  if constexpr (detail::world_state<Scenario>::sleeps) detail::disturb(state_, store, i);
}

template <class Scenario>
template <class Shape>
system_id world<Scenario>::insert(const body<Shape>& b, system_id id) {
  detail::require_movable(b, rank());
  if constexpr (Scenario::contact_law::soft)
    if (!b.fixed)
      detail::require_yielding<typename Scenario::contact_law::law, Shape>(
          state_.materials[b.material]);
  if constexpr (!link_type::alone) detail::require_reached(state_, id, b.shape, b.position);
  auto& store = state_.template of<Shape>().movable;
  write(store, store.insert_local(), b, id, b.fixed);
  state_.owned.add(id);
  state_.made.add(id);
  state_.changed = true;
  return id;
}

template <class Scenario>
template <class Shape>
handle<Shape> world<Scenario>::add_global(const body<Shape>& b) {
  auto& bodies = state_.template of<Shape>();
  const auto id = detail::id_of_attempt(attempts_++);
  write(bodies.global, bodies.global.append(), b, id, true);
  bodies.globals_changed = true;
  return {id};
}

template <class Scenario>
template <class Sites, class F>
std::size_t world<Scenario>::fill(const Sites& sites, F&& f) requires(
    std::is_void_v<detail::missing_in_fill<Scenario, Sites, F>>) {
  sections_.require_all_ranks("fill", rank());
  sections_.refuse_in_global("fill", rank());
  require_domain();
  if (fills_ >= detail::most_fills)
    detail::fail<std::runtime_error>(
        "fill was called more than {} times, and there are no ids for more: create bodies one by "
        "one with add_if_local",
        detail::most_fills);
  const auto fill = fills_++;
  std::size_t made = 0;
  const auto [lower, upper] = state_.own.bounds();
  const auto make = [&](const auto& site) {
    const auto id = detail::id_of_site(fill, site.index);
    auto made_body = [&] {
      if constexpr (std::is_invocable_v<F&, decltype(site), random_stream&>) {
        random_stream random(seed_, value_of(id));
        return f(site, random);
      } else {
        return f(site);
      }
    }();
    const auto add = [&](const auto& b) {
      if constexpr (detail::require_body<Scenario, std::remove_cvref_t<decltype(b)>>()) {
        using shape = std::remove_cvref_t<decltype(b.shape)>;
        detail::require_sane(b, state_.materials);
        if (!contains(b.position))
          detail::fail<std::invalid_argument>(
              "fill made a {} at {} on site {}, which rank {} does not own: keep bodies at "
              "site.position, or filter the sites instead",
              shape::name, detail::text(b.position), detail::text(site.position), rank());
        insert(detail::with_own_inertia(b, state_.materials), id);
        ++made;
      }
    };
    const auto take = [&](const auto& b) {
      if constexpr (requires { b.valueless_by_exception(); })
        std::visit(add, b);
      else
        add(b);
    };
    if constexpr (requires { made_body.has_value(); }) {
      if (made_body) take(*made_body);
    } else {
      take(made_body);
    }
  };
  constexpr bool known = concepts::site_set<Sites>;
  static_assert(known,
                "fill takes sites, and this type is not one: a bare lattice has no end, so write "
                "lattice & region, as in simple_cubic{.spacing = 2} & box_region{...}");
  if constexpr (known)
    sites.for_each_in(lower, upper, [&](const auto& site) {
      using place = decltype(site);
      constexpr bool fits =
          std::is_invocable_v<F&, place, random_stream&> || std::is_invocable_v<F&, place>;
      static_assert(fits,
                    "fill takes a function of a site, or of a site and its random numbers: write "
                    "[&](const site& place, random_stream& random) { return body{...}; }");
      if constexpr (fits)
        if (contains(site.position)) make(site);
    });
  return made;
}

template <class Scenario>
template <class Shape>
std::optional<body_view<Scenario, Shape>> world<Scenario>::find_here(handle<Shape> h) {
  auto& bodies = state_.template of<Shape>();
  const auto in = [&](auto& store, bool global) -> std::optional<view<Shape>> {
    const auto at = std::find(store.id.begin(), store.id.end(), h.id);
    if (at == store.id.end()) return std::nullopt;
    return view<Shape>(state_, sections_, store, static_cast<std::size_t>(at - store.id.begin()),
                       global);
  };
  if (auto found = in(bodies.movable, false)) return found;
  return in(bodies.global, true);
}

template <class Scenario>
template <class Shape>
void world<Scenario>::destroy(handle<Shape> h) requires(detail::takes_shape<Scenario, Shape>) {
  if constexpr (detail::require_shape<Scenario, Shape>()) {
    if constexpr (keeps)
      if (keeper_.skipped > 0) return;  // the file has the bodies that are left
    const auto found = (*this)[h];
    auto& bodies = state_.template of<Shape>();
    if (found.is_remote())
      detail::fail<std::logic_error>(
          "the {} {} was destroyed on rank {}, which holds a shadow copy only: destroy it where "
          "is_remote() is false",
          Shape::name, h.id, rank());
    if constexpr (detail::world_state<Scenario>::has_joints)
      detail::refuse_jointed(state_, Shape::name, h.id);
    if (found.is_global()) {
      if (sections_.exclusive)
        detail::fail<std::logic_error>(
            "the global {} {} was destroyed inside an exclusive section on rank {}, so the ranks "
            "would differ: destroy it on all ranks",
            Shape::name, h.id, rank());
      const auto at = std::find(bodies.global.id.begin(), bodies.global.id.end(), h.id);
      const auto i = at - bodies.global.id.begin();
      bodies.global.each_column([&](auto& c) { c.erase(c.begin() + i); });
      bodies.globals_changed = true;
      note_removal();
      return;
    }
    const auto at = std::find(bodies.movable.id.begin(), bodies.movable.id.end(), h.id);
    bodies.movable.remove_local(static_cast<std::size_t>(at - bodies.movable.id.begin()));
    note_destroyed(h.id);
    state_.changed = true;
    note_removal();
  } else {
    (void)h;
  }
}

template <class Scenario>
template <class Predicate>
std::size_t world<Scenario>::destroy_if(Predicate&& predicate) {
  note_reading("world.destroy_if");
  std::size_t removed = 0;
  state_.each_finite_shape([&](auto& b) {
    using shape = typename std::remove_cvref_t<decltype(b)>::shape_type;
    for (std::size_t i = 0; i < b.movable.locals;) {
      view<shape> v(state_, sections_, b.movable, i, false);
      if (predicate(std::as_const(v))) {
        if constexpr (detail::world_state<Scenario>::has_joints)
          detail::refuse_jointed(state_, shape::name, b.movable.id[i]);
        note_destroyed(b.movable.id[i]);
        b.movable.remove_local(i);
        ++removed;
      } else {
        ++i;
      }
    }
  });
  state_.changed |= removed > 0;
  if (removed > 0) note_removal();
  return removed;
}

template <class Scenario>
template <class Shape>
bool world<Scenario>::overlaps(const Shape& shape, const vec3& position, const quat& orientation,
                               system_id except) const {
  note_reading("world.overlaps");
  shape.validate();
  detail::require_finite("the position of an overlap query", position);
  bool found = false;
  const talus::pose place{position, orientation};
  const auto against = [&](const auto& store, bool global) {
    using other = typename std::remove_cvref_t<decltype(store)>::shape_type;
    if constexpr (collidable<Shape, other>)
      for (std::size_t i = 0; i < store.size() && !found; ++i) {
        if (store.id[i] == except) continue;
        talus::pose there = store.pose(i);
        if (!global) there.position = detail::seen_from(state_, position, there.position);
        if constexpr (Shape::finite && other::finite) {
          const real reach = shape.bounding_radius() + store.shape[i].bounding_radius();
          if ((there.position - position).squaredNorm() > reach * reach) continue;
        }
        collide_pair(shape, place, store.shape[i], there, 0,
                     [&](const contact_geometry& g) { found = found || g.gap < 0; });
      }
  };
  state_.each_shape([&](const auto& b) {
    against(b.movable, false);
    against(b.global, true);
  });
  return found;
}

}  // namespace talus
