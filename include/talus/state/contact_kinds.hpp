#pragma once
// The kind of contact of two shapes, decided at compile time, per pair of shapes.
#include <tuple>
#include <type_traits>

#include "talus/constraint/general_contact.hpp"
#include "talus/constraint/isotropic_contact.hpp"
#include "talus/core/type_list.hpp"
#include "talus/solver/contact_list.hpp"
#include "talus/solver/usual_contacts.hpp"

namespace talus::detail {

template <class Shape>
inline constexpr contact_side side_of =
    Shape::isotropic ? contact_side::scalar : contact_side::tensor;

/// Contact of two bodies that can move.
template <class Law, class A, class B, class Real = real>
using moving_contact =
    std::conditional_t<A::isotropic && B::isotropic,
                       isotropic_contact<contact_rows<Law>, partner::moving, Real>,
                       general_contact<contact_rows<Law>, side_of<A>, side_of<B>, Real>>;

/// Contact of a body that can move with a global one.
template <class Law, class A, class Real = real>
using anchored_contact = std::conditional_t<
    A::isotropic, isotropic_contact<contact_rows<Law>, partner::immovable, Real>,
    general_contact<contact_rows<Law>, side_of<A>, contact_side::immovable, Real>>;

/// Contact of a body that can move with a global one that may have a velocity; the solver's arrays
/// then contain global bodies. It is one of the kinds of contacts between movable bodies.
template <class Law, class A, class Real = real>
using driven_contact = moving_contact<Law, A, A, Real>;

template <class Law, class Real, template <class> class List, bool Driven, class A>
struct contacts_of_one {
  template <class B>
  static auto pair_with() {
    if constexpr (A::finite && B::finite)
      return type_list<List<moving_contact<Law, A, B, Real>>>{};
    else
      return type_list<>{};
  }
  static auto anchored() {
    if constexpr (A::finite && !Driven)
      return type_list<List<anchored_contact<Law, A, Real>>>{};
    else
      return type_list<>{};
  }
};

template <class Shapes, class Law, class Real, template <class> class List, bool Driven>
struct contact_lists_for;
template <class... Shapes, class Law, class Real, template <class> class List, bool Driven>
struct contact_lists_for<type_list<Shapes...>, Law, Real, List, Driven> {
  template <class A>
  using of_one = join_lists<
      decltype(contacts_of_one<Law, Real, List, Driven, A>::template pair_with<Shapes>())...,
      decltype(contacts_of_one<Law, Real, List, Driven, A>::anchored())>;
  using all = unique_types<join_lists<of_one<Shapes>...>>;
};

template <class List>
struct as_tuple;
template <class... Ts>
struct as_tuple<type_list<Ts...>> {
  using type = std::tuple<Ts...>;
};

/// std::tuple of the contact lists for the shapes of a scenario, each kind once. `Real` is the
/// scalar in which they are solved, `List` stores the contacts of one kind.
template <class Shapes, class Law, class Real = real, template <class> class List = contact_list,
          bool Driven = false>
using contact_lists_of =
    typename as_tuple<typename contact_lists_for<Shapes, Law, Real, List, Driven>::all>::type;

}  // namespace talus::detail
