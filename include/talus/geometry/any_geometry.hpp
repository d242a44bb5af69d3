#pragma once
// One run-time type for every region bounded by planes: stored in connections, sent in messages.
#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/geometry/combine.hpp"

namespace talus {

namespace detail {

/// A group of half-spaces and groups, converted to canonical form when it closes: nested groups of
/// one kind are merged, parts are sorted, repeated and redundant parts are dropped.
struct geometry_group {
  bool all_of = true;
  plain_vector<half_space> planes;
  std::vector<geometry_group> groups;

  friend bool operator==(const geometry_group&, const geometry_group&) = default;
  [[nodiscard]] bool less(const geometry_group& other) const;
  void add(const half_space& h);
  void add(geometry_group&& group);
  void settle();
};

class geometry_builder {
 public:
  void open(bool all_of) { path_.push_back({all_of, {}, {}}); }
  void plane(const half_space& h) { path_.back().planes.push_back(h); }
  void close();
  [[nodiscard]] const geometry_group& root() const { return path_.front(); }

 private:
  std::vector<geometry_group> path_{1};
};

}  // namespace detail

/// Any region that half-spaces, intersect, merge and complement can form. Its evaluation needs no
/// recursion or allocation. Two regions compare equal if their canonical forms do (order,
/// repetition and nesting of like groups do not matter). The default is all of space.
class any_geometry {
 public:
  any_geometry() = default;
  template <class Region>
  requires(!std::same_as<Region, any_geometry> && concepts::polyhedral<Region>)
      any_geometry(const Region& region) {  // NOLINT: every typed region is an any_geometry
    detail::geometry_builder builder;
    region.describe(builder);
    adopt(builder);
  }
  /// The intersection of half-spaces; all of space if there are none.
  [[nodiscard]] static any_geometry cell(std::span<const half_space> planes);

  /// See region: positive inside, and at most the distance to the boundary.
  [[nodiscard]] real value(const vec3& p) const;
  [[nodiscard]] bool contains(const vec3& p) const { return value(p) >= 0; }
  /// See concepts::polyhedral: as contains, but a shared boundary belongs to one side only.
  [[nodiscard]] bool owns(const vec3& p) const;

  /// All half-spaces in the region, in canonical order.
  [[nodiscard]] std::span<const half_space> planes() const { return planes_; }
  /// Whether the region is an intersection of half-spaces (one or none included).
  [[nodiscard]] bool convex() const { return program_.empty() && all_of_; }
  /// The smallest number of half-spaces that a point inside lies in; a larger number is more
  /// specific.
  [[nodiscard]] int depth() const { return depth_; }

  friend bool operator==(const any_geometry&, const any_geometry&) = default;

  /// The complement of the region; its value is exactly the negative.
  friend any_geometry complement(const any_geometry& g);

  template <class Sink>
  void describe(Sink& sink) const {
    auto plane = planes_.begin();
    sink.open(all_of_);
    if (program_.empty()) {
      for (const half_space& h : planes_) sink.plane(h);
    } else {
      for (std::size_t i = 1; i + 1 < program_.size(); ++i) switch (program_[i]) {
          case token::plane:
            sink.plane(*plane++);
            break;
          case token::close:
            sink.close();
            break;
          default:
            sink.open(program_[i] == token::open_all);
            break;
        }
    }
    sink.close();
  }

  void write(detail::byte_writer& out) const;
  [[nodiscard]] static any_geometry read(detail::byte_reader& in);

 private:
  enum class token : std::uint8_t { plane, open_all, open_any, close };
  static constexpr std::size_t max_nesting_ = 16;

  static constexpr real neutral(bool all_of) {
    return all_of ? std::numeric_limits<real>::infinity() : -std::numeric_limits<real>::infinity();
  }
  [[nodiscard]] real run(const vec3& p) const;
  [[nodiscard]] bool run_owns(const vec3& p) const;
  void adopt(detail::geometry_builder& builder);
  int emit(const detail::geometry_group& group, std::size_t nesting);
  static half_space read_plane(detail::byte_reader& in);

  detail::plain_vector<half_space> planes_;
  detail::plain_vector<token> program_;  // empty if there is only one group
  bool all_of_ = true;
  int depth_ = 0;
};

[[nodiscard]] any_geometry complement(const any_geometry& g);

/// A region in words: "intersect(x >= 2, y >= 1)".
[[nodiscard]] std::string to_string(const any_geometry& g);

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/geometry/detail/any_geometry_definitions.hpp"
#endif

#ifndef TALUS_COMPILED
#include "talus/geometry/any_geometry_definitions.hpp"
#endif
