// A readable basis of a subspace: orthonormal columns with as many zeros as plane rotations find. One matrix at a time,
// in plain doubles: the work is choices, not arithmetic.
#pragma once

#include <cstdint>

namespace rankdrop {

// (B, rows, columns) orthonormal columns -> (B, rows, columns), 1 <= columns <= rows; matrices by rows.
void readable(int rows, int columns, const double* in, std::int64_t count, double* out);

}  // namespace rankdrop
