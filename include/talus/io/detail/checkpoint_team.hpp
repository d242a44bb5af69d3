#pragma once
// Communication of ranks while they write or read a file. Its users do not depend on the transport.
#include <cstdint>
#include <exception>
#include <span>
#include <string>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/core/error.hpp"
#include "talus/parallel/reduction.hpp"

namespace talus::detail {

/// All functions are collective.
class checkpoint_team {
 public:
  checkpoint_team() = default;
  checkpoint_team(const checkpoint_team&) = delete;
  checkpoint_team& operator=(const checkpoint_team&) = delete;
  virtual ~checkpoint_team() = default;

  [[nodiscard]] virtual int rank() const = 0;
  [[nodiscard]] virtual int size() const = 0;
  virtual void barrier() = 0;
  [[nodiscard]] virtual std::vector<byte_buffer> gather(const byte_buffer& mine) = 0;
  [[nodiscard]] virtual std::vector<byte_buffer> gather_all(const byte_buffer& mine) = 0;
  virtual void broadcast(byte_buffer& bytes) = 0;
  virtual void most(std::span<std::uint64_t> values) = 0;
  virtual void sum(std::span<std::uint64_t> values) = 0;
  /// Whether each rank is a process of its own.
  [[nodiscard]] virtual bool of_processes() const = 0;

  /// Calls f() on this rank; if it fails on any rank, throws runtime_error with the same words on
  /// all.
  template <class F>
  void together(F&& f) {
    std::string problem;
    try {
      f();
    } catch (const aborted&) {
      throw;
    } catch (const std::exception& e) {
      problem = e.what();
      if (problem.empty()) problem = "unknown error";
    }
    agree(problem);
  }

 private:
  [[gnu::cold]] void agree(const std::string& problem);
};

template <class Link>
class team_over final : public checkpoint_team {
 public:
  explicit team_over(Link& link) : link_(link) {}
  [[nodiscard]] int rank() const override { return link_.rank(); }
  [[nodiscard]] int size() const override { return link_.size(); }
  void barrier() override { link_.barrier(); }
  [[nodiscard]] std::vector<byte_buffer> gather(const byte_buffer& mine) override {
    return link_.gather(mine);
  }
  [[nodiscard]] std::vector<byte_buffer> gather_all(const byte_buffer& mine) override {
    return link_.gather_all(mine);
  }
  void broadcast(byte_buffer& bytes) override { link_.broadcast(bytes); }
  void most(std::span<std::uint64_t> values) override { link_.reduce(reduction::max, values); }
  void sum(std::span<std::uint64_t> values) override { link_.reduce(reduction::sum, values); }
  [[nodiscard]] bool of_processes() const override {
    if constexpr (requires { *link_.communicator(); })
      return link_.communicator() != nullptr;
    else
      return requires { link_.communicator(); };
  }

 private:
  Link& link_;
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED_HDF5
#include "talus/io/detail/checkpoint_team_definitions.hpp"
#endif
