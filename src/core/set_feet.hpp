// Feet of one configuration on the singular set, from many starts at once: Newton's steps on
//
//     minimise |x|^2 / 2  subject to  F(q) = u^T J V2 = 0,     x = (q - centre) / scale,
//
// where one freedom of all six is lost, with the second derivative of F in closed form. Steps go towards the set and along
// it together, so that a walk needs few of them; whether an end is singular is for others to say.
#pragma once

#include <algorithm>

#include "block.hpp"
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
    }

    // Walks from q (count, n) to where they end; met (count): how they ended.
    void run(double* q, int count, std::int8_t* met) {
        const auto each = [&](auto change) {
            for (int i = 0; i < count; ++i)
                for (int j = 0; j < n_; ++j) change(q[i * n_ + j], set_.centre[(std::size_t)j], scale(j));
        };
        each([](double& x, double centre, double unit) { x = (x - centre) / unit; });
        walk(q, count, met);
        each([](double& x, double centre, double unit) { x = centre + x * unit; });
    }

  private:
    void walk(double* x, int count, std::int8_t* met) {
        std::vector<int> open((std::size_t)count);
        for (int i = 0; i < count; ++i) open[(std::size_t)i] = i, met[i] = kLost;
        for (int round = 0; round < set_.iterations && !open.empty(); ++round) {
            std::vector<int> left;
            for (std::size_t first = 0; first < open.size(); first += W) {
                const int lanes = (int)std::min<std::size_t>(W, open.size() - first);
                for (int lane = 0; lane < W; ++lane) {
                    const double* from = x + open[first + (std::size_t)(lane < lanes ? lane : 0)] * n_;
                    for (int j = 0; j < n_; ++j) set(x_[j], lane, from[j]);
                }
                propose();
                for (int lane = 0; lane < lanes; ++lane) {
                    const int number = open[first + (std::size_t)lane];
                    if (goes_on(lane, x + number * n_, met[number])) left.push_back(number);
                }
            }
            open.swap(left);
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
        if (get(ws_.sigma[kRank], lane) <= kOff) met = kArrived;  // else F is least there, and not zero
        return false;
    }

    void propose() {
        for (int j = 0; j < n_; ++j) q_[j] = fill(set_.centre[(std::size_t)j]) + x_[j] * fill(scale(j));
        if (n_ == 7) return step_of<7>();
        if (n_ == 6) return step_of<6>();
        step_of<0>();
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
        const Pack zero = fill(0.0);
        decompose_fast(chain_, view_, q_, kRank, ws_);
        const Pack* u = ws_.u + kRank * 6;
        Pack g[6], *screws = screws_;  // the columns, seen from where nothing moves
        for (int i = 0; i < n; ++i)
            for (int a = 0; a < 6; ++a) screws[6 * i + a] = ws_.jacobian[a * n + i];
        // slopes[k, i] = u^T dJ e_i / dq_k, for k < i
        for (int i = 0; i < n; ++i) {
            seen_by(u, screws + 6 * i, g);
            for (int k = 0; k < i; ++k) slopes_[k * n + i] = dot6(screws + 6 * k, g);
        }
        for (int b = 0; b < s; ++b) {
            const Pack* v = ws_.v + (kRank + b) * n;
            Pack image[6];
            for (int a = 0; a < 6; ++a) {
                image[a] = zero;
                for (int i = 0; i < n; ++i) image[a] = image[a] + ws_.jacobian[a * n + i] * v[i];
            }
            f_[b] = dot6(u, image);
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
                Pack entry = fill(j == k ? 1.0 : 0.0) - along_[j * n + k];
                for (int i = 0; i < n; ++i) entry = entry + along_[j * n + i] * product_[i * n + k];
                model_[k * n + j] = entry;
            }
            z_[j] = sum;
        }
        solve<N>(model_, z_, step_);
        for (int j = 0; j < n; ++j) {
            Pack tangent = zero;
            for (int k = 0; k < n; ++k) tangent = tangent + along_[j * n + k] * step_[k];
            pull_[j] = normal_[j] - tangent;
        }
        for (int j = 0; j < n; ++j) step_[j] = pull_[j];
    }

    // x = M^-1 b for the symmetric M nearby that has no negative pivot: L diag(|d|) L^T
    template <int N>
    void solve(Pack* m, const Pack* b, Pack* x) const {
        const int n = N ? N : n_;
        for (int j = 0; j < n; ++j) {
            Pack pivot = m[j * n + j];
            for (int k = 0; k < j; ++k) pivot = pivot - m[j * n + k] * m[j * n + k] * m[k * n + k];
            pivot = max(abs(pivot), fill(set_.flattest));
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

    // A = D in scaled variables: w_ its right vectors, zero where left out; the way onto the set; lambda
    template <int N>
    void split() {
        const int n = N ? N : n_, s = n - kRank;
        const Pack zero = fill(0.0), one = fill(1.0);
        svd(w_, n, s, kExact, size_, left_);
        const Pack sigma = ws_.sigma[kRank];
        const Pack cut = fill(kCut) * sqrt(max(sigma, fill(1e-16)));
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
            for (int b = 0; b < s; ++b) z_[j] = z_[j] + lambda_[b] * ws_.v[(kRank + b) * n + j];
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
            for (int i = 0; i < n; ++i) image[i] = zero;
            for (int r = 0; r < kRank; ++r) {
                const Pack share = dot6(ws_.u + 6 * r, moved_ + 6 * l) / max(ws_.sigma[r], fill(1e-6));
                for (int i = 0; i < n; ++i) image[i] = image[i] + ws_.v[r * n + i] * share;
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
    static constexpr double kSure = 0.1;    // Newton's steps shorter than this get shorter still,
    static constexpr double kSlack = 2.0;   // and all that follow come to less than so many of them

    const Chain& chain_;
    const SetFeetSettings& set_;
    const View view_;
    const int n_, s_;
    Workspace ws_;
    Pack *q_, *x_, *step_, *pull_, *z_, *normal_;
    Pack *slopes_, *bend_, *along_, *product_, *model_, *image_;
    Pack *f_, *size_, *lambda_, *w_, *left_, *screws_, *moved_;
};

}  // namespace rankdrop::RANKDROP_ISA
