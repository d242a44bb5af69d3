#pragma once
// Immutable data that many bodies share, such as the surface of a polyhedron. Bodies hold it by
// reference, and it is sent to a neighbouring rank only if that rank does not have it.
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/core/id.hpp"

namespace talus::detail {

/// The name of data, a hash of its content: 128 bits, so that collisions do not occur.
struct content_id {
  std::uint64_t high = 0, low = 0;
  friend bool operator==(const content_id&, const content_id&) = default;
  friend bool operator<(const content_id& a, const content_id& b) {
    return a.high != b.high ? a.high < b.high : a.low < b.low;
  }
};

[[nodiscard]] inline content_id id_of_content(std::span<const std::byte> bytes) {
  content_id id{mix(bytes.size()), ~mix(bytes.size())};
  while (!bytes.empty()) {
    const std::size_t n = bytes.size() < 8 ? bytes.size() : 8;
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data(), n);
    id.high = mix(id.high ^ word);
    id.low = mix(id.low + word * 0x9e3779b97f4a7c15ull);
    bytes = bytes.subspan(n);
  }
  return id;
}

/// What a thread has made of one type of data: it finds all that is in use, and the last ones made.
template <class Data>
class made_data {
 public:
  static constexpr std::size_t held = 32;  ///< the last ones made, in use or not

  template <class Make>
  [[nodiscard]] std::shared_ptr<const Data> get(const content_id& name, Make&& make) {
    std::shared_ptr<const Data> data = all_[name].lock();
    if (data != nullptr) return data;
    all_[name] = data = make();
    last_[next_] = data;
    next_ = (next_ + 1) % held;
    if (all_.size() > most_) {
      std::erase_if(all_, [](const auto& one) { return one.second.expired(); });
      most_ = 2 * all_.size() + 64;
    }
    return data;
  }

 private:
  std::map<content_id, std::weak_ptr<const Data>> all_;
  std::array<std::shared_ptr<const Data>, held> last_;
  std::size_t next_ = 0, most_ = 64;
};

/// Data that take long to make: `make()` is called unless this thread has made data of this name
/// that are in use, or among the last made_data::held. The name is a hash of all that they are made
/// from.
template <class Data, class Make>
[[nodiscard]] std::shared_ptr<const Data> made_once(const content_id& name, Make&& make) {
  thread_local made_data<Data> made;
  return made.get(name, make);
}

/// The shared data that both ends of a channel between two ranks hold. The two ends see the same
/// messages in the same order, so their memories stay equal without communication.
class shared_memory {
 public:
  /// Call it at the beginning of each exchange on the channel: removes data that recent exchanges
  /// did not use.
  void next_exchange() {
    ++exchange_;
    std::size_t kept = 0;
    for (entry& e : known_)
      if (e.used + patience >= exchange_) {
        if (&known_[kept] != &e) known_[kept] = std::move(e);
        ++kept;
      }
    known_.resize(kept);
  }
  /// The data, or null if the other end does not have it. The call marks the data as used.
  [[nodiscard]] std::shared_ptr<const void> recall(const content_id& id) {
    const std::size_t at = place_of(id);
    if (at == known_.size() || known_[at].id != id) return nullptr;
    known_[at].used = exchange_;
    return known_[at].data;
  }
  /// Returns the data stored under this name, which is `data` if the name is new.
  std::shared_ptr<const void> learn(const content_id& id, std::shared_ptr<const void> data) {
    if (auto known = recall(id)) return known;
    known_.insert(known_.begin() + static_cast<std::ptrdiff_t>(place_of(id)),
                  entry{id, data, exchange_});
    return data;
  }
  [[nodiscard]] std::size_t size() const { return known_.size(); }

 private:
  static constexpr std::uint64_t patience = 50;  ///< exchanges

  struct entry {
    content_id id;
    std::shared_ptr<const void> data;
    std::uint64_t used;
  };
  /// Position of the first entry that is not before `id`.
  [[nodiscard]] std::size_t place_of(const content_id& id) const {
    std::size_t low = 0, high = known_.size();
    while (low < high) {
      const std::size_t middle = (low + high) / 2;
      (known_[middle].id < id ? low : high) = known_[middle].id < id ? middle + 1 : middle;
    }
    return low;
  }

  std::vector<entry> known_;  ///< sorted
  std::uint64_t exchange_ = 0;
};

/// Writes the name of shared data, and the data unless the receiver has it. The data type has a
/// member `id` and packs itself.
template <class Data>
void put_shared(byte_writer& out, const std::shared_ptr<const Data>& data) {
  shared_memory* memory = out.memory();
  const bool known = memory != nullptr && memory->recall(data->id) != nullptr;
  out.put(data->id);
  out.put(static_cast<std::uint8_t>(known));
  if (known) return;
  data->pack(out);
  if (memory != nullptr) memory->learn(data->id, data);
}

/// Reads the output of put_shared.
template <class Data>
[[nodiscard]] std::shared_ptr<const Data> get_shared(byte_reader& in) {
  shared_memory* memory = in.memory();
  const auto id = in.get<content_id>();
  std::shared_ptr<const void> data;
  if (in.get<std::uint8_t>() != 0) {
    if (memory != nullptr) data = memory->recall(id);
    if (data == nullptr)
      throw std::runtime_error("a message names shared data that its receiver does not have");
  } else {
    data = std::make_shared<const Data>(Data::unpack(in));
    if (memory != nullptr) data = memory->learn(id, std::move(data));
  }
  return std::static_pointer_cast<const Data>(data);
}

}  // namespace talus::detail
