// Equations of families at packs of configurations, and their common zeros by Gauss–Newton.
#pragma once

#include "settings.hpp"
#include "sightings.hpp"
#include "svd.hpp"

namespace rankdrop::RANKDROP_ISA {

// Adds the second derivatives of sum_e weight_e f_e, over the first `count` equations, to the lower half of sum (n, n). A
// term is a wave w times a monomial M of the slides:  d2(wM) = -w M m m^T + w' (m dM^T + dM m^T) + w d2M. Waves of one angle
// are added up first, then those of angles that begin alike, product by product (`Families::node_before`): the sum of a
// product gives the entries of its last joint with each joint before. `amplitude` has room for every product.
inline void bend_at(const Families& table, int count, const Pack* q, const Waves<Pack>& waves, const Pack* weight,
                    Pack* amplitude, Pack* sum) {
    const int n = table.variables, nodes = table.nodes_of_first[(std::size_t)count];
    const auto add = [&](int a, int b, Pack value) {
        Pack& entry = sum[(a > b ? a : b) * n + (a > b ? b : a)];
        entry = entry + value;
    };
    for (int v = 0; v < nodes; ++v) amplitude[v] = fill(0.0);
    for (int e = 0; e < count; ++e)
        for (int t = table.terms[e]; t < table.terms[e + 1]; ++t) {
            const int k = table.angle[t], first = table.turns[k], last = table.turns[k + 1];
            Pack& whole = amplitude[table.node[t]];
            const int* p = table.powers.data() + (std::size_t)t * n;
            const Pack sine = waves.sine[table.node[t]], cosine = waves.cosine[table.node[t]];
            const Pack wave = (cosine * table.a[t] + sine * table.b[t]) * weight[e];
            if (!table.powered[t]) {
                whole = whole + wave;
                continue;
            }
            const Pack slope = (cosine * table.b[t] - sine * table.a[t]) * weight[e];
            // the monomial, differentiated by the slides a and b; -1 for none
            const auto monomial = [&](int a, int b) {
                Pack product = fill(1.0);
                for (int j = 0; j < n; ++j) {
                    int left = p[j];
                    for (const int by : {a, b})
                        if (by == j) product = product * (double)left--;
                    if (left > 0) product = product * power(q[j], left);
                }
                return product;
            };
            for (int a = 0; a < n; ++a) {
                if (p[a] == 0) continue;
                for (int b = 0; b <= a; ++b)
                    if (p[b] > 0 && (a != b || p[a] > 1)) add(a, b, wave * monomial(a, b));
                const Pack by = slope * monomial(a, -1);
                for (int i = first; i < last; ++i) add(table.turning[i], a, by * table.m[i]);
            }
            whole = whole + wave * monomial(-1, -1);
        }
    for (int v = nodes - 1; v >= 0; --v) {
        const int before = table.node_before[v], last = table.node_joint[v];
        if (before >= 0) amplitude[before] = amplitude[before] + amplitude[v];
        if (last < 0) continue;
        const Pack part = amplitude[v] * -table.node_m[v];
        for (int u = v; u >= 0; u = table.node_before[u])
            if (table.node_joint[u] >= 0) add(last, table.node_joint[u], part * table.node_m[u]);
    }
}

// f_e and their gradients at one pack of configurations.
class Equations {
  public:
    Equations(const Families& table, Arena& arena) : table_(table), count_((int)table.terms.size() - 1) {
        const auto take = [&](int count) { return arena.take<Pack>(static_cast<std::size_t>(count)); };
        f = take(count_), slopes = take(count_ * table.variables);
        sine_ = take(table.nodes()), cosine_ = take(table.nodes()), phase_ = take(2 * table.phases());
        amplitude_ = take(table.nodes());
    }

    void at(const Pack* q) { at(q, count_); }

    // the first `count` of them
    void at(const Pack* q, int count) {
        waves_of_first(table_, count, q, phase_, sine_, cosine_);
        const Waves<Pack> waves{sine_, cosine_};
        for (int e = 0; e < count; ++e) f[e] = equation_at(table_, e, q, waves, slopes + e * table_.variables);
    }

    // Adds the second derivatives of the first `count` equations, each times its weight, at the q of `at`, to the lower half
    // of sum (n, n).
    void bend(int count, const Pack* q, const Pack* weight, Pack* sum) const {
        bend_at(table_, count, q, Waves<Pack>{sine_, cosine_}, weight, amplitude_, sum);
    }

    int count() const { return count_; }

    // largest |f_e|
    Pack worst() const {
        Pack most = fill(0.0);
        for (int e = 0; e < count_; ++e) most = max(most, abs(f[e]));
        return most;
    }

    Pack *f, *slopes;  // (e), (e, n)

  private:
    const Families& table_;
    const int count_;
    Pack *sine_, *cosine_, *phase_, *amplitude_;
};

// Gauss–Newton with the shortest step −A⁺f along given directions, capped, in every lane until it is there.
class ZeroFinder {
    static_assert(kMostEquations <= kMaxColumns);

  public:
    ZeroFinder(const Families& table, const ZeroSettings& set, Arena& arena)
        : set_(set), n_(table.variables), free_(set.along.empty() ? n_ : (int)set.along.size() / n_), equations_(table, arena) {
        const int e = equations_.count();
        tall_ = std::max(e, free_), narrow_ = std::min(e, free_);
        const auto take = [&](int count) { return arena.take<Pack>(static_cast<std::size_t>(count)); };
        w_ = take(tall_ * narrow_), basis_ = take(narrow_ * narrow_), sigma_ = take(narrow_);
        step_ = take(n_), inner_ = take(free_);
    }

    // q in and out; what is left of the largest |f_e|
    Pack run(Pack* q) {
        Pack open = fill(1.0);
        for (int round = 0; round < set_.iterations; ++round) {
            equations_.at(q);
            open = select(equations_.worst() > fill(set_.enough), open, fill(0.0));
            if (!any(open > fill(0.0))) break;
            shortest();
            Pack square = fill(0.0);
            for (int j = 0; j < n_; ++j) square = square + step_[j] * step_[j];
            const Pack length = sqrt(square), share = min(fill(1.0), fill(set_.step) / max(length, fill(1e-300)));
            const Mask moves = open > fill(0.0);
            for (int j = 0; j < n_; ++j) q[j] = select(moves, q[j] - step_[j] * share, q[j]);
            open = select(length > fill(set_.still), open, fill(0.0));
        }
        equations_.at(q);
        return equations_.worst();
    }

  private:
    // A along direction d: of equation e
    Pack slope(int e, int d) const {
        const Pack* row = equations_.slopes + e * n_;
        if (set_.along.empty()) return row[d];
        Pack sum = fill(0.0);
        for (int j = 0; j < n_; ++j) sum = sum + row[j] * set_.along[static_cast<std::size_t>(j * free_ + d)];
        return sum;
    }

    // step_ = A⁺f, singular values below the cut left out
    void shortest() {
        const bool wide = equations_.count() <= free_;  // w = Aᵀ, else A: by columns, tall
        for (int c = 0; c < narrow_; ++c)
            for (int r = 0; r < tall_; ++r) w_[c * tall_ + r] = wide ? slope(c, r) : slope(r, c);
        svd(w_, tall_, narrow_, kExact, sigma_, basis_);
        for (int d = 0; d < free_; ++d) inner_[d] = fill(0.0);
        const Pack floor = max(sigma_[0] * fill(set_.cut), fill(1e-14));
        for (int c = 0; c < narrow_; ++c) {
            const Mask kept = sigma_[c] > floor;
            const Pack *left = w_ + c * tall_, *right = basis_ + c * narrow_;
            const Pack *out = wide ? left : right, *in = wide ? right : left;
            Pack share = fill(0.0);
            for (int e = 0; e < equations_.count(); ++e) share = share + in[e] * equations_.f[e];
            share = select(kept, share / select(kept, sigma_[c] * sigma_[c], fill(1.0)), fill(0.0));
            for (int d = 0; d < free_; ++d) inner_[d] = inner_[d] + out[d] * share;
        }
        for (int j = 0; j < n_; ++j) {
            if (set_.along.empty()) {
                step_[j] = inner_[j];
                continue;
            }
            step_[j] = fill(0.0);
            for (int d = 0; d < free_; ++d)
                step_[j] = step_[j] + inner_[d] * set_.along[static_cast<std::size_t>(j * free_ + d)];
        }
    }

    const ZeroSettings& set_;
    const int n_, free_;
    int tall_, narrow_;
    Equations equations_;
    Pack *w_, *basis_, *sigma_, *step_, *inner_;
};

}  // namespace rankdrop::RANKDROP_ISA
