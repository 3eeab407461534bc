// Vectors aligned to cache lines, so that packs never straddle one; large ones on huge pages.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <new>
#include <type_traits>
#include <utility>
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
        // Pages of 4 kB stop the hardware's prefetch 256 times a megabyte: a step that streams from memory takes a
        // tenth longer.
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

/// Numbers that are not initialised. A page is mapped where the thread runs that writes it first: no other thread
/// clears it before, and it lies in that thread's memory domain.
template <class T> class UnsetArray {
    static_assert(std::is_trivially_destructible_v<T>);

public:
    UnsetArray() = default;
    explicit UnsetArray(std::size_t size)
        : data_(size > 0 ? AlignedAllocator<T>().allocate(size) : nullptr), size_(size) {}
    ~UnsetArray() {
        if (data_) AlignedAllocator<T>().deallocate(data_, size_);
    }
    UnsetArray(UnsetArray&& other) noexcept
        : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}
    UnsetArray& operator=(UnsetArray&& other) noexcept {
        std::swap(data_, other.data_);
        std::swap(size_, other.size_);
        return *this;
    }
    /// Allocates `size` numbers; earlier content is lost.
    void need(std::size_t size) {
        if (size > size_) *this = UnsetArray(size);
    }
    T* data() { return data_; }
    const T* data() const { return data_; }
    std::size_t size() const { return size_; }
    T& operator[](std::size_t i) { return data_[i]; }
    const T& operator[](std::size_t i) const { return data_[i]; }

private:
    T* data_ = nullptr;
    std::size_t size_ = 0;
};

} // namespace skein
