// Memory of the core: blocks for results that NumPy will own, and an arena for the scratch of one call. Whoever gets none
// throws std::bad_alloc, which is Python's MemoryError.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <limits>
#include <memory>
#include <new>
#include <type_traits>
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
#if defined(_MSC_VER)
        _aligned_free(memory);
#else
        std::free(memory);
#endif
    }
};

using Memory = std::unique_ptr<void, Release>;

// At least `bytes`, not initialised. Fresh memory costs a page fault every 4 KiB, half the time of a large batch of
// Jacobians; huge pages, where the system has them, cost one every 2 MiB.
inline Memory allocate(std::size_t bytes) {
    const std::size_t alignment = bytes >= kLarge ? kHugePage : kAlignment;
    if (bytes > std::numeric_limits<std::size_t>::max() / 2) throw std::bad_alloc();
    const std::size_t whole = bytes == 0 ? kAlignment : (bytes + kAlignment - 1) / kAlignment * kAlignment;
#if defined(_MSC_VER)
    Memory memory(_aligned_malloc(whole, alignment));
#else
    void* address = nullptr;
    Memory memory(posix_memalign(&address, alignment, whole) == 0 ? address : nullptr);
#endif
    if (!memory) throw std::bad_alloc();
#if defined(__linux__) && defined(MADV_HUGEPAGE)
    if (bytes >= kLarge) madvise(memory.get(), whole / kHugePage * kHugePage, MADV_HUGEPAGE);  // advice: may be refused
#endif
    return memory;
}

// Hands out scratch piece by piece and gives all of it back at once, so that nobody sums sizes beforehand.
class Arena {
  public:
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
#if defined(__SANITIZE_ADDRESS__)
    static constexpr std::size_t kBlock = 0;  // a block for every piece: writing past its end is seen
#else
    static constexpr std::size_t kBlock = std::size_t{1} << 16;
#endif

    void more(std::size_t bytes) {
        const std::size_t size = bytes > kBlock ? bytes : kBlock;
        blocks_.push_back(allocate(size));
        next_ = static_cast<std::byte*>(blocks_.back().get());
        left_ = size;
    }

    std::vector<Memory> blocks_;
    std::byte* next_ = nullptr;
    std::size_t left_ = 0;
};

}  // namespace rankdrop
