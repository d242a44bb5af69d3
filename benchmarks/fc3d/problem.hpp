#pragma once
// Frictional contact problems from files: what the formats have in common, and Siconos' text.
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "talus/core/plain_vector.hpp"
#include "talus/solver/direct/assembled.hpp"

namespace fc3d {

using talus::mat3;
using talus::real;
using talus::detail::assemble;
using talus::detail::assembled_problem;
using talus::detail::contact_vector;
using talus::detail::delassus_block;
using talus::detail::fail;
using talus::detail::plain_vector;

/// More is taken for a damaged file.
inline constexpr long long most_contacts = 200'000, most_entries = 200'000'000;

/// W from single values in any order; those of one place are added up.
class block_gatherer {
 public:
  void add(long long row, long long column, real value) {
    if (value == 0) return;
    const auto i = static_cast<std::int32_t>(row / 3), j = static_cast<std::int32_t>(column / 3);
    if (blocks_.empty() || blocks_.back().row != i || blocks_.back().column != j)
      blocks_.push_back({i, j, mat3::Zero()});
    blocks_.back().value(row % 3, column % 3) += value;
  }
  [[nodiscard]] plain_vector<delassus_block> take() { return std::move(blocks_); }

 private:
  plain_vector<delassus_block> blocks_;
};

/// Numbers of a text, one after the other, each with a name for messages.
class number_stream {
 public:
  explicit number_stream(std::string_view text) : at_(text.data()), end_(at_ + text.size()) {}

  long long integer(const char* what, long long least, long long most) {
    const std::string_view word = next(what);
    long long value = 0;
    const auto [stop, code] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (code != std::errc{} || stop != word.data() + word.size())
      fail<std::runtime_error>("{} should be an integer, but is '{}'", what, std::string(word));
    if (value < least || value > most)
      fail<std::runtime_error>("{} should be in {} to {}, but is {}", what, least, most, value);
    return value;
  }
  real number(const char* what) {
    std::string_view word = next(what);
    const std::string whole(word);
    if (word.front() == '+') word.remove_prefix(1);
    real value = 0;
    const auto [stop, code] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (stop != word.data() + word.size() || code == std::errc::invalid_argument)
      fail<std::runtime_error>("{} should be a number, but is '{}'", what, whole);
    if (code == std::errc::result_out_of_range) value = std::strtod(whole.c_str(), nullptr);
    if (!std::isfinite(value))
      fail<std::runtime_error>("{} should be finite, but is '{}'", what, whole);
    return value;
  }

 private:
  std::string_view next(const char* what) {
    const auto blank = [](char c) { return c == ' ' || (c >= '\t' && c <= '\r'); };
    while (at_ != end_ && blank(*at_)) ++at_;
    if (at_ == end_) fail<std::runtime_error>("the file ends where {} should be", what);
    const char* first = at_;
    while (at_ != end_ && !blank(*at_)) ++at_;
    const auto length = static_cast<std::size_t>(at_ - first);
    if (length > 60) fail<std::runtime_error>("{} should be a number", what);
    return {first, length};
  }
  const char* at_;
  const char* end_;
};

inline plain_vector<delassus_block> read_dense(number_stream& in, long long size) {
  in.integer("the number of rows of the dense W", size, size);
  in.integer("the number of columns of the dense W", size, size);
  std::vector<real> column(static_cast<std::size_t>(3 * size));
  block_gatherer w;
  for (long long j = 0; j < size; j += 3) {
    for (real& x : column) x = in.number("an element of W");
    for (long long i = 0; i < size; i += 3)
      for (long long k = 0; k < 9; ++k)
        w.add(i + k % 3, j + k / 3, column[static_cast<std::size_t>(k / 3 * size + i + k % 3)]);
  }
  return w.take();
}

inline plain_vector<delassus_block> read_blocks(number_stream& in, long long size) {
  const auto list = [&](const char* what, long long count, long long least, long long most) {
    std::vector<long long> all(static_cast<std::size_t>(count));
    for (auto& x : all) x = in.integer(what, least, most);
    return all;
  };
  const auto count = in.integer("the number of blocks", 0, most_entries / 9);
  const auto rows = in.integer("the number of block rows", 1, size);
  const auto columns = in.integer("the number of block columns", 1, size);
  const auto row_ends = list("the end of a block row", rows, 1, size);
  const auto column_ends = list("the end of a block column", columns, 1, size);
  for (const auto* ends : {&row_ends, &column_ends}) {
    for (std::size_t k = 1; k < ends->size(); ++k)
      if ((*ends)[k] <= (*ends)[k - 1]) fail<std::runtime_error>("the ends of blocks must ascend");
    if (ends->back() != size)
      fail<std::runtime_error>("the blocks of W end at {} instead of {}", ends->back(), size);
  }
  const auto filled1 = in.integer("filled1", 0, rows + 1);
  const auto filled2 = in.integer("filled2", 0, count);
  const auto index1 = list("a row start (index1)", filled1, 0, count);
  const auto index2 = list("a block column (index2)", filled2, 0, columns - 1);
  for (std::size_t k = 1; k < index1.size(); ++k)
    if (index1[k] < index1[k - 1]) fail<std::runtime_error>("the row starts (index1) must ascend");
  if ((index1.empty() ? 0 : index1.back()) != count || filled2 != count)
    fail<std::runtime_error>("{} blocks, but the row starts end at {} and index2 has {}", count,
                             index1.empty() ? 0 : index1.back(), filled2);

  block_gatherer w;
  for (std::size_t row = 0; row + 1 < index1.size(); ++row) {
    const auto top = row > 0 ? row_ends[row - 1] : 0, height = row_ends[row] - top;
    for (auto k = index1[row]; k < index1[row + 1]; ++k) {
      const auto number = in.integer("the number of a block", 0, count - 1);
      if (number != k) fail<std::runtime_error>("block {} comes where {} should be", number, k);
      const auto c = static_cast<std::size_t>(index2[static_cast<std::size_t>(k)]);
      const auto left = c > 0 ? column_ends[c - 1] : 0, width = column_ends[c] - left;
      for (long long e = 0; e < width * height; ++e)
        w.add(top + e % height, left + e / height, in.number("an element of W"));
    }
  }
  return w.take();
}

/// A problem in Siconos' text format, W dense (storage 0) or in blocks (1). What follows mu is
/// ignored. Throws runtime_error or invalid_argument that says what is wrong.
inline assembled_problem read_text(std::string_view text) {
  number_stream in(text);
  in.integer("the dimension", 3, 3);
  const auto contacts = in.integer("the number of contacts", 0, most_contacts);
  const auto storage = in.integer("the storage (0 dense, 1 blocks)", 0, 1);
  const auto size = 3 * contacts;
  in.integer("the number of rows of W", size, size);
  in.integer("the number of columns of W", size, size);
  if (storage == 0 && size * size > most_entries)
    fail<std::runtime_error>("{} contacts are too many for a dense W", contacts);
  auto blocks = storage == 0 ? read_dense(in, size)
                : size > 0   ? read_blocks(in, size)
                             : plain_vector<delassus_block>{};
  contact_vector q(static_cast<int>(contacts));
  for (std::size_t k = 0; k < q.size(); ++k) q.data()[k] = in.number("an element of q");
  plain_vector<real> mu(static_cast<std::size_t>(contacts));
  for (auto& x : mu) x = in.number("a coefficient of friction");
  return assemble(std::move(blocks), std::move(q), std::move(mu));
}

/// Blocks of a square W as CSparse and FCLIB store it: in compressed rows (nz = -2), compressed
/// columns (-1) or triplets (their number; `i` rows, `p` columns).
inline plain_vector<delassus_block> compressed_blocks(int nz, int size, const std::vector<int>& p,
                                                      const std::vector<int>& i,
                                                      const std::vector<double>& x) {
  block_gatherer gather;
  const auto inside = [&](int k) { return k >= 0 && k < size; };
  if (nz >= 0) {
    const auto count = static_cast<std::size_t>(nz);
    if (p.size() < count || i.size() < count || x.size() < count)
      fail<std::runtime_error>("{} triplets, but W/p, W/i, W/x have {}, {}, {} values", nz,
                               p.size(), i.size(), x.size());
    // As in CSparse, from which the format comes: i rows, p columns.
    for (std::size_t k = 0; k < count; ++k) {
      if (!inside(i[k]) || !inside(p[k]))
        fail<std::runtime_error>("an element of W is at ({}, {}), outside", i[k], p[k]);
      gather.add(i[k], p[k], x[k]);
    }
  } else if (nz == -1 || nz == -2) {
    const auto lines = static_cast<std::size_t>(size);
    const auto stored = std::min(i.size(), x.size());
    if (p.size() < lines + 1 || p[0] != 0)
      fail<std::runtime_error>("W/p should have {} values and begin with 0", lines + 1);
    for (std::size_t line = 0; line < lines; ++line) {
      if (p[line + 1] < p[line] || static_cast<std::size_t>(p[line + 1]) > stored)
        fail<std::runtime_error>("W/p must ascend up to the {} values stored", stored);
      for (auto k = static_cast<std::size_t>(p[line]); k < static_cast<std::size_t>(p[line + 1]);
           ++k) {
        if (!inside(i[k])) fail<std::runtime_error>("W/i holds {}, outside", i[k]);
        if (nz == -2)
          gather.add(static_cast<int>(line), i[k], x[k]);
        else
          gather.add(i[k], static_cast<int>(line), x[k]);
      }
    }
  } else {
    fail<std::runtime_error>("W/nz should be -2, -1 or at least 0, but is {}", nz);
  }
  return gather.take();
}

/// All bytes of a file. Throws runtime_error if it cannot be read.
inline std::string contents(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string all(std::istreambuf_iterator<char>(file), {});
  if (!file && !file.eof()) fail<std::runtime_error>("cannot be read");
  return all;
}

}  // namespace fc3d
