// How far to where the rank drops, from the kinematics alone: for families whose conditions are too long to be walked on.
#pragma once

#include "block.hpp"

namespace rankdrop::RANKDROP_ISA {

inline constexpr int kWalk = 8;          // Newton steps of a walk at most, by conditions
inline constexpr int kWalkOnSet = 6;        // and by the kinematics, which cost as much as a hundred terms
inline constexpr double kStill = 0.05;   // a step this much shorter than the distance changes that by a thousandth of it
inline constexpr double kStride = 0.7;   // of a step at most [rad]
inline constexpr double kHopeless = 1.05; // times the nearest end so far: a walk that is farther after two steps gives up
inline constexpr double kBeside = 1e-2;  // of a family's conditions, where a walk that rests ends [rad]
inline constexpr int kStarts = 4;        // walks of one configuration, one a lane
inline constexpr int kPacks = (kStarts + W - 1) / W;
inline constexpr int kGroup = W > kStarts ? W / kStarts : 1;  // configurations walked from together: lanes k kStarts ...

// Scratch of `WalkOntoSet`.
struct SetRoom {
    Placed at;
    Pack *q, *x;                // (n), (kPacks, n)
    Pack *u, *v;                // (kPacks, m, m), (kPacks, n, n) by columns: U of the start, weak ones last; the last V2
    Pack *step, *jacobian, *turned;  // (n), (m, n) by rows; turned: U^T J
    Pack *basis;                // (n, n) by columns: row space of the strong rows, then its complement
    Pack *lower, *pull;         // (m, m) the strong rows in that basis, (m)
    Pack *left;                 // (m - rank, m) by rows
    Pack *f, *right, *rows;     // (entries), (entries), (entries, n): F, and D orthonormal
    Pack *scratch;              // (n, m)
    double *end, *first;        // (kGroup, n) where the nearest walk ends; where the first step of the first one leads

    SetRoom(const Chain& chain, int m_, Arena& arena) : at(placed_in(chain, arena)) {
        const std::size_t m = static_cast<std::size_t>(m_), n = static_cast<std::size_t>(chain.variables);
        const std::size_t packs = static_cast<std::size_t>(kPacks);
        q = arena.take<Pack>(n), x = arena.take<Pack>(packs * n), u = arena.take<Pack>(packs * m * m);
        v = arena.take<Pack>(packs * n * n), step = arena.take<Pack>(n), jacobian = arena.take<Pack>(m * n);
        turned = arena.take<Pack>(m * n), basis = arena.take<Pack>(n * n), lower = arena.take<Pack>(m * m);
        pull = arena.take<Pack>(m), left = arena.take<Pack>(m * m), f = arena.take<Pack>(m * n);
        right = arena.take<Pack>(m * n), rows = arena.take<Pack>(m * n * n), scratch = arena.take<Pack>(n * m);
        end = arena.take<double>(kGroup * n), first = arena.take<double>(kGroup * n);
    }
};

// Distances to first order, and to the nearest point that a walk rests at (infinite where none does).
struct OntoSet {
    double first, distance;
};

// From one configuration to where the rank is r or less: Newton's steps onto the tangent plane of F = 0, nearest to q, over
// all joints, from several sheets of the set at once. Walk k takes the k-th weakest direction that is still strong for the
// one that vanishes. ROWS, JOINTS, RANK > 0 fix the sizes at compile time (loops unroll);
// 0 leaves them to run time.
template <int ROWS, int JOINTS, int RANK>
class WalkOntoSet {
  public:
    WalkOntoSet(const Chain& chain, const View& view, const double* scale, int rank, const Workspace& start, SetRoom& room)
        : chain_(chain), view_(view), scale_(scale), start_(start), room_(room), m(ROWS ? ROWS : view.m),
          n(JOINTS ? JOINTS : chain.variables), rank_(RANK ? RANK : rank), s_(n - rank_) {
        // the rank of the whole twist is that seen from the base, where derivatives are shortest
        shifted_ = m == 6 && start.at.base_axes;
        for (int a = 0; a < m; ++a) shifted_ = shifted_ && view.row[a] == a;
        if (!shifted_) return;
        view_.axes = view_.origin = 0;
        for (double& one : view_.point) one = 0.0;
    }

    // From kGroup lanes of `start`, decomposed at q (in the same lanes). `beside(x)`: how far ends x are from the family's
    // conditions.
    template <class Beside>
    void run(const Pack* q, const int* lanes, OntoSet* out, Beside beside) {
        begin(q, lanes);
        Pack distance[kPacks], last[kPacks], nearest = fill(HUGE_VAL);
        Mask going[kPacks];
        for (int pack = 0; pack < kPacks; ++pack)
            distance[pack] = fill(0.0), last[pack] = fill(HUGE_VAL), going[pack] = distance[pack] == distance[pack];
        for (int count = 0; count < kWalkOnSet; ++count) {
            bool more = false;
            for (int pack = 0; pack < kPacks; ++pack) {
                if (!any(going[pack])) continue;
                if (count == 0) there(lanes, pack);
                else near(pack);
                Pack* x = room_.x + pack * n;
                for (int j = 0; j < n; ++j) room_.step[j] = (room_.q[j] - x[j]) / scale_[j];
                onto_tangent_plane();
                Pack square = fill(0.0), far = fill(0.0);
                for (int j = 0; j < n; ++j) square = square + room_.step[j] * room_.step[j];
                const Pack length = sqrt(square), part = min(fill(1.0), fill(kStride) / max(length, fill(1e-300)));
                if (count == 0 && pack == 0) keep_first(length, out);
                for (int j = 0; j < n; ++j) {
                    x[j] = select(going[pack], x[j] + room_.step[j] * part * scale_[j], x[j]);
                    const Pack way = (room_.q[j] - x[j]) / scale_[j];
                    far = far + way * way;
                }
                distance[pack] = select(going[pack], sqrt(far), distance[pack]);
                last[pack] = select(going[pack], length, last[pack]);
                going[pack] = going[pack] & (length > distance[pack] * kStill + fill(1e-9));
                more = more || any(going[pack]);
            }
            if (!more) break;
            if (count < 1) continue;
            for (int pack = 0; pack < kPacks; ++pack) compare(distance[pack], rests(distance[pack], last[pack]), nearest);
            for (int pack = 0; pack < kPacks; ++pack) going[pack] = going[pack] & (distance[pack] < nearest * kHopeless);
        }
        finish(distance, last, out, beside);
    }

  private:
    static Mask rests(const Pack& distance, const Pack& last) { return last <= distance * kStill + fill(1e-9); }

    static int group_of(int lane) { return kGroup > 1 ? lane / kStarts : 0; }

    // Which walk of its configuration a lane is.
    static int walk_of(int pack, int lane) { return (pack * W + lane) % kStarts; }

    void keep_first(const Pack& length, OntoSet* out) {
        for (int group = 0; group < kGroup; ++group) {
            const int lane = group * kStarts;
            out[group].first = get(length, lane);
            for (int j = 0; j < n; ++j)
                room_.first[group * n + j] = get(room_.q[j], lane) + get(room_.step[j], lane) * scale_[j];
        }
    }

    // The nearest end of each configuration's walks, in all of its lanes.
    static void compare(const Pack& distance, Mask counts, Pack& nearest) {
        double least[kGroup];
        for (int group = 0; group < kGroup; ++group) least[group] = HUGE_VAL;
        for (int lane = 0; lane < W; ++lane)
            if (get(counts, lane)) least[group_of(lane)] = std::min(least[group_of(lane)], get(distance, lane));
        for (int lane = 0; lane < W; ++lane) set(nearest, lane, std::min(get(nearest, lane), least[group_of(lane)]));
    }

    template <class Beside>
    void finish(const Pack* distance, const Pack* last, OntoSet* out, Beside beside) {
        for (int group = 0; group < kGroup; ++group) out[group].distance = HUGE_VAL;
        for (int pack = 0; pack < kPacks; ++pack) {
            const Mask still = rests(distance[pack], last[pack]);
            if (!any(still)) continue;
            const Pack off = beside(room_.x + pack * n);
            for (int lane = 0; lane < W; ++lane) {
                const int group = group_of(lane);
                if (!get(still, lane) || !(get(off, lane) <= kBeside) || !(get(distance[pack], lane) < out[group].distance)) continue;
                out[group].distance = get(distance[pack], lane);
                for (int j = 0; j < n; ++j) room_.end[group * n + j] = get(room_.x[pack * n + j], lane);
            }
        }
    }

    // Which direction of the start stands at place i of walk k: its first weak one changes places with a strong one.
    int place(int i, int k) const { return k > rank_ ? i : i == rank_ ? rank_ - k : i == rank_ - k ? rank_ : i; }

    void begin(const Pack* q, const int* lanes) {
        for (int j = 0; j < n; ++j)
            for (int lane = 0; lane < W; ++lane) set(room_.q[j], lane, get(q[j], lanes[group_of(lane)]));
        for (int pack = 0; pack < kPacks; ++pack) {
            for (int j = 0; j < n; ++j) room_.x[pack * n + j] = room_.q[j];
            for (int i = 0; i < m; ++i)
                for (int lane = 0; lane < W; ++lane) put_border(i, pack, lane, lanes[group_of(lane)]);
        }
        Placed& at = room_.at;
        const auto taken = [&](const Pack& from) {
            Pack to = from;
            for (int lane = 0; lane < W; ++lane) set(to, lane, get(from, lanes[group_of(lane)]));
            return to;
        };
        for (std::size_t i = 0; i < chain_.joints.size(); ++i)
            for (int c = 0; c < 3; ++c) {
                at.screws[i].v[c] = taken(start_.at.screws[i].v[c]);
                at.screws[i].w[c] = taken(start_.at.screws[i].w[c]);
            }
        at.base_axes = start_.at.base_axes;
        for (int i = 0; i < 3; ++i) at.p[i] = shifted_ ? fill(0.0) : taken(start_.at.p[i]);
        for (int i = 0; i < 9 && !at.base_axes; ++i) at.axes[i] = taken(start_.at.axes[i]);
    }

    // Direction i of the border: u, or where the twist is seen from the base, u^T of the shift from there to the point.
    void put_border(int i, int pack, int lane, int from_lane) {
        const Pack* from = start_.u + place(i, walk_of(pack, lane)) * m;
        Pack* to = room_.u + (pack * m + i) * m;
        for (int a = 0; a < m; ++a) set(to[a], lane, get(from[a], from_lane));
        if (!shifted_) return;
        double f[3], p[3];
        for (int c = 0; c < 3; ++c) f[c] = get(from[c], from_lane) * view_.factor[c], p[c] = get(start_.at.p[c], from_lane);
        for (int c = 0; c < 3; ++c) {
            const int d = (c + 1) % 3, e = (c + 2) % 3;
            set(to[3 + c], lane, get(from[3 + c], from_lane) + (p[d] * f[e] - p[e] * f[d]) / view_.factor[3 + c]);
        }
    }

    // F and its bases at the start, by its singular values and vectors.
    void there(const int* lanes, int pack) {
        const int values = std::min(m, n);
        for (int i = 0; i < (m - rank_) * m; ++i) room_.left[i] = room_.u[(pack * m + rank_) * m + i];
        for (int b = 0; b < s_; ++b)
            for (int lane = 0; lane < W; ++lane) {
                const Pack* from = start_.v + place(rank_ + b, walk_of(pack, lane)) * n;
                for (int j = 0; j < n; ++j) set(room_.basis[(rank_ + b) * n + j], lane, get(from[j], lanes[group_of(lane)]));
            }
        for (int i = 0; i < s_ * n; ++i) room_.v[pack * n * n + i] = room_.basis[rank_ * n + i];
        for (int i = 0; i < m - rank_; ++i)
            for (int b = 0; b < s_; ++b) {
                Pack& f = room_.f[i * s_ + b];
                f = fill(0.0);
                if (i != b || rank_ + i >= values) continue;
                for (int lane = 0; lane < W; ++lane)
                    set(f, lane, get(start_.sigma[place(rank_ + i, walk_of(pack, lane))], lanes[group_of(lane)]));
            }
    }

    // F and its bases at room.x, without singular values. U of the start splits the task in strong and weak directions; with
    // L Q = U1^T J (Gram and Schmidt) and a weak row a = u^T J,
    //     w = a - (a Q^T) Q,   left = u - U1 L^-T Q a^T,    so that w = left^T J lies in the complement V2 of Q,
    // and J has rank r where every w is zero. F = w V2, and D = left^T dJ V2 is its derivative.
    void near(int pack) {
        const Pack* u = room_.u + pack * m * m;
        forward(chain_, view_, room_.x + pack * n, room_.at);
        jacobian(chain_, view_, room_.at, room_.jacobian, n, 1);
        for (int i = 0; i < m; ++i)
            for (int j = 0; j < n; ++j) {
                Pack sum = fill(0.0);
                for (int a = 0; a < m; ++a) sum = sum + u[i * m + a] * room_.jacobian[a * n + j];
                room_.turned[i * n + j] = sum;
            }
        for (int i = 0; i < m; ++i) orthogonalise(i);
        complete(room_.v + pack * n * n);
        for (int i = rank_; i < m; ++i) {
            for (int b = rank_ - 1; b >= 0; --b) {
                Pack sum = room_.lower[i * m + b];
                for (int c = b + 1; c < rank_; ++c) sum = sum - room_.lower[c * m + b] * room_.pull[c];
                room_.pull[b] = sum / room_.lower[b * m + b];
            }
            Pack* left = room_.left + (i - rank_) * m;
            for (int a = 0; a < m; ++a) {
                left[a] = u[i * m + a];
                for (int b = 0; b < rank_; ++b) left[a] = left[a] - room_.pull[b] * u[b * m + a];
            }
            for (int b = 0; b < s_; ++b) {
                Pack sum = fill(0.0);
                for (int j = 0; j < n; ++j) sum = sum + room_.turned[i * n + j] * room_.basis[(rank_ + b) * n + j];
                room_.f[(i - rank_) * s_ + b] = sum;
            }
        }
    }

    // Row i of U^T J less what the strong rows before it span; of what is left of a strong one, the direction.
    void orthogonalise(int i) {
        Pack *row = room_.turned + i * n, *along = room_.lower + i * m;
        const int before = i < rank_ ? i : rank_;
        for (int b = 0; b < before; ++b) along[b] = fill(0.0);
        for (int pass = 0; pass < (i < rank_ ? 1 : 2); ++pass)  // what is left of a weak row is small: twice
            for (int b = 0; b < before; ++b) {
                const Pack* q = room_.basis + b * n;
                Pack overlap = fill(0.0);
                for (int j = 0; j < n; ++j) overlap = overlap + row[j] * q[j];
                for (int j = 0; j < n; ++j) row[j] = row[j] - overlap * q[j];
                along[b] = along[b] + overlap;
            }
        if (i >= rank_) return;
        Pack square = fill(0.0);
        for (int j = 0; j < n; ++j) square = square + row[j] * row[j];
        along[i] = sqrt(max(square, fill(1e-300)));
        const Pack inverse = fill(1.0) / along[i];
        for (int j = 0; j < n; ++j) room_.basis[i * n + j] = row[j] * inverse;
    }

    // V2: what it was before, made orthogonal to the strong rows as they are now.
    void complete(Pack* v) {
        for (int i = rank_; i < n; ++i) {
            Pack* x = room_.basis + i * n;
            for (int j = 0; j < n; ++j) x[j] = v[(i - rank_) * n + j];
            for (int b = 0; b < i; ++b) {
                const Pack* q = room_.basis + b * n;
                Pack overlap = fill(0.0);
                for (int j = 0; j < n; ++j) overlap = overlap + x[j] * q[j];
                for (int j = 0; j < n; ++j) x[j] = x[j] - overlap * q[j];
            }
            Pack square = fill(0.0);
            for (int j = 0; j < n; ++j) square = square + x[j] * x[j];
            const Pack inverse = fill(1.0) / sqrt(max(square, fill(1e-300)));
            for (int j = 0; j < n; ++j) v[(i - rank_) * n + j] = x[j] = x[j] * inverse;
        }
    }

    // step <- step - D^+ (F + D step) in scaled variables, by Gram and Schmidt; a row that depends on those before it is
    // left out.
    void onto_tangent_plane() {
        int rows = 0;
        for (int b = 0; b < s_; ++b) {
            derivative_times(chain_, view_, room_.at, room_.basis + (rank_ + b) * n, room_.scratch);
            for (int i = 0; i < m - rank_; ++i) {
                Pack* row = room_.rows + rows * n;
                Pack right = room_.f[i * s_ + b], before = fill(0.0), after = fill(0.0);
                for (int k = 0; k < n; ++k) {
                    Pack slope = fill(0.0);
                    for (int a = 0; a < m; ++a) slope = slope + room_.left[i * m + a] * room_.scratch[k * m + a];
                    row[k] = slope * scale_[k];
                    right = right + row[k] * room_.step[k];
                    before = before + row[k] * row[k];
                }
                for (int e = 0; e < rows; ++e) {
                    const Pack* other = room_.rows + e * n;
                    Pack overlap = fill(0.0);
                    for (int k = 0; k < n; ++k) overlap = overlap + row[k] * other[k];
                    for (int k = 0; k < n; ++k) row[k] = row[k] - overlap * other[k];
                    right = right - overlap * room_.right[e];
                }
                for (int k = 0; k < n; ++k) after = after + row[k] * row[k];
                const Pack length = sqrt(max(after, fill(1e-300)));
                const Pack factor = select(after > before * 1e-14 + fill(1e-28), fill(1.0) / length, fill(0.0));
                for (int k = 0; k < n; ++k) row[k] = row[k] * factor;
                room_.right[rows++] = right * factor;
            }
        }
        for (int e = 0; e < rows; ++e)
            for (int k = 0; k < n; ++k) room_.step[k] = room_.step[k] - room_.right[e] * room_.rows[e * n + k];
    }

    const Chain& chain_;
    View view_;
    const double* scale_;
    const Workspace& start_;
    SetRoom& room_;
    const int m, n, rank_, s_;
    bool shifted_;
};

// `out`: kGroup of them.
template <class Beside>
inline void walk_onto_set(const Chain& chain, const View& view, const double* scale, int rank, const Pack* q,
                          const Workspace& start, const int* lanes, SetRoom& room, OntoSet* out, Beside beside) {
    if (view.m == 6 && chain.variables == 7 && rank == 5)
        return WalkOntoSet<6, 7, 5>(chain, view, scale, rank, start, room).run(q, lanes, out, beside);
    if (view.m == 6 && chain.variables == 6 && rank == 5)
        return WalkOntoSet<6, 6, 5>(chain, view, scale, rank, start, room).run(q, lanes, out, beside);
    WalkOntoSet<0, 0, 0>(chain, view, scale, rank, start, room).run(q, lanes, out, beside);
}

}  // namespace rankdrop::RANKDROP_ISA
