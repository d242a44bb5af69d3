// ranks: 1
// timeout: 300
// A failing job ends within seconds, with one message and an error code. The test starts such jobs
// itself: four processes of this program, each with the name of a case as its argument.
#define DOCTEST_CONFIG_IMPLEMENT
#include <sys/wait.h>
#include <unistd.h>

#include <doctest/doctest.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <regex>
#include <sstream>
#include <string>
#include <thread>

#include "../parallel/transport_laws.hpp"
#include "talus/core/run_lock.hpp"
#include "talus/io/run_signals.hpp"
#include "talus/parallel/as_launched.hpp"
#include "talus/parallel/grid.hpp"
#include "talus/scene/run.hpp"

using namespace talus;
using namespace talus::transport_laws;
using namespace std::chrono_literals;

namespace {

std::string self;

/// Exchanges with neighbours and all ranks, without end or until `when` throws.
template <class Link>
void work(Link& l, const std::function<void(int step)>& when) {
  auto neighbour_messages = parcels_around(l);
  for (int step = 0;; ++step) {
    when(step);
    exchange_unknown(l, neighbour_messages, step);
    exchange_fixed(l, neighbour_messages, step);
  }
}

template <class Transport>
void fails_on(const std::vector<int>& ranks, launch_settings how = {}) {
  Transport::launch(how, [&](auto& l) {
    work(l, [&](int step) {
      if (step == 30 && std::ranges::count(ranks, l.rank()))
        throw std::runtime_error("a body left the domain");
    });
  });
}

/// The file of a run, and that of its lock.
std::string locked_file() { return self + ".locked"; }
std::string lock_of_file() { return locked_file() + ".lock"; }

/// Rank 0 holds a lock, and hears SIGTERM as a run with --checkpoint does; rank 2 calls `end`.
void beside_a_lock(void (*end)()) {
  mpi::launch(launch_settings{}, [&](auto& l) {
    const detail::listen_to_signals heard;
    std::optional<detail::run_lock> lock;
    if (l.rank() == 0) lock.emplace(locked_file(), "the file");
    work(l, [&](int step) {
      if (step == 30 && l.rank() == 2) end();
    });
  });
}

std::string results_file() { return self + ".json"; }

/// The last rank calls exit(3) after step 3 of a run whose results rank 0 has locked.
void exits_in_a_run() {
  using scene = scenario<bodies<sphere>, decomposition<grid<dynamic, 1>>, transport<mpi>>;
  std::string words[] = {"balls", "--quiet", "--steps", "5", "--json", results_file()};
  char* arguments[6];
  for (int k = 0; k < 6; ++k) arguments[k] = words[k].data();
  (void)talus::run<scene>(6, arguments, [](auto& w, const auto& options) {
    w.decompose({.lower = {-9}, .upper = {9}});
    w.after_each_step([&] {
      if (w.steps() == 3 && w.rank() == w.ranks() - 1) std::exit(3);
    });
    w.simulate({.steps = options.steps, .dt = options.dt});
  });
}

const std::map<std::string, std::function<void()>> jobs = {
    {"one", [] { fails_on<mpi>({2}); }},
    {"root", [] { fails_on<as_launched>({0}); }},
    {"two",
     [] {
       fails_on<mpi>({1, 3});
     }},
    {"all",
     [] {
       fails_on<mpi>({0, 1, 2, 3});
     }},
    {"all_but_root",
     [] {
       fails_on<as_launched>({1, 2, 3});
     }},
    {"at_once",
     [] {
       mpi::launch(launch_settings{}, [](auto&) { throw std::runtime_error("a body left"); });
     }},
    {"root_computes",  // without calling MPI
     [] {
       mpi::launch(launch_settings{}, [](auto& l) {
         if (l.rank() == 0) std::this_thread::sleep_for(60s);
         throw std::runtime_error("a body left");
       });
     }},
    {"in_collectives",
     [] {
       mpi::launch(launch_settings{}, [](auto& l) {
         for (int i = 0;; ++i) {
           if (i == 20 && l.rank() == 1) throw std::runtime_error("a body left");
           (void)l.gather_all(byte_buffer(100));
         }
       });
     }},
    {"returns",  // while the others exchange
     [] {
       mpi::launch(launch_settings{}, [](auto& l) {
         auto neighbour_messages = parcels_around(l);
         for (int step = 0; step < 30 || l.rank() != 2; ++step)
           exchange_unknown(l, neighbour_messages, step);
       });
     }},
    {"returns_fixed",
     [] {
       mpi::launch(launch_settings{}, [](auto& l) {
         auto neighbour_messages = parcels_around(l);
         for (int step = 0; step < 30 || l.rank() != 0; ++step)
           exchange_fixed(l, neighbour_messages, step);
       });
     }},
    {"returns_before_a_meeting",
     [] {
       mpi::launch(launch_settings{}, [](auto& l) {
         for (int i = 0; i < 9 || l.rank() != 3; ++i) (void)l.gather_all(byte_buffer(100));
       });
     }},
    {"returns_before_a_reduction",
     [] {
       mpi::launch(launch_settings{}, [](auto& l) {
         for (int i = 0; i < 9 || l.rank() != 1; ++i) {
           double one = 1;
           l.start_reduce(reduction::sum, std::span(&one, 1));
           l.finish_reduce(std::span(&one, 1));
         }
       });
     }},
    {"sends_much_to_one_that_returned",
     [] {
       mpi::launch(launch_settings{}, [](auto& l) {
         std::vector<neighbour_message> neighbour_messages{{l.rank() ^ 1}};
         neighbour_messages[0].out.resize(1 << 24);
         if (l.rank() == 1) return;
         if (l.rank() > 1) neighbour_messages.clear();
         l.start(neighbour_messages);
         l.finish(neighbour_messages);
       });
     }},
    {"some_end_later",  // and no rank waits in vain
     [] {
       mpi::launch(launch_settings{}, [](auto& l) {
         (void)l.gather(byte_buffer(10));
         if (l.rank() % 2) return;
         std::vector<neighbour_message> neighbour_messages{{l.rank() ^ 2}};
         neighbour_messages[0].out.resize(8);
         if (l.rank() == 2) std::this_thread::sleep_for(3s);
         l.start(neighbour_messages);
         l.finish(neighbour_messages);
         std::fputs("done\n", stderr);
       });
     }},
    {"no_std_exception", [] { mpi::launch(launch_settings{}, [](auto&) { throw 42; }); }},
    {"too_many_ranks", [] { as_launched::launch(launch_settings{.ranks = 9}, [](auto&) {}); }},
    {"own_report",
     [] {
       fails_on<mpi>({1, 2}, {.report = [](const std::string& m) {
                       std::fprintf(stderr, "<%s>\n", m.c_str());
                     }});
     }},
    {"own_communicator",
     [] {
       const boost::mpi::environment environment;
       mpi::launch({launch_settings{}, boost::mpi::communicator{}, 7}, [](auto& l) {
         work(l, [&](int step) {
           if (step == 9 && l.rank() == 3) throw std::runtime_error("a body left");
         });
       });
     }},
    {"wrong_size",
     [] {
       mpi::launch(launch_settings{}, [](auto& l) {
         std::vector<neighbour_message> neighbour_messages{{l.rank() ^ 1}};
         neighbour_messages[0].out.resize(l.rank() == 2 ? 80 : 40);
         neighbour_messages[0].in.resize(40);
         l.start_fixed(neighbour_messages);
         l.finish_fixed(neighbour_messages);
       });
     }},
    {"one_beside_a_lock", [] { beside_a_lock([] { throw std::runtime_error("a body left"); }); }},
    {"exit_beside_a_lock", [] { beside_a_lock([] { detail::end_of_job.load()(3); }); }},
    {"exits_in_a_run", exits_in_a_run},
    {"threads", [] { threads::launch({}, [](auto&) { std::fputs("ran\n", stderr); }); }},
    {"serial", [] { serial::launch({}, [](auto&) { std::fputs("ran\n", stderr); }); }},
};

struct outcome {
  std::string text;  // all of stderr
  int status = -1;
  double seconds = 0;
};

outcome run(const std::string& job) {
  // A clean environment: this test may run under mpirun itself.
  const std::string command =
      "env -i PATH=\"$PATH\" HOME=\"${HOME:-/}\" LD_LIBRARY_PATH=\"$LD_LIBRARY_PATH\" "
      "ASAN_OPTIONS=detect_leaks=0 OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 "
      "OMPI_MCA_rmaps_base_oversubscribe=1 OMPI_MCA_mpi_yield_when_idle=1 "
      "OMPI_MCA_hwloc_base_binding_policy=none OMPI_MCA_btl_vader_single_copy_mechanism=none "
      "timeout 50 mpirun -q -n 4 '" +
      self + "' job " + job + " 2>&1 >/dev/null";
  outcome result;
  const auto start = std::chrono::steady_clock::now();
  FILE* pipe = popen(command.c_str(), "r");
  REQUIRE(pipe != nullptr);
  for (int c; (c = std::fgetc(pipe)) != EOF;) result.text += static_cast<char>(c);
  result.status = WEXITSTATUS(pclose(pipe));
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

void check_job(const std::string& job, const std::string& text) {
  CAPTURE(job);
  const outcome result = run(job);
  CHECK_MESSAGE(std::regex_match(result.text, std::regex(text + "\n")), result.text);
  CHECK(result.status == 1);
  CHECK(result.seconds < 20);  // one or two, on an idle machine
}

const std::string left = "error on rank [0-3] of 4: a body left( the domain)?";

}  // namespace

int main(int argc, char** argv) {
  self = argv[0];
  if (argc == 3 && std::string(argv[1]) == "job") {
    try {
      jobs.at(argv[2])();
    } catch (const aborted&) {
      return 1;
    } catch (const std::exception& e) {
      std::fprintf(stderr, "%s\n", e.what());
      return 1;
    }
    return 0;
  }
  return doctest::Context(argc, argv).run();
}

TEST_CASE("mpi: an error on one rank ends the job with one message") {
  check_job("one", "error on rank 2 of 4: a body left the domain");
  check_job("root", "error on rank 0 of 4: a body left the domain");
  check_job("in_collectives", "error on rank 1 of 4: a body left");
  check_job("own_communicator", "error on rank 3 of 4: a body left");
}

TEST_CASE("mpi: errors on several ranks end the job with one message") {
  for (int repeat = 0; repeat < 2; ++repeat) {
    check_job("two", left);
    check_job("all", left);
    check_job("all_but_root", left);
    check_job("at_once", left);
  }
}

TEST_CASE("mpi: the message needs no help from a rank that computes") {
  check_job("root_computes", "error on rank [1-3] of 4: a body left");
}

TEST_CASE("mpi: every kind of error is reported") {
  check_job("no_std_exception", "error on rank [0-3] of 4: an exception that is no std::exception");
  check_job("too_many_ranks",
            "error on rank [0-3] of 4: 9 ranks are asked for, but the program runs on 4 MPI "
            "processes: start it with mpirun -n 9, or do not ask");
  check_job("wrong_size",
            "error on rank 3 of 4: rank 3 expected 40 bytes from rank 2, but more came: .*");
  check_job("own_report", "<" + left + ">");
}

TEST_CASE("mpi: a rank that returns while others wait for it ends the job with one message") {
  const auto ended = [](const char* rank) {
    return "error on rank [0-3] of 4: rank [0-3] waits for rank " + std::string(rank) +
           ", whose program has ended: .*";
  };
  check_job("returns", ended("2"));
  check_job("returns_fixed", ended("0"));
  check_job("returns_before_a_meeting", ended("3"));
  check_job("returns_before_a_reduction", ended("1"));
  check_job("sends_much_to_one_that_returned", ended("1"));
}

TEST_CASE("mpi: ranks may end at different times when nobody waits for them") {
  const outcome result = run("some_end_later");
  CHECK(result.text == "done\ndone\n");
  CHECK(result.status == 0);
  CHECK(result.seconds < 20);
}

TEST_CASE("mpi: no lock of rank 0 is left when another rank fails") {
  check_job("one_beside_a_lock", "error on rank 2 of 4: a body left");
  CHECK(::access(lock_of_file().c_str(), F_OK) != 0);
  const outcome result = run("exit_beside_a_lock");
  CHECK(result.status == 3);
  CHECK(::access(lock_of_file().c_str(), F_OK) != 0);
  ::unlink(lock_of_file().c_str());
}

TEST_CASE("mpi: a rank that exits writes the results of the run, which rank 0 has locked") {
  const outcome result = run("exits_in_a_run");
  CHECK(result.status == 3);
  std::stringstream json;
  json << std::ifstream(results_file()).rdbuf();
  INFO(result.text << json.str());
  CHECK(json.str().find("exit(3) on rank 3 after step 3") != std::string::npos);
  ::unlink(results_file().c_str());
}

TEST_CASE("threads and serial refuse to run several times over, and say so once") {
  check_job("threads", "mpirun started 4 processes, but .*'threads'.*");
  check_job("serial", "mpirun started 4 processes, but .*'serial'.*");
}
