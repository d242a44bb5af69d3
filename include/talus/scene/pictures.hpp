#pragma once
// Pictures of a run, as its options ask for them.
#include <filesystem>
#include <string>

#include "talus/core/error.hpp"
#include "talus/io/povray.hpp"
#include "talus/scene/options.hpp"

namespace talus {

/// Collective; call it when the bodies are there: with --frames DIR it writes a picture now and
/// after every `options.every` steps of simulate(), DIR/frame_00000.pov and so on. `look` is how
/// the scene likes to be seen; options overrule it. Throws runtime_error if the folder cannot be
/// made.
template <class Scenario>
void take_pictures(world<Scenario>& w, const options& options, picture look = {}) {
  if (options.frames.empty()) return;
  if (!options.colour.empty())
    look.colour = options.colour == "rank" ? picture::colouring::rank : picture::colouring::speed;
  look.copies |= options.copies;
  look.domains |= options.domains;
  std::error_code problem;
  std::filesystem::create_directories(options.frames, problem);
  if (problem)
    detail::fail<std::runtime_error>("the folder {} for pictures cannot be made: {}",
                                     options.frames, problem.message());
  const auto take = [&w, look, folder = options.frames](std::uint64_t number) {
    const std::string digits = std::to_string(number);
    const std::string zeros(digits.size() < 5 ? 5 - digits.size() : 0, '0');
    write_povray(w, folder + "/frame_" + zeros + digits + ".pov", look);
  };
  w.synchronize();
  take(w.steps() / options.every);
  w.after_each_step([&w, take, every = options.every] {
    if (w.steps() % every == 0) take(w.steps() / every);
  });
}

}  // namespace talus
