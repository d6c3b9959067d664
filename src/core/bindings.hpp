// What the bindings share: arrays in and out, batches over threads without the interpreter's lock.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <string>

#include "kernels.hpp"
#include "parallel.hpp"

namespace nb = nanobind;

namespace rankdrop {

using In1 = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using In2 = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Out2 = nb::ndarray<double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using In3 = nb::ndarray<const double, nb::ndim<3>, nb::c_contig, nb::device::cpu>;

inline constexpr std::int64_t kChunk = 256;

template <class T>
nb::object array(T* data, std::initializer_list<std::size_t> shape) {
    nb::capsule owner(data, [](void* p) noexcept { delete[] static_cast<T*>(p); });
    return nb::cast(nb::ndarray<nb::numpy, T>(data, shape.size(), shape.begin(), owner));
}

template <class T>
T* make(std::size_t count) {
    return new T[count > 0 ? count : 1];
}

// rows in chunks over threads, without the interpreter's lock; small batches stay on the calling thread
template <class Work>
void each(std::int64_t rows, int threads, Work work) {
    nb::gil_scoped_release release;
    if (threads == 1 || rows <= kChunk) {
        work(0, rows);
        return;
    }
    volatile bool stop = false;
    parallel_rows(rows, kChunk, threads, &stop, work, [] { return false; });
}

inline void fit(const Chain& chain, const In2& q) {
    if ((int)q.shape(1) != chain.variables) throw nb::value_error("q has the wrong number of columns");
}

void bind_chain(nb::module_& module);
void bind_search(nb::module_& module);
void bind_certify(nb::module_& module);
void bind_families(nb::module_& module);

}  // namespace rankdrop
