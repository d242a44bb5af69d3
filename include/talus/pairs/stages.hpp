#pragma once
// The stages of the search for pairs and contacts at which built-in features act; see
// ghosts/stages.hpp for those of the exchange of ghosts.

namespace talus::detail::search_stages {

/// Raises `steps`, the number of steps of their motion for which bodies search ahead.
struct search_ahead {
  template <class Hooks, class State>
  static auto call(State& s, int& steps) -> decltype(Hooks::search_ahead(s, steps)) {
    Hooks::search_ahead(s, steps);
  }
};
/// Contacts are found. Sets `search_again` if they must be found again.
struct contacts_found {
  template <class Hooks, class State>
  static auto call(State& s, bool& search_again)
      -> decltype(Hooks::contacts_found(s, search_again)) {
    Hooks::contacts_found(s, search_again);
  }
};

}  // namespace talus::detail::search_stages
