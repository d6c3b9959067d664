// Memory of the core: blocks for results that NumPy will own, and an arena for the scratch of one call. Whoever gets none
// throws std::bad_alloc, which is Python's MemoryError.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace rankdrop {

inline constexpr std::size_t kAlignment = 64;               // the widest pack
inline constexpr std::size_t kHugePage = std::size_t{1} << 21;
inline constexpr std::size_t kLarge = 2 * kHugePage;        // results from here on ask for huge pages

struct Release {
    void operator()(void* memory) const noexcept {
#if defined(_WIN32)
        _aligned_free(memory);
#else
        std::free(memory);
#endif
    }
};

using Memory = std::unique_ptr<void, Release>;

// At least `bytes`, not initialised, aligned for the widest pack.
inline Memory allocate(std::size_t bytes) {
    const std::size_t whole = (bytes / kAlignment + 1) * kAlignment;
#if defined(_WIN32)
    Memory memory(_aligned_malloc(whole, kAlignment));
#else
    Memory memory(std::aligned_alloc(kAlignment, whole));
#endif
    if (!memory) throw std::bad_alloc();
    return memory;
}

// The same for results, aligned for doubles. Fresh memory costs a page fault every 4 KiB, half the time of a large batch of
// Jacobians; huge pages, where the system has them, cost one every 2 MiB. They are asked for inside the block as malloc
// gives it: a block with an alignment of its own would be mapped anew every time, where malloc has a used one.
inline Memory allocate_result(std::size_t bytes) {
#if defined(_WIN32)
    return allocate(bytes);
#else
    Memory memory(std::malloc(std::max<std::size_t>(bytes, 1)));
    if (!memory) throw std::bad_alloc();
#if defined(__linux__) && defined(MADV_HUGEPAGE)
    if (bytes >= kLarge) {
        const auto begin = reinterpret_cast<std::uintptr_t>(memory.get());
        const std::uintptr_t first = (begin + kHugePage - 1) / kHugePage * kHugePage;
        const std::uintptr_t last = (begin + bytes) / kHugePage * kHugePage;
        if (last > first) madvise(reinterpret_cast<void*>(first), last - first, MADV_HUGEPAGE);  // advice: may be refused
    }
#endif
    return memory;
#endif
}

// Hands out scratch piece by piece and gives all of it back at once, so that nobody sums sizes beforehand. A thread keeps
// the first block for its next arena.
class Arena {
  public:
    Arena() = default;
    Arena(const Arena&) = delete;
    Arena& operator=(const Arena&) = delete;
    ~Arena() {
        if (first_.memory && first_.size == kBlock) spare() = std::move(first_.memory);
    }

    // `count` of T, not initialised, aligned for packs
    template <class T>
    T* take(std::size_t count) {
        static_assert(std::is_trivially_destructible_v<T>, "nothing is destroyed when the arena ends");
        const std::size_t bytes = (count * sizeof(T) + kAlignment - 1) / kAlignment * kAlignment;
        if (bytes > left_) more(bytes);
        T* here = reinterpret_cast<T*>(next_);
        next_ += bytes, left_ -= bytes;
        return here;
    }

  private:
    struct Block {
        Memory memory;
        std::size_t size;
    };

#if defined(__SANITIZE_ADDRESS__)
    static constexpr std::size_t kBlock = 0;  // a block for every piece: writing past its end is seen
#else
    static constexpr std::size_t kBlock = std::size_t{1} << 16;
#endif

    static Memory& spare() {
        thread_local Memory block;
        return block;
    }

    void more(std::size_t bytes) {
        const std::size_t size = std::max(bytes, kBlock);
        Block block{size == kBlock && spare() ? std::move(spare()) : allocate(size), size};
        next_ = static_cast<std::byte*>(block.memory.get());
        left_ = size;
        if (first_.memory)
            more_.push_back(std::move(block));
        else
            first_ = std::move(block);
    }

    Block first_{nullptr, 0};
    std::vector<Block> more_;  // seldom any: a vector would be allocated anew every time
    std::byte* next_ = nullptr;
    std::size_t left_ = 0;
};

}  // namespace rankdrop
