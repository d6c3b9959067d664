// NumPy's arrays as they lie in memory, for calls that take less time than a general view of an array does: nanobind's,
// or Python's buffer, cost as much as a Jacobian each. What is used is part of NumPy's stable binary interface, the same
// from 1.7 on, fetched when it is first needed; where it is not found there is no plain array, and nobody takes this way.
#pragma once

#include <nanobind/nanobind.h>

namespace rankdrop {

// The head of every array (PyArrayObject_fields of NumPy's ndarraytypes.h).
struct ArrayFields {
    PyObject_HEAD
    char* data;
    int nd;
    Py_ssize_t* dimensions;
    Py_ssize_t* strides;
    PyObject* base;
    PyObject* descr;
    int flags;

    bool writable() const { return (flags & 0x0400) != 0; }
};

// Functions of NumPy by their places in its table (`_ARRAY_API`).
struct NumPy {
    PyTypeObject* array = nullptr;  // 2: the type ndarray itself
    PyObject* float64 = nullptr;    // what 45, PyArray_DescrFromType, gives for native doubles: always the same object
    // 93, PyArray_New
    PyObject* (*make)(PyTypeObject*, int nd, const Py_ssize_t* dims, int type, const Py_ssize_t*, void*, int, int, PyObject*) = nullptr;

    NumPy() {
        PyObject* module = PyImport_ImportModule("numpy._core._multiarray_umath");
        if (!module) PyErr_Clear(), module = PyImport_ImportModule("numpy.core._multiarray_umath");  // before NumPy 2
        const nanobind::object owned = nanobind::steal(module);
        const nanobind::object api = nanobind::steal(module ? PyObject_GetAttrString(module, "_ARRAY_API") : nullptr);
        void** table = api.is_valid() ? static_cast<void**>(PyCapsule_GetPointer(api.ptr(), nullptr)) : nullptr;
        PyErr_Clear();
        if (!table) return;  // another NumPy: without this way
        float64 = reinterpret_cast<PyObject* (*)(int)>(table[45])(kDouble);
        make = reinterpret_cast<decltype(make)>(table[93]);
        array = static_cast<PyTypeObject*>(table[2]);
    }

    static constexpr int kDouble = 12;
};

inline const NumPy& numpy() {
    static const NumPy found;
    return found;
}

// The fields of a C-contiguous, aligned ndarray of native doubles, no subclass; null for anything else.
inline const ArrayFields* plain_array(PyObject* object) {
    const NumPy& np = numpy();
    if (Py_TYPE(object) != np.array) return nullptr;
    const auto* fields = reinterpret_cast<const ArrayFields*>(object);
    constexpr int kContiguous = 0x0001, kAligned = 0x0100;
    const bool plain = fields->descr == np.float64 && (fields->flags & (kContiguous | kAligned)) == (kContiguous | kAligned);
    return plain ? fields : nullptr;
}

// A new array of doubles, not initialised; null with Python's error set where there is no memory.
inline PyObject* new_array(const Py_ssize_t* shape, int nd) {
    const NumPy& np = numpy();
    return np.make(np.array, nd, shape, NumPy::kDouble, nullptr, nullptr, 0, 0, nullptr);
}

}  // namespace rankdrop
