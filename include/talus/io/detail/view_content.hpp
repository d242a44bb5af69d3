#pragma once
// The blocks of a frame of the viewer's page that change from frame to frame.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

#include "talus/body/material.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/io/detail/view_blocks.hpp"
#include "talus/io/detail/view_part.hpp"
#include "talus/world/picture.hpp"

namespace talus::detail {

/// The number of contacts stored for each frame, at most: the strongest ones.
inline constexpr std::size_t most_view_contacts = 50000;

/// The order of ids and parts.
[[nodiscard]] inline bool comes_before(const view_body& x, const view_body& y) {
  return x.id != y.id ? value_of(x.id) < value_of(y.id) : x.part < y.part;
}
/// Bodies by their ids, of a union the first part, and their places in the frame.
class view_places {
 public:
  view_places(const plain_vector<view_body>& all, const plain_vector<std::uint32_t>& place_of)
      : all_(all), place_of_(place_of) {}
  [[nodiscard]] const view_body* find(system_id id) const {
    view_body key;
    key.id = id;
    const auto at = std::lower_bound(all_.begin(), all_.end(), key, comes_before);
    return at != all_.end() && at->id == id ? at : nullptr;
  }
  [[nodiscard]] std::uint32_t of(system_id id) const {
    const view_body* const b = find(id);
    return b != nullptr ? place_of_[static_cast<std::size_t>(b - all_.begin())] : ~std::uint32_t{0};
  }
  /// Calls f(body, place) for all bodies, those of one id one after the other.
  template <class F>
  void each(F&& f) const {
    for (std::size_t i = 0; i < all_.size(); ++i) f(all_[i], place_of_[i]);
  }

 private:
  const plain_vector<view_body>& all_;  ///< in the order of ids and parts
  const plain_vector<std::uint32_t>& place_of_;
};

/// Velocities, orientations and states of bodies in the order of the frame, and the bounds of all.
[[gnu::cold]] void put_motion(view_json& head, view_blocks& to, const plain_vector<view_body>& all,
                              const plain_vector<std::uint32_t>& order, bool several_ranks);
/// The sum of the sizes of the contact forces on each body, and the number of its contacts; with
/// `each` also the strongest contacts, the strongest first.
[[gnu::cold]] void put_contacts(view_json& head, view_blocks& to, const view_grid& grid,
                                const view_places& places, plain_vector<view_contact>& contacts,
                                bool each);
/// Names and colours of materials, and the view that a program names, as JSON.
[[nodiscard, gnu::cold]] std::string view_materials(const material_table& all);
[[nodiscard, gnu::cold]] std::string view_look(const picture& look);
/// Joints, which all ranks of their bodies report, with the point of each body.
[[gnu::cold]] void put_joints(view_blocks& to, const view_grid& grid, const view_places& places,
                              plain_vector<view_joint>& joints);

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/io/detail/view_content_definitions.hpp"
#endif
