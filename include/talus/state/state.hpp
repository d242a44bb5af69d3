#pragma once
// The state of a world on one rank. The stages of a step work on it, the world is its public face.
#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <tuple>
#include <vector>

#include "talus/body/material.hpp"
#include "talus/constraint/cohesion.hpp"
#include "talus/constraint/joint_rows.hpp"
#include "talus/core/each.hpp"
#include "talus/core/neighbour_message.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/type_list.hpp"
#include "talus/detect/flush.hpp"
#include "talus/parallel/domain.hpp"
#include "talus/parallel/reduction.hpp"
#include "talus/parallel/single_domain.hpp"
#include "talus/parallel/traffic.hpp"
#include "talus/scenario/scenario.hpp"
#include "talus/state/bodies_of_shape.hpp"
#include "talus/state/body_count.hpp"
#include "talus/state/candidate_pairs.hpp"
#include "talus/state/counted_time.hpp"
#include "talus/state/feature_states.hpp"
#include "talus/state/flush_bodies.hpp"
#include "talus/state/function_times.hpp"
#include "talus/state/joint_table.hpp"
#include "talus/state/monitors.hpp"
#include "talus/state/periodic_ghosts.hpp"
#include "talus/state/response_state.hpp"
#include "talus/state/stage_clock.hpp"
#include "talus/state/step_lengths.hpp"
#include "talus/state/step_times.hpp"

namespace talus {

/// Seconds of wall time that the stages of the steps took on this rank.
struct stage_seconds {
  double detect = 0, respond = 0, integrate = 0, exchange = 0;
};

namespace detail {

/// Seconds that the stages of the steps took on a rank that balances its work: wall time and, for
/// exchanges, the time of the processor as well.
struct balanced_seconds {
  double detect = 0, respond = 0, integrate = 0;
  both_times exchange;
};

}  // namespace detail

/// The messages that this rank sent in the steps so far.
struct step_traffic {
  std::uint64_t messages_max = 0;  ///< in one step
  std::uint64_t bytes_max = 0;     ///< in one step
  std::uint64_t collectives = 0;   ///< in all steps
};

namespace detail {

/// Stands for shared_memory if no shape shares data.
struct no_shared_memory {};

/// What the filters of pairs depend on, and whether it has changed.
struct filter_revision {
  bool known = false;          ///< `revision` is that of the last search for pairs
  std::uint64_t revision = 0;  ///< of the states of the features
  bool changed = false;        ///< a body has changed since copies of it were sent
  bool sent = false;           ///< copies are sent, and the contacts of the step are not found
};
struct no_filter_revision {};

/// Messages between this rank and one of its neighbours, and migrated bodies; see
/// ghosts/messages.hpp.
struct message_channel {
  std::uint64_t sent = 0, received = 0;
  body_count given;        ///< to the neighbour
  body_count taken;        ///< from it
  body_count before_last;  ///< taken before the last migration of any
  body_count told;         ///< number that should have arrived, by its last message
};

/// The data that this rank and one of its neighbours hold about each other's bodies.
template <std::size_t Shapes, class Memory>
struct neighbour {
  int rank = 0;
  plain_vector<int> connected;  ///< the ranks it is connected to
  real reach = 0;               ///< largest reach of the bodies there
  std::array<plain_vector<std::uint32_t>, Shapes>
      shadowed;  ///< own bodies with a copy there, by shape, as copy_code encodes them
  std::array<std::size_t, Shapes> copies{};  ///< shadow copies here of bodies there
  plain_vector<body_holders> holders;        ///< of each of these that is fixed
  message_channel channel;
  [[no_unique_address]] Memory memory;  ///< of the shared data of shapes

  /// Both ends call it before each exchange of bodies.
  void next_exchange() {
    if constexpr (!std::is_empty_v<Memory>) memory.next_exchange();
  }
  [[nodiscard]] shared_memory* shared() {
    if constexpr (std::is_empty_v<Memory>)
      return nullptr;
    else
      return &memory;
  }
};

/// The positions of own bodies at the last choice of the copies for neighbours, and the reach of
/// that choice; see ghosts/shadow_copies.hpp.
template <std::size_t Shapes>
struct copy_choice {
  std::array<plain_vector<noted_body>, Shapes> bodies;  ///< by shape
  plain_vector<real> reach;                             ///< of each neighbour's bodies at that time
  real announced = 0;  ///< reach of the bodies here that neighbours hold
};
struct no_copy_choice {};
/// Stands for the choice of a solver if there is only one.
struct no_choice {};

template <class Shape>
struct is_finite : std::bool_constant<Shape::finite> {};
template <class Shape>
struct shares_data : std::bool_constant<packs_itself<Shape>> {};

/// Whether contacts are found and solved in the middle of a step.
template <class Scenario>
inline constexpr bool steps_by_midpoint = Scenario::integrator::at_midpoint;
/// The contact law of a scenario, as its contacts are compiled.
template <class Scenario>
using law_of =
    std::conditional_t<steps_by_midpoint<Scenario>, biased_law<typename Scenario::contact_law>,
                       typename Scenario::contact_law>;

/// The solver of a scenario, or both of them.
template <class Scenario>
using solvers_of = std::conditional_t<
    std::is_void_v<typename Scenario::solver_on_request>, typename Scenario::solver,
    either_solver<typename Scenario::solver, typename Scenario::solver_on_request>>;

template <class Scenario>
using response_state =
    typename response_of<typename Scenario::shapes, law_of<Scenario>, solvers_of<Scenario>,
                         solved_scalar<Scenario>,
                         contains_type<typename Scenario::features, driven>,
                         contains_type<typename Scenario::features, events>>::type;

/// The link of a transport; of a refused one, a type that causes no further errors.
struct no_link {
  static constexpr bool alone = true;
};
template <class Transport, bool = complete<Transport>>
struct link_of {
  using type = no_link;
};
template <class Transport>
struct link_of<Transport, true> {
  using type = typename Transport::link;
};

/// What follows from the policies of a scenario, for every part of the state.
template <class Scenario>
struct state_traits {
  using link_type = typename link_of<typename Scenario::transport>::type;
  using domain_type =
      std::conditional_t<link_type::alone, single_domain, domain<typename Scenario::decomposition>>;
  using law = law_of<Scenario>;
  /// The attractions of the contacts of this step, if the contact law lets touching bodies stick.
  [[no_unique_address]] std::conditional_t<is_cohesive<law>, attractions, no_attractions>
      attraction;
  using finite_shapes = filter_types<typename Scenario::shapes, is_finite>;
  static constexpr std::size_t shape_count = finite_shapes::size;

  /// Whether bodies are followed through a step.
  static constexpr bool continuous =
      contains_type<typename Scenario::features, continuous_collision>;
  /// Whether islands at rest are left out of the steps.
  static constexpr bool sleeps = contains_type<typename Scenario::features, sleeping>;
  /// Whether cuts between domains move.
  static constexpr bool balances = contains_type<typename Scenario::features, balancing>;
  /// Whether a feature keeps pairs of bodies apart.
  static constexpr bool filters = some_filter_pairs<typename Scenario::features>;
  /// Whether a feature reports which contacts begin and end.
  static constexpr bool follows_contacts = contains_type<typename Scenario::features, events>;
  /// Whether global bodies may be moved.
  static constexpr bool drives = contains_type<typename Scenario::features, driven>;
  /// Whether bodies may be joined.
  static constexpr bool has_joints = Scenario::joints::size > 0;
  /// Whether contacts are found and solved in the middle of a step.
  static constexpr bool midpoint = steps_by_midpoint<Scenario>;
  /// Steps, or parts of them, for which a body moves between the exchange of shadow copies and the
  /// action of the contacts found from them.
  static constexpr real steps_of_reach = midpoint ? 1.5 : 1;
  /// Whether there are two solvers, of which each run uses one.
  static constexpr bool two_solvers = !std::is_void_v<typename Scenario::solver_on_request>;
  /// Whether contacts may be solved colour by colour, so that nothing depends on the ranks.
  static constexpr bool may_use_colours = may_sweep_by_colours<solvers_of<Scenario>>;
  /// Whether small groups of contacts are solved across ranks. (With periodic axes, only on ranks
  /// that hold one image of each body: see sees_single_images().)
  /// With joints they are left to the sweeps: contacts alone do not show the whole of an island.
  static constexpr bool islands_across_ranks = !link_type::alone && !law::soft && !has_joints &&
                                               solves_shared_islands<typename Scenario::solver>;
  /// Whether space is periodic: then some shadow copies are images, and are shifted.
  static constexpr bool periodic = domain_type::periodic;
  using copy_code = detail::copy_code<periodic>;
  /// Whether fixed bodies may lie flush beside each other.
  static constexpr bool may_be_flush = []<class... Shapes>(type_list<Shapes...>) {
    return (has_flat_faces<Shapes> || ...);
  }(typename Scenario::shapes{});
};

/// The joints that this rank holds; nothing if the scenario names none.
template <class Scenario, class Kinds = typename Scenario::joints>
struct joint_state {
  template <class Kind>
  using list_of_kind = typename lists_for<solvers_of<Scenario>>::template list<
      joint_in_list<joint_rows<Kind, solver_state_of<solved_scalar<Scenario>>>>>;
  joint_table<Kinds, list_of_kind, state_traits<Scenario>::periodic> joints;
};
template <class Scenario>
struct joint_state<Scenario, type_list<>> {};

/// The loads, and the course of time.
struct step_conditions {
  vec3 gravity{0, 0, 0};
  /// What exerts forces in each step, at a time; see world::act_each_step().
  std::vector<named_function<std::function<void(real)>>> acting;
  real damping = 1;  ///< part of the velocity kept per unit of time
  real dt = 0;       ///< of the last step, or of the one under way
  step_lengths lengths;
  std::uint64_t steps = 0;
  real time = 0;
  counted_time clock;  ///< from which `time` follows
};

/// The bodies that this rank holds, by shape: its own, shadow copies, and global bodies.
template <class Scenario>
struct held_bodies {
  template <class Shape>
  using bodies_type =
      bodies_of_shape<Shape, typename Scenario::features, typename Scenario::broad_phase::search>;
  using tuple_type = map_to_tuple<typename Scenario::shapes, bodies_type>;

  tuple_type bodies;
  material_table materials;

  /// Calls f(bodies of a shape) for every shape of the scenario.
  template <class F>
  void each_shape(F&& f) {
    detail::each_of(bodies, f);
  }
  template <class F>
  void each_shape(F&& f) const {
    detail::each_of(bodies, f);
  }
  /// Calls f(bodies of a shape) for every shape of the scenario that can move.
  template <class F>
  void each_finite_shape(F&& f) {
    each_shape([&](auto& b) {
      if constexpr (std::remove_cvref_t<decltype(b)>::shape_type::finite) f(b);
    });
  }
  template <class F>
  void each_finite_shape(F&& f) const {
    each_shape([&](const auto& b) {
      if constexpr (std::remove_cvref_t<decltype(b)>::shape_type::finite) f(b);
    });
  }
  template <class Shape>
  auto& of() {
    (void)require_shape<Scenario, Shape>();
    return std::get<index_of<typename Scenario::shapes, Shape>>(bodies);
  }
  template <class Shape>
  const auto& of() const {
    (void)require_shape<Scenario, Shape>();
    return std::get<index_of<typename Scenario::shapes, Shape>>(bodies);
  }
};

/// This rank among the others: its domain, its neighbours, and what it has sent them.
template <class Scenario>
struct rank_state {
  using traits = state_traits<Scenario>;
  using link_type = typename traits::link_type;
  using domain_type = typename traits::domain_type;
  static constexpr std::size_t shape_count = traits::shape_count;
  using memory_type =
      std::conditional_t<(filter_types<typename traits::finite_shapes, shares_data>::size > 0),
                         shared_memory, no_shared_memory>;

  rank_state(link_type& l, domain_type d) : link(&l), own(std::move(d)) {}

  link_type* link;
  domain_type own;
  body_count owned;  ///< the bodies that should be owned here; see ghosts/conservation.hpp
  body_count made;   ///< created by this rank, minus those that it destroyed
  [[no_unique_address]] std::conditional_t<traits::periodic, periodic_ghosts<shape_count>,
                                           no_periodic_ghosts>
      copies;
  std::vector<neighbour<shape_count, memory_type>>
      neighbours;  ///< one for each connection, in the same order
  std::vector<neighbour_message> neighbour_messages;  ///< likewise: migrations
  bool strangers = false;  ///< some neighbours are not connected to each other
  bool changed = true;     ///< bodies were added, removed or changed since the last migration
  plain_vector<system_id> released;  ///< by the user, before neighbours were notified
  [[no_unique_address]] std::conditional_t<link_type::alone, no_copy_choice,
                                           copy_choice<shape_count>>
      choice;
  step_traffic sent;
};

/// The bodies here, and what this rank and its neighbours hold of each other's.
template <class Scenario>
struct population : held_bodies<Scenario>, rank_state<Scenario> {
  using rank_state<Scenario>::rank_state;
};

/// What is recorded of the steps so far.
template <class Scenario>
struct step_records {
  std::conditional_t<state_traits<Scenario>::balances, balanced_seconds, stage_seconds> seconds;
  function_times functions;
  step_times* single_steps = nullptr;  ///< where steps of simulate() are timed one by one
  [[no_unique_address]] monitor_records<typename Scenario::features> monitors;
};

/// All parts together. The first base holds the contacts and their solver or forces. A function
/// takes the narrowest part that it uses.
template <class Scenario>
struct world_state : response_state<Scenario>,
                     joint_state<Scenario>,
                     slots_of_features<typename Scenario::features, Scenario>,
                     Scenario::integrator::template state<Scenario>,
                     step_conditions,
                     population<Scenario>,
                     step_records<Scenario>,
                     state_traits<Scenario> {
  using traits = state_traits<Scenario>;
  using typename rank_state<Scenario>::link_type;
  using typename rank_state<Scenario>::domain_type;
  using typename traits::law;
  using rank_state<Scenario>::shape_count;
  using lists_type = typename response_state<Scenario>::lists_type;
  using history_type = typename response_state<Scenario>::history_type;

  world_state(link_type& l, domain_type d) : population<Scenario>(l, std::move(d)) {}

  [[no_unique_address]] std::conditional_t<traits::two_solvers, bool, no_choice>
      solver_on_request{};
  candidate_pairs found;
  [[no_unique_address]] std::conditional_t<traits::filters, filter_revision, no_filter_revision>
      filtered;
  [[no_unique_address]] std::conditional_t<traits::may_be_flush, flush_bodies, no_flush_bodies>
      flush;

  /// What may_touch can read of a body has changed: pairs are searched anew, here and on the
  /// neighbours.
  void note_filtered_change() {
    if constexpr (traits::filters) found.known = false, filtered.changed = true;
  }
  /// Neighbours have received the changes of bodies.
  void note_changes_sent() {
    this->changed = false;
    if constexpr (traits::filters) filtered.changed = false;
  }
  /// Whether this rank has all bodies.
  [[nodiscard]] constexpr bool on_one_rank() const {
    if constexpr (link_type::alone)
      return true;
    else
      return this->link->size() == 1;
  }
  /// Whether the contacts of this run are solved colour by colour.
  [[nodiscard]] constexpr bool by_colours() const {
    if constexpr (traits::two_solvers)
      return solver_on_request;
    else
      return traits::may_use_colours;
  }
  /// Solves with the second solver from now on.
  void use_solver_on_request() requires(traits::two_solvers) {
    solver_on_request = true;
    each_constraint_list([](auto& list) { list.keep_colours(true); });
  }
  /// References to the lists of contacts.
  [[nodiscard]] auto contact_lists() {
    return std::apply([](auto&... list) { return std::tie(list...); }, this->contacts);
  }
  template <class F>
  void each_contact_list(F&& f) {
    detail::each_of(this->contacts, f);
  }
  template <class F>
  void each_contact_list(F&& f) const {
    detail::each_of(this->contacts, f);
  }
  using traits::has_joints;
  template <class F>
  void each_joint_list(F&& f) {
    if constexpr (has_joints) this->joints.each_kind([&](auto& of_kind) { f(of_kind.list); });
  }
  template <class F>
  void each_joint_list(F&& f) const {
    if constexpr (has_joints) this->joints.each_kind([&](const auto& of_kind) { f(of_kind.list); });
  }
  /// The lists of contacts, then those of joints.
  template <class F>
  void each_constraint_list(F&& f) {
    each_contact_list(f), each_joint_list(f);
  }
  template <class F>
  void each_constraint_list(F&& f) const {
    each_contact_list(f), each_joint_list(f);
  }
};

/// The lists that the solver in use works on: contacts, then joints, so that joints are the last
/// that a sweep solves.
template <bool Coloured, class Scenario>
[[nodiscard]] decltype(auto) solver_lists(world_state<Scenario>& s) {
  if constexpr (!world_state<Scenario>::has_joints) {
    return lists_in_use<Coloured>(s.contacts);
  } else {
    return std::apply([](auto&... list) { return std::tie(list_in_use<Coloured>(list)...); },
                      std::tuple_cat(s.contact_lists(), s.joints.lists()));
  }
}

/// Every policy in use, with the active solver; see describe().
template <class Scenario>
[[nodiscard, gnu::cold]] std::string policies_in_use(const world_state<Scenario>& s) {
  if constexpr (world_state<Scenario>::two_solvers)
    if (s.by_colours())
      return scenario_with_solver<Scenario, typename Scenario::solver_on_request>::type::describe();
  return (void)s, describe<Scenario>();
}

}  // namespace detail
}  // namespace talus
