#pragma once
// The header of every message that carries bodies: its sequence number between two ranks, and the
// number of bodies migrated in that direction so far. A lost, duplicate, truncated or altered
// message is detected when the next one is read, and the body in it is known by its id. This needs
// no further message and no collective call.
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>

#include "talus/core/bytes.hpp"
#include "talus/state/body_count.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

struct message_header {
  std::uint64_t number = 0;  ///< from 1 on, in each direction
  body_count handed_over{};  ///< in this direction, up to and with this message
  std::uint64_t sum = 0;     ///< of the content, if bodies migrate
};

/// A checksum of bytes: rounds of multiplication and rotation, as in FNV-1a with words of 8 bytes
/// (Fowler, Noll, Vo).
[[nodiscard]] inline std::uint64_t sum_of(std::span<const std::byte> bytes) {
  std::uint64_t sum = 0xcbf29ce484222325ull;
  while (!bytes.empty()) {
    std::uint64_t word = 0;
    const std::size_t n = std::min(bytes.size(), sizeof word);
    std::memcpy(&word, bytes.data(), n);
    sum = std::rotl((sum ^ word) * 0x9e3779b97f4a7c15ull, 29);
    bytes = bytes.subspan(n);
  }
  return sum;
}

/// The last position of a body here: as one of this rank's, as a copy, or when copies or pairs were
/// chosen.
template <class Scenario>
[[nodiscard, gnu::cold]] std::string last_seen(const world_state<Scenario>& s, system_id id) {
  std::string place;
  const auto seen = [&](const vec3& p) {
    if (place.empty()) place = compose(" (last seen at {})", p);
  };
  std::size_t k = 0;
  s.each_finite_shape([&](const auto& b) {
    for (std::size_t i = 0; i < b.movable.size(); ++i)
      if (b.movable.id[i] == id) seen(b.movable.position[i]);
    const auto search = [&](const auto& noted) {
      for (const noted_body& n : noted)
        if (n.id == id) seen(n.position);
    };
    if constexpr (requires { s.choice.bodies; }) search(s.choice.bodies[k]);
    if (k < s.found.shapes.size()) search(s.found.shapes[k].bodies);
    ++k;
  });
  return place;
}
template <class Scenario>
[[nodiscard, gnu::cold]] std::string text(const world_state<Scenario>& s, const surplus& of) {
  return of.text() + (of.single() ? last_seen(s, of.id) : "");
}

inline constexpr const char* deliver_once =
    "the transport must deliver each message once, whole, and in the order in which they were sent";

/// Begins the next message to neighbour `n`.
template <class Scenario>
void open_message(rank_state<Scenario>& s, std::size_t n) {
  s.neighbours[n].next_exchange();
  s.neighbour_messages[n].out.assign(sizeof(message_header), std::byte{});
}

/// Writes the header of a complete message; `handover`: with a checksum.
template <class Scenario>
void seal_message(rank_state<Scenario>& s, std::size_t n, bool handover) {
  auto& channel = s.neighbours[n].channel;
  byte_buffer& out = s.neighbour_messages[n].out;
  const message_header head{++channel.sent, channel.given,
                            handover ? sum_of(std::span(out).subspan(sizeof(message_header))) : 0};
  std::memcpy(out.data(), &head, sizeof head);
}

/// Opens the message from neighbour `n`, and returns a reader of its content. Throws runtime_error,
/// with the ranks, the step, and the body if it is one, unless the message is the next in sequence.
template <class Scenario>
[[nodiscard]] byte_reader read_message(world_state<Scenario>& s, std::size_t n, bool handover) {
  auto& channel = s.neighbours[n].channel;
  const auto in = std::span<const std::byte>(s.neighbour_messages[n].in);
  const int from = s.neighbours[n].rank, here = s.link->rank();
  message_header head;
  if (in.size() >= sizeof head) std::memcpy(&head, in.data(), sizeof head);
  const std::uint64_t expected = ++channel.received;
  if (head.number != expected) {
    const bool again = head.number < expected && head.sum != 0;
    const surplus bodies = again ? surplus(channel.taken, channel.before_last)
                                 : surplus(head.handed_over, channel.taken);
    fail<std::runtime_error>(
        "rank {} waits for message {} of rank {} in step {}, but {}{}; {}", here, expected, from,
        s.steps,
        in.size() < sizeof head  ? compose("what came has {} bytes, and no head", in.size())
        : head.number < expected ? compose("message {} came a second time", head.number)
                                 : compose("message {} came: one is lost", head.number),
        bodies.bodies == 0 ? std::string()
                           : ", and with it " + text(s, bodies) +
                                 compose(", which rank {} handed over to rank {}", from, here),
        deliver_once);
  }
  const auto content = in.subspan(sizeof head);
  if (handover && sum_of(content) != head.sum)
    fail<std::runtime_error>(
        "the message in which rank {} hands over {} to rank {} in step {} came changed: {} bytes, "
        "which do not fit their checksum; {}",
        from, text(s, surplus(head.handed_over, channel.taken)), here, s.steps, in.size(),
        deliver_once);
  channel.told = head.handed_over;
  if (channel.told.bodies != channel.taken.bodies) channel.before_last = channel.taken;
  return byte_reader(content, s.neighbours[n].shared());
}

/// After the content has been read: throws runtime_error unless all of it was read, and as many
/// bodies arrived as were sent.
template <class Scenario>
void close_message(const world_state<Scenario>& s, std::size_t n, const byte_reader& rest) {
  const auto& channel = s.neighbours[n].channel;
  const int from = s.neighbours[n].rank, here = s.link->rank();
  if (channel.taken != channel.told) {
    const surplus difference(channel.taken, channel.told);
    fail<std::runtime_error>(
        "{} {} on the way from rank {} to rank {} in step {}: {} bodies were handed over so far, "
        "and {} came",
        text(s, difference),
        difference.bodies > 0   ? "came too much"
        : difference.bodies < 0 ? "was lost"
                                : "came",
        from, here, s.steps, channel.told.bodies, channel.taken.bodies);
  }
  if (!rest.empty())
    fail<std::runtime_error>(
        "the message of rank {} to rank {} in step {} is longer than its content; {}", from, here,
        s.steps, deliver_once);
}

}  // namespace talus::detail
