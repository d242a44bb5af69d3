#pragma once
// The data of a run in a checkpoint besides bodies and contacts.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/core/type_list.hpp"
#include "talus/io/detail/checkpoint_reader.hpp"
#include "talus/io/detail/checkpoint_writer.hpp"
#include "talus/world/fresh_start.hpp"
#include "talus/world/run_parameters.hpp"

namespace talus::detail {

/// A parameter that the set-up sets as in the run that wrote the file continues with its value at
/// the end of that run; a different one is an intended change, and is returned in words.
template <class State>
[[nodiscard, gnu::cold]] std::string merge_parameters(State& s, const parameters& at_first,
                                                      const parameters& at_last) {
  std::string changes;
  each_parameter(s, [&](std::size_t k, auto& value) {
    constexpr bool whole = std::is_integral_v<std::remove_cvref_t<decltype(value)>>;
    if (!(std::abs(at_last[k]) < (whole ? 2e9 : 1e300)) || !std::isfinite(at_first[k]))
      fail<std::runtime_error>("says that {} is {}, which makes no sense", parameter_names[k],
                               at_last[k]);
    const auto mine = static_cast<double>(value);
    const bool as_before = k == 0 ? mine == 0 : mine == at_first[k];  // dt: not yet set
    if (as_before) {
      value = static_cast<std::remove_cvref_t<decltype(value)>>(at_last[k]);
    } else if (mine != at_last[k]) {
      if (!changes.empty()) changes += ", ";
      changes += compose("{} is {} and was {}", parameter_names[k], mine, at_last[k]);
    }
  });
  return changes;
}

/// The properties in which the writing and the reading scenario must agree. Transport,
/// decomposition, solver, broad phase, precision and monitors may differ.
struct scenario_mark {
  std::string name, text;
};
template <class... Types>
[[nodiscard]] std::string list_text(type_list<Types...>, const char* name) {
  return describe_list<Types...>(name);
}
/// Writes a sorted list as features<checkpoints, driven> has it.
[[nodiscard, gnu::cold]] std::string sorted_list_text(const char* name,
                                                      std::vector<std::string> items);
template <class Scenario>
[[nodiscard, gnu::cold]] std::vector<scenario_mark> marks_of() {
  std::vector<std::string> features;
  for_each_type<typename Scenario::features>([&](auto type) {
    using feature = typename decltype(type)::type;
    constexpr bool of_bodies =
        !checkpoints_may_differ<feature> ||
        (Scenario::contact_law::soft && std::is_same_v<feature, energy_ledger>);
    if constexpr (of_bodies && concepts::feature<feature>) features.push_back(feature::name);
  });
  const std::string joints = Scenario::joints::size == 0
                                 ? std::string()
                                 : " " + list_text(typename Scenario::joints{}, "joints");
  return {{"bodies", list_text(typename Scenario::shapes{}, "bodies")},
          {"contacts", describe_policy<typename Scenario::contact_law>()},
          {"integrator", describe_policy<typename Scenario::integrator>()},
          {"features", sorted_list_text("features", std::move(features)) + joints}};
}

/// Numbers of a material, as they are stored.
[[nodiscard, gnu::cold]] std::array<double, 8> numbers_of(const material& m);
[[nodiscard, gnu::cold]] std::vector<double> numbers_of(const material_table& all);
/// The pairs that have properties of their own: both numbers, restitution, friction, dynamic
/// friction.
[[nodiscard, gnu::cold]] std::vector<double> numbers_of_pairs(const material_table& all);
/// The rules for pairs, of restitution and friction.
[[nodiscard, gnu::cold]] std::vector<double> numbers_of(const pair_rules& rules);
/// Throws runtime_error if the set-up has made other materials, or set other rules.
[[gnu::cold]] void require_materials(const checkpoint_reader& in, const material_table& mine);

/// Kept values: names, their meanings with numbers of bytes, and the bytes.
[[nodiscard, gnu::cold]] std::string names_of(const std::vector<kept_value>& values);
/// Collective, because of the sums.
[[gnu::cold]] void put_kept(checkpoint_team& team, const std::string& group,
                            const std::vector<kept_value>& values, std::vector<small_dataset>& out);
/// The bytes of values, with sums over all ranks on rank 0. Collective.
[[nodiscard, gnu::cold]] byte_buffer bytes_of_kept(checkpoint_team& team,
                                                   const std::vector<kept_value>& values);
/// Sets values from such bytes, which may end before the last of them.
[[gnu::cold]] void set_kept_in_order(const byte_buffer& bytes, int rank,
                                     const std::vector<kept_value>& values);
/// The values after each call of simulate() that has ended; nothing if no value is kept.
[[gnu::cold]] void put_kept_after_calls(const std::vector<byte_buffer>& all,
                                        std::vector<small_dataset>& out);
/// Empty for a file without them.
[[nodiscard, gnu::cold]] std::vector<byte_buffer> get_kept_after_calls(const checkpoint_reader& in);
/// Throws runtime_error unless the file has kept the same values by world.keep().
[[gnu::cold]] void require_kept(const checkpoint_reader& in, const std::vector<kept_value>& values);
/// Sets those of the values that a file has.
[[gnu::cold]] void get_kept(const checkpoint_reader& in, const std::string& group, int rank,
                            const std::vector<kept_value>& values);

}  // namespace talus::detail

#ifndef TALUS_COMPILED_HDF5
#include "talus/io/detail/checkpoint_parameters_definitions.hpp"
#endif
