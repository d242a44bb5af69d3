#pragma once
// The end of Python while its threads work with worlds.
#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>

namespace talus::detail {

/// The end of Python, for all worlds of a module. Threads that work with one come back with an
/// exception, before the interpreter ends below them. All functions hold its lock.
class end_of_python {
 public:
  /// During its lifetime Python does not end while `patience` lasts.
  class at_work {
   public:
    explicit at_work(end_of_python& end) : end_(end) { ++end_.working_; }
    at_work(const at_work&) = delete;
    at_work& operator=(const at_work&) = delete;
    ~at_work() { --end_.working_; }

   private:
    end_of_python& end_;
  };
  /// During its lifetime Python does not end, for any time, and the thread does not hold the lock
  /// of the interpreter: a scene returns after its present step, or at the end of its set-up.
  class in_scene {
   public:
    explicit in_scene(end_of_python& end) : count_{end} {}

   private:
    struct counted {
      explicit counted(end_of_python& end) : of(end) { ++of.in_scenes_; }
      counted(const counted&) = delete;
      counted& operator=(const counted&) = delete;
      ~counted() { --of.in_scenes_; }
      end_of_python& of;
    } count_;
    pybind11::gil_scoped_release release_;
  };

  [[nodiscard]] bool began() const { return began_; }
  /// Throws runtime_error on other threads than the one that ends Python.
  void require_more() const {
    if (began_ && std::this_thread::get_id() != on_)
      throw std::runtime_error("Python ends, so this world makes no more steps");
  }
  /// Begins the end, and waits for the threads at work. Their functions of Python have `patience`
  /// to return; Ctrl-C ends the wait.
  void wait(std::chrono::milliseconds patience) {
    on_ = std::this_thread::get_id();
    began_ = true;
    for (; in_scenes_ > 0 || (working_ > 0 && patience.count() > 0); --patience) {
      {
        const pybind11::gil_scoped_release release;  // another thread needs it to come back
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      if (PyErr_CheckSignals() != 0) return PyErr_Clear();
    }
  }

 private:
  std::atomic<bool> began_ = false;
  std::atomic<int> working_ = 0, in_scenes_ = 0;
  std::thread::id on_;  ///< the thread that ends Python
};

}  // namespace talus::detail
