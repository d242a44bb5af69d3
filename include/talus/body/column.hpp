#pragma once
// A column is a quantity that bodies carry. Its description, a type, drives storage, messages,
// checkpoints, output and digests; see concepts::column and docs/features.md.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

#include "talus/concepts.hpp"
#include "talus/core/bytes.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/type_list.hpp"

namespace talus {

/// When a value is sent to other ranks; each mode includes those below it in this list.
enum class travels : std::uint8_t {
  with_every_refresh,  ///< to all shadow copies, at the end of each step
  when_changed,        ///< to shadow copies when these are made, or after a change by the user
  on_migration,        ///< to the new owner of the body alone; shadow copies have the default
  never                ///< not at all: a new owner starts with the default
};

namespace detail {

/// A value to be overwritten.
template <class T>
[[nodiscard]] T blank() {
  if constexpr (requires { T::Zero(); })
    return T::Zero();
  else if constexpr (requires { T::Identity(); })
    return T::Identity();
  else
    return T{};
}

// Optional members of a description, with their defaults.

/// A column of talus: its values are a named member of `storage`, which hot code accesses by name.
template <class Column>
concept named_column = requires {
  typename Column::storage;
};
template <class Column>
[[nodiscard]] consteval travels travel_of() {
  if constexpr (requires { Column::travel; })
    return Column::travel;
  else
    return travels::with_every_refresh;
}
template <class Column>
[[nodiscard]] consteval bool in_checkpoint() {
  if constexpr (requires { Column::in_checkpoint; })
    return Column::in_checkpoint;
  else
    return true;
}
template <class Column>
[[nodiscard]] consteval bool in_output() {
  if constexpr (requires { Column::in_output; })
    return Column::in_output;
  else
    return !named_column<Column>;
}
/// Whether state_digest() includes a column. Of the built-in columns it includes the pose and the
/// velocities.
template <class Column>
[[nodiscard]] consteval bool in_digest() {
  if constexpr (requires { Column::in_digest; })
    return Column::in_digest;
  else
    return !named_column<Column>;
}
template <class Column, class Shape>
[[nodiscard]] consteval bool carried_by() {
  if constexpr (requires { Column::template carried_by<Shape>; })
    return Column::template carried_by<Shape>;
  else
    return true;
}
template <class Column>
[[nodiscard]] constexpr const char* unit_of() {
  if constexpr (requires { Column::unit; })
    return Column::unit;
  else
    return "";
}
template <class Column>
[[nodiscard]] typename Column::value_type initial_of() {
  if constexpr (requires { Column::initial; })
    return Column::initial;
  else
    return blank<typename Column::value_type>();
}

/// The storage of the values of a column.
template <class Column>
struct values_of_column {
  vector_of<typename Column::value_type> values;
};
template <class Column>
struct column_member {
  using storage = values_of_column<Column>;
  static constexpr auto member = &storage::values;
};
template <named_column Column>
struct column_member<Column> {
  using storage = typename Column::storage;
  static constexpr auto member = Column::member;
};

// Lists of columns.

template <class Columns, class Shape>
struct columns_carried_by;
template <class... Columns, class Shape>
struct columns_carried_by<type_list<Columns...>, Shape> {
  using type = join_lists<
      std::conditional_t<carried_by<Columns, Shape>(), type_list<Columns>, type_list<>>...>;
};
template <class Columns, travels Least>
struct columns_that_travel;
template <class... Columns, travels Least>
struct columns_that_travel<type_list<Columns...>, Least> {
  using sent = join_lists<
      std::conditional_t<(travel_of<Columns>() <= Least), type_list<Columns>, type_list<>>...>;
  using rest = join_lists<
      std::conditional_t<(travel_of<Columns>() > Least), type_list<Columns>, type_list<>>...>;
};
/// A column that appears twice is stored once; places of talus first, then names, so that the order
/// does not depend on the user's order of the features.
template <class Columns>
struct columns_sorted;
template <>
struct columns_sorted<type_list<>> {
  using type = type_list<>;
};
template <class Column>
struct columns_sorted<type_list<Column>> {
  using type = type_list<Column>;
};
template <class Column>
[[nodiscard]] consteval int place_of() {
  if constexpr (requires { Column::place; })
    return Column::place;
  else
    return 1000;
}
template <class... Columns>
requires(sizeof...(Columns) > 1) struct columns_sorted<type_list<Columns...>> {
  static constexpr std::size_t size = sizeof...(Columns);
  struct sorted_places {
    std::array<std::size_t, size> at{};
  };
  static constexpr sorted_places order = [] {
    constexpr std::array<int, size> places{place_of<Columns>()...};
    constexpr std::array<std::string_view, size> names{Columns::name...};
    sorted_places sorted;
    for (std::size_t n = 0; n < size; ++n) {
      std::size_t k = n;
      for (; k > 0; --k) {
        const std::size_t before = sorted.at[k - 1];
        if (places[before] < places[n] ||
            (places[before] == places[n] && names[before] <= names[n]))
          break;
        sorted.at[k] = before;
      }
      sorted.at[k] = n;
    }
    return sorted;
  }();
  template <std::size_t... I>
  static auto in_order(std::index_sequence<I...>)
      -> type_list<std::tuple_element_t<order.at[I], std::tuple<Columns...>>...>;
  using type = unique_types<decltype(in_order(std::make_index_sequence<size>{}))>;
};
template <class Columns>
using sorted_columns = typename columns_sorted<Columns>::type;

template <class Columns>
struct columns_by_use;
template <class... Columns>
struct columns_by_use<type_list<Columns...>> {
  using saved =
      join_lists<std::conditional_t<in_checkpoint<Columns>(), type_list<Columns>, type_list<>>...>;
  using unsaved =
      join_lists<std::conditional_t<in_checkpoint<Columns>(), type_list<>, type_list<Columns>>...>;
  using named =
      join_lists<std::conditional_t<named_column<Columns>, type_list<Columns>, type_list<>>...>;
  using shown =
      join_lists<std::conditional_t<in_output<Columns>(), type_list<Columns>, type_list<>>...>;
  using hashed =
      join_lists<std::conditional_t<in_digest<Columns>(), type_list<Columns>, type_list<>>...>;
};

/// The columns of talus itself in a list.
template <class Columns>
using named_columns = typename columns_by_use<Columns>::named;

/// The columns of a feature; empty by default.
template <class Feature>
struct columns_of_feature {
  using type = type_list<>;
};
template <class Feature>
requires requires { typename Feature::columns; }
struct columns_of_feature<Feature> {
  using type = typename Feature::columns;
};

}  // namespace detail
}  // namespace talus
