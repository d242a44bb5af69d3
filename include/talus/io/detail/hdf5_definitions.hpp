#pragma once
// The definitions of hdf5.hpp, in the compiled part or in each program.
#include "talus/io/detail/hdf5.hpp"
#include "talus/io/detail/hdf5_linkage.hpp"

namespace talus::detail {

TALUS_HDF5_INLINE std::mutex& hdf5_mutex() {
  static std::mutex one;
  return one;
}

TALUS_HDF5_INLINE silent_hdf5::silent_hdf5() {
  H5open();
  H5Eget_auto2(H5E_DEFAULT, &print_, &data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

TALUS_HDF5_INLINE std::string hdf5_words() {
  std::string words;
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_UPWARD,
      [](unsigned n, const H5E_error2_t* e, void* out) -> herr_t {
        if (n == 0 && e->desc != nullptr) *static_cast<std::string*>(out) = e->desc;
        return 0;
      },
      &words);
  return words.empty() ? "HDF5 gives no reason" : words;
}

TALUS_HDF5_INLINE std::size_t bytes_of(number_type t) {
  constexpr std::size_t bytes[] = {8, 4, 8, 4, 2, 1, 8};
  return bytes[static_cast<int>(t)];
}

TALUS_HDF5_INLINE hid_t type_in_file(number_type t) {
  const hid_t types[] = {H5T_IEEE_F64LE, H5T_IEEE_F32LE, H5T_STD_U64LE, H5T_STD_U32LE,
                         H5T_STD_U16LE,  H5T_STD_U8LE,   H5T_STD_I64LE};
  return types[static_cast<int>(t)];
}

TALUS_HDF5_INLINE hid_t type_in_memory(number_type t) {
  const hid_t types[] = {H5T_NATIVE_DOUBLE, H5T_NATIVE_FLOAT, H5T_NATIVE_UINT64, H5T_NATIVE_UINT32,
                         H5T_NATIVE_UINT16, H5T_NATIVE_UINT8, H5T_NATIVE_INT64};
  return types[static_cast<int>(t)];
}

TALUS_HDF5_INLINE std::uint64_t create_dataset(hid_t file, const std::string& path,
                                               const dataset_shape& shape) {
  const hsize_t extent[] = {shape.rows, shape.width};
  const hdf5_handle space(H5Screate_simple(shape.width == 1 ? 1 : 2, extent, nullptr), H5Sclose,
                          "written");
  const hdf5_handle links(H5Pcreate(H5P_LINK_CREATE), H5Pclose, "written");
  hdf5_ok(H5Pset_create_intermediate_group(links, 1), "written");
  const hdf5_handle how(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "written");
  hdf5_ok(H5Pset_layout(how, H5D_CONTIGUOUS), "written");
  hdf5_ok(H5Pset_alloc_time(how, H5D_ALLOC_TIME_EARLY), "written");
  hdf5_ok(H5Pset_fill_time(how, H5D_FILL_TIME_NEVER), "written");
  hdf5_ok(H5Pset_obj_track_times(how, false), "written");
  hdf5_handle set(
      H5Dcreate2(file, path.c_str(), type_in_file(shape.type), space, links, how, H5P_DEFAULT),
      H5Dclose, "written");
  const haddr_t at = shape.rows > 0 ? H5Dget_offset(set) : 0;
  if (at == HADDR_UNDEF) throw std::runtime_error("cannot be written: HDF5 gave a table no place");
  set.close("written");
  return at;
}

TALUS_HDF5_INLINE void write_whole(hid_t file, const std::string& path, number_type type,
                                   const void* data) {
  const hdf5_handle set(H5Dopen2(file, path.c_str(), H5P_DEFAULT), H5Dclose, "written");
  hdf5_ok(H5Dwrite(set, type_in_memory(type), H5S_ALL, H5S_ALL, H5P_DEFAULT, data), "written");
}

TALUS_HDF5_INLINE void write_attribute(hid_t file, const std::string& group, const char* name,
                                       std::span<const std::int64_t> values) {
  const hsize_t extent = values.size();
  const hdf5_handle at(H5Oopen(file, group.c_str(), H5P_DEFAULT), H5Oclose, "written");
  const hdf5_handle space(H5Screate_simple(1, &extent, nullptr), H5Sclose, "written");
  const hdf5_handle set(H5Acreate2(at, name, H5T_STD_I64LE, space, H5P_DEFAULT, H5P_DEFAULT),
                        H5Aclose, "written");
  hdf5_ok(H5Awrite(set, H5T_NATIVE_INT64, values.data()), "written");
}

TALUS_HDF5_INLINE void write_attribute(hid_t file, const std::string& group, const char* name,
                                       const std::string& word) {
  const hdf5_handle at(H5Oopen(file, group.c_str(), H5P_DEFAULT), H5Oclose, "written");
  const hdf5_handle type(H5Tcopy(H5T_C_S1), H5Tclose, "written");
  hdf5_ok(H5Tset_size(type, word.size()), "written");
  const hdf5_handle space(H5Screate(H5S_SCALAR), H5Sclose, "written");
  const hdf5_handle set(H5Acreate2(at, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
                        "written");
  hdf5_ok(H5Awrite(set, type, word.data()), "written");
}

TALUS_HDF5_INLINE row_selection::row_selection(hid_t set, std::uint64_t first, std::uint64_t rows,
                                               std::uint32_t width)
    : file_(H5Dget_space(set), H5Sclose, "used"), memory_(space_of(rows, width)) {
  const hsize_t start[] = {first, 0}, count[] = {rows, width};
  if (rows > 0)
    hdf5_ok(H5Sselect_hyperslab(file_, H5S_SELECT_SET, start, nullptr, count, nullptr), "used");
  else
    hdf5_ok(H5Sselect_none(file_), "used"), hdf5_ok(H5Sselect_none(memory_), "used");
}

TALUS_HDF5_INLINE hdf5_handle row_selection::space_of(std::uint64_t rows, std::uint32_t width) {
  const hsize_t extent[] = {rows > 0 ? rows : 1, width};
  return {H5Screate_simple(width == 1 ? 1 : 2, extent, nullptr), H5Sclose, "used"};
}

TALUS_HDF5_INLINE open_dataset::open_dataset(hid_t file, const std::string& path, number_type type,
                                             std::uint32_t width)
    : set_(H5Dopen2(file, path.c_str(), H5P_DEFAULT), H5Dclose, "read"), type_(type) {
  const hdf5_handle space(H5Dget_space(set_), H5Sclose, "read");
  const hdf5_handle stored(H5Dget_type(set_), H5Tclose, "read");
  hsize_t extent[2] = {0, 1};
  const int rank = H5Sget_simple_extent_ndims(space);
  if (rank < 1 || rank > 2 || H5Sget_simple_extent_dims(space, extent, nullptr) != rank ||
      H5Tequal(stored, type_in_file(type)) <= 0 || (width != 0 && extent[1] != width) ||
      extent[1] == 0 || extent[1] > 1u << 20)
    fail<std::runtime_error>("is damaged: its dataset {} is not what it should be", path);
  rows_ = extent[0];
  width_ = static_cast<std::uint32_t>(extent[1]);
}

TALUS_HDF5_INLINE void open_dataset::read(std::uint64_t first, std::uint64_t count,
                                          void* out) const {
  if (count == 0) return;
  const row_selection rows(set_, first, count, width_);
  hdf5_ok(H5Dread(set_, type_in_memory(type_), rows.memory(), rows.file(), H5P_DEFAULT, out),
          "read");
}

}  // namespace talus::detail
