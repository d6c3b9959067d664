// Coverings of 6R arms: the split determinant in tables, and the boxes that are left of it.
#include "bindings.hpp"

#include "split.hpp"

namespace rankdrop {
namespace {

using Places = nb::ndarray<const std::int32_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Whole = nb::ndarray<const std::int32_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

std::unique_ptr<Split> new_split(const In2& a, const In2& b, const In1& lower, const In1& upper, const Whole& depth,
                                 const In2& curvature, double rounding, double slope, int further, int top) {
    const auto is = [](const In2& x, std::size_t rows, std::size_t columns) { return x.shape(0) == rows && x.shape(1) == columns; };
    if (!is(a, kMinors, kWaves) || !is(b, kMinors, kWaves) || !is(curvature, kSplitVariables, kSplitVariables) ||
        lower.shape(0) != kSplitVariables || upper.shape(0) != kSplitVariables || depth.shape(0) != kSplitVariables)
        throw nb::value_error("six minors of fifteen waves, four variables");
    int depths = 1;
    for (int j = 0; j < kSplitVariables; ++j) {
        if (depth.data()[j] < 0) throw nb::value_error("a negative number of halvings");
        if (!(lower.data()[j] <= upper.data()[j])) throw nb::value_error("lower limits above upper ones");
        depths = std::max(depths, depth.data()[j]);
    }
    if (further < 0 || further > kMostHalvings || depths > kDeepest) throw nb::value_error("too many halvings");
    if (top < 0 || top >= depths) throw nb::value_error("no such level");
    return std::make_unique<Split>(make_split({a.data(), b.data(), lower.data(), upper.data(), depth.data(), curvature.data(),
                                               rounding, slope, further, top}));
}

// Boxes begin … end - 1 of the level `top`: all masks one box after the other, level by level; how many of each; counts.
nb::object cover(const Split& split, std::int64_t begin, std::int64_t end, int threads) {
    if (begin < 0 || begin > end || end > split.trees()) throw nb::value_error("no such boxes");
    const std::size_t rows = static_cast<std::size_t>(end - begin), parts = static_cast<std::size_t>(split.depths - split.top + 1);
    std::vector<CoverTree> trees(rows);
    std::atomic<bool> stop{false};
    bool raised = false;
    {
        nb::gil_scoped_release release;
        share({end - begin, 1, threads}, stop,
              [&](std::int64_t from, std::int64_t to) { kernels().cover(split, begin + from, begin + to, trees.data() + from); },
              [&] {
                  nb::gil_scoped_acquire acquire;
                  raised = PyErr_CheckSignals() != 0;
                  return raised;
              });
    }
    if (raised) throw nb::python_error();
    std::size_t words = 0;
    std::int64_t tested = 0, freed = 0;
    for (const CoverTree& tree : trees) {
        tested += tree.tested, freed += tree.freed;
        for (const auto& part : tree.masks) words += part.size();
    }
    Result<std::uint16_t> masks({words});
    Result<std::int32_t> sizes({rows, parts});
    std::size_t at = 0;
    for (std::size_t row = 0; row < rows; ++row)
        for (std::size_t part = 0; part < parts; ++part) {
            const auto& one = trees[row].masks[part];
            std::copy(one.begin(), one.end(), masks.data() + at);
            at += one.size();
            sizes.data()[row * parts + part] = static_cast<std::int32_t>(one.size());
        }
    return nb::make_tuple(masks.give(), sizes.give(), tested, freed);
}

// Leaves (B, 4), halved so many times in so many parts: free (0), proven to hold a singularity (1), or neither (2).
nb::object judge_leaves(const Split& split, const Places& leaves, int halvings, std::int64_t parts, int threads) {
    if (halvings < 0 || halvings > kMostHalvings) throw nb::value_error("too many halvings");
    if (leaves.shape(1) != kSplitVariables) throw nb::value_error("leaves have four places");
    const auto& cells = split.levels[static_cast<std::size_t>(split.depths)].cells;
    for (std::size_t i = 0; i < leaves.size(); ++i)
        if (leaves.data()[i] < 0 || leaves.data()[i] >= cells[i % kSplitVariables]) throw nb::value_error("no such leaf");
    Result<std::int8_t> out({leaves.shape(0)});
    each(leaves.shape(0), threads,
         [&](std::int64_t a, std::int64_t b) { kernels().judge(split, leaves.data(), halvings, parts, a, b, out.data()); });
    return out.give();
}

// The Bernstein coefficients (15, 16) of one box; where its corners have two signs, those rows alone.
nb::object split_shape(const Split& split, int number, const Whole& place) {
    if (number < 1 || number >= static_cast<int>(split.levels.size())) throw nb::value_error("no such level");
    if (place.shape(0) != kSplitVariables) throw nb::value_error("boxes have four places");
    for (std::size_t j = 0; j < kSplitVariables; ++j)
        if (place.data()[j] < 0 || place.data()[j] >= split.levels[static_cast<std::size_t>(number)].cells[j])
            throw nb::value_error("no such box");
    Result<double> out({kWaves, kRow});
    kernels().shape(split, number, place.data(), out.data());
    return out.give();
}

// What the test of a level works with: half-widths, slack, and the minors with their slopes as they stand in the tables.
nb::object split_level(const Split& split, int number) {
    if (number < 1 || number >= static_cast<int>(split.levels.size())) throw nb::value_error("no such level");
    const SplitLevel& level = split.levels[static_cast<std::size_t>(number)];
    Result<double> half({kSplitVariables}), a({level.a.size()}), b({level.b.size()});
    std::copy(level.half.begin(), level.half.end(), half.data());
    std::copy(level.a.begin(), level.a.end(), a.data());
    std::copy(level.b.begin(), level.b.end(), b.data());
    return nb::make_tuple(half.give(), level.slack, a.give(), b.give());
}

}  // namespace

void bind_cover(nb::module_& module) {
    nb::class_<Split>(module, "Split")
        .def(nb::new_(&new_split), nb::kw_only(), nb::arg("a"), nb::arg("b"), nb::arg("lower"), nb::arg("upper"),
             nb::arg("depth"), nb::arg("curvature"), nb::arg("rounding"), nb::arg("slope"), nb::arg("further"), nb::arg("top"))
        .def_prop_ro("trees", &Split::trees);
    module.def("cover", &cover, nb::arg("split"), nb::arg("begin"), nb::arg("end"), nb::kw_only(), nb::arg("threads") = 0);
    module.def("judge_leaves", &judge_leaves, nb::arg("split"), nb::arg("leaves"), nb::arg("halvings"), nb::kw_only(), nb::arg("parts") = kMostParts, nb::arg("threads") = 0);
    module.def("split_shape", &split_shape, nb::arg("split"), nb::arg("number"), nb::arg("place"));
    module.def("split_level", &split_level, nb::arg("split"), nb::arg("number"));
}

}  // namespace rankdrop
