#pragma once
// A scene on a thread of its own, which runs only while its caller waits for it.
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>

namespace talus::detail {

/// Unwinds the set-up of a scene whose caller does not need it any more. It is a std::exception, so
/// run passes it on.
struct scene_closed final : std::exception {
  [[nodiscard]] const char* what() const noexcept override { return "the world was closed"; }
};

/// Runs a function that calls yield() where its caller takes over. Between two resumptions the
/// thread is suspended there, so the local variables of the function stay alive, and its world is
/// at rest. So the set-up of run<...>, which simulates to the end, can be driven from outside.
class scene_thread {
 public:
  /// Is called by a waiting caller ten times per second.
  using poll_type = std::function<void()>;

  scene_thread() = default;
  scene_thread(const scene_thread&) = delete;
  scene_thread& operator=(const scene_thread&) = delete;
  ~scene_thread() { close(); }

  /// Starts the function; returns when it yields or ends.
  void start(std::function<void()> main, const poll_type& poll) {
    turns_ = std::make_unique<turns>();
    turn_ = turn::scene;
    process_ = ::getpid();
    thread_ = std::thread([this, main = std::move(main)] {
      std::exception_ptr error;
      try {
        main();
      } catch (const scene_closed&) {
      } catch (...) {
        error = std::current_exception();
      }
      const std::lock_guard lock(turns_->mutex);
      error_ = std::exchange(closing_, true) ? nullptr : error;
      ended_ = true;
      turn_ = turn::caller;
      turns_->changed.notify_all();
    });
    wait(poll);
  }
  /// Lets the function go on; returns when it yields again or ends.
  void resume(const poll_type& poll) {
    if (ended_) return;
    hand_over();
    wait(poll);
  }
  /// Calls `job` on the thread of the function, which stays where it yielded. Throws what the job
  /// throws.
  void run_there(std::function<void()> job) {
    if (ended_) return;
    job_ = std::move(job);
    hand_over();
    wait({});
    job_ = nullptr;
    if (const auto error = std::exchange(job_error_, nullptr)) std::rethrow_exception(error);
  }
  /// Ends the function: yield() throws scene_closed in it. Afterwards the thread is gone.
  void close() {
    if (!thread_.joinable()) return;
    if (!here()) {  // a fork has no copy of the thread, which may hold the mutex or wait there
      // Another thread of the fork may have its number: it must not be detached or joined.
      new std::thread(std::move(thread_));
      (void)turns_.release();  // the end of a condition variable waits for its waiters
      return;
    }
    if (!ended_) {
      {
        const std::lock_guard lock(turns_->mutex);
        closing_ = true;
      }
      hand_over();
      wait({});
    }
    thread_.join();
  }

  /// Whether this is the process that started it, not a fork of that.
  [[nodiscard]] bool here() const { return process_ == ::getpid(); }
  /// Whether the function has ended.
  [[nodiscard]] bool ended() const { return ended_; }
  /// The exception that ended it, unless that was close(); null otherwise.
  [[nodiscard]] std::exception_ptr error() const { return error_; }

  /// Called by the function: suspends it until the caller resumes it. Throws scene_closed.
  void yield() {
    std::unique_lock lock(turns_->mutex);
    for (;;) {
      if (closing_) throw scene_closed();
      turn_ = turn::caller;
      turns_->changed.notify_all();
      turns_->changed.wait(lock, [&] { return turn_ == turn::scene; });
      if (closing_) throw scene_closed();
      if (!job_) return;
      lock.unlock();
      try {
        job_();
      } catch (...) {
        job_error_ = std::current_exception();
      }
      lock.lock();
    }
  }

 private:
  enum class turn { caller, scene };
  /// How the two threads take turns.
  struct turns {
    std::mutex mutex;
    std::condition_variable changed;
  };

  void hand_over() {
    if (!here())
      throw std::runtime_error(
          "this world belongs to the process that made it, and a fork cannot use it: make a world "
          "in each process");
    const std::lock_guard lock(turns_->mutex);
    turn_ = turn::scene;
    turns_->changed.notify_all();
  }
  void wait(const poll_type& poll) {
    std::unique_lock lock(turns_->mutex);
    const auto mine = [&] { return turn_ == turn::caller; };
    while (!turns_->changed.wait_for(lock, std::chrono::milliseconds(100), mine)) {
      lock.unlock();
      if (poll) poll();
      lock.lock();
    }
  }

  std::unique_ptr<turns> turns_;
  turn turn_ = turn::caller;
  bool closing_ = false, ended_ = false;
  ::pid_t process_ = 0;  ///< that started the thread
  std::function<void()> job_;
  std::exception_ptr error_, job_error_;
  std::thread thread_;
};

}  // namespace talus::detail
