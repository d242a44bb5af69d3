// The rotating drum of Dosta and others (2024) with the published files: numbers of spheres in two
// quadrants over time, and CPU time. ./dev bench dosta_drum [--softness 500] [--dt 1e-4] [--time 5]
// [--curve FILE] [--positions FILE]; --softness 1 --dt 8e-7 is the stiff variant, which takes
// hours.
#include "dosta_drum.hpp"

#include <cstdlib>
#include <iostream>
#include <stdexcept>

namespace {

int run(int argc, char** argv) {
  dosta::drum_settings settings;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    double* number = argument == "--softness" ? &settings.softness
                     : argument == "--dt"     ? &settings.dt
                     : argument == "--time"   ? &settings.time
                                              : nullptr;
    std::string* const file = argument == "--curve"       ? &settings.curve
                              : argument == "--positions" ? &settings.positions
                                                          : nullptr;
    if (number == nullptr && file == nullptr)
      throw std::invalid_argument("dosta_drum has no option '" + argument +
                                  "'; there are: --softness, --dt, --time, --curve, --positions");
    if (i + 1 == argc) throw std::invalid_argument(argument + " needs a value");
    const char* value = argv[++i];
    if (number == nullptr) {
      *file = value;
      continue;
    }
    char* end = nullptr;
    *number = std::strtod(value, &end);
    if (end == value || *end != '\0' || !(*number > 0))
      throw std::invalid_argument(argument + " needs a positive number, not '" + value + "'");
  }
  const char* named = std::getenv("TALUS_DOSTA");
  const dosta::drum_result r =
      dosta::run_drum(named != nullptr ? named : "../shared/dosta", settings);
  std::printf(
      "{\"engine\": \"talus\", \"bodies\": %.0f, \"steps\": %.0f, \"cpu_seconds\": %.6g, "
      "\"cpu_ms_per_step\": %.6g, \"cpu_seconds_per_particle_step\": %.4g, "
      "\"kinetic_energy_per_body\": %.6g, \"m1_upper\": %.0f, \"m2_upper\": %.0f, \"m1_lower\": "
      "%.0f, \"m2_lower\": %.0f}\n",
      r.spheres, r.steps, r.cpu_seconds, 1000 * r.cpu_seconds / r.steps,
      r.cpu_seconds / (r.steps * r.spheres), r.kinetic_energy / r.spheres, r.m1_upper, r.m2_upper,
      r.m1_lower, r.m2_lower);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 2;
  }
}
