#pragma once
// The definitions of file_kind.hpp, in the compiled part or in each program.
#include "talus/io/detail/file_kind.hpp"
#include "talus/io/detail/hdf5_linkage.hpp"

namespace talus::detail {

TALUS_HDF5_INLINE byte_buffer bytes_of_text(const std::string& text) {
  const auto* at = reinterpret_cast<const std::byte*>(text.data());
  return {at, at + text.size()};
}

TALUS_HDF5_INLINE small_dataset text_dataset(std::string path, const std::string& text) {
  return {std::move(path), number_type::u8, text.size(), 1, bytes_of_text(text)};
}

TALUS_HDF5_INLINE void write_small(hid_t file, const std::string& path, number_type type,
                                   std::uint64_t rows, std::uint32_t width, const void* data) {
  create_dataset(file, path, {type, rows, width});
  if (rows > 0) write_whole(file, path, type, data);
}

}  // namespace talus::detail
