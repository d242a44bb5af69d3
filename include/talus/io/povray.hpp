#pragma once
// Pictures: a world as a scene file for the ray tracer POV-Ray.
#include <algorithm>
#include <array>
#include <cstring>
#include <exception>
#include <limits>
#include <string>
#include <type_traits>

#include "talus/core/output_file.hpp"
#include "talus/io/output_kinds.hpp"
#include "talus/io/povray_text.hpp"
#include "talus/world/each_joint.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// The view of a world. Lengths are in the units of the scene, angles in degrees.
struct picture {
  enum class colouring { rank, speed };

  vec3 from{10, -20, 10};  ///< position of the camera
  vec3 at{0, 0, 0};        ///< point at which it looks
  /// upward direction in the picture
  vec3 up{0, 0, 1};
  real angle = 40;  ///< of view, horizontally
  /// of bodies: by their rank, or by their speed
  colouring colour = colouring::rank;
  real fastest = 0;      ///< the speed that is red; 0: that of the fastest body
  bool copies = false;   ///< show shadow copies, as thin shells, in the colour of their holder
  bool domains = false;  ///< show the domain of each rank, as glass
  bool ground = true;    ///< show planes, those that face the camera
  bool joints = true;    ///< show joints: a ball at each, and a bar if its points are apart
  bool force = false;    ///< replace a file that is not a picture of talus
};

namespace detail {

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
  povray_scene(world<Scenario>& w, const picture& look) : world_(w), look_(look) { measure(); }

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
          add(b, finite ? vec3(0.66, 0.61, 0.54) : vec3(0.93, 0.92, 0.9), false);
      } else if (!b.is_remote()) {
        add(b, look_.colour == picture::colouring::rank ? own : of_speed(b), false);
      } else if (look_.copies) {
        add(b, own, true);
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
  template <class Body>
  [[nodiscard]] vec3 of_speed(const Body& b) const {
    if (b.is_fixed()) return {0.8, 0.78, 0.75};
    return colour_of_part(fastest_ > 0 ? b.velocity().norm() / fastest_ : 0);
  }
  template <class Body>
  void add(const Body& b, const vec3& colour, bool glass) {
    povray_form(out_, b.shape());
    out_ << " ";
    if constexpr (std::remove_cvref_t<decltype(b.shape())>::finite) add_placement(out_, b.pose());
    paint(b.is_fixed() && !b.is_global() ? vec3(0.6 * colour + vec3(0.35, 0.35, 0.35)) : colour,
          glass ? 0.7 : 0);
  }
  /// A ball whose size follows from the bodies, dark so that it differs from these; and a bar
  /// between points that are apart, as those of a rod.
  void add_joint(const joint_in_world& x) {
    const vec3 colour(0.12, 0.12, 0.14);
    const real size = real(0.12) * std::min(room(x.centre_a, x.point_a, x.centre_b, x.point_b),
                                            real(0.1) * (upper_ - lower_).norm());
    if (!(size > 0)) return;
    for (const vec3& at : {x.point_a, x.point_b}) {
      out_ << "sphere{" << at << "," << size << " ";
      paint(colour, 0);
      if ((x.point_a - x.point_b).norm() < size) return;
    }
    out_ << "cylinder{" << x.point_a << "," << x.point_b << "," << real(0.5) * size << " ";
    paint(colour, 0);
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
/// are grey. Throws runtime_error if the file cannot be written, or if an existing file is not a
/// picture.
template <class Scenario>
void write_povray(world<Scenario>& w, const std::string& file, const picture& look) {
  w.require_all_ranks("write_povray");
  detail::povray_scene<Scenario> scene(w, look);
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
