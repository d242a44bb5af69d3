#pragma once
// The definitions of checkpoint_reader.hpp, in the compiled part or in each program.
#include "talus/io/detail/checkpoint_reader.hpp"
#include "talus/io/detail/hdf5_linkage.hpp"

namespace talus::detail {

TALUS_HDF5_INLINE checkpoint_reader::checkpoint_reader(const std::string& name)
    : only_(hdf5_mutex()) {
  const system_file file(name, O_RDONLY | O_NONBLOCK);  // a pipe may have no writer
  struct stat found {};
  if (!file.good() || ::fstat(file.id(), &found) != 0)
    fail<std::runtime_error>("cannot be read: {}", system_words());
  const auto length = static_cast<std::uint64_t>(found.st_size);
  byte_buffer head(std::min<std::uint64_t>(length, 512));
  if (!S_ISREG(found.st_mode) || !file.read(0, head))
    throw std::runtime_error("cannot be read: it is no file");
  if (head.size() == 512) {  // its stated length, if plausible; read_block checks it
    std::uint32_t bytes = 0;
    std::memcpy(&bytes, head.data() + 36, 4);
    head.resize(std::min<std::uint64_t>({std::max(bytes, 512u), length, 1u << 26}));
    if (!file.read(0, head)) throw std::runtime_error("cannot be read to its end");
  }
  const checkpoint_block block = read_block(head, length);
  if (checksum_of_rest(file.id(), block) != block.rest_checksum)
    throw std::runtime_error("is damaged: the checksum of what describes its tables is wrong");
  const hdf5_handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "read");
#if H5_VERSION_GE(1, 10, 7)
  hdf5_ok(H5Pset_file_locking(access, false, true), "read");
#endif
  file_.emplace(H5Fopen(name.c_str(), H5F_ACC_RDONLY, access), H5Fclose, "read");
}

TALUS_HDF5_INLINE std::string checkpoint_reader::text(const std::string& path) const {
  const auto bytes = numbers<char>(path, number_type::u8);
  return {bytes.begin(), bytes.end()};
}

}  // namespace talus::detail
