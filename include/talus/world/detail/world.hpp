#pragma once
// Bodies of the longer member functions of world.
#include <variant>

#include "talus/world/world.hpp"

namespace talus {

template <class Scenario>
void world<Scenario>::check_connections() {
  sections_.require_all_ranks("check_connections", rank());
  if constexpr (domain_type::periodic) {
    require_two_sided_connections();  // none were made by hand, so there is nothing else to ask
  } else if constexpr (!link_type::alone) {
    require_two_sided_connections();
    talus::check_connections(
        state_.own, [&](const detail::byte_buffer& mine) { return state_.link->gather_all(mine); });
  }
}

/// Throws alike on all ranks if a rank is connected to one that is not connected to it: the two
/// would wait for each other for ever. Costs one reduction where nothing was connected by hand.
template <class Scenario>
void world<Scenario>::require_two_sided_connections() {
  std::uint64_t rewired = rewired_;
  state_.link->reduce(reduction::max, std::span(&rewired, 1));
  if (rewired == 0) return;
  std::vector<int> ranks;
  for (const connection& c : connections()) ranks.push_back(c.rank);
  detail::byte_buffer mine;
  detail::byte_writer(mine).put(std::span<const int>(ranks));
  std::vector<detail::plain_vector<int>> all;
  for (const auto& bytes : state_.link->gather_all(mine))
    all.push_back(detail::byte_reader(bytes).get_all<int>());
  for (std::size_t a = 0; a < all.size(); ++a)
    for (const int b : all[a]) {
      const auto& back = all[static_cast<std::size_t>(b)];
      if (std::find(back.begin(), back.end(), static_cast<int>(a)) == back.end())
        detail::fail<std::runtime_error>(
            "rank {} is connected to rank {}, but rank {} is not connected to rank {}: call "
            "connect on "
            "both sides, each with the region of the other",
            a, b, b, a);
    }
}

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
    if (!fixed) {
      store.inverse_mass[i] = 1 / (state_.materials[b.material].density * b.shape.volume());
      if constexpr (!std::is_same_v<typename Scenario::precision, double>)
        detail::require_mass_for_float(1 / store.inverse_mass[i], Shape::name);
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
  require_movable(b);
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
  bodies.global.resize(bodies.global.size() + 1);
  write(bodies.global, bodies.global.size() - 1, b, id, true);
  bodies.globals_changed = true;
  return {id};
}

template <class Scenario>
template <class Sites, class F>
std::size_t world<Scenario>::fill(const Sites& sites, F&& f) {
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
        validate(b);
        if (!contains(b.position))
          detail::fail<std::invalid_argument>(
              "fill made a {} at {} on site {}, which rank {} does not own: keep bodies at "
              "site.position, or filter the sites instead",
              shape::name, detail::text(b.position), detail::text(site.position), rank());
        insert(b, id);
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
                "fill takes sites, and this type is none: a bare lattice has no end, so write "
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
std::optional<body_view<Scenario, Shape>> world<Scenario>::find(handle<Shape> h) {
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
void world<Scenario>::destroy(handle<Shape> h) {
  const auto found = (*this)[h];
  auto& bodies = state_.template of<Shape>();
  if (found.is_remote())
    detail::fail<std::logic_error>(
        "the {} {} was destroyed on rank {}, which holds a shadow copy only: destroy it where "
        "is_remote() is false",
        Shape::name, h.id, rank());
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
}

/// The record of a global body that is to be driven, from where it is now.
template <class Scenario>
template <class Shape>
detail::driven_body& world<Scenario>::driven_body_of(handle<Shape> h, const char* what) {
  sections_.require_all_ranks(what, rank());
  const auto& store = state_.template of<Shape>().global;
  const auto at = std::find(store.id.begin(), store.id.end(), h.id);
  if (at == store.id.end())
    detail::fail<std::invalid_argument>(
        "{} takes a global body, and rank {} knows no global {} {}: add it in world.global(...)",
        what, rank(), Shape::name, h.id);
  auto& all = state_.driving.all;
  auto one = std::find_if(all.begin(), all.end(), [&](const auto& x) { return x->id == h.id; });
  if (one == all.end()) {
    all.push_back(std::make_unique<detail::driven_body>());
    one = all.end() - 1;
    (*one)->id = h.id;
    if constexpr (keeps) keeper_.add("driven body " + detail::text(h.id), (*one)->state);
  }
  const auto i = static_cast<std::size_t>(at - store.id.begin());
  detail::driven_body& body = **one;
  body.state = {};
  body.state.origin = body.state.at.point = store.position[i];
  body.state.orientation = store.pose(i).orientation;
  if constexpr (!Shape::finite) {
    body.state.normal = store.shape[i].unit_normal();
    body.state.offset = store.shape[i].offset;
  }
  body.is_servo = false;
  body.plan = nullptr;
  return body;
}

template <class Scenario>
template <class Shape, class Motion>
void world<Scenario>::drive(handle<Shape> h, Motion motion) {
  if constexpr (detail::require_feature<Scenario, driven>() &&
                detail::motion_of_body<Motion>::value) {
    detail::driven_body& body = driven_body_of(h, "drive");
    using value = decltype(motion(real{}));
    if constexpr (std::is_same_v<value, rigid_displacement>) {
      body.plan = [motion](const detail::driven_state& s, real t, real dt) {
        return detail::step_to(s, motion(t + dt), dt);
      };
      auto& bodies = state_.template of<Shape>();
      const auto now = detail::place_of(body.state.origin, motion(state_.time));
      if (now == body.state.at) return;
      body.state.at = now;
      const auto& ids = bodies.global.id;
      detail::put_driven(
          bodies, static_cast<std::size_t>(std::find(ids.begin(), ids.end(), h.id) - ids.begin()),
          body.state);
      bodies.globals_changed = true;
    } else {
      body.plan = [motion](const detail::driven_state& s, real t, real dt) {
        return detail::step_at(s, motion(t + dt / 2), dt);
      };
    }
  }
}

template <class Scenario>
template <class Shape>
void world<Scenario>::hold_force(handle<Shape> h, const servo& how) {
  if constexpr (detail::require_feature<Scenario, driven>()) {
    detail::require_positive(how.force, "the force of a servo");
    detail::require_positive(how.max_speed, "the greatest speed of a servo");
    require_finite("the axis of a servo", how.axis);
    detail::driven_body& body = driven_body_of(h, "hold_force");
    vec3 axis = unit(how.axis);
    if constexpr (!Shape::finite)
      if (axis == vec3(0, 0, 0)) axis = body.state.normal;
    if (axis == vec3(0, 0, 0))
      detail::fail<std::invalid_argument>(
          "a servo moves the {} {} along an axis: give the direction in which it presses",
          Shape::name, h.id);
    body.holds = {how.force, how.max_speed, axis};
    body.is_servo = true;
    body.state.speed = body.state.gain = how.max_speed;
    body.plan = [axis](const detail::driven_state& s, real, real dt) {
      return detail::step_of_servo(s, axis, dt);
    };
  }
}

template <class Scenario>
template <class Shape>
void world<Scenario>::halt(handle<Shape> h) {
  if constexpr (detail::require_feature<Scenario, driven>()) (void)driven_body_of(h, "halt");
}

template <class Scenario>
template <class Predicate>
std::size_t world<Scenario>::destroy_if(Predicate&& predicate) {
  std::size_t removed = 0;
  state_.each_finite_shape([&](auto& b) {
    using shape = typename std::remove_cvref_t<decltype(b)>::shape_type;
    for (std::size_t i = 0; i < b.movable.locals;) {
      view<shape> v(state_, sections_, b.movable, i, false);
      if (predicate(std::as_const(v))) {
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
  shape.validate();
  require_finite("the position of an overlap query", position);
  bool found = false;
  const talus::pose place{position, orientation};
  const auto against = [&](const auto& store) {
    using other = typename std::remove_cvref_t<decltype(store)>::shape_type;
    if constexpr (collidable<Shape, other>)
      for (std::size_t i = 0; i < store.size() && !found; ++i) {
        if (store.id[i] == except) continue;
        if constexpr (Shape::finite && other::finite) {
          const real reach = shape.bounding_radius() + store.shape[i].bounding_radius();
          if ((store.position[i] - position).squaredNorm() > reach * reach) continue;
        }
        collide_pair(shape, place, store.shape[i], store.pose(i), 0,
                     [&](const contact_geometry& g) { found = found || g.gap < 0; });
      }
  };
  state_.each_shape([&](const auto& b) {
    against(b.movable);
    against(b.global);
  });
  return found;
}

template <class Scenario>
body_count world<Scenario>::audit() {
  sections_.require_all_ranks("audit", rank());
  const body_count here = detail::count_owned(state_);
  std::array<std::uint64_t, 4> sums{here.bodies, here.ids, state_.made.bodies, state_.made.ids};
  state_.link->reduce(reduction::sum, std::span(sums));
  const body_count all{sums[0], sums[1]}, expected{sums[2], sums[3]};
  if (all != expected) {
    const detail::surplus difference(all, expected);
    detail::fail<std::runtime_error>(
        "{} {} after {} steps: all ranks together own {} bodies, but {} were created and not "
        "destroyed{}",
        difference.text(),
        difference.bodies < 0   ? "is lost"
        : difference.bodies > 0 ? "is there twice"
                                : "is there",
        state_.steps, all.bodies, expected.bodies,
        detail::owners_text(state_, difference.single() ? difference.id : no_id));
  }
  return all;
}

template <class Scenario>
void world<Scenario>::synchronize() {
  sections_.require_all_ranks("synchronize", rank());
  require_domain();
  if constexpr (!link_type::alone) {
    require_two_sided_connections();
    detail::match_connections(state_);
    detail::share_connections(state_);
    for (int round = 0;; ++round) {
      std::uint64_t passing = detail::migrate(state_, false);
      state_.link->reduce(reduction::sum, std::span(&passing, 1));
      if (passing == 0) break;
      if (round > ranks())
        detail::fail<std::runtime_error>(
            "{} bodies do not find the way to the rank that owns their centre: check_connections() "
            "says what is missing",
            passing);
    }
    detail::refuse_closed_faces(state_, false);
    state_.choice.reach.clear();  // domains may have changed
    // The first round tells every neighbour how far bodies reach, the second one acts on it.
    detail::share_shadow_copies(state_, true);
    detail::share_shadow_copies(state_, true);
  }
  if constexpr (detail::world_state<Scenario>::sleeps) detail::note_sleepers(state_);
  state_.changed = false;
  rewired_ = false;
  synchronized_ = true;
}

template <class Scenario>
void world<Scenario>::step(real dt) {
  sections_.require_all_ranks("step", rank());
  if (sections_.global)
    detail::fail<std::logic_error>(
        "step was called inside a global section on rank {}: close the section first", rank());
  detail::require_positive(dt, "the time step dt");
  if constexpr (keeps)
    if (keeper_.hooks != nullptr) keeper_.hooks->refuse_step_before_restart();
  if constexpr (!Scenario::contact_law::soft) {
    const solver_settings& how = state_.settings;
    if (!(how.tolerance >= 0 && how.tolerance < 1) || how.max_iterations < 1)
      detail::fail<std::invalid_argument>(
          "the tolerance of the solver is a contact residual in (0, 1), or 0 for a fixed number of "
          "iterations, and at least 1 iteration is allowed for it, but they are {} and {}",
          how.tolerance, how.max_iterations);
    if (how.iterations < 1 || how.correction_iterations < 0 ||
        !(how.correction >= 0 && how.correction <= 1))
      detail::fail<std::invalid_argument>(
          "the solver needs at least 1 iteration, 0 of the correction, and a part of the overlap "
          "in "
          "[0, 1] to correct, but has {}, {} and {}",
          how.iterations, how.correction_iterations, how.correction);
    // How far bodies reach in a step is told to the neighbours before it.
    if (dt > state_.dt) state_.dt = dt, state_.changed = true;
  }
  if (!synchronized_) synchronize();
  if (rewired_)
    detail::fail<std::runtime_error>(
        "rank {} changed its connections and then called step: call synchronize() on all ranks "
        "first",
        rank());
  if constexpr (balances) look_at_balance_if_due();
  const traffic before = state_.link->counters();
  if constexpr (balances)
    detail::step_with_clock(state_, dt);
  else
    detail::step(state_, dt);
  const traffic sent = state_.link->counters() - before;
  state_.sent.messages_max = std::max(state_.sent.messages_max, sent.messages);
  state_.sent.bytes_max = std::max(state_.sent.bytes_max, sent.bytes);
  state_.sent.collectives += sent.collectives;
}

template <class Scenario>
void world<Scenario>::simulate(const simulation& s) {
  sections_.require_all_ranks("simulate", rank());
  detail::require_positive(s.dt, "the time step dt");
  state_.dt = s.dt;
  std::size_t steps = s.steps;
  detail::checkpoint_hooks* hooks = nullptr;
  bool restarted = false;
  if constexpr (keeps)
    if (hooks = keeper_.hooks.get(); hooks != nullptr) {
      const detail::restart_plan plan = hooks->begin(s);
      if (plan.skips) return;
      steps = plan.steps;
      restarted = plan.restarts;
    }
  if (!restarted) synchronize();
  for (const auto& start : starters_) start();
  for (std::size_t k = 0; k < steps; ++k) {
    if constexpr (keeps)
      if (hooks != nullptr) hooks->before_step();
    step(s.dt);
    if constexpr (keeps)
      if (hooks != nullptr) hooks->after_step();
    for (const auto& observe : observers_) observe();
    if constexpr (keeps)
      if (hooks != nullptr) hooks->after_observers();
  }
  (void)audit();
}

}  // namespace talus
