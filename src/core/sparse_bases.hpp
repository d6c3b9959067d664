// Bases of a subspace with many zeros: those that depend on the subspace only, and plane rotations that make them
// better. Matrices are stored by columns.
#pragma once

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace rankdrop {

inline constexpr double kTie = 1e-6;        // sums and entries closer than this are equal
inline constexpr double kSame = 1e-9;       // sums that differ by rounding
inline constexpr double kWell = 1e-3;       // rows more dependent than this give no start
inline constexpr double kLower = 1e-12;     // a sweep has to lower the sum by this
inline constexpr int kSweeps = 50;          // rounds over all planes; two or three are the rule
inline constexpr int kSwept = 12;           // starts that are swept

using Vector = std::vector<double>;  // matrices by columns

inline double dot(const double* a, const double* b, int n) {
    double sum = 0.0;
    for (int i = 0; i < n; ++i) sum += a[i] * b[i];
    return sum;
}

inline double sum_of_sizes(const double* a, int n) {
    double sum = 0.0;
    for (int i = 0; i < n; ++i) sum += std::fabs(a[i]);
    return sum;
}

// One-sided Jacobi on `count` columns of length n: w <- w r, columns orthogonal; returns the smallest length.
inline double orthogonalise(double* w, int n, int count, double* r) {
    for (int sweep = 0; sweep < 30; ++sweep) {
        bool settled = true;
        for (int i = 0; i < count; ++i)
            for (int j = i + 1; j < count; ++j) {
                double *x = w + i * n, *y = w + j * n;
                const double xx = dot(x, x, n), yy = dot(y, y, n), xy = dot(x, y, n);
                if (xy * xy <= 1e-31 * xx * yy) continue;
                settled = false;
                const double d = yy - xx, p = 2 * xy;
                const double t = std::copysign(1.0, d) * p / (std::fabs(d) + std::sqrt(d * d + p * p));
                const double c = 1.0 / std::sqrt(1.0 + t * t), s = c * t;
                const auto turn = [&](double* a, double* b, int length) {
                    for (int k = 0; k < length; ++k) {
                        const double u = a[k], v = b[k];
                        a[k] = c * u - s * v, b[k] = s * u + c * v;
                    }
                };
                turn(x, y, n);
                if (r) turn(r + i * count, r + j * count, count);
            }
        if (settled) break;
    }
    double least = 1e300;
    for (int i = 0; i < count; ++i) least = std::min(least, std::sqrt(dot(w + i * n, w + i * n, n)));
    return least;
}

inline void normalise(double* x, int n) {
    const double length = std::sqrt(dot(x, x, n));
    for (int k = 0; k < n; ++k) x[k] /= length;
}

// Next choice of `count` rows out of `rows`, in lexicographic order; false after the last one.
inline bool next_choice(std::vector<int>& chosen, int rows) {
    const int count = (int)chosen.size();
    int i = count - 1;
    while (i >= 0 && chosen[i] == rows - count + i) --i;
    if (i < 0) return false;
    ++chosen[i];
    for (int j = i + 1; j < count; ++j) chosen[j] = chosen[j - 1] + 1;
    return true;
}

inline std::vector<int> first_choice(int count) {
    std::vector<int> chosen(count);
    std::iota(chosen.begin(), chosen.end(), 0);
    return chosen;
}

// Unit vector of the span of k orthonormal columns that vanishes in k - 1 chosen rows; false where they are dependent.
inline bool vector_with_zeros(const double* basis, int rows, int columns, const std::vector<int>& chosen, double* out) {
    const int zeros = columns - 1;
    Vector w(zeros * columns), x(columns);
    for (int i = 0; i < zeros; ++i)
        for (int j = 0; j < columns; ++j) w[i * columns + j] = basis[j * rows + chosen[i]];
    if (orthogonalise(w.data(), columns, zeros, nullptr) <= kTie) return false;
    for (int i = 0; i < zeros; ++i) normalise(&w[i * columns], columns);
    int axis = 0;
    double least = 2.0;
    for (int k = 0; k < columns; ++k) {
        double cover = 0.0;
        for (int i = 0; i < zeros; ++i) cover += w[i * columns + k] * w[i * columns + k];
        if (cover < least) least = cover, axis = k;
    }
    x[axis] = 1.0;
    for (int pass = 0; pass < 2; ++pass) {
        for (int i = 0; i < zeros; ++i) {
            const double overlap = dot(x.data(), &w[i * columns], columns);
            for (int k = 0; k < columns; ++k) x[k] -= overlap * w[i * columns + k];
        }
        normalise(x.data(), columns);
    }
    for (int i = 0; i < rows; ++i) {
        out[i] = 0.0;
        for (int j = 0; j < columns; ++j) out[i] += basis[j * rows + i] * x[j];
    }
    return true;
}

// Basis (columns - 1) of the part of the span that is orthogonal to a unit vector of it: a reflection's other columns.
inline void complement(const double* basis, int rows, int columns, const double* vector, double* out) {
    Vector w(columns);
    for (int j = 0; j < columns; ++j) w[j] = dot(basis + j * rows, vector, rows);
    normalise(w.data(), columns);
    w[0] += std::copysign(1.0, w[0]);
    const double scale = 2.0 / dot(w.data(), w.data(), columns);
    for (int c = 1; c < columns; ++c)
        for (int i = 0; i < rows; ++i) {
            double image = 0.0;
            for (int j = 0; j < columns; ++j) image += basis[j * rows + i] * w[j];
            out[(c - 1) * rows + i] = basis[c * rows + i] - scale * w[c] * image;
        }
}

// The plane rotations of two columns that make an entry of the first one zero, for each row in use; how many.
inline int plane_candidates(const double* pair, int rows, double* out) {
    int count = 0;
    for (int row = 0; row < rows; ++row) {
        const double a = pair[row], b = pair[rows + row], length = std::hypot(a, b);
        if (length <= kTie) continue;
        const double x = a / length, y = b / length;
        double* candidate = out + 2 * rows * count++;
        for (int i = 0; i < rows; ++i) {
            candidate[i] = pair[i] * y - pair[rows + i] * x;
            candidate[rows + i] = pair[i] * x + pair[rows + i] * y;
        }
    }
    return count;
}

// First of the smallest up to rounding, so that ties do not depend on it.
inline int first_smallest(const Vector& sums) {
    const double limit = *std::min_element(sums.begin(), sums.end()) + kSame;
    return (int)(std::find_if(sums.begin(), sums.end(), [&](double sum) { return sum <= limit; }) - sums.begin());
}

inline void best_in_plane(const double* pair, int rows, double* out) {
    Vector candidates(2 * rows * rows), sums;
    const int count = plane_candidates(pair, rows, candidates.data());
    for (int i = 0; i < count; ++i) sums.push_back(sum_of_sizes(&candidates[2 * rows * i], 2 * rows));
    const double* best = &candidates[2 * rows * first_smallest(sums)];
    std::copy(best, best + 2 * rows, out);
}

// Split off the vector with the smallest sum again and again; exact in the last plane.
inline void greedy(const double* basis, int rows, int columns, double* out) {
    if (columns == 1) {
        std::copy(basis, basis + rows, out);
        return;
    }
    if (columns == 2) return best_in_plane(basis, rows, out);
    Vector vectors, sums, vector(rows);
    std::vector<int> chosen = first_choice(columns - 1);
    do {
        if (!vector_with_zeros(basis, rows, columns, chosen, vector.data())) continue;
        sums.push_back(sum_of_sizes(vector.data(), rows));
        vectors.insert(vectors.end(), vector.begin(), vector.end());
    } while (next_choice(chosen, rows));
    const double* first = &vectors[rows * first_smallest(sums)];
    std::copy(first, first + rows, out);
    Vector rest(rows * (columns - 1));
    complement(basis, rows, columns, first, rest.data());
    greedy(rest.data(), rows, columns - 1, out + rows);
}

// The basis nearest to the projections of the chosen coordinate axes; false where these are nearly dependent.
inline bool nearest_to_axes(const double* basis, int rows, int columns, const std::vector<int>& chosen, double* out) {
    Vector w(columns * columns), r(columns * columns), image(rows);
    for (int i = 0; i < columns; ++i) {
        r[i * columns + i] = 1.0;
        for (int j = 0; j < columns; ++j) w[i * columns + j] = basis[j * rows + chosen[i]];
    }
    if (orthogonalise(w.data(), columns, columns, r.data()) <= kWell) return false;
    std::fill(out, out + rows * columns, 0.0);
    for (int i = 0; i < columns; ++i) {
        normalise(&w[i * columns], columns);
        for (int row = 0; row < rows; ++row) {
            image[row] = 0.0;
            for (int j = 0; j < columns; ++j) image[row] += basis[j * rows + row] * w[i * columns + j];
        }
        for (int c = 0; c < columns; ++c)
            for (int row = 0; row < rows; ++row) out[c * rows + row] += image[row] * r[i * columns + c];
    }
    return true;
}

// Bases that depend on the subspace only, one after the other.
inline Vector starts(const Vector& basis, int rows, int columns) {
    if (columns == 1) return basis;
    const int size = rows * columns;
    Vector found;
    if (columns == 2) {
        found.resize(size * rows);
        found.resize(size * plane_candidates(basis.data(), rows, found.data()));
        return found;
    }
    Vector one(size), rest(rows * (columns - 1));
    std::vector<int> chosen = first_choice(columns);
    do {
        if (nearest_to_axes(basis.data(), rows, columns, chosen, one.data()))
            found.insert(found.end(), one.begin(), one.end());
    } while (next_choice(chosen, rows));
    chosen = first_choice(columns - 1);
    do {
        if (!vector_with_zeros(basis.data(), rows, columns, chosen, one.data())) continue;
        complement(basis.data(), rows, columns, one.data(), rest.data());
        greedy(rest.data(), rows, columns - 1, one.data() + rows);
        found.insert(found.end(), one.begin(), one.end());
    } while (next_choice(chosen, rows));
    return found;
}

// Best plane rotations, plane after plane, until none lowers the sum.
inline void sweep(double* basis, int rows, int columns) {
    Vector pair(2 * rows), best(2 * rows);
    for (int round = 0; round < kSweeps; ++round) {
        bool improved = false;
        for (int a = 0; a < columns; ++a)
            for (int b = a + 1; b < columns; ++b) {
                std::copy(basis + a * rows, basis + (a + 1) * rows, pair.begin());
                std::copy(basis + b * rows, basis + (b + 1) * rows, pair.begin() + rows);
                best_in_plane(pair.data(), rows, best.data());
                if (sum_of_sizes(best.data(), 2 * rows) >= sum_of_sizes(pair.data(), 2 * rows) - kLower) continue;
                std::copy(best.begin(), best.begin() + rows, basis + a * rows);
                std::copy(best.begin() + rows, best.end(), basis + b * rows);
                improved = true;
            }
        if (!improved) break;
    }
}

// The starts with the smallest sums (rounded, so that order decides among equals and not rounding), swept and appended.
inline void append_swept(Vector& candidates, int rows, int columns) {
    const int size = rows * columns, count = (int)candidates.size() / size;
    std::vector<int> order(count);
    std::iota(order.begin(), order.end(), 0);
    Vector sums;
    for (int i = 0; i < count; ++i) sums.push_back(std::nearbyint(sum_of_sizes(&candidates[size * i], size) * 1e9));
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return sums[a] < sums[b]; });
    candidates.reserve(candidates.size() + kSwept * size);
    for (int i = 0; i < std::min(kSwept, count); ++i) {
        const auto from = candidates.begin() + size * order[i];
        candidates.insert(candidates.end(), from, from + size);
        sweep(&candidates[candidates.size() - size], rows, columns);
    }
}

}  // namespace rankdrop
