#pragma once
// Contacts that pass from triangle to triangle of a mesh: one contact of a body goes on, with its
// springs, whatever triangle has it in this step.
#include <algorithm>
#include <cstdint>

#include "talus/contact/contact_geometry.hpp"
#include "talus/contact/history.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/detect/triangle_feature.hpp"
#include "talus/interaction/film_bridge.hpp"
#include "talus/shape/nearest_on_triangle.hpp"

namespace talus::detail {

/// The contacts of a body with a mesh. `Law` is the composed law, `Kept` the memory of a contact.
template <class Law, class Kept>
class passing_contacts {
 public:
  /// Before the contacts of a pair.
  void begin() { features_.clear(), others_.clear(); }
  /// Notes a contact. Returns false if it is new and may have come from another triangle; it is
  /// then among the others.
  [[nodiscard]] bool stays(const contact_geometry& g, bool known) {
    if (known)
      features_.push_back(g.feature);
    else
      others_.push_back(g);
    return known;
  }
  [[nodiscard]] const plain_vector<contact_geometry>& others() const { return others_; }
  /// The memory of that contact of the last step which this one goes on with: of the same part of
  /// the body and with the triangle nearest to the point, of those that do not go on with their own
  /// triangle. Null for a new contact.
  template <class Tree>
  [[nodiscard]] const Kept* former(const history_of<Kept>& history, history_place before,
                                   const contact_key& key, const Tree& m, const vec3& point,
                                   real radius) {
    const auto* best = static_cast<const typename history_of<Kept>::entry*>(nullptr);
    const real near = near_part * radius;
    real least = near * near;
    const auto look = [&](const auto& e) {
      if (((e.key.feature ^ key.feature) & other_parts) != 0) return;
      const std::uint32_t t = triangle_of(e.key.feature);
      if (t >= m.triangles.size() ||
          std::find(features_.begin(), features_.end(), e.key.feature) != features_.end())
        return;
      const vec3 at = nearest_on_triangle(point, m.corner(t, 0), m.corner(t, 1), m.corner(t, 2)).at;
      if (const real square = (at - point).squaredNorm(); square < least) least = square, best = &e;
    };
    if (const auto row = history.row(before, key); !row.empty())
      for (const auto& e : row) look(e);
    else
      history.each_of_pair(key, look);
    if (best == nullptr) return nullptr;
    features_.push_back(best->key.feature);
    passed_ = best->memory;
    // The bridges of films are booked by their keys.
    Law::each_part([&]<class Part>() {
      if constexpr (takes_liquid<Part>) Law::template of<Part>(passed_) = {};
    });
    return &passed_;
  }

 private:
  /// How far from the contact its former triangle may be, as a part of the radius of the body.
  static constexpr real near_part = 0.1;

  plain_vector<std::uint64_t> features_;  ///< of former contacts that go on
  plain_vector<contact_geometry> others_;
  Kept passed_;
};

}  // namespace talus::detail
