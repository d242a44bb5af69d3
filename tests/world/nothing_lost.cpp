// Bodies are neither lost nor duplicated: faults of a transport, of ownership and of copies are
// injected, and each ends the run with the id of the body in the step in which it happened.
#include <doctest/doctest.h>

#include <functional>
#include <string>
#include <talus/observe/digest.hpp>
#include <talus/parallel/detail/thread_team.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/world/world.hpp>
#include <thread>

using namespace talus;

namespace {

/// Threads whose messages of unknown size a test may change, drop (0) or duplicate (2).
struct faulty {
  static constexpr const char* name = "faulty";
  using fault = std::function<int(int from, int to, detail::byte_buffer& message)>;
  static inline fault way;

  class link : public threads::link {
    using team = detail::thread_team;

   public:
    link(team& others, int rank) : threads::link(others, rank), team_(&others) {}

    void start(std::span<neighbour_message> neighbour_messages) {
      for (neighbour_message& p : neighbour_messages) {
        const int copies = way ? way(rank(), p.rank, p.out) : 1;
        for (int k = 1; k < copies; ++k) team_->send(rank(), p.rank, detail::byte_buffer(p.out));
        if (copies > 0) team_->send(rank(), p.rank, std::move(p.out));
        p.out.clear();
      }
    }
    void finish(std::span<neighbour_message> neighbour_messages) {
      team_->receive(rank(), neighbour_messages,
                     [](neighbour_message& p, detail::byte_buffer& message) {
                       p.in = std::move(message);
                       p.out.clear();
                     });
    }

   private:
    team* team_;
  };

  template <class Main>
  static void launch(const launch_settings& how, Main&& main) {
    detail::thread_team team(how.ranks);
    std::vector<std::thread> all;
    for (int r = 0; r < how.ranks; ++r)
      all.emplace_back([&, r] {
        try {
          link mine(team, r);
          main(mine);
        } catch (...) {
          team.end_with(std::current_exception());
        }
        team.leave(r);
      });
    for (auto& each : all) each.join();
    team.rethrow();
  }
};

using row = scenario<bodies<sphere>, transport<faulty>, decomposition<grid<dynamic, 1, 1>>>;
using row_world = world<row>;

/// Spheres in a row of domains of length 10, each about to cross the boundary on its right in steps
/// 5, 15, ...: body 0x4000000000000000 + r goes from rank r to rank r + 1.
void set_up(row_world& w) {
  const auto m = w.material({});
  for (int r = 0; r + 1 < w.ranks(); ++r)
    w.add_if_local(body{.shape = sphere{0.5},
                        .position = {10.0 * r + 9.46, 0, 0},
                        .material = m,
                        .velocity = {1, 0, 0}});
}
/// 40 steps on `ranks` ranks; `edit` is called before each. The message that ended it, or "".
std::string run(int ranks, std::function<void(row_world&)> edit = {}) {
  try {
    faulty::launch({.ranks = ranks}, [&](faulty::link& link) {
      row_world w(link, {.lower = {0}, .upper = {10.0 * ranks}});
      set_up(w);
      w.synchronize();
      for (int k = 0; k < 40; ++k) {
        if (edit) edit(w);
        w.step(0.1);
      }
      const auto all = w.audit();
      CHECK(all.bodies == static_cast<std::uint64_t>(ranks - 1));
    });
  } catch (const std::exception& e) {
    return e.what();
  }
  return "";
}
/// The same with a fault in the message in which rank 0 migrates its body to rank 1.
std::string run_with(std::function<int(detail::byte_buffer&)> fault) {
  std::uint64_t handed_over = 0;
  faulty::way = [&](int from, int to, detail::byte_buffer& message) {
    if (from != 0 || to != 1 || message.size() < sizeof(detail::message_header)) return 1;
    detail::message_header head;
    std::memcpy(&head, message.data(), sizeof head);
    if (head.sum == 0 ||
        head.handed_over.bodies == std::exchange(handed_over, head.handed_over.bodies))
      return 1;
    return fault(message);
  };
  const std::string text = run(2);
  faulty::way = {};
  return text;
}

bool says(const std::string& text, std::initializer_list<const char*> words) {
  bool all = true;
  for (const char* word : words) all = all && text.find(word) != std::string::npos;
  if (!all) MESSAGE("it says: ", text);
  return all;
}

const char* const first = "body 0x4000000000000000";

}  // namespace

TEST_CASE("without a fault nothing is said, for any number of ranks") {
  for (const int ranks : {2, 3, 4, 9}) CHECK(run(ranks) == "");
}

TEST_CASE("a handover that is dropped names the body, its place, both ranks and the step") {
  CHECK(says(run_with([](auto&) { return 0; }),
             {"rank 1 waits for message", "of rank 0 in step 6", "one is lost", first,
              "last seen at (9.96, 0, 0)", "rank 0 handed over to rank 1"}));
}

TEST_CASE("a handover that comes twice names the body, and does not make two of it") {
  CHECK(says(run_with([](auto&) { return 2; }),
             {"rank 1 waits for message", "of rank 0 in step 6", "came a second time", first,
              "rank 0 handed over to rank 1"}));
}

TEST_CASE("a handover in which any byte changed, or the end is cut off, is refused with its body") {
  const std::size_t head = sizeof(detail::message_header);
  for (const std::size_t at : {head, head + 9, head + 40, head + 100}) {
    CAPTURE(at);
    CHECK(says(run_with([&](auto& message) {
                 message.at(at) ^= std::byte{4};
                 return 1;
               }),
               {"rank 0 hands over", first, "to rank 1 in step 6 came changed"}));
  }
  CHECK(says(run_with([](auto& message) { return message.resize(message.size() - 8), 1; }),
             {"rank 0 hands over", first, "to rank 1 in step 6 came changed"}));
  CHECK(says(run_with([](auto& message) { return message.resize(5), 1; }),
             {"rank 1 waits for message", "what came has 5 bytes, and no head"}));
}

TEST_CASE("other messages that are cut, empty, or carry more than they say end the run as well") {
  for (const int size : {0, 20, 40, 60}) {
    CAPTURE(size);
    int count = 0;
    faulty::way = [&](int from, int, detail::byte_buffer& message) {
      if (from == 0 && ++count > 8 && message.size() > static_cast<std::size_t>(size))
        message.resize(static_cast<std::size_t>(size));
      return 1;
    };
    CHECK(run(2) != "");
    faulty::way = {};
  }
  faulty::way = [&](int from, int, detail::byte_buffer& message) {
    detail::message_header head;
    if (from != 0 || message.size() < sizeof head) return 1;
    std::memcpy(&head, message.data(), sizeof head);
    if (head.number > 8 && head.sum == 0) message.resize(message.size() + 8);
    return 1;
  };
  CHECK(says(run(2), {"the message of rank 0 to rank 1 in step", "is longer than its content"}));
  faulty::way = {};
}

TEST_CASE("a body that a rank counts as handed over, and did not pack, is named as lost") {
  CHECK(says(run(2,
                 [](row_world& w) {
                   if (w.rank() == 0 && w.steps() == 3)
                     talus::detail::state_of(w).neighbours[0].channel.given.add(system_id{77});
                 }),
             {"body 0x4d was lost on the way from rank 0 to rank 1 in step 3",
              "1 bodies were handed over so far, and 0 came"}));
}

TEST_CASE("a body that vanishes from a rank, or appears there, is named by that rank") {
  CHECK(says(run(2,
                 [](row_world& w) {
                   auto& store = talus::detail::state_of(w).of<sphere>().movable;
                   if (w.rank() == 0 && w.steps() == 3) store.remove_local(0);
                 }),
             {first, "rank 0 should own 1 bodies, and owns 0",
              "(last seen at (9.56, 0, 0)) is lost in step 4"}));
  const auto twice = [](row_world& w) {
    auto& store = talus::detail::state_of(w).of<sphere>().movable;
    if (w.rank() != 0 || w.steps() != 3) return;
    store.insert_local();
    store.each_column([](auto& c) { c[1] = c[0]; });
    talus::detail::state_of(w).changed = true;
  };
  CHECK(says(run(2, twice), {first, "twice"}));
  CHECK(says(run(2,
                 [](row_world& w) {
                   auto& store = talus::detail::state_of(w).of<sphere>().movable;
                   if (w.rank() == 0 && w.steps() == 3)
                     store.id[0] = system_id{5}, talus::detail::state_of(w).changed = true;
                 }),
             {"step 4", "rank 0 should own 1 bodies, and owns 1", "changed its id"}));
}

namespace {

/// Puts the body of rank 0 on `rank` as well, with a count that hides it.
void own_too(row_world& w, int rank, real x) {
  if (w.rank() != rank) return;
  auto& s = talus::detail::state_of(w);
  auto& store = s.of<sphere>().movable;
  const std::size_t i = store.insert_local();
  store.id[i] = detail::id_of_attempt(0);
  store.position[i] = {x, 0, 0};
  store.velocity[i] = {0, 0, 0};
  store.angular_velocity[i] = {0, 0, 0};
  store.shape[i] = sphere{0.5};
  store.inverse_mass[i] = 1;
  s.owned.add(store.id[i]);
  s.changed = true;
}

}  // namespace

TEST_CASE("a body with two owners is named with both, when copies are made or when it arrives") {
  CHECK(says(run(2,
                 [](row_world& w) {
                   if (w.steps() == 3) own_too(w, 1, 10.2);
                 }),
             {first, "has two owners in step 3, rank ", "0", "1", "it is there twice"}));
  // Out of reach of the boundary, so no other rank notices until the first one arrives.
  CHECK(says(run(2,
                 [](row_world& w) {
                   if (w.steps() == 3) own_too(w, 1, 15);
                 }),
             {first, "twice"}));
}

TEST_CASE("a body handed over to a rank that sees another owner names both ranks and the place") {
  CHECK(says(run(3,
                 [](row_world& w) {
                   if (w.rank() != 1 || w.steps() != 2) return;
                   auto& s = talus::detail::state_of(w);
                   s.own = row_world::domain_type(grid<dynamic, 1, 1>{.lower = {3}, .upper = {33}},
                                                  1, 3);
                 }),
             {"rank 0 handed body", "over to rank 1 as its owner in step", "belongs to rank 0"}));
}

TEST_CASE("copies that are not those which the owner tells of are named with the body") {
  const auto drop = [](row_world& w) {
    auto& s = talus::detail::state_of(w);
    auto& store = s.of<sphere>().movable;
    if (w.rank() == 1 && w.steps() == 3 && store.size() > store.locals) {
      store.resize(store.size() - 1);
      --s.neighbours[0].copies[0];
    }
  };
  CHECK(says(run(2, drop), {"the copies on rank 1 are not those that their owner, rank 0, tells of",
                            "0 instead of 1", first, "is missing"}));
  CHECK(says(
      run(2,
          [](row_world& w) {
            auto& store = talus::detail::state_of(w).of<sphere>().movable;
            if (w.rank() == 1 && w.steps() == 3 && store.size() > store.locals)
              store.id[store.locals] = system_id{9};
          }),
      {"the copies on rank 1 are not those that their owner, rank 0, tells of", "1 instead of 1"}));
}

TEST_CASE("an audit counts the bodies of all ranks, and names one that is lost or doubled") {
  CHECK(says(run(4,
                 [](row_world& w) {
                   if (w.steps() == 39) own_too(w, 3, 38);
                 }),
             {first, "is there twice after 40 steps", "own 4 bodies, but 3 were created",
              "it is owned by rank 1 at (13.46, 0, 0) and by rank 3 at (38, 0, 0)"}));
  CHECK(says(run(4,
                 [](row_world& w) {
                   if (w.steps() != 39 || w.rank() != 1) return;
                   auto& s = talus::detail::state_of(w);
                   s.owned.remove(s.of<sphere>().movable.id[0]);
                   s.of<sphere>().movable.remove_local(0);
                   s.changed = true;
                 }),
             {first, "is lost after 40 steps", "own 2 bodies, but 3 were created"}));
  faulty::launch({.ranks = 3}, [&](faulty::link& link) {
    row_world w(link, {.lower = {0}, .upper = {30}});
    set_up(w);
    w.exclusive(2, [&] { w.add(body{.shape = sphere{1}, .position = {25, 0, 0}}); });
    CHECK(w.audit().bodies == 3);
    w.simulate({.steps = 10, .dt = 0.1});
    CHECK(w.destroy_if([](const auto& b) { return b.position()[0] > 24; }) ==
          (link.rank() == 2 ? 1 : 0));
    CHECK(w.audit().bodies == 2);
    if (link.rank() == 1) w.destroy(handle<sphere>{detail::id_of_attempt(0)});
    CHECK(w.audit().bodies == 1);
    w.exclusive(0, [&] {
      CHECK_THROWS_WITH_AS((void)w.audit(), doctest::Contains("audit"), std::runtime_error);
    });
  });
}
