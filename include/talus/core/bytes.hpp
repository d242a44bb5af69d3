#pragma once
// The content of messages: values appended to and read from a plain byte buffer.
#include <concepts>
#include <cstddef>
#include <cstring>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

using byte_buffer = std::vector<std::byte>;

/// Types whose bytes are their value, on every rank.
template <class T>
inline constexpr bool plain_bytes = std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>;

class byte_writer;
class byte_reader;
class shared_memory;

/// A type that packs itself: `pack(byte_writer&)`, and a static `unpack(byte_reader&)` that
/// restores it.
template <class T>
concept packs_itself = requires(const T& value, byte_writer& out, byte_reader& in) {
  value.pack(out);
  { T::unpack(in) } -> std::same_as<T>;
};

/// Appends to a buffer. Sender and receiver must be of one architecture.
class byte_writer {
 public:
  /// `memory` belongs to the channel of the message; without it shared data is always sent.
  explicit byte_writer(byte_buffer& out, shared_memory* memory = nullptr)
      : out_(&out), memory_(memory) {}

  template <class T>
  void put(const T& value) {
    if constexpr (packs_itself<T>) {
      value.pack(*this);
    } else {
      static_assert(plain_bytes<T>, "only plain values travel in messages");
      const auto at = out_->size();
      out_->resize(at + sizeof(T));
      std::memcpy(out_->data() + at, &value, sizeof(T));
    }
  }
  template <class T>
  void put(std::span<const T> values) {
    put(values.size());
    if constexpr (std::is_same_v<T, std::byte>)
      out_->insert(out_->end(), values.begin(), values.end());
    else
      for (const T& value : values) put(value);
  }
  /// See core/shared_data.hpp; null if the channel has none.
  [[nodiscard]] shared_memory* memory() const { return memory_; }

 private:
  byte_buffer* out_;
  shared_memory* memory_;
};

/// Reads what a byte_writer wrote, in the same order; throws runtime_error past the end.
class byte_reader {
 public:
  explicit byte_reader(std::span<const std::byte> in, shared_memory* memory = nullptr)
      : in_(in), memory_(memory) {}

  template <class T>
  T get() {
    if constexpr (packs_itself<T>) {
      return T::unpack(*this);
    } else {
      static_assert(plain_bytes<T>, "only plain values travel in messages");
      if (in_.size() < sizeof(T)) throw std::runtime_error("a message ended before its content");
      T value;
      std::memcpy(static_cast<void*>(&value), in_.data(), sizeof(T));
      in_ = in_.subspan(sizeof(T));
      return value;
    }
  }
  /// So many bytes, which are not copied.
  std::span<const std::byte> get_bytes(std::size_t count) {
    if (in_.size() < count) throw std::runtime_error("a message ended before its content");
    const std::span<const std::byte> bytes = in_.first(count);
    in_ = in_.subspan(count);
    return bytes;
  }
  template <class T>
  vector_of<T> get_all() {
    const auto count = get<std::size_t>();
    if (count > in_.size()) throw std::runtime_error("a message ended before its content");
    vector_of<T> values(count);
    for (T& value : values) value = get<T>();
    return values;
  }
  [[nodiscard]] shared_memory* memory() const { return memory_; }
  [[nodiscard]] bool empty() const { return in_.empty(); }

 private:
  std::span<const std::byte> in_;
  shared_memory* memory_;
};

}  // namespace talus::detail
