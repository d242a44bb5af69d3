#pragma once
// Interior contacts of which a pair of bodies has several, swept patch by patch.
#include <cstddef>

#include "talus/response/contact_patches.hpp"
#include "talus/response/contact_row.hpp"

namespace talus::detail {

/// A contact_row whose patches are found when it is weighed.
template <swept_in_patches Contact, class Planner = ordered_planner>
class patched_row : public contact_row<Contact> {
 public:
  using typename contact_row<Contact>::state;

  [[nodiscard]] std::size_t bytes() const {
    return contact_row<Contact>::bytes() + patches_.bytes();
  }
  void weigh(const state& s) { patches_.weigh(this->contacts_, s); }
  void apply(state& s) const { patches_.apply_all(this->contacts_, s); }
  void forward(state& s) { patches_.sweep_forward(this->contacts_, s); }
  void backward(state& s) { patches_.sweep_backward(this->contacts_, s); }
  template <class Note>
  void backward_watched(state& s, real speed, Note&& note) {
    patches_.sweep_watched(this->contacts_, s, [&](std::size_t i, real change) {
      if (change > speed) note(i, change);
    });
  }
  void push(state& s) { patches_.sweep_push(this->contacts_, s); }

 private:
  contact_patches<Contact, Planner> patches_;
};

}  // namespace talus::detail
