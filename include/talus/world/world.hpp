#pragma once
// The world: bodies, their domain, and time.
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "talus/body/body.hpp"
#include "talus/body/mass.hpp"
#include "talus/core/field_names.hpp"
#include "talus/core/random.hpp"
#include "talus/core/rounding.hpp"
#include "talus/detect/narrow.hpp"
#include "talus/parallel/check_connections.hpp"
#include "talus/parallel/domain.hpp"
#include "talus/parallel/reach.hpp"
#include "talus/scenario/made_bodies.hpp"
#include "talus/scenario/scenario.hpp"
#include "talus/state/recorded_values.hpp"
#include "talus/state/state.hpp"
#include "talus/step/step.hpp"
#include "talus/world/balance.hpp"
#include "talus/world/body_checks.hpp"
#include "talus/world/checkpoints.hpp"
#include "talus/world/joint_handle.hpp"
#include "talus/world/picture.hpp"
#include "talus/world/sections.hpp"
#include "talus/world/state_of.hpp"
#include "talus/world/unit_names.hpp"
#include "talus/world/view.hpp"

namespace talus {

namespace detail {
struct body_to_join;
}

/// How often something is done, in steps.
struct every {
  /// number of steps from one time to the next
  std::uint64_t steps = 1;
};

/// One rank's part of a simulation of the given scenario. All ranks run the same program (SPMD):
/// functions marked *collective* are called by all of them, and throw runtime_error inside an
/// exclusive section.
template <class Scenario>
class world {
 public:
  using scenario_type = Scenario;
  using link_type = typename detail::world_state<Scenario>::link_type;
  using decomposition_type = typename Scenario::decomposition;
  using domain_type = typename detail::world_state<Scenario>::domain_type;
  template <class Shape>
  using view = body_view<Scenario, Shape>;

  /// A world on this rank, with its domain in `d`, connected to all ranks within reach. Throws
  /// invalid_argument, with both numbers, if `d` is meant for another number of ranks, and
  /// runtime_error for solver<reproducible> in a program compiled without -ffp-contract=off.
  world(link_type& link, const decomposition_type& d, const reach& within = {})
      : state_(link, domain_type(d, link.rank(), link.size(), within.distance)) {
    if constexpr (by_colours) detail::require_rounding_as_written();
    if constexpr (balances) state_.balance.divide(d, within.distance);
  }
  /// A world on this rank, with the decomposition's default values. If it has none for this number
  /// of ranks, decompose() must set them first: functions that need the domain throw
  /// invalid_argument until then. A decomposition for another number of ranks is refused at once.
  explicit world(link_type& link) : state_(link, domain_type::undivided(link.rank(), link.size())) {
    if constexpr (by_colours) detail::require_rounding_as_written();
    try {
      state_.own = domain_type(decomposition_type{}, rank(), ranks());
      if constexpr (balances) state_.balance.divide({}, 0);
    } catch (const std::invalid_argument& e) {
      const int wanted = decomposition_type{}.size();
      if (wanted > 0 && ranks() > 1 && wanted != ranks()) throw;  // no values can change that
      undivided_ = std::string(e.what()) + "; world.decompose(...) takes them";
    }
  }
  world(const world&) = delete;
  world& operator=(const world&) = delete;

  /// Number of this rank, from 0.
  [[nodiscard]] int rank() const { return state_.link->rank(); }
  /// Number of ranks.
  [[nodiscard]] int ranks() const { return state_.link->size(); }

  // --- Domain --------------------------------------------------------------------------------

  /// Divides space again: extents, cuts, and the reach of connections. Collective; bodies in
  /// foreign domains migrate at the next synchronize(). Connections made by hand before are
  /// removed.
  void decompose(const decomposition_type& d, const reach& within = {}) {
    sections_.require_all_ranks("decompose", rank());
    domain_type own(d, rank(), ranks(), within.distance);
    if constexpr (balances) state_.balance.divide(d, within.distance);
    state_.own = std::move(own);
    undivided_.clear();
    synchronized_ = false;
  }
  /// Refuses other fields.
  template <class D = decomposition_type,
            detail::sentence Fields = detail::fields::of_decomposition<D>::type::says>
  typename detail::fields::of_decomposition<D>::type::template refused<Fields> decompose(...)
      TALUS_REFUSED;
  /// Connects this rank to another one, in one of the five forms of domain::connect.
  template <class... Args>
  void connect(int rank, Args&&... args) {
    refuse_by_hand();
    state_.own.connect(rank, std::forward<Args>(args)...);
    rewired_ = true;
  }
  /// Removes the connection to a rank; both ranks do so before the next synchronize() or step.
  void disconnect(int rank) {
    refuse_by_hand();
    state_.own.disconnect(rank);
    rewired_ = true;
  }
  /// The ranks that this one is connected to, and their domains.
  [[nodiscard]] std::span<const connection> connections() const { return state_.own.connections(); }
  /// Collective: throws runtime_error, alike on all ranks, if connections are missing, one-sided,
  /// or if domains leave a gap or overlap; the message lists all findings.
  void check_connections();
  /// Whether this rank owns the point; true on exactly one rank.
  [[nodiscard]] bool contains(const vec3& p) const {
    require_domain();
    return state_.own.contains(p);
  }

  /// From now on cuts move when the ranks' shares have become uneven: before the first step and
  /// then before each that follows a multiple of `every`, if the largest share is more than `above`
  /// times the mean one. Bodies migrate to their new owners with all their data; ranks are
  /// connected as far as the present bodies then reach (pass the reach of larger bodies to come to
  /// decompose()). All ranks call it alike; throws invalid_argument for settings out of range, and
  /// if the chosen decomposition cannot move its cuts. Needs features<balancing>.
  void balance(const balance_settings& how) {
    if constexpr (detail::require_feature<Scenario, balancing>()) {
      sections_.require_all_ranks("balance", rank());
      detail::require_sane(how);
      if (undivided_.empty()) state_.balance.require_movable(state_.balance.divided);
      state_.balance.settings = how;
      state_.balance.moves = true;
    }
  }
  /// Refuses other fields.
  template <detail::sentence Fields = detail::fields::balance_settings>
  detail::fields::no_balance_settings<Fields> balance(...) TALUS_REFUSED;
  /// The present decomposition, with the present cuts.
  [[nodiscard]] const decomposition_type& divided() const {
    static_assert(balances,
                  "world.divided() tells where cuts have been moved: add balancing to the "
                  "features<...> of this scenario");
    return state_.balance.divided;
  }

  // --- Sections ------------------------------------------------------------------------------

  /// Section for one rank: `if (auto only = world.exclusive(0)) { ... }`.
  [[nodiscard]] exclusive_section exclusive(int rank) {
    return {sections_, rank, this->rank(), ranks()};
  }
  /// Calls f() on `rank` only.
  template <class F>
  void exclusive(int rank, F&& f) {
    if (const exclusive_section section(sections_, rank, this->rank(), ranks()); section) f();
  }
  /// Section for global bodies: `auto section = world.global();`.
  [[nodiscard]] global_section global() { return {sections_, rank()}; }
  /// Calls f(world) on all ranks; the bodies it adds are global.
  template <class F>
  void global(F&& f) {
    const global_section section(sections_, rank());
    f(*this);
  }

  /// Throws runtime_error in an exclusive section: for functions, named by `what`, that communicate
  /// over link() with all ranks. If they read bodies, throws as note_reading().
  void require_all_ranks(const char* what, bool reads = true) const {
    if (reads) note_reading(what);
    sections_.require_all_ranks(what, rank());
  }
  /// For functions, named by `what`, that read bodies: throws runtime_error after calls of
  /// simulate() that a restart leaves out, where the bodies are those of the set-up.
  void note_reading(const char* what) const {
    if constexpr (keeps)
      if (keeper_.skipped > 0) keeper_.hooks->refuse_reading(what);
  }

  // --- Parameters ----------------------------------------------------------------------------

  /// Makes a material, alike on all ranks; its fields are those of `material`. Throws
  /// invalid_argument for a value out of its range, with the range.
  material_id material(const talus::material& m) {
    sections_.require_all_ranks("material", rank());
    if constexpr (Scenario::contact_law::soft) Scenario::contact_law::law::require_material(m);
    return state_.materials.add(m);
  }
  /// Refuses other fields.
  template <detail::sentence Fields = detail::fields::material>
  detail::fields::no_material<Fields> material(...) TALUS_REFUSED;
  /// Properties of contacts between two materials, instead of what the rules make of the two.
  void material_pair(material_id a, material_id b, const pair_material& p) {
    state_.materials.set_pair(a, b, p);
    if constexpr (detail::world_state<Scenario>::sleeps) state_.sleep.all = true;
  }
  /// Refuses other fields.
  template <detail::sentence Fields = detail::fields::pair_material>
  detail::fields::no_pair_material<Fields> material_pair(material_id, material_id,
                                                         ...) TALUS_REFUSED;
  /// How contacts of two materials without properties of their own follow from the two, instead of
  /// the mean: `world.pair_rules({.friction = pair_rule::least})`. Alike on all ranks.
  void pair_rules(const talus::pair_rules& rules) {
    sections_.require_all_ranks("pair_rules", rank());
    state_.materials.set_rules(rules);
    if constexpr (detail::world_state<Scenario>::sleeps) state_.sleep.all = true;
  }
  /// Refuses other fields.
  template <detail::sentence Fields = detail::fields::pair_rules>
  detail::fields::no_pair_rules<Fields> pair_rules(...) TALUS_REFUSED;
  /// Parameters of an interaction law for contacts between two materials, in either order, instead
  /// of those that the law combines from both: `p` is of the type law::parameters. Alike on all
  /// ranks. Throws invalid_argument for a material of another world, and for parameters that the
  /// law refuses.
  template <class Parameters>
  void interaction(material_id a, material_id b,
                   const Parameters& p) requires(Scenario::contact_law::soft) {
    using law = typename Scenario::contact_law::law;
    using part = typename detail::part_with<Parameters, typename law::parts>::type;
    static_assert(!std::is_void_v<part>,
                  "world.interaction takes the parameters of an interaction law of the scenario, "
                  "and this type is of none of them: write my_law::parameters{...} for a my_law "
                  "that soft_contact<...> names");
    if constexpr (!std::is_void_v<part>) {
      sections_.require_all_ranks("interaction", rank());
      if constexpr (requires { part::require_parameters(p); }) part::require_parameters(p);
      state_.soft.pairs.template give<part>(state_.materials, a, b, p);
      // The reach of bodies may have changed.
      state_.changed = true, synchronized_ = false;
    }
  }
  /// The parameters of a law of the scenario in contacts between two materials. Throws
  /// runtime_error if the law needs them from world.interaction(...) and they were not set.
  template <class Law>
  [[nodiscard]] typename Law::parameters interaction(material_id a, material_id b) requires(
      Scenario::contact_law::soft) {
    auto& pairs = state_.soft.pairs;
    (void)state_.materials[a], (void)state_.materials[b];
    pairs.template require_part<Law>(a, b);
    pairs.follow(state_.materials);
    return Scenario::contact_law::law::template of<Law>(pairs.pair(a, b));
  }
  /// The materials made so far, and the properties of their pairs.
  [[nodiscard]] const material_table& materials() const { return state_.materials; }
  /// Acceleration of all bodies.
  void gravity(const vec3& g) {
    sections_.require_all_ranks("gravity", rank());
    detail::require_finite("the gravity", g);
    if constexpr (detail::world_state<Scenario>::sleeps)
      state_.sleep.all = state_.sleep.all || g != state_.gravity;
    state_.gravity = g;
  }
  /// The acceleration that was set; initially zero.
  [[nodiscard]] const vec3& gravity() const { return state_.gravity; }
  /// Part of all velocities that is kept per unit of time, in (0, 1].
  void damping(real kept) {
    if constexpr (detail::require_feature<Scenario, talus::damping>()) {
      if (!(kept > 0 && kept <= 1))
        detail::fail<std::invalid_argument>(
            "the damping is the part of the velocity kept per unit of time, in (0, 1], but is {}",
            kept);
      state_.damping = kept;
    }
  }
  /// When islands are put to sleep: bodies joined by contacts or joints, all of which have been at
  /// rest for a while on something immovable. They stand still, and are left out of the steps,
  /// until an awake body approaches, a field changes there, or the user changes one of them, a body
  /// that they touch, gravity, or a pair of materials. Alike on all ranks; throws invalid_argument
  /// for values that are not finite, a speed that is not positive, or a negative time. Needs
  /// features<sleeping>.
  void sleeping(const sleep_settings& how) {
    if constexpr (detail::require_feature<Scenario, talus::sleeping>()) {
      if (!(how.speed > 0) || !std::isfinite(how.speed) || !(how.time >= 0) ||
          !std::isfinite(how.time))
        detail::fail<std::invalid_argument>(
            "islands go to sleep below a positive speed and after a time of 0 or more, both "
            "finite, but they are {} and {}",
            how.speed, how.time);
      state_.sleep.settings = how;
    }
  }
  /// Refuses other fields.
  template <detail::sentence Fields = detail::fields::sleep_settings>
  detail::fields::no_sleep_settings<Fields> sleeping(...) TALUS_REFUSED;
  /// Wakes all islands, in the next step. All ranks call it alike; for one island see
  /// body_view::wake.
  void wake() {
    if constexpr (detail::require_feature<Scenario, talus::sleeping>()) {
      sections_.require_all_ranks("wake", rank());
      state_.sleep.all = true;
    }
  }
  /// The state of a user-defined feature on this rank; settings must be alike on all ranks.
  template <class Feature>
  [[nodiscard]] auto& feature() requires(!detail::built_in<Feature>) {
    static_assert(Scenario::template has_feature<Feature>,
                  "this scenario does not have this feature: add it to its features<...>");
    return detail::own_state<Feature>(state_);
  }
  /// Settings of the contact solver, to be changed alike on all ranks.
  [[nodiscard]] solver_settings& solver() requires(!Scenario::contact_law::soft) {
    return state_.settings;
  }
  /// Settings of the contact solver.
  [[nodiscard]] const solver_settings& solver() const requires(!Scenario::contact_law::soft) {
    return state_.settings;
  }
  /// Solves all contacts with the second solver of solver<First, Second>, as the option
  /// --reproducible of run() does. Call it alike on all ranks before the first step. Throws
  /// logic_error after a step.
  void use_solver_on_request() requires(!std::is_void_v<typename Scenario::solver_on_request>) {
    if (steps() > 0)
      detail::fail<std::logic_error>(
          "use_solver_on_request() is called after {} steps: call it before the first step, so "
          "that one solver makes all of them",
          steps());
    detail::require_rounding_as_written();
    state_.use_solver_on_request();
  }
  /// Iterations of the solver, and contact residuals at their end; for soft contacts, the residuals
  /// of features<residual_monitor> and measure_residual().
  [[nodiscard]] const talus::convergence& convergence() const {
    note_reading("world.convergence");
    return state_.convergence;
  }
  /// Seed of all random numbers that fill() passes. Set alike on all ranks.
  void seed(std::uint64_t seed) { seed_ = seed; }
  /// The seed that was set.
  [[nodiscard]] std::uint64_t seed() const { return seed_; }

  // --- Bodies --------------------------------------------------------------------------------

  /// Adds a body. In a global section it becomes global; elsewhere this rank must own its centre.
  /// Throws invalid_argument for values out of range and for a position in a foreign domain, and
  /// logic_error for an infinite body outside of a global section.
  template <class Shape>
  handle<Shape> add(const body<Shape>& given) requires(detail::takes_shape<Scenario, Shape>) {
    if constexpr (detail::require_shape<Scenario, Shape>()) {
      detail::require_sane(given, state_.materials, sections_.global);
      const auto& b = detail::with_own_inertia(given, state_.materials);
      if (sections_.global) return add_global(b);
      if constexpr (!Shape::finite) {
        detail::fail<std::logic_error>(
            "a {} is infinite, so it must be known on all ranks, but rank {} added it outside of a "
            "global section: add it in world.global(...)",
            Shape::name, rank());
      } else {
        require_in_box(Shape::name, b.position);
        if (!contains(b.position))
          detail::fail<std::invalid_argument>(
              "rank {} cannot add a {} at {}, which is in the domain of {}: ask "
              "world.contains(...) first, "
              "or use add_if_local or fill",
              rank(), Shape::name, detail::text(b.position), owner_text(b.position));
        return {insert(b, detail::id_of_rank(static_cast<std::uint64_t>(rank()), added_here_++))};
      }
    }
    return {};
  }
  /// Refuses a shape that the scenario does not name.
  template <class Shape, detail::sentence Says =
                             detail::missing_shape<Shape, detail::takes_shape<Scenario, Shape>>()>
  handle<Shape> add(const body<Shape>& b) requires(!detail::takes_shape<Scenario, Shape>);
  /// Adds a body at rest with this shape, material, position and orientation, as add(body) does.
  template <class Shape>
  handle<Shape> add(const Shape& shape, material_id material, const vec3& position = {0, 0, 0},
                    const quat& orientation = {1, 0, 0,
                                               0}) requires(detail::takes_shape<Scenario, Shape>) {
    return add(body<Shape>{
        .shape = shape, .position = position, .material = material, .orientation = orientation});
  }
  /// Refuses a shape that the scenario does not name.
  template <class Shape, detail::sentence Says =
                             detail::missing_shape<Shape, detail::takes_shape<Scenario, Shape>>()>
  handle<Shape> add(const Shape& shape, material_id material, const vec3& position = {0, 0, 0},
                    const quat& orientation = {1, 0, 0,
                                               0}) requires(!detail::takes_shape<Scenario, Shape>);
  /// Refuses the position before the material.
  template <class Shape>
  handle<Shape> add(const Shape&, const vec3&, material_id, const quat& = {1, 0, 0, 0}) {
    static_assert(!sizeof(Shape*),
                  "world.add takes the material before the position: write world.add(shape, "
                  "material, position)");
    return {};
  }
  /// Refuses a shape without its material.
  template <concepts::shape Shape>
  handle<Shape> add(const Shape&, const vec3& = {0, 0, 0}, const quat& = {1, 0, 0, 0}) {
    static_assert(!sizeof(Shape*),
                  "world.add takes a shape with its material: write world.add(shape, material, "
                  "position), or world.add(body{.shape = shape, .position = position})");
    return {};
  }
  /// Adds the body on the rank that owns its centre and returns its handle there. All ranks call it
  /// alike, so its id is the same for every number of ranks.
  template <class Shape>
  std::optional<handle<Shape>> add_if_local(const body<Shape>& given) requires(
      detail::takes_shape<Scenario, Shape>) {
    static_assert(Shape::finite,
                  "an infinite body, such as a plane, is known on all ranks: add it in "
                  "world.global([&](auto& scope) { scope.add(plane{}, material); })");
    if constexpr (detail::require_shape<Scenario, Shape>() && Shape::finite) {
      detail::require_sane(given, state_.materials);
      const auto& b = detail::with_own_inertia(given, state_.materials);
      sections_.require_all_ranks("add_if_local", rank());
      sections_.refuse_in_global("add_if_local", rank());
      require_in_box(Shape::name, b.position);
      const auto id = detail::id_of_attempt(attempts_++);
      if (contains(b.position)) return handle<Shape>{insert(b, id)};
    }
    return std::nullopt;
  }
  /// Refuses a shape that the scenario does not name.
  template <class Shape, detail::sentence Says =
                             detail::missing_shape<Shape, detail::takes_shape<Scenario, Shape>>()>
  std::optional<handle<Shape>> add_if_local(const body<Shape>& b) requires(
      !detail::takes_shape<Scenario, Shape>);
  /// Creates bodies on the sites that this rank owns, and visits no others: f(site) or f(site,
  /// random), with random numbers that depend on seed and site alone, returns a body, an optional
  /// one, or a std::variant of bodies of several shapes. All ranks call it alike, without
  /// communication; returns the number of bodies made here.
  template <class Sites, class F>
  std::size_t fill(const Sites& sites,
                   F&& f) requires(std::is_void_v<detail::missing_in_fill<Scenario, Sites, F>>);
  /// Refuses a shape that the scenario does not name.
  template <class Sites, class F,
            detail::sentence Says =
                detail::missing_shape_or_none<detail::missing_in_fill<Scenario, Sites, F>>()>
  std::size_t fill(const Sites&, F&&) requires(
      !std::is_void_v<detail::missing_in_fill<Scenario, Sites, F>>) = delete;

  /// Moves a global body along, from now on: `motion` is a function of the time of the world that
  /// returns a rigid_displacement, a rigid_velocity or a surface_velocity (body/motion.hpp), such
  /// as oscillation, turning, gliding and belt, which count the time from this call. Displacements
  /// count from the present position of the body, and must be zero now. The motion replaces an
  /// earlier motion or servo of the body; translate() and rotate() are undone by it. All ranks call
  /// it alike, with motions that return the same bits; a restart calls it again. Throws
  /// invalid_argument for a body that is unknown or not global, or if the motion begins elsewhere,
  /// with the jump in radii of the body; and runtime_error in an exclusive
  /// section; a step throws runtime_error if the motion is not finite. Needs features<driven>.
  template <class Shape, class Motion>
  void drive(handle<Shape> h, Motion motion);
  /// Moves a global body along an axis so that its contacts exert a force against it: a plane
  /// presses on a packing, with `.force` or with `.pressure`, numbers or functions of the time. The
  /// area of a plane is that of the face that the other planes, and a periodic box, leave of it at
  /// the start of each step. Without contacts so far the body moves at its greatest speed. It costs
  /// one reduction over all ranks in each step. Called again for the same axis, it continues with
  /// the speed that the body has. All ranks call it alike; throws as drive(), and invalid_argument
  /// for a force, a pressure or a speed that is not positive, for both or neither of force and
  /// pressure, for the pressure of a body that is not a plane, or without an axis; a step throws
  /// runtime_error if a function returns no finite number of 0 or more, or if a plane that holds a
  /// pressure is not bounded.
  template <class Shape>
  void hold_force(handle<Shape> h, const servo& how);
  /// Refuses other fields.
  template <class Shape, detail::sentence Fields = detail::fields::servo>
  detail::fields::no_servo<Fields> hold_force(handle<Shape>, ...) TALUS_REFUSED;
  /// Stops a driven body at its present position. All ranks call it alike.
  template <class Shape>
  void halt(handle<Shape> h);

  /// Joins two bodies from now on: `world.join(a, b, ball_joint{.at = point})`, with a kind of
  /// joint that the scenario names in joints<...>. Joined bodies have no contacts with each other.
  /// Collective: all ranks call it alike, with a handle or an empty optional handle of each body
  /// (some rank must have one). One of the bodies may be global. Throws, alike on all ranks,
  /// invalid_argument for a body that is unknown, the same body twice, two bodies that cannot move,
  /// and values out of range, and runtime_error in an exclusive section. A step throws
  /// runtime_error if the bodies are further apart than connections reach (docs/joints.md).
  template <class A, class B, class Kind>
  joint_handle<Scenario, Kind> join(const A& a, const B& b, const Kind& how);
  /// Removes a joint, unless that was done before. All ranks call it alike; throws runtime_error in
  /// an exclusive section.
  template <class Kind>
  void release(const joint_handle<Scenario, Kind>& joint);

  /// Removes a body that this rank owns, or a global one (on all ranks alike). Throws
  /// invalid_argument if it is unknown and logic_error if it is a shadow copy, or has a joint.
  template <class Shape>
  void destroy(handle<Shape> h) requires(detail::takes_shape<Scenario, Shape>);
  /// Refuses a shape that the scenario does not name.
  template <class Shape, detail::sentence Says = detail::words_on_missing_shape<Shape>()>
  void destroy(handle<Shape>) requires(!detail::takes_shape<Scenario, Shape>) = delete;

  /// The body if this rank knows it: as owner, as shadow copy or as a global body.
  template <class Shape>
  [[nodiscard]] std::optional<view<Shape>> find(handle<Shape> h) requires(
      detail::takes_shape<Scenario, Shape>) {
    if constexpr (detail::require_shape<Scenario, Shape>()) {
      note_reading("world.find");
      return find_here(h);
    } else {
      return (void)h, std::nullopt;
    }
  }
  /// The body if this rank knows it; throws invalid_argument if the body is unknown.
  template <class Shape>
  [[nodiscard]] view<Shape> operator[](handle<Shape> h) requires(
      detail::takes_shape<Scenario, Shape>) {
    if constexpr (detail::require_shape<Scenario, Shape>()) {
      note_reading("world[...]");
      if (auto found = find_here(h)) return *found;
      detail::fail<std::invalid_argument>(
          "rank {} does not know the {} {}: it was destroyed, or lives on another rank (use find)",
          rank(), Shape::name, h.id);
    } else {
      detail::fail<std::logic_error>("this scenario has no bodies of the shape of body {}", h.id);
    }
  }

  /// Refuses a shape that the scenario does not name.
  template <class Shape, detail::sentence Says = detail::words_on_missing_shape<Shape>()>
  std::optional<view<Shape>> find(handle<Shape>) requires(!detail::takes_shape<Scenario, Shape>) =
      delete;
  /// Refuses a shape that the scenario does not name.
  template <class Shape, detail::sentence Says = detail::words_on_missing_shape<Shape>()>
  view<Shape> operator[](handle<Shape>) requires(!detail::takes_shape<Scenario, Shape>) = delete;

  /// Calls f(body) for every body this rank owns.
  template <class F>
  void for_each_local(F&& f) {
    note_reading("world.for_each_local");
    state_.each_finite_shape([&](auto& b) { visit(b, b.movable, 0, b.movable.locals, false, f); });
  }
  /// Calls f(body) for every body this rank knows: its own, shadow copies and global ones.
  template <class F>
  void for_each_known(F&& f) {
    note_reading("world.for_each_known");
    state_.each_shape([&](auto& b) {
      visit(b, b.movable, 0, b.movable.size(), false, f);
      visit(b, b.global, 0, b.global.size(), true, f);
    });
  }
  /// Removes the bodies this rank owns for which predicate(body); returns how many.
  template <class Predicate>
  std::size_t destroy_if(Predicate&& predicate);

  /// Whether a shape at that pose overlaps any body this rank knows, except for `except`.
  template <class Shape>
  [[nodiscard]] bool overlaps(const Shape& shape, const vec3& position,
                              const quat& orientation = {1, 0, 0, 0},
                              system_id except = no_id) const;

  /// Number of bodies this rank owns.
  [[nodiscard]] std::size_t local_bodies() const {
    note_reading("world.local_bodies");
    std::size_t n = 0;
    state_.each_finite_shape([&](const auto& b) { n += b.movable.locals; });
    return n;
  }

  /// Collective: whether all bodies are present. Returns the number of bodies of all ranks, and the
  /// sum of their ids; throws runtime_error, alike on all ranks, if they differ from those created
  /// minus those destroyed. Each step checks every migration on its own, without a collective call;
  /// simulate() ends with an audit.
  body_count audit();

  // --- Time ----------------------------------------------------------------------------------

  /// Collective: bodies migrate to the ranks that own their centres, however far, and shadow copies
  /// are rebuilt. The first step does so by itself.
  void synchronize();
  /// Collective: advances time by `dt`. Throws invalid_argument for a dt that is not positive, and
  /// logic_error if there are fields of force or fluids, which act in the steps of simulate().
  void step(real dt);
  /// Collective: many steps; the observers are called after each. stop() or a condition ends it
  /// early. Throws invalid_argument for a dt that is not positive.
  void simulate(const simulation& s);
  /// Refuses other fields.
  template <detail::sentence Fields = detail::fields::simulation>
  detail::fields::no_simulation<Fields> simulate(...) TALUS_REFUSED;
  /// Ends the present call of simulate() after the present step; a later call continues. In a
  /// function passed to observe() any rank may call it: the ranks agree after the function, by one
  /// reduction if there are several. Elsewhere all ranks call it after the same step. A checkpoint
  /// records that the call was ended. Throws logic_error outside of simulate().
  void stop();
  /// Ends each call of simulate() if `condition(world)`, or `condition()`, is true on any rank:
  /// `world.stop_when(every{100}, [](auto& world) { return measure_motion(world).max_speed < 1e-3;
  /// })`. It is evaluated on all ranks after the steps whose number is a multiple of `when.steps`,
  /// so it may call collective functions of the world; several ranks agree by one reduction. Throws
  /// invalid_argument for a multiple of 0. The summary tells the time of all conditions together.
  template <class F>
  void stop_when(every when, F condition) {
    constexpr bool of_world = std::is_invocable_r_v<bool, F&, world&>;
    constexpr bool well = of_world || std::is_invocable_r_v<bool, F&>;
    static_assert(well,
                  "world.stop_when takes how often, and a condition of the world: write "
                  "world.stop_when(every{100}, [&](auto& world) { return ...; })");
    if constexpr (well)
      observe(detail::name_of_conditions, when,
              [condition = std::move(condition)](world& w) mutable {
                if constexpr (of_world) {
                  if (condition(w)) w.stop();
                } else if (condition()) {
                  w.stop();
                }
              });
  }
  /// Ends each call of simulate() if `condition(world)`, or `condition()`, is true on any rank
  /// after a step. It is evaluated after each step.
  template <class F>
  void stop_when(F condition) {
    stop_when(every{1}, std::move(condition));
  }
  /// Whether stop() or a condition ended the last call of simulate(), also if a checkpoint recorded
  /// it.
  [[nodiscard]] bool stopped() const { return stopped_; }
  /// A user-defined number, a column of the table of --csv: each line contains the last value that
  /// rank 0 has set, or is empty there before the first. A checkpoint stores it. `dimension` is
  /// written in the head of the column, as in "M L^2/T^2" (M mass, L length, T time). Throws
  /// invalid_argument for a name that is empty or has a comma, a quote or a line feed.
  void record(const std::string& name, double value, const std::string& dimension = "") {
    records_.set(name, value, dimension);
  }
  /// The numbers passed to record(). Throws as note_reading().
  [[nodiscard]] const detail::recorded_values& records() const {
    note_reading("world.records");
    return records_;
  }
  /// User-defined state that checkpoints hold: a value that is equal on all ranks, or that rank 0
  /// alone uses, such as a number or a random_stream; rank 0's value is stored, and at a restart
  /// all ranks get it. The variable must outlive all calls of simulate(); all ranks name the same.
  /// Throws invalid_argument for a name that is empty or already in use. Needs
  /// features<checkpoints>.
  template <class T>
  void keep(const std::string& name, T& value) {
    if constexpr (detail::require_feature<Scenario, checkpoints>()) keeper_.add(name, value);
  }
  /// User-defined state that checkpoints hold: a number that each rank counts on its own and that
  /// is summed over ranks. The sum is stored, and at a restart rank 0 gets it, the others 0. Throws
  /// like keep(). Needs features<checkpoints>.
  template <class T>
  void keep_sum(const std::string& name, T& value) {
    if constexpr (detail::require_feature<Scenario, checkpoints>()) keeper_.add_sum(name, value);
  }
  /// A value that the program computes from the bodies between calls of simulate(), such as the
  /// height of a packing that has settled: returns f(), and checkpoints hold it. A restart that
  /// leaves out the calls before returns the value of the file instead, and does not call f, since
  /// the bodies are those of the set-up then. The value is equal on all ranks: a number, a vec3, a
  /// handle, or another type without memory of its own. f may return nothing: a change of bodies
  /// that looks at them, which a restart leaves out (the bodies are replaced by those of the file).
  /// All ranks call it alike. Throws invalid_argument for a name that is empty or was used before,
  /// logic_error if f makes steps, or adds a body with add(), whose id depends on the ranks, or if
  /// ranks have different values, and runtime_error if a restart finds no value of that name in its
  /// file. Needs features<checkpoints>.
  template <class F>
  auto once(const std::string& name, F&& f);
  /// Calls f(time) in each step to exert forces on bodies, at the positions of that time: at the
  /// start of the step, and in its middle with integrator<moreau_midpoint>. f sees shadow copies,
  /// too, and exerts the same on them as their owners do. All ranks make the same calls in the same
  /// order. The summary gives the time of f under this name. Needs features<forces>.
  void act_each_step(const std::string& name, std::function<void(real)> f) {
    if constexpr (detail::require_feature<Scenario, forces>()) {
      state_.acting.push_back({std::move(f), state_.functions.number(name)});
      acting_.push_back(name);
    }
  }
  /// The names of act_each_step(), in the order of the calls.
  [[nodiscard]] const std::vector<std::string>& acting() const { return acting_; }
  /// Calls f() after each step of simulate().
  void after_each_step(std::function<void()> f) { after_each_step({}, std::move(f)); }
  /// Calls f() after each step of simulate(); the summary gives the time of f under this name.
  void after_each_step(std::string_view name, std::function<void()> f) {
    observers_.push_back({std::move(f), state_.functions.number(name)});
  }
  /// Calls f(), which changes neither bodies nor parameters, after each step of simulate(). (With
  /// soft contacts and features<energy_ledger>, the functions of after_each_step() cost a pass over
  /// the contacts in each step.)
  void monitor_each_step(std::string_view name, std::function<void()> f) {
    observers_.push_back({std::move(f), state_.functions.number(name), 0});
  }
  /// Calls f(world) after each step of simulate() whose number is a multiple of `when.steps`, on
  /// all ranks: `world.observe(every{100}, [](auto& world) { ... })`. f may call collective
  /// functions of the world. Throws invalid_argument for a multiple of 0.
  template <class When = every, class F>
  void observe(When when, F f) {
    observe({}, when, std::move(f));
  }
  /// Calls f(world) after the steps whose number is a multiple of `when.steps`; the summary gives
  /// the time of f under this name:
  /// `world.observe("height of the heap", every{100}, [](auto& world) { ... })`.
  template <class When = every, class F>
  void observe(std::string_view name, When when, F f) {
    constexpr bool well = std::is_same_v<When, every> && std::is_invocable_v<F&, world&>;
    static_assert(well,
                  "world.observe takes how often, and a function of the world: write "
                  "world.observe(every{100}, [&](auto& world) { ... })");
    if constexpr (well) {
      if (when.steps == 0)
        detail::fail<std::invalid_argument>(
            "world.observe was told to do something every 0 steps: give 1 or more");
      after_each_step(name, [this, when, f = std::move(f)]() mutable {
        if (state_.steps % when.steps != 0) return;
        f(*this);
        agree_ = true;
      });
      observers_.back().acts_every = when.steps;
    }
  }
  /// Calls f() after each step of simulate(), after all functions of after_each_step() and
  /// observe(): for output of their results.
  void after_observers(std::function<void()> f) { after_observers({}, std::move(f)); }
  /// Calls f() after all observers; the summary gives the time of f under this name.
  void after_observers(std::string_view name, std::function<void()> f) {
    writers_.push_back({std::move(f), state_.functions.number(name)});
  }
  /// Calls f(), which changes neither bodies nor parameters, after all observers.
  void monitor_after_observers(std::string_view name, std::function<void()> f) {
    writers_.push_back({std::move(f), state_.functions.number(name), 0});
  }
  /// Calls f() at the start of each simulate(), when all bodies are with their owners.
  void before_simulating(std::function<void()> f) { before_simulating({}, std::move(f)); }
  /// Calls f() at the start of each simulate(); the summary gives the time of f under this name.
  void before_simulating(std::string_view name, std::function<void()> f) {
    starters_.push_back({std::move(f), state_.functions.number(name)});
  }

  /// Number of time steps made so far, including those before a restart.
  [[nodiscard]] std::uint64_t steps() const { return state_.steps; }
  /// The step with which the present call of simulate() ends, or the last one ended.
  [[nodiscard]] std::uint64_t last_step() const { return last_step_; }
  /// Notes that pictures are taken of this world, by take_pictures() or in another way: run() then
  /// accepts --frames.
  void note_pictures() { takes_pictures_ = true; }
  /// Notes that pictures are taken, with the view that the page of --view begins with.
  void note_pictures(const picture& look) {
    takes_pictures_ = true;
    look_ = look;
  }
  /// The view that note_pictures() was given, or none.
  [[nodiscard]] const std::optional<picture>& look() const { return look_; }
  /// Whether note_pictures() was called.
  [[nodiscard]] bool takes_pictures() const { return takes_pictures_; }
  /// Calls of simulate() so far.
  [[nodiscard]] std::uint64_t simulations() const { return simulations_; }
  /// Throws runtime_error if a checkpoint was to be read, and no simulate() has reached its step.
  void require_restarted() const {
    if constexpr (keeps)
      if (keeper_.hooks != nullptr) keeper_.hooks->require_restarted();
  }
  /// The step of the checkpoint from which this run continued; 0 if it did not restart.
  [[nodiscard]] std::uint64_t restarted_at() const {
    if constexpr (keeps)
      return keeper_.restarted_at;
    else
      return 0;
  }
  /// Elapsed time, in units of time.
  [[nodiscard]] real time() const { return state_.time; }

  /// Names of the units in which the program gives its numbers: `world.units({.length = "m", .mass
  /// = "kg", .time = "s"})`. The summary, the heads of the columns of --csv and the JSON file show
  /// them, and forms such as kg m^2/s^2; no value depends on them. A unit without a name is M, L or
  /// T. All ranks call it alike. Throws invalid_argument for a name with a comma, a quote, a
  /// bracket or a line feed.
  void units(const unit_names& names) {
    detail::require_sane(names);
    units_ = names;
  }
  /// Refuses other fields.
  template <detail::sentence Fields = detail::fields::unit_names>
  detail::fields::no_unit_names<Fields> units(...) const TALUS_REFUSED;
  /// The names that were given.
  [[nodiscard]] const unit_names& units() const { return units_; }

  /// Seconds of wall time that the stages of the steps so far took on this rank.
  [[nodiscard]] stage_seconds stage_times() const {
    const auto& t = state_.seconds;
    return {t.detect, t.respond, t.integrate, t.exchange};
  }
  /// The messages that this rank sent in the steps so far.
  [[nodiscard]] const step_traffic& step_messages() const { return state_.sent; }
  /// Periodic space: its edges, and the image of a point nearest to another.
  [[nodiscard]] const periodic_box& periodic_space() const
      requires(detail::world_state<Scenario>::periodic) {
    return state_.own.box();
  }
  /// The link that sends messages between the ranks, for user-defined reductions.
  [[nodiscard]] link_type& link() { return *state_.link; }

 private:
  friend struct detail::checkpoint_access;
  friend struct detail::world_access;
  static constexpr bool keeps = Scenario::template has_feature<checkpoints>;
  static constexpr bool balances = Scenario::template has_feature<balancing>;
  static constexpr bool by_colours = detail::solves_by_colours<typename Scenario::solver>;

  static consteval void refuse_by_hand() {
    static_assert(
        !balances,
        "this scenario moves the cuts between its domains (features<balancing>), which "
        "would undo connections made by hand: give decompose() a reach instead, or remove "
        "balancing");
  }
  [[nodiscard]] bool ends_now(const simulation& s);
  void require_domain() const {
    if (!undivided_.empty()) throw std::invalid_argument(undivided_);
  }
  void require_in_box(const char* what, const vec3& p) const {
    if constexpr (domain_type::periodic) {
      require_domain();
      const auto& box = state_.own.box();
      if (!box.contains(p))
        detail::fail<std::invalid_argument>(
            "a {} was added at {}, outside of the periodic box, which goes from {} to {} along its "
            "periodic axes, the upper side excluded: add its image in there, at {}",
            what, detail::text(p), detail::text(box.lower()), detail::text(box.upper()),
            detail::text(box.wrapped(p)));
    }
  }
  [[nodiscard]] std::string owner_text(const vec3& p) const {
    const int owner = state_.own.owner(p);
    return owner < 0 ? "a rank it is not connected to" : detail::compose("rank {}", owner);
  }
  void require_two_sided_connections();
  void look_at_balance_if_due();
  void note_destroyed(system_id id) {
    state_.owned.remove(id);
    state_.made.remove(id);
  }
  /// Removing a body wakes the island that rests on it.
  void note_removal() {
    if constexpr (detail::world_state<Scenario>::sleeps) {
      if (!state_.sleep.asleep.empty()) state_.sleep.changed = state_.sleep.spreads = true;
    }
  }
  template <class Shape>
  void write(detail::body_store<Shape, typename Scenario::features>& store, std::size_t i,
             const body<Shape>& b, system_id id, bool fixed);
  template <class Shape>
  system_id insert(const body<Shape>& b, system_id id);
  template <class Shape>
  handle<Shape> add_global(const body<Shape>& b);
  template <class S, class K>
  friend class joint_handle;
  template <class Shape>
  detail::body_to_join agree_on_body(system_id named, const char* which);
  template <class Shape>
  [[nodiscard]] bool owns_body(const detail::body_to_join& one) const;
  template <class Kind, class Motor>
  void set_motor(const joint_handle<Scenario, Kind>& joint, const Motor& motor);
  template <class Kind>
  [[nodiscard]] const detail::joint_record<Kind>* find_joint(
      const joint_handle<Scenario, Kind>& joint);
  template <class Shape>
  detail::driven_body& driven_body_of(handle<Shape> h, const char* what);
  template <class Shape>
  [[nodiscard]] std::optional<view<Shape>> find_here(handle<Shape> h);
  template <class Bodies, class Store, class F>
  void visit(Bodies&, Store& store, std::size_t from, std::size_t to, bool global, F&& f) {
    using shape = typename Store::shape_type;
    for (std::size_t i = from; i < to; ++i) {
      view<shape> v(state_, sections_, store, i, global);
      f(v);
    }
  }

  detail::world_state<Scenario> state_;
  detail::open_sections sections_;
  std::string undivided_;  ///< why there is no domain yet; empty when there is one
  bool synchronized_ = false;
  bool takes_pictures_ = false;
  std::optional<picture> look_;
  bool rewired_ = false;  ///< connections were changed by hand since the last synchronize()
  std::uint64_t seed_ = 0;
  std::uint64_t fills_ = 0;
  std::uint64_t attempts_ = 0;
  std::uint64_t added_here_ = 0;
  std::uint64_t last_step_ = 0, simulations_ = 0;
  bool simulating_ = false, stopped_ = false;
  std::vector<std::string> acting_;  ///< the names of act_each_step()
  bool stop_asked_ = false;          ///< by this rank, in the present step
  bool agree_ = false;               ///< a function of observe() was called in the present step
  using called = std::vector<detail::named_function<std::function<void()>>>;
  using laps = detail::lap_clock<detail::world_state<Scenario>>;
  void call(const called& all, laps& clock) {
    for (const auto& one : all) {
      if (one.acts_every != 0 && state_.steps % one.acts_every == 0) detail::close_ledger(state_);
      one.f(), clock.lap(one.number);
    }
  }
  called observers_, writers_, starters_;
  unit_names units_;
  detail::recorded_values records_;
  [[no_unique_address]] std::conditional_t<keeps, detail::checkpoint_keeper, detail::keeps_nothing>
      keeper_;

  // The last members, because clang leaves out those behind a failed assertion.
  static_assert(detail::complete<typename Scenario::transport> ||
                    !std::is_same_v<typename Scenario::transport, serial>,
                "a world needs the transport of its scenario, which is serial: write #include "
                "<talus/parallel/serial.hpp>");
  static_assert(detail::complete<typename Scenario::transport> ||
                    std::is_same_v<typename Scenario::transport, serial>,
                "a world needs the transport of its scenario, which is threads unless it names "
                "another: write #include <talus/parallel/threads.hpp>");
};

}  // namespace talus

#include "talus/world/detail/balance_definitions.hpp"
#include "talus/world/detail/bodies_definitions.hpp"
#include "talus/world/detail/connections_definitions.hpp"
#include "talus/world/detail/driving_definitions.hpp"
#include "talus/world/detail/joining_definitions.hpp"
#include "talus/world/detail/once_definitions.hpp"
#include "talus/world/detail/time_definitions.hpp"
