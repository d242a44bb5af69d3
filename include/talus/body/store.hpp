#pragma once
// Storage of the bodies of one shape: structure of arrays, locals before shadow copies. Columns
// that the scenario does not need do not exist.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>
#include <vector>

#include "talus/body/column.hpp"
#include "talus/body/columns.hpp"
#include "talus/body/features.hpp"
#include "talus/core/bytes.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// Each column of a list as a member.
template <class Columns>
struct column_storage;
template <class... Columns>
struct column_storage<type_list<Columns...>> : column_member<Columns>::storage... {};

/// Inverse masses that fixed bodies have when they are released, of those with a mass other than
/// density times volume: few or none.
class kept_masses {
 public:
  void keep(system_id id, real inverse) {
    const auto at = place_of(id);
    if (at != all_.end() && at->id == id)
      all_[static_cast<std::size_t>(at - all_.begin())].inverse = inverse;
    else
      all_.insert(at, {id, inverse});
  }
  void forget(system_id id) {
    const auto at = place_of(id);
    if (at != all_.end() && at->id == id) all_.erase(at);
  }
  /// 0 if there is none.
  [[nodiscard]] real inverse_of(system_id id) const {
    const auto at = place_of(id);
    return at != all_.end() && at->id == id ? at->inverse : 0;
  }
  [[nodiscard]] bool empty() const { return all_.empty(); }

 private:
  struct entry {
    system_id id;
    real inverse;
  };
  /// The place of the first entry that is not before `id`.
  [[nodiscard]] std::vector<entry>::const_iterator place_of(system_id id) const {
    return std::lower_bound(all_.begin(), all_.end(), id,
                            [](const entry& e, system_id x) { return e.id < x; });
  }

  std::vector<entry> all_;  ///< sorted by id
};

/// All columns of the bodies of a shape.
template <class Shape, class Features>
struct columns_of_bodies;
template <class Shape, class... Features>
struct columns_of_bodies<Shape, type_list<Features...>> {
  using added = sorted_columns<join_lists<typename columns_of_feature<Features>::type...>>;
  using type = join_lists<columns_of_shape<Shape>, typename columns_carried_by<added, Shape>::type>;
};

template <class Shape, class Features>
struct body_store : column_storage<typename columns_of_bodies<Shape, Features>::type> {
  using shape_type = Shape;
  using list = typename columns_of_bodies<Shape, Features>::type;  ///< of columns
  template <class Column>
  static constexpr bool has = contains_type<list, Column>;

  static constexpr bool oriented = has<columns::orientation>;
  static constexpr bool tensor =
      Shape::finite && !Shape::isotropic;  ///< inertia is not a multiple of 1
  static constexpr bool forced = has<columns::force>;
  static constexpr bool keeps_contact_forces = has<columns::contact_force>;
  static constexpr bool sleeps = has<columns::quiet>;
  static constexpr bool numbered = has<columns::user_id>;

  std::size_t locals = 0;  ///< bodies [0, locals) are owned here, the rest are shadow copies
  kept_masses kept;        ///< of bodies with flag_own_mass

  [[nodiscard]] std::size_t size() const { return this->id.size(); }

  /// The values of a column, by its type.
  template <class Column>
  [[nodiscard]] auto& column() {
    return this->*column_member<Column>::member;
  }
  template <class Column>
  [[nodiscard]] const auto& column() const {
    return this->*column_member<Column>::member;
  }

  /// Calls f(values) for the columns of a list: by default for all.
  template <class Columns = list, class F>
  void each_column(F&& f) {
    [&]<class... C>(type_list<C...>) { (f(this->template column<C>()), ...); }(Columns{});
  }
  template <class Columns = list, class F>
  void each_column(F&& f) const {
    [&]<class... C>(type_list<C...>) { (f(this->template column<C>()), ...); }(Columns{});
  }
  /// Calls f(values, initial value) for the columns of a list.
  template <class Columns = list, class F>
  void each_initial(F&& f) {
    [&]<class... C>(type_list<C...>) {
      (f(this->template column<C>(), initial_of<C>()), ...);
    }(Columns{});
  }
  /// Calls f(values, the same column of `other`).
  template <class F>
  void each_column_with(const body_store& other, F&& f) {
    [&]<class... C>(type_list<C...>) {
      (f(this->template column<C>(), other.template column<C>()), ...);
    }(list{});
  }

  [[nodiscard]] talus::pose pose(std::size_t i) const {
    if constexpr (oriented)
      return {this->position[i], this->orientation_of[i]};
    else
      return {this->position[i], quat{1, 0, 0, 0}};
  }
  [[nodiscard]] bool fixed(std::size_t i) const { return this->flags[i] & flag_fixed; }
  [[nodiscard]] bool keeps_mass(std::size_t i) const { return this->flags[i] & flag_own_mass; }
  /// Gives a fixed body the inverse mass that it has when it is released.
  void keep_mass(std::size_t i, real inverse) {
    this->flags[i] |= flag_own_mass;
    kept.keep(this->id[i], inverse);
  }
  void forget_mass(std::size_t i) {
    if (!keeps_mass(i)) return;
    this->flags[i] &= static_cast<std::uint8_t>(~flag_own_mass);
    kept.forget(this->id[i]);
  }
  [[nodiscard]] bool asleep(std::size_t i) const {
    if constexpr (sleeps)
      return this->flags[i] & flag_asleep;
    else
      return (void)i, false;
  }
  /// Whether forces and contacts can move it in this step.
  [[nodiscard]] bool moves(std::size_t i) const { return this->inverse_mass[i] != 0 && !asleep(i); }

  /// Bytes that one body takes in the columns.
  [[nodiscard]] static constexpr std::size_t bytes_per_body() {
    return
        []<class... C>(type_list<C...>) { return (sizeof(typename C::value_type) + ...); }(list{});
  }

  void resize(std::size_t n) {
    each_column([&](auto& c) { c.resize(n); });
  }
  void drop_shadows() {
    resize(locals);
    if (kept.empty()) return;
    // A shadow copy may be an image of a local, so the masses of locals are kept.
    kept_masses of_locals;
    for (std::size_t i = 0; i < locals; ++i)
      if (keeps_mass(i)) of_locals.keep(this->id[i], kept.inverse_of(this->id[i]));
    kept = std::move(of_locals);
  }
  /// Removes the shadow copies.
  [[nodiscard]] body_store take_shadows() {
    body_store taken;
    for (std::size_t i = locals; i < size(); ++i) taken.append_from(*this, i);
    drop_shadows();
    return taken;
  }

  /// Makes room for one more local, after the others, and returns its index. The shadow copies
  /// keep their order.
  std::size_t insert_local() {
    resize(size() + 1);
    each_initial([&](auto& c, const auto& initial) {
      for (std::size_t i = c.size() - 1; i > locals; --i) c[i] = c[i - 1];
      c[locals] = initial;
    });
    return locals++;
  }
  /// Appends a body with the defaults of all columns, and returns its index.
  std::size_t append() {
    each_initial([&](auto& c, const auto& initial) { c.push_back(initial); });
    return size() - 1;
  }
  /// Removes local `i`: the last local takes its place. The shadow copies keep their order.
  void remove_local(std::size_t i) {
    forget_mass(i);
    each_column([&](auto& c) {
      c[i] = c[locals - 1];
      c.erase(c.begin() + static_cast<std::ptrdiff_t>(locals - 1));
    });
    --locals;
  }
  /// Local k becomes the former local order[k].
  void permute_locals(const plain_vector<std::uint32_t>& order) {
    each_column([&](auto& c) {
      const auto before = c;
      for (std::size_t k = 0; k < order.size(); ++k) c[k] = before[order[k]];
    });
  }
  /// Appends body `i` of another store.
  void append_from(const body_store& other, std::size_t i) {
    each_column_with(other, [&](auto& c, const auto& from) { c.push_back(from[i]); });
    if (other.keeps_mass(i)) kept.keep(other.id[i], other.kept.inverse_of(other.id[i]));
  }

  /// Appends bodies [first, last) of another store.
  void append_from(const body_store& other, std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) append_from(other, i);
  }

  /// The data that migrate to a new owner.
  void pack(std::size_t i, byte_writer& out) const { pack_columns<travels::on_migration>(i, out); }
  /// Appends the next body of a message.
  void unpack(byte_reader& in) { append_columns<travels::on_migration>(in); }
  /// The data of a new shadow copy.
  void pack_copy(std::size_t i, byte_writer& out) const { pack_columns<of_copies>(i, out); }
  void unpack_copy(byte_reader& in) { append_columns<of_copies>(in); }
  /// The data that a step changes, for a receiver that has a shadow copy of the body.
  void pack_motion(std::size_t i, byte_writer& out) const {
    pack_columns<travels::with_every_refresh>(i, out);
  }
  void unpack_motion(std::size_t i, byte_reader& in) {
    each_column<sent<travels::with_every_refresh>>(
        [&](auto& c) { c[i] = in.get<typename std::remove_cvref_t<decltype(c)>::value_type>(); });
  }

 private:
  template <travels Least>
  using sent = typename columns_that_travel<list, Least>::sent;
  template <travels Least>
  using rest = typename columns_that_travel<list, Least>::rest;
  /// If they are identical, copies are sent like migrated bodies.
  static constexpr travels of_copies =
      sent<travels::when_changed>::size == sent<travels::on_migration>::size
          ? travels::on_migration
          : travels::when_changed;

  template <travels Least>
  void pack_columns(std::size_t i, byte_writer& out) const {
    each_column<sent<Least>>([&](const auto& c) { out.put(c[i]); });
    if constexpr (Least != travels::with_every_refresh)
      if (keeps_mass(i)) out.put(kept.inverse_of(this->id[i]));
  }
  template <travels Least>
  void append_columns(byte_reader& in) {
    each_column<sent<Least>>([&](auto& c) {
      c.push_back(in.get<typename std::remove_cvref_t<decltype(c)>::value_type>());
    });
    each_initial<rest<Least>>([&](auto& c, const auto& initial) { c.push_back(initial); });
    if (keeps_mass(size() - 1)) kept.keep(this->id.back(), in.get<real>());
  }
};

}  // namespace talus::detail
