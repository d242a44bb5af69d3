#pragma once
// The end of Python while its threads work with worlds.
#include <cxxabi.h>
#include <pybind11/pybind11.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <utility>

namespace talus::detail {

/// The end of Python, for all worlds of a module. Threads that work with one come back with an
/// exception, before the interpreter ends below them. All functions hold its lock.
class end_of_python {
  /// Counts a thread. A fork lacks the threads that its parent has counted.
  class counted {
   public:
    counted(end_of_python& end, std::atomic<int> end_of_python::*of)
        : end_(end), of_(of), process_(end.begin_in_fork()) {
      ++(end_.*of_);
    }
    counted(const counted&) = delete;
    counted& operator=(const counted&) = delete;
    ~counted() {
      if (process_ == end_.process_) --(end_.*of_);
    }

   private:
    end_of_python& end_;
    std::atomic<int> end_of_python::*of_;
    ::pid_t process_;
  };

 public:
  /// During its lifetime Python does not end while `patience` lasts.
  class at_work {
   public:
    explicit at_work(end_of_python& end) : count_(end, &end_of_python::working_) {}

   private:
    counted count_;
  };
  /// During its lifetime Python does not end, for any time, and the thread does not hold the lock
  /// of the interpreter: a scene returns after its present step, or at the end of its set-up.
  class in_scene {
   public:
    explicit in_scene(end_of_python& end) : count_(end, &end_of_python::in_scenes_) {}

   private:
    counted count_;
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
    begin_in_fork();
    on_ = std::this_thread::get_id();
    began_ = true;
    const auto last = std::chrono::steady_clock::now() + patience;
    while (in_scenes_ > 0 || (working_ > 0 && std::chrono::steady_clock::now() < last)) {
      {
        const pybind11::gil_scoped_release release;  // another thread needs it to come back
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      if (PyErr_CheckSignals() != 0) return PyErr_Clear();
    }
  }

 private:
  /// In a fork, forgets the threads of its parent. Returns the process.
  ::pid_t begin_in_fork() {
    const ::pid_t here = ::getpid();
    if (std::exchange(process_, here) != here) working_ = in_scenes_ = 0, began_ = false;
    return here;
  }

  ::pid_t process_ = ::getpid();
  std::atomic<bool> began_ = false;
  std::atomic<int> working_ = 0, in_scenes_ = 0;
  std::thread::id on_;  ///< the thread that ends Python
};

/// Calls f(x) of Python, which may not return before Python ends. Python then stops the thread and
/// unwinds its stack, whose objects refer to what is no longer there: the thread stays here till
/// the process ends.
inline void call_of_thread(const pybind11::function& f, const pybind11::object& x) {
  PyObject* returned = nullptr;
#ifdef __GLIBCXX__
  try {
    returned = PyObject_CallFunctionObjArgs(f.ptr(), x.ptr(), nullptr);
  } catch (const abi::__forced_unwind&) {
    for (;;) ::pause();
  }
#else
  returned = PyObject_CallFunctionObjArgs(f.ptr(), x.ptr(), nullptr);
#endif
  if (returned == nullptr) throw pybind11::error_already_set();
  Py_DECREF(returned);
}

}  // namespace talus::detail
