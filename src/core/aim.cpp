// See aim.hpp. Rotations are 3 x 3 blocks of rows of 4 x 4 matrices.
#include "aim.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace rankdrop {
namespace {

constexpr double kWide = -0.85;        // cos below which a rotation vector is taken from the quaternion: near half a turn
constexpr double kTurnedOver = 1e-9;   // of 1 + cos of the tilt: the heading of a tool that is turned over is undefined
constexpr double kGoal = 1e-14;        // of an error: rounding
constexpr double kWeak = 1e-9;         // sigma below which Newton leaves a direction alone
constexpr double kCap = 0.5;           // of a step from far [rad; slides scaled]
constexpr double kHelps = 0.3, kTrusted = 3.0;  // shares of the error before: a step helps, a step is trusted

struct Turn {
    double r[3][3];
};

Turn rotation_of(const double* pose) {
    Turn out;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) out.r[i][j] = pose[4 * i + j];
    return out;
}

Turn transposed(const Turn& a) {
    Turn out;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) out.r[i][j] = a.r[j][i];
    return out;
}

Turn product(const Turn& a, const Turn& b) {
    Turn out;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) out.r[i][j] = a.r[i][0] * b.r[0][j] + a.r[i][1] * b.r[1][j] + a.r[i][2] * b.r[2][j];
    return out;
}

void applied(const Turn& a, const double* x, double* out) {
    for (int i = 0; i < 3; ++i) out[i] = a.r[i][0] * x[0] + a.r[i][1] * x[1] + a.r[i][2] * x[2];
}

// theta n near half a turn: from the column of 4 q q^T with the largest diagonal entry, q the quaternion (w, x, y, z).
void vector_near_half_turn(const Turn& t, double* vector) {
    const auto& r = t.r;
    const double outer[4][4] = {
        {1 + r[0][0] + r[1][1] + r[2][2], r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]},
        {r[2][1] - r[1][2], 1 + r[0][0] - r[1][1] - r[2][2], r[0][1] + r[1][0], r[0][2] + r[2][0]},
        {r[0][2] - r[2][0], r[0][1] + r[1][0], 1 - r[0][0] + r[1][1] - r[2][2], r[1][2] + r[2][1]},
        {r[1][0] - r[0][1], r[0][2] + r[2][0], r[1][2] + r[2][1], 1 - r[0][0] - r[1][1] + r[2][2]},
    };
    int largest = 0;
    for (int k = 1; k < 4; ++k)
        if (outer[k][k] > outer[largest][largest]) largest = k;
    double q[4], square = 0.0;
    for (int k = 0; k < 4; ++k) q[k] = outer[k][largest], square += q[k] * q[k];
    const double size = (q[0] < 0.0 ? -1.0 : 1.0) * std::sqrt(square);
    for (double& x : q) x /= size;
    const double sine = std::sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    const double share = 2.0 * std::atan2(sine, q[0]) / sine;
    for (int k = 0; k < 3; ++k) vector[k] = q[k + 1] * share;
}

// theta n of a rotation, 0 <= theta <= pi: from the skew part, which keeps its digits at small angles.
void rotation_vector(const Turn& t, double* vector) {
    const auto& r = t.r;
    const double cosine = 0.5 * (r[0][0] + r[1][1] + r[2][2] - 1.0);
    if (cosine < kWide) return vector_near_half_turn(t, vector);
    const double axial[3] = {0.5 * (r[2][1] - r[1][2]), 0.5 * (r[0][2] - r[2][0]), 0.5 * (r[1][0] - r[0][1])};
    const double sine = std::sqrt(axial[0] * axial[0] + axial[1] * axial[1] + axial[2] * axial[2]);
    const double share = sine > 0.0 ? std::atan2(sine, cosine) / sine : 1.0;
    for (int k = 0; k < 3; ++k) vector[k] = axial[k] * share;
}

// Rodrigues' formula.
Turn rotation_by(const double* vector) {
    const double angle = std::sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
    const double safe = angle > 0.0 ? angle : 1.0;
    const double x = vector[0] / safe, y = vector[1] / safe, z = vector[2] / safe;
    const Turn k{{{0.0, -z, y}, {z, 0.0, -x}, {-y, x, 0.0}}}, twice = product(k, k);
    const double s = std::sin(angle), c = 1.0 - std::cos(angle);
    Turn out;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) out.r[i][j] = (i == j ? 1.0 : 0.0) + s * k.r[i][j] + c * twice.r[i][j];
    return out;
}

// A rotation less what it turns about one axis, which the task leaves free.
Turn without(const Turn& turn, int axis, bool with_tip) {
    const auto& r = turn.r;
    const int i = (axis + 1) % 3, j = (axis + 2) % 3;
    double back[3] = {0.0, 0.0, 0.0};
    back[axis] = -2.0 * std::atan2(r[j][i] - r[i][j], 1.0 + r[0][0] + r[1][1] + r[2][2]);
    const Turn by = rotation_by(back);
    return with_tip ? product(turn, by) : product(by, turn);
}

void error_of(const AimSettings& aim, const double* now, const double* goal, double* error) {
    const Turn here = rotation_of(now), there = rotation_of(goal), back = transposed(here);
    double shift[3], vector[3];
    for (int i = 0; i < 3; ++i) {
        double lever = 0.0;
        for (int j = 0; j < 3; ++j) lever += (there.r[i][j] - here.r[i][j]) * aim.point[j];
        shift[i] = goal[4 * i + 3] - now[4 * i + 3] + lever;
    }
    Turn turn = aim.with_tip ? product(back, there) : product(there, back);
    if (aim.with_tip) {
        const double base[3] = {shift[0], shift[1], shift[2]};
        applied(back, base, shift);
    }
    if (aim.free >= 0) turn = without(turn, aim.free, aim.with_tip);
    rotation_vector(turn, vector);
    if (aim.heading >= 0 && 1.0 + turn.r[aim.heading][aim.heading] < kTurnedOver) vector[aim.heading] = std::numbers::pi;
    for (std::size_t a = 0; a < aim.rows.size(); ++a) {
        const int row = aim.rows[a];
        error[a] = row < 3 ? shift[row] / aim.length : vector[row - 3];
    }
}

// Room for one batch.
struct Scratch {
    Scratch(std::size_t m, std::size_t n, std::size_t count)
        : jacobian(count * m * n), sigma(count * std::min(m, n)), u(count * m * m), v(count * n * n) {}
    std::vector<double> jacobian, sigma, u, v;
};

void steps_of(const Aim& aim, const double* q, const double* errors, const double* damping, std::size_t count,
              Scratch& room, double* steps) {
    const std::size_t m = aim.m(), n = aim.n(), s = std::min(m, n);
    const Kernels& kernel = kernels(count);
    const std::int64_t end = static_cast<std::int64_t>(count);
    kernel.jacobian(aim.chain, aim.view, q, 0, end, room.jacobian.data());
    for (std::size_t k = 0; k < count * m * n; ++k) room.jacobian[k] *= aim.settings.joints[k % n];
    kernel.svd(static_cast<int>(m), static_cast<int>(n), room.jacobian.data(), 0, end, room.sigma.data(), room.u.data(),
               room.v.data());
    for (std::size_t row = 0; row < count; ++row) {
        const double *u = &room.u[row * m * m], *v = &room.v[row * n * n], *sigma = &room.sigma[row * s];
        double* step = steps + row * n;
        std::fill(step, step + n, 0.0);
        for (std::size_t k = 0; k < s; ++k) {
            const double damped = sigma[k] * sigma[k] + (damping ? damping[row] : 0.0);
            if (!(damped > kWeak * kWeak)) continue;
            double along = 0.0;
            for (std::size_t a = 0; a < m; ++a) along += errors[row * m + a] * u[a * m + k];
            const double share = sigma[k] / damped * along;
            for (std::size_t i = 0; i < n; ++i) step[i] += v[i * n + k] * share;
        }
        for (std::size_t i = 0; i < n; ++i) step[i] *= aim.settings.joints[i];
    }
}

// d of a pose of the tip, and the rotation vector of the turn from the start
void displacement_of(const DisplacementSettings& from, const double* now, double* error, double* turn) {
    rotation_vector(product(rotation_of(now), transposed(rotation_of(from.home))), turn);
    double shift[3];
    for (int i = 0; i < 3; ++i) {
        shift[i] = now[4 * i + 3] - from.home[4 * i + 3];
        for (int j = 0; j < 3; ++j) shift[i] += (now[4 * i + j] - from.home[4 * i + j]) * from.point[j];
    }
    for (std::size_t a = 0; a < from.rows.size(); ++a) {
        const int axis = from.rows[a] % 3;
        const double* vector = from.rows[a] < 3 ? shift : turn;
        error[a] = 0.0;
        for (int i = 0; i < 3; ++i) error[a] += from.axes[i][axis] * vector[i];
        error[a] *= from.row_scale[a];
    }
}

double length_of(const double* x, std::size_t count) {
    double square = 0.0;
    for (std::size_t i = 0; i < count; ++i) square += x[i] * x[i];
    return std::sqrt(square);
}

constexpr double kSmallTurn = 1e-2;  // below which (1 - a/2 cot a/2) / a^2 comes from its series

// omega - phi x omega / 2 + share phi x (phi x omega): the rate of the rotation vector phi of a body that turns with omega
void vector_rate(const double* phi, double share, double* omega) {
    double once[3], twice[3];
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        once[i] = phi[j] * omega[k] - phi[k] * omega[j];
    }
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        twice[i] = phi[j] * once[k] - phi[k] * once[j];
    }
    for (int i = 0; i < 3; ++i) omega[i] += share * twice[i] - 0.5 * once[i];
}

// The derivative (m, n) of d by scaled joint coordinates, from the six rows at one configuration
void displacement_slopes(const DisplacementSettings& from, const double* six, const double* turn, std::size_t n, double* out) {
    const double angle = length_of(turn, 3);
    double share = 1.0 / 12.0 + angle * angle / 720.0;
    if (angle >= kSmallTurn) share = (1.0 - 0.5 * angle / std::tan(0.5 * angle)) / (angle * angle);
    for (std::size_t k = 0; k < n; ++k) {
        double linear[3], omega[3];
        for (std::size_t i = 0; i < 3; ++i) {
            linear[i] = six[i * n + k] * from.joints[k];
            omega[i] = six[(i + 3) * n + k] * from.joints[k];
        }
        vector_rate(turn, share, omega);
        for (std::size_t a = 0; a < from.rows.size(); ++a) {
            const int axis = from.rows[a] % 3;
            const double* vector = from.rows[a] < 3 ? linear : omega;
            double sum = 0.0;
            for (int i = 0; i < 3; ++i) sum += from.axes[i][axis] * vector[i];
            out[a * n + k] = sum * from.row_scale[a];
        }
    }
}

// -A+ d, directions of singular values up to `weak` left out; u (m, m), sigma (s), v (n, n) of A
void shortest_step(const double* u, const double* sigma, const double* v, const double* error, double weak, std::size_t m,
                   std::size_t n, double* step) {
    std::fill(step, step + n, 0.0);
    for (std::size_t k = 0; k < std::min(m, n); ++k) {
        if (!(sigma[k] > weak)) continue;
        double along = 0.0;
        for (std::size_t a = 0; a < m; ++a) along += error[a] * u[a * m + k];
        along /= sigma[k];
        for (std::size_t i = 0; i < n; ++i) step[i] -= v[i * n + k] * along;
    }
}

}  // namespace

void aim_errors(const AimSettings& aim, const double* now, const double* goals, std::size_t count, double* errors) {
    for (std::size_t row = 0; row < count; ++row) error_of(aim, now + 16 * row, goals + 16 * row, errors + aim.rows.size() * row);
}

void aim_steps(const Aim& aim, const double* q, const double* errors, const double* damping, std::size_t count, double* steps) {
    Scratch room(aim.m(), aim.n(), count);
    steps_of(aim, q, errors, damping, count, room, steps);
}

void aim_newton(const Aim& aim, const NewtonSettings& how, const double* goals, std::size_t count, double* q, std::int64_t* when) {
    const std::size_t m = aim.m(), n = aim.n();
    Scratch room(m, n, count);
    std::vector<std::size_t> left(count), going;
    std::iota(left.begin(), left.end(), std::size_t{0});
    std::vector<double> size(count, std::numeric_limits<double>::infinity());
    std::vector<double> here(count * n), now(16 * count), errors(count * m), damping(count), steps(count * n);
    std::fill(when, when + count, std::int64_t{-1});
    for (const std::size_t row : left) std::copy_n(q + row * n, n, &here[row * n]);
    const int passes = how.far ? how.rounds : how.rounds + 1;  // from near the last one only looks
    for (int number = 0; number < passes && !left.empty(); ++number) {
        const bool stands = how.far || number == how.rounds;  // else steps are made while they help
        kernels(left.size()).pose(aim.chain, here.data(), 0, static_cast<std::int64_t>(left.size()), now.data());
        going.clear();
        for (std::size_t k = 0; k < left.size(); ++k) {
            const std::size_t row = left[k];
            double error[6], square = 0.0;
            error_of(aim.settings, &now[16 * k], goals + 16 * row, error);
            for (std::size_t a = 0; a < m; ++a) square += error[a] * error[a];
            const double fresh = std::sqrt(square), before = size[row];
            size[row] = fresh;
            if (fresh <= kGoal || (fresh <= how.close && (stands || fresh > kHelps * before))) {
                when[row] = number;
                continue;
            }
            if (number == how.rounds || !std::isfinite(fresh) || !(how.far || fresh <= kTrusted * before)) continue;
            std::copy_n(error, m, &errors[going.size() * m]);
            std::copy_n(q + row * n, n, &here[going.size() * n]);
            damping[going.size()] = std::min(square, 1.0);
            going.push_back(row);
        }
        if (going.empty()) break;
        steps_of(aim, here.data(), errors.data(), how.far ? damping.data() : nullptr, going.size(), room, steps.data());
        for (std::size_t k = 0; k < going.size(); ++k) {
            double *step = &steps[k * n], length = 0.0, share = 1.0;
            for (std::size_t i = 0; i < n; ++i) length += (step[i] / aim.settings.joints[i]) * (step[i] / aim.settings.joints[i]);
            if (how.far) share = std::min(1.0, kCap / std::max(std::sqrt(length), 1e-300));
            for (std::size_t i = 0; i < n; ++i) here[k * n + i] += step[i] * share;
            std::copy_n(&here[k * n], n, q + going[k] * n);
        }
        left.swap(going);
    }
}

void displacement_back(const Chain& chain, const View& six, const DisplacementSettings& from, const BackSettings& how,
                       std::size_t count, double* q, double* off) {
    const std::size_t m = from.rows.size(), n = static_cast<std::size_t>(chain.variables), s = std::min(m, n);
    Scratch room(m, n, count);
    std::vector<std::size_t> left(count), going;
    std::iota(left.begin(), left.end(), std::size_t{0});
    std::vector<double> here(q, q + count * n), now(16 * count), errors(count * m), columns(count * 6 * n), step(n);
    double turn[3];
    for (int round = 0; round < how.rounds && !left.empty(); ++round) {
        const Kernels& kernel = kernels(left.size());
        const std::int64_t end = static_cast<std::int64_t>(left.size());
        kernel.pose(chain, here.data(), 0, end, now.data());
        kernel.jacobian(chain, six, here.data(), 0, end, columns.data());
        for (std::size_t k = 0; k < left.size(); ++k) {
            displacement_of(from, &now[16 * k], &errors[k * m], turn);
            displacement_slopes(from, &columns[k * 6 * n], turn, n, &room.jacobian[k * m * n]);
        }
        kernel.svd(static_cast<int>(m), static_cast<int>(n), room.jacobian.data(), 0, end, room.sigma.data(), room.u.data(),
                   room.v.data());
        going.clear();
        for (std::size_t k = 0; k < left.size(); ++k) {
            double* end_of = q + left[k] * n;
            shortest_step(&room.u[k * m * m], &room.sigma[k * s], &room.v[k * n * n], &errors[k * m], how.weak, m, n, step.data());
            const double length = length_of(step.data(), n), share = std::min(1.0, how.longest / std::max(length, 1e-300));
            for (std::size_t i = 0; i < n; ++i) end_of[i] += step[i] * share * from.joints[i];
            if (!(length > how.still)) continue;
            std::copy_n(end_of, n, &here[going.size() * n]);
            going.push_back(left[k]);
        }
        left.swap(going);
    }
    kernels(count).pose(chain, q, 0, static_cast<std::int64_t>(count), now.data());
    for (std::size_t row = 0; row < count; ++row) {
        displacement_of(from, &now[16 * row], &errors[row * m], turn);
        off[row] = length_of(&errors[row * m], m);
    }
}

void poses_at(const double* poses, std::size_t poses_count, const double* places, std::size_t count, double* out) {
    const double last = poses_count < 2 ? 0.0 : static_cast<double>(poses_count - 2);
    for (std::size_t row = 0; row < count; ++row) {
        const double whole = std::clamp(std::floor(places[row]), 0.0, last), share = places[row] - whole;
        const std::size_t k = static_cast<std::size_t>(whole), next = std::min(k + 1, poses_count - 1);
        const double *start = poses + 16 * k, *end = poses + 16 * next;
        const Turn from = rotation_of(start);
        double turn[3];
        rotation_vector(product(rotation_of(end), transposed(from)), turn);
        for (double& x : turn) x *= share;
        const Turn made = product(rotation_by(turn), from);
        double* to = out + 16 * row;
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) to[4 * i + j] = made.r[i][j];
            to[4 * i + 3] = start[4 * i + 3] + share * (end[4 * i + 3] - start[4 * i + 3]);
        }
        to[12] = to[13] = to[14] = 0.0, to[15] = 1.0;
    }
}

}  // namespace rankdrop
