#pragma once
// The definitions of hdf5_image.hpp, in the compiled part or in each program.
#include "talus/io/detail/hdf5_image.hpp"
#include "talus/io/detail/hdf5_linkage.hpp"

namespace talus::detail {

TALUS_HDF5_INLINE void sparse_bytes::write(std::uint64_t at, std::span<const std::byte> from) {
  each_page(at, from.size(),
            [&](std::uint64_t page, std::size_t in_page, std::size_t offset, std::size_t bytes) {
              std::memcpy(pages_[page].data() + in_page, from.data() + offset, bytes);
            });
}

TALUS_HDF5_INLINE void sparse_bytes::read(std::uint64_t at, std::span<std::byte> into) const {
  each_page(at, into.size(),
            [&](std::uint64_t page, std::size_t in_page, std::size_t offset, std::size_t bytes) {
              const auto found = pages_.find(page);
              if (found == pages_.end())
                std::memset(into.data() + offset, 0, bytes);
              else
                std::memcpy(into.data() + offset, found->second.data() + in_page, bytes);
            });
}

TALUS_HDF5_INLINE void hdf5_image::use_in(hid_t access_list) {
  const target here{this};
  hdf5_ok(H5Pset_driver(access_list, driver_, &here), "composed");
}

TALUS_HDF5_INLINE H5FD_t* hdf5_image::open(const char*, unsigned, hid_t access_list, haddr_t) {
  const auto* to = static_cast<const target*>(H5Pget_driver_info(access_list));
  auto* file = to != nullptr ? new (std::nothrow) open_file{} : nullptr;
  if (file == nullptr) return nullptr;
  file->image = to->image;
  return &file->of_hdf5;
}

TALUS_HDF5_INLINE herr_t hdf5_image::close(H5FD_t* file) {
  open_file& f = mine(file);
  f.image->length_ = std::max(f.allocated, f.end);
  delete &f;
  return 0;
}

TALUS_HDF5_INLINE herr_t hdf5_image::query(const H5FD_t*, unsigned long* flags) {
  *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
           H5FD_FEAT_AGGREGATE_SMALLDATA;
  return 0;
}

TALUS_HDF5_INLINE herr_t hdf5_image::set_allocated(H5FD_t* file, H5FD_mem_t, haddr_t end) {
  mine(file).allocated = end;
  return 0;
}

TALUS_HDF5_INLINE herr_t hdf5_image::read(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at,
                                          std::size_t bytes, void* into) {
  mine(file).image->bytes_.read(at, std::span(static_cast<std::byte*>(into), bytes));
  return 0;
}

TALUS_HDF5_INLINE herr_t hdf5_image::write(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at,
                                           std::size_t bytes, const void* from) {
  open_file& f = mine(file);
  try {
    f.image->bytes_.write(at, std::span(static_cast<const std::byte*>(from), bytes));
  } catch (const std::bad_alloc&) {  // HDF5 is C
    return -1;
  }
  f.end = std::max<haddr_t>(f.end, at + bytes);
  return 0;
}

TALUS_HDF5_INLINE herr_t hdf5_image::truncate(H5FD_t* file, hid_t, hbool_t) {
  mine(file).end = mine(file).allocated;
  return 0;
}

TALUS_HDF5_INLINE hid_t hdf5_image::register_driver() {
  H5FD_class_t driver{};
#if H5_VERSION_GE(1, 13, 0)
  driver.version = H5FD_CLASS_VERSION;
  driver.value = static_cast<H5FD_class_value_t>(4711);  // of those reserved for general use
#endif
  driver.name = "talus_memory";
  driver.maxaddr = (haddr_t{1} << 62) - 1;
  driver.fc_degree = H5F_CLOSE_WEAK;
  driver.fapl_size = sizeof(target);
  driver.open = open;
  driver.close = close;
  driver.query = query;
  driver.get_eoa = get_allocated;
  driver.set_eoa = set_allocated;
  driver.get_eof = get_end;
  driver.read = read;
  driver.write = write;
  driver.truncate = truncate;
  // As in files on disks: metadata, and data.
  const H5FD_mem_t kinds[] = H5FD_FLMAP_DICHOTOMY;
  std::copy(std::begin(kinds), std::end(kinds), driver.fl_map);
  return H5FDregister(&driver);
}

}  // namespace talus::detail
