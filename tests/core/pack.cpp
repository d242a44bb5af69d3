// Packs of any number of lanes compute in each lane the result of a single number, to the bit; rows
// of four numbers convert to packs and back.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <talus/core/pack.hpp>
#include <talus/core/pack_rows.hpp>
#include <talus/core/pack_vector.hpp>
#include <talus/core/random.hpp>

using namespace talus;
using namespace talus::detail;

namespace {

template <class T, int N>
struct lanes {
  using number = T;
  static constexpr int count = N;
};

template <class Pack>
lane_of<Pack> lane(const Pack& p, int k) {
  lane_of<Pack> all[lanes_of<Pack>];
  std::memcpy(all, &p, sizeof p);
  return all[k];
}
template <class Pack>
Pack drawn(random_stream& random) {
  lane_of<Pack> all[lanes_of<Pack>];
  for (auto& x : all) x = static_cast<lane_of<Pack>>(random.uniform(-1.0, 1.0));
  Pack p;
  std::memcpy(&p, all, sizeof p);
  return p;
}

}  // namespace

TEST_CASE_TEMPLATE("lanes are computed as single numbers", Lanes, lanes<double, 1>,
                   lanes<double, 2>, lanes<double, 4>, lanes<double, 8>, lanes<float, 1>,
                   lanes<float, 4>, lanes<float, 8>, lanes<float, 16>) {
  using number = typename Lanes::number;
  using several = pack<number, Lanes::count>;
  static_assert(sizeof(several) == Lanes::count * sizeof(number));
  static_assert(lanes_of<several> == Lanes::count);
  static_assert(std::is_same_v<lane_of<several>, number>);
  random_stream random(4, 1);
  for (int n = 0; n < 300; ++n) {
    const auto a = drawn<several>(random), b = drawn<several>(random), c = drawn<several>(random);
    const several result = (a * b + c) / (b - 3 * c), root = square_root(a * a + b * b);
    const several most = larger(a, b), same = every_lane<several>(lane(a, 0));
    const several chosen = a < b ? c : a;
    const unsigned bits = bits_of(a < b);
    const pack_vector<several> v{a, b, c}, w{b, c, a}, across = crossed(v, w);
    for (int k = 0; k < Lanes::count; ++k) {
      const number x = lane(a, k), y = lane(b, k), z = lane(c, k);
      CHECK(lane(result, k) == (x * y + z) / (y - 3 * z));
      CHECK(lane(root, k) == std::sqrt(x * x + y * y));
      CHECK(lane(most, k) == std::max(x, y));
      CHECK(lane(same, k) == lane(a, 0));
      CHECK(lane(chosen, k) == (x < y ? z : x));
      CHECK((bits >> k & 1u) == (x < y ? 1u : 0u));
      CHECK(lane(dot(v, w), k) == x * y + y * z + z * x);
      CHECK(lane(across.z, k) == x * z - y * y);
    }
    CHECK((bits >> 1 >> (Lanes::count - 1)) == 0u);
  }
}

TEST_CASE_TEMPLATE("rows go to packs and back, thing 0 last", Lanes, lanes<double, 1>,
                   lanes<double, 8>, lanes<float, 1>, lanes<float, 16>) {
  using number = typename Lanes::number;
  using several = pack<number, Lanes::count>;
  struct thing {
    vector3<number> v;
    number more;
  };
  std::array<thing, Lanes::count> things;
  for (int k = 0; k < Lanes::count; ++k) {
    const auto x = static_cast<number>(10 * k);
    things[static_cast<std::size_t>(k)] = {{x, x + 1, x + 2}, x + 3};
  }
  const auto row = [&](int k) {
    auto& t = things[static_cast<std::size_t>(k)];
    return row_of(t, t.v);
  };
  auto rows = gather<several>(row);
  for (int k = 0; k < Lanes::count; ++k) {
    CHECK(lane(rows.x, k) == 10 * k);
    CHECK(lane(rows.y, k) == 10 * k + 1);
    CHECK(lane(rows.z, k) == 10 * k + 2);
    CHECK(lane(rows.w, k) == 10 * k + 3);
  }
  rows.y = rows.y + 5;
  scatter(rows, row);
  for (int k = 0; k < Lanes::count; ++k) {
    const thing& t = things[static_cast<std::size_t>(k)];
    CHECK(t.v == vector3<number>(number(10 * k), number(10 * k + 6), number(10 * k + 2)));
    CHECK(t.more == 10 * k + 3);
  }
  scatter(rows, [&](int) { return row(0); });
  CHECK(things[0].v == vector3<number>(0, 6, 2));
}
