#pragma once
// The contacts of one kind in a world with two solvers, of which each run uses one.
#include <cstddef>
#include <tuple>

#include "talus/contact/key.hpp"
#include "talus/solver/coloured_list.hpp"
#include "talus/solver/contact_list.hpp"

namespace talus::detail {

/// Stores contacts in the list of the solver in use. It has the common interface of both kinds of
/// lists, so that all stages of a step except the solvers are compiled once.
template <class Contact>
class either_list {
 public:
  using contact_type = Contact;
  using state = typename Contact::state;

  /// Chooses between the two lists. Both are empty at that time.
  void keep_colours(bool coloured) { by_colours_ = coloured; }
  template <bool Coloured>
  [[nodiscard]] auto& of() {
    if constexpr (Coloured)
      return coloured_;
    else
      return swept_;
  }

  void clear() { by_colours_ ? coloured_.clear() : swept_.clear(); }
  void add(const Contact& contact, const contact_key& key, bool a_moves, bool b_moves,
           history_place* last, bool at_border) {
    by_colours_ ? coloured_.add(contact, key, a_moves, b_moves, last)
                : swept_.add(contact, key, a_moves, b_moves, last, at_border);
  }
  void add_boundary(const Contact& contact, const contact_key& key, bool owns_a,
                    history_place* last) {
    by_colours_ ? coloured_.add_boundary(contact, key, owns_a, last)
                : swept_.add_boundary(contact, key, owns_a, last);
  }
  /// Only if the solver in use needs contacts of bodies of other ranks.
  void add_foreign(const Contact& contact, const contact_key& key) {
    swept_.add_foreign(contact, key);
  }
  [[nodiscard]] std::size_t size() const { return by_colours_ ? coloured_.size() : swept_.size(); }
  [[nodiscard]] std::size_t bytes() const { return coloured_.bytes() + swept_.bytes(); }
  template <class F>
  void each(F&& f) const {
    by_colours_ ? coloured_.each(f) : swept_.each(f);
  }
  template <class F>
  void each_acting(F&& f) const {
    by_colours_ ? coloured_.each_acting(f) : swept_.each_acting(f);
  }
  [[nodiscard]] bool renewed() const {
    return by_colours_ ? coloured_.renewed() : swept_.renewed();
  }
  void hold() { by_colours_ ? coloured_.hold() : swept_.hold(); }
  void store_in_place(stored_contact* entries) requires(renewable<Contact>) {
    by_colours_ ? coloured_.store_in_place(entries) : swept_.store_in_place(entries);
  }
  void load_impulses(const contact_history& history) {
    by_colours_ ? coloured_.load_impulses(history) : swept_.load_impulses(history);
  }
  void store_impulses(contact_history& history) const {
    by_colours_ ? coloured_.store_impulses(history) : swept_.store_impulses(history);
  }
  void add_to(residual_scale_of<exact_sum>& scale, const state& after, const state& given) const {
    by_colours_ ? coloured_.add_to(scale, after, given) : swept_.add_to(scale, after, given);
  }
  void add_approach(const state& after, plain_vector<real>& speeds) const {
    by_colours_ ? coloured_.add_approach(after, speeds) : swept_.add_approach(after, speeds);
  }
  [[nodiscard]] std::size_t counted() const {
    return by_colours_ ? coloured_.counted() : swept_.counted();
  }
  template <class Sums, class... Scale>
  void add_to(Sums& sums, const state& s, Scale... rho) const {
    by_colours_ ? coloured_.add_to(sums, s, rho...) : swept_.add_to(sums, s, rho...);
  }
  void warm_start(state& s) const { by_colours_ ? coloured_.warm_start(s) : swept_.warm_start(s); }

 private:
  contact_list<Contact> swept_;
  coloured_list<Contact> coloured_;
  bool by_colours_ = false;
};

/// The lists that the solver in use works on: those of the tuple themselves, or the parts of
/// either_list.
template <bool Coloured, class... Lists>
[[nodiscard]] auto& lists_in_use(std::tuple<Lists...>& lists) {
  return lists;
}
template <bool Coloured, class... Contacts>
[[nodiscard]] auto lists_in_use(std::tuple<either_list<Contacts>...>& lists) {
  return std::tie(std::get<either_list<Contacts>>(lists).template of<Coloured>()...);
}

/// The list that the solver in use works on: a list itself, or a part of either_list.
template <bool Coloured, class List>
[[nodiscard]] auto& list_in_use(List& list) {
  if constexpr (requires { list.template of<Coloured>(); })
    return list.template of<Coloured>();
  else
    return list;
}

}  // namespace talus::detail
