// What the bindings share: arrays in and out, batches over threads without the interpreter's lock.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <string>

#include "kernels.hpp"
#include "memory.hpp"
#include "pool.hpp"

namespace nb = nanobind;

namespace rankdrop {

using In1 = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using In2 = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Out2 = nb::ndarray<double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using In3 = nb::ndarray<const double, nb::ndim<3>, nb::c_contig, nb::device::cpu>;
using Flags = nb::ndarray<const bool, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

// An array that the core fills: its own until NumPy gets it, with the memory.
template <class T>
class Result {
  public:
    explicit Result(std::initializer_list<std::size_t> shape) : shape_(shape), memory_(allocate_result(sizeof(T) * size())) {}

    T* data() const { return static_cast<T*>(memory_.get()); }

    std::size_t size() const {
        return std::accumulate(shape_.begin(), shape_.end(), std::size_t{1}, [](std::size_t all, std::size_t next) {
            if (next != 0 && all > std::numeric_limits<std::size_t>::max() / sizeof(T) / next) throw std::bad_alloc();
            return all * next;
        });
    }

    Result& fill(T value) {
        std::fill(data(), data() + size(), value);
        return *this;
    }

    nb::object give() {
        T* values = data();
        nb::capsule owner(values, [](void* memory) noexcept { Release()(memory); });
        static_cast<void>(memory_.release());  // the capsule's from here on
        return nb::cast(nb::ndarray<nb::numpy, T>(values, shape_.size(), shape_.data(), owner));
    }

  private:
    std::vector<std::size_t> shape_;
    Memory memory_;
};

// Where a batch is written: the caller's own array, or one that NumPy gets.
class Target {
  public:
    Target(const nb::object& out, std::initializer_list<std::size_t> shape) {
        if (out.is_none()) {
            own_.emplace(shape);
            return;
        }
        if (!nb::try_cast(out, given_, false)) throw nb::type_error("out is a C-contiguous, writable array of float64");
        if (given_.ndim() != shape.size() || !std::equal(shape.begin(), shape.end(), given_.shape_ptr()))
            throw nb::value_error("out has the wrong shape");
        object_ = out;
    }

    double* data() const { return own_ ? own_->data() : given_.data(); }
    nb::object give() { return own_ ? own_->give() : object_; }

    // Rows are read while others are written.
    void apart_from(const In2& q) const {
        const double *begin = data(), *end = begin + (own_ ? own_->size() : given_.size());
        const double *first = q.data(), *last = first + q.size();
        if (std::less<>()(first, end) && std::less<>()(begin, last)) throw nb::value_error("out and q share memory");
    }

  private:
    std::optional<Result<double>> own_;
    nb::ndarray<double, nb::c_contig, nb::device::cpu> given_;
    nb::object object_;
};

inline constexpr std::int64_t kAlone = 256;                   // rows that are not worth a thread
inline constexpr std::int64_t kShort = 4096;                  // rows that one thread does without looking up
inline constexpr std::int64_t kLeastChunk = 64, kMostChunk = 256;  // rows done at one go

// work(begin, end) over all rows, in chunks over threads, without the interpreter's lock. Small batches stay on the
// calling thread. Throws what Python's signal handlers raised meanwhile.
template <class Work>
void each(std::size_t count, int threads, Work work) {
    const std::int64_t rows = static_cast<std::int64_t>(count);
    if (rows <= (threads == 1 ? kShort : kAlone)) {
        nb::gil_scoped_release release;
        work(std::int64_t{0}, rows);
        return;
    }
    std::atomic<bool> stop{false};
    bool raised = false;
    {
        nb::gil_scoped_release release;
        const std::int64_t chunk = threads == 1 ? kMostChunk : std::clamp(rows / 16 / 8 * 8, kLeastChunk, kMostChunk);
        share({rows, chunk, threads}, stop, std::ref(work), [&] {
            nb::gil_scoped_acquire acquire;
            raised = PyErr_CheckSignals() != 0;
            return raised;
        });
    }
    if (raised) throw nb::python_error();
}

inline std::vector<double> numbers(const In1& array) { return {array.data(), array.data() + array.shape(0)}; }

inline void fit(const Chain& chain, const In2& q) {
    if (static_cast<int>(q.shape(1)) != chain.variables) throw nb::value_error("q has the wrong number of columns");
}

// A view names links by number: it fits chains with as many links as the one it was made for.
inline void fit(const Chain& chain, const View& view) {
    if (view.links != chain.links()) throw nb::value_error("the view is of a chain with another number of links");
}

inline void fit(const Chain& chain, const View& view, const In2& q) {
    fit(chain, view);
    fit(chain, q);
}

// One scale for each variable, and limits (2, n) or none.
inline void fit(const Chain& chain, const std::vector<double>& scale, const std::vector<double>& lower) {
    const std::size_t n = static_cast<std::size_t>(chain.variables);
    if (scale.size() != n) throw nb::value_error("one scale for each variable");
    if (!lower.empty() && lower.size() != n) throw nb::value_error("limits have shape (2, n)");
}

// Rows of `limits`, (2, n), into two vectors.
inline void take_limits(const std::optional<In2>& limits, std::vector<double>& lower, std::vector<double>& upper) {
    if (!limits) return;
    if (limits->shape(0) != 2) throw nb::value_error("limits have shape (2, n)");
    const double *first = limits->data(), *second = first + limits->shape(1);
    lower.assign(first, second), upper.assign(second, second + limits->shape(1));
}

void bind_chain(nb::module_& module);
void bind_search(nb::module_& module);
void bind_certify(nb::module_& module);
void bind_families(nb::module_& module);
void bind_cover(nb::module_& module);
void bind_aim(nb::module_& module);

}  // namespace rankdrop
