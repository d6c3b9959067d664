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
inline constexpr double kHopelessFirst = 2.0;  // the same after the first look
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
    Pack *u, *v;                // (kPacks, m, m), (kPacks, n, n) by columns: the border, weak ones last; the last V2.
                                // Where one is weak, h of its reflection, 1 / (1 + |u_m|) and sign(u_m) for the strong ones
    Pack *step, *jacobian, *turned;  // (n), (m, n) by rows; turned: U^T J
    Pack *basis;                // (n, n) by columns: row space of the strong rows, then its complement
    Pack *lower, *pull;         // (m, m) the strong rows in that basis, (m)
    Pack *left;                 // (m - rank, m) by rows
    Pack *f, *right, *bare, *rows;  // (entries), (entries), (entries), (entries, n): F, and D orthonormal
    Pack *scratch;              // (n, m)
    double *normal_of, *first;  // (n) from q to the tangent plane at the nearest end; where the first step leads

    SetRoom(const Chain& chain, int m_, Arena& arena) : at(placed_in(chain, arena)) {
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

// A size that the compiler knows, or where FIXED is 0 one of run time.
template <int FIXED>
struct Size {
    explicit Size(int) {}
    operator int() const { return FIXED; }
};

template <>
struct Size<0> {
    int value;
    explicit Size(int value_) : value(value_) {}
    operator int() const { return value; }
};

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
        : chain_(chain), view_(seen_from_base(view)), scale_(scale), room_(room), m(view.m), n(chain.variables), rank_(rank),
          s_(n - rank_), shifted_(whole_twist(view)), mirrored_(m - rank_ == 1 && m > 2), factor_at_(m), sign_at_(m + 1) {}

    // From one lane of `start`, decomposed at q (in the same lane). `beside(x)`: how far ends x are from the family's
    // conditions.
    template <class Beside>
    void run(const Pack* q, const Workspace& start, int from, const SetPoints* points, OntoSet& out, Beside beside) {
        begin(q, start, from, points);
        Stand stand[kPacks];
        for (int pack = 0; pack < kPacks; ++pack) {
            for (int lane = 0; lane < W; ++lane)
                set(stand[pack].believed, lane, begun_at_points_ && walk_of(pack, lane) >= kHere ? kOffPoint : kOffOwn);
            look(pack, stand[pack]);
            if (pack == 0) keep_first(out);
            for (int j = 0; j < n; ++j) room_.last_step[pack * n + j] = room_.step[j];
        }
        gather_the_near(stand);
        for (int pack = 0; pack < kPacks; ++pack) {
            if (!any(stand[pack].going)) continue;
            for (int j = 0; j < n; ++j) room_.step[j] = room_.last_step[pack * n + j];
            advance(pack, 0, stand[pack]);
        }
        for (int count = 1; count < kWalkOnSet; ++count) {
            for (int pack = 0; pack < kPacks; ++pack) {
                if (!any(stand[pack].going)) continue;
                look(pack, stand[pack]);
                if (count + 1 < kWalkOnSet) advance(pack, count, stand[pack]);
            }
            const Pack enough = fill(kHopeless * least_value(stand));
            bool more = false;
            for (Stand& one : stand) {
                one.going = one.going & (one.plane < enough);
                more = more || any(one.going);
            }
            if (!more) break;
        }
        finish(stand, out, beside);
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

    // Where the walks of a pack stand.
    struct Stand {
        Pack value = fill(HUGE_VAL), off = fill(HUGE_VAL);  // nearest end so far, and how far that may be off the set
        Pack plane = fill(HUGE_VAL);                        // to the tangent plane at the last look
        Pack least = fill(HUGE_VAL), merit = fill(HUGE_VAL);  // the smallest merit, and that of the last look
        Pack distance = fill(HUGE_VAL), length = fill(HUGE_VAL);  // of the last look, and of its step
        Pack believed = fill(0.0);                          // part of the distance that an end may be off the set
        Mask going = fill(0.0) < fill(1.0);
    };

    // F, D and the step at a pack's places, and the stand of its walks there.
    void look(int pack, Stand& stand) {
        const Pack* way = room_.way + pack * n;
        for (int j = 0; j < n; ++j) room_.x[j] = room_.q[j] + way[j] * scale_[j], room_.step[j] = -way[j];
        near(pack);
        const Pack error = onto_tangent_plane();
        stand.distance = size_of(way), stand.length = size_of(room_.step), stand.merit = stand.distance + error + error;
        keep_end(pack, error, stand);
        stand.going = stand.going & not_still(stand);
    }

    static Mask not_still(const Stand& stand) { return stand.length > stand.distance * kStill + fill(1e-9); }

    // After the first look: walks whose tangent planes are far stop, and those that go on fill the first lanes.
    void gather_the_near(Stand* stand) {
        const double enough = kHopelessFirst * least_value(stand);
        const auto goes_on = [&](int walk) {
            const Stand& one = stand[walk / W];
            return get(one.going, walk % W) && get(one.plane, walk % W) < enough;
        };
        int count = 0;
        for (int walk = 0; walk < kStarts; ++walk) {
            if (!goes_on(walk)) continue;
            if (walk != count) exchange(stand, walk, count);
            ++count;
        }
        for (int pack = 0; pack < kPacks; ++pack) {
            Pack number;
            for (int lane = 0; lane < W; ++lane) set(number, lane, (double)(pack * W + lane));
            stand[pack].going = number < fill((double)count);
        }
    }

    static double least_value(const Stand* stand) {
        double least = HUGE_VAL;
        for (int pack = 0; pack < kPacks; ++pack)
            for (int lane = 0; lane < W; ++lane) least = std::min(least, get(stand[pack].value, lane));
        return least;
    }

    void exchange(Stand* stand, int one, int other) {
        const auto change = [&](Pack& a, Pack& b) {
            const double keep = get(a, one % W);
            set(a, one % W, get(b, other % W)), set(b, other % W, keep);
        };
        Stand &a = stand[one / W], &b = stand[other / W];
        for (Pack Stand::*part : {&Stand::value, &Stand::off, &Stand::plane, &Stand::merit, &Stand::distance, &Stand::length,
                                  &Stand::believed})
            change(a.*part, b.*part);
        const auto change_all = [&](Pack* all, int size) {
            for (int i = 0; i < size; ++i) change(all[one / W * size + i], all[other / W * size + i]);
        };
        for (Pack* ways : {room_.way, room_.last_step, room_.end, room_.normal}) change_all(ways, n);
        change_all(room_.u, m * m), change_all(room_.v, n * n);
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
    void keep_end(int pack, const Pack& error, Stand& stand) {
        const Pack bound = stand.distance + error;
        const Mask nearer = stand.going & (error <= stand.believed * stand.distance + fill(1e-9)) & (bound < stand.value);
        stand.value = select(nearer, bound, stand.value), stand.off = select(nearer, error, stand.off);
        Pack square = fill(0.0);
        for (int j = 0; j < n; ++j) {
            Pack &end = room_.end[pack * n + j], &normal = room_.normal[pack * n + j];
            const Pack way = room_.way[pack * n + j];
            const Pack onto = way + room_.step[j];
            end = select(nearer, way, end), normal = select(nearer, onto, normal), square = square + onto * onto;
        }
        stand.plane = select(stand.going, sqrt(square), stand.plane);
    }

    void advance(int pack, int count, Stand& stand) {
        Pack *way = room_.way + pack * n, *last = room_.last + pack * n, *last_step = room_.last_step + pack * n;
        Pack *held = room_.held + pack * n, *held_step = room_.held_step + pack * n;
        Pack share = fill(0.0);
        if (count > 0) {
            Pack along = fill(0.0), square = fill(1e-30);
            for (int j = 0; j < n; ++j) {
                const Pack change = room_.step[j] - last_step[j];
                along = along + change * room_.step[j], square = square + change * change;
            }
            share = select(stand.length < fill(kQuicken), max(fill(-2.0), min(fill(2.0), along / square)), share);
        }
        const Mask better = stand.merit <= stand.least;
        stand.least = select(better & stand.going, stand.merit, stand.least);
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
            way[j] = select(stand.going, from + step, way[j]);
        }
    }

    template <class Beside>
    void finish(const Stand* stand, OntoSet& out, Beside beside) {
        out.distance = HUGE_VAL;
        for (int pack = 0; pack < kPacks; ++pack) {
            for (int j = 0; j < n; ++j) room_.x[j] = room_.q[j] + room_.end[pack * n + j] * scale_[j];
            const Pack apart = beside(room_.x);
            for (int lane = 0; lane < W; ++lane) {
                if (!(get(stand[pack].value, lane) < out.distance)) continue;
                if (!(get(apart, lane) <= kBeside + 2.0 * get(stand[pack].off, lane))) continue;
                out.distance = get(stand[pack].value, lane);
                for (int j = 0; j < n; ++j) room_.normal_of[j] = get(room_.normal[pack * n + j], lane);
            }
        }
    }

    // Which direction of the start stands at place i of walk k: its first weak one changes places with a strong one.
    int place(int i, int k) const { return k > rank_ ? i : i == rank_ ? rank_ - k : i == rank_ - k ? rank_ : i; }

    void begin(const Pack* q, const Workspace& start, int from, const SetPoints* points) {
        begun_at_points_ = mirrored_ && points && points->width > 0;
        for (int j = 0; j < n; ++j) room_.q[j] = fill(get(q[j], from));
        int near_points[kNearPoints];
        double* at = room_.normal_of;
        for (int j = 0; j < n; ++j) at[j] = get(q[j], from);
        if (begun_at_points_) nearest_points(*points, at, near_points);
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
        for (int i = mirrored_ ? rank_ : 0; i < m; ++i) put_border(start, i, walk, pack, lane, from);
        if (mirrored_) put_mirror(pack, lane);
        for (int b = 0; b < s_; ++b)
            for (int j = 0; j < n; ++j)
                set(room_.v[(pack * n + b) * n + j], lane, get(start.v[place(rank_ + b, walk) * n + j], from));
    }

    // The border's last direction is the one that is lost at the point.
    void begin_at(const SetPoints& points, int number, const double* q, int pack, int lane) {
        const float *x = points.point(number), *lost = x + n, *free = lost + m;
        for (int j = 0; j < n; ++j) set(room_.way[pack * n + j], lane, 0.0);
        for (const int j : points.moving) {
            const double gap = (double)x[j] - q[j];
            set(room_.way[pack * n + j], lane, gap - kTurn * std::nearbyint(gap / kTurn));
        }
        for (int a = 0; a < m; ++a) set(room_.u[(pack * m + rank_) * m + a], lane, (double)lost[a]);
        put_mirror(pack, lane);
        for (int i = 0; i < s_ * n; ++i) set(room_.v[pack * n * n + i], lane, (double)free[i]);
    }

    // What `reflect` needs of the direction that is lost, at length 1, in place of the strong ones.
    void put_mirror(int pack, int lane) {
        Pack *u = room_.u + pack * m * m, *lost = u + rank_ * m;
        double square = 0.0;
        for (int a = 0; a < m; ++a) square += get(lost[a], lane) * get(lost[a], lane);
        const double length = std::sqrt(square);
        for (int a = 0; a < m; ++a) {
            const double part = get(lost[a], lane) / length;
            set(lost[a], lane, part), set(u[a], lane, part);
        }
        const double last = get(lost[rank_], lane), sign = last < 0.0 ? -1.0 : 1.0;
        set(u[rank_], lane, last + sign), set(u[sign_at_], lane, sign), set(u[factor_at_], lane, 1.0 / (1.0 + std::fabs(last)));
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
        if (mirrored_) reflect(u);
        else turn(u);
        orthogonalise(room_.v + pack * n * n);
        for (int i = rank_; i < m; ++i) {
            for (int b = rank_ - 1; b >= 0; --b) {
                Pack sum = room_.lower[i * m + b];
                for (int c = b + 1; c < rank_; ++c) sum = sum - room_.lower[c * m + b] * room_.pull[c];
                room_.pull[b] = sum / room_.lower[b * m + b];
            }
            take_left(u, i);
            for (int b = 0; b < s_; ++b) {
                Pack sum = fill(0.0);
                for (int j = 0; j < n; ++j) sum = sum + room_.turned[i * n + j] * room_.basis[(rank_ + b) * n + j];
                room_.f[(i - rank_) * s_ + b] = sum;
            }
        }
    }

    // left <- u_i - U1 pull.
    void take_left(const Pack* u, int i) {
        Pack* left = room_.left + (i - rank_) * m;
        for (int a = 0; a < m; ++a) left[a] = u[i * m + a];
        if (!mirrored_) {
            for (int a = 0; a < m; ++a)
                for (int b = 0; b < rank_; ++b) left[a] = left[a] - room_.pull[b] * u[b * m + a];
            return;
        }
        Pack along = fill(0.0);
        for (int b = 0; b < rank_; ++b) along = along + room_.pull[b] * u[b], left[b] = left[b] - room_.pull[b];
        along = along * u[factor_at_];
        for (int a = 0; a < m; ++a) left[a] = left[a] + along * u[a];
    }

    // U^T J.
    void turn(const Pack* u) {
        for (int i = 0; i < m; ++i)
            for (int j = 0; j < n; ++j) {
                Pack sum = fill(0.0);
                for (int a = 0; a < m; ++a) sum = sum + u[i * m + a] * room_.jacobian[a * n + j];
                room_.turned[i * n + j] = sum;
            }
    }

    // The same where U1 is a reflection's: all but the last of e_i - h_i h / (1 + |u_m|), h = u + sign(u_m) e_m.
    void reflect(const Pack* u) {
        const Pack *lost = u + rank_ * m, *last = room_.jacobian + rank_ * n;
        for (int j = 0; j < n; ++j) {
            Pack sum = fill(0.0);
            for (int a = 0; a < m; ++a) sum = sum + lost[a] * room_.jacobian[a * n + j];
            room_.turned[rank_ * n + j] = sum;
            const Pack along = (sum + u[sign_at_] * last[j]) * u[factor_at_];
            for (int i = 0; i < rank_; ++i) room_.turned[i * n + j] = room_.jacobian[i * n + j] - u[i] * along;
        }
    }

    // Rows of U^T J less what the strong rows before them span, and of what is left of a strong one, the direction: `basis`.
    // V2 completes it: what it was before, made orthogonal to them. What is left of a weak row is small: twice. A direction
    // is taken off all that come later at once, so that their sums overlap.
    void orthogonalise(Pack* v) {
        for (int i = rank_; i < n; ++i)
            for (int j = 0; j < n; ++j) room_.basis[i * n + j] = v[(i - rank_) * n + j];
        for (int b = 0; b < rank_; ++b) {
            const Pack length = size_above_zero(room_.turned + b * n), inverse = fill(1.0) / length;
            room_.lower[b * m + b] = length;
            for (int j = 0; j < n; ++j) room_.basis[b * n + j] = room_.turned[b * n + j] * inverse;
            for (int i = b + 1; i < m; ++i) room_.lower[i * m + b] = fill(0.0) + take_off(b, room_.turned + i * n);
            for (int i = rank_; i < n; ++i) take_off(b, room_.basis + i * n);
        }
        for (int i = rank_; i < m; ++i)
            for (int b = 0; b < rank_; ++b)
                room_.lower[i * m + b] = room_.lower[i * m + b] + take_off(b, room_.turned + i * n);
        for (int i = rank_; i < n; ++i) {
            Pack* x = room_.basis + i * n;
            for (int b = rank_; b < i; ++b) take_off(b, x);
            const Pack inverse = fill(1.0) / size_above_zero(x);
            for (int j = 0; j < n; ++j) v[(i - rank_) * n + j] = x[j] = x[j] * inverse;
        }
    }

    Pack size_above_zero(const Pack* x) const {
        Pack square = fill(0.0);
        for (int j = 0; j < n; ++j) square = square + x[j] * x[j];
        return sqrt(max(square, fill(1e-300)));
    }

    // x less its part along direction b of the basis, which is returned.
    Pack take_off(int b, Pack* x) const {
        const Pack* q = room_.basis + b * n;
        Pack overlap = fill(0.0);
        for (int j = 0; j < n; ++j) overlap = overlap + x[j] * q[j];
        for (int j = 0; j < n; ++j) x[j] = x[j] - overlap * q[j];
        return overlap;
    }

    // row_k = left^T dJ(e_k) x, of what `derivative_times` found.
    void slopes_of_task(const Pack* left, Pack* row) const {
        for (int k = 0; k < n; ++k) {
            row[k] = fill(0.0);
            for (int a = 0; a < m; ++a) row[k] = row[k] + left[a] * room_.scratch[k * m + a];
        }
    }

    // The same of the twist seen from the base: with the wrench (f ; t) that `left` is and (v ; w) = sum over i > k of S_i x_i,
    //     left^T [S_k, (v ; w)] = w_k . (v x f + w x t) + v_k . (w x f).
    void slopes_of_twist(const Pack* left, const Pack* x, Pack* row) const {
        Pack force[3], moment[3], by_rotation[3], by_translation[3], other[3];
        Twist later{};
        for (int c = 0; c < 3; ++c) {
            force[c] = left[c] * view_.factor[c], moment[c] = left[3 + c] * view_.factor[3 + c];
            later.v[c] = later.w[c] = fill(0.0);
        }
        for (int k = 0; k < n; ++k) row[k] = fill(0.0);
        for (int k = (int)chain_.joints.size() - 1; k >= 0; --k) {
            const Twist& screw = room_.at.screws[k];
            const int variable = chain_.joints[(std::size_t)k].variable;
            cross(later.v, force, by_rotation), cross(later.w, moment, other), cross(later.w, force, by_translation);
            for (int c = 0; c < 3; ++c) by_rotation[c] = by_rotation[c] + other[c];
            row[variable] = row[variable] + dot3(screw.w, by_rotation) + dot3(screw.v, by_translation);
            for (int c = 0; c < 3; ++c) {
                later.v[c] = later.v[c] + screw.v[c] * x[variable];
                later.w[c] = later.w[c] + screw.w[c] * x[variable];
            }
        }
    }

    // step <- step - D^+ (F + D step) in scaled variables, by Gram and Schmidt; a row that depends on those before it is
    // left out. Returns |D^+ F|.
    Pack onto_tangent_plane() {
        int rows = 0;
        Pack square = fill(0.0);
        for (int b = 0; b < s_; ++b) {
            const Pack* x = room_.basis + (rank_ + b) * n;
            if (!shifted_) derivative_times(chain_, view_, room_.at, x, room_.scratch);
            for (int i = 0; i < m - rank_; ++i) {
                Pack* row = room_.rows + rows * n;
                Pack right = room_.f[i * s_ + b], bare = right, before = fill(0.0), after = fill(0.0);
                if (shifted_) slopes_of_twist(room_.left + i * m, x, row);
                else slopes_of_task(room_.left + i * m, row);
                for (int k = 0; k < n; ++k) {
                    row[k] = row[k] * scale_[k];
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
    const Size<ROWS> m;
    const Size<JOINTS> n;
    const Size<RANK> rank_;
    const Size<JOINTS - RANK> s_;
    const bool shifted_, mirrored_;  // the twist is seen from the base; U1 is a reflection's
    const int factor_at_, sign_at_;        // places in `u` of what else `reflect` needs
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
