// Watches one arm in a control loop: header only, C++17, no Python. `rankdrop monitor ROBOT --header arm.h` writes the arm.
//
//     rankdrop::Monitor monitor(rankdrop_ur5_arm);
//     rankdrop_step seen;
//     monitor.step(q, velocity, seen);               // allocates nothing, throws nothing
//     velocity *= std::min(seen.scaling, seen.rate_scaling);
//
// With x = velocity / scale, joint by joint (scale: 1 for angles, the length scale for slides), and for each family the
// distance d and its gradient g by the scaled variables (`away`, there by q itself),
//
//     c = max(0, -g.x / |x|)                          the share of the motion that leads towards the family
//     k = (d - stop) / (start - stop), in 0 ... 1
//     1 / s = 1 - c + c / k,    scaling = the least s of all families
//
// so that a motion away from a family, along it, or of an arm that stands on it (d <= on) is not slowed; straight towards
// it, s = k. The null-space step is the steepest internal motion away from the nearest family that leads towards no other
// one nearer than `start`: P g projected on the cone {h: P g_f . h >= 0}, P the projection on the null space, at length 1.
// Bits are those of Python's `rankdrop.Monitor` where the compiler does not contract a*b + c.
#pragma once

#if defined(__FAST_MATH__)
#error "rankdrop/monitor.hpp: -ffast-math breaks the reduction of angles and tests for infinite values"
#endif

// a build of its own: the core's kernels live in other namespaces
#ifndef RANKDROP_ISA
#define RANKDROP_ISA header
#endif

#include <cmath>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "enclosure.hpp"
#include "monitor.h"
#include "single_svd.hpp"
#include "spread.hpp"

namespace rankdrop {
namespace RANKDROP_ISA {

class Monitor {
  public:
    // Of one family at the last step; `away`: (variables) gradient of the distance by q. NaN for one without conditions.
    struct Nearness {
        double distance, residual;
        const double* away;
    };

    // Throws std::invalid_argument for an arm that is not sound, std::bad_alloc.
    explicit Monitor(const rankdrop_arm& arm) : Monitor(chain_of(arm), view_of(arm), families_of(arm), settings_of(arm)) {
        name_ = arm.name;
        for (int f = 0; f < arm.listed; ++f) ids_.emplace_back(arm.ids[f]), names_.emplace_back(arm.names[f]);
        numbers_ = taken(arm.number, arm.families);
        places_.assign(static_cast<std::size_t>(arm.listed), -1);
        for (int f = 0; f < arm.families; ++f) {
            check(numbers_[f] >= 0 && numbers_[f] < arm.listed, "a family has no place in the list");
            places_[numbers_[f]] = f;
        }
        for (int b = 0; b < arm.bounds; ++b) bounds_.push_back(bound_of(arm, b));
    }

    Monitor(Chain chain, const View& view, Families families, MonitorSettings settings)
        : chain_(std::move(chain)), view_(view), families_(std::move(families)), settings_(std::move(settings)) {
        if (!families_.finish()) throw std::invalid_argument("rankdrop: sizes of the families' arrays do not agree");
        if (families_.variables != chain_.variables)
            throw std::invalid_argument("rankdrop: the families are of another number of joints");
        if (view_.links != chain_.links()) throw std::invalid_argument("rankdrop: the view is of another chain");
        if (settings_.generic < 1 || settings_.generic > std::min(view_.m, chain_.variables))
            throw std::invalid_argument("rankdrop: generic rank out of range");
        if (!(settings_.stop >= 0.0 && settings_.start > settings_.stop))
            throw std::invalid_argument("rankdrop: start is above stop, and stop is 0 or more");
        if (!settings_.rates.empty() && static_cast<int>(settings_.rates.size()) != chain_.variables)
            throw std::invalid_argument("rankdrop: one rate for each variable");
        if (!families_.points) RANKDROP_ISA::spread(chain_, view_, families_, settings_);
        const std::size_t n = size(), m = static_cast<std::size_t>(view_.m), count = families_.corank.size() + 1;
        const std::size_t nodes = static_cast<std::size_t>(families_.nodes());
        for (int f = 0; f < watched(); ++f) numbers_.push_back(f), places_.push_back(f);
        unknown_.assign(n, NAN);
        work_ = std::make_unique<Work>(chain_, view_.m, families_);
        sigma_.resize(std::min(m, n)), u_.resize(m * m), phase_.resize(2 * static_cast<std::size_t>(families_.phases()));
        sine_.resize(nodes), cosine_.resize(nodes);
        each_.resize(count), away_.resize(count * n), slope_.resize(count * n);
        inner_.resize(count * n), square_.resize(count), active_.resize(count);
        basis_.resize(n * n), gradient_.resize(n), null_.resize(n);
        held_.resize(n * n), upper_.resize(n * n), bound_.resize(n), pull_.resize(n), wish_.resize(n);
    }

    int variables() const { return chain_.variables; }
    int rows() const { return view_.m; }
    // Families are numbered as in Python's `Monitor.families`, here and in steps.
    int families() const { return static_cast<int>(places_.size()); }
    const std::string& name() const { return name_; }
    const std::string& id(int family) const { return ids_[static_cast<std::size_t>(family)]; }
    const std::string& name(int family) const { return names_[static_cast<std::size_t>(family)]; }

    // q, velocity: (variables); velocity may be null for none. False where one of them is not finite: then `out` says
    // rank -1 and scaling 0. Allocates nothing.
    bool step(const double* q, const double* velocity, rankdrop_step& out) noexcept {
        out = rankdrop_step{};
        out.rank = out.corank = out.family = out.nearest = -1;
        out.sigma = sigma_.data(), out.u = u_.data(), out.null_step = null_.data();
        for (int j = 0; j < chain_.variables; ++j)
            if (!std::isfinite(q[j]) || (velocity && !std::isfinite(velocity[j]))) return false;
        see(q, out);
        out.scaling = out.rate_scaling = 1.0;
        if (velocity) slow(velocity, out);
        step_inside(out);
        return true;
    }

    Nearness family(int number) const noexcept {
        const int place = places_[static_cast<std::size_t>(number)];
        if (place < 0) return {NAN, NAN, unknown_.data()};
        const std::size_t f = static_cast<std::size_t>(place);
        return {each_[f].distance, each_[f].residual, slope_.data() + f * size()};
    }

    // A radius around q within which no configuration is singular, of a known family or not [rad]: proven, by an enclosure
    // of each kind the arm came with; some hundred times the time of a step. 0 where nothing is proven or q is not finite.
    // Allocates: throws std::bad_alloc.
    double at_least(const double* q) const {
        double most = 0.0;
        for (int j = 0; j < chain_.variables; ++j)
            if (!std::isfinite(q[j])) return 0.0;
        for (const Bound& one : bounds_) {
            Arena arena;
            double radius = 0.0;
            EnclosureOutput out;
            out.radius = &radius;
            RANKDROP_ISA::Enclosure(chain_, one.view, one.settings, arena).run(q, nullptr, 0, 1, out);
            most = std::max(most, radius);
        }
        return kBelow * most;
    }

  private:
    using Pack = RANKDROP_ISA::Pack;

    // One way to look at the arm for a proof.
    struct Bound {
        View view;
        EnclosureSettings settings;
    };

    // Scratch of the kernels, and the arena it lies in.
    struct Work {
        Arena arena;
        RANKDROP_ISA::Workspace ws;
        Pack *x, *scratch, *gradient;
        RANKDROP_ISA::WalkRoom<double> walks;
        RANKDROP_ISA::FarRoom far;

        Work(const Chain& chain, int m, const Families& families)
            : ws(chain, m, arena), x(arena.take<Pack>(static_cast<std::size_t>(chain.variables))),
              scratch(arena.take<Pack>(static_cast<std::size_t>(chain.variables) * static_cast<std::size_t>(m))),
              gradient(arena.take<Pack>(static_cast<std::size_t>(chain.variables))), walks(families, arena),
              far(chain, m, families, arena) {}
    };

    static constexpr double kBelow = 1.0 - 1e-9;   // of a proven radius: what bisection and rounding leave open
    static constexpr double kLargest = 3.141592653589793;  // no larger ball is asked for
    static constexpr double kAlong = 1e-9;  // a share of motion that rounding makes [1]

    std::size_t size() const { return static_cast<std::size_t>(chain_.variables); }

    // Rank, families, distances: everything that no velocity is needed for.
    void see(const double* q, rankdrop_step& out) noexcept {
        const int n = chain_.variables, m = view_.m, s = m < n ? m : n;
        RANKDROP_ISA::Workspace& ws = work_->ws;
        for (int j = 0; j < n; ++j) work_->x[j] = RANKDROP_ISA::fill(q[j]);
        RANKDROP_ISA::decompose(chain_, view_, work_->x, s, ws, RANKDROP_ISA::svd_of_equal);
        for (int i = 0; i < s; ++i) sigma_[i] = RANKDROP_ISA::get(ws.sigma[i], 0);
        for (int a = 0; a < m; ++a)
            for (int i = 0; i < m; ++i) u_[a * m + i] = RANKDROP_ISA::get(ws.u[i * m + a], 0);
        out.rank = 0;
        for (int i = 0; i < settings_.generic; ++i) out.rank += sigma_[i] > settings_.singular;
        out.corank = settings_.generic - out.rank;
        RANKDROP_ISA::waves_of_one(families_, out.corank > 0, q, phase_.data(), sine_.data(), cosine_.data());
        const RANKDROP_ISA::Waves<double> waves{sine_.data(), cosine_.data()};
        for (int f = 0; f < watched(); ++f)
            if (families_.lengthy[f] && out.corank == 0)
                each_[f] = RANKDROP_ISA::apart_by_set(chain_, view_, families_, settings_, f, work_->x, ws, 0, work_->far,
                                                      away_.data() + f * n);
            else
                each_[f] = RANKDROP_ISA::apart<double>(families_, f, q, waves, gradient_.data(), away_.data() + f * n);
        RANKDROP_ISA::walk_all<double>(families_, settings_.start, q, work_->walks, each_.data(), away_.data());
        const auto met = RANKDROP_ISA::attribute<double>(families_, settings_, out.corank, each_.data());
        out.family = listed(static_cast<int>(met.family)), out.nearest = listed(static_cast<int>(met.nearest));
        out.residual = met.residual;
        out.distance = met.distance;
        beyond(out);
        for (int f = 0; f < count(); ++f)
            for (int j = 0; j < n; ++j) slope_[f * n + j] = away_[f * n + j] / families_.scale[j];
    }

    // Where families are not all there is, sigma's slope is one more: its distance, and where it leads.
    void beyond(rankdrop_step& out) noexcept {
        if (!settings_.beyond) return;
        const double slope = RANKDROP_ISA::get(
            RANKDROP_ISA::first_order_distance(chain_, view_, families_, settings_, work_->ws, work_->scratch, work_->gradient), 0);
        const int n = chain_.variables, f = watched();
        double square = 0.0;
        for (int j = 0; j < n; ++j) {
            gradient_[j] = RANKDROP_ISA::get(work_->gradient[j], 0);
            square += gradient_[j] * gradient_[j];
        }
        each_[f].distance = each_[f].residual = square > 0.0 ? slope : out.corank > 0 ? 0.0 : HUGE_VAL;
        out.distance = std::min(out.distance, slope);
        for (int j = 0; j < n; ++j) away_[f * n + j] = square > 0.0 ? gradient_[j] / std::sqrt(square) : 0.0;
    }

    // Families whose distances count: all, and sigma's slope.
    int count() const { return watched() + settings_.beyond; }

    // Families that the kernels know, preferred ones first; what is told of one has its number in Python's order.
    int watched() const { return static_cast<int>(families_.corank.size()); }
    int listed(int place) const { return place < 0 ? -1 : numbers_[static_cast<std::size_t>(place)]; }

    // The nearest of them, -1 for none.
    int first() const {
        int best = -1;
        for (int f = 0; f < count(); ++f)
            if (std::isfinite(each_[f].distance) && (best < 0 || each_[f].distance < each_[best].distance)) best = f;
        return best;
    }

    void slow(const double* velocity, rankdrop_step& out) noexcept {
        const int n = chain_.variables, nearest = first();
        double length = 0.0;
        for (int j = 0; j < n; ++j) {
            const double x = velocity[j] / families_.scale[j];
            length += x * x;
            if (settings_.rates.empty() || !(std::fabs(velocity[j]) > settings_.rates[j])) continue;
            out.rate_scaling = std::min(out.rate_scaling, settings_.rates[j] / std::fabs(velocity[j]));
        }
        length = std::sqrt(length);
        if (!(length > 0.0)) return;
        for (int f = 0; f < count(); ++f) {
            double share = 0.0;
            for (int j = 0; j < n; ++j) share -= slope_[f * n + j] * velocity[j];
            share /= length;
            if (f == nearest) out.approach = share;
            if (each_[f].distance <= settings_.on || share <= kAlong || !(each_[f].distance < settings_.start)) continue;
            const double c = std::min(share, 1.0);
            const double k = std::max(0.0, (each_[f].distance - settings_.stop) / (settings_.start - settings_.stop));
            out.scaling = std::min(out.scaling, k / (k * (1.0 - c) + c));
        }
    }

    // Internal motion: the null space in scaled variables, the gradients in it, and the projection on their cone. None at
    // singular configurations, whose null space is not all motion.
    void step_inside(rankdrop_step& out) noexcept {
        const int n = chain_.variables, rank = settings_.generic, nearest = first();
        for (int j = 0; j < n; ++j) null_[j] = 0.0;
        if (rank >= n || out.corank > 0 || nearest < 0) return;
        int columns = 0;
        for (int i = rank; i < n; ++i) columns += null_column(i, columns);
        for (int f = 0; f < count(); ++f) {
            active_[f] = f == nearest || (each_[f].distance < settings_.start && each_[f].distance > settings_.on);
            if (active_[f]) project(f, columns);
        }
        if (!(square_[nearest] > 1e-18)) return;
        double* h = null_.data();
        const double *goal = inner_.data() + nearest * n, size_goal = square_[nearest];
        for (int j = 0; j < n; ++j) h[j] = goal[j];
        project_on_cone(goal, h, size_goal);
        double square = 0.0, along = 0.0;
        for (int j = 0; j < n; ++j) square += h[j] * h[j], along += h[j] * goal[j];
        const bool leads = square > 1e-12 * size_goal && along > 0.0 && harmless(h, std::sqrt(square));
        out.null_rate = leads ? along / std::sqrt(square) : 0.0;
        for (int j = 0; j < n; ++j) h[j] = leads ? h[j] / std::sqrt(square) * families_.scale[j] : 0.0;
    }

    // h: `goal` projected on {h: g_f . h >= 0 for all active f}, by nonnegative least squares of its dual (Lawson and Hanson):
    // h = goal + sum pull_f g_f over a set of gradients that bind, at most as many as there are internal freedoms.
    void project_on_cone(const double* goal, double* h, double size_goal) noexcept {
        const int n = chain_.variables, rounds = 3 * count() + 3;
        int binding = 0;
        for (int round = 0; round < rounds; ++round) {
            int worst = -1;
            double most = 1e-9 * std::sqrt(size_goal);
            for (int f = 0; f < count(); ++f) {
                if (!active_[f] || !(square_[f] > 1e-18)) continue;
                double along = 0.0;
                for (int j = 0; j < n; ++j) along -= inner_[f * n + j] * h[j];
                along /= std::sqrt(square_[f]);
                if (along > most) most = along, worst = f;
            }
            if (worst < 0 || binding == n) return;
            bound_[binding] = worst, pull_[binding++] = 0.0;
            for (;;) {
                if (!solve(goal, binding)) {  // as good as parallel to those that bind
                    active_[worst] = 0;
                    --binding;
                    solve(goal, binding);
                }
                double part = 1.0;
                int least = -1;
                for (int b = 0; b < binding; ++b)
                    if (wish_[b] <= 0.0 && pull_[b] < part * (pull_[b] - wish_[b]))
                        part = pull_[b] / (pull_[b] - wish_[b]), least = b;
                    else if (wish_[b] <= 0.0 && pull_[b] == 0.0)
                        part = 0.0, least = b;
                for (int b = 0; b < binding; ++b) pull_[b] += part * (wish_[b] - pull_[b]);
                if (least < 0) break;
                for (int b = least + 1; b < binding; ++b) bound_[b - 1] = bound_[b], pull_[b - 1] = pull_[b];
                --binding;
                if (binding == 0) break;
            }
            for (int j = 0; j < n; ++j) h[j] = goal[j];
            for (int b = 0; b < binding; ++b)
                for (int j = 0; j < n; ++j) h[j] += pull_[b] * inner_[bound_[b] * n + j];
        }
    }

    // wish: least squares of goal + sum wish_b g_b over those that bind, by Gram-Schmidt. False where they are dependent.
    bool solve(const double* goal, int binding) noexcept {
        const int n = chain_.variables;
        for (int b = 0; b < binding; ++b) {
            double* x = held_.data() + b * n;
            const double* g = inner_.data() + bound_[b] * n;
            for (int j = 0; j < n; ++j) x[j] = g[j];
            for (int c = 0; c < b; ++c) {
                const double* y = held_.data() + c * n;
                double overlap = 0.0;
                for (int j = 0; j < n; ++j) overlap += x[j] * y[j];
                for (int j = 0; j < n; ++j) x[j] -= overlap * y[j];
                upper_[c * n + b] = overlap;
            }
            double square = 0.0;
            for (int j = 0; j < n; ++j) square += x[j] * x[j];
            if (!(square > 1e-20 * square_[bound_[b]])) return false;
            upper_[b * n + b] = std::sqrt(square);
            for (int j = 0; j < n; ++j) x[j] /= upper_[b * n + b];
        }
        for (int b = binding - 1; b >= 0; --b) {
            double sum = 0.0;
            for (int j = 0; j < n; ++j) sum -= held_[b * n + j] * goal[j];
            for (int c = b + 1; c < binding; ++c) sum -= upper_[b * n + c] * wish_[c];
            wish_[b] = sum / upper_[b * n + b];
        }
        return true;
    }

    // Column i of V in scaled variables, made orthogonal to the columns before: 1 where something is left.
    int null_column(int i, int columns) noexcept {
        const int n = chain_.variables;
        double* x = basis_.data() + columns * n;
        for (int j = 0; j < n; ++j) x[j] = RANKDROP_ISA::get(work_->ws.v[i * n + j], 0) / families_.scale[j];
        for (int pass = 0; pass < 2; ++pass)
            for (int c = 0; c < columns; ++c) {
                const double* y = basis_.data() + c * n;
                double overlap = 0.0;
                for (int j = 0; j < n; ++j) overlap += x[j] * y[j];
                for (int j = 0; j < n; ++j) x[j] -= overlap * y[j];
            }
        double square = 0.0;
        for (int j = 0; j < n; ++j) square += x[j] * x[j];
        if (!(square > 1e-24)) return 0;
        for (int j = 0; j < n; ++j) x[j] /= std::sqrt(square);
        return 1;
    }

    // The part of a family's gradient that internal motion reaches.
    void project(int f, int columns) noexcept {
        const int n = chain_.variables;
        double* out = inner_.data() + f * n;
        for (int j = 0; j < n; ++j) out[j] = 0.0;
        for (int c = 0; c < columns; ++c) {
            const double* y = basis_.data() + c * n;
            double along = 0.0;
            for (int j = 0; j < n; ++j) along += away_[f * n + j] * y[j];
            for (int j = 0; j < n; ++j) out[j] += along * y[j];
        }
        square_[f] = 0.0;
        for (int j = 0; j < n; ++j) square_[f] += out[j] * out[j];
    }

    bool harmless(const double* h, double length) const noexcept {
        const int n = chain_.variables;
        for (int f = 0; f < count(); ++f) {
            if (!active_[f]) continue;
            double along = 0.0;
            for (int j = 0; j < n; ++j) along += inner_[f * n + j] * h[j];
            if (along < -1e-6 * length) return false;
        }
        return true;
    }

    static void check(bool sound, const char* what) {
        if (!sound) throw std::invalid_argument(std::string("rankdrop: not a sound arm: ") + what);
    }

    template <class T>
    static std::vector<T> taken(const T* from, int count) {
        check(count >= 0 && (from || count == 0), "an array is missing");
        return count == 0 ? std::vector<T>() : std::vector<T>(from, from + count);
    }

    // As many as the last of the starts says.
    static int end_of(const int* starts, int count) {
        check(starts && count >= 0 && starts[0] == 0 && starts[count] >= 0, "starts do not rise from 0");
        return starts[count];
    }

    static Chain chain_of(const rankdrop_arm& arm) {
        check(arm.format == RANKDROP_ARM_FORMAT, "written for another version of this header");
        check(arm.joints > 0 && arm.variables > 0, "it has no joints");
        Chain chain;
        chain.variables = arm.variables;
        chain.frames = taken(arm.frames, 12 * (arm.joints + 2));
        for (int i = 0; i < arm.joints; ++i) {
            check(arm.variable[i] >= 0 && arm.variable[i] < arm.variables, "a joint is driven by no variable");
            chain.joints.push_back(joint_constants(arm.screws + 6 * i, arm.turns[i] != 0, arm.variable[i], arm.multiplier[i],
                                                   arm.offset[i]));
        }
        return chain;
    }

    static View view_of(const rankdrop_arm& arm) {
        View view;
        view.links = arm.joints + 2, view.axes = arm.axes, view.origin = arm.origin, view.m = arm.rows;
        check(arm.rows >= 1 && arm.rows <= 6, "a task has one to six rows");
        check(arm.axes >= 0 && arm.axes < view.links && arm.origin >= 0 && arm.origin < view.links, "no such link");
        for (int i = 0; i < 3; ++i) view.point[i] = arm.point[i];
        for (int a = 0; a < arm.rows; ++a) {
            check(arm.row[a] >= 0 && arm.row[a] < 6, "a row is out of range");
            view.row[a] = arm.row[a], view.factor[a] = arm.factor[a];
        }
        return view;
    }

    static Families families_of(const rankdrop_arm& arm) {
        const int pins = end_of(arm.first_pin, arm.families), turns = end_of(arm.first_turn, arm.angles);
        Families out;
        out.variables = arm.variables;
        out.shift = taken(arm.shift, arm.angles), out.turns = taken(arm.first_turn, arm.angles + 1);
        out.turning = taken(arm.turning, turns), out.m = taken(arm.m, turns);
        out.angle = taken(arm.angle, arm.terms), out.a = taken(arm.cosine, arm.terms), out.b = taken(arm.sine, arm.terms);
        out.powers = taken(arm.powers, arm.terms * arm.variables);
        out.terms = taken(arm.first_term, arm.equations + 1), out.coupled = taken(arm.coupled, arm.equations);
        out.equations = taken(arm.first_equation, arm.families + 1), out.corank = taken(arm.corank, arm.families);
        out.scale = taken(arm.scale, arm.variables), out.periodic = taken(arm.periodic, arm.variables);
        out.pins = taken(arm.first_pin, arm.families + 1), out.pinned = taken(arm.pinned, pins);
        out.at = taken(arm.first_value, pins + 1), out.values = taken(arm.values, end_of(arm.first_value, pins));
        return out;
    }

    static Bound bound_of(const rankdrop_arm& arm, int number) {
        check(arm.joints <= kMostJoints && arm.bound_rows >= 1 && arm.bound_rows <= 6, "it has too many joints or rows for a proof");
        check(arm.bound_link[number] >= 0 && arm.bound_link[number] <= arm.joints, "no such link");
        check(arm.generic_rank <= std::min(arm.bound_rows, arm.variables), "a proof keeps the generic rank");
        Bound out;
        View& view = out.view;
        view.links = arm.joints + 2, view.axes = view.origin = arm.bound_link[number], view.m = arm.bound_rows;
        for (int i = 0; i < 3; ++i) view.point[i] = arm.bound_point[3 * number + i];
        for (int a = 0; a < view.m; ++a) {
            check(arm.bound_row[a] >= 0 && arm.bound_row[a] < 6, "a row is out of range");
            view.row[a] = arm.bound_row[a];
            view.factor[a] = view.row[a] < 3 ? 1.0 / arm.bound_length[number] : 1.0;
        }
        out.settings.rank = arm.generic_rank, out.settings.length = arm.bound_length[number];
        out.settings.radius = kLargest, out.settings.repeats = arm.bound_repeats;
        out.settings.scale = taken(arm.scale, arm.variables);
        out.settings.arm = taken(arm.bound_reach + number * arm.joints, arm.joints);
        return out;
    }

    static MonitorSettings settings_of(const rankdrop_arm& arm) {
        MonitorSettings out;
        out.generic = arm.generic_rank, out.singular = arm.singular, out.on = arm.on, out.loose = arm.loose;
        out.start = arm.start, out.stop = arm.stop, out.beyond = arm.beyond != 0;
        out.rates = taken(arm.rates, arm.variables);
        return out;
    }

    Chain chain_;
    View view_;
    Families families_;
    MonitorSettings settings_;
    std::string name_;
    std::vector<std::string> ids_, names_;
    std::vector<int> numbers_, places_;  // place in the kernels' order -> number, and back; -1: without conditions
    std::vector<double> unknown_;  // (variables) NaN
    std::vector<Bound> bounds_;
    std::unique_ptr<Work> work_;
    std::vector<double> sigma_, u_, phase_, sine_, cosine_;
    std::vector<RANKDROP_ISA::Apart<double>> each_;  // of families, and sigma over its slope
    std::vector<double> away_, slope_, inner_;  // (families + 1, n) gradients of distances: by scaled variables, by q, internal
    std::vector<double> square_, basis_, gradient_, null_, held_, upper_, pull_, wish_;
    std::vector<int> bound_;
    std::vector<char> active_;
};

}  // namespace RANKDROP_ISA

using RANKDROP_ISA::Monitor;

}  // namespace rankdrop
