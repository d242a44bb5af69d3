#pragma once
// Waiting in MPI, but not for ever for a rank whose program has ended: whoever waits for a second
// begins to ask whether there is anybody left to wait for.
#include <chrono>
#include <cstdint>

#include "talus/core/error.hpp"
#include "talus/parallel/detail/mpi_verdict.hpp"

namespace talus::detail {

class mpi_patience {
  using clock = std::chrono::steady_clock;

 public:
  static constexpr int all = -1;

  mpi_patience() = default;  ///< waits for ever
  explicit mpi_patience(const mpi_verdict& who_left) : who_left_(&who_left) {}

  /// Calls done() until it is true. Throws runtime_error if `other`, or for a collective call (the
  /// `call`-th) any rank, has ended its program before it came so far, and nothing of it arrived in
  /// a further second.
  template <class Done>
  void wait(int rank, int other, std::uint64_t call, Done&& done) const {
    if (done()) return;
    auto look = clock::now() + std::chrono::seconds(1);
    int suspect = all;
    for (unsigned polls = 1;; ++polls) {
      if (done()) return;
      if (polls % 64 != 0 || who_left_ == nullptr || clock::now() < look) continue;
      if (suspect != all)
        fail<std::runtime_error>(
            "rank {} waits for rank {}, whose program has ended: all ranks make the same steps and "
            "the same collective calls, and none returns before the others",
            rank, suspect);
      suspect = find_suspect(other, call);
      look = clock::now() + std::chrono::milliseconds(suspect == all ? 200 : 1000);
    }
  }

 private:
  [[nodiscard]] int find_suspect(int other, std::uint64_t call) const {
    const auto left = who_left_->left();
    for (std::size_t r = 0; r < left.size(); ++r) {
      const bool concerned = other == all ? left[r] <= call : static_cast<int>(r) == other;
      if (left[r] > 0 && concerned) return static_cast<int>(r);
    }
    return all;
  }

  const mpi_verdict* who_left_ = nullptr;
};

}  // namespace talus::detail
