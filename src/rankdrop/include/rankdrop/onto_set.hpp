// How far to where the rank drops, from the kinematics alone: for families whose conditions are too long to be walked on.
#pragma once

#include "block.hpp"
#include "set_points.hpp"

namespace rankdrop::RANKDROP_ISA {

inline constexpr int kWalk = 8;          // Newton steps of a walk at most, by conditions
inline constexpr int kWalkOnSet = 5;        // and by the kinematics, which cost as much as a hundred terms
inline constexpr double kStill = 0.05;   // a step this much shorter than the distance changes that by a thousandth of it
inline constexpr double kStride = 0.7;   // of a step at most [rad]
inline constexpr double kQuicken = 0.3;  // steps shorter than this are drawn from two tangent planes [rad]
inline constexpr double kBack = 0.4;     // of a step that led away, what is tried instead
inline constexpr double kHopeless = 1.05; // times the nearest value so far: a tangent plane that is farther is not gone to
inline constexpr double kBeside = 1e-2;  // of a family's conditions, where a walk of it ends [rad]
inline constexpr double kOffOwn = 0.04, kOffPoint = 0.12;  // as far off the set as this, of the distance, it is believed
inline constexpr int kHere = 2;              // walks of one configuration that begin at it where points are known
inline constexpr int kStarts = kHere + kNearPoints;  // all its walks, one a lane
inline constexpr int kPacks = (kStarts + W - 1) / W;

// Scratch of `WalkOntoSet`. By packs (kPacks, n) where not said: x, as ways from q in scaled variables.
struct SetRoom {
    Placed at;
    Pack *q, *x;                // (n), (n)
    Pack *way, *last, *last_step, *held, *held_step;  // where a walk is, was before, and was nearest, and the steps there
    Pack *end, *normal;         // where its value is from, and the way from q to the tangent plane there
    Pack *u, *v;                // (kPacks, m, m), (kPacks, n, n) by columns: the border, weak ones last; the last V2
    Pack *step, *jacobian, *turned;  // (n), (m, n) by rows; turned: U^T J
    Pack *basis;                // (n, n) by columns: row space of the strong rows, then its complement
    Pack *lower, *pull;         // (m, m) the strong rows in that basis, (m)
    Pack *left;                 // (m - rank, m) by rows
    Pack *f, *right, *bare, *rows;  // (entries), (entries), (entries), (entries, n): F, and D orthonormal
    Pack *scratch;              // (n, m)
    double *normal_of, *first;  // (n) from q to the tangent plane at the nearest end; where the first step leads
    PointRoom points;

    SetRoom(const Chain& chain, int m_, Arena& arena) : at(placed_in(chain, arena)), points(arena) {
        const std::size_t m = static_cast<std::size_t>(m_), n = static_cast<std::size_t>(chain.variables);
        const std::size_t packs = static_cast<std::size_t>(kPacks);
        q = arena.take<Pack>(n), x = arena.take<Pack>(n), u = arena.take<Pack>(packs * m * m);
        for (Pack** ways : {&way, &last, &last_step, &held, &held_step, &end, &normal}) *ways = arena.take<Pack>(packs * n);
        v = arena.take<Pack>(packs * n * n), step = arena.take<Pack>(n), jacobian = arena.take<Pack>(m * n);
        turned = arena.take<Pack>(m * n), basis = arena.take<Pack>(n * n), lower = arena.take<Pack>(m * m);
        pull = arena.take<Pack>(m), left = arena.take<Pack>(m * m), f = arena.take<Pack>(m * n);
        right = arena.take<Pack>(m * n), bare = arena.take<Pack>(m * n), rows = arena.take<Pack>(m * n * n);
        scratch = arena.take<Pack>(n * m), normal_of = arena.take<double>(n), first = arena.take<double>(n);
    }
};

// Distances to first order, and to the nearest point that a walk comes to (infinite where none does).
struct OntoSet {
    double first, distance;
};

// Whether all of the twist is seen, in axes of the base. Its rank is that seen at the base, where derivatives are shortest.
inline bool whole_twist(const View& view) {
    bool whole = view.m == 6 && view.axes == 0;
    for (int a = 0; a < view.m; ++a) whole = whole && view.row[a] == a;
    return whole;
}

inline View seen_from_base(View view) {
    if (!whole_twist(view)) return view;
    view.origin = 0;
    for (double& one : view.point) one = 0.0;
    return view;
}

// From one configuration to where the rank is r or less: Newton's steps onto the tangent plane of F = 0, nearest to q, over
// all joints, from several sheets of the set at once. Walk 0 begins at q with its weakest direction for the one that
// vanishes, walk 1 with its second weakest: near a point where both are lost, the nearer sheet may be either's. The others
// begin at points of the set that lie near (`SetPoints`), or where there are none at q as well, walk k with the k-th weakest
// direction that is still strong. Beside F and D, every look gives a bound from above to first order,
//     |q - x| + |D^+ F|,
// which counts where the second part is small, so that walks that circle count too. A step that leads to a larger one is
// shortened; one that follows another is quickened by the secant of both (Anderson). ROWS, JOINTS, RANK > 0 fix the sizes at
// compile time (loops unroll); 0 leaves them to run time.
template <int ROWS, int JOINTS, int RANK>
class WalkOntoSet {
  public:
    WalkOntoSet(const Chain& chain, const View& view, const double* scale, int rank, SetRoom& room)
        : chain_(chain), view_(seen_from_base(view)), scale_(scale), room_(room), m(ROWS ? ROWS : view.m),
          n(JOINTS ? JOINTS : chain.variables), rank_(RANK ? RANK : rank), s_(n - rank_),
          shifted_(whole_twist(view)) {}

    // From one lane of `start`, decomposed at q (in the same lane). `beside(x)`: how far ends x are from the family's
    // conditions.
    template <class Beside>
    void run(const Pack* q, const Workspace& start, int from, const SetPoints* points, OntoSet& out, Beside beside) {
        begin(q, start, from, points);
        const Pack far = fill(HUGE_VAL);
        Pack value[kPacks], merit[kPacks], off[kPacks], plane[kPacks];
        Mask going[kPacks];
        for (int pack = 0; pack < kPacks; ++pack)
            value[pack] = merit[pack] = off[pack] = plane[pack] = far, going[pack] = fill(0.0) < far;
        for (int count = 0; count < kWalkOnSet; ++count) {
            bool more = false;
            for (int pack = 0; pack < kPacks; ++pack) {
                if (!any(going[pack])) continue;
                const Pack* way = room_.way + pack * n;
                for (int j = 0; j < n; ++j) room_.x[j] = room_.q[j] + way[j] * scale_[j], room_.step[j] = -way[j];
                near(pack);
                const Pack error = onto_tangent_plane(), length = size_of(room_.step), distance = size_of(way);
                if (count == 0 && pack == 0) keep_first(out);
                keep_end(pack, going[pack], distance, error, value[pack], off[pack], plane[pack]);
                going[pack] = going[pack] & (length > distance * kStill + fill(1e-9));
                if (count + 1 < kWalkOnSet) advance(pack, count, going[pack], distance + error + error, length, merit[pack]);
            }
            double nearest = HUGE_VAL;
            for (int pack = 0; pack < kPacks; ++pack)
                for (int lane = 0; lane < W; ++lane) nearest = std::min(nearest, get(value[pack], lane));
            for (int pack = 0; pack < kPacks; ++pack) {
                if (count > 0) going[pack] = going[pack] & (plane[pack] < fill(nearest * kHopeless));
                more = more || any(going[pack]);
            }
            if (!more) break;
        }
        finish(value, off, out, beside);
    }

    // step <- -D^+ F at configurations decomposed in this view with `keep` the rank, lane by lane.
    void back_onto_set(const Workspace& here) {
        for (std::size_t i = 0; i < chain_.joints.size(); ++i) room_.at.screws[i] = here.at.screws[i];
        for (int i = 0; i < 3; ++i) room_.at.p[i] = here.at.p[i];
        room_.at.base_axes = here.at.base_axes;
        for (int i = 0; i < 9 && !here.at.base_axes; ++i) room_.at.axes[i] = here.at.axes[i];
        for (int i = 0; i < (m - rank_) * m; ++i) room_.left[i] = here.u[rank_ * m + i];
        for (int i = rank_ * n; i < n * n; ++i) room_.basis[i] = here.v[i];
        for (int i = 0; i < m - rank_; ++i)
            for (int b = 0; b < s_; ++b) {
                Pack& f = room_.f[i * s_ + b];
                f = fill(0.0);
                for (int a = 0; a < m; ++a)
                    for (int j = 0; j < n; ++j)
                        f = f + room_.left[i * m + a] * here.jacobian[a * n + j] * room_.basis[(rank_ + b) * n + j];
            }
        for (int j = 0; j < n; ++j) room_.step[j] = fill(0.0);
        onto_tangent_plane();
    }

    const View& view() const { return view_; }
    // (n) one row of D at the last look, of length 1, in scaled variables.
    const Pack* row(int number) const { return room_.rows + number * n; }

  private:
    Pack size_of(const Pack* x) const {
        Pack square = fill(0.0);
        for (int j = 0; j < n; ++j) square = square + x[j] * x[j];
        return sqrt(square);
    }

    // Which walk a lane is.
    static int walk_of(int pack, int lane) { return (pack * W + lane) % kStarts; }

    void keep_first(OntoSet& out) {
        double square = 0.0;
        for (int j = 0; j < n; ++j) {
            const double x = get(room_.step[j], 0);
            square += x * x, room_.first[j] = x;
        }
        out.first = std::sqrt(square);
    }

    // The value of a walk, the least so far, and where it is from; how far the tangent plane is.
    void keep_end(int pack, Mask going, const Pack& distance, const Pack& error, Pack& value, Pack& off, Pack& plane) {
        Pack believed = fill(kOffPoint);
        if (!begun_at_points_) believed = fill(kOffOwn);
        else
            for (int lane = 0; lane < W; ++lane)
                if (walk_of(pack, lane) < kHere) set(believed, lane, kOffOwn);
        const Pack bound = distance + error;
        const Mask nearer = going & (error <= believed * distance + fill(1e-9)) & (bound < value);
        value = select(nearer, bound, value), off = select(nearer, error, off);
        Pack square = fill(0.0);
        for (int j = 0; j < n; ++j) {
            Pack &end = room_.end[pack * n + j], &normal = room_.normal[pack * n + j];
            const Pack way = room_.way[pack * n + j];
            const Pack onto = way + room_.step[j];
            end = select(nearer, way, end), normal = select(nearer, onto, normal), square = square + onto * onto;
        }
        plane = select(going, sqrt(square), plane);
    }

    void advance(int pack, int count, Mask going, const Pack& merit, const Pack& length, Pack& least) {
        Pack *way = room_.way + pack * n, *last = room_.last + pack * n, *last_step = room_.last_step + pack * n;
        Pack *held = room_.held + pack * n, *held_step = room_.held_step + pack * n;
        Pack share = fill(0.0);
        if (count > 0) {
            Pack along = fill(0.0), square = fill(1e-30);
            for (int j = 0; j < n; ++j) {
                const Pack change = room_.step[j] - last_step[j];
                along = along + change * room_.step[j], square = square + change * change;
            }
            share = select(length < fill(kQuicken), max(fill(-2.0), min(fill(2.0), along / square)), share);
        }
        const Mask better = merit <= least;
        least = select(better & going, merit, least);
        for (int j = 0; j < n; ++j) {
            const Pack step = room_.step[j];
            if (count > 0) room_.step[j] = step - share * (way[j] - last[j] + step - last_step[j]);
            last[j] = way[j], last_step[j] = step;
        }
        const Pack part = min(fill(1.0), fill(kStride) / max(size_of(room_.step), fill(1e-300)));
        for (int j = 0; j < n; ++j) {
            const Pack from = select(better, way[j], held[j]);
            const Pack step = select(better, room_.step[j] * part, held_step[j] * kBack);
            held[j] = from, held_step[j] = step;
            way[j] = select(going, from + step, way[j]);
        }
    }

    template <class Beside>
    void finish(const Pack* value, const Pack* off, OntoSet& out, Beside beside) {
        out.distance = HUGE_VAL;
        for (int pack = 0; pack < kPacks; ++pack) {
            for (int j = 0; j < n; ++j) room_.x[j] = room_.q[j] + room_.end[pack * n + j] * scale_[j];
            const Pack apart = beside(room_.x);
            for (int lane = 0; lane < W; ++lane) {
                if (!(get(value[pack], lane) < out.distance)) continue;
                if (!(get(apart, lane) <= kBeside + 2.0 * get(off[pack], lane))) continue;
                out.distance = get(value[pack], lane);
                for (int j = 0; j < n; ++j) room_.normal_of[j] = get(room_.normal[pack * n + j], lane);
            }
        }
    }

    // Which direction of the start stands at place i of walk k: its first weak one changes places with a strong one.
    int place(int i, int k) const { return k > rank_ ? i : i == rank_ ? rank_ - k : i == rank_ - k ? rank_ : i; }

    void begin(const Pack* q, const Workspace& start, int from, const SetPoints* points) {
        begun_at_points_ = points && points->width > 0;
        for (int j = 0; j < n; ++j) room_.q[j] = fill(get(q[j], from));
        int near_points[kNearPoints];
        double* at = room_.normal_of;
        for (int j = 0; j < n; ++j) at[j] = get(q[j], from);
        if (begun_at_points_) nearest_points(*points, at, room_.points, near_points);
        for (int pack = 0; pack < kPacks; ++pack)
            for (int lane = 0; lane < W; ++lane) {
                const int walk = walk_of(pack, lane);
                if (walk >= kHere && begun_at_points_)
                    begin_at(*points, near_points[walk - kHere], at, pack, lane);
                else
                    begin_here(start, from, walk, pack, lane);
            }
    }

    void begin_here(const Workspace& start, int from, int walk, int pack, int lane) {
        for (int j = 0; j < n; ++j) set(room_.way[pack * n + j], lane, 0.0);
        for (int i = 0; i < m; ++i) put_border(start, i, walk, pack, lane, from);
        for (int b = 0; b < s_; ++b)
            for (int j = 0; j < n; ++j)
                set(room_.v[(pack * n + b) * n + j], lane, get(start.v[place(rank_ + b, walk) * n + j], from));
    }

    // The border's last direction is the one that is lost at the point; the strong ones are made of it by a reflection.
    void begin_at(const SetPoints& points, int number, const double* q, int pack, int lane) {
        const float *x = points.point(number), *lost = x + n, *free = lost + m;
        for (int j = 0; j < n; ++j) set(room_.way[pack * n + j], lane, 0.0);
        for (const int j : points.moving) {
            const double gap = (double)x[j] - q[j];
            set(room_.way[pack * n + j], lane, gap - kTurn * std::nearbyint(gap / kTurn));
        }
        const double sign = lost[m - 1] < 0.0f ? -1.0 : 1.0, square = 1.0 + std::fabs((double)lost[m - 1]);
        const auto mirror = [&](int a) { return (double)lost[a] + (a == m - 1 ? sign : 0.0); };
        for (int i = 0; i < m; ++i)
            for (int a = 0; a < m; ++a)
                set(room_.u[(pack * m + i) * m + a], lane,
                    i == m - 1 ? (double)lost[a] : (i == a ? 1.0 : 0.0) - mirror(i) * mirror(a) / square);
        for (int i = 0; i < s_ * n; ++i) set(room_.v[pack * n * n + i], lane, (double)free[i]);
    }

    // Direction i of the border: u, or where the twist is seen from the base, u^T of the shift from there to the point.
    void put_border(const Workspace& start, int i, int walk, int pack, int lane, int from_lane) {
        const Pack* from = start.u + place(i, walk) * m;
        Pack* to = room_.u + (pack * m + i) * m;
        for (int a = 0; a < m; ++a) set(to[a], lane, get(from[a], from_lane));
        if (!shifted_) return;
        double f[3], p[3];
        for (int c = 0; c < 3; ++c) f[c] = get(from[c], from_lane) * view_.factor[c], p[c] = get(start.at.p[c], from_lane);
        for (int c = 0; c < 3; ++c) {
            const int d = (c + 1) % 3, e = (c + 2) % 3;
            set(to[3 + c], lane, get(from[3 + c], from_lane) + (p[d] * f[e] - p[e] * f[d]) / view_.factor[3 + c]);
        }
    }

    // F and its bases at room.x, without singular values. U of the start splits the task in strong and weak directions; with
    // L Q = U1^T J (Gram and Schmidt) and a weak row a = u^T J,
    //     w = a - (a Q^T) Q,   left = u - U1 L^-T Q a^T,    so that w = left^T J lies in the complement V2 of Q,
    // and J has rank r where every w is zero. F = w V2, and D = left^T dJ V2 is its derivative.
    void near(int pack) {
        const Pack* u = room_.u + pack * m * m;
        forward(chain_, view_, room_.x, room_.at);
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
    // left out. Returns |D^+ F|.
    Pack onto_tangent_plane() {
        int rows = 0;
        Pack square = fill(0.0);
        for (int b = 0; b < s_; ++b) {
            derivative_times(chain_, view_, room_.at, room_.basis + (rank_ + b) * n, room_.scratch);
            for (int i = 0; i < m - rank_; ++i) {
                Pack* row = room_.rows + rows * n;
                Pack right = room_.f[i * s_ + b], bare = right, before = fill(0.0), after = fill(0.0);
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
                    right = right - overlap * room_.right[e], bare = bare - overlap * room_.bare[e];
                }
                for (int k = 0; k < n; ++k) after = after + row[k] * row[k];
                const Pack length = sqrt(max(after, fill(1e-300)));
                const Pack factor = select(after > before * 1e-14 + fill(1e-28), fill(1.0) / length, fill(0.0));
                for (int k = 0; k < n; ++k) row[k] = row[k] * factor;
                room_.right[rows] = right * factor, room_.bare[rows] = bare * factor;
                square = square + room_.bare[rows] * room_.bare[rows];
                ++rows;
            }
        }
        for (int e = 0; e < rows; ++e)
            for (int k = 0; k < n; ++k) room_.step[k] = room_.step[k] - room_.right[e] * room_.rows[e * n + k];
        return sqrt(square);
    }

    const Chain& chain_;
    const View view_;
    const double* scale_;
    SetRoom& room_;
    const int m, n, rank_, s_;
    const bool shifted_;
    bool begun_at_points_ = false;
};

template <class Beside>
inline void walk_onto_set(const Chain& chain, const View& view, const double* scale, int rank, const Pack* q,
                          const Workspace& start, int lane, const SetPoints* points, SetRoom& room, OntoSet& out,
                          Beside beside) {
    if (view.m == 6 && chain.variables == 7 && rank == 5)
        return WalkOntoSet<6, 7, 5>(chain, view, scale, rank, room).run(q, start, lane, points, out, beside);
    if (view.m == 6 && chain.variables == 6 && rank == 5)
        return WalkOntoSet<6, 6, 5>(chain, view, scale, rank, room).run(q, start, lane, points, out, beside);
    WalkOntoSet<0, 0, 0>(chain, view, scale, rank, room).run(q, start, lane, points, out, beside);
}

}  // namespace rankdrop::RANKDROP_ISA
