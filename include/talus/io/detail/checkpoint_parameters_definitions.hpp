#pragma once
// The definitions of checkpoint_parameters.hpp, in the compiled part or in each program.
#include <algorithm>
#include <array>
#include "talus/io/detail/checkpoint_parameters.hpp"

#include "talus/io/detail/hdf5_linkage.hpp"

namespace talus::detail {

TALUS_HDF5_INLINE std::array<double, 8> numbers_of(const material& m) {
  return {m.density,   m.restitution,    m.friction,      m.sliding_friction(),
          m.stiffness, m.youngs_modulus, m.poisson_ratio, m.rolling_friction};
}

TALUS_HDF5_INLINE std::vector<double> numbers_of(const material_table& all) {
  std::vector<double> numbers;
  for (std::size_t i = 0; i < all.size(); ++i)
    for (const double x : numbers_of(all[material_id(i)])) numbers.push_back(x);
  return numbers;
}

TALUS_HDF5_INLINE std::vector<double> numbers_of_pairs(const material_table& all) {
  std::vector<double> numbers;
  for (const auto& own : all.own_pairs().entries()) {
    const pair_material& p = own.value;
    numbers.insert(numbers.end(), {double(own.low), double(own.high), p.restitution, p.friction,
                                   p.dynamic_friction});
  }
  return numbers;
}

TALUS_HDF5_INLINE std::vector<double> numbers_of(const pair_rules& rules) {
  return {static_cast<double>(rules.restitution), static_cast<double>(rules.friction)};
}

TALUS_HDF5_INLINE void require_materials(const checkpoint_reader& in, const material_table& mine) {
  constexpr std::array names{"density",   "restitution",     "friction",      "dynamic friction",
                             "stiffness", "Young's modulus", "Poisson ratio", "rolling friction"};
  const auto theirs = in.reals("/materials/each", checkpoint_reader::any, 8);
  if (theirs.size() != 8 * mine.size())
    fail<std::runtime_error>(
        "is of a run with {} materials, and this program has made {}: its set-up must make the "
        "same",
        theirs.size() / 8, mine.size());
  const auto own = numbers_of(mine);
  for (std::size_t k = 0; k < own.size(); ++k)
    if (own[k] != theirs[k])
      fail<std::runtime_error>(
          "is of a run whose material {} has the {} {}, and this program gives it {}: its set-up "
          "must make the same materials",
          k / 8, names[k % 8], theirs[k], own[k]);
  const pair_rules& rules = mine.rules();
  const bool by_table = rules.friction == pair_rule::table || rules.restitution == pair_rule::table;
  const auto theirs_of =
      in.has("/materials/rules") ? in.reals("/materials/rules", 2, 1) : std::vector<double>{0, 0};
  if (theirs_of != numbers_of(rules))
    fail<std::runtime_error>(
        "is of a run with other rules for pairs of materials (world.pair_rules), and this program "
        "takes friction by the {} and restitution by the {}: its set-up must set the same",
        name_of(rules.friction), name_of(rules.restitution));
  // A pair set in only one of the two runs may still be equal.
  const auto same = [](const pair_material& a, const pair_material& b) {
    return a.restitution == b.restitution && a.friction == b.friction &&
           a.sliding_friction() == b.sliding_friction();
  };
  const auto refuse = [](std::uint32_t a, std::uint32_t b) {
    fail<std::runtime_error>(
        "is of a run with other properties for contacts of the materials {} and {} (world."
        "material_pair): its set-up must make the same",
        a, b);
  };
  if (!in.has("/materials/own_pairs")) {  // written before these were stored: the whole square
    const auto n = mine.size();
    const auto all = in.reals("/materials/pairs", n * n, 3);
    for (std::size_t k = 0; k < n * n; ++k)
      if (!same({all[3 * k], all[3 * k + 1], all[3 * k + 2]},
                mine.pair(material_id(k / n), material_id(k % n))))
        refuse(static_cast<std::uint32_t>(k / n), static_cast<std::uint32_t>(k % n));
    return;
  }
  const auto pairs = in.reals("/materials/own_pairs", checkpoint_reader::any, 5);
  pair_table<pair_material> of_file;
  for (std::size_t k = 0; k < pairs.size(); k += 5) {
    if (!(pairs[k] >= 0 && pairs[k] <= pairs[k + 1] && pairs[k + 1] < double(mine.size())))
      fail<std::runtime_error>("is damaged: it has a pair of the materials {} and {}", pairs[k],
                               pairs[k + 1]);
    const auto a = static_cast<std::uint32_t>(pairs[k]),
               b = static_cast<std::uint32_t>(pairs[k + 1]);
    const pair_material p{pairs[k + 2], pairs[k + 3], pairs[k + 4]};
    const pair_material* own = mine.own_pair(material_id(a), material_id(b));
    if (own != nullptr ? !same(p, *own)
                       : by_table || !same(p, mine.by_rule(material_id(a), material_id(b))))
      refuse(a, b);
    of_file.set(a, b, p);
  }
  for (const auto& own : mine.own_pairs().entries()) {
    if (of_file.find(own.low, own.high) != nullptr) continue;
    const material_id a{static_cast<std::uint16_t>(own.low)},
        b{static_cast<std::uint16_t>(own.high)};
    if (by_table || !same(own.value, mine.by_rule(a, b))) refuse(own.low, own.high);
  }
}

TALUS_HDF5_INLINE std::string names_of(const std::vector<kept_value>& values) {
  std::string names;
  for (const kept_value& v : values) names += v.name + '\n';
  return names;
}

TALUS_HDF5_INLINE byte_buffer bytes_of_kept(checkpoint_team& team,
                                            const std::vector<kept_value>& values) {
  byte_buffer bytes;
  byte_writer to(bytes);
  for (const kept_value& v : values) {
    if (v.means == kept_value::kind::alike) {
      const auto* at = static_cast<const std::byte*>(v.at);
      bytes.insert(bytes.end(), at, at + v.bytes);
    } else if (v.means == kept_value::kind::sum_of_reals) {
      byte_buffer mine;
      byte_writer(mine).put(v.real_number(v.at));
      double sum = 0;
      for (const byte_buffer& each : team.gather(mine)) sum += byte_reader(each).get<double>();
      to.put(sum);
    } else if (v.means == kept_value::kind::exact_sum) {
      std::array<double, exact_sum::digits + 1> digits, sum{};
      static_cast<exact_sum*>(v.at)->write(digits);
      byte_buffer mine;
      for (const double digit : digits) byte_writer(mine).put(digit);
      for (const byte_buffer& each : team.gather(mine)) {
        byte_reader theirs(each);
        for (double& digit : sum) digit += theirs.get<double>();
      }
      for (const double digit : sum) to.put(digit);
    } else {
      std::uint64_t sum = v.integer(v.at);
      team.sum(std::span(&sum, 1));
      to.put(sum);
    }
  }
  return bytes;
}

TALUS_HDF5_INLINE void put_kept(checkpoint_team& team, const std::string& group,
                                const std::vector<kept_value>& values,
                                std::vector<small_dataset>& out) {
  std::vector<std::uint64_t> kinds;
  for (const kept_value& v : values)
    kinds.insert(kinds.end(), {static_cast<std::uint64_t>(v.means), v.bytes});
  byte_buffer bytes = bytes_of_kept(team, values);
  out.push_back(text_dataset(group + "/names", names_of(values)));
  out.push_back(numbers_dataset<std::uint64_t>(group + "/kinds", kinds, 2));
  out.push_back({group + "/values", number_type::u8, bytes.size(), 1, bytes});
}

TALUS_HDF5_INLINE void require_kept(const checkpoint_reader& in,
                                    const std::vector<kept_value>& values) {
  const std::string theirs = in.text("/kept/names"), mine = names_of(values);
  const auto line = [](std::string names) {
    if (names.empty()) return std::string("nothing");
    names.pop_back();
    for (char& c : names)
      if (c == '\n') c = ',';
    return names;
  };
  if (theirs != mine)
    fail<std::runtime_error>("is of a run that kept {}, and this program keeps {} (world.keep)",
                             line(theirs), line(mine));
}

/// Sets one value from the bytes of a file.
[[gnu::cold]] inline void set_kept(const kept_value& v, int rank, byte_reader& from) {
  if (v.means == kept_value::kind::alike) {
    auto* to = static_cast<std::byte*>(v.at);
    for (std::size_t i = 0; i < v.bytes; ++i) to[i] = from.get<std::byte>();
  } else if (v.means == kept_value::kind::sum_of_reals) {
    const auto sum = from.get<double>();
    v.set_real(v.at, rank == 0 ? sum : 0);
  } else if (v.means == kept_value::kind::exact_sum) {
    std::array<double, exact_sum::digits + 1> digits;
    for (double& digit : digits) digit = from.get<double>();
    auto& sum = *static_cast<exact_sum*>(v.at);
    sum = {};
    if (rank == 0) sum.read(digits);
  } else {
    const auto sum = from.get<std::uint64_t>();
    v.set_integer(v.at, rank == 0 ? sum : 0);
  }
}

TALUS_HDF5_INLINE void get_kept(const checkpoint_reader& in, const std::string& group, int rank,
                                const std::vector<kept_value>& values) {
  const std::string names = in.text(group + "/names");
  const auto count = static_cast<std::size_t>(std::count(names.begin(), names.end(), '\n'));
  const auto kinds = in.integers(group + "/kinds", count, 2);
  const auto bytes = in.numbers<std::byte>(group + "/values", number_type::u8);
  std::size_t name = 0, first = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t end = names.find('\n', name);
    const std::string own = names.substr(name, end - name);
    const kept_value stored{own, static_cast<kept_value::kind>(kinds[2 * k]), kinds[2 * k + 1],
                            nullptr};
    const std::size_t size = stored.stored_bytes();
    if (size > bytes.size() - first)
      fail<std::runtime_error>("is damaged: it ends within the value '{}'", own);
    for (const kept_value& v : values) {
      if (v.name != own) continue;
      if (stored.means != v.means || stored.bytes != v.bytes)
        fail<std::runtime_error>(
            "is of a run that kept '{}' as another type of value: its type must stay the same",
            own);
      byte_reader from({bytes.data() + first, size});
      set_kept(v, rank, from);
    }
    name = end + 1, first += size;
  }
}

TALUS_HDF5_INLINE void set_kept_in_order(const byte_buffer& bytes, int rank,
                                         const std::vector<kept_value>& values) {
  std::size_t first = 0;
  for (const kept_value& v : values) {
    const std::size_t size = v.stored_bytes();
    if (size > bytes.size() - first) return;  // the others have been named later
    byte_reader from({bytes.data() + first, size});
    set_kept(v, rank, from);
    first += size;
  }
}

TALUS_HDF5_INLINE void put_kept_after_calls(const std::vector<byte_buffer>& all,
                                            std::vector<small_dataset>& out) {
  std::vector<std::uint64_t> sizes;
  byte_buffer bytes;
  for (const byte_buffer& one : all) {
    sizes.push_back(one.size());
    bytes.insert(bytes.end(), one.begin(), one.end());
  }
  if (bytes.empty()) return;
  out.push_back(numbers_dataset<std::uint64_t>("/kept/sizes_after_calls", sizes));
  out.push_back({"/kept/after_calls", number_type::u8, bytes.size(), 1, bytes});
}

TALUS_HDF5_INLINE std::vector<byte_buffer> get_kept_after_calls(const checkpoint_reader& in) {
  std::vector<byte_buffer> all;
  if (!in.has("/kept/sizes_after_calls")) return all;
  const auto bytes = in.numbers<std::byte>("/kept/after_calls", number_type::u8);
  auto from = bytes.begin();
  for (const std::uint64_t size : in.integers("/kept/sizes_after_calls")) {
    if (size > static_cast<std::uint64_t>(bytes.end() - from))
      fail<std::runtime_error>("is damaged: the values of world.keep after call {} are cut off",
                               all.size() + 1);
    const auto to = from + static_cast<std::ptrdiff_t>(size);
    all.emplace_back(from, to), from = to;
  }
  return all;
}

TALUS_HDF5_INLINE std::string sorted_list_text(const char* name, std::vector<std::string> items) {
  std::sort(items.begin(), items.end());
  std::string text;
  for (const std::string& item : items) text += (text.empty() ? "" : ", ") + item;
  return std::string(name) + "<" + text + ">";
}

}  // namespace talus::detail
