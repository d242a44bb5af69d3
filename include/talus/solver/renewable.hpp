#pragma once
// Contacts that can be kept from step to step.

namespace talus::detail {

/// Contacts that get new data in their places; see step/kept_contacts.hpp.
template <class Contact>
concept renewable = Contact::paired && requires {
  typename Contact::blocks;
};

}  // namespace talus::detail
