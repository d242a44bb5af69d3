#pragma once
// scenario<...>: all decisions before the run, as one type.
#include <string>
#include <string_view>

#include "talus/body/bodies.hpp"
#include "talus/body/features.hpp"
#include "talus/contact/law.hpp"
#include "talus/core/precision.hpp"
#include "talus/core/refused_fields.hpp"
#include "talus/core/rounding.hpp"
#include "talus/detect/policy.hpp"
#include "talus/interaction/film_bridge.hpp"
#include "talus/interaction/soft_contact.hpp"
#include "talus/parallel/grid.hpp"
#include "talus/parallel/policy.hpp"
#include "talus/scenario/joints.hpp"
#include "talus/shape/plane.hpp"
#include "talus/shape/sphere.hpp"
#include "talus/solver/policy.hpp"

namespace talus {

namespace detail {

/// Whether contacts of a law are forces without a memory.
template <class ContactLaw>
inline constexpr bool law_forgets = false;
template <class ContactLaw>
requires(ContactLaw::soft) inline constexpr bool law_forgets<ContactLaw> = !ContactLaw::remembers;

template <class Role>
struct in_role {
  template <class Type>
  struct played_by : std::bool_constant<plays<Type, Role>> {};
};

template <class List, class Type>
struct list_and;
template <class... Types, class Type>
struct list_and<type_list<Types...>, Type> {
  using type = type_list<Types..., Type>;
};
template <class List, class Type>
using list_with = typename list_and<List, Type>::type;

/// The first policy of a role, or its default. Later ones were refused before.
template <class Role, class Default, class... Policies>
using policy_for = find_type<type_list<Policies...>, in_role<Role>::template played_by, Default>;

template <class Role, class... Policies>
inline constexpr bool at_most_one = (std::size_t{0} + ... + plays<Policies, Role>) <= 1;

/// A policy of talus, recognised by its spelling, without instantiating any of it.
template <class Type>
inline constexpr bool spelled_as_policy = false;
template <class... Parts>
inline constexpr bool spelled_as_policy<bodies<Parts...>> = true;
template <class... Parts>
inline constexpr bool spelled_as_policy<hard_contact<Parts...>> = true;
template <class... Parts>
inline constexpr bool spelled_as_policy<soft_contact<Parts...>> = true;
template <class... Parts>
inline constexpr bool spelled_as_policy<features<Parts...>> = true;
template <class Part, class OnRequest>
inline constexpr bool spelled_as_policy<solver<Part, OnRequest>> = true;
template <class Part>
inline constexpr bool spelled_as_policy<broad_phase<Part>> = true;
template <class Part>
inline constexpr bool spelled_as_policy<integrator<Part>> = true;
template <class Part>
inline constexpr bool spelled_as_policy<decomposition<Part>> = true;
template <class Part>
inline constexpr bool spelled_as_policy<transport<Part>> = true;
template <class Part>
inline constexpr bool spelled_as_policy<precision<Part>> = true;
template <class... Kinds>
inline constexpr bool spelled_as_policy<joints<Kinds...>> = true;

/// Refuses a type that is not a policy, with matching advice.
template <class Type>
struct argument_of_scenario {
  static constexpr bool bare_shape = concepts::shape<Type>;
  static constexpr bool bare_decomposition = !bare_shape && concepts::decomposition<Type>;
  static constexpr bool bare_transport = is_named_transport<Type> || concepts::transport<Type>;
  static constexpr bool bare_part = requires { typename Type::talus_part_of; };

  static_assert(!bare_shape,
                "scenario<...> takes a shape inside bodies<...>: write bodies<sphere> for a bare "
                "sphere, and likewise for this shape");
  static_assert(!bare_decomposition,
                "scenario<...> takes a decomposition inside decomposition<...>: write "
                "decomposition<grid<2, 2>> for a bare grid<2, 2>, and likewise for this type");
  static_assert(!bare_transport,
                "scenario<...> takes a transport inside transport<...>: write transport<threads> "
                "for a bare threads, and likewise for this type");
  static_assert(!is_law_or_resistance<Type>,
                "scenario<...> takes the parts of a contact law inside soft_contact<...>: write "
                "soft_contact<linear_spring_dashpot> for a bare linear_spring_dashpot");
  static_assert(!is_part<Type, roles::contact_law> || is_law_or_resistance<Type>,
                "scenario<...> takes the parts of a contact law inside hard_contact<...>: write "
                "hard_contact<coulomb_friction> for a bare coulomb_friction");
  static_assert(
      !is_part<Type, roles::solver>,
      "scenario<...> takes a solver inside solver<...>: write "
      "solver<nonlinear_gauss_seidel> for a bare nonlinear_gauss_seidel, and likewise for "
      "accelerated_jacobi and substepping");
  static_assert(!is_part<Type, roles::broad_phase>,
                "scenario<...> takes a broad phase inside broad_phase<...>: write "
                "broad_phase<linear_hash_grid> for a bare linear_hash_grid");
  static_assert(!is_part<Type, roles::integrator>,
                "scenario<...> takes an integrator inside integrator<...>: write "
                "integrator<semi_implicit_euler> for a bare semi_implicit_euler");
  static_assert(!is_part<Type, roles::precision>,
                "scenario<...> takes a precision inside precision<...>: write "
                "precision<mixed_precision> for a bare mixed_precision");
  static_assert(!is_part<Type, roles::features>,
                "scenario<...> takes a feature inside features<...>: write features<orientation> "
                "for a bare orientation, and likewise for this type");
  static_assert(!is_part<Type, roles::joints>,
                "scenario<...> takes a joint inside joints<...>: write joints<ball_joint> for a "
                "bare ball_joint, and likewise for this type");
  static_assert(
      policy<Type> || bare_shape || bare_decomposition || bare_transport || bare_part,
      "scenario<...> takes talus policies only, and this type is not one: remove it, or use "
      "one of bodies, hard_contact, soft_contact, solver, broad_phase, integrator, decomposition, "
      "transport, precision, features, joints");
};

/// A policy refuses its own wrong arguments; outside of concepts, because compilers print more in
/// them.
template <class Type>
using examined_argument =
    std::conditional_t<spelled_as_policy<Type>, Type, examined<argument_of_scenario, Type>>;

}  // namespace detail

/// All decisions before the run. Policies in any order, each role at most once; the comment at each
/// member names the default.
template <class... Policies>
struct scenario final {
  static_assert((... && (sizeof(detail::examined_argument<Policies>) > 0)));
  static_assert(detail::at_most_one<roles::bodies, Policies...>,
                "scenario<...> names the role 'bodies' twice: put all shapes into one bodies<...>");
  static_assert(detail::at_most_one<roles::contact_law, Policies...>,
                "scenario<...> names the role 'contact law' twice: keep one hard_contact<...> or "
                "soft_contact<...>");
  static_assert(detail::at_most_one<roles::solver, Policies...>,
                "scenario<...> names the role 'solver' twice: keep one solver<...>");
  static_assert(detail::at_most_one<roles::broad_phase, Policies...>,
                "scenario<...> names the role 'broad phase' twice: keep one broad_phase<...>");
  static_assert(detail::at_most_one<roles::integrator, Policies...>,
                "scenario<...> names the role 'integrator' twice: keep one integrator<...>");
  static_assert(detail::at_most_one<roles::decomposition, Policies...>,
                "scenario<...> names the role 'decomposition' twice: keep one decomposition<...>");
  static_assert(detail::at_most_one<roles::transport, Policies...>,
                "scenario<...> names the role 'transport' twice: keep one transport<...>");
  static_assert(detail::at_most_one<roles::precision, Policies...>,
                "scenario<...> names the role 'precision' twice: keep one precision<...>");
  static_assert(detail::at_most_one<roles::features, Policies...>,
                "scenario<...> names the role 'features' twice: put all of them into one "
                "features<...>");
  static_assert(detail::at_most_one<roles::joints, Policies...>,
                "scenario<...> names the role 'joints' twice: put all of them into one "
                "joints<...>");

 private:
  template <class Role, class Default>
  using pick = detail::policy_for<Role, Default, Policies...>;

  using bodies_policy = pick<roles::bodies, talus::bodies<sphere, plane>>;
  using solver_policy = pick<roles::solver, talus::solver<nonlinear_gauss_seidel>>;
  using broad_phase_policy = pick<roles::broad_phase, talus::broad_phase<linear_hash_grid>>;
  using integrator_policy = pick<roles::integrator, talus::integrator<semi_implicit_euler>>;
  using decomposition_policy = pick<roles::decomposition, talus::decomposition<grid<dynamic>>>;
  using transport_policy = pick<roles::transport, talus::transport<threads>>;
  using precision_policy = pick<roles::precision, talus::precision<double>>;
  using features_policy = pick<roles::features, talus::features<>>;
  using joints_policy = pick<roles::joints, talus::joints<>>;
  using law_policy = pick<roles::contact_law,
                          hard_contact<coulomb_friction, newton_restitution, split_correction>>;

  static constexpr bool verlet = std::is_same_v<typename integrator_policy::type, velocity_verlet>;
  static_assert(!law_policy::soft || (... && !detail::plays<Policies, roles::solver>),
                "scenario<...> names a solver and soft_contact<...>, but soft contacts are forces "
                "and have nothing to solve: remove the solver, or use hard_contact<...>");
  template <class Feature>
  static constexpr bool names = detail::contains_type<typename features_policy::list, Feature>;
  static_assert(
      !law_policy::soft || !(names<continuous_collision> || names<sleeping>),
      "scenario<...> names soft_contact<...> and a feature that needs the impulses of hard "
      "contacts: remove continuous_collision and sleeping, or use hard_contact<...>");
  static_assert(!detail::law_takes_liquid<law_policy> || names<surface_liquid>,
                "scenario<...> names bridges from_films<...>, but its bodies carry no liquid: add "
                "features<surface_liquid>, or use the bridge without from_films");
  static_assert(detail::law_takes_liquid<law_policy> || !names<surface_liquid>,
                "scenario<...> names surface_liquid, and no contact law that takes liquid from the "
                "bodies: add from_films<willett_bridge> to soft_contact<...>");
  static_assert(!names<events> || !detail::law_forgets<law_policy>,
                "scenario<...> names events and a soft contact that remembers nothing, so that no "
                "contact would begin or end: add coulomb_friction to soft_contact<...>");
  static constexpr bool has_joints = joints_policy::list::size > 0;
  static_assert(!has_joints || !law_policy::soft,
                "scenario<...> names joints and soft_contact<...>, but joints are solved together "
                "with hard contacts: use hard_contact<...>");
  static_assert(!has_joints || law_policy::soft || law_policy::correction,
                "scenario<...> names joints and a contact law without a position correction, which "
                "keeps joints together: add split_correction to hard_contact<...>");
  static_assert(!has_joints || !names<continuous_collision>,
                "scenario<...> names joints and continuous_collision, which follows bodies without "
                "their joints: remove the feature, or the joints");
  /// Joints turn with their bodies.
  using oriented_features =
      std::conditional_t<has_joints && !names<orientation>,
                         detail::list_with<typename features_policy::list, orientation>,
                         typename features_policy::list>;
  using kept_features =
      std::conditional_t<verlet, detail::list_with<oriented_features, detail::contact_forces>,
                         oriented_features>;
  static constexpr bool in_double = std::is_same_v<typename precision_policy::type, double>;
  static_assert(in_double || !law_policy::soft,
                "scenario<...> names soft_contact<...> and a precision other than double, but soft "
                "contacts are computed in double: remove the precision, or use hard_contact<...>");
  static_assert(in_double || std::is_same_v<typename solver_policy::type, nonlinear_gauss_seidel> ||
                    detail::solves_by_colours<typename solver_policy::type>,
                "scenario<...> names a precision other than double and a solver that works in "
                "double: remove the precision, or use solver<nonlinear_gauss_seidel> or "
                "solver<reproducible>");
  static_assert(
      detail::rounds_as_written || !detail::solves_by_colours<typename solver_policy::type>,
      "scenario<...> names solver<reproducible> in a program compiled with -ffast-math or "
      "a part of it, after which results depend on the compiler: compile without it, or "
      "use solver<nonlinear_gauss_seidel>");
  static_assert(!names<balancing> ||
                    detail::is_movable_decomposition<typename decomposition_policy::type>,
                "scenario<...> names balancing and a decomposition that cannot move its cuts: use "
                "decomposition<bisection<dynamic>>, or remove balancing");
  static constexpr bool alone = std::is_same_v<typename transport_policy::type, serial>;
  static constexpr bool periodic = detail::is_periodic<typename decomposition_policy::type>;
  static_assert(!periodic || !alone,
                "scenario<...> names a periodic decomposition and transport<serial>, but a rank "
                "beside its own image talks to itself: use transport<threads>, on one rank too");
  static constexpr bool midpoint =
      std::is_same_v<typename integrator_policy::type, moreau_midpoint>;
  static_assert(!midpoint || !law_policy::soft,
                "scenario<...> names integrator<moreau_midpoint> and soft_contact<...>, whose "
                "forces need no velocities at the end of the step: use "
                "integrator<velocity_verlet>, or hard_contact<...>");
  static_assert(!midpoint || !detail::uses_substeps<typename solver_policy::type>,
                "scenario<...> names integrator<moreau_midpoint> and solver<substepping>, but both "
                "divide the step: keep one of them");
  static_assert(law_policy::soft || !verlet,
                "scenario<...> names integrator<velocity_verlet> and hard contacts, whose impulses "
                "are no forces that it could use: remove the integrator, or use "
                "soft_contact<...>");

 public:
  using shapes = typename bodies_policy::list;  ///< sphere and plane
  using contact_law = law_policy;               ///< friction, restitution and correction
  using solver = typename solver_policy::type;  ///< nonlinear_gauss_seidel
  using solver_on_request = typename solver_policy::on_request;  ///< none: void
  using broad_phase = typename broad_phase_policy::type;         ///< linear_hash_grid
  using integrator = typename integrator_policy::type;           ///< semi_implicit_euler
  using decomposition = typename decomposition_policy::type;     ///< a grid for any number of ranks
  using transport = typename transport_policy::type;             ///< threads
  using precision = typename precision_policy::type;             ///< double
  using features = std::conditional_t<                           ///< none
      !names<energy_ledger> || (!law_policy::soft && !has_joints), kept_features,
      detail::list_with<kept_features, std::conditional_t<has_joints, detail::joint_flows,
                                                          detail::contact_flows>>>;
  using joints = typename joints_policy::list;  ///< none

  template <class Shape>
  static constexpr bool has_shape = detail::contains_type<shapes, Shape>;
  template <class Feature>
  static constexpr bool has_feature = detail::contains_type<features, Feature>;

  /// Every policy in use, given or default, spelled as in scenarios, separated by spaces.
  [[gnu::cold]] static std::string describe() {
    using detail::describe_policy;
    return detail::joined_text(
        {describe_policy<bodies_policy>(), describe_policy<contact_law>(),
         contact_law::soft ? std::string() : describe_policy<solver_policy>(),
         describe_policy<broad_phase_policy>(), describe_policy<integrator_policy>(),
         describe_policy<decomposition_policy>(), describe_policy<transport_policy>(),
         describe_policy<precision_policy>(), describe_policy<features_policy>(),
         describe_policy<joints_policy>()},
        " ");
  }
};

namespace detail {

template <class Scenario, class Method>
struct scenario_with_solver;
template <class... Policies, class Method>
struct scenario_with_solver<scenario<Policies...>, Method> {
  using type = scenario<
      std::conditional_t<plays<Policies, roles::solver>, talus::solver<Method>, Policies>...>;
};

}  // namespace detail

/// Every policy of a scenario, for summaries and files.
template <class Scenario>
std::string describe() {
  return Scenario::describe();
}

namespace detail {

/// "this scenario has no bodies of this shape, box: add the shape to its bodies<...>".
template <class Shape>
[[nodiscard]] consteval auto words_on_missing_shape() {
  constexpr std::string_view words[] = {"this scenario has no bodies of this shape, ", Shape::name,
                                        ": add the shape to its bodies<...>"};
  char text[words[0].size() + words[1].size() + words[2].size() + 1] = {};
  char* to = text;
  for (const std::string_view w : words)
    for (const char c : w) *to++ = c;
  return sentence(text);
}
/// Whether functions that add a body take this shape. Others beside them, with the sentence, take
/// and refuse all others. clang does not print the sentence of a deleted function: there the
/// functions take all shapes, and refuse in their bodies.
template <class Scenario, class Shape>
inline constexpr bool takes_shape =
#ifdef __clang__
    true;
#else
    Scenario::template has_shape<Shape>;
#endif

/// Compilers begin a message with the name of what they instantiate, which has the sentence here:
/// before the place in the program, which may be deep in functions that it passes to others.
template <sentence Says, bool Taken>
struct refused {
  static_assert(Taken,
                "this scenario has no bodies of this shape: add the shape to its bodies<...>");
};
/// The sentence for functions that take shapes, and an error unless this one is taken.
template <class Shape, bool Taken>
[[nodiscard]] consteval auto missing_shape() {
  constexpr auto says = words_on_missing_shape<Shape>();
  (void)sizeof(refused<says, Taken>);
  return says;
}

// The sentences of refusals, on their own: if they fail within a constant expression, clang adds
// that the expression is not constant.
template <class Shape, class Scenario>
void body_of_scenario() {
  static_assert(Scenario::template has_shape<Shape>,
                "this scenario has no bodies of this shape: add the shape to its bodies<...>");
}
template <class Feature, class Scenario>
void feature_of_scenario() {
  static_assert(Scenario::template has_feature<Feature>,
                "this scenario does not have this feature: add it to its features<...>");
}
template <class Body>
inline constexpr bool is_described = requires(const Body& b) {
  b.shape, b.position;
};
template <class Body>
void body_that_is_added() {
  static_assert(
      is_described<Body>,
      "a body is added, and this type is not one: write body{.shape = sphere{0.5}, .position "
      "= place.position, .material = stone}");
}

template <class Kind, class Scenario>
void joint_of_scenario() {
  static_assert(contains_type<typename Scenario::joints, Kind>,
                "this scenario does not have this kind of joint: add it to its joints<...>");
}

/// Refuses a shape that is absent from the scenario, in one sentence. False after a refusal, so
/// that `if constexpr (require_shape<Scenario, Shape>())` suppresses further errors.
template <class Scenario, class Shape>
consteval bool require_shape() {
  if (false) body_of_scenario<Shape, Scenario>();  // compiled, not called
  return Scenario::template has_shape<Shape>;
}
/// Refuses an argument that is added as a body, if its shape is absent from the scenario, in one
/// sentence. The argument may be a bare shape. False after a refusal.
template <class Scenario, class Body>
consteval bool require_body() {
  if (false) body_that_is_added<Body>();
  if constexpr (is_described<Body>)
    return require_shape<Scenario, decltype(Body::shape)>();
  else
    return false;
}
/// Refuses a kind of joint that is absent from the scenario, in one sentence. False after a
/// refusal.
template <class Scenario, class Kind>
consteval bool require_joint() {
  if (false) joint_of_scenario<Kind, Scenario>();
  return contains_type<typename Scenario::joints, Kind>;
}
/// Refuses the use of a feature, such as user_ids, that is absent from the scenario, in one
/// sentence. False after a refusal.
template <class Scenario, class Feature>
consteval bool require_feature() {
  if (false) feature_of_scenario<Feature, Scenario>();
  return Scenario::template has_feature<Feature>;
}

}  // namespace detail
}  // namespace talus
