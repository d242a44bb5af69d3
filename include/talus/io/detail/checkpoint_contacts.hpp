#pragma once
// Conversion of the memory of contacts to the tables of a checkpoint, and back.
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "talus/contact/key.hpp"
#include "talus/io/detail/checkpoint_bodies.hpp"
#include "talus/io/detail/checkpoint_table.hpp"
#include "talus/world/fresh_start.hpp"

namespace talus::detail {

/// Calls f(name, part) for the parts of a contact's memory.
template <class Memory, class F>
void each_part_of_memory(Memory& m, F&& f) {
  if constexpr (requires { m.squaredNorm(); }) {
    f("impulse", m);
  } else {
    Memory::each_column(m, f);
  }
}
template <class Part>
using stored_part = std::conditional_t<std::is_same_v<std::remove_cvref_t<Part>, bool>,
                                       std::uint8_t, std::remove_cvref_t<Part>>;

/// Ids of both bodies, the point of their manifold, whether the owner of the first (0) or of the
/// second (1) wrote it, and its memory.
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

/// The index of the bodies known to a rank, those it owns first.
struct known_places {
  id_table ids;
  plain_vector<vec3> position;
  std::size_t own = 0;
};
template <class Scenario>
[[nodiscard]] known_places places_of_known(const held_bodies<Scenario>& s) {
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

/// The memory of contacts of bodies owned here.
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
    if (c.key.a != last) a = known.ids.find(last = c.key.a);  // they are sorted by body
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

/// The memory of contacts of the bodies `own`. If both owners of a contact wrote it, each reads the
/// entry of its own predecessor.
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
        const auto stored = table.get<stored_part<decltype(part)>>(k++, i);
        if (!all_finite(stored))
          fail<std::runtime_error>(
              "is damaged: what the contact of bodies {} and {} remembers makes no sense", c.key.a,
              c.key.b);
        part = static_cast<std::remove_cvref_t<decltype(part)>>(stored);
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
