// Vectors aligned to cache lines, so that packs never straddle one; large ones on huge pages.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <new>
#include <vector>

namespace skein {

inline constexpr std::size_t cache_line = 64;

template <class T> struct AlignedAllocator {
    using value_type = T;
    AlignedAllocator() = default;
    template <class U> AlignedAllocator(const AlignedAllocator<U>&) {}
    T* allocate(std::size_t n) {
        const std::size_t bytes = n * sizeof(T);
        void* p = ::operator new(bytes, alignment(bytes));
        // With pages of 4 kB the hardware loses its way 256 times a megabyte: a step that streams from memory takes a tenth longer.
        if (bytes >= large) madvise(p, bytes, MADV_HUGEPAGE);
        return static_cast<T*>(p);
    }
    void deallocate(T* p, std::size_t n) { ::operator delete(p, alignment(n * sizeof(T))); }
    template <class U> bool operator==(const AlignedAllocator<U>&) const { return true; }

private:
    static constexpr std::size_t huge_page = std::size_t{2} << 20, large = 4 * huge_page;
    static constexpr std::align_val_t alignment(std::size_t bytes) {
        return std::align_val_t{bytes < large ? cache_line : huge_page};
    }
};

template <class T> using AlignedVector = std::vector<T, AlignedAllocator<T>>;

} // namespace skein
