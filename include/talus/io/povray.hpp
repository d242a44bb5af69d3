#pragma once
// Pictures: a world as a scene file for the ray tracer POV-Ray.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <exception>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <type_traits>

#include "talus/core/output_file.hpp"
#include "talus/io/output_kinds.hpp"
#include "talus/io/povray_text.hpp"
#include "talus/world/each_joint.hpp"
#include "talus/world/picture.hpp"
#include "talus/world/world.hpp"

namespace talus {

namespace detail {

/// The centre of the body with this number on any rank; none: there is no such body. Collective,
/// unless the number is no_id on all ranks.
template <class Scenario>
[[nodiscard, gnu::cold]] std::optional<vec3> centre_of_followed(world<Scenario>& w, system_id id) {
  if (id == no_id) return {};
  constexpr real infinity = std::numeric_limits<real>::infinity();
  std::array<double, 3> centre{-infinity, -infinity, -infinity};
  w.for_each_known([&](const auto& b) {
    if (b.id() == id && !b.is_remote())
      for (int k = 0; k < 3; ++k) centre[static_cast<std::size_t>(k)] = b.position()[k];
  });
  w.link().reduce(reduction::max, centre);
  if (centre[0] == -infinity) return {};
  return vec3(centre[0], centre[1], centre[2]);
}
/// The number of a body that at least one rank knows. Collective.
template <class Link>
[[nodiscard, gnu::cold]] system_id agreed_id(Link& link, system_id id) {
  std::uint64_t number = static_cast<std::uint64_t>(id);
  link.reduce(reduction::min, std::span(&number, 1));
  return system_id{number};
}

/// Writes a region as a solid: intersections and unions of POV-Ray's half-spaces.
class povray_region {
 public:
  explicit povray_region(povray_text& out) : out_(out) {}
  void open(bool all_of) { out_ << (all_of ? "intersection{" : "union{"); }
  void plane(const half_space& h) {  // solid where n.x <= d there
    out_ << "plane{" << vec3(-h.normal()) << "," << -h.displacement() << "}";
  }
  void close() { out_ << "}"; }

 private:
  povray_text& out_;
};

template <class Scenario>
class povray_scene {
 public:
  povray_scene(world<Scenario>& w, const picture& look) : world_(w), look_(look) {
    if (const auto centre = centre_of_followed(w, look.follow))
      look_.from += *centre, look_.at += *centre;
    if (look_.colour == picture::colouring::automatic)
      look_.colour = w.ranks() == 1 || shows_materials(view_of(w).materials)
                         ? picture::colouring::material
                         : picture::colouring::rank;
    measure();
  }

  /// A plane with the camera behind it would hide everything.
  template <class Shape>
  [[nodiscard]] bool shows(const Shape& shape) const {
    if constexpr (requires { shape.distance(look_.from); })
      return look_.ground && shape.distance(look_.from) > 0;
    else
      return look_.ground;
  }
  /// The part of this rank in the picture.
  [[nodiscard]] std::string part() {
    const bool first = world_.rank() == 0;
    const vec3 own = colour_of_number(world_.rank());
    world_.for_each_known([&](const auto& b) {
      if (!b.is_visible()) return;
      if (b.is_global()) {
        constexpr bool finite = std::remove_cvref_t<decltype(b)>::shape_type::finite;
        if (first && (finite || shows(b.shape())))
          add(b, of_wall(b, finite), finite ? of_walls<decltype(b)>() : 0);
      } else if (!b.is_remote()) {
        add(b, colour(b, own), b.is_fixed() ? of_walls<decltype(b)>() : 0);
      } else if (look_.copies) {
        add(b, own, 0.7);
      }
    });
    if (look_.joints) for_each_joint(world_, [&](const joint_in_world& x) { add_joint(x); });
    if (look_.domains) add_domain(own);
    return out_.str();
  }

  /// Camera, lights, background.
  [[nodiscard]] std::string head() const {
    povray_text out;
    const vec3 view = look_.at - look_.from, side = view.cross(look_.up);
    const vec3 over = look_.up.normalized() * view.norm();
    out << picture_mark
        << "global_settings{max_trace_level 64}\n"  // faces of transparent walls on a ray
        << "background{srgb<1,1,1>}\n"
        // Seen from a right-handed world: right is minus POV-Ray's.
        << "camera{location " << look_.from << " sky " << look_.up
        << " right -x*image_width/image_height look_at " << look_.at << " angle " << look_.angle
        << "}\n"
        << "light_source{" << vec3(look_.from + over - 0.6 * side) << " rgb 0.9}\n"
        << "light_source{" << vec3(look_.from + 0.8 * side) << " rgb 0.35 shadowless}\n"
        << "#default{finish{ambient 0.18 diffuse 0.75 specular 0.15 roughness 0.05}}\n";
    return out.str();
  }

 private:
  /// Fastest body and bounds of the scene. Collective.
  void measure() {
    constexpr real infinity = std::numeric_limits<real>::infinity();
    std::array<double, 7> most;
    most.fill(-infinity);
    most[6] = 0;
    world_.for_each_local([&](const auto& b) {
      const real r = b.shape().bounding_radius();
      for (int k = 0; k < 3; ++k) {
        most[k] = std::max(most[k], b.position()[k] + r);
        most[k + 3] = std::max(most[k + 3], r - b.position()[k]);
      }
      most[6] = std::max(most[6], b.velocity().norm());
    });
    world_.link().reduce(reduction::max, most);
    upper_ = {most[0], most[1], most[2]};
    lower_ = {-most[3], -most[4], -most[5]};
    fastest_ = look_.fastest > 0 ? look_.fastest : most[6];
  }
  [[nodiscard]] bool by_material() const { return look_.colour == picture::colouring::material; }
  /// A fixed body is paler than others.
  [[nodiscard]] static vec3 pale(const vec3& colour) {
    return vec3(0.6 * colour + vec3(0.35, 0.35, 0.35));
  }
  template <class Body>
  [[nodiscard]] vec3 colour(const Body& b, const vec3& of_rank) const {
    if (by_material()) {
      const vec3 own = colour_of_material(view_of(world_).materials[b.material()], b.material());
      return b.is_fixed() && !has_colour(b) ? pale(own) : own;
    }
    if (look_.colour == picture::colouring::rank) return b.is_fixed() ? pale(of_rank) : of_rank;
    if (b.is_fixed()) return pale({0.8, 0.78, 0.75});
    return colour_of_part(fastest_ > 0 ? b.velocity().norm() / fastest_ : 0);
  }
  template <class Body>
  [[nodiscard]] bool has_colour(const Body& b) const {
    const vec3& c = view_of(world_).materials[b.material()].colour;
    return c[0] == c[0];
  }
  template <class Body>
  [[nodiscard]] vec3 of_wall(const Body& b, bool finite) const {
    if (by_material() && has_colour(b)) return view_of(world_).materials[b.material()].colour;
    return finite ? vec3(0.66, 0.61, 0.54) : vec3(0.93, 0.92, 0.9);
  }
  /// What a face of a wall transmits, so that bodies are seen through it: a ray meets two faces of
  /// a solid, and one of a surface of triangles.
  template <class Body>
  [[nodiscard]] real of_walls() const {
    const real all = 1 - std::clamp(look_.walls, real{0}, real{1});
    using shape = typename std::remove_cvref_t<Body>::shape_type;
    if constexpr (requires(const shape& s) { s.tree().triangles; })
      return all;
    else
      return std::sqrt(all);
  }
  template <class Body>
  void add(const Body& b, const vec3& colour, real transmit) {
    if (transmit >= 1) return;
    povray_form(out_, b.shape());
    out_ << " ";
    if constexpr (std::remove_cvref_t<decltype(b.shape())>::finite) add_placement(out_, b.pose());
    paint(colour, transmit);
  }
  /// A ball whose size follows from the bodies, dark so that it differs from these; bars to the
  /// centres of the bodies, and one between points that are apart, as those of a rod.
  void add_joint(const joint_in_world& x) {
    const vec3 colour(0.12, 0.12, 0.14);
    const real size = real(0.12) * std::min(room(x.centre_a, x.point_a, x.centre_b, x.point_b),
                                            real(0.1) * (upper_ - lower_).norm());
    if (!(size > 0)) return;
    const auto bar = [&](const vec3& from, const vec3& to, real thickness) {
      if ((from - to).norm() < size) return false;
      out_ << "cylinder{" << from << "," << to << "," << thickness << " ";
      paint(colour, 0);
      return true;
    };
    const auto ball = [&](const vec3& at) {
      out_ << "sphere{" << at << "," << size << " ";
      paint(colour, 0);
    };
    ball(x.point_a);
    if (bar(x.point_a, x.point_b, real(0.5) * size)) ball(x.point_b);
    (void)bar(x.centre_a, x.point_a, real(0.3) * size);
    (void)bar(x.centre_b, x.point_b, real(0.3) * size);
  }
  /// The longest arm of a joint.
  [[nodiscard]] static real room(const vec3& a, const vec3& at_a, const vec3& b, const vec3& at_b) {
    return std::max((a - at_a).norm(), (b - at_b).norm());
  }
  void add_domain(const vec3& colour) {
    if (world_.connections().empty()) return;
    const auto& domain = view_of(world_).own;
    const vec3 room = 0.02 * (upper_ - lower_);
    out_ << "intersection{box{" << vec3(lower_ - room) << "," << vec3(upper_ + room) << "}";
    povray_region region(out_);
    const auto by_hand = [&] {
      for (const connection& c : world_.connections()) complement(c.geometry).describe(region);
    };
    if constexpr (requires { domain.partition()->geometry(0); }) {
      if (domain.partition() != nullptr)
        any_geometry(domain.partition()->geometry(world_.rank())).describe(region);
      else
        by_hand();
    } else {
      by_hand();
    }
    paint(colour, 0.85);
  }
  void paint(const vec3& c, real transmit) {
    out_ << "pigment{srgbt<" << c[0] << "," << c[1] << "," << c[2] << "," << transmit << ">}}\n";
  }

  world<Scenario>& world_;
  picture look_;
  povray_text out_;
  vec3 lower_{0, 0, 0}, upper_{0, 0, 0};
  real fastest_ = 0;
};

}  // namespace detail

/// Collective: writes the present state to one scene file. Owners draw their bodies; global bodies
/// without a colour of their material are grey. Throws runtime_error if the file cannot be written,
/// or if an existing file is not a picture.
template <class Scenario>
void write_povray(world<Scenario>& w, const std::string& file, const picture& look) {
  w.require_all_ranks("write_povray");
  picture agreed = look;
  agreed.follow = detail::agreed_id(w.link(), look.follow);
  detail::povray_scene<Scenario> scene(w, agreed);
  const std::string part = scene.part();
  detail::byte_buffer bytes(part.size());
  if (!part.empty()) std::memcpy(bytes.data(), part.data(), part.size());
  const auto parts = w.link().gather(bytes);
  if (w.rank() != 0) return;
  std::string text = scene.head();
  for (const auto& p : parts) text.append(reinterpret_cast<const char*>(p.data()), p.size());
  try {
    detail::write_output(file, text, detail::picture_output, look.force);
  } catch (const std::exception& e) {
    detail::fail<std::runtime_error>("the picture {} of step {} {}", file, w.steps(), e.what());
  }
}

}  // namespace talus
