// What an enclosure is told, and what it says.
#pragma once

#include <cstdint>
#include <vector>

namespace rankdrop {

inline constexpr int kMostJoints = 32;  // of a chain whose regions are certified

// What an enclosure is told besides the view, whose axes and point are those of one link.
struct EnclosureSettings {
    int rank = 6;               // the rank to be kept
    double length = 1.0;        // scale of the translation rows
    double radius = 3.2;        // largest ball
    double repeats = 1.0;       // sqrt of the largest number of joints that one variable drives
    std::vector<double> scale;  // (n) one unit of each variable in its own unit
    std::vector<double> arm;    // (joints) reach from each axis to the point of the link, without travel of slides
};

// Rows are boxes (free, split) or balls (radius); the rest, where bound is not null, is what the bound speaks of.
struct EnclosureOutput {
    std::int8_t* free = nullptr;    // 1: the rank does not fall below `rank` in the box
    std::int32_t* split = nullptr;  // the variable that contributes most
    double* radius = nullptr;
    double above = 0.0;             // balls that are not larger are not measured: their radius is 0
    double* bound = nullptr;        // (rows, r, r)
    double* sigma = nullptr;        // (rows, r)
    double* u = nullptr;            // (rows, m, r)
    double* v = nullptr;            // (rows, n, r)
    double* arm = nullptr;          // (rows, joints)
};

// Boxes cut by balls around one configuration: rows of `q` are the centres of the boxes, `half` their half-widths.
struct Cut {
    const double* offset;    // (rows, n) the centres of the boxes from that of the balls, scaled
    const double* rounding;  // (rows) how far a centre may be off, scaled
    const double* low;       // (rows) radii up to which the boxes are known to be free
    const double* high;      // (rows) radii asked for
    double* proven;          // (rows) the part of the box in a ball of this radius is free: from low to high
    std::int32_t* split;     // (rows) the variable that contributes most
};

}  // namespace rankdrop
