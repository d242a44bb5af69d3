#pragma once
// Finds the contacts with fixed bodies that are not on their common surface; see
// detect/flush.hpp. What is found depends on the bodies alone, not on their order or owner: a rank
// that computes a contact holds every body that reaches its point. (Those that goes_on() looks at,
// up to a diameter of the movable body away, it holds if they are global.)
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>

#include "talus/contact/contact_geometry.hpp"
#include "talus/detect/flush.hpp"
#include "talus/pairs/filtered_pairs.hpp"
#include "talus/shape/nearest_on_triangle.hpp"
#include "talus/state/kinematic_bodies.hpp"
#include "talus/state/state.hpp"

namespace talus {
template <class... Shapes>
class union_of;
}  // namespace talus

namespace talus::detail {

/// A contact of a movable body with a fixed one.
struct contact_with_fixed {
  vec3 point, normal;  ///< on the surface of the fixed body, and from there to the other one
  vec3 centre;         ///< of the movable body
  real radius = 0;
  system_id id = no_id;
  bool round = false;                ///< the movable body is a sphere
  bool curved = false;               ///< see is_rounded
  bool convex = false;               ///< see is_rounded_whole
  std::size_t shape = 0, index = 0;  ///< of the movable body in the scenario, and in its store
};

/// Shapes whose contacts with a flat face have the normal of that face. Those of boxes, hulls and
/// meshes may have that of a face of their own.
template <class Shape>
inline constexpr bool is_rounded = !has_flat_faces<Shape>;
template <class... Parts>
inline constexpr bool is_rounded<union_of<Parts...>> = (... && is_rounded<Parts>);
/// The convex ones of these: the area in which one touches a plane extends from each of its ends
/// towards the centre.
template <class Shape>
inline constexpr bool is_rounded_whole = is_rounded<Shape>;
template <class... Parts>
inline constexpr bool is_rounded_whole<union_of<Parts...>> = false;

/// Calls f(store, index) for a body that may be flush.
template <class Scenario, class F>
void with_flush_body(const world_state<Scenario>& s, std::uint32_t number, F&& f) {
  const flush_body& one = s.flush.all[number];
  s.each_shape([&](const auto& b) {
    using shape = typename std::remove_cvref_t<decltype(b)>::shape_type;
    if constexpr (is_solid_beside<shape>)
      if (index_of<typename Scenario::shapes, shape> == one.shape)
        f(one.global ? b.global : b.movable, one.index);
  });
}

/// Finds the contacts with flush bodies that are not on their common surface.
template <class Scenario>
class flush_surface {
  using state_type = world_state<Scenario>;
  /// Bodies are taken to enter a surface of triangles by at most this part of their radius.
  static constexpr real depth_part = 0.02;
  /// The sine of an angle between two faces that counts as zero, and between a face and the normal
  /// of a curved body, which has a contact of its own with each face under it.
  static constexpr real level = 1e-3, level_of_curved = 1e-6;
  /// The part of a unit normal within a face is longer than this where the normal is that of an
  /// edge.
  static constexpr real along_face = 1e-6;
  /// How far beyond a solid a face has to be in view, as a part of the radius of the other body.
  static constexpr real view_part = 0.01;
  /// How far from a contact the body above it goes on, as a part of its radius.
  static constexpr real onwards_part = 1e-4;

 public:
  flush_surface(state_type& s, const contact_with_fixed& c)
      : s_(s), c_(c), point_(c.point), normal_(c.normal), depth_(depth_part * c.radius) {
    // A body that is followed falls freely until its impact.
    if constexpr (state_type::continuous)
      depth_ = std::max(depth_, 2 * s.gravity.norm() * s.dt * s.dt);
  }

  /// Whether the contact of the body with this number there is not on the common surface.
  [[nodiscard]] bool hides(std::uint32_t number) {
    point_ = on_body(number);
    const auto& f = s_.flush;
    const bool half_space = f.all[number].radius == 0;
    bool hidden = false, levelled = !c_.round;
    f.each_near(number, point_, reach_of(number), [&](std::uint32_t other) {
      if (!std::exchange(levelled, true)) normal_ = of_face(number);
      if constexpr (state_type::has_joints)  // it has no contacts with the movable body
        if (s_.joints.joined(c_.id, f.all[other].id)) return true;
      if constexpr (state_type::filters)
        if (!touches(other)) return true;
      const real tolerance = tolerance_of(number, other);
      bool meets = false;
      each_solid(other, point_, tolerance, [&](const auto& solid, const pose& at) {
        const vec3 p = at.to_body(point_), n = to_body(at, normal_);
        const beside how = stands_beside(solid, p, n, tolerance);
        meets = meets || how != beside::apart;
        if (how == beside::covers)
          hidden = !half_space && stay_together(number, other) &&
                   !goes_on(number, solid, at, p, tolerance);
        else if (how == beside::agrees && c_.round) {
          // Both have the same contact.
          const bool over = lies_over(solid, at.to_body(c_.centre), n);
          hidden = over == is_under(number, tolerance) ? comes_first(other, number) : over;
        }
        return !hidden;
      });
      if (meets && !hidden && c_.convex && !c_.round && !half_space)
        hidden = ends_over(number, other) && stay_together(number, other);
      return !hidden;
    });
    return hidden;
  }
  /// Calls f(id) for the bodies beside the one with this number whose surface is level with the
  /// contact, but for `way`, and at most `reach` beside its point.
  template <class F>
  void each_beside(std::uint32_t number, real way, real reach, F&& f) {
    point_ = on_body(number);
    if (!c_.round) normal_ = of_face(number);
    s_.flush.each_near(number, point_, reach_of(number) + reach, [&](std::uint32_t other) {
      const real tolerance = tolerance_of(number, other);
      bool level = false;
      each_solid(other, point_, tolerance + reach, [&](const auto& solid, const pose& at) {
        level = is_level_with(solid, at.to_body(point_), to_body(at, normal_), tolerance + way,
                              reach - way);
        return !level;
      });
      if (level) f(s_.flush.all[other].id);
      return true;
    });
  }

  /// Whether the contact with the body of this number is at its edge, and the common surface goes
  /// on all around, at the distance `step`.
  [[nodiscard]] bool is_on_seam(std::uint32_t number, real step) {
    bool beside = false;
    s_.flush.each_near(number, point_, reach_of(number) + 2 * step, [&](std::uint32_t) {
      beside = true;
      return false;
    });
    if (!beside) return false;
    point_ = on_body(number);
    real along = 0.99;  // flat bodies that lean have contacts along a normal of their own
    each_face_at(number, point_, flush_part * s_.flush.all[number].radius, [&](const vec3& face) {
      if (const real cosine = face.dot(c_.normal); cosine > along) along = cosine, normal_ = face;
    });
    const vec3 u = vec3::Unit(std::abs(normal_[0]) < real(0.6) ? 0 : 1).cross(normal_).normalized();
    const vec3 v = normal_.cross(u), p = point_;
    const auto lies_on = [&](std::uint32_t one, const vec3& q) {
      return is_face_at(one, q, normal_, tolerance_of(number, one));
    };
    bool inside = true;
    for (const vec3& way :
         {u, v, vec3(-u), vec3(-v), vec3(u + v), vec3(u - v), vec3(-u + v), vec3(-u - v)}) {
      const vec3 q = p + step * way;
      if (lies_on(number, q)) continue;
      inside = false;
      bool goes_on = false;
      s_.flush.each_near(number, q, reach_of(number), [&](std::uint32_t other) {
        goes_on = lies_on(other, q);
        return !goes_on;
      });
      if (!goes_on) return false;
    }
    return !inside;
  }

 private:
  [[nodiscard]] static vec3 to_body(const pose& at, const vec3& direction) {
    return rotated(at.orientation.conjugate(), direction);
  }
  template <class F>
  void with_body(std::uint32_t number, F&& f) const {
    with_flush_body(s_, number, f);
  }
  /// Whether features let the movable body touch the one with this number.
  [[nodiscard]] bool touches(std::uint32_t number) const {
    bool may = true;
    s_.each_finite_shape([&](const auto& b) {
      using shape = typename std::remove_cvref_t<decltype(b)>::shape_type;
      if (index_of<typename Scenario::shapes, shape> == c_.shape)
        with_body(number, [&](const auto& store, std::size_t i) {
          may = may_touch(s_, b.movable, c_.index, store, i);
        });
    });
    return may;
  }
  /// Calls f(convex solid, its frame) for the parts of a body around a point of the world, until it
  /// returns false.
  template <class F>
  void each_solid(std::uint32_t number, const vec3& p, real tolerance, F&& f) const {
    with_body(number, [&](const auto& store, std::size_t i) {
      const auto& shape = store.shape[i];
      using type = std::remove_cvref_t<decltype(shape)>;
      if constexpr (is_half_space<type>) {
        f(flat_half_space{shape.unit_normal(), shape.offset}, pose{});
      } else if constexpr (is_block<type>) {
        f(flat_block{shape.half()}, store.pose(i));
      } else if constexpr (is_hull<type>) {
        const real reach = shape.bounding_radius() + tolerance;
        if ((p - store.position[i]).squaredNorm() > reach * reach) return;
        f(flat_hull<std::remove_cvref_t<decltype(shape.mesh())>>{shape.mesh()}, store.pose(i));
      } else {
        const pose at = store.pose(i);
        const vec3 q = at.to_body(p), centre = at.to_body(c_.centre);
        const real reach = depth_ + tolerance;
        const auto& m = shape.tree();
        bool more = true;
        m.each_within(q - vec3(reach, reach, reach), q + vec3(reach, reach, reach),
                      [&](std::uint32_t t) {
                        if (more)
                          more = f(flat_prism{{m.corner(t, 0), m.corner(t, 1), m.corner(t, 2)},
                                              up_at(m, t, centre),
                                              depth_},
                                   at);
                      });
      }
    });
  }
  /// Whether the point is on a face of the body with this normal.
  [[nodiscard]] bool is_face_at(std::uint32_t number, const vec3& q, const vec3& n,
                                real tolerance) const {
    bool level = false;
    each_solid(number, q, tolerance, [&](const auto& solid, const pose& at) {
      level = is_level_with(solid, at.to_body(q), to_body(at, n), tolerance, 0);
      return !level;
    });
    return level;
  }
  /// Whether the contact is on the edge of its body, and the movable body lies over the neighbour
  /// alone there. The neighbour has this contact too, and a more accurate one: the search for the
  /// nearest points of an edge and a curved body finds the gap to round-off, but the place only to
  /// the square root of it.
  [[nodiscard]] bool ends_over(std::uint32_t number, std::uint32_t neighbour) const {
    const real tolerance = tolerance_of(number, neighbour);
    const vec3 n = of_face(number), inwards = c_.centre - point_;
    const vec3 along = inwards - inwards.dot(n) * n;
    const real far = along.norm();
    if (far <= 4 * tolerance) return false;
    const real step = std::min(far, std::max(onwards_part * c_.radius, 4 * tolerance));
    const vec3 q = point_ + (step / far) * along;
    return is_face_at(neighbour, q, n, tolerance) && !is_face_at(number, q, n, tolerance);
  }
  template <class Tree>
  [[nodiscard]] static vec3 up_at(const Tree& m, std::uint32_t t, const vec3& centre) {
    const bool over = m.normals[t].dot(centre - m.corner(t, 0)) >= 0;
    return over ? m.normals[t] : vec3(-m.normals[t]);
  }
  /// Calls f(normal) for the faces of a body at a point, in the world.
  template <class F>
  void each_face_at(std::uint32_t number, const vec3& p, real tolerance, F&& f) const {
    with_body(number, [&](const auto& store, std::size_t i) {
      const auto& shape = store.shape[i];
      using type = std::remove_cvref_t<decltype(shape)>;
      if constexpr (is_triangulated<type>) {
        const pose at = store.pose(i);
        const vec3 q = at.to_body(p), centre = at.to_body(c_.centre);
        const auto& m = shape.tree();
        each_triangle_at(m, q, tolerance,
                         [&](std::uint32_t t) { f(rotated(at.orientation, up_at(m, t, centre))); });
      } else {
        each_solid(number, p, tolerance, [&](const auto& solid, const pose& at) {
          const vec3 q = at.to_body(p);
          solid.each_face([&](const vec3& m, real offset) {
            if (std::abs(m.dot(q) - offset) <= tolerance) f(rotated(at.orientation, m));
            return true;
          });
          return true;
        });
      }
    });
  }
  template <class Tree, class F>
  static void each_triangle_at(const Tree& m, const vec3& q, real tolerance, F&& f) {
    const vec3 reach(tolerance, tolerance, tolerance);
    m.each_within(q - reach, q + reach, [&](std::uint32_t t) {
      const flat_prism flat{{m.corner(t, 0), m.corner(t, 1), m.corner(t, 2)}, m.normals[t], 0};
      if (flat.each_face(
              [&](const vec3& n, real offset) { return n.dot(q) - offset <= tolerance; }))
        f(t);
    });
  }

  /// The point q of a solid on its edge or at its corner, if it is near one that has the normal n.
  /// Searches for curved bodies give points beside it: the further, the more n leans over the edge.
  template <class Solid>
  [[nodiscard]] vec3 on_edge(const Solid& solid, vec3 q, const vec3& n) const {
    constexpr real along = along_face;
    real near = real(2e-3) * c_.radius;
    vec3 first(0, 0, 0);  // the face that is most along n
    solid.each_face([&](const vec3& m, real offset) {
      if (offset - m.dot(q) <= near && m.dot(n) > std::max(along, first.dot(n))) first = m;
      return true;
    });
    solid.each_face([&](const vec3& m, real offset) {
      if (m == first) q += (offset - m.dot(q)) * m;
      return true;
    });
    // The others at an edge with this normal are along what is left of it, also where both lean.
    // The point stays in the first face.
    const vec3 left = n - first.dot(n) * first;
    near = std::clamp(real(0.1) * left.norm() * c_.radius, real(0.05) * near, near);
    bool more = true;
    for (int k = 0; k < 8 && more; ++k) {
      more = false;
      solid.each_face([&](const vec3& m, real offset) {
        const real below = offset - m.dot(q);
        if (m == first || std::abs(below) > near || m.dot(left) <= along) return true;
        const vec3 way = m - m.dot(first) * first;
        const real square = way.squaredNorm();
        if (std::abs(below) > real(10) * near * square) return true;
        q += (below / square) * way;
        more = more || std::abs(below) > real(1e-6) * near;
        return true;
      });
    }
    return q;
  }
  /// The point on the body: a side face has contacts with what is just above its upper edge.
  [[nodiscard]] vec3 on_body(std::uint32_t number) const {
    vec3 p = c_.point;
    with_body(number, [&](const auto& store, std::size_t i) {
      using type = std::remove_cvref_t<decltype(store.shape[i])>;
      if constexpr (is_block<type> || is_hull<type>) {
        each_solid(number, p, c_.radius, [&](const auto& solid, const pose& at) {
          vec3 q = at.to_body(p);
          solid.each_face([&](const vec3& m, real offset) {
            q -= std::max(real(0), m.dot(q) - offset) * m;
            return true;
          });
          p = at.to_world(on_edge(solid, q, to_body(at, c_.normal)));
          return true;
        });
      } else if constexpr (is_triangulated<type>) {
        p = on_triangles(store.shape[i].tree(), store.pose(i), p);
      }
    });
    return p;
  }
  /// The point p on a surface of triangles, at the edge with the normal of the contact: of the
  /// triangles in the plane of the nearest one, that which goes furthest along the normal counts,
  /// because others may end there on an edge within the plane.
  template <class Tree>
  [[nodiscard]] vec3 on_triangles(const Tree& m, const pose& at, const vec3& p) const {
    const vec3 q = at.to_body(p), reach(depth_, depth_, depth_), centre = at.to_body(c_.centre),
               n = to_body(at, c_.normal);
    real least = std::numeric_limits<real>::infinity();
    std::uint32_t nearest = 0;
    const auto near = [&](std::uint32_t t) {
      return nearest_on_triangle(q, m.corner(t, 0), m.corner(t, 1), m.corner(t, 2)).at;
    };
    m.each_within(q - reach, q + reach, [&](std::uint32_t t) {
      if (const real far = (near(t) - q).norm(); far < least) least = far, nearest = t;
    });
    if (least == std::numeric_limits<real>::infinity()) return p;
    const auto edge_of = [&](std::uint32_t t) {
      const flat_prism flat{
          {m.corner(t, 0), m.corner(t, 1), m.corner(t, 2)}, up_at(m, t, centre), 0};
      return on_edge(flat, near(t), n);
    };
    vec3 best = edge_of(nearest);
    const vec3& up = m.normals[nearest];
    const vec3 left = n - n.dot(up) * up;
    const real further = real(1e-10) * c_.radius * left.norm();
    if (left.norm() <= along_face) return at.to_world(best);
    m.each_within(q - reach, q + reach, [&](std::uint32_t t) {
      const vec3 apart = m.corner(t, 0) - m.corner(nearest, 0);
      if (t == nearest || m.normals[t].cross(up).norm() > along_face ||
          std::abs(up.dot(apart)) > along_face * m.bounding_radius ||
          (near(t) - q).norm() > least + onwards_part * c_.radius)
        return;
      if (const vec3 one = edge_of(t); left.dot(one - best) > further) best = one;
    });
    return at.to_world(best);
  }
  /// The normal of the face of the body from which that of the contact differs as little as beside
  /// an edge within round-off.
  [[nodiscard]] vec3 of_face(std::uint32_t number) const {
    vec3 n = c_.normal;
    each_face_at(number, point_, flush_part * s_.flush.all[number].radius, [&](const vec3& face) {
      if (face.cross(c_.normal).norm() <= level_of_curved && face.dot(c_.normal) > 0) n = face;
    });
    return n;
  }
  /// Whether the body is below the centre of the other one.
  [[nodiscard]] bool is_under(std::uint32_t number, real tolerance) const {
    bool under = false;
    each_solid(number, point_, tolerance, [&](const auto& solid, const pose& at) {
      const vec3 n = to_body(at, normal_);
      under = stands_beside(solid, at.to_body(point_), n, tolerance) == beside::agrees &&
              lies_over(solid, at.to_body(c_.centre), n);
      return !under;
    });
    return under;
  }
  /// Whether the body has a free face with about this normal near its point, which is inside the
  /// solid: beyond a wall that the other body overlaps, the floor does not end.
  template <class Solid>
  [[nodiscard]] bool goes_on(std::uint32_t number, const Solid& solid, const pose& at,
                             const vec3& p, real tolerance) const {
    bool any = false, free = false;
    each_face_at(number, point_, tolerance, [&](const vec3& face) {
      any = true;
      if (c_.round ? face.cross(c_.normal).norm() > real(1e-6) || face.dot(c_.normal) < 0
                   : face.dot(c_.normal) < real(0.5))
        return;
      const vec3 n = to_body(at, face);
      if (stands_beside(solid, p, n, tolerance) == beside::agrees) {
        // The surface is flat there. A face of the other body may be tilted by round-off.
        free = free || face.cross(c_.normal).norm() <= (c_.curved ? level_of_curved : level);
        return;
      }
      constexpr real infinity = std::numeric_limits<real>::infinity();
      real nearest = infinity, on_surface = infinity;
      const auto look = [&](real way, const vec3& there) {
        if (way >= on_surface || way > 2 * c_.radius || is_covered(number, there, face)) return;
        if (!c_.round && !is_in_view(number, there, vec3((there - point_) / way), face)) return;
        nearest = std::min(nearest, way);
        if (reaches(number, there, tolerance)) on_surface = way;
      };
      each_way_out(solid, p, n, tolerance,
                   [&](real way, const vec3& q) { look(way, at.to_world(q)); });
      if (nearest == infinity)  // in a corner: a way out of this solid leads into another one
        each_way_out(solid, p, n, tolerance, [&](real way, const vec3& q) {
          if (way > 2 * c_.radius) return;
          const vec3 first = at.to_world(q);
          each_cover(number, first, face, [&](const auto& second, const pose& its) {
            each_way_out(second, its.to_body(first), to_body(its, face), tolerance,
                         [&](real, const vec3& r) {
                           const vec3 there = its.to_world(r);
                           look((there - point_).norm(), there);
                         });
          });
        });
      free = free || on_surface <= 2 * nearest + 8 * tolerance;
    });
    return free || !any;
  }
  /// Whether the centre of the other body is in view from the face of this body, at a point beside
  /// the solid or next to it: not from a groove under an edge that they share. Where two grooves
  /// cross, a point in one of them may see it through the other.
  [[nodiscard]] bool is_in_view(std::uint32_t number, const vec3& p, const vec3& outwards,
                                const vec3& face) const {
    const real far = view_part * c_.radius;
    const vec3 there = p + far * outwards, side = far * face.cross(outwards);
    return sees(number, there) && (sees(number, there + side) || sees(number, there - side));
  }
  /// Whether no body on the way from a point to the centre of the other body is in between.
  [[nodiscard]] bool sees(std::uint32_t number, const vec3& p) const {
    const real tolerance = real(0.01) * view_part * c_.radius;
    bool free = true;
    const auto look = [&](std::uint32_t past) {
      each_solid(past, p, tolerance, [&](const auto& solid, const pose& at) {
        free = !leads_through(solid, at.to_body(p), at.to_body(c_.centre), tolerance);
        return free;
      });
      return free;
    };
    if (look(number)) s_.flush.each_near(number, p, reach_of(number), look);
    return free;
  }
  /// Calls f(solid, its frame) for the neighbours that cover a face of the body at a point.
  template <class F>
  void each_cover(std::uint32_t number, const vec3& p, const vec3& n, F&& f) const {
    s_.flush.each_near(number, p, reach_of(number), [&](std::uint32_t other) {
      const real tolerance = tolerance_of(number, other);
      each_solid(other, p, tolerance, [&](const auto& solid, const pose& at) {
        if (stands_beside(solid, at.to_body(p), to_body(at, n), tolerance) == beside::covers)
          f(solid, at);
        return true;
      });
      return true;
    });
  }
  [[nodiscard]] bool is_covered(std::uint32_t number, const vec3& p, const vec3& n) const {
    const auto& f = s_.flush;
    bool covered = false;
    f.each_near(number, p, reach_of(number), [&](std::uint32_t other) {
      const real tolerance = tolerance_of(number, other);
      each_solid(other, p, tolerance, [&](const auto& solid, const pose& at) {
        covered = stands_beside(solid, at.to_body(p), to_body(at, n), tolerance) == beside::covers;
        return !covered;
      });
      return !covered;
    });
    return covered;
  }
  /// Whether the body contains a point of the world.
  [[nodiscard]] bool reaches(std::uint32_t number, const vec3& p, real tolerance) const {
    bool inside = false;
    with_body(number, [&](const auto& store, std::size_t i) {
      const auto& shape = store.shape[i];
      if constexpr (is_triangulated<std::remove_cvref_t<decltype(shape)>>)
        each_triangle_at(shape.tree(), store.pose(i).to_body(p), tolerance,
                         [&](std::uint32_t) { inside = true; });
      else
        each_solid(number, p, tolerance, [&](const auto& solid, const pose& at) {
          const vec3 q = at.to_body(p);
          inside = solid.each_face(
              [&](const vec3& m, real offset) { return m.dot(q) - offset <= tolerance; });
          return true;
        });
    });
    return inside;
  }
  /// How far from a point neighbours of a body may contain it: triangles below them.
  [[nodiscard]] real reach_of(std::uint32_t number) const {
    return flush_part * s_.flush.all[number].radius + depth_;
  }
  [[nodiscard]] real tolerance_of(std::uint32_t a, std::uint32_t b) const {
    // Two planes have no radii.
    return flush_part * std::max(s_.flush.all[a].radius + s_.flush.all[b].radius, c_.radius);
  }
  /// Whether both bodies move the contact point alike in this step. (A belt stays.)
  [[nodiscard]] bool stay_together(std::uint32_t a, std::uint32_t b) const {
    if constexpr (state_type::drives) {
      const auto carried = [&](std::uint32_t number) {
        vec3 p = point_;
        with_body(number, [&](const auto& store, std::size_t i) {
          using shape = typename std::remove_cvref_t<decltype(store)>::shape_type;
          const driven_body* one = s_.flush.all[number].global ? driven_at<shape>(s_, i) : nullptr;
          if (one == nullptr) return;
          const rigid_place &from = one->state.at, &to = one->next.end;
          if (one->is_servo)
            p += s_.dt * store.velocity[i];
          else
            p = to.point + rotated(quat(to.turn * from.turn.conjugate()), vec3(p - from.point));
        });
        return p;
      };
      return (carried(a) - carried(b)).norm() <= tolerance_of(a, b);
    }
    return (void)a, (void)b, true;
  }
  /// Whether the contact of a counts, if a and b have the same contact: that of the faster surface
  /// at the contact counts, else that of a plane, else that of the body with the smaller id.
  [[nodiscard]] bool comes_first(std::uint32_t a, std::uint32_t b) const {
    const auto speed = [&](std::uint32_t number) {
      vec3 v(0, 0, 0);
      if (!state_type::drives && s_.flush.all[number].global) return real(0);
      with_body(number, [&](const auto& store, std::size_t i) {
        v = store.velocity[i] + store.angular_velocity[i].cross(point_ - store.position[i]);
      });
      return v.norm();
    };
    const flush_body &x = s_.flush.all[a], &y = s_.flush.all[b];
    const real faster = (speed(a) - speed(b)) * s_.dt;
    if (std::abs(faster) > tolerance_of(a, b)) return faster > 0;
    if ((x.radius == 0) != (y.radius == 0)) return x.radius == 0;
    return x.id < y.id;
  }

  state_type& s_;
  const contact_with_fixed& c_;
  vec3 point_;   ///< on the body whose contact it is
  vec3 normal_;  ///< of the contact, or of the face there if they are the same
  real depth_;
};

/// Whether contacts of a movable shape with a fixed one may be hidden. On a plane only those that
/// another surface there has too.
template <class Scenario, class Fixed, class Other>
inline constexpr bool has_contacts_hidden = world_state<Scenario>::may_be_flush &&
                                            (has_flat_faces<Fixed> ||
                                             (is_half_space<Fixed> && Other::isotropic));

/// Number of the fixed body k of a store among those that may be flush, if it touches others.
template <class Fixed, class Scenario>
[[nodiscard]] std::int32_t number_if_flush(const world_state<Scenario>& s, bool global,
                                           std::size_t k) {
  const std::int32_t number =
      s.flush.number_of(index_of<typename Scenario::shapes, Fixed>, global, k);
  return number >= 0 && s.flush.touches_any(static_cast<std::uint32_t>(number)) ? number : -1;
}
/// Whether one of two bodies is fixed and touches others.
template <class ShapeA, class ShapeB, bool Paired, class Scenario, class StoreA, class StoreB>
[[nodiscard]] bool is_beside_flush(const world_state<Scenario>& s, const StoreA& a, std::size_t i,
                                   const StoreB& b, std::size_t j) {
  if constexpr (has_contacts_hidden<Scenario, ShapeB, ShapeA>)
    if (s.flush.any() && (!Paired || b.inverse_mass[j] == 0))
      return number_if_flush<ShapeB>(s, !Paired, j) >= 0;
  if constexpr (Paired && has_contacts_hidden<Scenario, ShapeA, ShapeB>)
    if (s.flush.any() && a.inverse_mass[i] == 0) return number_if_flush<ShapeA>(s, false, i) >= 0;
  return (void)s, (void)a, (void)i, (void)b, (void)j, false;
}
/// Calls f(surface, number) for the contact of body l with the fixed body k of this number, which
/// is at `at` for this pair, if that touches other fixed bodies.
template <class Fixed, class Other, class Scenario, class StoreF, class StoreO, class F>
void with_flush_surface(world_state<Scenario>& s, const StoreF& fixed, std::size_t k,
                        const vec3& at, bool global, const StoreO& other, std::size_t l,
                        const vec3& centre, const vec3& point, const vec3& normal, F&& f) {
  const std::int32_t number = number_if_flush<Fixed>(s, global, k);
  if (number < 0) return;
  const vec3 image = fixed.position[k] - at;  // where it is among the others
  const contact_with_fixed c{point + image,
                             normal,
                             centre + image,
                             other.shape[l].bounding_radius(),
                             other.id[l],
                             Other::isotropic,
                             is_rounded<Other>,
                             is_rounded_whole<Other>,
                             index_of<typename Scenario::shapes, Other>,
                             l};
  flush_surface<Scenario> surface(s, c);
  f(surface, static_cast<std::uint32_t>(number));
}
/// Whether that contact is not on the common surface of flush bodies.
template <class Fixed, class Other, class Scenario, class StoreF, class StoreO>
[[nodiscard]] bool is_hidden_on(world_state<Scenario>& s, const StoreF& fixed, std::size_t k,
                                const vec3& at, bool global, const StoreO& other, std::size_t l,
                                const vec3& centre, const vec3& point, const vec3& normal) {
  bool hidden = false;
  if constexpr (has_contacts_hidden<Scenario, Fixed, Other>)
    with_flush_surface<Fixed, Other>(
        s, fixed, k, at, global, other, l, centre, point, normal,
        [&](auto& surface, std::uint32_t number) { hidden = surface.hides(number); });
  return hidden;
}
/// Calls f(surface, number) for the contact g of bodies i and j of two stores, which are at p_a and
/// p_b for this pair, if one of them is fixed and touches other fixed bodies.
template <class ShapeA, class ShapeB, bool Paired, class Scenario, class StoreA, class StoreB,
          class F>
[[gnu::noinline]] void on_flush_surface(world_state<Scenario>& s, const StoreA& a, std::size_t i,
                                        const vec3& p_a, const StoreB& b, std::size_t j,
                                        const vec3& p_b, const contact_geometry& g, F&& f) {
  const vec3 half_gap = real(0.5) * g.gap * g.normal;
  if (!Paired || b.inverse_mass[j] == 0) {
    if constexpr (has_contacts_hidden<Scenario, ShapeB, ShapeA>)
      with_flush_surface<ShapeB, ShapeA>(s, b, j, p_b, !Paired, a, i, p_a, g.point - half_gap,
                                         g.normal, f);
    return;
  }
  if constexpr (Paired && has_contacts_hidden<Scenario, ShapeA, ShapeB>)
    if (a.inverse_mass[i] == 0)
      with_flush_surface<ShapeA, ShapeB>(s, a, i, p_a, false, b, j, p_b, g.point + half_gap,
                                         -g.normal, f);
}
/// Whether contacts of two shapes may be on the common surface of flush bodies.
template <class Scenario, class ShapeA, class ShapeB, bool Paired>
inline constexpr bool may_be_on_flush_surface = has_contacts_hidden<Scenario, ShapeB, ShapeA> ||
                                                (Paired &&
                                                 has_contacts_hidden<Scenario, ShapeA, ShapeB>);
/// Whether the contact g of bodies i and j of two stores, which are at p_a and p_b for this pair,
/// is not on the common surface of flush bodies, if one of them is fixed.
template <class ShapeA, class ShapeB, bool Paired, class Scenario, class StoreA, class StoreB>
[[nodiscard, gnu::always_inline]] inline bool is_hidden(world_state<Scenario>& s, const StoreA& a,
                                                        std::size_t i, const vec3& p_a,
                                                        const StoreB& b, std::size_t j,
                                                        const vec3& p_b,
                                                        const contact_geometry& g) {
  bool hidden = false;
  if constexpr (may_be_on_flush_surface<Scenario, ShapeA, ShapeB, Paired>)
    if (s.flush.any()) [[unlikely]]
      on_flush_surface<ShapeA, ShapeB, Paired>(
          s, a, i, p_a, b, j, p_b, g,
          [&](auto& surface, std::uint32_t number) { hidden = surface.hides(number); });
  return hidden;
}

}  // namespace talus::detail
