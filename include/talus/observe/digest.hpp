#pragma once
// A fingerprint of the state of all bodies.
#include <bit>
#include <cstdint>
#include <span>
#include <string>

#include "talus/world/world.hpp"

namespace talus {

namespace detail {

/// Hash of a sequence of scalars to the last bit; -0 counts as 0.
class bit_hash {
 public:
  explicit bit_hash(std::uint64_t start) : value_(mix(start)) {}
  void add(real x) { value_ = mix(value_ ^ std::bit_cast<std::uint64_t>(x + 0.0)); }
  void add(const vec3& v) { add(v[0]), add(v[1]), add(v[2]); }
  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_;
};

}  // namespace detail

/// Collective: a hash of ids, positions, orientations and velocities of all bodies that are not
/// global, as 16 hexadecimal digits. It is the sum over the bodies of a hash of each, so it depends
/// neither on their order nor on which rank owns them: equal states give equal digests on any
/// number of ranks.
template <class Scenario>
[[nodiscard, gnu::cold]] std::string state_digest(world<Scenario>& w) {
  w.require_all_ranks("state_digest");
  std::uint64_t sum = 0;
  w.for_each_local([&](const auto& body) {
    detail::bit_hash h(value_of(body.id()));
    h.add(body.position());
    h.add(body.velocity());
    h.add(body.angular_velocity());
    const quat q = body.orientation();
    h.add(vec3(q.vec()));
    h.add(q.w());
    sum += h.value();
  });
  w.link().reduce(reduction::sum, std::span(&sum, 1));
  return fmt::vformat("{:016x}", fmt::make_format_args(sum));
}

}  // namespace talus
