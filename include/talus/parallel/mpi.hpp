#pragma once
// Ranks as MPI processes. The only transport that includes MPI.
//
// Boost.MPI does everything but five things it has not (1.74): non-blocking messages without a
// heap allocation each, a wait that tells the size of each message, non-blocking collectives,
// windows, and waits that end when there is nobody left to wait for. These are C. Before each of
// its collective calls all ranks meet, with such a wait.
#include <mpi.h>

#include <boost/mpi/communicator.hpp>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "talus/parallel/detail/mpi_patience.hpp"
#include "talus/parallel/detail/mpi_verdict.hpp"
#include "talus/parallel/detail/open_exchange.hpp"
#include "talus/parallel/launch_settings.hpp"
#include "talus/parallel/reduction.hpp"

namespace talus {

struct mpi {
  static constexpr const char* name = "mpi";

  struct settings : launch_settings {
    settings(const launch_settings& plain = {}) : launch_settings(plain) {}
    settings(const launch_settings& plain, boost::mpi::communicator ranks,
             std::optional<int> message_tag = {})
        : launch_settings(plain), communicator(std::move(ranks)), tag(message_tag) {}

    /// The processes of the run; all of MPI's if not given.
    std::optional<boost::mpi::communicator> communicator;
    /// If given, messages travel on the communicator itself with this tag, else on a duplicate.
    std::optional<int> tag;
  };

  /// One process's end. One tag is enough: between two ranks MPI keeps the order of messages, and
  /// one exchange is open at a time. May be moved, but not while an exchange is open.
  class link {
    using byte_buffer = detail::byte_buffer;
    using sizes = detail::open_exchange::sizes;

   public:
    static constexpr bool alone = false;

    /// Talks on a duplicate of `ranks`, so that nothing else can mix with its messages. All ranks
    /// construct their link together.
    explicit link(const boost::mpi::communicator& ranks);
    /// Talks on `ranks` itself and marks its messages with `tag`, which nobody else may use there.
    /// Throws invalid_argument for a tag that MPI does not have.
    link(const boost::mpi::communicator& ranks, int tag);

    [[nodiscard]] int rank() const { return rank_; }
    [[nodiscard]] int size() const { return size_; }
    [[nodiscard]] const traffic& counters() const { return exchange_.sent(); }
    [[nodiscard]] const boost::mpi::communicator& communicator() const { return ranks_; }
    /// From now on nobody is waited for whose program has ended, as `who_left` records, and long
    /// waits are reported.
    void heed(detail::mpi_verdict& who_left, detail::wait_monitor& watch);

    void start(std::span<neighbour_message> neighbour_messages);
    void finish(std::span<neighbour_message> neighbour_messages);
    void start_fixed(std::span<neighbour_message> neighbour_messages);
    void finish_fixed(std::span<neighbour_message> neighbour_messages);

    void barrier();
    [[nodiscard]] std::vector<byte_buffer> gather(const byte_buffer& mine);
    [[nodiscard]] std::vector<byte_buffer> gather_all(const byte_buffer& mine);
    void broadcast(byte_buffer& data);
    void reduce(reduction how, std::span<double> values);
    void start_reduce(reduction how, std::span<const double> values);
    void finish_reduce(std::span<double> values);
    void reduce(reduction how, std::span<std::uint64_t> values);

   private:
    /// All ranks are in the same collective call.
    void meet();
    /// From rank 0 upwards, so that all ranks have the same to the bit.
    static void combine(reduction how, std::span<double> values, std::span<const double> all);
    /// Sends the messages to other ranks. finish() passes on what a rank sends to itself.
    void send_all(std::span<const neighbour_message> neighbour_messages);
    /// The next message of rank `from`, of any size.
    void receive(int from, byte_buffer& data);
    void await_sends(std::span<const neighbour_message> neighbour_messages);
    /// Returns MPI_SUCCESS or MPI_ERR_TRUNCATE. (One by one: Open MPI 4.1 may crash in MPI_Waitall
    /// when one of the messages is too long.)
    int wait(MPI_Request& request, int other, MPI_Status* status = MPI_STATUS_IGNORE);

    static std::size_t size_of(const MPI_Status& status);
    /// Never null, which Boost.MPI would dereference for an empty message.
    static const unsigned char* bytes(const byte_buffer& data);
    static unsigned char* bytes(byte_buffer& data);
    static int count(const byte_buffer& data);

    boost::mpi::communicator ranks_;
    int tag_ = 0;
    int rank_;
    int size_;
    detail::open_exchange exchange_;
    std::vector<MPI_Request> sends_;
    std::vector<MPI_Request> receives_;
    std::vector<double> brought_, all_brought_;  ///< to the open reduction
    MPI_Request reduction_ = MPI_REQUEST_NULL;
    detail::mpi_patience patience_;
  };

  /// Calls main(link&) on this process. Initialises MPI if the program has not, and then finalises
  /// it as well; as MPI starts only once, a program with several runs initialises it in its main().
  /// An exception on any of several ranks ends the job: one rank reports it, and all processes are
  /// ended with MPI_Abort. A single process throws to the caller.
  template <class Main>
  static void launch(const settings& how, Main&& main) {
    launch_each(how, [&](link& mine) { main(mine); });
  }

 private:
  using body = std::function<void(link&)>;
  static void launch_each(const settings& how, const body& main);
  static void run(const settings& how, const boost::mpi::communicator& ranks, const body& main,
                  detail::mpi_verdict* verdict);
};

}  // namespace talus

#ifndef TALUS_COMPILED_MPI
#include "talus/parallel/mpi_definitions.hpp"
#endif
