// Screws along straight motions of the joints, as power series (see local/taylor.py for the recursion).
#pragma once

#include <cstddef>
#include <vector>

namespace rankdrop {

// screws (joints, 6) at the start, all in the frame of the task, whose point is fixed in link `origin` and whose axes turn
// with link `axes`; rates (motions, joints). Out: (order + 1, motions, joints, 6) coefficients.
inline void screw_series(const double* screws, const double* rates, std::size_t motions, std::size_t joints, std::size_t axes,
                         std::size_t origin, std::size_t order, double* out) {
    const std::size_t slot = joints * 6, power = motions * slot;
    std::vector<double> carriers((order + 1) * slot);
    for (std::size_t d = 0; d < motions; ++d) {
        const double* rate = rates + d * joints;
        for (std::size_t k = 0; k < slot; ++k) out[d * slot + k] = screws[k];
        for (std::size_t p = 0;; ++p) {
            // W_i - V of this power: the joints before joint i carry it along, the frame's own motion is taken off
            const double* term = out + p * power + d * slot;
            double before[6] = {}, frame[6] = {};
            for (std::size_t i = 0; i < joints; ++i)
                for (std::size_t c = 0; c < 6; ++c)
                    if (i < (c < 3 ? origin : axes)) frame[c] += rate[i] * term[6 * i + c];
            for (std::size_t i = 0; i < joints; ++i)
                for (std::size_t c = 0; c < 6; ++c) {
                    carriers[p * slot + 6 * i + c] = before[c] - frame[c];
                    before[c] += rate[i] * term[6 * i + c];
                }
            if (p == order) break;
            double* next = out + (p + 1) * power + d * slot;
            const double share = 1.0 / (double)(p + 1);
            for (std::size_t i = 0; i < joints; ++i) {
                double sum[6] = {};
                for (std::size_t a = 0; a <= p; ++a) {
                    const double *x = carriers.data() + a * slot + 6 * i, *y = out + (p - a) * power + d * slot + 6 * i;
                    for (int c = 0; c < 3; ++c) {
                        const int e = (c + 1) % 3, f = (c + 2) % 3;
                        sum[c] += (x[3 + e] * y[f] - x[3 + f] * y[e]) + (x[e] * y[3 + f] - x[f] * y[3 + e]);
                        sum[3 + c] += x[3 + e] * y[3 + f] - x[3 + f] * y[3 + e];
                    }
                }
                for (int c = 0; c < 6; ++c) next[6 * i + c] = sum[c] * share;
            }
        }
    }
}

}  // namespace rankdrop
