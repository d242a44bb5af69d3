#pragma once
// The few functions of HDF5 that checkpoints and outputs use (C API), with errors in our words and
// handles that close themselves. Compiled for size: nothing here depends on the scenario.
#include <hdf5.h>

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <mutex>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "talus/core/error.hpp"

namespace talus::detail {

/// The library is not thread-safe, and there is one of it in a process: locked while it is used.
[[nodiscard]] std::mutex& hdf5_mutex();

/// In its lifetime HDF5 prints nothing.
class silent_hdf5 {
 public:
  silent_hdf5();
  silent_hdf5(const silent_hdf5&) = delete;
  silent_hdf5& operator=(const silent_hdf5&) = delete;
  ~silent_hdf5() { H5Eset_auto2(H5E_DEFAULT, print_, data_); }

 private:
  H5E_auto2_t print_ = nullptr;
  void* data_ = nullptr;
};

/// The first cause of HDF5's last error.
[[nodiscard, gnu::cold]] std::string hdf5_words();

/// Throws runtime_error, "cannot be <done>: <why>", for a return value of HDF5 that signals
/// failure.
template <class Result>
Result hdf5_ok(Result result, const char* done) {
  if (result < 0) fail<std::runtime_error>("cannot be {}: {}", done, hdf5_words());
  return result;
}

/// A handle that is closed at the end of its life.
class hdf5_handle {
 public:
  using closer = herr_t (*)(hid_t);
  hdf5_handle(hid_t id, closer close, const char* done) : id_(hdf5_ok(id, done)), close_(close) {}
  hdf5_handle(hdf5_handle&& other) noexcept
      : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  hdf5_handle(const hdf5_handle&) = delete;
  hdf5_handle& operator=(const hdf5_handle&) = delete;
  ~hdf5_handle() {
    if (id_ >= 0) close_(id_);
  }
  operator hid_t() const { return id_; }
  /// Never closes it: if closing would wait for ranks that have failed.
  void leave_open() { id_ = -1; }
  /// Closes it now, and returns whether that succeeds.
  void close(const char* done) {
    if (id_ >= 0) hdf5_ok(close_(std::exchange(id_, -1)), done);
  }

 private:
  hid_t id_;
  closer close_;
};

/// The type of the rows of a dataset. In the file all numbers are little-endian.
enum class number_type : std::uint8_t { f64, f32, u64, u32, u16, u8, i64 };

[[nodiscard]] std::size_t bytes_of(number_type t);
[[nodiscard, gnu::cold]] hid_t type_in_file(number_type t);
[[nodiscard, gnu::cold]] hid_t type_in_memory(number_type t);

/// A dataset: rows of `width` numbers.
struct dataset_shape {
  number_type type = number_type::f64;
  std::uint64_t rows = 0;
  std::uint32_t width = 1;
  [[nodiscard]] std::size_t row_bytes() const { return bytes_of(type) * width; }
};

/// Makes a dataset whose position in the file is fixed at once, without filling it, and its parent
/// groups. Returns the position of its rows in the file; 0 if it has none.
[[gnu::cold]] std::uint64_t create_dataset(hid_t file, const std::string& path,
                                           const dataset_shape& shape);

[[gnu::cold]] void write_whole(hid_t file, const std::string& path, number_type type,
                               const void* data);

/// An attribute of an existing group: numbers.
[[gnu::cold]] void write_attribute(hid_t file, const std::string& group, const char* name,
                                   std::span<const std::int64_t> values);
/// An attribute of an existing group: a word, in as many bytes as it has letters.
[[gnu::cold]] void write_attribute(hid_t file, const std::string& group, const char* name,
                                   const std::string& word);

/// Rows [first, first + rows) of the space of a dataset, and as many in memory.
class row_selection {
 public:
  row_selection(hid_t set, std::uint64_t first, std::uint64_t rows, std::uint32_t width);
  [[nodiscard]] hid_t file() const { return file_; }
  [[nodiscard]] hid_t memory() const { return memory_; }

 private:
  static hdf5_handle space_of(std::uint64_t rows, std::uint32_t width);
  hdf5_handle file_, memory_;
};

/// The dataset at `path`, which must hold rows of `width` such numbers. Any width fits 0.
class open_dataset {
 public:
  open_dataset(hid_t file, const std::string& path, number_type type, std::uint32_t width);
  [[nodiscard]] std::uint64_t rows() const { return rows_; }
  [[nodiscard]] std::uint32_t width() const { return width_; }
  /// `out` holds `count` rows. The caller has checked the number of rows.
  void read(std::uint64_t first, std::uint64_t count, void* out) const;

 private:
  hdf5_handle set_;
  number_type type_;
  std::uint64_t rows_ = 0;
  std::uint32_t width_ = 1;
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED_HDF5
#include "talus/io/detail/hdf5_definitions.hpp"
#endif
