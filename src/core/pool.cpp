#include "pool.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <new>
#include <thread>
#include <vector>

#if defined(__unix__) || defined(__APPLE__)
#include <pthread.h>
#endif

namespace rankdrop {
namespace {

constexpr auto kPoll = std::chrono::milliseconds(50);

int processors() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

// As many as are asked for, but more than four for each processor only take memory.
int threads_for(int asked) {
    if (asked <= 0) return processors();
    return asked <= 16 ? asked : std::min(asked, std::max(16, 4 * processors()));
}

struct Range {
    std::int64_t begin, end;
};

struct Job {
    Job(const Batch& batch, std::atomic<bool>& stopped, const std::function<void(std::int64_t, std::int64_t)>& rows_done,
        int helpers)
        : rows(batch.rows), chunk(batch.chunk), stop(stopped), work(rows_done), seats(helpers) {
        left.reserve(static_cast<std::size_t>(helpers) + 1);  // every thread leaves one range at most
    }

    const std::int64_t rows, chunk;
    std::atomic<bool>& stop;
    const std::function<void(std::int64_t, std::int64_t)>& work;
    std::atomic<std::int64_t> next{0};
    // what follows is guarded by the pool's lock
    int seats;       // threads that may still come
    int inside = 0;  // threads that are at work
    std::vector<Range> left;
    std::exception_ptr failure;
    std::condition_variable done;
};

class Pool {
  public:
    // Puts a job up for `job.seats` threads, starting what is missing of them.
    void offer(Job& job) {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (job.seats == 0) return;
        try {
            jobs_.push_back(&job);
        } catch (const std::bad_alloc&) {
            job.seats = 0;
            return;
        }
        wanted_ += job.seats;
        while (workers_ < wanted_ + busy_ && start()) {}
        job.seats > 1 ? come_.notify_all() : come_.notify_one();
    }

    // One chunk after the other, until none is left.
    template <class Between>
    void run(Job& job, Between between) {
        for (std::int64_t begin; !job.stop.load() && (begin = job.next.fetch_add(job.chunk)) < job.rows;) {
            const Range range{begin, std::min(begin + job.chunk, job.rows)};
            try {
                job.work(range.begin, range.end);
            } catch (const std::bad_alloc&) {
                const std::lock_guard<std::mutex> lock(mutex_);
                job.left.push_back(range);
                return;
            } catch (...) {
                const std::lock_guard<std::mutex> lock(mutex_);
                if (!job.failure) job.failure = std::current_exception();
                job.stop = true;
                return;
            }
            between();
        }
    }

    // Takes the job down and waits for the threads that are still at it.
    template <class Poll>
    void finish(Job& job, Poll poll) {
        std::unique_lock<std::mutex> lock(mutex_);
        wanted_ -= job.seats;
        job.seats = 0;
        jobs_.erase(std::remove(jobs_.begin(), jobs_.end(), &job), jobs_.end());
        while (!job.done.wait_for(lock, kPoll, [&] { return job.inside == 0; })) {
            lock.unlock();
            poll();
            lock.lock();
        }
    }

    int workers() {
        const std::lock_guard<std::mutex> lock(mutex_);
        return workers_;
    }

  private:
    bool start() {
        try {
            std::thread([this] { serve(); }).detach();
        } catch (...) {  // no more threads here, or no memory for one: those that are there have to do
            return false;
        }
        ++workers_;
        return true;
    }

    void serve() {
        std::unique_lock<std::mutex> lock(mutex_);
        for (;;) {
            if (jobs_.empty() && workers_ > processors()) break;  // more were asked for than the machine can run
            come_.wait(lock, [this] { return !jobs_.empty(); });
            Job& job = *jobs_.front();
            if (--job.seats == 0) jobs_.pop_front();
            --wanted_, ++busy_, ++job.inside;
            lock.unlock();
            run(job, [] {});
            lock.lock();
            --busy_;
            if (--job.inside == 0) job.done.notify_all();  // under the lock: the job ends as soon as it is let go
        }
        --workers_;
    }

    std::mutex mutex_;
    std::condition_variable come_;
    std::deque<Job*> jobs_;  // those with a seat left
    int workers_ = 0, busy_ = 0, wanted_ = 0;
};

// Never destroyed: its threads wait in it until the process ends. A forked child has none of them, and the lock may be
// held by one that is not there; it gets a pool of its own.
std::atomic<Pool*> shared_pool{nullptr};

Pool& pool() {
#if defined(__unix__) || defined(__APPLE__)
    static const int registered = pthread_atfork(nullptr, nullptr, [] { shared_pool.store(nullptr); });
    static_cast<void>(registered);
#endif
    Pool* here = shared_pool.load();
    if (here) return *here;
    auto fresh = std::make_unique<Pool>();
    if (shared_pool.compare_exchange_strong(here, fresh.get())) return *fresh.release();
    return *here;
}

}  // namespace

void share(const Batch& batch, std::atomic<bool>& stop, const std::function<void(std::int64_t, std::int64_t)>& work,
           const std::function<bool()>& poll) {
    using Clock = std::chrono::steady_clock;
    auto asked = Clock::now();
    const auto ask = [&] {
        if (stop.load()) return;
        const auto now = Clock::now();
        if (now - asked < kPoll) return;
        asked = now;
        if (poll()) stop = true;
    };
    const std::int64_t chunks = (batch.rows + batch.chunk - 1) / batch.chunk;
    const int helpers = static_cast<int>(std::min<std::int64_t>(threads_for(batch.threads), chunks)) - 1;
    Job job(batch, stop, work, std::max(0, helpers));
    Pool& threads = pool();
    threads.offer(job);
    threads.run(job, ask);
    threads.finish(job, ask);
    if (job.failure) std::rethrow_exception(job.failure);
    // what threads left that got no memory, and what nobody was there for any more
    const auto alone = [&](std::int64_t begin, std::int64_t end) {
        work(begin, end);
        ask();
    };
    for (std::size_t i = 0; i < job.left.size() && !stop.load(); ++i) alone(job.left[i].begin, job.left[i].end);
    for (std::int64_t begin; !stop.load() && (begin = job.next.fetch_add(batch.chunk)) < batch.rows;)
        alone(begin, std::min(begin + batch.chunk, batch.rows));
}

int threads_kept() { return pool().workers(); }

}  // namespace rankdrop
