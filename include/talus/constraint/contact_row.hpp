#pragma once
// Interior contacts that are solved one by one, in a row.
#include <cstddef>

#include "talus/constraint/impact_terms.hpp"
#include "talus/constraint/joint_in_list.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/constraint/stored_impulses.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

template <class Contact>
class contact_row {
 public:
  using state = typename Contact::state;

  void clear() { contacts_.clear(); }
  /// Only blocks depend on which of its bodies can move.
  void add(const Contact& c, bool, bool) { contacts_.push_back(c); }
  [[nodiscard]] std::size_t size() const { return contacts_.size(); }
  [[nodiscard]] std::size_t bytes() const { return contacts_.capacity() * sizeof(Contact); }
  [[nodiscard]] const Contact& operator[](std::size_t i) const { return contacts_[i]; }
  /// Calls f(contact), which may change it.
  template <class F>
  void edit(std::size_t i, F&& f) {
    f(contacts_[i]);
  }

  void load_impulses(const contact_history& history, const plain_vector<contact_key>& keys,
                     const plain_vector<history_place*>& places) {
    detail::load_impulses(history, keys, places, contacts_);
  }
  void prepare(const state& s) {
    for (Contact& c : contacts_) c.prepare(s, 1, 1);
  }
  void prepare_again(const state& s) { prepare(s); }
  void apply(state& s) const {
    for (const Contact& c : contacts_) c.apply(s, c.impulse_in_frame());
  }
  /// Adds the impulses that are held to the others.
  void end_impacts() {
    if constexpr (may_rebound<Contact>)
      for (Contact& c : contacts_) c.set(c.impulse_in_frame() + c.held);
  }
  void forward(state& s) {
    in_streams([&](Contact& c) { meet_impacts(c, s), c.apply(s, c.relax(s)); });
  }
  void backward(state& s) {
    in_streams_backward([&](Contact& c) { meet_impacts(c, s), c.apply(s, c.relax(s)); });
  }
  /// Solves as backward() does, and calls note(number, change of velocity) for those that change by
  /// more than `speed`.
  template <class Note>
  void backward_watched(state& s, real speed, Note&& note) {
    in_streams_backward([&](Contact& c) {
      meet_impacts(c, s);
      const auto d = c.relax(s);
      c.apply(s, d);
      const real change = c.speed_of(d);
      if (change > speed) note(static_cast<std::size_t>(&c - contacts_.data()), change);
    });
  }
  void correct(state& s) {
    in_streams([&](Contact& c) {
      const auto d = c.relax_correction(s);
      if constexpr (!is_joint<Contact>)
        if (d == 0) return;
      c.correct_a(s, d), c.correct_b(s, d);
    });
  }

 protected:
  plain_vector<Contact> contacts_;

 private:
  /// Sweeps run through this many parts of the row side by side: see the kinds of contacts.
  static constexpr std::size_t streams = Contact::streams;

  template <class F>
  void in_streams(F&& f) {
    const std::size_t part = contacts_.size() / streams;
    for (std::size_t i = 0; i < part; ++i)
      for (std::size_t k = 0; k < streams; ++k) f(contacts_[k * part + i]);
    for (std::size_t i = streams * part; i < contacts_.size(); ++i) f(contacts_[i]);
  }
  template <class F>
  void in_streams_backward(F&& f) {
    const std::size_t part = contacts_.size() / streams;
    for (std::size_t i = contacts_.size(); i-- > streams * part;) f(contacts_[i]);
    for (std::size_t i = part; i-- > 0;)
      for (std::size_t k = streams; k-- > 0;) f(contacts_[k * part + i]);
  }
};

}  // namespace talus::detail
