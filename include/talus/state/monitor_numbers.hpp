#pragma once
// The numbers of the monitors and of the states of features on one rank, to store them in a
// checkpoint.
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "talus/core/exact_sum.hpp"
#include "talus/state/monitors.hpp"

namespace talus::detail {

/// The value over all ranks: the sum of a number over the ranks, or the largest. A rest belongs to
/// the sum before it: what the numbers before leave.
enum class over_ranks { sum, rest, largest };

/// The argument of `each_number(visit)` of a record: visit.sum(x) and visit.largest(x) name a
/// number, and its reduction over all ranks.
template <class F>
class number_visitor {
 public:
  explicit number_visitor(F& f) : f_(f) {}

  void sum(double& x) { f_(x, over_ranks::sum); }
  void sum(vec3& v) {
    for (int k = 0; k < 3; ++k) sum(v[k]);
  }
  /// The nearest number, that of what is left, and so on.
  void sum(signed_sum& x) {
    std::array<double, parts_of_sum> parts;
    signed_sum left = x;
    for (double& part : parts) part = left.value(), left -= part;
    const auto before = parts;
    for (double& part : parts) f_(part, &part == parts.data() ? over_ranks::sum : over_ranks::rest);
    if (parts == before) return;
    x = {};
    for (const double part : parts) x += part;
  }
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
  /// Their digits cover the terms of a sum, unless these differ by more than 10^60 in size.
  static constexpr std::size_t parts_of_sum = 4;

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

/// Calls f(number, over_ranks) for the numbers that a record, or the state of a feature, passes to
/// a visitor.
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
