#pragma once
// Interior contacts of a kind with several per pair of bodies, swept manifold by manifold.
#include <cstddef>

#include "talus/constraint/contact_manifolds.hpp"
#include "talus/constraint/contact_row.hpp"

namespace talus::detail {

/// A contact_row that finds its manifolds when it is prepared.
template <swept_in_manifolds Contact, class Planner = ordered_planner>
class manifold_row : public contact_row<Contact> {
 public:
  using typename contact_row<Contact>::state;

  [[nodiscard]] std::size_t bytes() const {
    return contact_row<Contact>::bytes() + manifolds_.bytes();
  }
  template <class F>
  void edit(std::size_t i, F&& f) {
    manifolds_.impulses_change();
    contact_row<Contact>::edit(i, f);
  }
  void prepare(const state& s) { manifolds_.prepare(this->contacts_, s); }
  void prepare_again(const state& s) { manifolds_.prepare_again(this->contacts_, s); }
  void apply(state& s) const { manifolds_.apply_all(this->contacts_, s); }
  void forward(state& s) { meet_all(s), manifolds_.sweep_forward(this->contacts_, s); }
  void backward(state& s) { meet_all(s), manifolds_.sweep_backward(this->contacts_, s); }
  template <class Note>
  void backward_watched(state& s, real speed, Note&& note) {
    meet_all(s);
    manifolds_.sweep_watched(this->contacts_, s, [&](std::size_t i, real change) {
      if (change > speed) note(i, change);
    });
  }
  void correct(state& s) { manifolds_.sweep_correction(this->contacts_, s); }

  // Sweeps over one group of islands, see island_groups.hpp, in steps without impacts.

  void sweep_group(std::size_t group, bool forward, state& s) {
    manifolds_.sweep_group(group, forward, this->contacts_, s);
  }
  void correct_group(std::size_t group, bool first, state& s) {
    manifolds_.correct_group(group, first, this->contacts_, s);
  }
  /// Calls f(contact) with one contact of each manifold.
  template <class F>
  void each_manifold(F&& f) const {
    manifolds_.each_manifold(this->contacts_,
                             [&](std::size_t first, std::size_t) { f(this->contacts_[first]); });
  }

 private:
  void meet_all(state& s) {
    if (s.stage == impact_stage::none) return;
    for (Contact& c : this->contacts_) meet_impacts(c, s);
  }

  contact_manifolds<Contact, Planner> manifolds_;
};

}  // namespace talus::detail
