#pragma once
// Columns of bodies as numpy arrays without a copy, which stay valid when the world changes.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace talus::detail {

/// Lends columns to numpy arrays, which are read-only and refer to the memory of the world. Before
/// the world changes, keep() gives each column with a living array to the arrays, and the world a
/// copy: an array shows the state in which it was taken as long as it lives, and a column without a
/// living array is never copied. All calls hold the lock of the interpreter, while no step is made.
class lent_columns {
  struct loan {
    virtual ~loan() = default;
    virtual void keep() = 0;
    const void* column = nullptr;  ///< null: the arrays have the column to themselves
  };
  template <class Column>
  struct loan_of final : loan {
    explicit loan_of(Column& c) : from(&c) { column = &c; }
    void keep() override {
      Column copy = *from;
      own = std::move(*from);  // the memory stays where it is
      *from = std::move(copy);
      column = nullptr;
    }
    Column* from;
    Column own{};
  };

 public:
  /// The first `rows` values of a column, each with `width` numbers (0: the array has one
  /// dimension) that begin at `first` for the first one.
  template <class Number, class Column>
  [[nodiscard]] pybind11::array lend(Column& column, std::size_t rows, std::size_t width,
                                     const Number* first) {
    namespace py = pybind11;
    using value = typename Column::value_type;
    std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(rows)};
    std::vector<py::ssize_t> strides{sizeof(value)};
    if (width > 0) {
      shape.push_back(static_cast<py::ssize_t>(width));
      strides.push_back(sizeof(Number));
    }
    py::array result;
    if (rows == 0) {
      result = py::array(py::dtype::of<Number>(), shape);
    } else {
      auto* const owner = new std::shared_ptr<loan>(loan_for(column));
      const py::capsule base(owner, [](void* p) { delete static_cast<std::shared_ptr<loan>*>(p); });
      result = py::array(py::dtype::of<Number>(), shape, strides, first, base);
    }
    result.attr("setflags")(py::arg("write") = false);
    return result;
  }
  /// To be called before anything changes or frees columns.
  void keep() {
    for (const auto& one : loans_)
      if (const auto alive = one.lock(); alive && alive->column != nullptr) alive->keep();
    loans_.clear();
  }

 private:
  /// All arrays of a column share one loan.
  template <class Column>
  [[nodiscard]] std::shared_ptr<loan> loan_for(Column& column) {
    std::erase_if(loans_, [](const auto& one) { return one.expired(); });
    for (const auto& one : loans_)
      if (auto alive = one.lock(); alive && alive->column == &column) return alive;
    auto made = std::make_shared<loan_of<Column>>(column);
    loans_.push_back(made);
    return made;
  }

  std::vector<std::weak_ptr<loan>> loans_;
};

}  // namespace talus::detail
