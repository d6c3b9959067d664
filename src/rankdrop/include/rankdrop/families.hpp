// Families of singular configurations as flat tables of numbers, and what a monitor says of each configuration.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

namespace rankdrop {

inline constexpr int kMostOfGroup = 1024;  // points
inline constexpr int kMostMoving = 16;     // joints that matter to them
inline constexpr int kBlock = 32;          // of them that are compared at once

// Points of the set where a family's rank drops, in groups that lie together: what walks begin at.
struct SetPoints {
    std::vector<int> moving;           // joints that matter to them, all of them turn
    int width = 0;                     // of a point's record: q (n) [rad], the direction lost (m), the null space (n - rank, n)
    std::vector<float> records;
    std::vector<std::int16_t> place;   // group after group in blocks (pairs of moving, kBlock, 2) [parts of a turn, 2^16 of them]
    std::vector<std::int16_t> centre;  // of all groups, in blocks
    std::vector<int> first;            // first point of every group, and the end
    std::vector<int> first_place;      // where the first block of every group begins in `place`

    const float* point(int number) const { return records.data() + static_cast<std::size_t>(number) * static_cast<std::size_t>(width); }
};

// Equations f = sum_t (a_t cos(m_k . q - shift_k) + b_t sin(m_k . q - shift_k)) prod_j q_j^p_tj with k = angle_t. Families
// stand in the order in which they are preferred.
struct Families {
    int variables = 0;
    std::vector<double> shift;        // of every angle
    std::vector<int> turns;           // first joint that turns every angle, and the end
    std::vector<int> turning;         // these joints
    std::vector<double> m;            // and by how much
    std::vector<int> angle;           // of every term
    std::vector<double> a, b;         // (terms)
    std::vector<int> powers;          // (terms, n)
    std::vector<int> terms;           // first term of every equation, and the end
    std::vector<int> equations;       // first equation of every family, and the end
    std::vector<int> corank;          // of every family
    std::vector<double> scale;        // (n) what a joint motion is measured by: 1, or the length scale
    std::vector<int> periodic;        // (n) 1: a turn of 2 pi is no motion
    std::vector<int> coupled;         // of every equation: 0 where pinned joints alone say it
    std::vector<int> pins;            // first pinned joint of every family, and the end
    std::vector<int> pinned;          // the pinned joints
    std::vector<int> at;              // first value of every pinned joint, and the end
    std::vector<double> values;       // [rad, or the unit of the arm's lengths]
    // `finish` fills in the rest: e^(i angle) as products of phases e^(i m_j q_j) and e^(-i shift), shared as they begin alike
    std::vector<char> powered{};                    // of every term: has it any power
    std::vector<int> phase_joint{};                 // -1: a constant
    std::vector<double> phase_m{};                  // multiple of the joint, or the constant
    std::vector<int> node_before{}, node_phase{};   // a product: another one, or -1, times a phase
    std::vector<int> node_joint{};                  // of the last phase of every product: its joint, or -1,
    std::vector<double> node_m{};                   // and its multiple
    std::vector<int> node{};                        // of every term: e^(i angle)
    // products are numbered as terms meet them: so many of the first, and of the phases, are in the first e equations
    std::vector<int> nodes_of_first{}, phases_of_first{};
    // of every family: may Newton walk to it by its coupled equations, or are they so long that kinematics are quicker
    std::vector<char> walked{}, lengthy{};
    // what is walked by: these equations' phases and products; of a lengthy family those of `witness`, its shortest one
    std::vector<int> first_phase{}, own_phase{}, first_node{}, own_node{}, witness{};
    std::vector<int> plain_phase{}, plain_node{};   // of all families that are not lengthy
    int widest = 0;                                 // coupled equations of a family that is walked to, at most
    std::shared_ptr<const std::vector<SetPoints>> points{};  // of every family, by `spread`; empty where they are of no use

    int angles() const { return static_cast<int>(shift.size()); }
    int phases() const { return static_cast<int>(phase_m.size()); }
    int nodes() const { return static_cast<int>(node_phase.size()); }

    // Whether the sizes agree and every index is one; then the rest is filled in.
    bool finish() {
        const std::size_t n = static_cast<std::size_t>(variables), count = a.size();
        const auto rising = [](const std::vector<int>& starts, std::size_t end) {
            return !starts.empty() && starts.front() == 0 && starts.back() == static_cast<int>(end) &&
                   std::is_sorted(starts.begin(), starts.end());
        };
        const auto within = [](const std::vector<int>& numbers, int end) {
            return std::all_of(numbers.begin(), numbers.end(), [&](int one) { return one >= 0 && one < end; });
        };
        if (variables < 1 || b.size() != count || angle.size() != count || powers.size() != count * n || scale.size() != n ||
            periodic.size() != n || turns.size() != shift.size() + 1 || !rising(turns, turning.size()) ||
            m.size() != turning.size() || !within(turning, variables) || !within(angle, angles()) || !rising(terms, count) ||
            !rising(equations, terms.size() - 1) || equations.size() != corank.size() + 1 ||
            coupled.size() + 1 != terms.size() || pins.size() != equations.size() || !rising(pins, pinned.size()) ||
            at.size() != pinned.size() + 1 || !rising(at, values.size()) || !within(pinned, variables))
            return false;
        powered.assign(count, 0);
        for (std::size_t i = 0; i < powers.size(); ++i)
            if (powers[i] != 0) powered[i / n] = 1;
        multiply_out();
        prepare_walks();
        return true;
    }

    void prepare_walks() {
        // terms: eight steps of a walk take some microseconds; with six joints the kinematics are quicker, and find more
        const int too_long = variables > 6 ? 100 : 15;
        walked.clear(), lengthy.clear(), witness.clear(), first_phase.assign(1, 0), first_node.assign(1, 0);
        own_phase.clear(), own_node.clear(), plain_phase.clear(), plain_node.clear();
        Met plain(*this);
        for (std::size_t family = 0; family < corank.size(); ++family) {
            Met own(*this);
            int rows = 0, count = 0, shortest = -1;
            const auto length = [this](int e) { return terms[(std::size_t)e + 1] - terms[(std::size_t)e]; };
            for (int e = equations[family]; e < equations[family + 1]; ++e) {
                if (!coupled[(std::size_t)e]) continue;
                ++rows, count += length(e);
                if (shortest < 0 || length(e) < length(shortest)) shortest = e;
            }
            walked.push_back(rows > 0 && count <= too_long), lengthy.push_back(rows > 0 && count > too_long);
            witness.push_back(shortest);
            if (walked.back()) widest = std::max(widest, rows);
            for (int e = equations[family]; e < equations[family + 1]; ++e) {
                if (!lengthy.back()) plain.add(e);
                if (walked.back() ? coupled[(std::size_t)e] : lengthy.back() && e == shortest) own.add(e);
            }
            own.append_to(own_phase, own_node);
            first_node.push_back((int)own_node.size()), first_phase.push_back((int)own_phase.size());
        }
        plain.append_to(plain_phase, plain_node);
    }

    // Phases and products that some equations are made of.
    struct Met {
        const Families& table;
        std::vector<char> nodes, phases;

        explicit Met(const Families& families)
            : table(families), nodes(families.node_phase.size(), 0), phases(families.phase_m.size(), 0) {}

        void add(int equation) {
            for (int t = table.terms[(std::size_t)equation]; t < table.terms[(std::size_t)equation + 1]; ++t)
                for (int k = table.node[(std::size_t)t]; k >= 0 && !nodes[(std::size_t)k]; k = table.node_before[(std::size_t)k])
                    nodes[(std::size_t)k] = 1, phases[(std::size_t)table.node_phase[(std::size_t)k]] = 1;
        }

        void append_to(std::vector<int>& own_phase, std::vector<int>& own_node) const {
            for (std::size_t k = 0; k < nodes.size(); ++k)
                if (nodes[k]) own_node.push_back((int)k);
            for (std::size_t k = 0; k < phases.size(); ++k)
                if (phases[k]) own_phase.push_back((int)k);
        }
    };

    void multiply_out() {
        std::map<std::pair<int, double>, int> phases_met;
        std::map<std::pair<int, int>, int> nodes_met;
        std::vector<int> leaf;
        phase_joint.clear(), phase_m.clear(), node_before.clear(), node_phase.clear(), node.clear();
        const auto times = [&](int before, int joint, double by) {
            const auto [phase, fresh] = phases_met.insert({{joint, by}, phases()});
            if (fresh) phase_joint.push_back(joint), phase_m.push_back(by);
            const auto [product, made] = nodes_met.insert({{before, phase->second}, nodes()});
            if (made) node_before.push_back(before), node_phase.push_back(phase->second);
            return product->second;
        };
        for (std::size_t k = 0; k < shift.size(); ++k) {
            int product = -1;
            for (int i = turns[k]; i < turns[k + 1]; ++i)
                product = times(product, turning[static_cast<std::size_t>(i)], m[static_cast<std::size_t>(i)]);
            if (product < 0 || shift[k] != 0.0) product = times(product, -1, -shift[k]);
            leaf.push_back(product);
        }
        for (const int k : angle) node.push_back(leaf[static_cast<std::size_t>(k)]);
        count_products();
    }

    void count_products() {
        node_joint.clear(), node_m.clear();
        for (const int phase : node_phase) {
            node_joint.push_back(phase_joint[(std::size_t)phase]);
            node_m.push_back(phase_m[(std::size_t)phase]);
        }
        nodes_of_first.assign(1, 0), phases_of_first.assign(1, 0);
        for (std::size_t e = 0; e + 1 < terms.size(); ++e) {
            int last_node = nodes_of_first.back() - 1, last_phase = phases_of_first.back() - 1;
            for (int t = terms[e]; t < terms[e + 1]; ++t)
                for (int k = node[(std::size_t)t]; k >= 0; k = node_before[(std::size_t)k]) {
                    last_node = std::max(last_node, k);
                    last_phase = std::max(last_phase, node_phase[(std::size_t)k]);
                }
            nodes_of_first.push_back(last_node + 1), phases_of_first.push_back(last_phase + 1);
        }
    }
};

struct MonitorSettings {
    int generic = 0;            // generic rank
    double singular = 1e-9;     // sigma at or below: zero
    double on = 1e-5;           // a singular configuration with a smaller residual lies on the family [rad]
    double loose = 1e-3;        // where none of its corank does: the nearest one of its corank, up to here [rad]
    double start = 0.2;         // motion towards a family is slowed nearer than this [rad]
    double stop = 0.02;         // and stopped nearer than this [rad]
    bool beyond = false;        // there may be singularities beyond the families: sigma over its slope counts as a distance
    std::vector<double> rates{};  // (n) largest joint rates, infinite for none; or empty
};

// Rows are configurations; `v` may be null.
struct SightingsOutput {
    double *sigma, *u, *v, *residual, *distance;
    std::int32_t *rank, *family, *nearest;
};

}  // namespace rankdrop
