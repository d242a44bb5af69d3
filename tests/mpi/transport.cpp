// ranks: 1 2 4
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include <boost/mpi/environment.hpp>

#include "../parallel/transport_laws.hpp"
#include "talus/parallel/as_launched.hpp"

using namespace talus;
using namespace talus::transport_laws;

static_assert(concepts::transport<mpi> && !mpi::link::alone);
static_assert(concepts::transport<as_launched> && !as_launched::link::alone);

int main(int argc, char** argv) {
  const boost::mpi::environment environment(argc, argv, false);
  doctest::Context context(argc, argv);
  if (boost::mpi::communicator{}.rank() != 0) context.setOption("minimal", true);
  return context.run();
}

namespace {
const boost::mpi::communicator& world() {
  static const boost::mpi::communicator all;
  return all;
}
}  // namespace

TEST_CASE("mpi obeys the laws of transports") { obeys_all<mpi>(world().size()); }
TEST_CASE("as_launched obeys the laws of transports") { obeys_all<as_launched>(world().size()); }

TEST_CASE("as_launched is mpi with several processes, else threads or serial as asked") {
  const auto chosen = [](const as_launched::settings& how) {
    std::string text;
    as_launched::launch(how, [&](auto& l) {
      if (l.rank() == 0) text = fmt::format("{} {}", l.transport_name(), l.size());
      l.barrier();
    });
    return text;
  };
  if (world().size() > 1) {
    CHECK(chosen(launch_settings{.default_ranks = 9}) ==
          (world().rank() == 0 ? fmt::format("mpi {}", world().size()) : ""));
  } else {
    CHECK(chosen(launch_settings{}) == "serial 1");
    CHECK(chosen(launch_settings{.default_ranks = 9}) == "serial 1");
    CHECK(chosen(launch_settings{.ranks = 3}) == "threads 3");
    CHECK(chosen({launch_settings{}, world()}) == "mpi 1");
    obeys_all<as_launched>(4);
  }
}

TEST_CASE("mpi: an MPI that was there before is left running") {
  mpi::launch(launch_settings{}, [](auto&) {});
  CHECK(boost::mpi::environment::initialized());
  CHECK(!boost::mpi::environment::finalized());
}

TEST_CASE("mpi: links do not hear each other, nor the user's own messages") {
  std::vector<mpi::link> links;
  links.emplace_back(world());
  links.emplace_back(world());
  links.emplace_back(world(), 17);
  links.emplace_back(world(), 18);
  const int me = world().rank(), next = (me + 1) % world().size();
  const auto foreign = world().isend(next, 0, me);  // on the same communicator, another tag
  std::vector<std::vector<neighbour_message>> neighbour_messages;
  for (auto& l : links) neighbour_messages.push_back(parcels_around(l));
  const auto content = [](std::size_t k, int from, int to) {
    byte_buffer bytes;
    fill(bytes, from, to, static_cast<int>(k), 20 + k);
    return bytes;
  };
  for (std::size_t k = 0; k < links.size(); ++k) {
    for (neighbour_message& p : neighbour_messages[k]) p.out = content(k, me, p.rank);
    links[k].start(neighbour_messages[k]);
  }
  for (std::size_t k = links.size(); k-- > 0;) {  // in reverse order
    links[k].finish(neighbour_messages[k]);
    for (const neighbour_message& p : neighbour_messages[k]) CHECK(p.in == content(k, p.rank, me));
  }
  int from = -1;
  world().recv(boost::mpi::any_source, 0, from);
  CHECK((from + 1) % world().size() == me);
  boost::mpi::request(foreign).wait();
}

TEST_CASE("mpi: a part of the processes, with a tag of its own") {
  const int half = world().rank() % 2;
  const auto part = world().split(half);
  mpi::launch({launch_settings{.ranks = part.size()}, part, 5}, [&](mpi::link& l) {
    CHECK(l.size() == part.size());
    CHECK(l.rank() == part.rank());
    auto neighbour_messages = parcels_around(l);
    for (int step = 0; step < 10; ++step) exchange_unknown(l, neighbour_messages, step);
  });
}

TEST_CASE("mpi: tags have a range") {
  CHECK_THROWS_WITH_AS(mpi::link(world(), -1), doctest::Contains("tag is -1"),
                       std::invalid_argument);
}

TEST_CASE("mpi: a single process throws to its caller") {
  if (world().size() > 1) return;
  CHECK_THROWS_WITH_AS(mpi::launch(launch_settings{.ranks = 4}, [](auto&) {}),
                       doctest::Contains("4 ranks are asked for, but the program runs on 1"),
                       std::invalid_argument);
  CHECK_THROWS_AS(mpi::launch(launch_settings{}, [](auto&) { throw std::range_error("mine"); }),
                  std::range_error);
}
