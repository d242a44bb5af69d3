#pragma once
// Frictional contact problems in FCLIB's HDF5 format (Acary, Brémond, Koziara, Pérignon 2014).
#include <hdf5.h>

#include <string>
#include <vector>

#include "problem.hpp"

namespace fc3d {

/// An identifier of the HDF5 library, given back at the end.
class hdf5_handle {
 public:
  hdf5_handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  hdf5_handle(const hdf5_handle&) = delete;
  hdf5_handle& operator=(const hdf5_handle&) = delete;
  ~hdf5_handle() {
    if (id_ >= 0) close_(id_);
  }
  [[nodiscard]] hid_t get() const { return id_; }
  explicit operator bool() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// All values of a data set, converted to Number (int or double).
template <class Number>
std::vector<Number> read_all(hid_t file, const std::string& name) {
  const hdf5_handle set(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!set) fail<std::runtime_error>("there is no data set '{}' in it", name);
  const hdf5_handle space(H5Dget_space(set.get()), H5Sclose);
  const hssize_t count = space ? H5Sget_simple_extent_npoints(space.get()) : -1;
  if (count < 0 || count > most_entries)
    fail<std::runtime_error>("the size of data set '{}' is out of bounds", name);
  std::vector<Number> all(static_cast<std::size_t>(count));
  const hid_t type = std::is_same_v<Number, int> ? H5T_NATIVE_INT : H5T_NATIVE_DOUBLE;
  if (H5Dread(set.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data()) < 0)
    fail<std::runtime_error>("data set '{}' cannot be read", name);
  return all;
}

inline int read_one(hid_t file, const std::string& name) {
  const auto all = read_all<int>(file, name);
  if (all.size() != 1)
    fail<std::runtime_error>("data set '{}' should be one number, but has {}", name, all.size());
  return all[0];
}

/// A local problem in FCLIB's format; W in compressed rows (nz = -2), compressed columns (-1) or
/// triplets (>= 0). Throws runtime_error or invalid_argument that says what is wrong.
inline assembled_problem read_fclib(const std::string& path) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  const hdf5_handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!file) fail<std::runtime_error>("is not a sound HDF5 file");
  const hid_t f = file.get();
  const std::string top = "fclib_local/", w = top + "W/";
  if (H5Lexists(f, "fclib_local", H5P_DEFAULT) <= 0) {
    if (H5Lexists(f, "fclib_global", H5P_DEFAULT) > 0)
      fail<std::runtime_error>("holds a global problem; only local ones are read");
    fail<std::runtime_error>("has no group fclib_local");
  }
  if (const int d = read_one(f, top + "spacedim"); d != 3)
    fail<std::runtime_error>("the dimension should be 3, but is {}", d);
  const int rows = read_one(f, w + "m"), columns = read_one(f, w + "n"), nz = read_one(f, w + "nz");
  auto q = read_all<double>(f, top + "vectors/q");
  auto mu = read_all<double>(f, top + "vectors/mu");
  const auto size = static_cast<int>(3 * mu.size());
  if (rows != size || columns != size || q.size() != static_cast<std::size_t>(size))
    fail<std::runtime_error>("{} coefficients of friction, but W is {} by {} and q has {} values",
                             mu.size(), rows, columns, q.size());
  const auto p = read_all<int>(f, w + "p"), i = read_all<int>(f, w + "i");
  const auto x = read_all<double>(f, w + "x");

  auto blocks = compressed_blocks(nz, size, p, i, x);
  return assemble(std::move(blocks), contact_vector(q.data(), size / 3),
                  plain_vector<real>(std::span<const real>(mu)));
}

}  // namespace fc3d
