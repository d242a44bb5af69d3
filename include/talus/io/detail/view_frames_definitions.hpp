#pragma once
// The definitions of view_frames.hpp, in the compiled part or in each program.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include "talus/core/error.hpp"
#include "talus/core/linkage.hpp"
#include "talus/core/sort.hpp"
#include "talus/io/detail/view_frames.hpp"

namespace talus::detail {

struct by_id {
  [[nodiscard]] bool operator()(const view_body& x, const view_body& y) const {
    return comes_before(x, y);
  }
};
/// What decides on the place of a body in a frame.
struct view_rank_of_body {
  int wall = 0, shape = 0, form = 0;
  std::uint32_t index = 0;

  friend bool operator<(const view_rank_of_body& x, const view_rank_of_body& y) {
    if (x.wall != y.wall) return x.wall < y.wall;
    if (x.shape != y.shape) return x.shape < y.shape;
    return x.form != y.form ? x.form < y.form : x.index < y.index;
  }
};
/// Whether what does not move is the same.
[[nodiscard]] inline bool looks_like(const view_body& x, const view_body& y) {
  return x.shape == y.shape && x.flags == y.flags && x.material == y.material && x.form == y.form &&
         x.size == y.size && x.mass == y.mass;
}
TALUS_INLINE void view_frames::leave_out(plain_vector<view_body>& all, view_frame& out) const {
  std::size_t kept = 0, bad = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const view_body& b = all[i];
    const quat& q = b.orientation;
    if (finite(b.position) && finite(b.velocity) && finite(q.vec()) && std::isfinite(q.w())) {
      all[kept++] = b;
    } else if (++bad == 1) {
      out.warning = compose("body {} of rank {} is at {} with velocity {}", b.id, b.rank,
                            text(b.position), text(b.velocity));
    }
  }
  all.resize(kept);
  if (bad > 0)
    out.warning =
        compose("{} bodies are left out, because their state is not finite; the first: {}", bad,
                out.warning);
}

/// Places the pieces of planes that are drawn: in the middle of the bodies, as large as all of
/// them. The size changes seldom, since a changed body takes a new row of the table.
TALUS_INLINE void view_frames::measure(plain_vector<view_body>& all) {
  constexpr double most = std::numeric_limits<double>::max();
  vec3 lower{most, most, most}, upper{-most, -most, -most};
  bool any = false, planes = false;
  for (const view_body& b : all) {
    if (b.shape == view_shape::plane) {
      planes = true;
      continue;
    }
    any = true;
    const double half = std::max({b.size[0], b.size[1], b.size[2]}) / 2;
    for (int k = 0; k < 3; ++k) {
      lower[k] = std::min(lower[k], b.position[k] - half);
      upper[k] = std::max(upper[k], b.position[k] + half);
    }
  }
  if (!planes) return;
  const double reach = any ? 0.5 * (upper - lower).norm() : 1;
  if (reach_ == 0 || reach > 2 * reach_)
    middle_ = any ? vec3(0.5 * (lower + upper)) : vec3(0, 0, 0), reach_ = 1.1 * reach;
  for (view_body& b : all) {
    if (b.shape != view_shape::plane) continue;
    // It comes with its normal as orientation, and a point of its surface.
    const vec3 n = rotated(b.orientation, vec3(0, 0, 1));
    b.position = middle_ - n.dot(middle_ - b.position) * n;
    b.size = {static_cast<float>(2 * reach_), static_cast<float>(2 * reach_), 0};
  }
}

TALUS_INLINE std::int32_t view_frames::number_of(std::uint64_t form) const {
  if (form == 0) return -1;
  const auto at = std::lower_bound(forms_.begin(), forms_.end(), form,
                                   [](const known_form& f, std::uint64_t id) { return f.id < id; });
  return at != forms_.end() && at->id == form ? at->number : -1;
}

/// The rows of bodies, which are in the order of their ids. New bodies and new forms are added.
TALUS_INLINE void view_frames::add_rows(const plain_vector<view_body>& all,
                                        plain_vector<std::uint32_t>& rows, view_blocks& to,
                                        view_frame& out) {
  plain_vector<known_body> merged;
  merged.reserve(known_.size() + all.size());
  plain_vector<std::uint32_t> added;
  std::size_t k = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    while (k < known_.size() && comes_before(known_[k].body, all[i])) merged.push_back(known_[k++]);
    const bool here = k < known_.size() && !comes_before(all[i], known_[k].body);
    known_body one = here ? known_[k++] : known_body{all[i], rows_};
    if (!here || !looks_like(one.body, all[i])) {
      one = {all[i], rows_++};
      added.push_back(static_cast<std::uint32_t>(i));
    }
    merged.push_back(one), rows[i] = one.row;
  }
  while (k < known_.size()) merged.push_back(known_[k++]);
  known_.swap(merged);
  if (added.empty()) return;

  std::string numbers;
  for (const std::uint32_t i : added) {
    if (all[i].form == 0) continue;
    const auto at =
        std::lower_bound(forms_.begin(), forms_.end(), all[i].form,
                         [](const known_form& f, std::uint64_t id) { return f.id < id; });
    if (at == forms_.end() || at->id != all[i].form || at->number >= 0) continue;
    at->number = numbered_forms_++;
    const std::string number = std::to_string(at->number);
    (numbers += numbers.empty() ? "" : ",") += number;
    view_form& f = pending_[at->at];
    to.put("form_points_" + number, f.points);
    to.put("form_corners_" + number, f.corners);
    f = {};
  }
  if (!numbers.empty()) out.head.add_raw("forms", "[" + numbers + "]");
  const auto column = [&]<class T>(const char* name, T, auto&& value) {
    plain_vector<T> values;
    values.reserve(added.size());
    for (const std::uint32_t i : added) values.push_back(static_cast<T>(value(all[i])));
    to.put(name, values);
  };
  column("new_id", std::uint64_t{}, [](const view_body& b) { return value_of(b.id); });
  column("new_shape", std::uint8_t{}, [](const view_body& b) { return b.shape; });
  column("new_flags", std::uint8_t{}, [](const view_body& b) { return b.flags; });
  column("new_material", std::uint16_t{}, [](const view_body& b) { return b.material; });
  column("new_part", std::uint32_t{}, [](const view_body& b) { return b.part; });
  column("new_form", std::int32_t{}, [&](const view_body& b) { return number_of(b.form); });
  column("new_mass", float{}, [](const view_body& b) { return b.mass; });
  plain_vector<float> sizes;
  for (const std::uint32_t i : added)
    for (const float size : all[i].size) sizes.push_back(size);
  to.put("new_size", sizes);
}

TALUS_INLINE view_frame view_frames::make(std::vector<view_part>& parts) {
  view_frame out;
  view_blocks to(out.bytes);
  plain_vector<view_body> all;
  std::string seconds, domains;
  for (std::size_t rank = 0; rank < parts.size(); ++rank) {
    view_part& p = parts[rank];
    all.append(std::span<const view_body>(p.bodies.data(), p.bodies.size()));
    p.bodies = {};
    seconds += seconds.empty() ? "[" : ",[";
    for (std::size_t k = 0; k < p.seconds.size(); ++k)
      (seconds += k > 0 ? "," : "") += view_json::number(p.seconds[k]);
    seconds += "]";
    for (view_form& f : p.forms) {
      const auto at =
          std::lower_bound(forms_.begin(), forms_.end(), f.id,
                           [](const known_form& k, std::uint64_t id) { return k.id < id; });
      if (at != forms_.end() && at->id == f.id) continue;
      forms_.insert(at, {f.id, -1, static_cast<std::uint32_t>(pending_.size())});
      pending_.push_back(std::move(f));
    }
    if (p.domain.empty()) continue;
    (domains += domains.empty() ? "" : ",") +=
        "{\"rank\":" + std::to_string(rank) + ",\"planes\":[";
    bool first = true;
    for (const view_plane& plane : p.domain)
      domains += compose("{}[{},{},{},{}]", std::exchange(first, false) ? "" : ",",
                         view_json::number(plane.normal[0]), view_json::number(plane.normal[1]),
                         view_json::number(plane.normal[2]), view_json::number(plane.distance));
    domains += "]}";
  }
  leave_out(all, out);
  measure(all);
  sort_values(all, by_id{});
  plain_vector<std::uint32_t> rows(all.size());
  add_rows(all, rows, to, out);
  const auto table = [&] {
    view_json head = out.head;
    head.add("table", 1), head.add_raw("blocks", to.where());
    return view_table{head.str(), out.bytes.size()};
  };
  const bool other_domains = domains != domains_;
  if (other_domains) out.head.add_raw("domains", "[" + domains + "]"), domains_ = domains;
  if (!out.bytes.empty() || other_domains) out.table = table();

  // The order of a frame: bodies of one form follow each other.
  plain_vector<view_rank_of_body> keys(all.size());
  for (std::uint32_t i = 0; i < keys.size(); ++i)
    keys[i] = {all[i].flags & view_wall, static_cast<int>(all[i].shape), number_of(all[i].form), i};
  sort_values(keys);
  plain_vector<std::uint32_t> order(all.size());
  for (std::size_t k = 0; k < keys.size(); ++k) order[k] = keys[k].index;
  plain_vector<std::uint32_t> shown(all.size()), place_of(all.size());
  for (std::uint32_t k = 0; k < order.size(); ++k)
    shown[k] = rows[order[k]], place_of[order[k]] = k;
  const bool same = shown_.size() == shown.size() && rows_ > 0 &&
                    std::equal(shown.begin(), shown.end(), shown_.begin());
  if (!same) to.put("rows", shown), out.table_with_rows = table();
  shown_.swap(shown);

  const view_grid grid(all);
  grid.put("position", to, [&](auto&& put) {
    for (const std::uint32_t i : order) put(all[i].position);
  });
  put_motion(out.head, to, all, order, parts.size() > 1);
  const view_places places(all, place_of);
  plain_vector<view_contact> contacts;
  plain_vector<view_joint> joints;
  for (const view_part& p : parts) {
    for (const view_contact& c : p.contacts)
      if (finite(c.point) && finite(c.force)) contacts.push_back(c);
    for (const view_joint& j : p.joints) joints.push_back(j);
  }
  put_contacts(out.head, to, grid, places, contacts, contacts_);
  put_joints(to, grid, places, joints);

  out.head.add("ranks", static_cast<double>(parts.size()));
  out.head.add_raw("lower", view_json::vector(grid.lower()));
  out.head.add_raw("cell", view_json::vector(grid.cell()));
  out.head.add("position_error", grid.error());
  out.head.add_raw("seconds", "[" + seconds + "]");
  if (!out.warning.empty()) out.head.add_raw("notes", "[" + detail::quoted_text(out.warning) + "]");
  out.head.add_raw("blocks", to.where());
  return out;
}

}  // namespace talus::detail
