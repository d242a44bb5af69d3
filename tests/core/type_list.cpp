#include "talus/core/type_list.hpp"

#include <doctest/doctest.h>

#include <string>
#include <type_traits>
#include <vector>

using namespace talus;
using namespace talus::detail;

namespace {
struct a {};
struct b {};
struct c {};
template <class T>
struct is_b : std::is_same<T, b> {};
template <class T>
struct is_c : std::is_same<T, c> {};
template <class T>
struct box_of {};
using ab = type_list<a, b>;
}  // namespace

TEST_CASE("a list knows what it contains and where") {
  static_assert(contains_type<ab, a> && contains_type<ab, b> && !contains_type<ab, c>);
  static_assert(!contains_type<type_list<>, a>);
  static_assert(index_of<ab, a> == 0 && index_of<ab, b> == 1);
  static_assert(index_of<type_list<c, b, b>, b> == 1);
  CHECK(ab::size == 2);
}

TEST_CASE("equal types are dropped in order") {
  static_assert(std::is_same_v<unique_types<type_list<a, b, a, c, b>>, type_list<a, b, c>>);
  static_assert(std::is_same_v<unique_types<type_list<>>, type_list<>>);
  static_assert(all_different<ab> && !all_different<type_list<a, b, a>>);
  static_assert(all_different<type_list<>>);
}

TEST_CASE("lists are filtered, searched and mapped") {
  static_assert(std::is_same_v<filter_types<type_list<b, a, b>, is_b>, type_list<b, b>>);
  static_assert(std::is_same_v<filter_types<ab, is_c>, type_list<>>);
  static_assert(std::is_same_v<find_type<ab, is_b, int>, b>);
  static_assert(std::is_same_v<find_type<ab, is_c, int>, int>);
  static_assert(std::is_same_v<find_type<type_list<>, is_c, int>, int>);
  static_assert(std::is_same_v<map_types<ab, box_of>, type_list<box_of<a>, box_of<b>>>);
  static_assert(
      std::is_same_v<map_to_tuple<ab, std::vector>, std::tuple<std::vector<a>, std::vector<b>>>);
}

TEST_CASE("types are visited in order") {
  std::string seen;
  for_each_type<type_list<char, int>>(
      [&](auto type) { seen += std::to_string(sizeof(typename decltype(type)::type)); });
  CHECK(seen == "14");
}
