#pragma once
// The content of messages: values appended to and read from a plain byte buffer.
#include <cstddef>
#include <cstring>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "talus/core/math.hpp"

namespace talus::detail {

using byte_buffer = std::vector<std::byte>;

/// Types whose bytes are their value. Eigen's fixed-size types are so in fact, and so are structs
/// of them, though their copy constructors hide it from is_trivially_copyable; what owns memory has
/// a destructor that tells.
template <class T>
inline constexpr bool plain_bytes = std::is_trivially_destructible_v<T> && !std::is_pointer_v<T>;

/// Appends to a buffer. Sender and receiver must be of one architecture.
class byte_writer {
 public:
  explicit byte_writer(byte_buffer& out) : out_(&out) {}

  template <class T>
  void put(const T& value) {
    static_assert(plain_bytes<T>, "only plain values travel in messages");
    const auto at = out_->size();
    out_->resize(at + sizeof(T));
    std::memcpy(out_->data() + at, &value, sizeof(T));
  }
  template <class T>
  void put(std::span<const T> values) {
    put(values.size());
    for (const T& value : values) put(value);
  }

 private:
  byte_buffer* out_;
};

/// Reads what a byte_writer wrote, in the same order; throws runtime_error past the end.
class byte_reader {
 public:
  explicit byte_reader(std::span<const std::byte> in) : in_(in) {}

  template <class T>
  T get() {
    static_assert(plain_bytes<T>, "only plain values travel in messages");
    if (in_.size() < sizeof(T)) throw std::runtime_error("a message ended before its content");
    T value;
    std::memcpy(static_cast<void*>(&value), in_.data(), sizeof(T));
    in_ = in_.subspan(sizeof(T));
    return value;
  }
  template <class T>
  std::vector<T> get_all() {
    std::vector<T> values(get<std::size_t>());
    for (T& value : values) value = get<T>();
    return values;
  }
  [[nodiscard]] bool empty() const { return in_.empty(); }

 private:
  std::span<const std::byte> in_;
};

}  // namespace talus::detail
