// The SVD of a single matrix, as `svd` of svd.hpp with the precision `kExact`; false where this processor, or this size, has
// no other way than that one.
#pragma once

namespace rankdrop {

bool svd_of_one(double* matrix, int rows, int columns, double* sigma, double* vectors);

#if defined(RANKDROP_HAVE_X86_SETS)
namespace avx2 {
bool svd_of_one(double* matrix, int rows, int columns, double* sigma, double* vectors);
}
#endif

}  // namespace rankdrop
