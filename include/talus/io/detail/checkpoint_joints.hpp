#pragma once
// Conversion of joints to the tables of a checkpoint, and back.
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "talus/constraint/joint_line.hpp"
#include "talus/ghosts/migrating_joints.hpp"
#include "talus/io/detail/checkpoint_bodies.hpp"
#include "talus/io/detail/checkpoint_contacts.hpp"
#include "talus/io/detail/checkpoint_reader.hpp"
#include "talus/io/detail/checkpoint_table.hpp"
#include "talus/state/joints.hpp"

namespace talus::detail {

template <class Kind>
[[nodiscard]] std::string path_of_joints() {
  return std::string("/joints_") + Kind::name;
}
/// Ids of both bodies, the number of the joint, its anchors in the frames of the bodies, its
/// impulses, its coordinates and its load; of kinds with coordinates, by what these were driven.
template <class Kind>
[[nodiscard]] std::vector<table_column> columns_of_joints() {
  std::vector<table_column> all{column_of<system_id>("a"),
                                column_of<system_id>("b"),
                                column_of<std::uint64_t>("number"),
                                column_of<typename Kind::anchors>("anchors"),
                                column_of<typename joint_record<Kind>::impulse_type>("impulse"),
                                column_of<joint_coordinates>("coordinates"),
                                column_of<wrench>("load")};
  if constexpr (has_axes<Kind>) all.push_back(column_of<axis_drives>("drives"));
  return all;
}

/// The joints of bodies owned here: both ranks of two movable ones write it, each near its body.
template <class Kind, class Records>
[[nodiscard]] table_part table_of_joints(const Records& records, const jointed_ids& ids,
                                         const plain_vector<joint_end>& ends) {
  table_part t;
  t.path = path_of_joints<Kind>();
  t.columns = columns_of_joints<Kind>();
  t.memory.resize(t.columns.size());
  plain_vector<std::array<std::size_t, 2>> bodies;
  for (const auto& r : records) {
    if (r.follows) continue;
    const std::size_t a = ids.find(r.key.a), b = ids.find(r.key.b);
    std::size_t k = 0;
    const auto put = [&](const auto& value) { byte_writer(t.memory[k++]).put(value); };
    put(r.key.a), put(r.key.b), put(r.key.number), put(r.anchors), put(r.impulse);
    put(r.coordinates), put(r.load);
    if constexpr (has_axes<Kind>) put(r.drives);
    bodies.push_back({a, b});
  }
  t.rows = bodies.size();
  cut_into_pieces(t);
  for (std::size_t k = 0; k < t.columns.size(); ++k) t.columns[k].rows = t.memory[k].data();
  for (table_piece& p : t.pieces)
    for (std::size_t i = p.first; i < p.first + p.rows; ++i)
      for (const std::size_t k : bodies[i])
        if (ends[k].known) enlarge(p.box, ends[k].position);
  sum_up_pieces(t);
  return t;
}
template <class Scenario>
void add_joint_tables(world_state<Scenario>& s, std::vector<table_part>& tables) {
  if constexpr (world_state<Scenario>::has_joints) {
    const plain_vector<joint_end> ends = find_joint_ends(s);
    s.joints.each_kind([&](const auto& of_kind) {
      using kind = typename std::remove_cvref_t<decltype(of_kind)>::kind;
      tables.push_back(table_of_joints<kind>(of_kind.records, s.joints.ids(), ends));
    });
  }
}

/// The joints of the bodies `own`.
template <class Scenario>
void read_joints(const checkpoint_reader& in, world_state<Scenario>& s, const id_table& own,
                 const std::pair<vec3, vec3>& bounds) {
  if constexpr (world_state<Scenario>::has_joints) {
    s.joints.made = in.integers("/run/joints", 1)[0];
    s.joints.changed();
    s.joints.each_kind([&](auto& of_kind) {
      using kind = typename std::remove_cvref_t<decltype(of_kind)>::kind;
      of_kind.records.clear();
      table_reader table = in.table(path_of_joints<kind>(), columns_of_joints<kind>(), false);
      for (const table_piece& p : table.pieces()) {
        if (!overlap(p.box, bounds.first, bounds.second)) continue;
        table.read(p);
        for (std::uint64_t i = 0; i < p.rows; ++i) {
          joint_record<kind> r{};
          r.key = {table.get<system_id>(0, i), table.get<system_id>(1, i),
                   table.get<std::uint64_t>(2, i)};
          if (!own.has(r.key.a) && !own.has(r.key.b)) continue;
          r.anchors = table.get<typename kind::anchors>(3, i);
          r.impulse = table.get<typename joint_record<kind>::impulse_type>(4, i);
          r.coordinates = table.get<joint_coordinates>(5, i);
          r.load = table.get<wrench>(6, i);
          bool makes_sense = true;
          if constexpr (has_axes<kind>) {
            r.drives = table.get<axis_drives>(7, i);
            makes_sense = all_finite(r.drives);
          }
          if (!all_finite(r.anchors) || !all_finite(r.impulse) || !all_finite(r.coordinates) ||
              !all_finite(r.load) || !makes_sense || r.key.number >= s.joints.made)
            fail<std::runtime_error>("is damaged: the {} of bodies {} and {} makes no sense",
                                     kind::name, r.key.a, r.key.b);
          of_kind.add(r);
        }
      }
    });
    keep_own_joints(s, false);
  } else {
    (void)in, (void)s, (void)own, (void)bounds;
  }
}

}  // namespace talus::detail
