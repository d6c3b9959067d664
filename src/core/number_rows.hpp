// Rows of numbers from text: plain decimal numbers between separators, and nothing else.
#pragma once

#include <charconv>
#include <cstddef>
#include <system_error>
#include <vector>

namespace rankdrop {

// Numbers of the rows of a text, one after the other, as many in each row; false where anything else stands there, a number
// is beyond the range of doubles, or the library does not read numbers.
inline bool read_rows(const char* at, const char* end, char separator, std::size_t columns, std::vector<double>& out) {
#if defined(__cpp_lib_to_chars)
    const auto skip_blanks = [&] {
        while (at != end && (*at == ' ' || (*at == '\t' && separator != '\t'))) ++at;
    };
    const auto begins = [&](const char* sign) { return sign != end && ((*sign >= '0' && *sign <= '9') || *sign == '.'); };
    while (at != end) {
        for (std::size_t column = 0; column < columns; ++column) {
            skip_blanks();
            if (at != end && *at == '+' && begins(at + 1)) ++at;
            if (at == end || !begins(*at == '-' ? at + 1 : at)) return false;  // no names of infinities
            double value = 0.0;
            const auto [after, error] = std::from_chars(at, end, value);
            if (error != std::errc()) return false;
            out.push_back(value);
            at = after;
            skip_blanks();
            const bool last = column + 1 == columns;
            if (last && at == end) return true;
            if (at == end || *at != (last ? '\n' : separator)) return false;
            ++at;
        }
    }
    return columns > 0;
#else
    static_cast<void>(at), static_cast<void>(end), static_cast<void>(separator), static_cast<void>(columns), static_cast<void>(out);
    return false;
#endif
}

}  // namespace rankdrop
