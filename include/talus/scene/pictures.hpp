#pragma once
// Pictures of a run according to its options.
#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <string>

#include "talus/core/error.hpp"
#include "talus/core/field_names.hpp"
#include "talus/core/output_file.hpp"
#include "talus/core/run_lock.hpp"
#include "talus/io/output_series.hpp"
#include "talus/io/povray.hpp"
#include "talus/scene/detail/run_guard.hpp"
#include "talus/scene/options.hpp"

namespace talus {

namespace detail {

/// Makes a folder for pictures and its parents. Ranks may do so at the same time. (<filesystem>
/// takes the compiler a third of a second.)
[[gnu::cold]] inline void make_folder(const std::string& path) {
  int problem = 0;
  for (std::size_t end = 0; end != path.npos;) {
    end = path.find('/', end + 1);
    problem = mkdir(path.substr(0, end).c_str(), 0777) == 0 ? 0 : errno;
  }
  struct stat found {};
  if (stat(path.c_str(), &found) == 0 && S_ISDIR(found.st_mode)) return;
  fail<std::runtime_error>("the folder {} for pictures cannot be made: {}", path,
                           std::strerror(problem == EEXIST || problem == 0 ? ENOTDIR : problem));
}

/// Converted from options, so that a call without a third argument prefers the overload that takes
/// them directly.
struct any_options {
  any_options(const options&) {}
};

}  // namespace detail

/// Collective; call it when the bodies are there: with --frames DIR it writes a picture now and
/// after every `options.every` steps of simulate(), DIR/frame_00000.pov and so on. `look` is the
/// default view of the scene; options overrule it. Throws runtime_error if the folder cannot be
/// made.
template <class Scenario>
void take_pictures(world<Scenario>& w, const options& options, picture look = {}) {
  if (!options.colour.empty())
    look.colour = options.colour == "rank"    ? picture::colouring::rank
                  : options.colour == "speed" ? picture::colouring::speed
                                              : picture::colouring::material;
  look.follow = detail::agreed_id(w.link(), look.follow);
  w.note_pictures(look);
  if (options.frames.empty()) return;
  look.copies |= options.copies;
  look.domains |= options.domains;
  look.force |= options.force;
  detail::make_folder(options.frames);
  std::shared_ptr<detail::run_lock> lock;
  if (w.rank() == 0) {
    lock = std::make_shared<detail::run_lock>(options.frames + "/frame.pov.series",
                                              "--frames " + options.frames);
    lock->remove_left_over(options.frames + "/frame_", ".pov");
    const std::size_t before = detail::inspect_series("the picture", options.frames + "/frame_",
                                                      ".pov", detail::picture_output, look.force,
                                                      [](const std::string&) { return false; });
    if (before > 0 && options.restart.empty())
      detail::say_in_run(
          detail::compose("--frames {} replaces pictures of an earlier run\n", options.frames),
          options.quiet);
  }
  // The camera stays where the body was that it followed, and at the view itself after a restart
  // without that body.
  const auto centre = std::make_shared<vec3>(0, 0, 0);
  const auto take = [&w, look, centre, folder = options.frames](std::uint64_t number) {
    picture now = look;
    now.follow = no_id;
    if (const auto at = detail::centre_of_followed(w, look.follow)) *centre = *at;
    now.from += *centre, now.at += *centre;
    const std::string digits = std::to_string(number);
    const std::string zeros(digits.size() < 5 ? 5 - digits.size() : 0, '0');
    write_povray(w, folder + "/frame_" + zeros + digits + ".pov", now);
  };
  w.synchronize();
  auto& s = detail::state_of(w);
  {
    const detail::function_clock clock(s, s.functions.number("pictures of --frames"));
    take(w.steps() / options.every);
  }
  w.monitor_each_step("pictures of --frames", [&w, take, lock, every = options.every] {
    if (w.steps() % every == 0) take(w.steps() / every);
  });
}

/// Refuses other fields.
template <class Scenario, detail::sentence Fields = detail::fields::picture>
detail::fields::no_picture<Fields> take_pictures(world<Scenario>&, detail::any_options,
                                                 ...) TALUS_REFUSED;

}  // namespace talus
