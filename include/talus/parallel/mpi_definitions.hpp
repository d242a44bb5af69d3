#pragma once
// The definitions of mpi.hpp, in the compiled part or in each program.
#include <mpi.h>

#include <atomic>
#include <boost/mpi/collectives.hpp>
#include <boost/mpi/collectives/all_gatherv.hpp>  // which collectives.hpp forgets
#include <boost/mpi/environment.hpp>
#include <climits>
#include <exception>
#include <functional>
#include <numeric>
#include <utility>

#include "talus/core/linkage.hpp"
#include "talus/parallel/launcher.hpp"
#include "talus/parallel/mpi.hpp"

namespace talus {

TALUS_MPI_INLINE mpi::link::link(const boost::mpi::communicator& ranks)
    : ranks_(ranks, boost::mpi::comm_duplicate), rank_(ranks.rank()), size_(ranks.size()) {
  // Errors come back as boost::mpi::exception instead of ending the job unexplained.
  MPI_Comm_set_errhandler(ranks_, MPI_ERRORS_RETURN);
}
TALUS_MPI_INLINE mpi::link::link(const boost::mpi::communicator& ranks, int tag)
    : ranks_(ranks), tag_(tag), rank_(ranks.rank()), size_(ranks.size()) {
  const int largest = boost::mpi::environment::max_tag();
  if (tag < 0 || tag > largest)
    detail::fail<std::invalid_argument>("the message tag is {}, but tags go from 0 to {}", tag,
                                        largest);
}

TALUS_MPI_INLINE void mpi::link::start(std::span<neighbour_message> neighbour_messages) {
  exchange_.start(neighbour_messages, sizes::unknown, rank_, size_);
  send_all(neighbour_messages);
}

TALUS_MPI_INLINE void mpi::link::finish(std::span<neighbour_message> neighbour_messages) {
  exchange_.finish(neighbour_messages, sizes::unknown, rank_);
  for (neighbour_message& p : neighbour_messages) {
    if (p.rank == rank_)
      p.in.swap(p.out);
    else
      receive(p.rank, p.in);
  }
  await_sends(neighbour_messages);
  for (neighbour_message& p : neighbour_messages) p.out.clear();
}

TALUS_MPI_INLINE void mpi::link::start_fixed(std::span<neighbour_message> neighbour_messages) {
  exchange_.start(neighbour_messages, sizes::fixed, rank_, size_);
  receives_.clear();
  for (neighbour_message& p : neighbour_messages)
    if (p.rank != rank_)
      BOOST_MPI_CHECK_RESULT(MPI_Irecv, (p.in.data(), count(p.in), MPI_UNSIGNED_CHAR, p.rank, tag_,
                                         ranks_, &receives_.emplace_back()));
  send_all(neighbour_messages);
}

TALUS_MPI_INLINE void mpi::link::finish_fixed(std::span<neighbour_message> neighbour_messages) {
  exchange_.finish(neighbour_messages, sizes::fixed, rank_);
  auto next = receives_.begin();
  for (neighbour_message& p : neighbour_messages) {
    if (p.rank == rank_) {
      if (p.in.size() != p.out.size()) detail::fail_size(rank_, p, p.out.size());
      p.in.swap(p.out);
      continue;
    }
    MPI_Status status;
    if (wait(*next++, p.rank, &status) == MPI_ERR_TRUNCATE) detail::fail_size(rank_, p, {});
    if (size_of(status) != p.in.size()) detail::fail_size(rank_, p, size_of(status));
  }
  await_sends(neighbour_messages);
}

TALUS_MPI_INLINE void mpi::link::barrier() { meet(); }

TALUS_MPI_INLINE std::vector<detail::byte_buffer> mpi::link::gather(const byte_buffer& mine) {
  // One message each: MPI_Gatherv would limit the whole to 2 GiB.
  meet();
  std::vector<byte_buffer> all;
  if (rank_ != 0) {
    ranks_.send(0, tag_, bytes(mine), count(mine));
  } else {
    all.resize(static_cast<std::size_t>(size_));
    all[0] = mine;
    for (int r = 1; r < size_; ++r) receive(r, all[static_cast<std::size_t>(r)]);
  }
  return all;
}

TALUS_MPI_INLINE std::vector<detail::byte_buffer> mpi::link::gather_all(const byte_buffer& mine) {
  meet();
  std::vector<int> counts;
  boost::mpi::all_gather(ranks_, count(mine), counts);
  byte_buffer whole(std::accumulate(counts.begin(), counts.end(), std::size_t{0}));
  count(whole);
  boost::mpi::all_gatherv(ranks_, bytes(mine), bytes(whole), counts);
  std::vector<byte_buffer> all;
  all.reserve(counts.size());
  for (auto at = whole.cbegin(); const int n : counts) {
    all.emplace_back(at, at + n);
    at += n;
  }
  return all;
}

TALUS_MPI_INLINE void mpi::link::broadcast(byte_buffer& data) {
  meet();
  std::uint64_t n = data.size();
  boost::mpi::broadcast(ranks_, n, 0);
  data.resize(n);
  boost::mpi::broadcast(ranks_, bytes(data), count(data), 0);
}

TALUS_MPI_INLINE void mpi::link::reduce(reduction how, std::span<double> values) {
  // Not MPI_Allreduce, which may add up in any order.
  meet();
  if (values.empty()) return;
  std::vector<double> all(values.size() * static_cast<std::size_t>(size_));
  boost::mpi::all_gather(ranks_, values.data(), static_cast<int>(values.size()), all.data());
  combine(how, values, all);
}

TALUS_MPI_INLINE void mpi::link::reduce(reduction how, std::span<std::uint64_t> values) {
  meet();
  if (values.empty()) return;
  const auto with = [&]<class Number>(const std::vector<Number>& mine, Number* all, auto op) {
    boost::mpi::all_reduce(ranks_, mine.data(), static_cast<int>(mine.size()), all, op);
  };
  if (how == reduction::sum) {
    with(std::vector<std::uint64_t>(values.begin(), values.end()), values.data(),
         std::plus<std::uint64_t>{});
    return;
  }
  // Open MPI 4.1 compares unsigned numbers above 2^63 as negative ones, so they are compared as
  // signed numbers in the same order.
  constexpr std::uint64_t middle = std::uint64_t{1} << 63;
  std::vector<std::int64_t> mine, most(values.size());
  for (const std::uint64_t v : values) mine.push_back(static_cast<std::int64_t>(v ^ middle));
  if (how == reduction::min) with(mine, most.data(), boost::mpi::minimum<std::int64_t>{});
  if (how == reduction::max) with(mine, most.data(), boost::mpi::maximum<std::int64_t>{});
  for (std::size_t k = 0; k < values.size(); ++k)
    values[k] = static_cast<std::uint64_t>(most[k]) ^ middle;
}

TALUS_MPI_INLINE void mpi::link::start_reduce(reduction how, std::span<const double> values) {
  exchange_.start_reduce(how, values.size(), rank_);
  brought_.assign(values.begin(), values.end());
  all_brought_.resize(values.size() * static_cast<std::size_t>(size_));
  const int n = static_cast<int>(values.size());
  BOOST_MPI_CHECK_RESULT(MPI_Iallgather, (brought_.data(), n, MPI_DOUBLE, all_brought_.data(), n,
                                          MPI_DOUBLE, ranks_, &reduction_));
}

TALUS_MPI_INLINE void mpi::link::finish_reduce(std::span<double> values) {
  const reduction how = exchange_.finish_reduce(values.size(), rank_);
  wait(reduction_, detail::mpi_patience::all);
  combine(how, values, all_brought_);
}

TALUS_MPI_INLINE void mpi::link::meet() {
  exchange_.count_collective(rank_);
  MPI_Request request = MPI_REQUEST_NULL;
  BOOST_MPI_CHECK_RESULT(MPI_Ibarrier, (ranks_, &request));
  wait(request, detail::mpi_patience::all);
}

TALUS_MPI_INLINE void mpi::link::combine(reduction how, std::span<double> values,
                                         std::span<const double> all) {
  if (values.empty()) return;
  std::copy_n(all.begin(), values.size(), values.begin());
  for (std::size_t at = values.size(); at < all.size(); at += values.size())
    detail::combine<double>(how, values, all.subspan(at, values.size()));
}

TALUS_MPI_INLINE void mpi::link::send_all(std::span<const neighbour_message> neighbour_messages) {
  sends_.clear();
  for (const neighbour_message& p : neighbour_messages)
    if (p.rank != rank_)
      BOOST_MPI_CHECK_RESULT(MPI_Isend, (p.out.data(), count(p.out), MPI_UNSIGNED_CHAR, p.rank,
                                         tag_, ranks_, &sends_.emplace_back()));
}

TALUS_MPI_INLINE void mpi::link::receive(int from, byte_buffer& data) {
  MPI_Status message;
  patience_.wait(rank_, from, 0, [&] {
    int there = 0;
    BOOST_MPI_CHECK_RESULT(MPI_Iprobe, (from, tag_, ranks_, &there, &message));
    return there != 0;
  });
  data.resize(size_of(message));
  ranks_.recv(from, tag_, bytes(data), count(data));
}

TALUS_MPI_INLINE void mpi::link::await_sends(
    std::span<const neighbour_message> neighbour_messages) {
  auto next = sends_.begin();
  for (const neighbour_message& p : neighbour_messages)
    if (p.rank != rank_) wait(*next++, p.rank);
}

TALUS_MPI_INLINE int mpi::link::wait(MPI_Request& request, int other, MPI_Status* status) {
  int result = MPI_SUCCESS;
  patience_.wait(rank_, other, exchange_.sent().collectives, [&] {
    int done = 0;
    result = MPI_Test(&request, &done, status);
    return done != 0 || result != MPI_SUCCESS;
  });
  if (result != MPI_SUCCESS && result != MPI_ERR_TRUNCATE)
    throw boost::mpi::exception("MPI_Test", result);
  return result;
}

TALUS_MPI_INLINE std::size_t mpi::link::size_of(const MPI_Status& status) {
  int bytes = 0;
  MPI_Get_count(&status, MPI_UNSIGNED_CHAR, &bytes);
  return static_cast<std::size_t>(bytes);
}

TALUS_MPI_INLINE const unsigned char* mpi::link::bytes(const byte_buffer& data) {
  static constexpr unsigned char nothing = 0;
  return data.empty() ? &nothing : reinterpret_cast<const unsigned char*>(data.data());
}

TALUS_MPI_INLINE unsigned char* mpi::link::bytes(byte_buffer& data) {
  return const_cast<unsigned char*>(bytes(std::as_const(data)));
}

TALUS_MPI_INLINE int mpi::link::count(const byte_buffer& data) {
  if (data.size() > INT_MAX)
    detail::fail<std::runtime_error>(
        "a message of {} bytes is too long: MPI counts to {}; use more ranks", data.size(),
        INT_MAX);
  return static_cast<int>(data.size());
}

TALUS_MPI_INLINE void mpi::link::heed(detail::mpi_verdict& who_left, detail::wait_monitor& watch) {
  patience_ = detail::mpi_patience(who_left, watch);
}

TALUS_MPI_INLINE void mpi::launch_each(const settings& how, const body& main) {
  namespace mpi = boost::mpi;
  if (mpi::environment::finalized())
    detail::fail<std::runtime_error>(
        "MPI has been finalised and cannot start again: for several runs in one program, put "
        "boost::mpi::environment into main()");
  std::optional<mpi::environment> ours;
  if (!mpi::environment::initialized()) {
    if (how.argc && how.argv)
      ours.emplace(*how.argc, *how.argv, mpi::threading::funneled, false);
    else
      ours.emplace(mpi::threading::funneled, false);
  }
  const auto ranks = how.communicator.value_or(mpi::communicator{});
  if (ranks.size() == 1) return run(how, ranks, main, nullptr);

  detail::mpi_verdict verdict(ranks);
  static std::atomic<detail::mpi_verdict*> verdict_of_job;
  struct whole_job {
    explicit whole_job(detail::mpi_verdict& verdict) {
      verdict_of_job = &verdict;
      detail::end_of_job = [](int code) {
        int here = 0;  // MPI serves one thread
        if (MPI_Is_thread_main(&here) == MPI_SUCCESS && here != 0)
          verdict_of_job.load()->leave_locks();
        MPI_Abort(MPI_COMM_WORLD, code);
      };
    }
    ~whole_job() { detail::end_of_job = nullptr; }
  } const job(verdict);
  const auto end_with = [&](const char* error) {
    if (!verdict.first()) verdict.wait_for_the_end();
    how.report(detail::compose("error on rank {} of {}: {}", ranks.rank(), ranks.size(), error));
    verdict.end();
  };
  if (verdict.limited())
    end_with(
        "MPI cannot share memory between processes: it needs longer files than the limit allows "
        "(ulimit -f): raise that limit");
  try {
    run(how, ranks, main, &verdict);
  } catch (const std::exception& e) {
    end_with(e.what());
  } catch (...) {
    end_with("an exception that is no std::exception");
  }
}

TALUS_MPI_INLINE void mpi::run(const settings& how, const boost::mpi::communicator& ranks,
                               const body& main, detail::mpi_verdict* verdict) {
  const int started = detail::find_launcher().size;
  if (started > 1 && ranks.size() == 1 && !how.communicator)
    detail::fail<std::runtime_error>(
        "mpirun started {} processes, but they do not see each other: mpirun and the program "
        "belong to different MPIs",
        started);
  if (how.ranks != 0 && how.ranks != ranks.size())
    detail::fail<std::invalid_argument>(
        "{} ranks are asked for, but the program runs on {} MPI processes: start it with "
        "mpirun -n {}, or do not ask",
        how.ranks, ranks.size(), how.ranks);
  link mine = how.tag ? link(ranks, *how.tag) : link(ranks);
  detail::wait_monitor watch(how);
  if (verdict != nullptr) mine.heed(*verdict, watch);
  main(mine);
  if (verdict != nullptr) verdict->leave(mine.counters().collectives);
}

}  // namespace talus
