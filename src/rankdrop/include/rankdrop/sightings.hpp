// What a monitor sees: families, residuals, distances and ways away, of packs of configurations or of one.
#pragma once

#include <type_traits>
#include <vector>

#include "block.hpp"
#include "families.hpp"
#include "onto_set.hpp"

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

template <class T>
inline void multiply_one(const Families& table, int k, const T* phase, T* sine, T* cosine) {
    const int before = table.node_before[k], last = table.node_phase[k];
    const T s = phase[last], c = phase[table.phases() + last];
    sine[k] = before < 0 ? s : sine[before] * c + cosine[before] * s;
    cosine[k] = before < 0 ? c : cosine[before] * c - sine[before] * s;
}

// `phase`: sines of all phases, then their cosines. `nodes`: so many of the products.
template <class T>
inline void multiply(const Families& table, int nodes, const T* phase, T* sine, T* cosine) {
    for (int k = 0; k < nodes; ++k) multiply_one(table, k, phase, sine, cosine);
}

template <class T>
inline T phase_at(const Families& table, int k, const T* q) {
    return table.phase_joint[k] < 0 ? T{} + table.phase_m[k] : q[table.phase_joint[k]] * table.phase_m[k];
}

// One configuration in each lane: of the first `count` equations.
inline void waves_of_first(const Families& table, int count, const Pack* q, Pack* phase, Pack* sine, Pack* cosine) {
    const std::size_t equations = (std::size_t)count;
    for (int k = 0; k < table.phases_of_first[equations]; ++k)
        sincos(phase_at(table, k, q), phase[k], phase[table.phases() + k]);
    multiply(table, table.nodes_of_first[equations], phase, sine, cosine);
}

// One configuration in each lane. `all`: lengthy families too.
inline void waves_at(const Families& table, bool all, const Pack* q, Pack* phase, Pack* sine, Pack* cosine) {
    const auto turn = [&](int k) { sincos(phase_at(table, k, q), phase[k], phase[table.phases() + k]); };
    if (all) {
        for (int k = 0; k < table.phases(); ++k) turn(k);
        multiply(table, table.nodes(), phase, sine, cosine);
        return;
    }
    for (const int k : table.plain_phase) turn(k);
    for (const int k : table.plain_node) multiply_one(table, k, phase, sine, cosine);
}

// One configuration, one phase in each lane: the same bits. `number` gives the phases, `count` of them.
template <class Number>
inline void phases_of_one(const Families& table, int count, Number number, const double* q, double* phase) {
    for (int first = 0; first < count; first += W) {
        const int here = count - first < W ? count - first : W;
        Pack angle = fill(0.0), s, c;
        for (int lane = 0; lane < here; ++lane) set(angle, lane, phase_at(table, number(first + lane), q));
        sincos(angle, s, c);
        for (int lane = 0; lane < here; ++lane) {
            phase[number(first + lane)] = get(s, lane);
            phase[table.phases() + number(first + lane)] = get(c, lane);
        }
    }
}

inline void waves_of_one(const Families& table, bool all, const double* q, double* phase, double* sine, double* cosine) {
    if (all) {
        phases_of_one(table, table.phases(), [](int i) { return i; }, q, phase);
        multiply(table, table.nodes(), phase, sine, cosine);
        return;
    }
    const int* plain = table.plain_phase.data();
    phases_of_one(table, (int)table.plain_phase.size(), [plain](int i) { return plain[i]; }, q, phase);
    for (const int k : table.plain_node) multiply_one(table, k, phase, sine, cosine);
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

// The way from the nearest value of a pinned joint to where it is.
template <class T>
inline T way_of(const Families& table, int pin, const T* q) {
    const int j = table.pinned[pin];
    const T turn = T{} + 6.283185307179586, round = T{} + 6755399441055744.0;  // 1.5 * 2^52
    T least = T{} + HUGE_VAL, way{};
    for (int v = table.at[pin]; v < table.at[pin + 1]; ++v) {
        T gap = q[j] - table.values[v];
        if (table.periodic[j]) gap = gap - turn * ((gap / turn + round) - round);
        way = select(abs(gap) < least, gap, way);
        least = min(least, abs(gap));
    }
    return way;
}

// Of one family: `residual`, largest |f|/|grad f| over its equations, with |f|^(1/2) where the gradient is small, never
// far above the distance; `distance`, the motion of the pinned joints to their nearest values, exactly, and of the coupled
// ones by that measure or, after `walk`, to the nearest point that Newton's steps come to [rad].
template <class T>
struct Apart {
    T residual, distance;
};

// `away`, of one configuration only and where not null: the gradient of the distance by the scaled joint variables, along
// the steepest of the coupled equations; zero on the family.
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
    T distance = coupled * coupled;
    for (int p = table.pins[family]; p < table.pins[family + 1]; ++p) {
        const int j = table.pinned[p];
        const T way = way_of(table, p, q) / (T{} + table.scale[j]);
        distance = distance + way * way;
        if constexpr (std::is_same_v<T, double>)
            if (away) away[j] += way;
    }
    distance = sqrt(distance);
    if constexpr (std::is_same_v<T, double>)
        if (away && distance > 0.0)
            for (int j = 0; j < n; ++j) away[j] /= distance;
    return {worst, distance};
}

// Room for walks: `foot` and `step` (n), `rows` (widest, n), `right` (widest), and waves of all phases and products.
template <class T>
struct WalkRoom {
    T *foot, *step, *rows, *right, *phase, *sine, *cosine;
    bool* pinned;  // (n)

    WalkRoom(const Families& table, Arena& arena) {
        const std::size_t n = (std::size_t)table.variables, widest = (std::size_t)table.widest;
        foot = arena.take<T>(n), step = arena.take<T>(n), rows = arena.take<T>(widest * n), right = arena.take<T>(widest);
        phase = arena.take<T>(2 * (std::size_t)table.phases()), pinned = arena.take<bool>(n);
        sine = arena.take<T>((std::size_t)table.nodes()), cosine = arena.take<T>((std::size_t)table.nodes());
    }
};

inline void own_phases(const Families& table, int family, const Pack* q, Pack* phase) {
    for (int i = table.first_phase[family]; i < table.first_phase[family + 1]; ++i) {
        const int k = table.own_phase[i];
        sincos(phase_at(table, k, q), phase[k], phase[table.phases() + k]);
    }
}

#if RANKDROP_WIDTH > 1
inline void own_phases(const Families& table, int family, const double* q, double* phase) {
    const int* own = table.own_phase.data() + table.first_phase[family];
    const int count = table.first_phase[family + 1] - table.first_phase[family];
    phases_of_one(table, count, [own](int i) { return own[i]; }, q, phase);
}
#endif

// step <- step - A^+ (f + A step), by Gram and Schmidt; a row that depends on those before it is left out.
template <class T>
inline void onto_tangent_plane(const Families& table, int family, const WalkRoom<T>& room) {
    const int n = table.variables;
    const Waves<T> waves{room.sine, room.cosine};
    int rows = 0;
    for (int e = table.equations[family]; e < table.equations[family + 1]; ++e) {
        if (!table.coupled[e]) continue;
        T* row = room.rows + rows * n;
        T right = equation_at(table, e, room.foot, waves, row), before{}, after{};
        for (int j = 0; j < n; ++j) {
            row[j] = room.pinned[j] ? T{} : row[j] * table.scale[j];
            right = right + row[j] * room.step[j];
            before = before + row[j] * row[j];
        }
        for (int b = 0; b < rows; ++b) {
            const T* other = room.rows + b * n;
            T overlap{};
            for (int j = 0; j < n; ++j) overlap = overlap + row[j] * other[j];
            for (int j = 0; j < n; ++j) row[j] = row[j] - overlap * other[j];
            right = right - overlap * room.right[b];
        }
        for (int j = 0; j < n; ++j) after = after + row[j] * row[j];
        const T length = sqrt(max(after, T{} + 1e-300));
        const T factor = select(after > before * 1e-14 + (T{} + 1e-28), (T{} + 1.0) / length, T{});
        for (int j = 0; j < n; ++j) row[j] = row[j] * factor;
        room.right[rows++] = right * factor;
    }
    for (int b = 0; b < rows; ++b)
        for (int j = 0; j < n; ++j) room.step[j] = room.step[j] - room.right[b] * room.rows[b * n + j];
}

// The distance of one family by Newton's steps onto the tangent plane at x, nearest to q,
//     x <- q - A^+ (f(x) + A (q - x)),    A = df/dx in scaled variables,
// over the joints that are not pinned, these at their nearest values. Where they do not come to rest it stays `first`.
// `away`, as in `apart`: from the foot to q.
template <class T>
inline T walk(const Families& table, int family, const T* q, T first, const WalkRoom<T>& room, double* away) {
    const int n = table.variables;
    const T zero{};
    T held = zero;  // square of the pinned joints' way
    for (int j = 0; j < n; ++j) room.foot[j] = q[j], room.pinned[j] = false;
    for (int p = table.pins[family]; p < table.pins[family + 1]; ++p) {
        const int j = table.pinned[p];
        const T way = way_of(table, p, q), scaled = way / (zero + table.scale[j]);
        room.pinned[j] = true, room.foot[j] = q[j] - way, held = held + scaled * scaled;
    }
    T distance = first, last = zero + HUGE_VAL;
    Said<T> going = zero == zero;
    for (int count = 0; count < kWalk && any(going); ++count) {
        own_phases(table, family, room.foot, room.phase);
        for (int i = table.first_node[family]; i < table.first_node[family + 1]; ++i)
            multiply_one(table, table.own_node[i], room.phase, room.sine, room.cosine);
        for (int j = 0; j < n; ++j) room.step[j] = room.pinned[j] ? zero : (q[j] - room.foot[j]) / (zero + table.scale[j]);
        onto_tangent_plane(table, family, room);
        T square{}, far = held;
        for (int j = 0; j < n; ++j) square = square + room.step[j] * room.step[j];
        const T length = sqrt(square), part = min(zero + 1.0, (zero + kStride) / max(length, zero + 1e-300));
        for (int j = 0; j < n; ++j) {
            if (room.pinned[j]) continue;
            room.foot[j] = select(going, room.foot[j] + room.step[j] * part * table.scale[j], room.foot[j]);
            const T way = (q[j] - room.foot[j]) / (zero + table.scale[j]);
            far = far + way * way;
        }
        far = sqrt(far);
        distance = select(going, far, distance), last = select(going, length, last);
        going = going & (length > (zero + kStill) * far + (zero + 1e-9));
    }
    const Said<T> rests = last <= (zero + kStill) * distance + (zero + 1e-9);
    if constexpr (std::is_same_v<T, double>)
        if (away && rests && distance > 1e-6)  // nearer, the direction of the tangent plane is the better one
            for (int j = 0; j < n; ++j) away[j] = (q[j] - room.foot[j]) / table.scale[j] / distance;
    return select(rests, distance, first);
}

// Distances in `each` that Newton's steps may change: of the nearest family, of those that may be, and of those nearer
// than `start`. `away` (families, n) or null.
template <class T>
inline void walk_all(const Families& table, double start, const T* q, const WalkRoom<T>& room, Apart<T>* each, double* away) {
    const int count = (int)table.corank.size();
    T least = T{} + HUGE_VAL;
    for (int family = 0; family < count; ++family) least = min(least, each[family].distance);
    const T within = max(least + least, T{} + start);
    for (int family = 0; family < count; ++family) {
        const Said<T> may = each[family].distance <= within;
        if (!table.walked[family] || !any(may)) continue;
        const T found = walk(table, family, q, each[family].distance, room, away ? away + family * table.variables : nullptr);
        each[family].distance = select(may, found, each[family].distance);
    }
}

// Scratch of walks by the kinematics: the set, and one condition of a family at the end.
struct FarRoom {
    SetRoom set;
    Pack *phase, *sine, *cosine, *gradient;

    FarRoom(const Chain& chain, int m, const Families& table, Arena& arena) : set(chain, m, arena) {
        const std::size_t nodes = (std::size_t)table.nodes();
        phase = arena.take<Pack>(2 * (std::size_t)table.phases()), sine = arena.take<Pack>(nodes);
        cosine = arena.take<Pack>(nodes), gradient = arena.take<Pack>((std::size_t)table.variables);
    }
};

// |f|/|grad f| of a lengthy family's shortest condition at x.
inline Pack beside(const Families& table, int family, const Pack* x, FarRoom& room) {
    own_phases(table, family, x, room.phase);
    for (int i = table.first_node[family]; i < table.first_node[family + 1]; ++i)
        multiply_one(table, table.own_node[i], room.phase, room.sine, room.cosine);
    const Waves<Pack> waves{room.sine, room.cosine};
    const Pack f = equation_at(table, table.witness[family], x, waves, room.gradient);
    Pack slope = fill(0.0);
    for (int j = 0; j < table.variables; ++j) {
        const Pack g = room.gradient[j] * table.scale[j];
        slope = slope + g * g;
    }
    return abs(f) / max(sqrt(slope), fill(1e-300));
}

// Whether other singular configurations of this corank are known, or may be.
inline bool shared(const Families& table, const MonitorSettings& set, int family) {
    if (set.beyond) return true;
    for (std::size_t other = 0; other < table.corank.size(); ++other)
        if ((int)other != family && table.corank[other] <= table.corank[family]) return true;
    return false;
}

// Residual and distance of a lengthy family at a regular configuration, in this lane of q and `start`: by the kinematics.
// They are of the singular set; walks that end beside the family's condition were to another family. Where none counts, the
// distance is to first order. `away`, (n) or null: the gradient of the distance by scaled variables.
inline Apart<double> apart_by_set(const Chain& chain, const View& view, const Families& table, const MonitorSettings& set,
                                  int family, const Pack* q, const Workspace& start, int lane, FarRoom& room, double* away) {
    const int n = table.variables;
    const bool all = !shared(table, set, family);
    const auto off = [&](const Pack* x) { return all ? fill(0.0) : beside(table, family, x, room); };
    const SetPoints* points = table.points ? table.points->data() + family : nullptr;
    OntoSet found{};
    walk_onto_set(chain, view, table.scale.data(), set.generic - table.corank[family], q, start, lane, points, room.set, found,
                  off);
    const bool reached = std::isfinite(found.distance);
    if (away) {
        const double* there = reached ? room.set.normal_of : room.set.first;
        double square = 0.0;
        for (int j = 0; j < n; ++j) square += there[j] * there[j];
        for (int j = 0; j < n; ++j) away[j] = square > 0.0 ? -there[j] / std::sqrt(square) : 0.0;
    }
    return {found.first, reached ? found.distance : found.first};
}

template <class T>
struct Attribution {
    T family, nearest, residual, distance;  // family: -1 for none; distance: of `nearest`
};

// The first family in the order of preference that a singular configuration lies on, and the nearest one of all.
template <class T>
inline Attribution<T> attribute(const Families& table, const MonitorSettings& set, T corank, const Apart<T>* each) {
    const T none = T{} - 1.0, far = T{} + HUGE_VAL, zero{};
    T chosen = none, own = far, chosen_corank = none, nearest = none, least = far, its = far, close = none, closest = far;
    for (int family = 0; family < (int)table.corank.size(); ++family) {
        const Apart<T> one = each[family];
        const T residual = one.residual, index = zero + (double)family;
        const T lost = zero + (double)table.corank[family];
        const Said<T> first = (chosen < zero) & (lost <= corank) & (residual <= zero + set.on);
        chosen = select(first, index, chosen), own = select(first, residual, own);
        chosen_corank = select(first, lost, chosen_corank);
        const Said<T> nearer = one.distance < least;
        nearest = select(nearer, index, nearest), least = select(nearer, one.distance, least);
        its = select(nearer, residual, its);
        const Said<T> alike = (lost == corank) & (residual < closest);
        close = select(alike, index, close), closest = select(alike, residual, closest);
    }
    const Said<T> loose = (chosen_corank < corank) & (closest <= zero + set.loose);
    chosen = select(loose, close, chosen), own = select(loose, closest, own);
    return {chosen, nearest, select(chosen < zero, its, own), least};
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
