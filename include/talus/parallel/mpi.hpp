#pragma once
// Ranks as MPI processes. The only transport that includes MPI.
#include <mpi.h>

#include <boost/mpi/collectives.hpp>
#include <boost/mpi/communicator.hpp>
#include <boost/mpi/environment.hpp>
#include <climits>
#include <cstdint>
#include <exception>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "talus/parallel/detail/launcher.hpp"
#include "talus/parallel/detail/mpi_verdict.hpp"
#include "talus/parallel/detail/open_exchange.hpp"
#include "talus/parallel/launch_settings.hpp"
#include "talus/parallel/reduction.hpp"

namespace talus {

struct mpi {
  static constexpr const char* name = "mpi";

  /// One process's end. One tag is enough: between two ranks MPI keeps the order of messages, and
  /// one exchange is open at a time.
  class link {
    using byte_buffer = detail::byte_buffer;
    using sizes = detail::open_exchange::sizes;

   public:
    static constexpr bool alone = false;

    /// Talks on a duplicate of `ranks`, so that nothing else can mix with its messages. All ranks
    /// construct their link together.
    explicit link(const boost::mpi::communicator& ranks)
        : ranks_(ranks, boost::mpi::comm_duplicate) {
      // Errors come back as exceptions (boost::mpi::exception) instead of ending the job unexplained.
      MPI_Comm_set_errhandler(ranks_, MPI_ERRORS_RETURN);
    }
    /// Talks on `ranks` itself and marks its messages with `tag`, which nobody else may use there.
    link(const boost::mpi::communicator& ranks, int tag) : ranks_(ranks), tag_(tag) {
      if (tag < 0 || tag > boost::mpi::environment::max_tag())
        detail::fail<std::invalid_argument>("the message tag is {}, but tags go from 0 to {}", tag,
                                            boost::mpi::environment::max_tag());
    }

    [[nodiscard]] int rank() const { return rank_; }
    [[nodiscard]] int size() const { return size_; }
    [[nodiscard]] const traffic& counters() const { return exchange_.sent(); }
    [[nodiscard]] const boost::mpi::communicator& communicator() const { return ranks_; }

    void start(std::span<parcel> parcels) {
      exchange_.start(parcels, sizes::unknown, rank_, size_);
      requests_.clear();
      send(parcels);
    }
    void finish(std::span<parcel> parcels) {
      exchange_.finish(parcels, sizes::unknown, rank_);
      for (parcel& p : parcels) {
        const auto found = ranks_.probe(p.rank, tag_);
        p.in.resize(static_cast<std::size_t>(*found.template count<unsigned char>()));
        ranks_.recv(p.rank, tag_, bytes(p.in), count(p, p.in));
      }
      check(MPI_Waitall(std::ssize(requests_), requests_.data(), MPI_STATUSES_IGNORE));
      for (parcel& p : parcels) p.out.clear();
    }
    void start_fixed(std::span<parcel> parcels) {
      exchange_.start(parcels, sizes::fixed, rank_, size_);
      requests_.clear();
      for (parcel& p : parcels)
        check(MPI_Irecv(p.in.data(), count(p, p.in), MPI_UNSIGNED_CHAR, p.rank, tag_, ranks_, add()));
      send(parcels);
    }
    void finish_fixed(std::span<parcel> parcels) {
      exchange_.finish(parcels, sizes::fixed, rank_);
      statuses_.resize(requests_.size());
      const int result = MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(),
                                     statuses_.data());
      for (std::size_t i = 0; i < parcels.size(); ++i) {
        
      }
    }

   private:
  };
};

}  // namespace talus
