// The readable basis of a subspace: of all candidates the one with the fewest entries.
// What is done and why stands in local/readable.py; the same in NumPy, as the oracle, in tests/reference/readable.py.
#include "readable.hpp"

#include "sparse_bases.hpp"

namespace rankdrop {
namespace {

constexpr double kRounding = 1e-13;  // entries below this are zero
constexpr int kPlanes = 20000;       // last planes looked at in the search for sparser bases: 10 ms; 6 rows need 4500

double step(double value) { return -std::nearbyint(value / kTie); }  // larger entries first, in steps of the tie

// Signs and order of the columns fixed, rounding removed.
Vector canonical(const double* basis, int rows, int columns) {
    Vector clean(basis, basis + rows * columns);
    std::vector<int> largest(columns), order(columns);
    for (int c = 0; c < columns; ++c) {
        double *x = &clean[c * rows], most = 0.0;
        for (int i = 0; i < rows; ++i) {
            if (std::fabs(x[i]) < kRounding) x[i] = 0.0;
            most = std::max(most, std::fabs(x[i]));
        }
        while (std::fabs(x[largest[c]]) < most - kTie) ++largest[c];
        const double sign = x[largest[c]] < 0.0 ? -1.0 : 1.0;
        for (int i = 0; i < rows; ++i) x[i] = x[i] * sign + 0.0;
        order[c] = c;
    }
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
        if (largest[a] != largest[b]) return largest[a] < largest[b];
        for (int i = 0; i < rows; ++i) {
            const double x = step(clean[a * rows + i]), y = step(clean[b * rows + i]);
            if (x != y) return x < y;
        }
        return false;
    });
    Vector sorted;
    for (int c : order) sorted.insert(sorted.end(), clean.begin() + c * rows, clean.begin() + (c + 1) * rows);
    return sorted;
}

// Of two tied bases: the larger |entries| in the earlier rows, then the larger entries.
bool earlier(const Vector& a, const Vector& b) {
    for (const bool sizes : {true, false})
        for (std::size_t i = 0; i < a.size(); ++i) {
            const double x = step(sizes ? std::fabs(a[i]) : a[i]), y = step(sizes ? std::fabs(b[i]) : b[i]);
            if (x != y) return x < y;
        }
    return false;
}

int entries_of(const double* a, int n) {
    return (int)std::count_if(a, a + n, [](double x) { return std::fabs(x) > kTie; });
}

// Looks for a basis with fewer entries than any so far, vector by vector: each one vanishes in as many rows as what is
// left of the space allows. A branch ends where even the sparsest vector of the rest, taken for every column, is too much.
class Sparser {
  public:
    Sparser(int rows, int columns, int fewest) : rows_(rows), columns_(columns), fewest_(fewest), chosen_(rows * columns) {}

    // Bases with strictly fewer entries than what was found before, the last ones the sparsest.
    Vector search(const Vector& basis) {
        branch(basis, columns_, 0);
        return found_;
    }

  private:
    void branch(const Vector& basis, int left, int spent) {
        double* next = &chosen_[(columns_ - left) * rows_];
        if (left == 2) {
            if (++planes_ > kPlanes) return;
            Vector candidates(2 * rows_ * rows_);
            const int count = plane_candidates(basis.data(), rows_, candidates.data());
            for (int i = 0; i < count; ++i) {
                const double* pair = &candidates[2 * rows_ * i];
                const int total = spent + entries_of(pair, 2 * rows_);
                if (total > fewest_ || (total == fewest_ && found_.empty())) continue;
                std::copy(pair, pair + 2 * rows_, next);
                fewest_ = total;
                found_.insert(found_.end(), chosen_.begin(), chosen_.end());
            }
            return;
        }
        Vector vectors, one(rows_), rest(rows_ * (left - 1));
        int least = rows_;
        std::vector<int> zeros = first_choice(left - 1);
        do {
            if (!vector_with_zeros(basis.data(), rows_, left, zeros, one.data()) || known(vectors, one)) continue;
            least = std::min(least, entries_of(one.data(), rows_));
            vectors.insert(vectors.end(), one.begin(), one.end());
        } while (next_choice(zeros, rows_));
        for (std::size_t at = 0; at < vectors.size(); at += rows_) {
            const int with = spent + entries_of(&vectors[at], rows_);
            if (with + (left - 1) * least > fewest_ - (found_.empty() ? 1 : 0)) continue;
            std::copy(&vectors[at], &vectors[at] + rows_, next);
            complement(basis.data(), rows_, left, &vectors[at], rest.data());
            branch(rest, left - 1, with);
        }
    }

    bool known(const Vector& vectors, const Vector& one) const {
        for (std::size_t at = 0; at < vectors.size(); at += rows_)
            if (std::fabs(dot(&vectors[at], one.data(), rows_)) > 1.0 - 1e-12) return true;
        return false;
    }

    const int rows_, columns_;
    int fewest_, planes_ = 0;
    Vector chosen_, found_;
};

void append_sparser(Vector& candidates, const Vector& basis, int rows, int columns) {
    const int size = rows * columns;
    int fewest = size + 1;
    for (std::size_t at = 0; at < candidates.size(); at += size) fewest = std::min(fewest, entries_of(&candidates[at], size));
    const Vector more = Sparser(rows, columns, fewest).search(basis);
    candidates.insert(candidates.end(), more.begin(), more.end());
}

// Fewest entries; among those the smallest sum; among ties as `earlier` says.
Vector choose(const Vector& candidates, int rows, int columns) {
    const int size = rows * columns, count = (int)candidates.size() / size;
    std::vector<int> entries(count);
    Vector sums(count);
    int fewest = size + 1;
    for (int i = 0; i < count; ++i) {
        const double* one = &candidates[size * i];
        entries[i] = entries_of(one, size);
        fewest = std::min(fewest, entries[i]);
        sums[i] = sum_of_sizes(one, size);
    }
    double smallest = 1e300;
    for (int i = 0; i < count; ++i)
        if (entries[i] == fewest) smallest = std::min(smallest, sums[i]);
    Vector best;
    for (int i = 0; i < count; ++i) {
        if (entries[i] != fewest || sums[i] > smallest + kTie) continue;
        Vector one = canonical(&candidates[size * i], rows, columns);
        if (best.empty() || earlier(one, best)) best = std::move(one);
    }
    return best;
}

}  // namespace

void readable(int rows, int columns, const double* in, std::int64_t count, double* out) {
    Vector basis(rows * columns);
    for (std::int64_t item = 0; item < count; ++item, in += rows * columns, out += rows * columns) {
        if (columns == rows) {
            for (int i = 0; i < rows; ++i)
                for (int j = 0; j < columns; ++j) out[i * columns + j] = i == j ? 1.0 : 0.0;
            continue;
        }
        for (int i = 0; i < rows; ++i)
            for (int j = 0; j < columns; ++j) basis[j * rows + i] = in[i * columns + j];
        Vector candidates = starts(basis, rows, columns);
        if (columns > 2) {
            append_swept(candidates, rows, columns);
            append_sparser(candidates, basis, rows, columns);
        }
        const Vector best = choose(candidates, rows, columns);
        for (int i = 0; i < rows; ++i)
            for (int j = 0; j < columns; ++j) out[i * columns + j] = best[j * rows + i];
    }
}

}  // namespace rankdrop
