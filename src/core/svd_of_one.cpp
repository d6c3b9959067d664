// The SVD of a single matrix, for kernels of other instruction sets.
#include "svd_of_one.hpp"

#include "single_svd.hpp"

namespace rankdrop::RANKDROP_ISA {

bool svd_of_one(double* matrix, int rows, int columns, double* sigma, double* vectors) {
    return svd_of_single(matrix, rows, columns, sigma, vectors);
}

}  // namespace rankdrop::RANKDROP_ISA
