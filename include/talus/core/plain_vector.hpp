#pragma once
// Lists of plain values. A std::vector costs the compiler 0.15 s for each type of element, and a
// small program has forty; here growing and copying are compiled once for all types.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <new>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace talus::detail {

/// Types that own nothing: a copy of their bytes is a copy of the value.
template <class T>
inline constexpr bool owns_nothing = std::is_trivially_copyable_v<T>;

[[gnu::noinline]] inline void release_memory(void* memory, std::size_t alignment) {
  ::operator delete (memory, std::align_val_t{alignment});
}
/// Asks the system for large pages, which some systems grant on request only: each page costs a
/// fault when it is first touched, so that growing arrays of half a million bodies cost thousands.
inline void prefer_large_pages(void* memory, std::size_t bytes) {
#if defined(__linux__)
  constexpr std::size_t page = 4096, worthwhile = std::size_t{4} << 20;
  if (bytes < worthwhile) return;
  const auto begin = (reinterpret_cast<std::uintptr_t>(memory) + page - 1) / page * page;
  const auto end = (reinterpret_cast<std::uintptr_t>(memory) + bytes) / page * page;
  (void)madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
#else
  (void)memory, (void)bytes;
#endif
}
/// New memory for `room` values of `size` bytes that begins with the first `kept` of the old ones.
[[gnu::noinline]] inline void* moved_memory(void* old, std::size_t kept, std::size_t room,
                                            std::size_t size, std::size_t alignment) {
  if (room > static_cast<std::size_t>(-1) / 2 / size) throw std::bad_alloc();
  void* const memory = ::operator new (room* size, std::align_val_t{alignment});
  prefer_large_pages(memory, room * size);
  if (kept > 0) std::memcpy(memory, old, kept * size);
  if (old != nullptr) release_memory(old, alignment);
  return memory;
}

/// Like std::vector, for values that own nothing. Iterators are pointers.
template <class T>
class plain_vector {
  static_assert(owns_nothing<T>, "a plain_vector holds values that own nothing");

 public:
  using value_type = T;
  using iterator = T*;
  using const_iterator = const T*;

  plain_vector() = default;
  explicit plain_vector(std::size_t n) { resize(n); }
  plain_vector(std::size_t n, const T& value) { assign(n, value); }
  plain_vector(std::initializer_list<T> values) { append(values.begin(), values.size()); }
  plain_vector(const T* first, const T* last) {
    append(first, static_cast<std::size_t>(last - first));
  }
  explicit plain_vector(std::span<const T> values) { append(values.data(), values.size()); }
  plain_vector(const plain_vector& other) { append(other.data_, other.size_); }
  plain_vector(plain_vector&& other) noexcept { swap(other); }
  ~plain_vector() {
    if (data_ != nullptr) release_memory(data_, alignof(T));
  }
  plain_vector& operator=(const plain_vector& other) {
    if (this != &other) clear(), reserve(other.size_), append(other.data_, other.size_);
    return *this;
  }
  plain_vector& operator=(plain_vector&& other) noexcept {
    if (this != &other) swap(other), other.clear();
    return *this;
  }
  void swap(plain_vector& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(room_, other.room_);
  }
  friend void swap(plain_vector& a, plain_vector& b) noexcept { a.swap(b); }

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::size_t capacity() const { return room_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] T* data() { return data_; }
  [[nodiscard]] const T* data() const { return data_; }
  [[nodiscard]] T& operator[](std::size_t i) { return data_[i]; }
  [[nodiscard]] const T& operator[](std::size_t i) const { return data_[i]; }
  [[nodiscard]] T& front() { return data_[0]; }
  [[nodiscard]] const T& front() const { return data_[0]; }
  [[nodiscard]] T& back() { return data_[size_ - 1]; }
  [[nodiscard]] const T& back() const { return data_[size_ - 1]; }
  [[nodiscard]] T* begin() { return data_; }
  [[nodiscard]] T* end() { return data_ + size_; }
  [[nodiscard]] const T* begin() const { return data_; }
  [[nodiscard]] const T* end() const { return data_ + size_; }

  void clear() { size_ = 0; }
  void reserve(std::size_t n) {
    if (n > room_) move_to(n);
  }
  void resize(std::size_t n) {
    make_room(n);
    for (; size_ < n; ++size_) ::new (static_cast<void*>(data_ + size_)) T{};
    size_ = n;
  }
  void resize(std::size_t n, const T& value) {
    if (n > size_) {
      const T copy = value;  // may be an element of this vector
      make_room(n);
      while (size_ < n) ::new (static_cast<void*>(data_ + size_++)) T(copy);
    }
    size_ = n;
  }
  void assign(std::size_t n, const T& value) {
    const T copy = value;
    clear();
    reserve(n);
    resize(n, copy);
  }
  void push_back(const T& value) {
    if (size_ < room_) {
      ::new (static_cast<void*>(data_ + size_++)) T(value);
    } else {
      resize(size_ + 1, value);
    }
  }
  template <class... Arguments>
  T& emplace_back(Arguments&&... arguments) {
    push_back(T{std::forward<Arguments>(arguments)...});
    return back();
  }
  void pop_back() { --size_; }
  /// Appends `n` values that the caller assigns, and returns the first of them.
  [[nodiscard]] T* extend(std::size_t n) {
    make_room(size_ + n);
    size_ += n;
    return data_ + size_ - n;
  }
  /// Removes the last `n` values.
  void shorten(std::size_t n) { size_ -= n; }
  /// Appends `n` values from another place.
  void append(const T* values, std::size_t n) {
    if (n == 0) return;
    make_room(size_ + n);
    std::memcpy(static_cast<void*>(data_ + size_), static_cast<const void*>(values), n * sizeof(T));
    size_ += n;
  }
  void append(std::span<const T> values) { append(values.data(), values.size()); }
  void erase(T* first, T* last) {
    if (first == last) return;
    std::memmove(static_cast<void*>(first), static_cast<const void*>(last),
                 static_cast<std::size_t>(end() - last) * sizeof(T));
    size_ -= static_cast<std::size_t>(last - first);
  }
  void erase(T* at) { erase(at, at + 1); }
  void insert(T* at, const T& value) {
    const auto place = static_cast<std::size_t>(at - data_);
    const T copy = value;
    push_back(copy);
    for (std::size_t i = size_ - 1; i > place; --i) data_[i] = data_[i - 1];
    data_[place] = copy;
  }

  operator std::span<const T>() const { return {data_, size_}; }
  operator std::span<T>() { return {data_, size_}; }

  friend bool operator==(const plain_vector& a, const plain_vector& b) {
    if (a.size_ != b.size_) return false;
    for (std::size_t i = 0; i < a.size_; ++i)
      if (!(a.data_[i] == b.data_[i])) return false;
    return true;
  }
  /// Lexicographic order.
  friend bool operator<(const plain_vector& a, const plain_vector& b) {
    for (std::size_t i = 0; i < a.size_ && i < b.size_; ++i) {
      if (a.data_[i] < b.data_[i]) return true;
      if (b.data_[i] < a.data_[i]) return false;
    }
    return a.size_ < b.size_;
  }

 private:
  void make_room(std::size_t n) {
    if (n > room_) move_to(n > 2 * size_ ? n : 2 * size_);
  }
  void move_to(std::size_t n) {
    data_ = static_cast<T*>(moved_memory(data_, size_, n, sizeof(T), alignof(T)));
    room_ = n;
  }

  T* data_ = nullptr;
  std::size_t size_ = 0, room_ = 0;
};

/// A plain_vector if values own nothing, else a std::vector.
template <class T>
using vector_of = std::conditional_t<owns_nothing<T>, plain_vector<T>, std::vector<T>>;

}  // namespace talus::detail
