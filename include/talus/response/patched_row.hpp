#pragma once
// Interior contacts of which a pair of bodies has several, swept patch by patch.
#include <cstddef>

#include "talus/response/contact_patch.hpp"
#include "talus/response/contact_row.hpp"

namespace talus::detail {

/// A contact_row whose patches are found when it is weighed.
template <swept_in_patches Contact>
class patched_row : public contact_row<Contact> {
 public:
  using typename contact_row<Contact>::state;

  void weigh(const state& s) { patches_.weigh(this->contacts_, s); }
  void apply(state& s) const { patches_.apply_all(this->contacts_, s); }
  void forward(state& s) { patches_.sweep_forward(this->contacts_, s); }
  void backward(state& s) {
    patches_.sweep_backward(this->contacts_, s, [](auto&&...) {});
  }
  template <class Note>
  void backward_watched(state& s, real speed, Note&& note) {
    patches_.sweep_backward(this->contacts_, s, [&](std::size_t i, const auto& d) {
      if (const real change = this->contacts_[i].speed_of(d); change > speed) note(i, change);
    });
  }
  void push(state& s) { patches_.sweep_push(this->contacts_, s); }

 private:
  contact_patches<Contact> patches_;
};

}  // namespace talus::detail
