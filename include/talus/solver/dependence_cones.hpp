#pragma once
// The contacts of other ranks that this rank solves too, so that sweeps by colours need one
// exchange each.
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "talus/core/id.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// The contacts of one pair of bodies, with the place where their list stores them. Bodies are
/// solver indices; b is -1 if one of them cannot move.
struct known_unit {
  std::int32_t a = -1, b = -1;
  std::uint32_t list = 0, part = 0, first = 0, count = 0;
};

/// A contact between a body X of rank A and a body Y of rank B is computed on both. For that A
/// needs the velocity of Y before the colour of the contact, thus the results of the contacts of Y
/// with lower colours, those of their other bodies with still lower colours, and so on: a cone of
/// contacts in which colours decrease. B sends A all contacts of this cone once in a step. A then
/// needs the velocities of their bodies only at the start of each sweep, and computes the rest as B
/// does, to the bit (redundant computation in overlapping domains, as in communication-avoiding
/// Krylov methods: Demmel, Hoemmen, Mohiyuddin, Yelick 2008).
///
/// Where more than two ranks meet, a cone has contacts between bodies of a third rank C, of which B
/// has only what C has sent. So contacts travel in rounds, each one rank further.
///
/// A level of a body is a colour plus 1: all its contacts with a lower colour plus 1 are needed, or
/// known.
class dependence_cones {
 public:
  static constexpr std::uint32_t none = ~std::uint32_t{0};
  struct place_of_unit {
    std::uint32_t colour, index;
  };
  struct told_level {
    std::uint32_t body, level;  ///< its index in the table, and the level that is known there now
  };
  /// The traffic with one neighbour.
  struct line {
    int rank = 0;
    bool open = false;  ///< takes part in this round
    bool more = false;  ///< this rank will send more in the next round
    /// Bodies of the contacts sent and received, in solver indices here: both ranks have the same
    /// tables, in the same order.
    plain_vector<std::int32_t> sent, received;
    std::size_t told = 0;                      ///< bodies of `sent` that the neighbour knows
    plain_vector<place_of_unit> units;         ///< to be sent in this round
    plain_vector<told_level> levels;           ///< likewise
    std::unordered_set<std::uint64_t> before;  ///< units sent earlier
    plain_vector<std::int32_t> raised, third;  ///< bodies of the cone: new needs, of third ranks
  };
  std::vector<line> lines;

  /// `bodies` of this rank, shadow copies included.
  void start(int rank, std::size_t bodies, std::size_t neighbours);
  void set_owner(std::int32_t body, int rank) { owner_[at(body)] = rank; }
  [[nodiscard]] int owner(std::int32_t body) const { return owner_[at(body)]; }
  void add(const known_unit& unit, std::uint32_t colour);
  /// Whether a body has a known contact of this colour that another rank sent.
  [[nodiscard]] bool received(std::int32_t body, std::uint32_t colour) const {
    return from_others_.contains(key(at(body), colour));
  }
  void note_received(std::int32_t body, std::uint32_t colour) {
    from_others_.insert(key(at(body), colour));
  }
  [[nodiscard]] const known_unit& unit(const place_of_unit& p) const {
    return by_colour_[p.colour][p.index];
  }
  /// The contacts that the neighbours with an open line need and do not have yet.
  void find(bool first);
  /// The index of a body in the table of the bodies sent to line n; enters it if it is new.
  [[nodiscard]] std::uint32_t index_in_table(std::size_t n, std::int32_t body);
  void raise_known(std::int32_t body, std::uint32_t level);
  /// A body that this rank has neither as its own nor as a shadow copy.
  void add_body(std::int32_t body, system_id name, int owner);

  /// Names of bodies that hold on all ranks: ids of bodies that move, and for other bodies of the
  /// solver their rank and number there.
  [[nodiscard]] static system_id name_of_number(int rank, std::int32_t number) {
    return system_id{std::uint64_t{3} << 62 | std::uint64_t(rank) << 32 | std::uint32_t(number)};
  }
  void set_name(system_id name, std::int32_t body) { numbers_.emplace(value_of(name), body); }
  /// -1 for an unknown name.
  [[nodiscard]] std::int32_t find_name(system_id name) const {
    const auto found = numbers_.find(value_of(name));
    return found == numbers_.end() ? -1 : found->second;
  }
  [[nodiscard]] std::size_t own_bodies() const { return bodies_; }
  [[nodiscard]] system_id name_of_added(std::int32_t body) const {
    return added_[at(body) - bodies_];
  }
  [[nodiscard]] std::size_t bytes() const;

 private:
  /// The levels of a body for one line: `need` is wanted by this rank, and `told` has been sent.
  struct cell {
    std::uint32_t need = 0, told = 0, index = none;
  };
  static std::size_t at(std::int32_t body) { return static_cast<std::size_t>(body); }
  static std::uint64_t key(std::size_t x, std::uint32_t colour) {
    return static_cast<std::uint64_t>(x) << 32 | colour;
  }
  /// The first of a body's cells, one for each line.
  std::size_t cells_of(std::int32_t body);
  void raise(std::size_t n, std::int32_t body, std::uint32_t need);
  void add_to_cone(std::size_t n, std::uint32_t colour, std::uint32_t index);
  void find_levels(std::size_t n);
  void find_level(std::size_t n, std::int32_t body);

  int rank_ = 0;
  std::size_t bodies_ = 0;
  plain_vector<int> owner_;
  plain_vector<std::uint32_t> known_;  ///< the level below which all contacts are known, if foreign
  plain_vector<std::uint32_t> slot_;   ///< number of the cells of a body, plus 1
  plain_vector<cell> cells_;
  std::vector<plain_vector<known_unit>> by_colour_;
  plain_vector<system_id> added_;  ///< names of the bodies from bodies_ on
  std::unordered_set<std::uint64_t> from_others_;
  std::unordered_map<std::uint64_t, std::int32_t> numbers_;
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/solver/dependence_cones_definitions.hpp"
#endif
