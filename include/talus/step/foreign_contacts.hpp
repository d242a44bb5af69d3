#pragma once
// How ranks send each other the contacts of their cones of dependence. For solvers that sweep
// colour by colour; see solver/dependence_cones.hpp.
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/core/each.hpp"
#include "talus/ghosts/shared_velocities.hpp"
#include "talus/state/state.hpp"
#include "talus/step/colour_contacts.hpp"

namespace talus::detail {

/// The exchange after contacts have their colours and their stored impulses. Bodies that this rank
/// has neither as its own nor as shadow copies follow all others in the arrays of the solver, until
/// drop_foreign_bodies().
template <class Scenario>
class foreign_contacts {
  using state_type = world_state<Scenario>;
  using number = solved_scalar<Scenario>;
  using line = dependence_cones::line;
  static constexpr bool corrects = state_type::law::correction;
  /// Rows of joints look for the kind of inertia at run time.
  static constexpr bool has_tensors =
      state_type::has_joints ||
      filter_types<typename state_type::finite_shapes, has_tensor>::size > 0;

 public:
  explicit foreign_contacts(state_type& s)
      : s_(s), cones_(s.colours.cones), all_(s.colours.all), rank_(s.link->rank()) {}

  void share() {
    list_what_is_here();
    bool any = !all_.lines.empty();
    for (bool first = true; any; first = false) {
      cones_.find(first);
      any = exchange_contacts();
    }
    wanted_.resize(cones_.lines.size()), asked_.resize(cones_.lines.size());
    by_colour_.assign(cones_.lines.size(), 0), asked_by_colour_.assign(cones_.lines.size(), 0);
    if (s_.link->size() > 2) exchange_wishes();
    list_velocities();
  }

 private:
  /// Own contacts and bodies; lines for all connections but to this rank itself.
  void list_what_is_here() {
    std::vector<int> ranks;
    for (const auto& n : s_.neighbours)
      if (n.rank != rank_) ranks.push_back(n.rank);
    const std::size_t bodies = s_.solver.bodies.size();
    cones_.start(rank_, bodies, ranks.size());
    for (std::size_t n = 0; n < ranks.size(); ++n) cones_.lines[n].rank = ranks[n];
    for (const auto& other : s_.travelling)
      for (const auto i : other.received)
        cones_.set_owner(static_cast<std::int32_t>(i), other.rank);
    if (all_.lines.empty()) return;
    for (const colour_line& l : all_.lines) {
      cones_.lines[line_to(l.rank)].open = true;
      for (const std::uint32_t n : l.units)
        for (const std::int32_t body : {all_.unit(n).a, all_.unit(n).b})
          cones_.set_name(name_of(body), body);
    }
    std::size_t unit = 0, k = 0;
    auto&& lists = solver_lists<true>(s_);
    each_of(lists, [&](const auto& list) {
      const std::size_t start = unit;
      for (; unit < s_.colours.ends[k]; ++unit) {
        const contact_unit& u = all_.unit(unit);
        const auto& place = list.place_of_unit(unit - start);
        cones_.add({u.a, u.b, static_cast<std::uint32_t>(k), place.part, place.first, place.count},
                   all_.colour_of(unit));
      }
      ++k;
    });
  }
  [[nodiscard]] std::size_t line_to(int rank) const {
    std::size_t n = 0;
    while (n < cones_.lines.size() && cones_.lines[n].rank != rank) ++n;
    return n;
  }
  [[nodiscard]] bool moves(std::int32_t body) const {
    return s_.solver.bodies[static_cast<std::size_t>(body)].inverse_mass != 0;
  }
  [[nodiscard]] system_id name_of(std::int32_t body) const {
    const auto at = static_cast<std::size_t>(body);
    if (at >= cones_.own_bodies()) return cones_.name_of_added(body);
    const system_id id = moves(body) ? id_of_number(s_, at) : no_id;
    return id == no_id ? dependence_cones::name_of_number(rank_, body) : id;
  }

  /// One round: contacts travel one rank further. Returns whether another one follows.
  bool exchange_contacts() {
    const stage_clock clock(s_.seconds.exchange);
    std::vector<neighbour_message> messages;
    for (std::size_t n = 0; n < cones_.lines.size(); ++n)
      if (cones_.lines[n].open)
        pack(n, messages.emplace_back(neighbour_message{.rank = cones_.lines[n].rank}).out);
    s_.link->start(messages);
    s_.link->finish(messages);
    bool any = false;
    std::size_t k = 0;
    for (line& l : cones_.lines)
      if (l.open) {
        const bool more = unpack(l, byte_reader(messages[k++].in));
        l.open = more || l.more;
        any = any || l.open;
      }
    return any;
  }

  void pack(std::size_t n, byte_buffer& message) {
    line& l = cones_.lines[n];
    byte_buffer contacts;
    byte_writer rows(contacts);
    std::uint32_t k = 0;
    auto&& lists = solver_lists<true>(s_);
    each_of(lists, [&](const auto& list) {
      std::uint32_t count = 0;
      for (const auto& p : l.units) count += cones_.unit(p).list == k;
      rows.put(count);
      for (const auto& p : l.units) {
        const known_unit& u = cones_.unit(p);
        if (u.list != k) continue;
        rows.put(p.colour), rows.put(u.count);
        rows.put(cones_.index_in_table(n, u.a));
        rows.put(u.b < 0 ? dependence_cones::none : cones_.index_in_table(n, u.b));
        for (std::uint32_t i = 0; i < u.count; ++i) {
          auto c = list.contact(p.colour, u.part, u.first + i);
          c.a = static_cast<std::int32_t>(cones_.index_in_table(n, c.a));
          if constexpr (std::remove_cvref_t<decltype(c)>::paired)
            c.b = static_cast<std::int32_t>(cones_.index_in_table(n, c.b));
          rows.put(c), rows.put(list.key(p.colour, u.part, u.first + i));
        }
      }
      ++k;
    });
    byte_writer out(message);
    out.put(l.more);
    out.put(static_cast<std::uint32_t>(l.sent.size() - l.told));
    for (; l.told < l.sent.size(); ++l.told) {
      const std::int32_t body = l.sent[l.told];
      const auto at = static_cast<std::size_t>(body);
      const system_id name = name_of(body);
      if (cones_.owner(body) == rank_) cones_.set_name(name, body);
      out.put(name), out.put(cones_.owner(body)), out.put(s_.solver.bodies[at]);
      if constexpr (has_tensors)
        out.put(at < s_.solver.first_tensor ? mat3::Zero() : s_.solver.tensor(at));
    }
    out.put(static_cast<std::uint32_t>(l.levels.size()));
    for (const auto& level : l.levels) out.put(level);
    message.insert(message.end(), contacts.begin(), contacts.end());
  }

  /// Returns whether the neighbour will send more.
  bool unpack(line& l, byte_reader in) {
    const bool more = in.get<bool>();
    for (auto count = in.get<std::uint32_t>(); count > 0; --count) {
      const auto name = in.get<system_id>();
      const auto owner = in.get<int>();
      const auto body = in.get<solver_body_of<number>>();
      mat3 tensor = mat3::Zero();
      if constexpr (has_tensors) tensor = in.get<mat3>();
      std::int32_t here = cones_.find_name(name);
      if (here < 0) {
        here = add_body(body, tensor);
        cones_.add_body(here, name, owner);
      }
      l.received.push_back(here);
    }
    for (auto count = in.get<std::uint32_t>(); count > 0; --count) {
      const auto level = in.get<dependence_cones::told_level>();
      cones_.raise_known(l.received[level.body], level.level);
    }
    std::uint32_t k = 0;
    auto&& lists = solver_lists<true>(s_);
    each_of(lists, [&](auto& list) {
      for (auto units = in.get<std::uint32_t>(); units > 0; --units) unpack_unit(l, in, list, k);
      ++k;
    });
    return more;
  }
  std::int32_t add_body(const solver_body_of<number>& body, [[maybe_unused]] const mat3& tensor) {
    auto& solver = s_.solver;
    solver.bodies.push_back(body);
    if constexpr (corrects) solver.shift.push_back({{0, 0, 0}, body.inverse_mass});
    if constexpr (has_tensors) {
      solver.tensors.push_back(tensor);
      if constexpr (corrects) solver.turn.push_back({});
    }
    return static_cast<std::int32_t>(solver.bodies.size() - 1);
  }
  template <class List>
  void unpack_unit(line& l, byte_reader& in, List& list, std::uint32_t k) {
    using contact_type = typename List::contact_type;
    const auto colour = in.get<std::uint32_t>(), count = in.get<std::uint32_t>();
    const auto a = l.received[in.get<std::uint32_t>()];
    const auto index_b = in.get<std::uint32_t>();
    const auto b = index_b == dependence_cones::none ? -1 : l.received[index_b];
    const bool known = cones_.received(a, colour);
    known_unit unit{a, b, k, List::foreign, 0, count};
    for (std::uint32_t i = 0; i < count; ++i) {
      auto c = in.get<contact_type>();
      const auto key = in.get<contact_key>();
      if (known) continue;
      c.a = l.received[static_cast<std::size_t>(c.a)];
      bool b_moves = false;
      if constexpr (contact_type::paired) {
        c.b = l.received[static_cast<std::size_t>(c.b)];
        b_moves = moves(c.b);
      }
      const std::uint32_t place = list.add_foreign(c, key, colour, moves(c.a), b_moves);
      if (i == 0) unit.first = place;
    }
    if (known) return;
    cones_.add(unit, colour);
    cones_.note_received(a, colour);
    if (b >= 0) cones_.note_received(b, colour);
  }

  /// Asks the owners for the velocities of bodies that a neighbour has sent for a third rank. If
  /// this rank is not connected to the owner, the neighbour instead sends the velocities of its own
  /// bodies before each colour.
  void exchange_wishes() {
    plain_vector<char> comes(s_.solver.bodies.size(), 0);
    for (const line& l : cones_.lines)
      for (const std::int32_t body : l.received)
        if (cones_.owner(body) == l.rank) comes[static_cast<std::size_t>(body)] = 1;
    for (std::size_t n = 0; n < cones_.lines.size(); ++n)
      for (const std::int32_t body : cones_.lines[n].received) {
        if (!moves(body) || comes[static_cast<std::size_t>(body)]) continue;
        const std::size_t owner = line_to(cones_.owner(body));
        if (owner == cones_.lines.size()) {
          by_colour_[n] = 1;
          continue;
        }
        comes[static_cast<std::size_t>(body)] = 1;
        wanted_[owner].push_back(body);
      }
    std::vector<neighbour_message> messages;
    for (std::size_t n = 0; n < cones_.lines.size(); ++n) {
      byte_writer out(messages.emplace_back(neighbour_message{.rank = cones_.lines[n].rank}).out);
      out.put(by_colour_[n]);
      for (const std::int32_t body : wanted_[n]) out.put(name_of(body));
    }
    const stage_clock clock(s_.seconds.exchange);
    s_.link->start(messages);
    s_.link->finish(messages);
    for (std::size_t n = 0; n < cones_.lines.size(); ++n) {
      byte_reader in(messages[n].in);
      asked_by_colour_[n] = in.get<char>();
      while (!in.empty()) {
        const auto name = in.get<system_id>();
        const std::int32_t body = cones_.find_name(name);
        if (body < 0)
          fail<std::logic_error>("rank {} asks rank {} for a body that this does not share",
                                 cones_.lines[n].rank, rank_);
        asked_[n].push_back(body);
      }
    }
  }

  /// The bodies whose velocities travel before each colour. Almost all do before the first one.
  void list_velocities() {
    auto& lines = s_.colours.lines;
    lines.resize(cones_.lines.size());
    for (std::size_t n = 0; n < lines.size(); ++n) {
      const line& l = cones_.lines[n];
      velocities_by_colour& v = lines[n];
      v.rank = l.rank;
      const colour_line* shared = nullptr;
      for (const colour_line& one : all_.lines)
        if (one.rank == l.rank) shared = &one;
      list(v.sent, v.sent_from, l.sent, rank_, asked_[n], asked_by_colour_[n] ? shared : nullptr,
           &colour_line::own);
      list(v.received, v.received_from, l.received, l.rank, wanted_[n],
           by_colour_[n] ? shared : nullptr, &colour_line::foreign);
    }
    auto& of_colour = s_.colours.of_colour;
    if (of_colour.size() < all_.colours()) of_colour.resize(all_.colours());
    for (std::uint32_t c = 0; c < all_.colours(); ++c) {
      auto& m = of_colour[c];
      m.lines.clear(), m.neighbour_messages.clear();
      for (std::size_t n = 0; n < lines.size(); ++n)
        if (lines[n].any(c)) {
          m.lines.push_back(static_cast<std::uint32_t>(n));
          m.neighbour_messages.push_back({.rank = lines[n].rank});
        }
    }
  }
  void list(plain_vector<std::int32_t>& bodies, plain_vector<std::uint32_t>& from,
            const plain_vector<std::int32_t>& table, int owner,
            const plain_vector<std::int32_t>& more, const colour_line* by_colour,
            plain_vector<std::int32_t> colour_line::*of_line) const {
    bodies.clear(), from.clear();
    from.push_back(0);
    for (const std::int32_t body : table)
      if (cones_.owner(body) == owner && moves(body)) bodies.push_back(body);
    bodies.append(more.data(), more.size());
    for (std::uint32_t c = 0; c < all_.colours(); ++c) {
      if (by_colour != nullptr)
        for (std::uint32_t i = by_colour->first[c]; i < by_colour->first[c + 1]; ++i)
          bodies.push_back((by_colour->*of_line)[i]);
      from.push_back(static_cast<std::uint32_t>(bodies.size()));
    }
  }

  state_type& s_;
  dependence_cones& cones_;
  const colouring& all_;
  int rank_;
  std::vector<plain_vector<std::int32_t>> wanted_, asked_;  ///< further bodies received and sent
  plain_vector<char> by_colour_, asked_by_colour_;          ///< likewise their kind
};

/// To be called after the solver.
template <class Scenario>
void drop_foreign_bodies(world_state<Scenario>& s) {
  auto& solver = s.solver;
  const std::size_t bodies = s.colours.cones.own_bodies();
  const std::size_t added = solver.bodies.size() - bodies;
  if (added == 0) return;
  solver.bodies.resize(bodies);
  if constexpr (world_state<Scenario>::law::correction) solver.shift.resize(bodies);
  if (solver.tensors.size() > bodies - solver.first_tensor) {
    solver.tensors.resize(bodies - solver.first_tensor);
    if constexpr (world_state<Scenario>::law::correction) solver.turn.resize(solver.tensors.size());
  }
}

}  // namespace talus::detail
