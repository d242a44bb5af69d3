#pragma once
// A compiled scene that Python drives: its set-up runs on a thread of its own, and is suspended
// after the steps that were asked for.
#include <pybind11/pybind11.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/io/run_signals.hpp"
#include "talus/observe/summary.hpp"
#include "talus/python/end_of_python.hpp"
#include "talus/python/lent_columns.hpp"
#include "talus/python/scene_thread.hpp"
#include "talus/scene/run.hpp"
#include "talus/world/world.hpp"

namespace talus::detail {

/// One world of a scene, from its set-up to its end, as run<Scenario, Options> would make it. All
/// functions hold the lock of the interpreter, and release it while the scene runs.
template <class Scenario, class Options, class SetUp>
class session {
 public:
  using world_type = world<Scenario>;

  /// `words` are the arguments of a command line. Throws usage_error.
  session(const SetUp& set_up, std::string name, const std::vector<std::string>& words,
          std::shared_ptr<end_of_python> end)
      : set_up_(set_up), name_(std::move(name)), words_(words), end_(std::move(end)) {
    arguments_.push_back(name_.c_str());
    for (const std::string& word : words_) arguments_.push_back(word.c_str());
    options_ = parse<Options>(static_cast<int>(arguments_.size()), arguments_.data(), {}, "",
                              withdraw_options<Scenario>);
    if (options_.ranks > 1)
      fail<std::invalid_argument>(
          "{} ranks are asked for, but Python drives worlds of one rank: run the program itself on "
          "several ranks, and read its output",
          options_.ranks);
    if (find_launcher().size > 1)
      throw std::runtime_error(
          "Python was started by mpirun as several processes, but it drives worlds of one rank: "
          "start it without mpirun");
  }
  /// Runs the set-up up to the start of its first simulate() with a step to make, or to its end.
  /// Throws what the set-up throws.
  void begin() {
    const only_one busy(*this);
    {
      const end_of_python::in_scene there(*end_);
      thread_.start([this] { main(); }, {});
    }
    rethrow();
  }
  ~session() {
    try {
      close();
    } catch (...) {  // close() reports it
    }
  }

  /// Makes `n` steps, or fewer if the set-up ends before. After the last step of a simulate() the
  /// set-up also runs on to the next one with a step to make, or to its end. Returns their number.
  /// Throws runtime_error if it had ended before, what the steps throw, and the exception of a
  /// signal, such as KeyboardInterrupt, after the present step.
  std::uint64_t step(std::uint64_t n) {
    if (n == 0) return 0;
    (void)open();
    require_more();
    const only_one busy(*this);
    lent_.keep();
    made_ = 0, asked_ = n, interrupted_ = false;
    std::exception_ptr signal;
    {
      const end_of_python::in_scene there(*end_);
      thread_.resume([&] {
        const pybind11::gil_scoped_acquire acquire;
        if (signal || PyErr_CheckSignals() == 0) return;
        signal = std::make_exception_ptr(pybind11::error_already_set());
        interrupted_ = true;
      });
    }
    rethrow();
    if (signal) std::rethrow_exception(signal);
    return made_;
  }

  /// Throws runtime_error if the set-up has come to its end.
  void require_more() {
    if (!over_) return;
    const std::uint64_t steps = open().steps();
    fail<std::runtime_error>(
        "the set-up has ended after {} steps, so there is nothing more to simulate: make a world "
        "with more steps, as in World(steps={})",
        steps, 2 * std::max<std::uint64_t>(steps, 1));
  }
  /// Calls f(world), which changes nothing, on the thread of the scene.
  template <class F>
  auto read(F&& f) {
    world_type& w = open();
    const only_one busy(*this);
    using result = std::invoke_result_t<F&, world_type&>;
    const end_of_python::in_scene there(*end_);
    if constexpr (std::is_void_v<result>) {
      thread_.run_there([&] { f(w); });
    } else {
      result r{};
      thread_.run_there([&] { r = f(w); });
      return r;
    }
  }
  /// Calls f(world), which may change the world, likewise.
  template <class F>
  auto change(F&& f) {
    (void)open();
    require_idle();
    lent_.keep();
    return read(std::forward<F>(f));
  }
  /// The world, to read single numbers. Throws runtime_error if it was closed or ended by an error.
  [[nodiscard]] world_type& open() {
    require_idle();
    if (world_ == nullptr)
      throw std::runtime_error(failed_.empty() ? "this world was closed: make another one"
                                               : "this world was ended by an error: " + failed_);
    return *world_;
  }
  /// Ends the scene; arrays that were taken from it stay valid. Files of options, such as json, are
  /// complete if the set-up has come to its end. Throws runtime_error if one cannot be written.
  void close() {
    if (world_ == nullptr) return;
    const only_one busy(*this);
    lent_.keep();
    {
      const end_of_python::in_scene there(*end_);
      if (over_ && thread_.here()) thread_.resume({});  // to the end of the run
      thread_.close();
      world_ = nullptr;
    }
    rethrow();
  }

  [[nodiscard]] end_of_python& end() { return *end_; }
  /// Whether the set-up has come to its end.
  [[nodiscard]] bool over() const { return over_; }
  [[nodiscard]] lent_columns& lent() { return lent_; }
  [[nodiscard]] const Options& options() const { return options_; }
  [[nodiscard]] const std::string& name() const { return name_; }
  /// What the set-up has returned.
  [[nodiscard]] const results& own() const { return own_; }

 private:
  void require_idle() const {
    end_->require_more();
    if (busy_ && thread_.here())  // a fork lacks the thread
      throw std::runtime_error(
          "another thread works with this world: wait until it has finished, or give each thread "
          "its own world");
  }
  /// During its lifetime other threads of Python are refused.
  struct only_one {
    explicit only_one(session& s) : of(s) { s.require_idle(), s.busy_ = true; }
    only_one(const only_one&) = delete;
    only_one& operator=(const only_one&) = delete;
    ~only_one() { of.busy_ = false; }
    session& of;
  };

  /// On the thread of the scene.
  void main() {
    std::optional<listen_to_signals> listening;
    if constexpr (Scenario::template has_feature<checkpoints>)
      if (!options_.checkpoint.empty()) listening.emplace();
    launch_settings settings;
    settings.ranks = 1;
    settings.default_ranks = 1;
    settings.patience = 0;
    const auto driven = [this](world_type& w, const Options& o) -> results {
      drive(w, o);
      return own_;
    };
    Scenario::transport::launch(settings, [&](auto& link) {
      struct leave {
        session* of;
        ~leave() { of->world_ = nullptr; }
      } const at_the_end{this};
      run_log log(name_);
      log.open(options_, static_cast<int>(arguments_.size()), arguments_.data(), program_build());
      const int code =
          run_rank<Scenario>(link, std::as_const(options_), name_, driven, log, wall_seconds());
      if (log.finish(code) != code)
        throw std::runtime_error("the run has lost a line of its log or of standard output");
      if (code == exit_code_of_time_limit)
        throw std::runtime_error("the run was ended by its time limit (time_limit)");
      if (code > 128)
        fail<std::runtime_error>("the run was ended by signal {}; its checkpoint is {}", code - 128,
                                 options_.checkpoint);
    });
  }
  void drive(world_type& w, const Options& o) {
    world_ = &w;
    // After the last step of a simulate() the set-up goes on to the next one with a step to make,
    // or to its end.
    w.before_simulating("Python", [this, &w] {
      if (w.steps() == w.last_step()) return;
      if (!std::exchange(begun_, true) || std::exchange(due_, false)) thread_.yield();
    });
    w.monitor_after_observers("Python", [this, &w] {
      if (++made_ != asked_ && !interrupted_ && !end_->began()) return;
      due_ = w.steps() == w.last_step();
      if (due_) return;
      close_ledger(state_of(w));  // the caller may change the world
      thread_.yield();
    });
    if constexpr (std::is_void_v<decltype(set_up_(w, o))>)
      set_up_(w, o);
    else
      own_ = set_up_(w, o);
    over_ = true;
    thread_.yield();  // the world stays, to be read
  }
  /// On the thread of the caller, after the scene has run.
  void rethrow() {
    if (!thread_.ended()) return;
    const std::exception_ptr error = thread_.error();
    if (!error) return;
    try {
      std::rethrow_exception(error);
    } catch (const std::exception& e) {
      failed_ = e.what();
      throw;
    }
  }

  SetUp set_up_;
  std::string name_;
  std::vector<std::string> words_;
  std::shared_ptr<end_of_python> end_;
  std::vector<const char*> arguments_;
  Options options_;
  results own_;
  std::string failed_;
  world_type* world_ = nullptr;  ///< on the stack of the scene's thread
  lent_columns lent_;
  std::uint64_t asked_ = 0, made_ = 0;
  std::atomic<bool> interrupted_ = false;
  bool begun_ = false, over_ = false;
  bool due_ = false;   ///< the caller waits for the end of the present simulate()
  bool busy_ = false;  ///< a thread of Python is in one of the functions
  scene_thread thread_;
};

}  // namespace talus::detail
