#pragma once
// Conversion of bodies to the tables of a checkpoint, and back.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "talus/body/store.hpp"
#include "talus/core/bytes.hpp"
#include "talus/core/shared_data.hpp"
#include "talus/io/detail/checkpoint_table.hpp"
#include "talus/world/fresh_start.hpp"

namespace talus::detail {

/// The stored form of a value: as reals if it consists of reals, else as its bytes.
template <class T>
[[nodiscard]] table_column column_of(const char* name) {
  if constexpr (requires { typename T::stored_as_bytes; })
    return {name, number_type::u8, sizeof(T)};
  else if constexpr (std::is_same_v<T, std::uint64_t> || std::is_same_v<T, system_id>)
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

/// The columns of a store in checkpoints, and those left out.
template <class Store>
using saved_columns = typename columns_by_use<typename Store::list>::saved;
template <class Store>
using unsaved_columns = typename columns_by_use<typename Store::list>::unsaved;

template <class... Columns>
[[nodiscard]] std::vector<table_column> table_columns(type_list<Columns...>) {
  return {column_of<typename Columns::value_type>(Columns::name)...};
}
template <class Store>
[[nodiscard]] std::vector<table_column> columns_of() {
  return table_columns(saved_columns<Store>{});
}

/// The path of the table of the shape at `number` of these names.
[[nodiscard, gnu::cold]] std::string path_of_table(const char* group,
                                                   std::span<const std::string_view> names,
                                                   std::size_t number);
/// Tables of the shapes of a scenario: bodies/sphere, and bodies/union_of_2 for a second shape of
/// that name.
template <class Store, class Shapes>
[[nodiscard]] std::string table_of_shape(const char* group) {
  return []<class... Each>(const char* all, type_list<Each...>) {
    const std::array<std::string_view, sizeof...(Each)> names{Each::name...};
    return path_of_table(all, names, index_of<Shapes, typename Store::shape_type>);
  }(group, Shapes{});
}

/// The inverse masses of the first `n` bodies. Those that fixed bodies have when they are released
/// are negative.
template <class Store>
[[nodiscard]] const std::byte* inverse_masses_of(const Store& store, std::size_t n, table_part& t) {
  bool kept = false;
  for (std::size_t i = 0; i < n; ++i) kept = kept || store.keeps_mass(i);
  if (!kept) return reinterpret_cast<const std::byte*>(store.inverse_mass.data());
  byte_buffer values;
  byte_writer out(values);
  for (std::size_t i = 0; i < n; ++i)
    out.put(store.keeps_mass(i) ? -store.kept.inverse_of(store.id[i]) : store.inverse_mass[i]);
  t.memory.push_back(std::move(values));
  return t.memory.back().data();
}
/// The inverse of it, for a body that was read.
template <class Store>
void read_kept_mass(Store& store, std::size_t i) {
  if (!store.keeps_mass(i)) return;
  const real inverse = -store.inverse_mass[i];
  if (!(inverse > 0) || !std::isfinite(inverse) || !store.fixed(i))
    fail<std::runtime_error>("is damaged: fixed body {} has no mass", store.id[i]);
  store.inverse_mass[i] = 0;
  store.keep_mass(i, inverse);
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
  store.template each_column<saved_columns<Store>>([&](const auto& c) {
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
    } else if (static_cast<const void*>(&c) == &store.inverse_mass) {
      t.columns[k++].rows = inverse_masses_of(store, n, t);
    } else {
      t.columns[k++].rows = reinterpret_cast<const std::byte*>(c.data());
    }
  });
  for (table_piece& p : t.pieces)
    for (std::size_t i = p.first; i < p.first + p.rows; ++i) enlarge(p.box, store.position[i]);
  sum_up_pieces(t);
  return t;
}

/// The forms in the extras of a table: bodies of one form share one entry.
template <class Shape>
class form_reader {
 public:
  [[nodiscard]] Shape get(std::array<std::uint64_t, 2> at, std::span<const std::byte> extra) {
    if (at[0] > extra.size() || at[1] > extra.size() - at[0])
      throw std::runtime_error("is damaged: a body has the form of none");
    const auto bytes = extra.subspan(at[0], at[1]);
    const content_id id = id_of_content(bytes);
    const auto known = known_.find(id);
    if (known != known_.end()) return known->second;
    byte_reader in(bytes);
    return known_.emplace(id, Shape::unpack(in)).first->second;
  }

 private:
  std::map<content_id, Shape> known_;
};

/// Whether all numbers of a value that is stored as reals are finite.
template <class T>
[[nodiscard]] bool all_finite(const T& value) {
  if constexpr (std::is_same_v<T, float>) {
    return std::isfinite(value);
  } else if constexpr (!packs_itself<T>) {
    const table_column c = column_of<T>("");
    if (c.type != number_type::f64) return true;
    const auto* at = reinterpret_cast<const std::byte*>(&value);
    for (std::uint32_t k = 0; k < c.width; ++k, at += sizeof(double)) {
      double x;
      std::memcpy(&x, at, sizeof x);
      if (!std::isfinite(x)) return false;
    }
  }
  return true;
}

/// Throws runtime_error for a body with values out of range: the checksum holds, but another
/// program may have written the bytes.
template <class Store>
void require_sane(const Store& s, std::size_t i, std::size_t materials) {
  constexpr std::uint8_t all_flags =
      flag_fixed | flag_invisible | flag_asleep | flag_disturbed | flag_released | flag_own_mass;
  bool sane = s.id[i] != no_id && s.inverse_mass[i] >= 0 && (s.flags[i] & ~all_flags) == 0 &&
              static_cast<std::size_t>(s.material[i]) < materials;
  s.template each_column<named_columns<typename Store::list>>([&](const auto& c) {
    using value = typename std::remove_cvref_t<decltype(c)>::value_type;
    if constexpr (!std::is_same_v<value, typename Store::shape_type>)
      sane = sane && all_finite(c[i]);
  });
  if constexpr (Store::oriented)
    sane = sane && std::abs(s.orientation_of[i].squaredNorm() - 1) < 1e-6;
  if (!sane) fail<std::runtime_error>("is damaged: body {} makes no sense", s.id[i]);
  s.shape[i].validate();
}

/// Rows that must be read for the bodies within a box: room for them is reserved at once, and
/// memory is used only as needed.
[[nodiscard, gnu::cold]] std::uint64_t rows_within(const table_reader& table,
                                                   const std::pair<vec3, vec3>& bounds);

struct no_forms {};

/// Appends the bodies for which takes(position) to the locals of a store that has no shadow copies.
/// Pieces outside of a box are not read.
template <class Store, class Takes>
void read_bodies(table_reader& table, Store& store, const std::pair<vec3, vec3>& bounds,
                 std::size_t materials, Takes&& takes) {
  using shape = typename Store::shape_type;
  constexpr std::size_t column_of_position = 1;
  [[maybe_unused]] std::conditional_t<packs_itself<shape>, form_reader<shape>, no_forms> forms;
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
    const std::size_t first = store.size();
    std::size_t k = 0;
    store.template each_column<saved_columns<Store>>([&](auto& c) {
      using value = typename std::remove_cvref_t<decltype(c)>::value_type;
      for (const std::uint32_t i : kept) {
        if constexpr (packs_itself<shape>) {  // without it there are no forms
          if constexpr (packs_itself<value>)
            c.push_back(forms.get(table.get<std::array<std::uint64_t, 2>>(k, i), table.extra()));
        }
        if constexpr (!packs_itself<value>) c.push_back(table.get<value>(k, i));
      }
      ++k;
    });
    store.template each_initial<unsaved_columns<Store>>(
        [&](auto& c, const auto& initial) { c.resize(store.size(), initial); });
    store.locals = store.size();
    for (std::size_t i = first; i < store.size(); ++i) {
      read_kept_mass(store, i);
      require_sane(store, i, materials);
    }
  }
}

}  // namespace talus::detail

#ifndef TALUS_COMPILED_HDF5
#include "talus/io/detail/checkpoint_bodies_definitions.hpp"
#endif
