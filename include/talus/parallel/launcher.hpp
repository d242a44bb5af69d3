#pragma once
// Detects from the environment alone whether mpirun or a similar launcher started this process. MPI
// need not be linked or initialised.
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>

#include "talus/core/error.hpp"

namespace talus::detail {

struct launcher {
  int size = 0;  ///< processes in the job; 0: started without a launcher
  int rank = 0;
};

/// Ends all processes of the job with this code; null if the job is one process.
inline std::atomic<void (*)(int)> end_of_job{nullptr};

[[nodiscard]] inline launcher find_launcher() {
  // SLURM_PROCID is no evidence: a batch script without srun has it as well.
  constexpr const char* names[][2] = {{"OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK"},
                                      {"PMI_SIZE", "PMI_RANK"},
                                      {"MV2_COMM_WORLD_SIZE", "MV2_COMM_WORLD_RANK"},
                                      {"SLURM_STEP_NUM_TASKS", "SLURM_PROCID"},
                                      {nullptr, "PMIX_RANK"},
                                      {nullptr, "PMI_RANK"}};
  for (const auto& [size_name, rank_name] : names) {
    const char* size = size_name ? std::getenv(size_name) : nullptr;
    const char* rank = std::getenv(rank_name);
    if (!rank || (size_name && !size)) continue;
    const int r = std::max(0, std::atoi(rank));
    return {size ? std::max(1, std::atoi(size)) : r + 1, r};
  }
  return {};
}

/// Whether this is the first process of the job on its machine.
[[nodiscard]] inline bool first_on_its_machine() {
  for (const char* name : {"OMPI_COMM_WORLD_LOCAL_RANK", "MPI_LOCALRANKID", "SLURM_LOCALID"})
    if (const char* rank = std::getenv(name)) return std::atoi(rank) == 0;
  return find_launcher().rank == 0;
}

/// Throws if this is one of several processes of a job whose transport does not connect them.
inline void refuse_launcher(const char* transport) {
  const launcher job = find_launcher();
  if (job.size <= 1) return;
  if (job.rank > 0) {  // the first process reports for all, and its end ends the job
    ::sleep(2);
    throw aborted{};
  }
  fail<std::runtime_error>(
      "mpirun started {} processes, but this program was built with the transport '{}', which does "
      "not connect them: each would simulate everything. Include \"talus/mpi.hpp\" and choose the "
      "transport mpi or as_launched, or start the program without mpirun",
      job.size, transport);
}

}  // namespace talus::detail
