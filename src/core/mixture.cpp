#include "mixture.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

namespace rankdrop {
namespace {

using Numbers = std::vector<double>;

// Eigenvalues of a symmetric matrix (k x k, destroyed) by Jacobi's rotations, and where not null its eigenvectors by columns.
void eigen(double* a, int k, double* weights, double* vectors) {
    if (vectors)
        for (int i = 0; i < k * k; ++i) vectors[i] = i % (k + 1) == 0 ? 1.0 : 0.0;
    for (int sweep = 0; sweep < 30; ++sweep) {
        double off = 0.0, all = 0.0;
        for (int i = 0; i < k; ++i)
            for (int j = 0; j < k; ++j) (i == j ? all : off) += a[i * k + j] * a[i * k + j];
        if (off <= 1e-34 * (all + off)) break;
        for (int p = 0; p < k; ++p)
            for (int q = p + 1; q < k; ++q) {
                const double apq = a[p * k + q];
                if (apq == 0.0) continue;
                const double theta = (a[q * k + q] - a[p * k + p]) / (2.0 * apq);
                const double t = (theta < 0.0 ? -1.0 : 1.0) / (std::fabs(theta) + std::sqrt(theta * theta + 1.0));
                const double c = 1.0 / std::sqrt(t * t + 1.0), s = t * c;
                for (int i = 0; i < k; ++i) {
                    const double x = a[i * k + p], y = a[i * k + q];
                    a[i * k + p] = c * x - s * y, a[i * k + q] = s * x + c * y;
                }
                for (int i = 0; i < k; ++i) {
                    const double x = a[p * k + i], y = a[q * k + i];
                    a[p * k + i] = c * x - s * y, a[q * k + i] = s * x + c * y;
                }
                if (!vectors) continue;
                for (int i = 0; i < k; ++i) {
                    const double x = vectors[i * k + p], y = vectors[i * k + q];
                    vectors[i * k + p] = c * x - s * y, vectors[i * k + q] = s * x + c * y;
                }
            }
    }
    for (int i = 0; i < k; ++i) weights[i] = a[i * k + i];
}

class Mixer {
  public:
    explicit Mixer(const MixtureInput& in) : in_(in), blocks_(in.pieces * in.k * in.k), k_(in.k), n_(in.n) {
        const auto size = [](int count) { return static_cast<std::size_t>(count); };
        for (Numbers* room : {&x_, &ahead_, &stepped_, &vectors_}) room->resize(size(blocks_));
        matrix_.resize(size(std::max(k_ * k_, n_ * n_)));
        weights_.resize(size(std::max(in.pieces * k_, n_))), sorted_.resize(weights_.size());
        along_.resize(size(n_)), step_.resize(size(n_));
    }

    void run(std::int64_t row, const MixtureOutput& out) {
        values_ = in_.values + row * in_.pieces * k_, tensor_ = in_.tensor + row * blocks_ * n_, tau_ = in_.tau[row];
        double* mixed = out.mixed + row * blocks_;
        std::copy_n(in_.mixed + row * blocks_, blocks_, x_.begin());
        const double pace = 1.0 / std::max(tau_ * steepest(), 1e-300);
        for (int effort = 0; effort < in_.effort; ++effort) {
            descend(pace);
            const double most = bound();
            if (most - reached() <= std::max(0.1 * most, in_.exact)) break;
        }
        out.most[row] = bound();
        for (int c = 0; c < n_; ++c) out.step[row * n_ + c] = -tau_ * along_[static_cast<std::size_t>(c)];
        out.fall[row] = now() - after(out.step + row * n_);
        std::copy(x_.begin(), x_.end(), mixed);
    }

  private:
    // largest eigenvalue of the sum of T_jac T_jacᵀ
    double steepest() {
        std::fill_n(matrix_.begin(), n_ * n_, 0.0);
        for (int e = 0; e < blocks_; ++e)
            for (int a = 0; a < n_; ++a)
                for (int b = 0; b < n_; ++b) matrix_[static_cast<std::size_t>(a * n_ + b)] += tensor_[e * n_ + a] * tensor_[e * n_ + b];
        eigen(matrix_.data(), n_, weights_.data(), nullptr);
        return *std::max_element(weights_.begin(), weights_.begin() + n_);
    }

    // along_ = G(mixture)
    void follow(const Numbers& mixture) {
        std::fill(along_.begin(), along_.end(), 0.0);
        for (int e = 0; e < blocks_; ++e)
            for (int c = 0; c < n_; ++c)
                along_[static_cast<std::size_t>(c)] += mixture[static_cast<std::size_t>(e)] * tensor_[e * n_ + c];
    }

    // `rounds` steps of the accelerated projected gradient from x_
    void descend(double pace) {
        ahead_ = x_;
        double momentum = 1.0;
        for (int round = 0; round < in_.rounds; ++round) {
            follow(ahead_);
            for (int e = 0; e < blocks_; ++e) {
                const int inside = e % (k_ * k_), piece = e / (k_ * k_);
                double gradient = inside % (k_ + 1) == 0 ? values_[piece * k_ + inside / (k_ + 1)] : 0.0;
                for (int c = 0; c < n_; ++c) gradient -= tau_ * along_[static_cast<std::size_t>(c)] * tensor_[e * n_ + c];
                stepped_[static_cast<std::size_t>(e)] = ahead_[static_cast<std::size_t>(e)] + pace * gradient;
            }
            project();
            const double later = (1.0 + std::sqrt(1.0 + 4.0 * momentum * momentum)) / 2.0;
            const double on = (momentum - 1.0) / later;
            for (std::size_t e = 0; e < x_.size(); ++e) ahead_[e] = stepped_[e] + on * (stepped_[e] - x_[e]);
            std::swap(x_, stepped_);
            momentum = later;
        }
    }

    // stepped_ <- the nearest positive semidefinite blocks whose traces sum to 1, by their eigenvalues
    void project() {
        const int kk = k_ * k_, count = in_.pieces * k_;
        for (int piece = 0; piece < in_.pieces; ++piece) {
            const double* block = stepped_.data() + piece * kk;
            for (int i = 0; i < k_; ++i)
                for (int j = 0; j < k_; ++j)
                    matrix_[static_cast<std::size_t>(i * k_ + j)] = (block[i * k_ + j] + block[j * k_ + i]) / 2.0;
            eigen(matrix_.data(), k_, weights_.data() + piece * k_, vectors_.data() + piece * kk);
        }
        std::copy_n(weights_.begin(), count, sorted_.begin());
        std::sort(sorted_.begin(), sorted_.begin() + count, std::greater<>());
        double sum = 0.0, excess = 0.0;
        for (int i = 0; i < count; ++i) {
            sum += sorted_[static_cast<std::size_t>(i)];
            const double level = (sum - 1.0) / (i + 1);
            if (sorted_[static_cast<std::size_t>(i)] > level) excess = level;
        }
        for (int piece = 0; piece < in_.pieces; ++piece) {
            const double* v = vectors_.data() + piece * kk;
            for (int i = 0; i < k_; ++i)
                for (int j = 0; j < k_; ++j) {
                    double entry = 0.0;
                    for (int e = 0; e < k_; ++e)
                        entry += std::max(weights_[static_cast<std::size_t>(piece * k_ + e)] - excess, 0.0) * v[i * k_ + e] * v[j * k_ + e];
                    stepped_[static_cast<std::size_t>(piece * kk + i * k_ + j)] = entry;
                }
        }
    }

    double now() const { return *std::max_element(values_, values_ + in_.pieces * k_); }

    // what no step's fall, |step|^2 / 2 tau counted, can exceed, by x_; leaves along_ = G(x_)
    double bound() {
        follow(x_);
        double weighted = 0.0;
        for (int piece = 0; piece < in_.pieces; ++piece)
            for (int i = 0; i < k_; ++i)
                weighted += x_[static_cast<std::size_t>(piece * k_ * k_ + i * (k_ + 1))] * values_[piece * k_ + i];
        return now() - weighted + half_length();
    }

    // the same of the step from x_
    double reached() {
        for (int c = 0; c < n_; ++c) step_[static_cast<std::size_t>(c)] = -tau_ * along_[static_cast<std::size_t>(c)];
        return now() - after(step_.data()) - half_length();
    }

    double half_length() const {
        double square = 0.0;
        for (const double entry : along_) square += entry * entry;
        return tau_ * square / 2.0;
    }

    // the model's largest value after a step
    double after(const double* step) {
        double most = -HUGE_VAL;
        for (int piece = 0; piece < in_.pieces; ++piece) {
            for (int e = 0; e < k_ * k_; ++e) {
                double entry = e % (k_ + 1) == 0 ? values_[piece * k_ + e / (k_ + 1)] : 0.0;
                for (int c = 0; c < n_; ++c) entry += tensor_[(piece * k_ * k_ + e) * n_ + c] * step[c];
                matrix_[static_cast<std::size_t>(e)] = entry;
            }
            eigen(matrix_.data(), k_, weights_.data(), nullptr);
            most = std::max(most, *std::max_element(weights_.begin(), weights_.begin() + k_));
        }
        return most;
    }

    const MixtureInput& in_;
    const int blocks_, k_, n_;
    const double *values_ = nullptr, *tensor_ = nullptr;
    double tau_ = 1.0;
    Numbers x_, ahead_, stepped_, vectors_, matrix_, weights_, sorted_, along_, step_;
};

}  // namespace

void mix(const MixtureInput& in, std::int64_t begin, std::int64_t end, const MixtureOutput& out) {
    Mixer mixer(in);
    for (std::int64_t row = begin; row < end; ++row) mixer.run(row, out);
}

}  // namespace rankdrop
