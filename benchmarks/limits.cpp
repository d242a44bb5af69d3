// What this machine can do at most, to hold the engine against: memory bandwidth of a triad, on one
// core and on all, by the size of what is moved; and multiply-adds in the widest registers of one
// core.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "scenes/protocol.hpp"
#include "talus/core/clock.hpp"

namespace {

#if defined(__AVX512F__)
constexpr std::size_t lanes = 8;
#elif defined(__AVX__)
constexpr std::size_t lanes = 4;
#else
constexpr std::size_t lanes = 2;
#endif
typedef double wide __attribute__((vector_size(lanes * sizeof(double))));

/// One after the other, so that a page lies with the core that uses it.
struct arrays {
  std::vector<double> a, b, c;
  explicit arrays(std::size_t n) : a(n, 0), b(n, 1), c(n, 2) {}
};

/// a = b + 3 c, as STREAM has it (McCalpin 1995): 24 bytes for each of n numbers. Not the fourth
/// stream, of lines that are read before they are written.
[[gnu::noinline]] void triad(arrays& x) {
  double* __restrict a = x.a.data();
  const double* __restrict b = x.b.data();
  const double* __restrict c = x.c.data();
  const std::size_t n = x.a.size();
#pragma GCC ivdep
  for (std::size_t i = 0; i < n; ++i) a[i] = b[i] + 3 * c[i];
}

/// GB/s of the fastest of several rounds, all threads at once.
double bandwidth(std::size_t bytes, int threads, double seconds) {
  const std::size_t n = bytes / 24;
  std::vector<double> rates(static_cast<std::size_t>(threads));
  std::vector<std::thread> all;
  for (int t = 0; t < threads; ++t)
    all.emplace_back([&, t] {
      arrays x(n);
      const std::size_t repeats = std::max<std::size_t>(1, 20'000'000 / n);
      const double end = talus::detail::wall_seconds() + seconds;
      double best = 0;
      do {
        const double start = talus::detail::wall_seconds();
        for (std::size_t k = 0; k < repeats; ++k) triad(x);
        const double spent = talus::detail::wall_seconds() - start;
        best = std::max(best, 24e-9 * static_cast<double>(n * repeats) / spent);
      } while (talus::detail::wall_seconds() < end);
      if (x.a[n / 2] != 7) throw std::logic_error("the triad is wrong");
      rates[static_cast<std::size_t>(t)] = best;
    });
  double sum = 0;
  for (auto& each : all) each.join();
  for (const double rate : rates) sum += rate;
  return sum;
}

/// Sums of products in sixteen chains, which hide each other's latency. The library itself is
/// compiled without fused multiply-adds, so that its results do not depend on the compiler's
/// choice.
[[gnu::noinline, gnu::optimize("fp-contract=fast")]] double multiply_add(std::uint64_t rounds,
                                                                         double factor) {
  wide sums[16];
  for (int k = 0; k < 16; ++k) sums[k] = wide{} + 0.5 * k;
  const wide f = wide{} + factor, d = wide{} + 1e-3;
  for (std::uint64_t r = 0; r < rounds; ++r)
#pragma GCC unroll 16
    for (int k = 0; k < 16; ++k) sums[k] = sums[k] * f + d;
  wide sum = sums[0];
  for (int k = 1; k < 16; ++k) sum += sums[k];
  double total = 0;
  for (std::size_t i = 0; i < lanes; ++i) total += sum[i];
  return total;
}

double gigaflops(double seconds) {
  constexpr std::uint64_t rounds = 1'000'000;
  const double end = talus::detail::wall_seconds() + seconds;
  double best = 0, sum = 0;
  do {
    const double start = bench::cpu_seconds();
    sum += multiply_add(rounds, 0.999);
    best = std::max(
        best, 2e-9 * 16 * lanes * static_cast<double>(rounds) / (bench::cpu_seconds() - start));
  } while (talus::detail::wall_seconds() < end);
  if (!(sum > 0)) throw std::logic_error("the multiply-adds are wrong");  // and the sum is needed
  return best;
}

}  // namespace

int main(int argc, char** argv) {
  return bench::guarded([&] {
    bench::arguments args(argc, argv);
    const auto milliseconds = args.count("milliseconds", 1000);  // for each figure
    const auto largest = args.count("megabytes", 768);           // of each thread
    const auto file = args.json_file();
    if (!args.done()) return;
    const double seconds = 1e-3 * static_cast<double>(milliseconds);
    const int cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));

    bench::record out;
    out.add("cores", cores);
    out.add("vector_bits", 64 * lanes);
    out.add("gflops_one_core", gigaflops(seconds));
    const std::size_t kib = 1024, mib = 1024 * kib;
    const auto add = [&](const std::string& name, std::size_t bytes) {
      out.add("gb_per_s_" + name + "_one_core", bandwidth(bytes, 1, seconds));
      out.add("gb_per_s_" + name + "_all_cores", bandwidth(bytes, cores, seconds));
    };
    add("24_kib", 24 * kib);
    add("1_mib", mib);
    add("4_mib", 4 * mib);
    add("24_mib", 24 * mib);
    add("memory", largest * mib);
    out.write(file);
  });
}
