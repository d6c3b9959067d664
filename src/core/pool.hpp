// Splits a batch over threads that are kept between calls. Rows are independent, so the result does not depend on how
// they are split, on how many threads there are, or on which of them does what.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>

namespace rankdrop {

struct Batch {
    std::int64_t rows;
    std::int64_t chunk;  // rows done at one go
    int threads;         // 0: one for every processor
};

// Calls work(begin, end) on chunks until every row is done, on the calling thread and on threads of the pool. `poll` is
// asked on the calling thread, between chunks and while it waits, every 50 ms; when it says true, `stop` is set and chunks
// not begun are left out; it must not throw. A thread that cannot be started is done without; one that gets no memory leaves its rows to
// the calling thread, which throws std::bad_alloc when it gets none either.
void share(const Batch& batch, std::atomic<bool>& stop, const std::function<void(std::int64_t, std::int64_t)>& work,
           const std::function<bool()>& poll);

// How many threads the pool has at this moment.
int threads_kept();

}  // namespace rankdrop
