#pragma once
// Colours of contacts that depend on the ids of their bodies alone, whichever ranks see them.
#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "talus/contact/key.hpp"
#include "talus/core/bytes.hpp"
#include "talus/core/disjoint_sets.hpp"
#include "talus/core/error.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/solver/colour_sets.hpp"

namespace talus::detail {

/// The contacts of one pair of bodies. They have one colour and are solved one after the other.
struct contact_unit {
  std::uint64_t priority = 0;  ///< a hash of the ids
  system_id id_a = no_id, id_b = no_id;
  std::int32_t a = -1, b = -1;  ///< the movable ones, in solver indices; owned here first
  std::uint32_t list = 0;       ///< of the solver: two bodies may have joints in several
  std::uint32_t first = 0;      ///< of its contacts in their list
  std::int32_t line = -1;       ///< index of the connection to the neighbour that has it too
  bool swapped = false;         ///< a is the body with id_b

  [[nodiscard]] system_id id_of_a() const { return swapped ? id_b : id_a; }
  [[nodiscard]] system_id id_of_b() const { return swapped ? id_a : id_b; }

  /// Whether another unit takes its place in the same order.
  [[nodiscard]] bool same_bodies(const contact_unit& u) const {
    return id_a == u.id_a && id_b == u.id_b && a == u.a && b == u.b && first == u.first;
  }
};

/// The data that two neighbours exchange about the contacts between their bodies, in the same order
/// on both sides.
struct colour_line {
  int rank = 0;
  plain_vector<std::uint32_t> units;
  byte_buffer out, in;
  /// Own and foreign bodies of the units, sorted by colour; those of colour k from first[k] on.
  plain_vector<std::int32_t> own, foreign;
  plain_vector<std::uint32_t> first;

  [[nodiscard]] bool open() const { return told < units.size() || heard < units.size(); }
  std::size_t told = 0, heard = 0, telling = 0;
};

/// Colours the contacts of all ranks so that no two of one body have the same colour: each gets the
/// lowest free colour, in order of descending priority (greedy colouring in the order of random
/// priorities; across ranks as Jones and Plassmann 1993: a contact waits only for contacts of its
/// own bodies). Each rank has all contacts of its own bodies; of a contact between bodies of two
/// ranks each sends the other the colours in use on its side.
class colouring {
 public:
  std::vector<colour_line> lines;

  /// Begins with the first `kept` units of the last time, if these are alone: without lines.
  void start(std::size_t bodies, std::size_t kept = 0);
  void add(const contact_unit& unit) {
    units_.push_back(unit);
    join(unit);
  }

  /// `exchange(first)` sends `out` of all connections (if `first`) or of the open ones, and fills
  /// `in`. Throws runtime_error if neighbours do not have the same contacts.
  template <class Exchange>
  void colour(Exchange&& exchange) {
    sort();
    colour_of_.assign(units_.size(), none);
    if (lines.empty()) {
      for (const std::uint32_t n : order_) give(n, sets_.lowest_free(units_[n].a, units_[n].b));
      return;
    }
    across_lines(exchange);
    for (colour_line& l : lines) schedule(l);
  }
  /// The number of colours here.
  [[nodiscard]] std::uint32_t colours() const { return colours_; }
  /// The units, in the order in which they were added.
  [[nodiscard]] std::size_t size() const { return units_.size(); }
  [[nodiscard]] const contact_unit& unit(std::size_t n) const { return units_[n]; }
  [[nodiscard]] std::uint32_t colour_of(std::size_t n) const { return colour_of_[n]; }
  [[nodiscard]] std::span<const std::uint32_t> colours_of_units() const { return colour_of_; }
  /// The bodies of this rank that units connect: each body, but for shorten(), may follow others.
  [[nodiscard]] disjoint_sets& islands() { return islands_; }
  /// The number of units of each body; one between two bodies of this rank counts for one of both.
  [[nodiscard]] const plain_vector<std::uint32_t>& units_of_bodies() const { return units_of_; }
  [[nodiscard]] std::size_t bytes() const;

 private:
  static constexpr std::uint32_t none = ~std::uint32_t{0};
  struct taken_there {
    bool told = false, known = false;
    std::vector<std::uint64_t> colours;
  };

  /// Units of one body a mostly follow each other: to count them for b is faster.
  void join(const contact_unit& u) {
    const bool joins = u.b >= 0 && u.line < 0;
    if (joins) islands_.join(u.a, u.b);
    ++units_of_[static_cast<std::size_t>(joins ? u.b : u.a)];
  }
  static bool comes_before(const contact_unit& x, const contact_unit& y);
  /// By priority: into buckets by its first bits, few in each, and then by insertion.
  void sort();
  void give(std::uint32_t n, std::uint32_t colour);

  template <class Exchange>
  void across_lines(Exchange&& exchange) {
    there_.clear();
    number_.assign(units_.size(), none);
    for (const std::uint32_t n : order_)
      if (const contact_unit& u = units_[n]; u.line >= 0) {
        number_[n] = static_cast<std::uint32_t>(there_.size());
        there_.emplace_back();
        lines[static_cast<std::size_t>(u.line)].units.push_back(n);
      }
    for (colour_line& l : lines) {
      std::uint64_t sum = 0;
      for (const std::uint32_t n : l.units) sum += mix(units_[n].priority);
      byte_writer out(l.out);
      out.put(static_cast<std::uint64_t>(l.units.size())), out.put(sum);
    }
    remaining_ = order_;
    waits_.assign(colour_sets_size(), 0);
    for (std::uint32_t round = 1;; ++round) {
      const bool first = round == 1;
      const bool any =
          first || std::any_of(lines.begin(), lines.end(), [](auto& l) { return l.open(); });
      go_on(round);
      if (!any) return;
      exchange(first);
      for (colour_line& l : lines)
        if (first || l.open()) poll(l, first);
    }
  }
  [[nodiscard]] std::size_t colour_sets_size() const;
  /// Colours the contacts that are ready, and writes the data that the neighbours need for it.
  void go_on(std::uint32_t round);
  void tell(colour_line& l, std::uint32_t n);
  void poll(colour_line& l, bool first);
  void schedule(colour_line& l);

  plain_vector<contact_unit> units_;
  disjoint_sets islands_;
  plain_vector<std::uint32_t> units_of_;
  plain_vector<std::uint32_t> order_, starts_, colour_of_, remaining_, number_, waits_;
  std::vector<taken_there> there_;  ///< of the units across connections
  colour_sets sets_;
  std::uint32_t colours_ = 0;
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/solver/colouring_definitions.hpp"
#endif
