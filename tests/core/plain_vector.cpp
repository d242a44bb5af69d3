#include "talus/core/plain_vector.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <new>
#include <random>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "talus/core/plain_pair.hpp"
#include "talus/core/sort.hpp"

using namespace talus::detail;

namespace {

struct alignas(64) wide {
  double value = 7;
};

template <class T>
void same(const plain_vector<T>& a, const std::vector<T>& b) {
  REQUIRE(a.size() == b.size());
  CHECK(a.capacity() >= a.size());
  CHECK(a.empty() == b.empty());
  CHECK(std::vector<T>(a.begin(), a.end()) == b);
}

}  // namespace

TEST_CASE("a plain_vector holds what a std::vector holds, whatever is done to it") {
  plain_vector<int> a;
  std::vector<int> b;
  std::mt19937 any(5);
  for (int step = 0; step < 4000; ++step) {
    const int value = static_cast<int>(any() % 1000);
    const std::size_t at = b.empty() ? 0 : any() % b.size(), n = any() % 40;
    const auto offset = static_cast<std::ptrdiff_t>(at);
    switch (any() % 12) {
      case 0:
        a.resize(n), b.resize(n);
        break;
      case 1:
        a.resize(n, value), b.resize(n, value);
        break;
      case 2:
        a.assign(n, value), b.assign(n, value);
        break;
      case 3:
        if (step % 10 == 0) a.clear(), b.clear();
        break;
      case 4:
        if (!b.empty()) a.erase(a.begin() + at), b.erase(b.begin() + offset);
        break;
      case 5:
        if (!b.empty()) a.erase(a.begin() + at, a.end()), b.erase(b.begin() + offset, b.end());
        break;
      case 6:
        a.insert(a.begin() + at, value), b.insert(b.begin() + offset, value);
        break;
      case 7:
        if (!b.empty()) a.push_back(a[at]), b.push_back(int{b[at]});
        break;
      case 8:
        a = plain_vector<int>(a), b = std::vector<int>(b);
        break;
      case 9:
        if (!b.empty()) a.pop_back(), b.pop_back();
        break;
      default:
        a.push_back(value), b.push_back(value);
        break;
    }
    same(a, b);
  }
}

TEST_CASE("values of its own may be given to a plain_vector that has to grow") {
  plain_vector<std::array<double, 3>> list{{1, 2, 3}};
  for (int i = 0; i < 20; ++i) list.push_back(list[0]);
  list.resize(100, list.back());
  list.assign(300, list[50]);
  CHECK(list[299] == std::array<double, 3>{1, 2, 3});
}

TEST_CASE("what is moved from is empty, and copies are their own") {
  plain_vector<int> a{1, 2, 3};
  plain_vector<int> b = std::move(a);
  CHECK(a.empty());
  a = b;
  a[0] = 9;
  CHECK(b[0] == 1);
  a = std::move(b);
  CHECK(b.empty());
  CHECK(a == plain_vector<int>{1, 2, 3});
  swap(a, b);
  CHECK(a.empty());
  a = a;
  b = static_cast<const plain_vector<int>&>(b);
  CHECK(b.size() == 3);
}

TEST_CASE("values lie where their alignment demands, and have their defaults") {
  plain_vector<wide> list(3);
  for (int i = 0; i < 100; ++i) {
    list.push_back({double(i)});
    CHECK(reinterpret_cast<std::uintptr_t>(list.data()) % 64 == 0);
  }
  CHECK(list[0].value == 7);
  CHECK(list.back().value == 99);
}

TEST_CASE("plain_vectors compare as dictionaries do") {
  using list = plain_vector<int>;
  CHECK(list{1, 2} < list{1, 3});
  CHECK(list{1} < list{1, 0});
  CHECK(!(list{1, 2} < list{1, 2}));
  CHECK(!(list{2} < list{1, 2}));
  CHECK(!(list{1} == list{1, 1}));
}

TEST_CASE("what owns memory is not plain") {
  static_assert(std::is_same_v<vector_of<int>, plain_vector<int>>);
  static_assert(std::is_same_v<vector_of<std::string>, std::vector<std::string>>);
  using pair = std::pair<int, int>;  // its assignment is its own
  static_assert(std::is_same_v<vector_of<pair>, std::vector<pair>>);
  static_assert(
      std::is_same_v<vector_of<plain_pair<int, int>>, plain_vector<plain_pair<int, int>>>);
  CHECK_THROWS_AS(plain_vector<int>(~std::size_t{0} / 2), std::bad_alloc);
}

TEST_CASE("short lists are sorted") {
  plain_vector<plain_pair<double, int>> list;
  std::mt19937 any(3);
  for (int i = 0; i < 500; ++i) list.push_back({static_cast<double>(any() % 50), i});
  auto down = list;
  sort_values(list);
  CHECK(std::is_sorted(list.begin(), list.end()));
  sort_values(down, [](const auto& a, const auto& b) { return b < a; });
  CHECK(std::is_sorted(down.begin(), down.end(), [](auto& a, auto& b) { return b < a; }));
}
