// The monitor: rank, families, lost directions and first-order distance of each configuration, in one go.
#pragma once

#include "block.hpp"
#include "families.hpp"

namespace rankdrop::RANKDROP_ISA {

inline Pack power(Pack x, int exponent) {
    Pack result = fill(1.0);
    for (int i = 0; i < exponent; ++i) result = result * x;
    return result;
}

// One equation and its gradient at q.
inline Pack equation_at(const Families& table, int equation, const Pack* q, Pack* gradient) {
    const int n = table.variables;
    Pack f = fill(0.0);
    for (int j = 0; j < n; ++j) gradient[j] = fill(0.0);
    for (int t = table.terms[equation]; t < table.terms[equation + 1]; ++t) {
        const double* m = table.m.data() + (std::size_t)t * n;
        const int* p = table.powers.data() + (std::size_t)t * n;
        Pack angle = fill(-table.shift[t]), sine, cosine, monomial = fill(1.0);
        for (int j = 0; j < n; ++j) {
            if (m[j] != 0.0) angle = angle + q[j] * m[j];
            if (p[j] > 0) monomial = monomial * power(q[j], p[j]);
        }
        sincos(angle, sine, cosine);
        const Pack wave = cosine * table.a[t] + sine * table.b[t];
        const Pack slope = (cosine * table.b[t] - sine * table.a[t]) * monomial;
        f = f + wave * monomial;
        for (int j = 0; j < n; ++j) {
            if (m[j] != 0.0) gradient[j] = gradient[j] + slope * m[j];
            if (p[j] == 0) continue;
            Pack others = power(q[j], p[j] - 1) * (double)p[j];
            for (int i = 0; i < n; ++i)
                if (i != j && p[i] > 0) others = others * power(q[i], p[i]);
            gradient[j] = gradient[j] + wave * others;
        }
    }
    return f;
}

// Of one family: `residual`, largest |f|/|grad f| over its equations, with |f|^(1/2) where the gradient is small, never
// far above the distance; `reach`, the motion of the pinned joints to their nearest values, exactly, and of the coupled
// ones by that measure [rad].
struct Apart {
    Pack residual, reach;
};

inline Apart apart(const Families& table, int family, const Pack* q, Pack* gradient) {
    Pack worst = fill(0.0), coupled = fill(0.0);
    for (int e = table.equations[family]; e < table.equations[family + 1]; ++e) {
        const Pack f = abs(equation_at(table, e, q, gradient));
        Pack slope = fill(0.0);
        for (int j = 0; j < table.variables; ++j) {
            const Pack g = gradient[j] * table.scale[j];
            slope = slope + g * g;
        }
        const Pack size = min(f / max(sqrt(slope), fill(1e-300)), sqrt(f));
        worst = max(worst, size);
        if (table.coupled[e]) coupled = max(coupled, size);
    }
    const Pack turn = fill(6.283185307179586), round = fill(6755399441055744.0);  // 1.5 * 2^52
    Pack reach = coupled * coupled;
    for (int p = table.pins[family]; p < table.pins[family + 1]; ++p) {
        const int j = table.pinned[p];
        Pack least = fill(HUGE_VAL);
        for (int v = table.at[p]; v < table.at[p + 1]; ++v) {
            Pack gap = q[j] - fill(table.values[v]);
            if (table.periodic[j]) gap = gap - turn * ((gap / turn + round) - round);
            least = min(least, abs(gap));
        }
        least = least / fill(table.scale[j]);
        reach = reach + least * least;
    }
    return {worst, sqrt(reach)};
}

struct Attribution {
    Pack family, nearest, residual;  // family: -1 for none
};

// The first family in the order of preference that a singular configuration lies on, and the one of least reach of all.
inline Attribution attribute(const Families& table, const MonitorSettings& set, Pack corank, const Pack* q, Pack* gradient) {
    const Pack none = fill(-1.0), far = fill(HUGE_VAL);
    Pack chosen = none, own = far, chosen_corank = none, nearest = none, least = far, its = far, close = none, closest = far;
    for (int family = 0; family < (int)table.corank.size(); ++family) {
        const Apart one = apart(table, family, q, gradient);
        const Pack residual = one.residual, index = fill((double)family);
        const Pack lost = fill((double)table.corank[family]);
        const Mask first = (chosen < fill(0.0)) & (lost <= corank) & (residual <= fill(set.on));
        chosen = select(first, index, chosen), own = select(first, residual, own);
        chosen_corank = select(first, lost, chosen_corank);
        const Mask nearer = one.reach < least;
        nearest = select(nearer, index, nearest), least = select(nearer, one.reach, least), its = select(nearer, residual, its);
        const Mask alike = (lost == corank) & (residual < closest);
        close = select(alike, index, close), closest = select(alike, residual, closest);
    }
    const Mask loose = (chosen_corank < corank) & (closest <= fill(set.loose));
    chosen = select(loose, close, chosen), own = select(loose, closest, own);
    return {chosen, nearest, select(chosen < fill(0.0), its, own)};
}

// sigma_r / |d sigma_r / dq|, joint motions divided by their scale; 0 where sigma_r is zero. `scratch`: n * m packs.
inline Pack first_order_distance(const Chain& chain, const View& view, const Families& table, const MonitorSettings& set,
                                 Workspace& ws, Pack* scratch) {
    const int n = chain.variables, m = view.m, last = set.generic - 1;
    derivative_times(chain, view, ws.at, ws.v + last * n, scratch);
    Pack slope = fill(0.0);
    for (int k = 0; k < n; ++k) {
        Pack g = fill(0.0);
        for (int a = 0; a < m; ++a) g = g + ws.u[last * m + a] * scratch[k * m + a];
        g = g * table.scale[k];
        slope = slope + g * g;
    }
    const Pack sigma = ws.sigma[last];
    return select(sigma <= fill(set.singular), fill(0.0), sigma / sqrt(slope));
}

}  // namespace rankdrop::RANKDROP_ISA
