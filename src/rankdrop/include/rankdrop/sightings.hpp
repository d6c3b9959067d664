// What a monitor sees: families, residuals, ways away and first-order distance, of packs of configurations or of one.
#pragma once

#include <type_traits>

#include "block.hpp"
#include "families.hpp"

namespace rankdrop::RANKDROP_ISA {

template <class T>
inline T power(T x, int exponent) {
    T result = T{} + 1.0;
    for (int i = 0; i < exponent; ++i) result = result * x;
    return result;
}

// What a comparison gives: the compiler's own masks are not always `Mask`.
template <class T>
using Said = std::conditional_t<std::is_same_v<T, double>, bool, Mask>;

// Sines and cosines of all products of phases (`Families::nodes`).
template <class T>
struct Waves {
    const T *sine, *cosine;
};

// `phase`: sines of all phases, then their cosines.
template <class T>
inline void multiply(const Families& table, const T* phase, T* sine, T* cosine) {
    for (int k = 0; k < table.nodes(); ++k) {
        const int before = table.node_before[k], last = table.node_phase[k];
        const T s = phase[last], c = phase[table.phases() + last];
        sine[k] = before < 0 ? s : sine[before] * c + cosine[before] * s;
        cosine[k] = before < 0 ? c : cosine[before] * c - sine[before] * s;
    }
}

template <class T>
inline T phase_at(const Families& table, int k, const T* q) {
    return table.phase_joint[k] < 0 ? T{} + table.phase_m[k] : q[table.phase_joint[k]] * table.phase_m[k];
}

// One configuration in each lane.
inline void waves_at(const Families& table, const Pack* q, Pack* phase, Pack* sine, Pack* cosine) {
    for (int k = 0; k < table.phases(); ++k) sincos(phase_at(table, k, q), phase[k], phase[table.phases() + k]);
    multiply(table, phase, sine, cosine);
}

// One configuration, one phase in each lane: the same bits.
inline void waves_of_one(const Families& table, const double* q, double* phase, double* sine, double* cosine) {
    const int count = table.phases();
    for (int first = 0; first < count; first += W) {
        const int here = count - first < W ? count - first : W;
        Pack angle = fill(0.0), s, c;
        for (int lane = 0; lane < here; ++lane) set(angle, lane, phase_at(table, first + lane, q));
        sincos(angle, s, c);
        for (int lane = 0; lane < here; ++lane) {
            phase[first + lane] = get(s, lane);
            phase[count + first + lane] = get(c, lane);
        }
    }
    multiply(table, phase, sine, cosine);
}

// One equation and its gradient at q.
template <class T>
inline T equation_at(const Families& table, int equation, const T* q, const Waves<T>& waves, T* gradient) {
    const int n = table.variables;
    T f{};
    for (int j = 0; j < n; ++j) gradient[j] = T{};
    for (int t = table.terms[equation]; t < table.terms[equation + 1]; ++t) {
        const int k = table.angle[t];
        const int* p = table.powers.data() + (std::size_t)t * n;
        const T sine = waves.sine[table.node[t]], cosine = waves.cosine[table.node[t]];
        const T wave = cosine * table.a[t] + sine * table.b[t];
        T slope = cosine * table.b[t] - sine * table.a[t], monomial = T{} + 1.0;
        if (table.powered[t]) {
            for (int j = 0; j < n; ++j)
                if (p[j] > 0) monomial = monomial * power(q[j], p[j]);
            slope = slope * monomial;
            for (int j = 0; j < n; ++j) {
                if (p[j] == 0) continue;
                T others = power(q[j], p[j] - 1) * (double)p[j];
                for (int i = 0; i < n; ++i)
                    if (i != j && p[i] > 0) others = others * power(q[i], p[i]);
                gradient[j] = gradient[j] + wave * others;
            }
        }
        f = f + wave * monomial;
        for (int i = table.turns[k]; i < table.turns[k + 1]; ++i) {
            const int j = table.turning[i];
            gradient[j] = gradient[j] + slope * table.m[i];
        }
    }
    return f;
}

// Of one family: `residual`, largest |f|/|grad f| over its equations, with |f|^(1/2) where the gradient is small, never
// far above the distance; `reach`, the motion of the pinned joints to their nearest values, exactly, and of the coupled
// ones by that measure [rad].
template <class T>
struct Apart {
    T residual, reach;
};

// `away`, of one configuration only and where not null: the gradient of `reach` by the scaled joint variables, along the
// steepest of the coupled equations; zero on the family.
template <class T>
inline Apart<T> apart(const Families& table, int family, const T* q, const Waves<T>& waves, T* gradient, double* away) {
    const int n = table.variables;
    T worst{}, coupled{};
    if (away)
        for (int j = 0; j < n; ++j) away[j] = 0.0;
    for (int e = table.equations[family]; e < table.equations[family + 1]; ++e) {
        const T f = equation_at(table, e, q, waves, gradient), size_f = abs(f);
        T slope{};
        for (int j = 0; j < n; ++j) {
            gradient[j] = gradient[j] * table.scale[j];
            slope = slope + gradient[j] * gradient[j];
        }
        slope = max(sqrt(slope), T{} + 1e-300);
        const T size = min(size_f / slope, sqrt(size_f));
        worst = max(worst, size);
        if (!table.coupled[e]) continue;
        if constexpr (std::is_same_v<T, double>)
            if (away && size > coupled)
                for (int j = 0; j < n; ++j) away[j] = gradient[j] * ((f < 0.0 ? -size : size) / slope);
        coupled = max(coupled, size);
    }
    const T turn = T{} + 6.283185307179586, round = T{} + 6755399441055744.0;  // 1.5 * 2^52
    T reach = coupled * coupled;
    for (int p = table.pins[family]; p < table.pins[family + 1]; ++p) {
        const int j = table.pinned[p];
        T least = T{} + HUGE_VAL, way{};
        for (int v = table.at[p]; v < table.at[p + 1]; ++v) {
            T gap = q[j] - table.values[v];
            if (table.periodic[j]) gap = gap - turn * ((gap / turn + round) - round);
            way = select(abs(gap) < least, gap, way);
            least = min(least, abs(gap));
        }
        least = least / (T{} + table.scale[j]);
        reach = reach + least * least;
        if constexpr (std::is_same_v<T, double>)
            if (away) away[j] += way / table.scale[j];
    }
    reach = sqrt(reach);
    if constexpr (std::is_same_v<T, double>)
        if (away && reach > 0.0)
            for (int j = 0; j < n; ++j) away[j] /= reach;
    return {worst, reach};
}

template <class T>
struct Attribution {
    T family, nearest, residual;  // family: -1 for none
};

// The first family in the order of preference that a singular configuration lies on, and the one of least reach of all;
// `apart_of` gives the `Apart` of a family.
template <class T, class Look>
inline Attribution<T> attribute(const Families& table, const MonitorSettings& set, T corank, Look apart_of) {
    const T none = T{} - 1.0, far = T{} + HUGE_VAL, zero{};
    T chosen = none, own = far, chosen_corank = none, nearest = none, least = far, its = far, close = none, closest = far;
    for (int family = 0; family < (int)table.corank.size(); ++family) {
        const Apart<T> one = apart_of(family);
        const T residual = one.residual, index = zero + (double)family;
        const T lost = zero + (double)table.corank[family];
        const Said<T> first = (chosen < zero) & (lost <= corank) & (residual <= zero + set.on);
        chosen = select(first, index, chosen), own = select(first, residual, own);
        chosen_corank = select(first, lost, chosen_corank);
        const Said<T> nearer = one.reach < least;
        nearest = select(nearer, index, nearest), least = select(nearer, one.reach, least), its = select(nearer, residual, its);
        const Said<T> alike = (lost == corank) & (residual < closest);
        close = select(alike, index, close), closest = select(alike, residual, closest);
    }
    const Said<T> loose = (chosen_corank < corank) & (closest <= zero + set.loose);
    chosen = select(loose, close, chosen), own = select(loose, closest, own);
    return {chosen, nearest, select(chosen < zero, its, own)};
}

// sigma_r / |d sigma_r / dq|, joint motions divided by their scale; 0 where sigma_r is zero. `scratch`: n * m packs;
// `gradient`: n, of sigma_r by the scaled joint variables.
inline Pack first_order_distance(const Chain& chain, const View& view, const Families& table, const MonitorSettings& set,
                                 Workspace& ws, Pack* scratch, Pack* gradient) {
    const int n = chain.variables, m = view.m, last = set.generic - 1;
    derivative_times(chain, view, ws.at, ws.v + last * n, scratch);
    Pack slope = fill(0.0);
    for (int k = 0; k < n; ++k) {
        Pack g = fill(0.0);
        for (int a = 0; a < m; ++a) g = g + ws.u[last * m + a] * scratch[k * m + a];
        g = g * table.scale[k];
        gradient[k] = g;
        slope = slope + g * g;
    }
    const Pack sigma = ws.sigma[last];
    return select(sigma <= fill(set.singular), fill(0.0), sigma / sqrt(slope));
}

}  // namespace rankdrop::RANKDROP_ISA
