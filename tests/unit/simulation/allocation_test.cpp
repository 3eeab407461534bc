// No allocation inside a step: malloc and operator new are counted while rods advance.
#include "support/scenes_for_tests.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

namespace {
std::atomic<bool> counting{false};
std::atomic<long> allocations{0};

void* counted(std::size_t bytes, std::size_t alignment) {
    if (counting) ++allocations;
    void* p = alignment > alignof(std::max_align_t)
                  ? std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment)
                  : std::malloc(bytes);
    if (!p) throw std::bad_alloc();
    return p;
}
} // namespace

void* operator new(std::size_t bytes) { return counted(bytes, 1); }
void* operator new[](std::size_t bytes) { return counted(bytes, 1); }
void* operator new(std::size_t bytes, std::align_val_t a) { return counted(bytes, static_cast<std::size_t>(a)); }
void* operator new[](std::size_t bytes, std::align_val_t a) { return counted(bytes, static_cast<std::size_t>(a)); }
void operator delete(void* p) noexcept { std::free(p); }
void operator delete[](void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
void operator delete[](void* p, std::size_t) noexcept { std::free(p); }
void operator delete(void* p, std::align_val_t) noexcept { std::free(p); }
void operator delete[](void* p, std::align_val_t) noexcept { std::free(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }
void operator delete[](void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }

namespace skein {
namespace {

long allocations_of_steps(int threads) {
    test::Stage stage(test::cilia_scene(100), 8, threads);
    stage.advance(128); // warm up: the thread team starts on its first loop
    allocations = 0;
    counting = true;
    stage.advance(640);
    counting = false;
    return allocations;
}

TEST(Allocation, CounterSeesAllocations) {
    allocations = 0;
    counting = true;
    const auto seen = std::make_unique<std::vector<double>>(100);
    counting = false;
    EXPECT_EQ(allocations, 2);
}

TEST(Allocation, NoneInsideAStep) {
    EXPECT_EQ(allocations_of_steps(1), 0);
    EXPECT_EQ(allocations_of_steps(2), 0);
}

} // namespace
} // namespace skein
