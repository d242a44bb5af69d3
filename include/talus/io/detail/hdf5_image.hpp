#pragma once
// An HDF5 file composed in memory. HDF5 writes the metadata of the datasets to pages of memory, and
// no rows; the caller writes the pages to the disk. So HDF5 never meets a full disk: a file that it
// cannot close makes it crash when the program ends.
#include <hdf5.h>
#if H5_VERSION_GE(1, 13, 0)
#include <H5FDdevelop.h>
#endif

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <new>
#include <span>
#include <utility>

#include "talus/io/detail/hdf5.hpp"

namespace talus::detail {

/// Bytes of a file of which only some pages are held; all others are zero.
class sparse_bytes {
 public:
  static constexpr std::size_t page_bytes = 4096;

  void write(std::uint64_t at, std::span<const std::byte> from);
  void read(std::uint64_t at, std::span<std::byte> into) const;
  /// Calls f(place, bytes) for the held pages, in ascending order, up to `length`.
  template <class F>
  void each(std::uint64_t length, F&& f) const {
    for (const auto& [page, bytes] : pages_) {
      const std::uint64_t at = page * page_bytes;
      if (at >= length) return;
      f(at, std::span<const std::byte>(bytes).first(
                static_cast<std::size_t>(std::min<std::uint64_t>(page_bytes, length - at))));
    }
  }

 private:
  template <class F>
  static void each_page(std::uint64_t at, std::size_t bytes, F&& f) {
    for (std::size_t offset = 0; offset < bytes;) {
      const auto in_page = static_cast<std::size_t>(at % page_bytes);
      const std::size_t part = std::min(page_bytes - in_page, bytes - offset);
      f(at / page_bytes, in_page, offset, part);
      at += part;
      offset += part;
    }
  }
  std::map<std::uint64_t, std::array<std::byte, page_bytes>> pages_;
};

/// The file driver of HDF5 for such files, and one file. Use it under hdf5_mutex().
class hdf5_image {
 public:
  hdf5_image() : driver_(hdf5_ok(register_driver(), "composed")) {}
  hdf5_image(const hdf5_image&) = delete;
  hdf5_image& operator=(const hdf5_image&) = delete;
  ~hdf5_image() { H5FDunregister(driver_); }

  /// Makes files with this access list in this image.
  [[gnu::cold]] void use_in(hid_t access_list);
  /// The length of the whole file, after it is closed.
  [[nodiscard]] std::uint64_t length() const { return length_; }
  [[nodiscard]] sparse_bytes take_bytes() { return std::move(bytes_); }

 private:
  /// The content of an access list.
  struct target {
    hdf5_image* image;
  };
  /// HDF5's own part comes first.
  struct open_file {
    H5FD_t of_hdf5;
    hdf5_image* image;
    haddr_t allocated, end;
  };
  static open_file& mine(H5FD_t* file) { return *reinterpret_cast<open_file*>(file); }
  static const open_file& mine(const H5FD_t* file) {
    return *reinterpret_cast<const open_file*>(file);
  }

  static H5FD_t* open(const char*, unsigned, hid_t access_list, haddr_t);
  static herr_t close(H5FD_t* file);
  static herr_t query(const H5FD_t*, unsigned long* flags);
  static haddr_t get_allocated(const H5FD_t* file, H5FD_mem_t) { return mine(file).allocated; }
  static herr_t set_allocated(H5FD_t* file, H5FD_mem_t, haddr_t end);
  static haddr_t get_end(const H5FD_t* file, H5FD_mem_t) { return mine(file).end; }
  static herr_t read(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t bytes, void* into);
  static herr_t write(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t bytes,
                      const void* from);
  static herr_t truncate(H5FD_t* file, hid_t, hbool_t);

  [[gnu::cold]] static hid_t register_driver();

  hid_t driver_;
  sparse_bytes bytes_;
  std::uint64_t length_ = 0;
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED_HDF5
#include "talus/io/detail/hdf5_image_definitions.hpp"
#endif
