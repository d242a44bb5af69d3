#pragma once
// Rigid bodies built from several shapes: agglomerates of spheres, hammers, a whole stair. Bodies
// of one form share their parts: a copy of the shape costs a reference.
#include <cmath>
#include <cstddef>
#include <memory>
#include <type_traits>
#include <variant>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/shared_data.hpp"
#include "talus/core/type_list.hpp"
#include "talus/shape/detail/union_moments.hpp"
#include "talus/shape/detail/union_parts.hpp"
#include "talus/shape/frame.hpp"
#include "talus/shape/principal_axes.hpp"

namespace talus {

/// How often volume counts that several parts of a union share.
enum class overlap_rule {
  once,    ///< with the largest of their densities
  counted  ///< in each part
};
/// Options of a union: `clump grain{parts, {.overlaps = overlap_rule::counted}}`.
struct union_options {
  overlap_rule overlaps = overlap_rule::once;  ///< of the parts
};

template <class... Shapes>
class union_of;

namespace detail {
template <class Shape>
inline constexpr bool is_union = false;
template <class... Shapes>
inline constexpr bool is_union<union_of<Shapes...>> = true;

template <class Shape>
inline constexpr bool is_part_of_union = [] {
  if constexpr (requires { Shape::finite; }) return Shape::finite && !is_union<Shape> && !requires {
      Shape::immovable;
    };
  else
    return false;
}();
}  // namespace detail

/// A union of parts of the named shapes, given in any frame:
/// `union_of<box, capsule> hammer{{{.shape = box{{1, 1, 2}}, .at = {{0, 0, 3}}}, {.shape =
/// stick}}}`. Its mass is the sum of those of its parts, each density (relative to that of the
/// material) times volume; volume that parts share counts once, with the largest of their
/// densities, unless `.overlaps = overlap_rule::counted` says otherwise. Where no more than two
/// spheres overlap, or boxes and polyhedra alone, mass, centre and inertia are closed forms; where
/// more spheres do, they are exact to 1e-8, and between other shapes to 1e-6. Parts with a member
/// `chord(p, d)` are measured faster. Equal unions share what was computed for the first.
/// The frame of the body lies at the centre of mass along the principal axes: `frame()` gives it in
/// the coordinates of the parts, and `placed(shape, pose)` of shape/frame.hpp gives the pose of a
/// body whose parts lie at the given coordinates.
template <class... Shapes>
class union_of {
  static_assert(sizeof...(Shapes) > 0,
                "union_of<> names no shape: name those of the parts, as in union_of<sphere, box>");
  static_assert((... && detail::is_part_of_union<Shapes>),
                "union_of<...> takes shapes with a volume that are no unions themselves: leave out "
                "the others, add the parts of a union one by one, and instead of a triangle_mesh, "
                "which is a surface, add convex_polyhedron parts");
  static_assert(detail::all_different<type_list<Shapes...>>,
                "union_of<...> names a shape twice: keep one of the two");
  using data = detail::union_parts<Shapes...>;

 public:
  struct part {
    std::variant<Shapes...> shape;
    pose at{};         ///< of the coordinates in which the shape was given
    real density = 1;  ///< relative to that of the material; 0 for a part without mass
  };

  static constexpr bool finite = true;
  static constexpr bool isotropic = false;
  static constexpr const char* name = "union_of";
  static constexpr std::size_t max_parts = 65535;

  /// An empty value, to be assigned to.
  union_of() = default;
  /// One part, for a body with a centre of mass or an inertia of its own.
  template <class Shape>
  explicit union_of(const Shape& shape) requires(... || std::is_same_v<Shape, Shapes>)
      : union_of(std::vector<part>{{.shape = shape}}) {}
  /// Throws invalid_argument for an invalid part, for zero total mass, and for more than 65,535
  /// parts.
  explicit union_of(const std::vector<part>& parts, const union_options& how = {})
      : data_(build<real>(parts, how.overlaps)) {}

  /// Throws invalid_argument if there are no parts.
  void validate() const {
    if (data_ == nullptr)
      detail::fail<std::invalid_argument>(
          "a union_of without parts is no body: make it from a list of parts");
  }

  /// Number of its parts.
  [[nodiscard]] std::size_t parts() const { return data_->entries.size(); }
  /// Calls f(shape, pose in the frame of the body) for each part, in the order given.
  template <class F>
  void each_part(F&& f) const {
    for (std::size_t n = 0; n < parts(); ++n)
      data_->visit(n, [&](const auto& shape, const pose& at, real) { f(shape, at); });
  }
  /// Calls f(number, shape, pose) for the parts that may lie within `reach` of a point of the
  /// body's frame, in an order that depends on the union alone.
  template <class F>
  void each_part_near(const vec3& point, real reach, F&& f) const {
    data_->near(point, reach, [&](std::size_t n) {
      data_->visit(n, [&](const auto& shape, const pose& at, real) { f(n, shape, at); });
    });
  }

  /// The frame of the body in the coordinates of the parts.
  [[nodiscard]] const pose& frame() const { return data_->frame; }
  /// Distance of its furthest point from the centre.
  [[nodiscard]] real bounding_radius() const { return data_->bounding_radius; }
  /// The least distance from the centre of mass to the bounds along the axes of the body; a
  /// twentieth of the bounding radius if the centre is outside of them.
  [[nodiscard]] real least_extent() const { return data_->least_extent; }
  /// Integral of the relative density, from which the mass follows.
  [[nodiscard]] real volume() const { return data_->volume; }
  /// Principal moments per unit mass.
  [[nodiscard]] const vec3& inertia() const { return data_->inertia; }
  /// Furthest point of all parts along `direction`; of equals, that of the first part.
  [[nodiscard]] vec3 support(const vec3& direction) const {
    vec3 furthest(0, 0, 0);
    bool found = false;
    each_part([&](const auto& shape, const pose& at) {
      const vec3 p = at.to_world(
          shape.support(detail::inverse({{0, 0, 0}, at.orientation}).to_world(direction)));
      if (!found || direction.dot(p) > direction.dot(furthest)) furthest = p, found = true;
    });
    return furthest;
  }
  /// Half edges of the smallest box about the centre of mass, parallel to the axes of the world,
  /// that contains the body at a pose.
  [[nodiscard]] vec3 half_extents(const pose& at) const {
    vec3 half(0, 0, 0);
    const pose back = detail::inverse({{0, 0, 0}, at.orientation});
    for (int i = 0; i < 3; ++i)
      for (const real sign : {-1., 1.}) {
        const vec3 d = back.to_world(vec3(sign * vec3::Unit(i)));
        half[i] = std::max(half[i], d.dot(support(d)));
      }
    return half;
  }

  /// This union with its centre of mass at a point, given in the coordinates of the parts. The
  /// principal moments and axes are kept.
  [[nodiscard]] union_of with_centre(const vec3& centre) const {
    return with_frame({centre, data_->frame.orientation}, data_->inertia);
  }
  /// This union with another centre of mass and another inertia per unit mass: a symmetric
  /// matrix, about the centre, along the axes of the coordinates of the parts.
  [[nodiscard]] union_of with_inertia(const vec3& centre, const mat3& inertia) const {
    const auto principal = detail::principal_inertia(centre, inertia);
    return with_frame(principal.frame, principal.inertia);
  }

  template <class Writer>
  void pack(Writer& out) const {
    detail::put_shared(out, data_);
  }
  template <class Reader>
  static union_of unpack(Reader& in) {
    union_of u;
    u.data_ = detail::get_shared<data>(in);
    return u;
  }

  /// Equal in every part.
  friend bool operator==(const union_of& a, const union_of& b) {
    return a.data_ == b.data_ || (a.data_ && b.data_ && a.data_->id == b.data_->id);
  }

 private:
  static void validate(const std::vector<part>& parts) {
    if (parts.empty() || parts.size() > max_parts)
      detail::fail<std::invalid_argument>(
          "a union_of has from 1 to {} parts, but {} were given: split it, or give some", max_parts,
          parts.size());
    real mass = 0;
    for (std::size_t n = 0; n < parts.size(); ++n) {
      const part& p = parts[n];
      std::visit([](const auto& shape) { shape.validate(); }, p.shape);
      if (!(p.density >= 0) || !std::isfinite(p.density))
        detail::fail<std::invalid_argument>(
            "the density of part {} of a union_of must be finite and not negative, but is {}", n,
            p.density);
      if (!detail::finite(p.at.position) || !(std::abs(p.at.orientation.norm() - 1) < 1e-6))
        detail::fail<std::invalid_argument>(
            "part {} of a union_of needs a finite position and a unit quaternion, but is at {} "
            "with "
            "a quaternion of norm {}",
            n, p.at.position, p.at.orientation.norm());
      mass += p.density;
    }
    if (!(mass > 0))
      detail::fail<std::invalid_argument>(
          "all {} parts of a union_of have density 0: give one of them a mass", parts.size());
  }

  static void require_measured(const data& built) {
    const auto normal = [](real x) { return x > 0 && std::isnormal(x); };
    bool good = normal(built.volume) && std::isfinite(built.bounding_radius) &&
                built.bounding_radius <= detail::largest_size;
    for (int k = 0; k < 3; ++k) good = good && normal(built.inertia[k]);
    if (!good)
      detail::fail<std::invalid_argument>(
          "a union_of {} parts has the volume {}, the radius {} and the inertia {}, beyond what "
          "numbers can hold: choose units in which its size is nearer to 1, and parts that lie "
          "near "
          "each other",
          built.entries.size(), built.volume, built.bounding_radius, built.inertia);
  }

  template <class Real>
  [[nodiscard]] static std::shared_ptr<const data> build(const std::vector<part>& parts,
                                                         overlap_rule rule) {
    validate(parts);
    // The parts at their places from the first one, which avoids cancellation far from the origin.
    const vec3 base = parts[0].at.position;
    data given;
    for (const part& p : parts)
      std::visit(
          [&](const auto& shape) {
            const pose at = placed(shape, p.at);
            given.add(shape, {at.position - base, at.orientation}, p.density);
          },
          p.shape);
    given.sort();
    detail::byte_buffer key;
    detail::byte_writer writer(key);
    writer.put(rule == overlap_rule::counted), writer.put(base);
    given.pack(writer);
    return detail::made_once<data>(detail::id_of_content(key), [&] {
      detail::mass_moments<Real> moments;
      for (std::size_t n = 0; n < parts.size(); ++n)
        given.visit(n, [&](const auto& shape, const pose& at, real density) {
          moments += detail::moments_of<Real>(shape, at, density);
        });
      // Integrals are less precise than sums; a symmetric union keeps its axes.
      Real round_off = Real(1e-13);
      if (rule == overlap_rule::once &&
          detail::shared_moments<Real, Shapes...>(given).subtract_from(moments))
        round_off = Real(1e-8);
      const auto principal = moments.reduce(round_off);
      data built;
      built.volume = moments.mass, built.inertia = principal.inertia;
      built.frame = {base + principal.frame.position, principal.frame.orientation};
      const pose back = detail::inverse(built.frame);
      for (const part& p : parts)
        std::visit(
            [&](const auto& shape) {
              built.add(shape, detail::combined(back, placed(shape, p.at)), p.density);
            },
            p.shape);
      return finished(std::move(built));
    });
  }
  [[nodiscard]] static std::shared_ptr<const data> finished(data built) {
    built.sort();
    require_measured(built);
    detail::byte_buffer content;
    detail::byte_writer writer(content);
    built.pack(writer);
    built.id = detail::id_of_content(content);
    return std::make_shared<const data>(std::move(built));
  }
  /// These parts with another frame of the body.
  [[nodiscard]] union_of with_frame(const pose& frame, const vec3& inertia) const {
    detail::byte_buffer key;
    detail::byte_writer writer(key);
    writer.put(data_->id), writer.put(frame.position), writer.put(frame.orientation);
    writer.put(inertia);
    union_of u;
    u.data_ = detail::made_once<data>(detail::id_of_content(key), [&] {
      data built;
      built.volume = data_->volume, built.inertia = inertia, built.frame = frame;
      const pose change = detail::combined(detail::inverse(frame), data_->frame);
      for (std::size_t n = 0; n < parts(); ++n)
        data_->visit(n, [&](const auto& shape, const pose& at, real density) {
          built.add(shape, detail::combined(change, at), density);
        });
      return finished(std::move(built));
    });
    return u;
  }

  std::shared_ptr<const data> data_;
};

}  // namespace talus
