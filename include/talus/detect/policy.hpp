#pragma once
// broad_phase<...>: the search for candidate pairs.
#include "talus/core/policy.hpp"

namespace talus {

class hash_grid;

/// Cells in a linear hash, with one level of cells for each size class, rebuilt for each search.
struct linear_hash_grid final {
  using talus_part_of = roles::broad_phase;
  using search = hash_grid;
  static constexpr const char* name = "linear_hash_grid";
};

/// Policy: the broad phase. Default: broad_phase<linear_hash_grid>.
template <class Method>
struct broad_phase final {
  static_assert(detail::is_part<Method, roles::broad_phase>,
                "broad_phase<...> takes a broad phase, and this type is not one: write "
                "broad_phase<linear_hash_grid> or broad_phase<sweep_and_prune>");
  static_assert(
      !detail::is_part<Method, roles::broad_phase> || requires { typename Method::search; },
      "broad_phase<...> takes a broad phase with a type `search` that finds pairs, as "
      "concepts::pair_search says, and this one has none: write broad_phase<linear_hash_grid>, or "
      "give it one");
  using talus_role = roles::broad_phase;
  using type = Method;
  static std::string describe() { return detail::describe_list<Method>("broad_phase"); }
};

}  // namespace talus
