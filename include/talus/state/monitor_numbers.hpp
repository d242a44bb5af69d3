#pragma once
// The numbers of the monitors and of the states of features on one rank, to store them in a
// checkpoint.
#include <cmath>
#include <cstdint>
#include <vector>

#include "talus/core/exact_sum.hpp"
#include "talus/state/monitors.hpp"

namespace talus::detail {

/// The value over all ranks: the sum of a number over the ranks, or the largest.
enum class over_ranks { sum, largest };

/// Numbers whose sum is exactly that one: the nearest number, that of what is left, and so on. The
/// last is not finite if the sum is not.
[[nodiscard, gnu::cold]] inline std::vector<double> parts_of(signed_sum left) {
  std::vector<double> parts;
  for (double part = left.value(); part != 0; part = left.value()) {
    parts.push_back(part);
    if (!std::isfinite(part)) break;
    left -= part;
  }
  return parts;
}

/// The argument of `each_number(visit)` of a record: visit.sum(x) and visit.largest(x) name a
/// number, and its reduction over all ranks. Calls f(number, over_ranks), and f(signed_sum) for
/// exact sums.
template <class F>
class number_visitor {
 public:
  explicit number_visitor(F& f) : f_(f) {}

  void sum(double& x) { f_(x, over_ranks::sum); }
  void sum(vec3& v) {
    for (int k = 0; k < 3; ++k) sum(v[k]);
  }
  void sum(signed_sum& x) { f_(x); }
  void sum(vector_sum& x) {
    for (signed_sum& part : x.parts) sum(part);
  }
  void sum(exact_sum& x) {
    signed_sum whole;
    whole.plus = x;
    sum(whole);
    exact_sum::cancel(whole.plus, whole.minus);
    x = whole.plus;
  }
  void sum(std::uint64_t& n) {
    auto x = static_cast<double>(n);
    sum(x);
    n = x >= 0 && x < 9e15 ? static_cast<std::uint64_t>(x) : 0;
  }
  void largest(double& x) { f_(x, over_ranks::largest); }
  void largest(bool& b) {
    double x = b;
    largest(x);
    b = x != 0;
  }
  template <class... Numbers>
  void sums(Numbers&... numbers) {
    (sum(numbers), ...);
  }

 private:
  F& f_;
};

/// The argument of `each_list(visit)` of the state of a feature: visit.alike(list) names a list of
/// 64-bit numbers that is the same on all ranks.
template <class F>
class list_visitor {
 public:
  explicit list_visitor(F& f) : f_(f) {}

  void alike(std::vector<std::uint64_t>& list) { f_(list); }

 private:
  F& f_;
};

/// Calls f for the numbers that a record, or the state of a feature, passes to a visitor.
template <class Record, class F>
void each_number(Record& record, F&& f) {
  number_visitor visit(f);
  record.each_number(visit);
}

/// Calls f(name, record) for the monitors that the scenario names.
template <class... Features, class F>
void each_record_of(monitor_records<type_list<Features...>>& all, F& f) {
  const auto visit = [&]<class Feature>(type_list<Feature>) {
    if constexpr (requires { typename Feature::record; })
      static_cast<record_slot<Feature>&>(all).each_record(f);
  };
  (visit(type_list<Features>{}), ...);
}

}  // namespace talus::detail
