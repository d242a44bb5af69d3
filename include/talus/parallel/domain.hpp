#pragma once
// The part of space that one rank owns, and its connections to the ranks around it.
#include <algorithm>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>
#include <variant>

#include "talus/concepts.hpp"
#include "talus/core/error.hpp"
#include "talus/parallel/closed_neighbour.hpp"
#include "talus/parallel/connection.hpp"

namespace talus {

/// The domain of one rank. A generating decomposition connects every rank to all its neighbours,
/// also across edges and corners, by the connect() that is public, and its owner() decides about
/// every point. With connections by hand, a rank owns the points that none of its connected ranks
/// claims, and points on a shared boundary belong to the side towards +x (then +y, +z), as in a
/// grid. A single rank owns all of space with any decomposition.
template <concepts::decomposition Decomposition>
class domain {
 public:
  /// The domain of `rank` out of `ranks`, connected to all ranks whose regions come within `reach`
  /// (a length; 0: those that touch). Throws invalid_argument if the decomposition is ill-defined
  /// or is meant for another number of ranks.
  domain(const Decomposition& d, int rank, int ranks, real reach = 0) : rank_(rank), ranks_(ranks) {
    require_reach(reach);
    if (ranks < 1 || rank < 0 || rank >= ranks)
      detail::fail<std::invalid_argument>(
          "there is no rank {} in a job of {}: ranks are numbered from 0 to {}", rank, ranks,
          ranks - 1);
    if constexpr (concepts::generating_decomposition<Decomposition>) {
      // A single rank owns all of space, but the decomposition is checked there too.
      auto cells = d.resolve(ranks == 1 && d.size() > 0 ? d.size() : ranks);
      if (ranks == 1 && !periodic) return;
      cells_ = std::move(cells);
      own_ = cells_->geometry(rank);
      if constexpr (has_cell) cell_ = cells_->cell(rank);
      for (const half_space& h : own_.planes()) size_ = std::max(size_, std::abs(h.displacement()));
      for (const int other : cells_->neighbours(rank, reach))
        add_connection(other, cells_->geometry(other), 0);
      if constexpr (closing)
        for (const int other : cells_->closed(rank))
          if (!find(other)) closed_.emplace_back(other, cells_->geometry(other));
      generated_ = true;
    }
  }

  /// A domain before the decomposition is known: no connections, and all of space.
  [[nodiscard]] static domain undivided(int rank, int ranks) { return domain(rank, ranks); }

  [[nodiscard]] int rank() const { return rank_; }
  [[nodiscard]] int ranks() const { return ranks_; }

  /// Connects this rank to a remote `rank` whose region lies beyond a plane with the normal
  /// (a, b, c) of any length but zero, pointing towards the remote rank, at the displacement `d`
  /// from the origin. `dx` (a length, >= 0) widens the region for the placement of shadow copies.
  /// All five forms throw invalid_argument for a rank that does not exist, is this one or is
  /// connected already, and for an invalid normal or `dx`.
  void connect(int rank, real a, real b, real c, real d, real dx = 0) {
    connect(rank, any_geometry(half_space(a, b, c, d)), dx);
  }
  /// Connects this rank to a remote `rank` whose region lies beyond a plane with a normal and a
  /// displacement.
  void connect(int rank, const vec3& normal, real d, real dx = 0) {
    connect(rank, any_geometry(half_space(normal, d)), dx);
  }
  /// Connects this rank to a remote `rank` whose region lies beyond a plane with the normal (a, b,
  /// c) through the point (x, y, z).
  void connect(int rank, real a, real b, real c, real x, real y, real z, real dx = 0) {
    connect(rank, any_geometry(half_space(a, b, c, x, y, z)), dx);
  }
  /// Connects this rank to a remote `rank` whose region lies beyond a plane with a normal through a
  /// point.
  void connect(int rank, const vec3& normal, const vec3& point, real dx = 0) {
    connect(rank, any_geometry(half_space(normal, point)), dx);
  }
  /// Connects this rank to a remote `rank` that occupies any region. Regions given to several ranks
  /// may overlap if the more specific one lies within the others: a corner, as the intersection of
  /// two half-spaces, beside the half-spaces themselves.
  void connect(int rank, any_geometry geometry, real dx = 0);

  /// Removes the connection to `rank`; throws invalid_argument if there is none.
  void disconnect(int rank);

  /// Connections in ascending order of rank.
  [[nodiscard]] std::span<const connection> connections() const { return connections_; }
  /// The connection to `rank`, or nullptr.
  [[nodiscard]] const connection* find(int rank) const {
    const auto at = position(rank);
    return at != connections_.end() && at->rank == rank ? &*at : nullptr;
  }

  /// Whether space is periodic. Then a rank may be its own neighbour, and connections cannot be
  /// made by hand.
  static constexpr bool periodic = [] {
    if constexpr (concepts::generating_decomposition<Decomposition>)
      return concepts::periodic_partition<decltype(std::declval<const Decomposition&>().resolve(
          1))>;
    return false;
  }();
  /// The periodic box; valid once the decomposition is known.
  [[nodiscard]] const auto& box() const requires(periodic) { return cells_->box(); }

  /// Whether there can be closed faces; only then are bodies tested against them.
  static constexpr bool closing = [] {
    if constexpr (concepts::generating_decomposition<Decomposition>)
      return concepts::closing_partition<decltype(std::declval<const Decomposition&>().resolve(1))>;
    return false;
  }();
  /// The ranks that this one touches on closed faces only.
  [[nodiscard]] std::span<const closed_neighbour> closed() const requires(closing) {
    return closed_;
  }

  /// The partition of space among all ranks; nullptr for a single rank or connections by hand.
  [[nodiscard]] const auto* partition() const { return cells_ ? &*cells_ : nullptr; }

  /// Whether a rank lies behind a closed face, without a connection.
  [[nodiscard]] bool closed_to([[maybe_unused]] int rank) const {
    if constexpr (closing)
      return !find(rank) && std::any_of(closed_.begin(), closed_.end(),
                                        [&](const auto& c) { return c.rank() == rank; });
    return false;
  }

  /// A distance from this domain within which all ranks are connected or lie behind closed faces,
  /// which bodies keep away from in any case. Infinite for connections by hand, because the ranks
  /// beyond are unknown then.
  [[nodiscard]] real covered() const {
    if (covered_ < 0) covered_ = measure_covered();
    return covered_;
  }

  /// Whether this rank owns the point; of all ranks of a job exactly one does.
  [[nodiscard]] bool contains(const vec3& p) const {
    if constexpr (concepts::generating_decomposition<Decomposition>) {
      if constexpr (has_cell)
        if (cells_) return cell_.contains(p);
      if (cells_) {
        // The rule itself is evaluated only if round-off could contradict the region.
        const real inside = own_.value(p), margin = 1e-10 * (size_ + detail::max_norm(p));
        if (inside > margin) return true;
        return !(inside < -margin) && cells_->owner(p) == rank_;
      }
    }
    for (const connection& c : connections_)
      if (c.geometry.owns(p)) return false;
    return !detail::has_nan(p);  // no rank owns NaN
  }
  /// The owner of a point: this rank, a connected rank, or -1 if the point belongs to a rank
  /// without a connection to this one.
  [[nodiscard]] int owner(const vec3& p) const;

  /// An axis-aligned box (lower, upper corner; infinite on sides without bounds) around the domain
  /// of this rank.
  [[nodiscard]] std::pair<vec3, vec3> bounds() const {
    constexpr real infinity = std::numeric_limits<real>::infinity();
    if constexpr (concepts::generating_decomposition<Decomposition>)
      if constexpr (has_cell)
        if (cells_)
          return {vec3(cell_.lower[0], cell_.lower[1], cell_.lower[2]),
                  vec3(cell_.upper[0], cell_.upper[1], cell_.upper[2])};
    if constexpr (requires { cells_->bounds(rank_); })
      if (cells_) return cells_->bounds(rank_);
    return {detail::thrice<real>(-infinity), detail::thrice<real>(infinity)};
  }

  /// A lower bound of the distance from a point to every connected region, widened by its overlap.
  /// Bodies with a smaller radius do not reach other ranks.
  [[nodiscard]] real interior_distance(const vec3& p) const {
    if constexpr (concepts::generating_decomposition<Decomposition>)
      if (generated_) {
        if constexpr (has_cell)
          return cell_.interior_distance(p);
        else
          return own_.value(p);
      }
    real nearest = std::numeric_limits<real>::infinity();
    for (const connection& c : connections_) nearest = std::min(c.distance(p), nearest);
    return nearest;
  }
  /// Calls f(index into connections()) for every connection whose widened region may come within
  /// `radius` of the point, in ascending order.
  template <class F>
  void for_each_within(const vec3& p, real radius, F&& f) const {
    if constexpr (concepts::generating_decomposition<Decomposition>)
      if (generated_ && interior_distance(p) > radius) return;
    for (std::size_t i = 0; i < connections_.size(); ++i)
      if (connections_[i].distance(p) <= radius) f(i);
  }
  /// Calls f(index into connections(), number of the image, place of the image) for every
  /// connection and every image of the point for which the widened region may come within `radius`
  /// of the image.
  template <class F>
  void for_each_image_within(const vec3& p, real radius, F&& f) const requires(periodic) {
    if (interior_distance(p) > radius) return;
    box().each_within(p, radius, [&](auto image, const vec3& q) {
      for (std::size_t i = 0; i < connections_.size(); ++i)
        if ((image != 0 || connections_[i].rank != rank_) && connections_[i].distance(q) <= radius)
          f(i, image, q);
    });
  }

 private:
  domain(int rank, int ranks) : rank_(rank), ranks_(ranks) {}

  static void require_reach(real reach) {
    if (!(reach >= 0) || !std::isfinite(reach))
      detail::fail<std::invalid_argument>(
          "the reach of a neighbourhood must be a finite length >= 0, but is {}", reach);
    if (!concepts::generating_decomposition<Decomposition> && reach > 0)
      detail::fail<std::invalid_argument>(
          "a reach of {} extends the connections that a decomposition generates, but by_hand "
          "generates none: connect the ranks by hand, or choose another decomposition",
          reach);
  }

  template <class D>
  static auto cells_of(const D& d) -> decltype(d.resolve(1));
  using cells_type = decltype(cells_of(std::declval<const Decomposition&>()));
  // A partition may offer cell(rank), a cheap form of contains() and of the distance to the
  // outside.
  static constexpr bool has_cell = requires(const cells_type& cells) { cells.cell(0); };
  template <class Cells>
  struct cell_of {
    using type = char;
  };
  template <class Cells>
  requires requires(const Cells& cells) { cells.cell(0); }
  struct cell_of<Cells> {
    using type = decltype(std::declval<const Cells&>().cell(0));
  };

  void add_connection(int rank, any_geometry geometry, real dx) {
    generated_ = false;
    covered_ = -1;
    connections_.insert(position(rank), {rank, std::move(geometry), dx});
  }
  [[nodiscard]] real measure_covered() const {
    constexpr real infinity = std::numeric_limits<real>::infinity();
    if constexpr (concepts::generating_decomposition<Decomposition>) {
      if (!cells_) return infinity;
      const auto within = [&](real reach) {
        const auto near = cells_->neighbours(rank_, reach);
        return std::all_of(near.begin(), near.end(),
                           [&](int r) { return find(r) != nullptr || closed_to(r); });
      };
      real low = 0, high = 1;
      while (within(high)) {
        low = high, high *= 4;
        if (high > 1e100) return infinity;
      }
      for (int k = 0; k < 60 && high - low > 1e-3 * high; ++k)
        (within(0.5 * (low + high)) ? low : high) = 0.5 * (low + high);
      return low;
    }
    return infinity;
  }
  [[nodiscard]] auto position(int rank) const {
    return std::lower_bound(connections_.begin(), connections_.end(), rank,
                            [](const connection& c, int r) { return c.rank < r; });
  }

  int rank_;
  int ranks_;
  bool generated_ = false;  // only generated connections, none of them widened
  std::optional<cells_type> cells_;
  typename cell_of<cells_type>::type cell_{};
  any_geometry own_;
  real size_ = 0;  // largest displacement of a plane of own_
  std::vector<connection> connections_;
  [[no_unique_address]] std::conditional_t<closing, std::vector<closed_neighbour>, std::monostate>
      closed_;
  mutable real covered_ = -1;  // not measured yet
};

template <concepts::decomposition Decomposition>
void domain<Decomposition>::connect(int rank, any_geometry geometry, real dx) {
  if constexpr (periodic)
    detail::fail<std::invalid_argument>(
        "rank {} cannot connect to rank {} by hand: a periodic decomposition makes all "
        "connections, "
        "with images too; give it a reach instead",
        rank_, rank);
  if (rank < 0 || rank >= ranks_)
    detail::fail<std::invalid_argument>(
        "rank {} cannot connect to rank {}: this job has {} rank(s), numbered from 0; "
        "start it with more ranks or correct the number",
        rank_, rank, ranks_);
  if (rank == rank_)
    detail::fail<std::invalid_argument>(
        "rank {} cannot connect to itself; give the rank on the other side of the boundary", rank_);
  if (!(dx >= 0) || !std::isfinite(dx))
    detail::fail<std::invalid_argument>(
        "the overlap dx of the connection from rank {} to rank {} must be a finite length >= 0, "
        "but is {}",
        rank_, rank, dx);
  const auto at = position(rank);
  if (at != connections_.end() && at->rank == rank)
    detail::fail<std::invalid_argument>(
        "rank {} is connected to rank {} already; a rank has one connection to another: "
        "call disconnect({}) first, or merge both regions into one geometry",
        rank_, rank, rank);
  add_connection(rank, std::move(geometry), dx);
}

template <concepts::decomposition Decomposition>
void domain<Decomposition>::disconnect(int rank) {
  if constexpr (periodic)
    detail::fail<std::invalid_argument>(
        "rank {} cannot disconnect from rank {}: a periodic decomposition makes all connections",
        rank_, rank);
  const connection* found = find(rank);
  if (!found)
    detail::fail<std::invalid_argument>(
        "rank {} is not connected to rank {}, so that it cannot disconnect; "
        "connections() lists the ranks it is connected to",
        rank_, rank);
  covered_ = -1;
  connections_.erase(connections_.begin() + (found - connections_.data()));
}

template <concepts::decomposition Decomposition>
int domain<Decomposition>::owner(const vec3& p) const {
  if (detail::has_nan(p)) return -1;
  if constexpr (concepts::generating_decomposition<Decomposition>)
    if (cells_) {
      const int owner = cells_->owner(p);
      return owner == rank_ || find(owner) ? owner : -1;
    }
  const int claimed = detail::claimant(connections_, p);
  return claimed < 0 ? rank_ : claimed;
}

}  // namespace talus
