// Validation cases of talus against formulas and publications, written as a JSON array.
#include "validation.hpp"

#include <algorithm>
#include <cstring>
#include <iostream>
#include <stdexcept>

#include "scenes/report.hpp"
#include "validation_bonds.hpp"
#include "validation_bridges.hpp"
#include "validation_chung_ooi.hpp"
#include "validation_closed_forms.hpp"
#include "validation_cohesion.hpp"
#include "validation_dosta.hpp"
#include "validation_fluid.hpp"
#include "validation_hard_cohesion.hpp"

namespace {

/// The themes; add a line for a new one.
const std::vector<validation::theme> themes{{"chung_ooi", validation::chung_ooi},
                                            {"dosta", validation::dosta},
                                            {"closed_forms", validation::closed_forms},
                                            {"cohesion", validation::cohesion},
                                            {"hard_cohesion", validation::hard_cohesion},
                                            {"bonds", validation::bonds},
                                            {"bridges", validation::bridges},
                                            {"fluid", validation::fluid}};

int run(int argc, char** argv) {
  std::string only, file;
  validation::effort effort;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--quick") {
      effort.quick = true;
    } else if (argument == "--only" || argument == "--json") {
      if (i + 1 == argc) throw std::invalid_argument(argument + " needs a value");
      (argument == "--only" ? only : file) = argv[++i];
      if (argument == "--json") bench::require_place(file, bench::json_output);
    } else {
      throw std::invalid_argument("validation has no option '" + argument +
                                  "'; there are: --quick, --only NAME,..., --json FILE");
    }
  }
  std::vector<bool> chosen(themes.size(), only.empty());
  for (std::size_t at = 0; !only.empty() && at <= only.size();) {
    const std::size_t end = std::min(only.find(',', at), only.size());
    const std::string name = only.substr(at, end - at);
    const auto found =
        std::find_if(themes.begin(), themes.end(), [&](const auto& t) { return t.name == name; });
    if (found == themes.end()) {
      std::string all;
      for (const auto& t : themes) all += (all.empty() ? "" : ", ") + t.name;
      throw std::invalid_argument("--only: there are no cases '" + name + "'; there are: " + all);
    }
    chosen[static_cast<std::size_t>(found - themes.begin())] = true;
    at = end + 1;
  }
  validation::report results;
  for (std::size_t i = 0; i < themes.size(); ++i)
    if (chosen[i]) themes[i].run(results, effort);
  bench::record::write_text(validation::json(results), file);
  int missed = 0;
  for (const auto& r : results)
    if (!r.met()) {
      ++missed;
      std::cerr << "not met: " << r.name << ", " << r.quantity << ": expected "
                << validation::number(r.expected) << ", found " << validation::number(r.found)
                << " " << r.unit << "\n";
    }
  return missed > 0 ? 1 : 0;
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
