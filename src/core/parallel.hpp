// Splits a batch over threads. Rows are independent, so the result does not depend on how they are split.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

namespace rankdrop {

// work(begin, end) on chunks of `chunk` rows; `poll` is called on the calling thread every 50 ms while others work and
// returns true to stop (then *stop is set, and chunks not begun are left out).
template <class Work, class Poll>
void parallel_rows(std::int64_t rows, std::int64_t chunk, int threads, volatile bool* stop, Work work, Poll poll) {
    if (threads <= 0) threads = std::max(1u, std::thread::hardware_concurrency());
    threads = (int)std::min<std::int64_t>(threads, (rows + chunk - 1) / chunk);
    std::atomic<std::int64_t> next{0};
    std::mutex mutex;
    std::condition_variable done;
    int running = threads;
    const auto body = [&] {
        for (std::int64_t begin; !*stop && (begin = next.fetch_add(chunk)) < rows;) work(begin, std::min(begin + chunk, rows));
        const std::lock_guard<std::mutex> lock(mutex);
        if (--running == 0) done.notify_all();
    };
    std::vector<std::thread> pool;
    pool.reserve(threads);
    for (int i = 0; i < threads; ++i) pool.emplace_back(body);
    {
        std::unique_lock<std::mutex> lock(mutex);
        while (!done.wait_for(lock, std::chrono::milliseconds(50), [&] { return running == 0; })) {
            lock.unlock();
            if (poll()) *stop = true;
            lock.lock();
        }
    }
    for (std::thread& thread : pool) thread.join();
}

}  // namespace rankdrop
