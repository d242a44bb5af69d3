// Contacts of manifolds that are solved eight at a time, against each contact solved by itself.
#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <talus/constraint/general_contact.hpp>
#include <talus/constraint/manifold_row.hpp>
#include <talus/contact/law.hpp>

using namespace talus;
using namespace talus::detail;

namespace {

using law = hard_contact<coulomb_friction, newton_restitution, split_correction>;
template <bool Paired>
using contact_of = general_contact<law, contact_side::tensor,
                                   Paired ? contact_side::tensor : contact_side::immovable>;

class random_numbers {
 public:
  real between(real low, real high) { return std::uniform_real_distribution<>(low, high)(random_); }
  vec3 vector(real size) {
    return {between(-size, size), between(-size, size), between(-size, size)};
  }

 private:
  std::mt19937_64 random_{3};
};

struct problem {
  solver_state state;
  random_numbers random;
  std::vector<std::size_t> first;  ///< contact of each patch

  explicit problem(std::size_t bodies) {
    state.bodies.resize(bodies), state.shift.resize(bodies);
    state.turn.resize(bodies), state.tensors.resize(bodies);
    for (std::size_t i = 0; i < bodies; ++i) {
      const real m = random.between(0.5, 2);
      state.bodies[i] = {random.vector(1), m, random.vector(1), 0};
      state.shift[i] = {vec3(0, 0, 0), m};
      mat3 t;
      for (int j = 0; j < 9; ++j) t(j / 3, j % 3) = random.between(-0.5, 0.5);
      state.tensors[i] = t * t.transpose();
      for (int j = 0; j < 3; ++j) state.tensors[i](j, j) += 1;
    }
  }
  /// Some contacts of a on b with one normal. A level one has zeros of both signs.
  template <class Row>
  void add(Row& row, std::int32_t a, std::int32_t b, int contacts, bool level = false) {
    using contact = std::remove_cvref_t<decltype(row[0])>;
    vec3 normal = random.vector(1);
    if (level) normal[2] = 0;
    normal.normalize();
    const vec3 offset = random.vector(1);
    first.push_back(row.size());
    for (int k = 0; k < contacts; ++k) {
      contact c;
      c.a = a, c.b = b, c.normal = normal;
      if (level) c.normal[2] = random.between(0, 1) < 0.5 ? 0. : -0.;
      c.arm_a = random.vector(1);
      c.arm_b = c.arm_a + offset;
      c.friction = random.between(0, 1) < 0.2 ? 0 : random.between(0.1, 1);
      c.target_velocity = random.between(0, 1) < 0.5 ? 0 : random.between(-0.5, 0.5);
      c.correction_rate = random.between(-0.1, 0.3);
      if (random.between(0, 1) < 0.7)
        c.load_impulse(random.between(0, 0.5) * normal + random.vector(0.3));
      row.add(c, true, true);
    }
  }
};

/// The contacts of patches one by one. Watched sweeps go there and back over patches of more than
/// four contacts.
template <class Contact>
struct one_by_one {
  const std::vector<std::size_t>& first;
  plain_vector<Contact> contacts;

  template <class Note>
  void sweep(solver_state& s, bool forward, bool watched, Note&& note) {
    for (std::size_t n = 0; n < first.size(); ++n) {
      const std::size_t patch = forward ? n : first.size() - 1 - n, from = first[patch];
      const std::size_t end = patch + 1 < first.size() ? first[patch + 1] : contacts.size();
      const std::size_t last = end - from - 1;
      const bool both_ways = last >= 4 && watched;
      const auto visit = [&](std::size_t k, bool notes) {
        const std::size_t i = forward ? from + k : end - 1 - k;
        const auto d = contacts[i].relax(s);
        contacts[i].apply(s, d);
        if (notes) note(i, contacts[i].speed_of(d));
      };
      for (std::size_t k = 0; k <= last; ++k) visit(k, !both_ways || k == last);
      for (std::size_t k = last; both_ways && k-- > 0;) visit(k, true);
    }
  }
  void sweep(solver_state& s, bool forward) {
    sweep(s, forward, false, [](std::size_t, real) {});
  }
};

/// Sweeps in both directions and of the correction: in blocks, and one by one.
template <bool Paired>
void check(problem& p, manifold_row<contact_of<Paired>>& row) {
  contact_row<contact_of<Paired>> all;
  for (std::size_t i = 0; i < row.size(); ++i) all.add(row[i], true, true);
  solver_state one = p.state, other = p.state;
  row.prepare(one), all.prepare(other);
  row.apply(one), all.apply(other);
  one_by_one<contact_of<Paired>> plain{p.first, {}};
  for (std::size_t i = 0; i < all.size(); ++i) plain.contacts.push_back(all[i]);
  std::size_t noted = 0, changed = 0;
  real difference = 0, kinds[3] = {0, 0, 0};
  const auto compare = [&] {
    for (std::size_t i = 0; i < one.bodies.size(); ++i) {
      difference = std::max(difference, (one.bodies[i].v - other.bodies[i].v).norm());
      difference = std::max(difference, (one.bodies[i].w - other.bodies[i].w).norm());
      difference = std::max(difference, (one.shift[i].v - other.shift[i].v).norm());
      difference = std::max(difference, (one.turn[i].w - other.turn[i].w).norm());
      CHECK(one.bodies[i].inverse_mass == other.bodies[i].inverse_mass);
    }
    for (std::size_t i = 0; i < row.size(); ++i)
      difference = std::max(difference, (row[i].r - plain.contacts[i].r).norm());
  };
  row.forward(one), plain.sweep(other, true);
  compare();
  row.backward(one), plain.sweep(other, false);
  compare();
  row.forward(one), plain.sweep(other, true);
  std::vector<real> changes(row.size(), 0);
  row.backward_watched(one, 1e-3,
                       [&](std::size_t i, real change) { changes[i] = change, ++noted; });
  plain.sweep(other, false, true, [&](std::size_t i, real change) {
    if (change <= 1e-3) return;
    ++changed;
    CHECK(changes[i] == doctest::Approx(change));
  });
  compare();
  CHECK(noted == changed);
  CHECK(noted > row.size() / 12);
  for (std::size_t i = 0; i < all.size(); ++i) all.edit(i, [&](auto& c) { c = plain.contacts[i]; });
  for (int k = 0; k < 3; ++k) row.correct(one), all.correct(other);
  compare();
  for (std::size_t i = 0; i < row.size(); ++i) {
    const vec3& r = row[i].r;
    const real slip = std::hypot(r[1], r[2]) - row[i].friction * r[0];
    ++kinds[r[0] == 0 ? 0 : std::abs(slip) < 1e-9 ? 1 : 2];
  }
  for (const real of_kind : kinds) CHECK(of_kind > 0.01 * static_cast<real>(row.size()));
  CHECK(difference < 1e-10);
}

}  // namespace

TEST_CASE_TEMPLATE("patches apart are solved in blocks as one by one", Paired, std::true_type,
                   std::false_type) {
  constexpr std::int32_t manifolds = 301;  // blocks that are filled in part
  problem p(2 * manifolds);
  manifold_row<contact_of<Paired::value>> row;
  for (std::int32_t k = 0; k < manifolds; ++k)
    p.add(row, 2 * k, Paired::value ? 2 * k + 1 : -1, Paired::value ? 1 + k % 7 : 1 + k % 4);
  check<Paired::value>(p, row);
}

TEST_CASE_TEMPLATE("a patch that is alone has the bits that it has beside others", Paired,
                   std::true_type, std::false_type) {
  for (int depth = 1; depth <= 4; ++depth) {
    problem p(16);
    manifold_row<contact_of<Paired::value>> many;
    for (std::int32_t k = 0; k < 8; ++k)
      p.add(many, 2 * k, Paired::value ? 2 * k + 1 : -1,
            k % 2 == 0 && (Paired::value || depth <= 4) ? depth : 1 + k % 4);
    for (std::size_t patch = 0; patch < 8; ++patch) {
      manifold_row<contact_of<Paired::value>> all = many, single;
      const std::size_t from = p.first[patch], end = patch < 7 ? p.first[patch + 1] : many.size();
      for (std::size_t i = from; i < end; ++i) single.add(many[i], true, true);
      solver_state one = p.state, other = p.state;
      std::vector<real> changes[2];
      const auto solve = [&](auto& row, solver_state& s, std::vector<real>& noted) {
        row.prepare(s), row.apply(s);
        for (int k = 0; k < 6; ++k) k % 2 == 0 ? row.forward(s) : row.backward(s);
        const std::size_t begin = row.size() == single.size() ? 0 : from;
        row.backward_watched(s, 0, [&](std::size_t i, real change) {
          if (i >= begin && i - begin < end - from) noted.push_back(change);
        });
        for (int k = 0; k < 3; ++k) row.correct(s);
      };
      solve(single, one, changes[0]), solve(all, other, changes[1]);
      CHECK(changes[0] == changes[1]);
      for (const std::size_t i : {2 * patch, 2 * patch + 1}) {
        CHECK(one.bodies[i].v == other.bodies[i].v);
        CHECK(one.bodies[i].w == other.bodies[i].w);
        CHECK(one.shift[i].v == other.shift[i].v);
        CHECK(one.turn[i].w == other.turn[i].w);
      }
      for (std::size_t i = from; i < end; ++i) CHECK(single[i - from].r == all[i].r);
    }
  }
}

TEST_CASE("normals that differ in the sign of a zero alone are one") {
  constexpr std::int32_t manifolds = 100;
  problem p(2 * manifolds);
  manifold_row<contact_of<true>> row;
  for (std::int32_t k = 0; k < manifolds; ++k) p.add(row, 2 * k, 2 * k + 1, 1 + k % 7, true);
  check<true>(p, row);
}

TEST_CASE("what all patches share and cannot move is left as it is") {
  constexpr std::int32_t manifolds = 100;
  problem p(manifolds + 1);
  solver_body& ground = p.state.bodies[manifolds];
  ground.inverse_mass = p.state.shift[manifolds].inverse_mass = 0;
  for (int j = 0; j < 9; ++j) p.state.tensors[manifolds](j / 3, j % 3) = 0;
  manifold_row<contact_of<true>> row;
  for (std::int32_t k = 0; k < manifolds; ++k) p.add(row, k, manifolds, 1 + k % 4);
  check<true>(p, row);
}

TEST_CASE("a body in a hundred patches is hit by each once") {
  constexpr std::int32_t manifolds = 100;
  problem p(manifolds + 1);
  manifold_row<contact_of<true>> row;
  for (std::int32_t k = 0; k < manifolds; ++k) p.add(row, k, manifolds, 1 + k % 4);
  const auto momentum = [&](const solver_state& s) {
    vec3 sum{0, 0, 0};
    for (const solver_body& b : s.bodies) sum += b.v / b.inverse_mass;
    return sum;
  };
  const vec3 before = momentum(p.state);
  row.prepare(p.state);
  row.apply(p.state);
  for (int k = 0; k < 3; ++k) row.forward(p.state), row.backward(p.state);
  CHECK((momentum(p.state) - before).norm() < 1e-10);
}

TEST_CASE(
    "patches that share a body are planned into blocks in their order, eight at most in one") {
  random_numbers random;
  for (const int bodies : {2, 3, 20, 500}) {
    ordered_planner plan;
    plan.clear();
    std::vector<std::int64_t> last(static_cast<std::size_t>(bodies), -1);  // block of each body
    std::vector<int> filled(4000, 0);
    for (int k = 0; k < 2000; ++k) {
      const int a = static_cast<int>(random.between(0, bodies)) % bodies;
      const int b = (a + 1 + static_cast<int>(random.between(0, bodies - 1))) % bodies;
      const bool alone = a == b || random.between(0, 1) < 0.2;
      const auto slot = static_cast<std::int64_t>(plan.place(a, alone ? -1 : b)), block = slot / 8;
      CHECK(slot % 8 == filled[static_cast<std::size_t>(block)]++);
      CHECK(block > last[static_cast<std::size_t>(a)]);
      last[static_cast<std::size_t>(a)] = block;
      if (alone) continue;
      CHECK(block > last[static_cast<std::size_t>(b)]);
      last[static_cast<std::size_t>(b)] = block;
    }
    // No more blocks than necessary, if most manifolds are independent.
    if (bodies == 500)
      CHECK(std::count_if(filled.begin(), filled.end(), [](int n) { return n > 0; }) < 300);
    CHECK(*std::max_element(filled.begin(), filled.end()) <= 8);
  }
}

TEST_CASE("a chain of patches is solved in the order of the list") {
  constexpr std::int32_t bodies = 150;  // longer than there are open blocks
  problem p(bodies);
  manifold_row<contact_of<true>> row;
  for (std::int32_t k = 0; k + 1 < bodies; ++k) p.add(row, k, k + 1, 1 + k % 4);
  check<true>(p, row);
}

TEST_CASE("sweeps by groups of islands give the bits of sweeps over all contacts") {
  // Islands of three bodies whose contacts lie apart in the list; body 0 cannot move and touches
  // all.
  constexpr std::size_t islands = 200, bodies = 1 + 3 * islands;
  using contact = contact_of<true>;
  problem p(bodies);
  p.state.bodies[0].inverse_mass = 0, p.state.shift[0].inverse_mass = 0;
  p.state.tensors[0].setZero();
  manifold_row<contact> whole;
  for (std::int32_t level = 0; level < 3; ++level)
    for (std::int32_t k = 0; k < static_cast<std::int32_t>(islands); ++k) {
      const std::int32_t lower = level == 0 ? 0 : 3 * k + level;
      p.add(whole, lower, 3 * k + level + 1, 1 + (k + level) % 6);
    }
  manifold_row<contact> by_groups = whole;
  solver_state other = p.state;
  other.groups.find(bodies, 50, [&](auto&& f) {
    by_groups.each_manifold([&](const contact& c) { c.a == 0 ? f(c.b, -1) : f(c.a, c.b); });
  });
  REQUIRE(other.groups.size() == 12);
  whole.prepare(p.state), by_groups.prepare(other);
  for (int k = 0; k < 6; ++k) k % 2 == 0 ? whole.forward(p.state) : whole.backward(p.state);
  for (int k = 0; k < 3; ++k) whole.correct(p.state);
  for (std::size_t g = 0; g < other.groups.size(); ++g) {
    for (int k = 0; k < 6; ++k) by_groups.sweep_group(g, k % 2 == 0, other);
    for (int k = 0; k < 3; ++k) by_groups.correct_group(g, k == 0, other);
  }
  for (std::size_t i = 0; i < bodies; ++i) {
    CHECK(p.state.bodies[i].v == other.bodies[i].v);
    CHECK(p.state.bodies[i].w == other.bodies[i].w);
    CHECK(p.state.shift[i].v == other.shift[i].v);
    CHECK(p.state.turn[i].w == other.turn[i].w);
  }
  for (std::size_t i = 0; i < whole.size(); ++i) CHECK(whole[i].r == by_groups[i].r);
}

TEST_CASE("impulses are stored_entry in the world, whatever the sign of a zero in the normal") {
  plain_vector<contact_of<true>> row;
  for (const real zero : {0.0, -0.0, 0.0}) {
    auto& c = row.emplace_back();
    c.normal = {1, 0, zero}, c.friction = 1;
    c.load_impulse(vec3(2, 0.5, 0.25));
  }
  plain_vector<contact_key> keys(3);
  for (std::size_t k = 0; k < 3; ++k) keys[k].feature = k;
  contact_history history;
  store_impulses(history, keys, plain_vector<history_place*>(3, nullptr), row);
  for (const auto& kept : history.entries()) CHECK(kept.memory == vec3(2, 0.5, 0.25));
}

TEST_CASE("rows of four numbers end within the object that they are read from") {
  const auto inside = [](const auto& whole, const auto& part) {
    const auto row = row_of(whole, part);
    const char* const begin = reinterpret_cast<const char*>(&whole);
    return row.begin >= begin && row.begin + 4 * sizeof(part[0]) <= begin + sizeof(whole);
  };
  const contact_of<true> c;
  CHECK(inside(c, c.normal));
  CHECK(inside(c, c.arm_a));
  CHECK(inside(c, c.arm_b));
  CHECK(inside(c, c.r));
  CHECK(&c.target_velocity == &c.r[0] + 3);
  const solver_body b;
  CHECK(inside(b, b.v));
  CHECK(inside(b, b.w));
  const body_shift shift;
  CHECK(inside(shift, shift.v));
  const body_turn turn;
  CHECK(inside(turn, turn.w));
}
