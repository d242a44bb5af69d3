#pragma once
// A digest of the state of all bodies.
#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
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
  /// Any other value, by its bytes; for a type with its own serialization, its packed bytes.
  template <class T>
  void add(const T& value) {
    byte_buffer bytes;
    byte_writer(bytes).put(value);
    for (std::size_t i = 0; i < bytes.size(); i += sizeof(std::uint64_t)) {
      std::uint64_t word = 0;
      std::memcpy(&word, bytes.data() + i, std::min(sizeof word, bytes.size() - i));
      value_ = mix(value_ ^ word);
    }
  }
  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_;
};

template <class View>
void add_columns(bit_hash& h, const View& body) {
  [&]<class... Columns>(type_list<Columns...>) {
    (h.add(body.template get<Columns>()), ...);
  }(typename columns_by_use<typename View::columns>::hashed{});
}

}  // namespace detail

/// Collective: a hash of ids, positions, orientations, velocities and the columns of user-defined
/// features, of all bodies that are not global, as 16 hexadecimal digits. It is the sum over the
/// bodies of a hash of each, so it depends neither on their order nor on their ranks: equal states
/// give equal digests on any number of ranks.
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
    detail::add_columns(h, body);
    sum += h.value();
  });
  w.link().reduce(reduction::sum, std::span(&sum, 1));
  return fmt::vformat("{:016x}", fmt::make_format_args(sum));
}

}  // namespace talus
