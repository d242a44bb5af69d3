#pragma once
// Access to the state of a world for the layers above it. Observers and outputs see a const view;
// what restarts a run or applies forces gets the state itself. Neither is part of the public face.

namespace talus {

template <class Scenario>
class world;

namespace detail {

template <class Scenario>
struct world_state;

struct world_access {
  template <class Scenario>
  [[nodiscard]] static const world_state<Scenario>& view(const world<Scenario>& w) {
    return w.state_;
  }
  template <class Scenario>
  [[nodiscard]] static world_state<Scenario>& state(world<Scenario>& w) {
    return w.state_;
  }
};

template <class Scenario>
[[nodiscard]] const world_state<Scenario>& view_of(const world<Scenario>& w) {
  return world_access::view(w);
}
template <class Scenario>
[[nodiscard]] world_state<Scenario>& state_of(world<Scenario>& w) {
  return world_access::state(w);
}
template <class Scenario>
[[nodiscard]] const world_state<Scenario>& state_of(const world<Scenario>& w) {
  return world_access::view(w);
}

}  // namespace detail
}  // namespace talus
