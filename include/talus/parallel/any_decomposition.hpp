#pragma once
// A decomposition chosen at run time.
#include <limits>
#include <memory>
#include <type_traits>
#include <utility>

#include "talus/concepts.hpp"
#include "talus/geometry/any_geometry.hpp"
#include "talus/parallel/bisection.hpp"

namespace talus {

/// The partition of any decomposition. Each query costs a virtual call.
class any_partition {
 public:
  template <class Partition>
  requires(!std::same_as<Partition, any_partition> &&
           concepts::partition<Partition>) explicit any_partition(Partition cells)
      : cells_(std::make_shared<const of<Partition>>(std::move(cells))) {}

  [[nodiscard]] int size() const { return cells_->size(); }
  [[nodiscard]] int owner(const vec3& p) const { return cells_->owner(p); }
  [[nodiscard]] std::vector<int> neighbours(int rank, real reach) const {
    return cells_->neighbours(rank, reach);
  }
  [[nodiscard]] any_geometry geometry(int rank) const { return cells_->geometry(rank); }
  [[nodiscard]] std::pair<vec3, vec3> bounds(int rank) const { return cells_->bounds(rank); }
  [[nodiscard]] std::vector<int> closed(int rank) const { return cells_->closed(rank); }

 private:
  struct offers {
    virtual ~offers() = default;
    virtual int size() const = 0;
    virtual int owner(const vec3& p) const = 0;
    virtual std::vector<int> neighbours(int rank, real reach) const = 0;
    virtual any_geometry geometry(int rank) const = 0;
    virtual std::pair<vec3, vec3> bounds(int rank) const = 0;
    virtual std::vector<int> closed(int rank) const = 0;
  };
  template <class Partition>
  struct of final : offers {
    explicit of(Partition p) : cells(std::move(p)) {}
    int size() const override { return cells.size(); }
    int owner(const vec3& p) const override { return cells.owner(p); }
    std::vector<int> neighbours(int rank, real reach) const override {
      return cells.neighbours(rank, reach);
    }
    any_geometry geometry(int rank) const override { return cells.geometry(rank); }
    std::pair<vec3, vec3> bounds([[maybe_unused]] int rank) const override {
      if constexpr (requires { cells.bounds(rank); }) return cells.bounds(rank);
      if constexpr (requires { cells.cell(rank).lower[0]; }) {
        const auto [lower, upper] = cells.cell(rank);
        return {vec3(lower[0], lower[1], lower[2]), vec3(upper[0], upper[1], upper[2])};
      }
      constexpr real infinity = std::numeric_limits<real>::infinity();
      return {detail::thrice<real>(-infinity), detail::thrice<real>(infinity)};
    }
    std::vector<int> closed([[maybe_unused]] int rank) const override {
      if constexpr (concepts::closing_partition<Partition>) return cells.closed(rank);
      return {};
    }
    Partition cells;
  };
  std::shared_ptr<const offers> cells_;  // immutable, so copies may share it
};

/// Any decomposition that generates its connections, as a value, for programs that let the user
/// choose. If the choice is known at compile time, the decomposition itself is faster and smaller.
///   scenario<..., decomposition<any_decomposition>>
///   world.decompose(hexagonal ? any_decomposition(hexagonal<dynamic>{...}) : grid<dynamic>{...});
/// The default fits one rank only. features<balancing> requires bisection<dynamic>.
class any_decomposition {
 public:
  any_decomposition() = default;
  template <class Decomposition>
  requires(!std::same_as<Decomposition, any_decomposition> &&
           concepts::generating_decomposition<Decomposition>)
      any_decomposition(Decomposition d)  // NOLINT: every decomposition is one of any
      : made_of_(std::make_shared<const of<Decomposition>>(std::move(d))) {}

  [[nodiscard]] int size() const { return made_of_ ? made_of_->size() : 0; }
  /// Throws invalid_argument if none was chosen, and the exceptions of the chosen one.
  [[nodiscard]] any_partition resolve(int ranks) const;
  /// The decomposition that was chosen if it is of this type, else null.
  template <class Decomposition>
  [[nodiscard]] const Decomposition* as() const {
    const auto* chosen = dynamic_cast<const of<Decomposition>*>(made_of_.get());
    return chosen != nullptr ? &chosen->decomposition : nullptr;
  }

  // With features<balancing>, for a bisection<dynamic> (templates, so that only programs that use
  // them compile them).

  /// Whether the cuts of the chosen one can move.
  template <class Movable = bisection<dynamic>>
  [[nodiscard]] bool movable() const {
    return as<Movable>() != nullptr;
  }
  template <class Link, class Movable = bisection<dynamic>>
  [[nodiscard]] any_decomposition shared_out(Link& link, std::span<const vec3> places,
                                             std::uint64_t weight, int ranks) const {
    return as<Movable>()->shared_out(link, places, weight, ranks);
  }
  template <class Movable = bisection<dynamic>>
  [[nodiscard]] std::vector<real> positions() const {
    return movable() ? as<Movable>()->positions() : std::vector<real>();
  }
  template <class Movable = bisection<dynamic>>
  [[nodiscard]] any_decomposition placed(std::span<const real> positions) const {
    return movable() ? any_decomposition(as<Movable>()->placed(positions)) : *this;
  }

 private:
  struct offers {
    virtual ~offers() = default;
    virtual int size() const = 0;
    virtual any_partition resolve(int ranks) const = 0;
  };
  template <class Decomposition>
  struct of final : offers {
    explicit of(Decomposition d) : decomposition(std::move(d)) {}
    int size() const override { return decomposition.size(); }
    any_partition resolve(int ranks) const override {
      return any_partition(decomposition.resolve(ranks));
    }
    Decomposition decomposition;
  };
  std::shared_ptr<const offers> made_of_;
};

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/parallel/any_decomposition_definitions.hpp"
#endif
