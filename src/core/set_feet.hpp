// Feet of one configuration on the singular set, from many starts at once: Newton's steps on
//
//     minimise |x|^2 / 2  subject to  F(q) = u^T J V2 = 0,     x = (q - centre) / scale,
//
// where one freedom of all six is lost, with the second derivative of F in closed form. Steps go towards the set and along
// it together, so that a walk needs few of them. An end has F at most `off`, looked at once more; whether it is singular to
// the last digit is for others to say.
//
// Singular values are worked out where a walk begins. After that u comes from the direction that was lost at the step
// before: with U1 its complement, L Q = U1^T J and V2 the complement of Q,
//     u <- u - U1 L^-T Q J^T u   (of length 1),   so that  u^T J  lies in V2, as  J V2  does along u,
// one step of inverse iteration with J J^T for a tenth of the work. All that is said below of u, V2 and the pseudoinverse
// of what is kept, Q^T L^-1 U1^T, holds of these as of singular vectors.
#pragma once

#include <algorithm>

#include "block.hpp"
#include "damped.hpp"
#include "settings.hpp"

namespace rankdrop::RANKDROP_ISA {

class SetFeet {
  public:
    static constexpr int kRank = 5;  // kept, of six rows

    SetFeet(const Chain& chain, const View& view, const SetFeetSettings& settings, Arena& arena)
        : chain_(chain), set_(settings), view_(still_view(chain, view, settings, arena)), n_(chain.variables), s_(n_ - kRank),
          ws_(chain, 6, arena) {
        const auto take = [&](int count) { return arena.take<Pack>(static_cast<std::size_t>(count)); };
        for (Pack** vector : {&q_, &x_, &step_, &pull_, &z_, &normal_}) *vector = take(n_);
        for (Pack** matrix : {&slopes_, &bend_, &along_, &product_, &model_, &image_}) *matrix = take(n_ * n_);
        for (Pack** of_block : {&f_, &size_, &lambda_}) *of_block = take(s_);
        w_ = take(n_ * s_), left_ = take(s_ * s_), screws_ = take(6 * n_), moved_ = take(6 * n_);
        u_ = take(6), mirror_ = take(6), basis_ = take(n_ * n_), lower_ = take(kRank * kRank), pivot_ = take(kRank);
    }

    // Walks from q (count, n) to where they end, whole turns taken off; met (count): how they ended, far (count): how far
    // from the centre.
    void run(double* q, int count, std::int8_t* met, double* far) {
        for (int i = 0; i < count; ++i)
            for (int j = 0; j < n_; ++j) q[i * n_ + j] = (q[i * n_ + j] - set_.centre[(std::size_t)j]) / scale(j);
        walk(q, count, met);
        for (int i = 0; i < count; ++i) {
            double square = 0.0;
            for (int j = 0; j < n_; ++j) {
                double& x = q[i * n_ + j];
                const double turn = set_.turn[(std::size_t)j] / scale(j);
                if (turn > 0.0) x -= turn * std::nearbyint(x / turn);
                square += x * x;
                x = set_.centre[(std::size_t)j] + x * scale(j);
            }
            far[i] = std::sqrt(square);
        }
    }

  private:
    void walk(double* x, int count, std::int8_t* met) {
        std::vector<int> open((std::size_t)count), left;
        const int memory = 6 + s_ * n_;  // of a start: u and V2 of the step before
        before_.assign((std::size_t)(count * memory), 0.0);
        for (int i = 0; i < count; ++i) open[(std::size_t)i] = i, met[i] = kLost;
        for (int round = 0; round < set_.iterations && !open.empty(); ++round) {
            left.clear();
            by_packs(open, x, [&] { propose(round == 0); }, [&](int lane, int number) {
                double* last = before_.data() + number * memory;
                for (int a = 0; a < 6; ++a) last[a] = get(u_[a], lane);
                for (int i = 0; i < s_ * n_; ++i) last[6 + i] = get(basis_[kRank * n_ + i], lane);
                if (goes_on(lane, x + number * n_, met[number])) left.push_back(number);
            });
            open.swap(left);
        }
        left.clear();
        for (int i = 0; i < count; ++i)
            if (met[i] == kArrived) left.push_back(i);
        by_packs(left, x, [&] { look(); }, [&](int lane, int number) {
            if (!(get(off_, lane) <= set_.off)) met[number] = kNowhere;
        });
    }

    // `act` on packs of the starts with these numbers, and `judge` each of them.
    template <class Act, class Judge>
    void by_packs(const std::vector<int>& numbers, const double* x, Act act, Judge judge) {
        for (std::size_t first = 0; first < numbers.size(); first += W) {
            const int lanes = (int)std::min<std::size_t>(W, numbers.size() - first), memory = 6 + s_ * n_;
            for (int lane = 0; lane < W; ++lane) {
                const int number = numbers[first + (std::size_t)(lane < lanes ? lane : 0)];
                const double *from = x + number * n_, *last = before_.data() + number * memory;
                for (int j = 0; j < n_; ++j) set(x_[j], lane, from[j]);
                for (int a = 0; a < 6; ++a) set(u_[a], lane, last[a]);
                for (int i = 0; i < s_ * n_; ++i) set(basis_[kRank * n_ + i], lane, last[6 + i]);
            }
            act();
            for (int lane = 0; lane < lanes; ++lane) judge(lane, numbers[first + (std::size_t)lane]);
        }
    }

    // All six rows in axes and at a point that stand still: brackets of columns are their derivatives then. The point is
    // where that of the task is at the centre.
    static View still_view(const Chain& chain, const View& view, const SetFeetSettings& settings, Arena& arena) {
        Placed at = placed_in(chain, arena);
        Pack* q = arena.take<Pack>(static_cast<std::size_t>(chain.variables));
        for (int j = 0; j < chain.variables; ++j) q[j] = fill(settings.centre[static_cast<std::size_t>(j)]);
        forward(chain, view, q, at);
        View out = view;
        out.axes = out.origin = 0;
        // a point of link 0, whose frame is the first one
        const double* base = chain.frames.data();
        for (int i = 0; i < 3; ++i) {
            out.point[i] = 0.0;
            for (int k = 0; k < 3; ++k) out.point[i] += base[3 * k + i] * (get(at.p[k], 0) - base[9 + k]);
        }
        return out;
    }

    // Takes the step of a lane; whether another one is worth its while
    bool goes_on(int lane, double* x, std::int8_t& met) const {
        double square = 0.0, far = 0.0;
        for (int j = 0; j < n_; ++j) square += get(step_[j], lane) * get(step_[j], lane);
        const double length = std::sqrt(square);
        if (!(length < HUGE_VAL)) return false;
        const double share = length > set_.longest ? set_.longest / length : 1.0;
        for (int j = 0; j < n_; ++j) x[j] += share * get(step_[j], lane), far += x[j] * x[j];
        far = std::sqrt(far);
        if (length < kSure && far - kSlack * length > set_.farthest) {
            met = kFarther;
            return false;
        }
        if (length > set_.still) return true;
        if (get(off_, lane) <= kOff) met = kArrived;  // else F is least there, and not zero
        return false;
    }

    void to_joints() {
        for (int j = 0; j < n_; ++j) q_[j] = fill(set_.centre[(std::size_t)j]) + x_[j] * fill(scale(j));
    }

    void propose(bool first) {
        to_joints();
        if (first) {
            decompose_fast(chain_, view_, q_, kRank, ws_);
            for (int a = 0; a < 6; ++a) u_[a] = ws_.u[kRank * 6 + a];
            for (int i = kRank * n_; i < n_ * n_; ++i) basis_[i] = ws_.v[i];
        } else {
            place(chain_, view_, q_, ws_);
        }
        if (n_ == 7) return step_of<7>();
        if (n_ == 6) return step_of<6>();
        step_of<0>();
    }

    // How far from singular: F alone
    void look() {
        to_joints();
        place(chain_, view_, q_, ws_);
        border<0>();
    }

    // U1^T y: the coordinates but the last of y seen in the mirror that turns the last axis into u
    void strong_part(const Pack* y, Pack* out) const {
        const Pack share = dot6(mirror_, y) * turned_;
        for (int i = 0; i < kRank; ++i) out[i] = y[i] - mirror_[i] * share;
    }

    // screws_: the columns, seen from where nothing moves; u_; basis_: Q by rows, then V2; lower_ and pivot_: L and the
    // inverse of its diagonal; f_ and its length, off_
    template <int N>
    void border() {
        const int n = N ? N : n_, s = n - kRank;
        const Pack zero = fill(0.0), one = fill(1.0);
        for (int i = 0; i < n; ++i)
            for (int a = 0; a < 6; ++a) screws_[6 * i + a] = ws_.jacobian[a * n + i];
        for (int a = 0; a < 6; ++a) mirror_[a] = u_[a];
        mirror_[5] = mirror_[5] + select(u_[5] < zero, -one, one);
        turned_ = one / (one + abs(u_[5]));
        Pack* weak = pull_;
        for (int j = 0; j < n; ++j) {
            Pack strong[kRank];
            strong_part(screws_ + 6 * j, strong);
            for (int i = 0; i < kRank; ++i) basis_[i * n + j] = strong[i];
            weak[j] = dot6(u_, screws_ + 6 * j);
        }
        Pack along[kRank];
        for (int i = 0; i < n; ++i) {
            Pack* x = basis_ + i * n;
            for (int b = 0; b < i; ++b) {
                const Pack* y = basis_ + b * n;
                const Pack overlap = dot<N>(x, y);
                for (int j = 0; j < n; ++j) x[j] = x[j] - overlap * y[j];
                if (i < kRank) lower_[i * kRank + b] = overlap;
            }
            const Pack inverse = one / sqrt(max(dot<N>(x, x), fill(1e-12)));
            for (int j = 0; j < n; ++j) x[j] = x[j] * inverse;
            if (i < kRank) pivot_[i] = inverse;
        }
        for (int b = 0; b < kRank; ++b) along[b] = dot<N>(weak, basis_ + b * n);
        for (int b = kRank - 1; b >= 0; --b) {  // L^-T of it
            for (int c = b + 1; c < kRank; ++c) along[b] = along[b] - lower_[c * kRank + b] * along[c];
            along[b] = along[b] * pivot_[b];
        }
        Pack share = zero;
        for (int b = 0; b < kRank; ++b) share = share + mirror_[b] * along[b];
        for (int a = 0; a < 6; ++a) u_[a] = u_[a] + mirror_[a] * (share * turned_) - (a < kRank ? along[a] : zero);
        const Pack length = one / sqrt(dot6(u_, u_));
        for (int a = 0; a < 6; ++a) u_[a] = u_[a] * length;
        for (int j = 0; j < n; ++j) weak[j] = dot6(u_, screws_ + 6 * j);
        Pack square = zero;
        for (int b = 0; b < s; ++b) {
            f_[b] = dot<N>(weak, basis_ + (kRank + b) * n);
            square = square + f_[b] * f_[b];
        }
        off_ = sqrt(square);
    }

    template <int N>
    Pack dot(const Pack* a, const Pack* b) const {
        Pack sum = a[0] * b[0];
        for (int j = 1; j < (N ? N : n_); ++j) sum = sum + a[j] * b[j];
        return sum;
    }

    static Pack dot6(const Pack* a, const Pack* b) {
        return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5];
    }

    // g with  g . A = y . [A, s]
    static void seen_by(const Pack* y, const Pack* s, Pack* g) {
        Pack a[3], b[3];
        cross(s + 3, y, g);
        cross(s, y, a), cross(s + 3, y + 3, b);
        for (int c = 0; c < 3; ++c) g[3 + c] = a[c] + b[c];
    }

    template <int N>
    void step_of() {
        const int n = N ? N : n_, s = n - kRank;
        border<N>();
        const Pack zero = fill(0.0), *u = u_, *screws = screws_;
        Pack g[6];
        // slopes[k, i] = u^T dJ e_i / dq_k, for k < i
        for (int i = 0; i < n; ++i) {
            seen_by(u, screws + 6 * i, g);
            for (int k = 0; k < i; ++k) slopes_[k * n + i] = dot6(screws + 6 * k, g);
        }
        for (int b = 0; b < s; ++b) {
            const Pack* v = basis_ + (kRank + b) * n;
            for (int k = 0; k < n; ++k) {
                Pack sum = zero;
                for (int i = k + 1; i < n; ++i) sum = sum + slopes_[k * n + i] * v[i];
                w_[b * n + k] = sum * scale(k);
            }
        }
        split<N>();
        curve<N>(u, screws);
        // the second derivative of |x|^2 / 2 - lambda . F along the set, and what pulls along it
        for (int j = 0; j < n; ++j) {
            for (int k = 0; k < n; ++k) {
                Pack across = zero;
                for (int i = 0; i < s; ++i) across = across + w_[i * n + j] * w_[i * n + k];
                along_[j * n + k] = fill(j == k ? 1.0 : 0.0) - across;
                bend_[j * n + k] = fill(j == k ? 1.0 : 0.0) - bend_[j * n + k];
            }
        }
        for (int j = 0; j < n; ++j) {
            Pack pull = x_[j];
            for (int k = 0; k < n; ++k) {
                pull = pull + bend_[j * n + k] * normal_[k];
                Pack sum = zero;
                for (int i = 0; i < n; ++i) sum = sum + bend_[j * n + i] * along_[i * n + k];
                product_[j * n + k] = sum;
            }
            pull_[j] = pull;
        }
        for (int j = 0; j < n; ++j) {
            Pack sum = zero;
            for (int k = 0; k < n; ++k) {
                sum = sum + along_[j * n + k] * pull_[k];
                if (k > j) continue;  // symmetric
                Pack entry = fill(j == k ? 1.0 : 0.0) - along_[j * n + k];
                for (int i = 0; i < n; ++i) entry = entry + along_[j * n + i] * product_[i * n + k];
                model_[j * n + k] = entry;
            }
            z_[j] = sum;
        }
        solve_convex<N>(model_, set_.flattest, z_, n, step_);
        for (int j = 0; j < n; ++j) {
            Pack tangent = zero;
            for (int k = 0; k < n; ++k) tangent = tangent + along_[j * n + k] * step_[k];
            pull_[j] = normal_[j] - tangent;
        }
        for (int j = 0; j < n; ++j) step_[j] = pull_[j];
    }

    // A = D in scaled variables: w_ its right vectors, zero where left out; the way onto the set; lambda
    template <int N>
    void split() {
        const int n = N ? N : n_, s = n - kRank;
        const Pack zero = fill(0.0), one = fill(1.0);
        svd(w_, n, s, kExact, size_, left_);
        const Pack cut = fill(kCut) * sqrt(max(off_, fill(1e-16)));
        for (int j = 0; j < n; ++j) normal_[j] = zero;
        for (int b = 0; b < s; ++b) lambda_[b] = zero;
        for (int i = 0; i < s; ++i) {
            const Mask seen = size_[i] > cut;
            const Pack inverse = select(seen, one / select(seen, size_[i], one), zero);
            Pack off = zero, way = zero;
            for (int b = 0; b < s; ++b) off = off + left_[i * s + b] * f_[b];
            for (int j = 0; j < n; ++j) {
                w_[i * n + j] = w_[i * n + j] * inverse;
                way = way + w_[i * n + j] * x_[j];
            }
            off = off * inverse;
            for (int j = 0; j < n; ++j) normal_[j] = normal_[j] - w_[i * n + j] * off;
            for (int b = 0; b < s; ++b) lambda_[b] = lambda_[b] + left_[i * s + b] * (way * inverse);
        }
    }

    // bend_ = the second derivative of lambda . F in scaled variables: with z = V2 lambda and h_k = [S_k, sum over i > k of S_i z_i],
    //     u^T d2J z  at (k, l), l <= k:  u . [S_l, h_k],      less twice the symmetric part of  (u^T dJ_k) J1^+ (dJ_l z)
    template <int N>
    void curve(const Pack* u, const Pack* screws) {
        const int n = N ? N : n_, s = n - kRank;
        const Pack zero = fill(0.0);
        for (int j = 0; j < n; ++j) {
            z_[j] = zero;
            for (int b = 0; b < s; ++b) z_[j] = z_[j] + lambda_[b] * basis_[(kRank + b) * n + j];
        }
        Pack later[6], g[6];
        for (int a = 0; a < 6; ++a) later[a] = zero;
        for (int k = n - 1; k >= 0; --k) {
            const Pack* screw = screws + 6 * k;
            Pack *h = moved_ + 6 * k, left[3], right[3];
            cross(screw + 3, later, left), cross(screw, later + 3, right), cross(screw + 3, later + 3, h + 3);
            for (int c = 0; c < 3; ++c) h[c] = left[c] + right[c];
            seen_by(u, h, g);
            for (int l = 0; l <= k; ++l) bend_[k * n + l] = dot6(screws + 6 * l, g);
            for (int a = 0; a < 6; ++a) later[a] = later[a] + screw[a] * z_[k];
        }
        for (int l = 0; l < n; ++l) {
            Pack* image = image_ + l * n;
            Pack strong[kRank];
            strong_part(moved_ + 6 * l, strong);
            for (int i = 0; i < n; ++i) image[i] = zero;
            for (int r = 0; r < kRank; ++r) {
                for (int b = 0; b < r; ++b) strong[r] = strong[r] - lower_[r * kRank + b] * strong[b];
                strong[r] = strong[r] * pivot_[r];
                for (int i = 0; i < n; ++i) image[i] = image[i] + basis_[r * n + i] * strong[r];
            }
        }
        for (int k = 0; k < n; ++k)
            for (int l = 0; l < n; ++l) {
                Pack sum = zero;
                for (int i = k + 1; i < n; ++i) sum = sum + slopes_[k * n + i] * image_[l * n + i];
                product_[k * n + l] = sum;
            }
        for (int k = 0; k < n; ++k)
            for (int l = 0; l <= k; ++l) {
                const Pack value = (bend_[k * n + l] - product_[k * n + l] - product_[l * n + k]) * (scale(k) * scale(l));
                bend_[k * n + l] = bend_[l * n + k] = value;
            }
    }

    double scale(int j) const { return set_.scale[(std::size_t)j]; }

    static constexpr double kCut = 1e-2;    // values of D below this times the root of sigma are zero on the set, as in tangent.hpp
    static constexpr double kOff = 1e-4;    // sigma beside the set, by the last step at most

    const Chain& chain_;
    const SetFeetSettings& set_;
    const View view_;
    const int n_, s_;
    std::vector<double> before_;
    Workspace ws_;
    Pack *q_, *x_, *step_, *pull_, *z_, *normal_;
    Pack *slopes_, *bend_, *along_, *product_, *model_, *image_;
    Pack *f_, *size_, *lambda_, *w_, *left_, *screws_, *moved_;
    Pack *u_, *mirror_, *basis_, *lower_, *pivot_;
    Pack turned_{}, off_{};
};

}  // namespace rankdrop::RANKDROP_ISA
