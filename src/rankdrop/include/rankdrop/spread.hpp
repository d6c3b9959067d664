// Points spread over the singular set, which walks of lengthy families begin at.
#pragma once

#include <cstdint>
#include <vector>

#include "sightings.hpp"

namespace rankdrop::RANKDROP_ISA {

inline constexpr int kSpread = 60000;     // starts: points lie about 0.2 rad apart where three joints are free
inline constexpr int kGroups = 512;       // whole blocks
inline constexpr int kSettling = 24;      // steps of a start at most
inline constexpr double kSettled = 1e-7;  // sigma at a point, whose joints are kept in single precision
inline constexpr double kIdle = 1e-4;     // of the rows of D: joints that change nothing on the set

// A number in 0 ... 1 for every index, evenly (the finaliser of SplitMix64).
inline double even(std::uint64_t index) {
    std::uint64_t z = (index + 1) * 0x9E3779B97F4A7C15ULL;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return (double)((z ^ (z >> 31)) >> 11) * 0x1.0p-53;
}

// Points that starts drawn over the joint space come to by Newton's steps of least length.
struct Settled {
    std::vector<double> q, u, v, most;  // (points, n), (points, m), (points, n - r, n), (n) the largest entry of D's rows
};

template <class Beside>
inline Settled settle(const Chain& chain, const View& view, const Families& table, int rank, Beside beside) {
    const int n = chain.variables, m = view.m, free = n - rank;
    Arena arena;
    SetRoom room(chain, m, arena);
    Workspace ws(chain, m, arena);
    Pack* x = arena.take<Pack>((std::size_t)n);
    WalkOntoSet<0, 0, 0> walk(chain, view, table.scale.data(), rank, room);
    Settled out;
    out.most.assign((std::size_t)n, 0.0);
    for (int first = 0; first < kSpread; first += W) {
        for (int lane = 0; lane < W; ++lane)
            for (int j = 0; j < n; ++j)
                set(x[j], lane, kTurn * (even((std::uint64_t)(first + lane) * (std::uint64_t)n + (std::uint64_t)j) - 0.5));
        Mask going = fill(0.0) < fill(1.0);
        for (int count = 0; count < kSettling; ++count) {
            decompose_fast(chain, walk.view(), x, rank, ws);
            walk.back_onto_set(ws);
            going = going & (ws.sigma[rank] > fill(kSettled));
            if (!any(going)) break;
            Pack square = fill(0.0);
            for (int j = 0; j < n; ++j) square = square + room.step[j] * room.step[j];
            const Pack part = min(fill(1.0), fill(kStride) / max(sqrt(square), fill(1e-300)));
            for (int j = 0; j < n; ++j) x[j] = select(going, x[j] + room.step[j] * part * table.scale[j], x[j]);
        }
        const Pack off = beside(x);
        for (int lane = 0; lane < W && first + lane < kSpread; ++lane) {
            if (!(get(ws.sigma[rank], lane) <= kSettled) || !(get(off, lane) <= kBeside)) continue;
            for (int j = 0; j < n; ++j) out.q.push_back(get(x[j], lane));
            for (int a = 0; a < m; ++a) out.u.push_back(get(ws.u[rank * m + a], lane));
            for (int i = 0; i < free * n; ++i) out.v.push_back(get(ws.v[rank * n + i], lane));
            for (int b = 0; b < free; ++b)
                for (int j = 0; j < n; ++j)
                    out.most[(std::size_t)j] = std::max(out.most[(std::size_t)j], std::fabs(get(walk.row(b)[j], lane)));
        }
    }
    return out;
}

// Some of the places (points, paired joints), block after block as `squares_to` reads them; the last block is filled up with
// zeros.
inline void append_blocks(const std::vector<std::int16_t>& place, const std::vector<int>& some, int joints,
                          std::vector<std::int16_t>& out) {
    for (std::size_t first = 0; first < some.size(); first += kBlock)
        for (int j = 0; j < joints; j += 2)
            for (std::size_t i = first; i < first + kBlock; ++i)
                for (int own = 0; own < 2; ++own)
                    out.push_back(i < some.size() ? place[(std::size_t)(some[i] * paired(joints) + j + own)] : std::int16_t{0});
}

// Groups of points by the nearest of their centres, the first of the points themselves.
inline SetPoints grouped(const Settled& from, int n, int m, int free) {
    SetPoints out;
    for (int j = 0; j < n; ++j)
        if (from.most[(std::size_t)j] > kIdle) out.moving.push_back(j);
    const int joints = (int)out.moving.size(), count = (int)from.q.size() / n;
    const int stride = paired(joints);
    std::vector<std::int16_t> place((std::size_t)(count * stride));
    for (int i = 0; i < count; ++i)
        for (int j = 0; j < joints; ++j)
            place[(std::size_t)(i * stride + j)] = parts_of_turn(from.q[(std::size_t)(i * n + out.moving[(std::size_t)j])]);
    std::vector<int> some(kGroups);
    for (int i = 0; i < kGroups; ++i) some[(std::size_t)i] = i;
    append_blocks(place, some, joints, out.centre);
    std::vector<std::int32_t> squares(kGroups);
    std::vector<std::vector<int>> members(kGroups);
    for (int i = 0; i < count; ++i) {
        for (int block = 0; block < kGroups; block += kBlock)
            squares_to(out.centre.data() + block * stride, place.data() + (std::ptrdiff_t)i * stride, joints, squares.data() + block);
        auto& group = members[(std::size_t)(std::min_element(squares.begin(), squares.end()) - squares.begin())];
        if ((int)group.size() < kMostOfGroup) group.push_back(i);
    }
    out.first.assign(1, 0);
    out.width = n + m + free * n;
    const auto append = [&out](const std::vector<double>& all, int i, int width) {
        for (int k = 0; k < width; ++k) out.records.push_back((float)all[(std::size_t)(i * width + k)]);
    };
    for (const std::vector<int>& group : members) {
        out.first_place.push_back((int)out.place.size());
        append_blocks(place, group, joints, out.place);
        for (const int i : group) append(from.q, i, n), append(from.u, i, m), append(from.v, i, free * n);
        out.first.push_back(out.first.back() + (int)group.size());
    }
    return out;
}

// Fills in `points` of every lengthy family, about half a second: where one direction is lost and only turning joints
// matter. Empty where too few starts settle.
inline void spread(const Chain& chain, const View& view, Families& table, const MonitorSettings& settings) {
    const int n = chain.variables, m = view.m;
    std::vector<SetPoints> all_points(table.corank.size());
    for (int family = 0; family < (int)table.corank.size(); ++family) {
        const int rank = settings.generic - table.corank[(std::size_t)family];
        if (!table.lengthy[(std::size_t)family] || m - rank != 1) continue;
        Arena arena;
        FarRoom room(chain, m, table, arena);
        const bool all = !shared(table, settings, family);
        const Settled found = settle(chain, view, table, rank,
                                     [&](const Pack* x) { return all ? fill(0.0) : beside(table, family, x, room); });
        if ((int)found.q.size() < 4 * kGroups * n) continue;
        SetPoints points = grouped(found, n, m, n - rank);
        const bool turns = std::all_of(points.moving.begin(), points.moving.end(), [&](int j) { return table.periodic[(std::size_t)j]; });
        if (turns && (int)points.moving.size() <= kMostMoving) all_points[(std::size_t)family] = std::move(points);
    }
    table.points = std::make_shared<const std::vector<SetPoints>>(std::move(all_points));
}

}  // namespace rankdrop::RANKDROP_ISA
