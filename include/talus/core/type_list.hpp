#pragma once
// Lists of types and the operations on them that talus needs, on top of Boost.Hana. Only the used
// parts of Hana are included: all of it costs four times as much to compile.
#include <boost/hana/append.hpp>
#include <boost/hana/bool.hpp>
#include <boost/hana/contains.hpp>
#include <boost/hana/filter.hpp>
#include <boost/hana/find_if.hpp>
#include <boost/hana/fold_left.hpp>
#include <boost/hana/for_each.hpp>
#include <boost/hana/if.hpp>
#include <boost/hana/optional.hpp>
#include <boost/hana/tuple.hpp>
#include <boost/hana/type.hpp>
#include <cstddef>
#include <tuple>
#include <type_traits>

namespace talus {

/// A list of types, itself an empty value.
template <class... Types>
struct type_list {
  static constexpr std::size_t size = sizeof...(Types);
};

namespace detail {

namespace hana = boost::hana;

template <class... Types>
constexpr auto to_hana(type_list<Types...>) {
  return hana::tuple_t<Types...>;
}
template <class... Types>
constexpr auto from_hana(hana::tuple<Types...>) {
  return type_list<typename Types::type...>{};
}

/// List of types of a Hana computation, e.g. list_of<decltype(hana::filter(...))>.
template <class HanaTuple>
using list_of = decltype(from_hana(HanaTuple{}));

template <class List, class Type>
inline constexpr bool contains_type = false;
template <class... Types, class Type>
inline constexpr bool contains_type<type_list<Types...>, Type> = (std::is_same_v<Types, Type> ||
                                                                  ...);

template <class HanaValue>
using plain = std::remove_cvref_t<HanaValue>;

/// Position of the first `Type` in `List`; does not compile if `List` lacks it.
template <class List, class Type>
inline constexpr std::size_t index_of = 0;
template <class... Types, class Type>
inline constexpr std::size_t index_of<type_list<Types...>, Type> = [] {
  static_assert((std::is_same_v<Types, Type> || ...), "this type is not in the list");
  std::size_t i = 0;
  (void)((std::is_same_v<Types, Type> || (++i, false)) || ...);
  return i;
}();

struct append_new {
  template <class Kept, class Type>
  constexpr auto operator()(Kept kept, Type type) const {
    return hana::if_(hana::contains(kept, type), kept, hana::append(kept, type));
  }
};
/// `List` without repeated types; the order of first occurrences stays.
template <class List>
using unique_types =
    list_of<decltype(hana::fold_left(to_hana(List{}), hana::tuple<>{}, append_new{}))>;

template <class List>
inline constexpr bool all_different = unique_types<List>::size == List::size;

/// A predicate for Hana from a template with a `value`.
template <template <class> class Predicate>
struct predicate {
  template <class Type>
  constexpr auto operator()(Type) const {
    return hana::bool_c<Predicate<typename Type::type>::value>;
  }
};

/// The types for which `Predicate<Type>::value` is true.
template <class List, template <class> class Predicate>
using filter_types = list_of<decltype(hana::filter(to_hana(List{}), predicate<Predicate>{}))>;

/// The first type with `Predicate<Type>::value`, or `Default`.
template <class List, template <class> class Predicate, class Default>
using find_type = typename plain<decltype(hana::find_if(to_hana(List{}), predicate<Predicate>{})
                                              .value_or(hana::type_c<Default>))>::type;

template <class List, template <class> class F>
struct map_types_in;
template <class... Types, template <class> class F>
struct map_types_in<type_list<Types...>, F> {
  using list = type_list<F<Types>...>;
  using tuple = std::tuple<F<Types>...>;
};
/// type_list<F<A>, F<B>, ...>.
template <class List, template <class> class F>
using map_types = typename map_types_in<List, F>::list;
/// std::tuple<F<A>, F<B>, ...>: one F for each type, e.g. one storage for each shape.
template <class List, template <class> class F>
using map_to_tuple = typename map_types_in<List, F>::tuple;

template <class... Lists>
struct lists_joined {
  using type = type_list<>;
};
template <class... A>
struct lists_joined<type_list<A...>> {
  using type = type_list<A...>;
};
template <class... A, class... B, class... Rest>
struct lists_joined<type_list<A...>, type_list<B...>, Rest...>
    : lists_joined<type_list<A..., B...>, Rest...> {};
/// One list of the types of several, in order.
template <class... Lists>
using join_lists = typename lists_joined<Lists...>::type;

/// Calls f(hana::type_c<A>), f(hana::type_c<B>), ...; `typename decltype(x)::type` is the type.
template <class List, class F>
constexpr void for_each_type(F&& f) {
  hana::for_each(to_hana(List{}), f);
}

}  // namespace detail
}  // namespace talus
