#pragma once
// From bodies and contacts to the tables of a checkpoint, and back.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "talus/body/store.hpp"
#include "talus/core/bytes.hpp"
#include "talus/core/shared_data.hpp"
#include "talus/io/detail/checkpoint_table.hpp"
#include "talus/world/fresh_start.hpp"

namespace talus::detail {

/// How a value is stored: what is made of reals as reals, else as its bytes.
template <class T>
[[nodiscard]] table_column column_of(const char* name) {
  if constexpr (std::is_same_v<T, std::uint64_t> || std::is_same_v<T, system_id>)
    return {name, number_type::u64, 1};
  else if constexpr (std::is_same_v<T, std::uint32_t>)
    return {name, number_type::u32, 1};
  else if constexpr (std::is_same_v<T, material_id>)
    return {name, number_type::u16, 1};
  else if constexpr (std::is_same_v<T, std::uint8_t>)
    return {name, number_type::u8, 1};
  else if constexpr (std::is_same_v<T, float>)
    return {name, number_type::f32, 1};
  else if constexpr (packs_itself<T>)
    return {name, number_type::u64, 2};  // first byte and number of bytes in `extra`
  else if constexpr (sizeof(T) % 8 == 0)
    return {name, number_type::f64, sizeof(T) / 8};
  else
    return {name, number_type::u8, sizeof(T)};
}

template <class Store>
[[nodiscard]] std::vector<table_column> columns_of() {
  std::vector<const char*> names;
  Store::each_column_name([&](const char* name) { names.push_back(name); });
  std::vector<table_column> columns;
  Store().each_column([&](const auto& c) {
    using value = typename std::remove_cvref_t<decltype(c)>::value_type;
    columns.push_back(column_of<value>(names.at(columns.size())));
  });
  return columns;
}

/// Tables of the shapes of a scenario: bodies/sphere, and bodies/union_of_2 for a second shape of
/// that name.
template <class Store, class Shapes>
[[nodiscard]] std::string table_of_shape(const char* group) {
  int same = 1;
  for_each_type<Shapes>([&](auto type) {
    using other = typename decltype(type)::type;
    constexpr bool before = index_of<Shapes, other> < index_of<Shapes, typename Store::shape_type>;
    if (before && std::string(other::name) == Store::shape_type::name) ++same;
  });
  std::string path = std::string("/") + group + "/" + Store::shape_type::name;
  if (same > 1) path += "_" + std::to_string(same);
  return path;
}

/// The first `n` bodies of a store; the store must not change while the table is in use.
template <class Store>
[[nodiscard]] table_part part_of(const Store& store, std::size_t n, std::string path) {
  table_part t;
  t.path = std::move(path);
  t.rows = n;
  t.columns = columns_of<Store>();
  t.extras = packs_itself<typename Store::shape_type>;
  cut_into_pieces(t);
  std::size_t k = 0;
  store.each_column([&](const auto& c) {
    using value = typename std::remove_cvref_t<decltype(c)>::value_type;
    if constexpr (packs_itself<value>) {
      byte_buffer references;
      byte_writer out(references);
      for (table_piece& p : t.pieces) {
        std::map<content_id, std::array<std::uint64_t, 2>> known;  // each form once in a piece
        p.extra_first = t.extra.size();
        for (std::size_t i = p.first; i < p.first + p.rows; ++i) {
          byte_buffer form;
          byte_writer form_out(form);
          c[i].pack(form_out);
          const auto [at, isnew] = known.try_emplace(
              id_of_content(form), std::array{t.extra.size() - p.extra_first, form.size()});
          if (isnew) t.extra.insert(t.extra.end(), form.begin(), form.end());
          out.put(at->second);
        }
        p.extra_bytes = t.extra.size() - p.extra_first;
      }
      t.memory.push_back(std::move(references));
      t.columns[k++].rows = t.memory.back().data();
    } else {
      t.columns[k++].rows = reinterpret_cast<const std::byte*>(c.data());
    }
  });
  for (table_piece& p : t.pieces)
    for (std::size_t i = p.first; i < p.first + p.rows; ++i) enlarge(p.box, store.position[i]);
  sum_up_pieces(t);
  return t;
}

/// A form in the extras of a piece.
template <class Shape>
class form_reader {
 public:
  [[nodiscard]] Shape get(std::array<std::uint64_t, 2> at, std::span<const std::byte> extra,
                          shared_memory& memory) {
    if (at[0] > extra.size() || at[1] > extra.size() - at[0])
      throw std::runtime_error("is damaged: a body has the form of none");
    const auto known = known_.find(at);
    if (known != known_.end()) return known->second;
    byte_reader in(extra.subspan(at[0], at[1]), &memory);
    return known_.emplace(at, Shape::unpack(in)).first->second;
  }
  void next_piece() { known_.clear(); }

 private:
  std::map<std::array<std::uint64_t, 2>, Shape> known_;
};

/// Throws runtime_error for a body that makes no sense: the bytes are as they were written, but
/// whoever wrote them may have been no talus.
template <class Store>
void require_sane(const Store& s, std::size_t i, std::size_t materials) {
  bool sane = finite(s.velocity[i]) && finite(s.angular_velocity[i]) &&
              std::isfinite(s.inverse_mass[i]) && s.inverse_mass[i] >= 0 &&
              static_cast<std::size_t>(s.material[i]) < materials;
  if constexpr (Store::shape_type::finite) sane = sane && finite(s.position[i]);
  if constexpr (Store::oriented)
    sane = sane && std::abs(s.orientation_of[i].squaredNorm() - 1) < 1e-6;
  if (!sane) fail<std::runtime_error>("is damaged: body {} makes no sense", s.id[i]);
  s.shape[i].validate();
}

/// Rows that have to be read for what lies within a box: room for them is asked for at once, of
/// which memory is taken as far as it is used.
[[nodiscard, gnu::cold]] inline std::uint64_t rows_within(const table_reader& table,
                                                          const std::pair<vec3, vec3>& bounds) {
  std::uint64_t rows = 0;
  for (const table_piece& p : table.pieces())
    if (overlap(p.box, bounds.first, bounds.second)) rows += p.rows;
  return rows;
}

/// Appends the bodies for which takes(position) to the locals of a store that has no shadow copies.
/// Pieces outside of a box are not read.
template <class Store, class Takes>
void read_bodies(table_reader& table, Store& store, const std::pair<vec3, vec3>& bounds,
                 std::size_t materials, Takes&& takes) {
  using shape = typename Store::shape_type;
  constexpr std::size_t column_of_position = 1;
  shared_memory memory;
  [[maybe_unused]] std::conditional_t<packs_itself<shape>, form_reader<shape>, no_column> forms;
  plain_vector<std::uint32_t> kept;
  const std::size_t room = store.size() + rows_within(table, bounds);
  store.each_column([&](auto& c) { c.reserve(room); });
  for (const table_piece& p : table.pieces()) {
    if (!overlap(p.box, bounds.first, bounds.second)) continue;
    table.read(p);
    kept.clear();
    for (std::uint64_t i = 0; i < p.rows; ++i)
      if (takes(table.get<vec3>(column_of_position, i)))
        kept.push_back(static_cast<std::uint32_t>(i));
    if constexpr (packs_itself<shape>) {
      forms.next_piece();
      memory.next_exchange();
    }
    const std::size_t first = store.size();
    std::size_t k = 0;
    store.each_column([&](auto& c) {
      using value = typename std::remove_cvref_t<decltype(c)>::value_type;
      for (const std::uint32_t i : kept) {
        if constexpr (packs_itself<value>)
          c.push_back(
              forms.get(table.get<std::array<std::uint64_t, 2>>(k, i), table.extra(), memory));
        else
          c.push_back(table.get<value>(k, i));
      }
      ++k;
    });
    store.locals = store.size();
    for (std::size_t i = first; i < store.size(); ++i) require_sane(store, i, materials);
  }
}

/// Calls f(name, part) for the parts of what a contact remembers.
template <class Memory, class F>
void each_part_of_memory(Memory& m, F&& f) {
  if constexpr (requires { m.squaredNorm(); }) {
    f("impulse", m);
  } else {
    if constexpr (requires { m.spring; }) f("spring", m.spring), f("sliding", m.sliding);
    if constexpr (requires { m.contact_radius; }) f("contact_radius", m.contact_radius);
    if constexpr (requires { m.turn; }) f("rolling", m.turn);
  }
}
template <class Part>
using stored_part = std::conditional_t<std::is_same_v<std::remove_cvref_t<Part>, bool>,
                                       std::uint8_t, std::remove_cvref_t<Part>>;

/// Ids of both bodies, the point of their manifold, whether the owner of the first (0) or of the
/// second (1) wrote it, and what it remembers.
template <class Memory>
[[nodiscard]] std::vector<table_column> columns_of_contacts() {
  std::vector<table_column> columns{column_of<system_id>("a"), column_of<system_id>("b"),
                                    column_of<std::uint64_t>("feature"),
                                    column_of<std::uint8_t>("side")};
  Memory m{};
  each_part_of_memory(m, [&](const char* name, auto& part) {
    columns.push_back(column_of<stored_part<decltype(part)>>(name));
  });
  return columns;
}

/// Where the bodies are that a rank knows, those it owns first.
struct known_places {
  id_table ids;
  plain_vector<vec3> position;
  std::size_t own = 0;
};
template <class Scenario>
[[nodiscard]] known_places places_of_known(const world_state<Scenario>& s) {
  known_places known;
  std::size_t all = 0;
  s.each_finite_shape([&](const auto& b) { all += b.movable.size(); });
  known.ids.reset(all);
  known.position.reserve(all);
  const auto add = [&](const auto& store, std::size_t i) {
    known.ids.add(store.id[i]);
    known.position.push_back(store.position[i]);
  };
  s.each_finite_shape([&](const auto& b) {
    for (std::size_t i = 0; i < b.movable.locals; ++i) add(b.movable, i);
    known.own += b.movable.locals;
  });
  s.each_finite_shape([&](const auto& b) {
    for (std::size_t i = b.movable.locals; i < b.movable.size(); ++i) add(b.movable, i);
  });
  return known;
}

/// What contacts of bodies owned here remember.
template <class History>
[[nodiscard]] table_part part_of_contacts(const History& history, const known_places& known,
                                          std::string path) {
  using entry = typename History::entry;
  using memory = decltype(entry::memory);
  table_part t;
  t.path = std::move(path);
  t.columns = columns_of_contacts<memory>();
  t.memory.resize(t.columns.size());
  plain_vector<std::array<std::uint32_t, 2>> bodies;
  bodies.reserve(history.entries().size());
  for (std::size_t k = 0; k < t.columns.size(); ++k)
    t.memory[k].resize(history.entries().size() * t.columns[k].row_bytes());
  system_id last = no_id;
  std::uint32_t a = id_table::unknown;
  for (const entry& c : history.entries()) {
    if (c.key.a != last) a = known.ids.find(last = c.key.a);  // they come body by body
    const std::uint32_t b = known.ids.find(c.key.b);
    if (a >= known.own && b >= known.own) continue;
    const std::uint8_t side = a >= known.own;
    std::size_t k = 0;
    const auto put = [&](const auto& value) {
      std::memcpy(t.memory[k++].data() + bodies.size() * sizeof value, &value, sizeof value);
    };
    put(c.key.a), put(c.key.b), put(c.key.feature), put(side);
    each_part_of_memory(c.memory, [&](const char*, const auto& part) {
      put(static_cast<stored_part<decltype(part)>>(part));
    });
    bodies.push_back({a, b});
  }
  t.rows = bodies.size();
  cut_into_pieces(t);
  for (std::size_t k = 0; k < t.columns.size(); ++k) t.columns[k].rows = t.memory[k].data();
  for (table_piece& p : t.pieces)
    for (std::size_t i = p.first; i < p.first + p.rows; ++i)
      for (const std::uint32_t body : bodies[i])
        if (body != id_table::unknown) enlarge(p.box, known.position[body]);
  sum_up_pieces(t);
  return t;
}

/// What contacts of the bodies `own` remember. Where both owners of a contact wrote it, each takes
/// what its own predecessor wrote.
template <class History>
[[nodiscard]] History read_contacts(table_reader& table, const id_table& own,
                                    const std::pair<vec3, vec3>& bounds) {
  using entry = typename History::entry;
  History first, second;
  first.reset(rows_within(table, bounds));
  for (const table_piece& p : table.pieces()) {
    if (!overlap(p.box, bounds.first, bounds.second)) continue;
    table.read(p);
    for (std::uint64_t i = 0; i < p.rows; ++i) {
      entry c;
      c.key = {table.get<system_id>(0, i), table.get<system_id>(1, i),
               table.get<std::uint64_t>(2, i)};
      const bool own_a = own.has(c.key.a);
      if (!own_a && !own.has(c.key.b)) continue;
      std::size_t k = 4;
      each_part_of_memory(c.memory, [&](const char*, auto& part) {
        part = static_cast<std::remove_cvref_t<decltype(part)>>(
            table.get<stored_part<decltype(part)>>(k++, i));
      });
      const bool by_owner_of_a = table.get<std::uint8_t>(3, i) == 0;
      (by_owner_of_a == own_a ? first : second).add(c.key, c.memory);
    }
  }
  plain_vector<entry> others;
  for (const entry& c : second.entries()) {
    bool told = false;
    first.each_of_pair(c.key, [&](const entry&) { told = true; });
    if (!told) others.push_back(c);
  }
  for (const entry& c : others) first.add(c.key, c.memory);
  return first;
}

}  // namespace talus::detail
