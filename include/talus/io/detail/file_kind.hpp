#pragma once
// Common functions of the kinds of HDF5 files that all ranks write together, and their differences.
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <utility>

#include "talus/core/bytes.hpp"
#include "talus/io/detail/checkpoint_places.hpp"
#include "talus/io/detail/checkpoint_table.hpp"
#include "talus/io/detail/hdf5.hpp"
#include "talus/io/detail/hdf5_image.hpp"
#include "talus/io/detail/system_file.hpp"

namespace talus::detail {

/// A dataset that rank 0 writes alone.
struct small_dataset {
  std::string path;
  number_type type = number_type::f64;
  std::uint64_t rows = 0;
  std::uint32_t width = 1;
  byte_buffer bytes;
};

[[nodiscard, gnu::cold]] byte_buffer bytes_of_text(const std::string& text);
[[nodiscard, gnu::cold]] small_dataset text_dataset(std::string path, const std::string& text);
template <class T>
[[nodiscard, gnu::cold]] small_dataset numbers_dataset(std::string path, std::span<const T> values,
                                                       std::uint32_t width = 1) {
  const auto bytes = std::as_bytes(values);
  return {std::move(path),
          std::is_same_v<T, double>         ? number_type::f64
          : std::is_same_v<T, std::int64_t> ? number_type::i64
                                            : number_type::u64,
          values.size() / width,
          width,
          {bytes.begin(), bytes.end()}};
}

/// The data of one kind of file besides its tables, on rank 0 alone.
class file_kind {
 public:
  file_kind() = default;
  file_kind(const file_kind&) = delete;
  file_kind& operator=(const file_kind&) = delete;
  virtual ~file_kind() = default;

  /// For messages, as in "the checkpoint".
  [[nodiscard]] virtual const char* name() const = 0;
  /// Description of the files of this kind.
  [[nodiscard]] virtual const output_kind& looks() const = 0;
  /// Whether it must be on the disk, and read back, before it is renamed.
  [[nodiscard]] virtual bool durable() const = 0;
  /// Bytes before the HDF5 file proper: 0, or 512 times a power of two.
  [[nodiscard]] virtual std::uint32_t block_bytes(std::size_t /*columns*/) { return 0; }
  /// A dataset has its position in the file.
  virtual void placed(std::uint64_t /*at*/, std::uint64_t /*bytes*/) {}
  /// Adds the data of table `k` to the file.
  virtual void describe(hid_t /*file*/, const table_part&, std::size_t /*k*/, const counted_rows&) {
  }
  /// Adds the data of the whole file.
  virtual void describe_file(hid_t) {}
  /// All rows are written: writes the last data before the file is renamed. `file` is open.
  virtual void seal(int /*file*/, const sparse_bytes& /*but_rows*/, std::uint64_t /*bytes*/) {}
  /// Throws runtime_error if the data besides the rows cannot be read back.
  virtual void verify(int /*file*/) {}
};

[[gnu::cold]] void write_small(hid_t file, const std::string& path, number_type type,
                               std::uint64_t rows, std::uint32_t width, const void* data);

}  // namespace talus::detail

#ifndef TALUS_COMPILED_HDF5
#include "talus/io/detail/file_kind_definitions.hpp"
#endif
