#pragma once
// The definitions of view_frames.hpp, in the compiled part or in each program.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "talus/core/error.hpp"
#include "talus/core/linkage.hpp"
#include "talus/io/detail/view_frames.hpp"

namespace talus::detail {

TALUS_INLINE std::string view_json::quoted(std::string_view text) {
  static constexpr const char* digits = "0123456789abcdef";
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') (out += '\\') += c;
    else if (static_cast<unsigned char>(c) < 0x20 || c == '<')
      ((out += "\\u00") += digits[c >> 4 & 15]) += digits[c & 15];
    else out += c;
  }
  return out += '"';
}
TALUS_INLINE std::string view_json::number(double value) {
  return std::isfinite(value) ? text(value) : "null";
}
TALUS_INLINE std::string view_json::vector(const vec3& v) {
  return "[" + number(v[0]) + "," + number(v[1]) + "," + number(v[2]) + "]";
}
TALUS_INLINE void view_json::add_raw(std::string_view key, std::string_view json) {
  if (!text_.empty()) text_ += ',';
  ((text_ += quoted(key)) += ':') += json;
}
TALUS_INLINE void view_json::add(std::string_view key, double value) {
  add_raw(key, number(value));
}
TALUS_INLINE void view_json::add_text(std::string_view key, std::string_view text) {
  add_raw(key, quoted(text));
}

/// The arrays of a frame, each at a multiple of eight bytes, and where they are.
class view_frames::blocks {
 public:
  explicit blocks(byte_buffer& to) : to_(to) {}
  template <class T>
  void put(std::string_view name, const plain_vector<T>& values) {
    put(name, std::span(values.data(), values.size()));
  }
  template <class T>
  void put(std::string_view name, std::span<const T> values) {
    static_assert(std::is_arithmetic_v<T>);
    to_.resize((to_.size() + 7) / 8 * 8);
    const std::size_t at = to_.size();
    to_.resize(at + values.size_bytes());
    if (!values.empty()) std::memcpy(to_.data() + at, values.data(), values.size_bytes());
    constexpr char kind = std::is_floating_point_v<T> ? 'f' : std::is_signed_v<T> ? 'i' : 'u';
    where_.add_raw(name, compose("[\"{}{}\",{},{}]", kind, 8 * sizeof(T), at, values.size()));
  }
  [[nodiscard]] std::string where() const { return where_.str(); }

 private:
  byte_buffer& to_;
  view_json where_;
};

/// The grid of whole cells in which a frame holds its positions. Where cells would be coarse beside
/// bodies it has numbers of single precision instead.
class view_grid {
 public:
  explicit view_grid(const plain_vector<view_body>& all) {
    constexpr double most = std::numeric_limits<double>::max();
    vec3 upper{-most, -most, -most};
    lower_ = {most, most, most};
    double smallest = most, largest = 0;
    for (const view_body& b : all) {
      for (int k = 0; k < 3; ++k) {
        lower_[k] = std::min(lower_[k], b.position[k]), upper[k] = std::max(upper[k], b.position[k]);
        largest = std::max(largest, std::abs(b.position[k]));
      }
      if (b.shape == view_shape::plane) continue;
      smallest = std::min<double>(smallest, std::max({b.size[0], b.size[1], b.size[2]}) / 2);
    }
    if (all.empty()) lower_ = upper = {0, 0, 0};
    for (int k = 0; k < 3; ++k) {
      const double extent = upper[k] - lower_[k];
      cell_[k] = extent > 0 ? extent / 65535 : 1;
      if (extent > 0) error_ = std::max(error_, cell_[k] / 2);
    }
    whole_ = error_ <= 0.002 * smallest;
    if (whole_) return;
    lower_ = {0, 0, 0}, cell_ = {1, 1, 1};
    error_ = std::ldexp(largest, -24);
  }
  /// `each(f)` calls f(point) for all points.
  template <class Each>
  void put(std::string_view name, view_frames::blocks& to, Each&& each) const;

  [[nodiscard]] double error() const { return error_; }
  [[nodiscard]] const vec3& lower() const { return lower_; }
  [[nodiscard]] const vec3& cell() const { return cell_; }
  [[nodiscard]] bool whole() const { return whole_; }

 private:
  vec3 lower_{0, 0, 0}, cell_{1, 1, 1};
  double error_ = 0;
  bool whole_ = true;
};

/// The order of ids and parts.
[[nodiscard]] inline bool comes_before(const view_body& x, const view_body& y) {
  return x.id != y.id ? value_of(x.id) < value_of(y.id) : x.part < y.part;
}
/// Whether what does not move is the same.
[[nodiscard]] inline bool looks_like(const view_body& x, const view_body& y) {
  return x.shape == y.shape && x.flags == y.flags && x.material == y.material && x.form == y.form &&
         x.size == y.size && x.mass == y.mass;
}
/// Converts sizes to whole numbers of cells in [0, 65535].
[[nodiscard]] inline std::uint16_t cells_of(double x) {
  return static_cast<std::uint16_t>(std::clamp(std::round(x), 0.0, 65535.0));
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
    out.warning = compose("{} bodies are left out, because their state is not finite; the first: {}",
                          bad, out.warning);
}

/// Places the pieces of planes that are drawn: in the middle of the bodies, as large as all of them.
/// The size changes seldom, since a changed body takes a new row of the table.
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
                                        plain_vector<std::uint32_t>& rows, blocks& to,
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
    to.put("form_points_" + number, std::span<const float>(f.points));
    to.put("form_corners_" + number, std::span<const std::uint32_t>(f.corners));
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

template <class Each>
void view_grid::put(std::string_view name, view_frames::blocks& to, Each&& each) const {
  plain_vector<std::uint16_t> cells;
  plain_vector<float> numbers;
  each([&](const vec3& p) {
    for (int k = 0; k < 3; ++k)
      if (whole_)
        cells.push_back(cells_of((p[k] - lower_[k]) / cell_[k]));
      else
        numbers.push_back(static_cast<float>(p[k]));
  });
  if (whole_)
    to.put(name, cells);
  else
    to.put(name, numbers);
}

TALUS_INLINE view_frame view_frames::make(std::vector<view_part>& parts) {
  view_frame out;
  blocks to(out.bytes);
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
    (domains += domains.empty() ? "" : ",") += "{\"rank\":" + std::to_string(rank) + ",\"planes\":[";
    bool first = true;
    for (const view_plane& plane : p.domain)
      domains += compose("{}[{},{},{},{}]", std::exchange(first, false) ? "" : ",",
                         view_json::number(plane.normal[0]), view_json::number(plane.normal[1]),
                         view_json::number(plane.normal[2]), view_json::number(plane.distance));
    domains += "]}";
  }
  leave_out(all, out);
  measure(all);
  std::sort(all.begin(), all.end(), comes_before);
  plain_vector<std::uint32_t> rows(all.size());
  add_rows(all, rows, to, out);

  // The order of a frame: bodies of one form follow each other.
  plain_vector<std::uint32_t> order(all.size());
  plain_vector<std::int32_t> forms(all.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i, forms[i] = number_of(all[i].form);
  std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
    const view_body &x = all[i], &y = all[j];
    const int wall_x = x.flags & view_wall, wall_y = y.flags & view_wall;
    if (wall_x != wall_y) return wall_x < wall_y;
    if (x.shape != y.shape) return x.shape < y.shape;
    return forms[i] != forms[j] ? forms[i] < forms[j] : i < j;
  });
  plain_vector<std::uint32_t> shown(all.size()), place_of(all.size());
  for (std::uint32_t k = 0; k < order.size(); ++k)
    shown[k] = rows[order[k]], place_of[order[k]] = k;
  const bool same = shown_.size() == shown.size() && rows_ > 0 &&
                    std::equal(shown.begin(), shown.end(), shown_.begin());
  if (!same) to.put("rows", shown);
  shown_.swap(shown);

  const view_grid grid(all);
  grid.put("position", to, [&](auto&& put) {
    for (const std::uint32_t i : order) put(all[i].position);
  });
  constexpr double most = std::numeric_limits<double>::max();
  vec3 lower{most, most, most}, upper{-most, -most, -most};
  double fastest = 0, speed = 0;
  bool asleep = false;
  std::size_t movable = 0;
  for (const view_body& b : all) {
    for (int k = 0; k < 3; ++k) speed = std::max(speed, std::abs(b.velocity[k]));
    asleep = asleep || b.asleep != 0;
    if ((b.flags & view_wall) != 0) continue;
    fastest = std::max(fastest, b.velocity.norm()), movable += b.part == 0;
    const double half = std::max({b.size[0], b.size[1], b.size[2]}) / 2;
    for (int k = 0; k < 3; ++k) {
      lower[k] = std::min(lower[k], b.position[k] - half);
      upper[k] = std::max(upper[k], b.position[k] + half);
    }
  }
  const double speed_cell = std::max(speed / 32767, 1e-300);
  plain_vector<std::int16_t> velocities, turns;
  plain_vector<std::uint16_t> ranks;
  plain_vector<std::uint8_t> sleep;
  const auto small = [](double x) {
    return static_cast<std::int16_t>(std::clamp(std::round(x), -32767.0, 32767.0));
  };
  for (const std::uint32_t i : order) {
    const view_body& b = all[i];
    for (int k = 0; k < 3; ++k) velocities.push_back(small(b.velocity[k] / speed_cell));
    const quat& q = b.orientation;
    if (b.shape != view_shape::sphere)
      for (const double x : {q.x(), q.y(), q.z(), q.w()}) turns.push_back(small(32767 * x));
    ranks.push_back(static_cast<std::uint16_t>(b.rank)), sleep.push_back(b.asleep);
  }
  to.put("velocity", velocities);
  if (!turns.empty()) to.put("orientation", turns);
  if (parts.size() > 1) to.put("rank", ranks);
  if (asleep) to.put("asleep", sleep);

  // Contacts and joints name bodies by their place in the frame; parts of a union by the first.
  const auto find = [&](system_id id) -> const view_body* {
    view_body key;
    key.id = id;
    const auto at = std::lower_bound(all.begin(), all.end(), key, comes_before);
    return at != all.end() && at->id == id ? at : nullptr;
  };
  const auto place = [&](system_id id) {
    const view_body* const b = find(id);
    return b != nullptr ? place_of[static_cast<std::size_t>(b - all.begin())]
                        : ~std::uint32_t{0};
  };
  plain_vector<view_contact> contacts;
  plain_vector<view_joint> joints;
  for (const view_part& p : parts) {
    for (const view_contact& c : p.contacts)
      if (finite(c.point) && finite(c.force)) contacts.push_back(c);
    for (const view_joint& j : p.joints) joints.push_back(j);
  }
  std::sort(contacts.begin(), contacts.end(), [](const view_contact& x, const view_contact& y) {
    const double f = x.force.squaredNorm(), g = y.force.squaredNorm();
    if (f != g) return f > g;
    if (x.a != y.a) return value_of(x.a) < value_of(y.a);
    return x.b != y.b ? value_of(x.b) < value_of(y.b) : x.feature < y.feature;
  });
  out.head.add("contacts_of", static_cast<double>(contacts.size()));
  if (!contacts.empty()) {
    double sum = 0;
    for (const view_contact& c : contacts) sum += c.force.norm();
    const double force_cell = std::max(contacts[0].force.norm() / 65535, 1e-300);
    out.head.add("force_mean", sum / static_cast<double>(contacts.size()));
    out.head.add("force_cell", force_cell);
    if (contacts.size() > most_contacts) contacts.resize(most_contacts);
    plain_vector<std::uint32_t> a, b;
    plain_vector<std::uint16_t> sizes;
    for (const view_contact& c : contacts) {
      a.push_back(place(c.a)), b.push_back(place(c.b));
      sizes.push_back(cells_of(c.force.norm() / force_cell));
    }
    to.put("contact_a", a), to.put("contact_b", b), to.put("contact_force", sizes);
    grid.put("contact_point", to, [&](auto&& put) {
      for (const view_contact& c : contacts) put(c.point);
    });
  }
  // Both ranks of a joint report it.
  const auto joint_before = [](const view_joint& x, const view_joint& y) {
    if (x.a != y.a) return value_of(x.a) < value_of(y.a);
    return x.b != y.b ? value_of(x.b) < value_of(y.b) : x.number < y.number;
  };
  std::sort(joints.begin(), joints.end(), joint_before);
  std::size_t kept = 0;
  for (const view_joint& j : joints)
    if (kept == 0 || joint_before(joints[kept - 1], j)) joints[kept++] = j;
  joints.resize(kept);
  if (!joints.empty()) {
    plain_vector<std::uint32_t> a, b;
    for (const view_joint& j : joints) a.push_back(place(j.a)), b.push_back(place(j.b));
    to.put("joint_a", a), to.put("joint_b", b);
    const auto put_ends = [&](const char* name, bool first) {
      grid.put(name, to, [&](auto&& put) {
        for (const view_joint& j : joints) {
          const view_body *x = find(j.a), *y = find(j.b);
          if (!first) std::swap(x, y);
          vec3 on = first ? j.on_a : j.on_b;
          if (x == nullptr && y != nullptr) x = y, on = first ? j.on_b : j.on_a;
          put(x != nullptr ? vec3(x->position + rotated(x->orientation, on)) : vec3(0, 0, 0));
        }
      });
    };
    put_ends("joint_point", true), put_ends("joint_other", false);
  }

  out.head.add("bodies", static_cast<double>(movable));
  out.head.add("ranks", static_cast<double>(parts.size()));
  out.head.add_raw("lower", view_json::vector(grid.lower()));
  out.head.add_raw("cell", view_json::vector(grid.cell()));
  out.head.add("position_error", grid.error());
  if (movable > 0) {
    std::string box = view_json::vector(lower) + "," + view_json::vector(upper);
    std::erase_if(box, [](char c) { return c == '[' || c == ']'; });
    out.head.add_raw("box", "[" + box + "]");
  }
  out.head.add("speed_cell", speed_cell);
  out.head.add("speed_max", fastest);
  out.head.add_raw("seconds", "[" + seconds + "]");
  if (domains != domains_) out.head.add_raw("domains", "[" + domains + "]"), domains_ = domains;
  if (!out.warning.empty())
    out.head.add_raw("notes", "[" + view_json::quoted(out.warning) + "]");
  out.head.add_raw("blocks", to.where());
  return out;
}

}  // namespace talus::detail
