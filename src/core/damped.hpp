// The quadratic model of a sum of squares at one point, and the damped step that it proposes.
#pragma once

#include "lanes.hpp"
#include "memory.hpp"

namespace rankdrop::RANKDROP_ISA {

// N > 0 fixes the size at compile time; 0 leaves it to run time.
template <int N>
inline void solve_damped_of(const Pack* normal, Pack mu, const Pack* b, int n_, Pack* l, Pack* x) {
    const int n = N ? N : n_;
    const Pack tiny = fill(1e-300);
    for (int j = 0; j < n; ++j) {
        Pack pivot = normal[j * n + j] + mu;
        for (int k = 0; k < j; ++k) pivot = pivot - l[j * n + k] * l[j * n + k];
        // rounding may eat the pivot of a direction that D does not see; the damping alone is left then
        const Pack root = sqrt(max(pivot, max(mu * fill(1e-3), tiny)));
        const Pack inverse = fill(1.0) / root;
        l[j * n + j] = inverse;  // the pivot is only ever divided by
        for (int i = j + 1; i < n; ++i) {
            Pack sum = normal[i * n + j];
            for (int k = 0; k < j; ++k) sum = sum - l[i * n + k] * l[j * n + k];
            l[i * n + j] = sum * inverse;
        }
    }
    for (int i = 0; i < n; ++i) {
        Pack sum = b[i];
        for (int k = 0; k < i; ++k) sum = sum - l[i * n + k] * x[k];
        x[i] = sum * l[i * n + i];
    }
    for (int i = n - 1; i >= 0; --i) {
        Pack sum = x[i];
        for (int k = i + 1; k < n; ++k) sum = sum - l[k * n + i] * x[k];
        x[i] = sum * l[i * n + i];
    }
}

// Solves (N + mu I) x = b by Cholesky, N symmetric (n x n), in lanes. `l` has room for n * n packs.
inline void solve_damped(const Pack* normal, Pack mu, const Pack* b, int n, Pack* l, Pack* x) {
    if (n == 7) return solve_damped_of<7>(normal, mu, b, n, l, x);
    if (n == 6) return solve_damped_of<6>(normal, mu, b, n, l, x);
    return solve_damped_of<0>(normal, mu, b, n, l, x);
}

// x = M^-1 b for the symmetric M nearby that has no pivot below `flattest`: L diag(|d|) L^T. Of M (n x n) the lower part is
// read, and written over.
template <int N>
inline void solve_convex(Pack* m, double flattest, const Pack* b, int n_, Pack* x) {
    const int n = N ? N : n_;
    for (int j = 0; j < n; ++j) {
        Pack pivot = m[j * n + j];
        for (int k = 0; k < j; ++k) pivot = pivot - m[j * n + k] * m[j * n + k] * m[k * n + k];
        pivot = max(abs(pivot), fill(flattest));
        m[j * n + j] = pivot;
        const Pack inverse = fill(1.0) / pivot;
        for (int i = j + 1; i < n; ++i) {
            Pack sum = m[i * n + j];
            for (int k = 0; k < j; ++k) sum = sum - m[i * n + k] * m[j * n + k] * m[k * n + k];
            m[i * n + j] = sum * inverse;
        }
    }
    for (int i = 0; i < n; ++i) {
        Pack sum = b[i];
        for (int k = 0; k < i; ++k) sum = sum - m[i * n + k] * x[k];
        x[i] = sum;
    }
    for (int i = n - 1; i >= 0; --i) {
        Pack sum = x[i] / m[i * n + i];
        for (int k = i + 1; k < n; ++k) sum = sum - m[k * n + i] * x[k];
        x[i] = sum;
    }
}

// Newton's steps shorter than kSure get shorter still, and all that follow come to less than kSlack of them
constexpr double kSure = 0.1, kSlack = 2.0;

inline Pack dot(const Pack* a, const Pack* b, int n) {
    Pack sum = fill(0.0);
    for (int i = 0; i < n; ++i) sum = sum + a[i] * b[i];
    return sum;
}

// The quadratic model of |F|^2 / 2 at one point: gradient g = D^T F, normal matrix N = D^T D (angles and scaled
// lengths), with variables pressed against a limit taken out.
struct Model {
    Pack *g, *normal;
    Pack size2;  // |F|^2
    Pack trace;  // of N

    Model(int variables, Arena& arena) {
        const std::size_t n = static_cast<std::size_t>(variables);
        g = arena.take<Pack>(n), normal = arena.take<Pack>(n * n);
    }
};

}  // namespace rankdrop::RANKDROP_ISA
