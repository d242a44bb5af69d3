#pragma once
// The joints that a rank holds: those of the bodies it owns. They migrate with their bodies.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <type_traits>
#include <vector>

#include "talus/body/jointed_body.hpp"
#include "talus/constraint/joint_line.hpp"
#include "talus/constraint/line_writer.hpp"
#include "talus/core/each.hpp"
#include "talus/core/id.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/sort.hpp"
#include "talus/core/type_list.hpp"

namespace talus::detail {

/// The identity of a joint, on every rank: its bodies in the order in which they were joined, and
/// the number of the call that joined them. The order of joints in lists.
struct joint_key {
  system_id a = no_id, b = no_id;
  std::uint64_t number = 0;

  friend bool operator==(const joint_key&, const joint_key&) = default;
  friend bool operator<(const joint_key& x, const joint_key& y) {
    if (x.a != y.a) return value_of(x.a) < value_of(y.a);
    if (x.b != y.b) return value_of(x.b) < value_of(y.b);
    return x.number < y.number;
  }
};

/// Stands for the frame of the world among the bodies of joints.
inline constexpr system_id id_of_world{~std::uint64_t{0} - 1};

template <class Kind>
inline constexpr bool has_axes = requires {
  Kind::has_angle;
}
|| requires { Kind::has_travel; };
/// Nothing for kinds without coordinates.
struct no_drives {};
template <class Kind>
using drives_of_kind = std::conditional_t<has_axes<Kind>, axis_drives, no_drives>;

/// A joint as it migrates and is stored.
template <class Kind>
struct joint_record {
  using impulse_type = row_values<Kind::rows>;
  joint_key key;
  typename Kind::anchors anchors;
  impulse_type impulse;           ///< of the rows, in the last step
  joint_coordinates coordinates;  ///< at the start of the last step, or in its middle
  wrench load;  ///< its impulse on the first body in the last step, about the joint's point
  /// By what its coordinates were driven in the last step, if it has any.
  [[no_unique_address]] drives_of_kind<Kind> drives;
  bool acts = false;  ///< on a body owned here, which is not fixed
  /// A joint of a fixed body that acts on a body of another rank has two records: the owner of the
  /// fixed body repeats the record of the other rank (`follows`), and the other rank stores in
  /// `follower` which rank that is.
  bool follows = false;
  std::int32_t follower = -1;
};

/// The joints of one kind, in the order of their keys, and their rows in the solver.
template <class Kind, class List>
struct joints_of_kind {
  using kind = Kind;
  using record = joint_record<Kind>;
  using row = typename List::contact_type;
  plain_vector<record> records;
  List list;
  /// Joints of other ranks in islands that reach here, for the step under way, and their rows; in
  /// the order of their keys. See ghosts/shared_joints.hpp.
  plain_vector<record> far;
  plain_vector<row> far_rows;

  [[nodiscard]] record* find(const joint_key& key) {
    record* at = place(key);
    return at != records.end() && at->key == key ? at : nullptr;
  }
  /// A joint may come from several ranks. One from a rank on which it acts replaces others.
  void add(const record& r) {
    record* at = place(r.key);
    if (at == records.end() || !(at->key == r.key))
      records.insert(at, r);
    else if (r.acts)
      *at = r;
  }

 private:
  [[nodiscard]] record* place(const joint_key& key) {
    return std::lower_bound(records.begin(), records.end(), key,
                            [](const record& r, const joint_key& k) { return r.key < k; });
  }
};

/// The bodies that joints of this rank join.
struct jointed_ids {
  struct member {
    system_id id = no_id;
    real reach = 0;  ///< how far the centre of a partner may be
    friend bool operator<(const member& x, const member& y) {
      return value_of(x.id) < value_of(y.id);
    }
  };
  plain_vector<member> members;                          ///< in the order of their ids
  plain_vector<plain_pair<system_id, system_id>> pairs;  ///< the lower id first; sorted

  static constexpr std::size_t unknown = ~std::size_t{0};
  [[nodiscard]] std::size_t find(system_id id) const {
    const auto at = std::lower_bound(members.begin(), members.end(), member{id});
    return at != members.end() && at->id == id ? static_cast<std::size_t>(at - members.begin())
                                               : unknown;
  }
  [[nodiscard]] bool joined(system_id a, system_id b) const {
    if (pairs.empty()) return false;
    if (value_of(b) < value_of(a)) std::swap(a, b);
    return std::binary_search(pairs.begin(), pairs.end(), plain_pair{a, b});
  }
};

/// A body of a joint, as this rank sees it.
struct joint_end {
  bool known = false, own = false, moves = false, global = false;
  bool asleep = false;       ///< immovable until it wakes
  bool at_border = false;    ///< other ranks need its velocity
  std::int32_t number = -1;  ///< in the solver's arrays
  std::int32_t owner = -1;   ///< the rank of a copy
  vec3 position{0, 0, 0};    ///< at its owner
  quat orientation{1, 0, 0, 0};
  vec3 velocity{0, 0, 0}, spin{0, 0, 0};
  real inverse_mass = 0;
  real radius = 0;  ///< of its bounding sphere, if it moves

  /// Neither fixed nor global, awake or not.
  [[nodiscard]] bool movable() const { return inverse_mass != 0; }
  /// The lever of a joint on it, at least its size; 0 if it does not move.
  [[nodiscard]] real lever(const vec3& arm) const {
    return moves ? std::max(arm.norm(), radius) : real(0);
  }
};

/// A joint that does not hold: the worst one so far. Step 0: none.
struct joint_opening {
  std::uint64_t step = 0;
  std::uint32_t kind = 0;  ///< its place in joints<...>
  joint_key key;
  real part = 0;  ///< its gap over its arm, or the error of an angle
  real gap = 0;   ///< the largest error of a length

  /// Takes the worse one.
  void note(const joint_opening& other) {
    if (other.part > part) *this = other;
  }
};
/// Smaller openings are not noted.
inline constexpr real noted_opening = 0.01;

inline constexpr std::size_t no_wall = ~std::size_t{0};

/// What this rank and another one exchange of the islands of joints on both; bodies by their
/// numbers in joint_table::ends.
struct joint_partner {
  static constexpr std::uint32_t ignored = ~std::uint32_t{0};
  int rank = -1;
  plain_vector<std::uint32_t> sent;
  plain_vector<std::uint32_t> received;  ///< or ignored: what never moves and is known here
};

template <class Kinds, template <class> class ListOf, bool Periodic>
class joint_table;
template <class... Kinds, template <class> class ListOf, bool Periodic>
class joint_table<type_list<Kinds...>, ListOf, Periodic> {
 public:
  std::uint64_t made = 0;      ///< calls of join so far; alike on all ranks
  std::size_t wall = no_wall;  ///< what global bodies are in the solver's arrays, if joints need it
  plain_vector<joint_end> before;  ///< at the start of the step, for integrators that need it
  /// The bodies of joints in the step under way: the members of ids(), then those of far joints.
  plain_vector<joint_end> ends;
  plain_vector<plain_pair<system_id, std::uint32_t>> far;  ///< the latter, in the order of ids
  joint_opening opening;                                   ///< on this rank
  std::vector<joint_partner> partners;  ///< of islands of joints on several ranks, by rank

  template <class F>
  void each_kind(F&& f) {
    each_of(kinds_, f);
  }
  template <class F>
  void each_kind(F&& f) const {
    each_of(kinds_, f);
  }
  template <class Kind>
  [[nodiscard]] auto& of() {
    return std::get<joints_of_kind<Kind, ListOf<Kind>>>(kinds_);
  }
  [[nodiscard]] auto lists() {
    return std::tie(std::get<joints_of_kind<Kinds, ListOf<Kinds>>>(kinds_).list...);
  }
  /// To be called when records were added or removed, or reach further.
  void changed() { known_ = false; }
  /// Number of joints here.
  [[nodiscard]] std::size_t size() const {
    std::size_t n = 0;
    each_kind([&](const auto& of_kind) { n += of_kind.records.size(); });
    return n;
  }
  [[nodiscard]] const jointed_ids& ids() {
    if (!known_) list_ids();
    return ids_;
  }
  /// The place of a body in `ends`, or jointed_ids::unknown.
  [[nodiscard]] std::size_t find_end(system_id id) {
    if (const std::size_t k = ids().find(id); k != jointed_ids::unknown) return k;
    const auto at = std::lower_bound(far.begin(), far.end(), plain_pair{id, std::uint32_t{0}});
    return at != far.end() && at->first == id ? at->second : jointed_ids::unknown;
  }
  /// Whether two bodies have a joint: then they have no contacts.
  [[nodiscard]] bool joined(system_id a, system_id b) { return ids().joined(a, b); }

 private:
  void list_ids() {
    ids_.members.clear(), ids_.pairs.clear();
    each_kind([&](const auto& of_kind) {
      using kind = typename std::remove_cvref_t<decltype(of_kind)>::kind;
      for (const auto& r : of_kind.records) {
        // A body reaches its partner alone, whatever is known of the partner's reach.
        // All ranks know the frame of the world. In periodic space the body must be so near to the
        // point there that it has one nearest image.
        real way = distance_of<kind>(r.anchors, r.coordinates);
        if (r.key.a == id_of_world) way = Periodic ? way - r.anchors.frames.on_a.norm() : 0;
        const real reach = slack * way;
        ids_.members.push_back({r.key.a, reach}), ids_.members.push_back({r.key.b, reach});
        const bool in_order = value_of(r.key.a) < value_of(r.key.b);
        ids_.pairs.push_back({in_order ? r.key.a : r.key.b, in_order ? r.key.b : r.key.a});
      }
    });
    auto& all = ids_.members;
    std::sort(all.begin(), all.end());
    std::size_t kept = 0;
    for (const auto& m : all)
      if (kept > 0 && all[kept - 1].id == m.id)
        all[kept - 1].reach = std::max(all[kept - 1].reach, m.reach);
      else
        all[kept++] = m;
    all.resize(kept);
    sort_values(ids_.pairs);
    known_ = true;
  }
  /// A factor on the distance of two jointed bodies that allows for the position error.
  static constexpr real slack = 1.25;

  std::tuple<joints_of_kind<Kinds, ListOf<Kinds>>...> kinds_;
  jointed_ids ids_;
  bool known_ = false;
};

}  // namespace talus::detail
