// Copies of rods and their figures, put together tile by tile: the bits of one rod alone, for any width, mapping and
// threads.
#include "mechanics/rod_copies.hpp"
#include "skein/core/index.hpp"
#include "support/scenes_for_tests.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <mutex>
#include <numeric>

namespace skein {
namespace {

/// Every law, kind of end and section; groups that do not fill their tiles, turns on both sides of the polynomials'
/// range.
SceneSpec every_kind() {
    SceneSpec scene = test::cilia_scene(19, 12);
    scene.time = {.duration = 1, .safety = 0.3};
    const auto add = [&](RodSpec rod, const std::string& name, long count) -> RodSpec& {
        rod.name = name;
        rod.placement = {.kind = PlacementKind::line, .counts = {count}, .spacing = {0.6}};
        return scene.rods.emplace_back(rod);
    };
    for (std::size_t i = 0; i < std::size(law_names); ++i) {
        const auto law = static_cast<Law>(i);
        RodSpec& rod = add(test::crooked_rod(9), "law" + std::to_string(static_cast<int>(law)), 6);
        rod.material.law = law;
        rod.start = EndKind::pinned;
        rod.end = EndKind::clamped;
    }
    add(test::crooked_rod(7), "frozen", 3).start = EndKind::clamped_frozen;
    add(test::simple_rod(5), "bent", 9).shape.start_curvature = Vec3d{3.5, 0, 1};
    add(test::simple_rod(1), "short", 3);
    add(test::rigid_body(0.4, 0.05), "bodies", 11);
    add(test::crooked_body(), "crooked_bodies", 5);
    RodSpec& ring = add(test::simple_rod(16), "rings", 9);
    ring.shape.closed = true;
    RodSpec& turned = add(test::simple_rod(6), "turned", 3);
    turned.start = EndKind::clamped;
    turned.start_motion.rotation_amplitude = {0.2, 0, 0.3};
    turned.start_motion.period = 1.3;
    return scene;
}

/// Of a scene whose rods have all been shaken.
struct Shaken : test::Stage {
    Shaken(int lanes, int thread_count, Mapping mapping) : Stage(every_kind(), lanes, thread_count, mapping) {
        for (std::size_t i = 0; i < rods->local().size(); ++i) {
            const RodGroup& group = group_of(i);
            std::vector<Slot<1>> state = test::shaken_state(group, 0.01, 0.1, 0.3, static_cast<unsigned>(i));
            if (group.closed()) state.back() = {state[0].position, state[0].velocity, broadcast<1>(no_turn), {}};
            rods->import_rod(i, state);
        }
    }
    const RodGroup& group_of(std::size_t i) const { return nth(groups, rods->local()[i].group); }
};

template <class F> void with_all(F&& f) {
    for (const int lanes : test::built_lanes())
        for (const int threads : {1, 3})
            for (const Mapping mapping : {Mapping::across, Mapping::automatic}) {
                SCOPED_TRACE(std::to_string(lanes) + " lanes, " + std::to_string(threads) + " threads, mapping " +
                             std::to_string(static_cast<int>(mapping)));
                f(Shaken(lanes, threads, mapping));
            }
}

constexpr double lag = 0.037;

TEST(Copies, AreTheBitsOfOneRodAlone) {
    with_all([](const Shaken& stage) {
        const auto count = stage.rods->local().size();
        std::vector<std::size_t> all(count), some;
        std::iota(all.begin(), all.end(), std::size_t{0});
        for (std::size_t i = 0; i < count; ++i)
            if (i % 5 != 1 && i % 7 != 2) some.push_back(i);
        const std::vector<std::size_t> few(all.begin(), all.begin() + 10); // threads share tiles
        for (const auto& which : {all, some, few, std::vector<std::size_t>{}, std::vector<std::size_t>{3}})
            for (const Copy copy :
                 {Copy::canonical, Copy::positions, Copy::synchronised, Copy::frames, Copy::strained}) {
                constexpr double time = 0.25;
                std::vector<int> seen(which.size(), 0);
                std::mutex one_at_a_time;
                stage.rods->read(
                    which, copy, lag,
                    [&](int thread, std::size_t at, const RodCopy& found) {
                        const std::lock_guard lock(one_at_a_time);
                        ASSERT_LT(at, which.size());
                        EXPECT_LT(thread, stage.threads.count());
                        ++seen[at];
                        const RodGroup& group = stage.group_of(which[at]);
                        std::vector<Slot<1>> twin(static_cast<std::size_t>(group.slots()));
                        stage.rods->export_rod(which[at], twin);
                        if (copy == Copy::positions) synchronise_positions(group, twin, lag);
                        else if (copy != Copy::canonical) synchronise(group, twin, lag);
                        ASSERT_EQ(found.state.size(), twin.size());
                        EXPECT_EQ(std::memcmp(found.state.data(), twin.data(), found.state.size_bytes()), 0)
                            << "rod " << which[at];
                        if (copy == Copy::canonical) {
                            EXPECT_EQ(found.hash, hash_rod(stage.rods->local()[which[at]].gid, twin));
                        }
                        ASSERT_EQ(found.frames.size(), has_frames(copy) ? group.element.size() : 0);
                        for (std::size_t k = 0; k < found.frames.size(); ++k) {
                            const Mat3d q = frame(twin[k]);
                            EXPECT_EQ(std::memcmp(&found.frames[k], &q, sizeof q), 0)
                                << "rod " << which[at] << " element " << k;
                        }
                        ASSERT_EQ(found.profile.size(), copy == Copy::strained ? twin.size() : 0);
                        std::vector<NodeProfile> profile(found.profile.size());
                        if (profile.empty()) return;
                        rod_profile(group, twin, time, profile);
                        EXPECT_EQ(std::memcmp(found.profile.data(), profile.data(), found.profile.size_bytes()), 0)
                            << "rod " << which[at];
                    },
                    time);
                EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<std::ptrdiff_t>(which.size()));
            }
        std::uint64_t digest = 0;
        stage.rods->read(all, Copy::canonical, 0,
                         [&, lock = std::make_shared<std::mutex>()](int, std::size_t, const RodCopy& one) {
                             const std::lock_guard held(*lock);
                             digest += one.hash;
                         });
        EXPECT_EQ(stage.rods->digest(), digest);
    });
}

TEST(Figures, AreTheBitsOfOneRodAlone) {
    with_all([](const Shaken& stage) {
        std::vector<RodFigures> found(stage.rods->local().size());
        stage.rods->figures(0.25, lag, found);
        for (std::size_t i = 0; i < found.size(); ++i) {
            std::vector<Slot<1>> state(static_cast<std::size_t>(stage.group_of(i).slots()));
            stage.rods->export_rod(i, state);
            synchronise(stage.group_of(i), state, lag);
            const RodFigures twin = figures_of(stage.group_of(i), state, 0.25);
            EXPECT_EQ(std::memcmp(&found[i], &twin, sizeof twin), 0)
                << "rod " << i << " of " << stage.group_of(i).name();
        }
    });
}

// Axial energy of a rod that is hardly stretched: EA e^2/2 but for the cube of the strain, to round-off.
TEST(Figures, EnergyOfSmallStrainsKeepsItsDigits) {
    const RodGroup group(test::simple_rod(10), 0, 0, "");
    std::vector<Slot<1>> state(11);
    group.start_state(0, state);
    const double strain = 1e-7;
    for (Slot<1>& slot : state) slot.position = Pack<1>(1 + strain) * slot.position;
    const ElementConstants& c = group.element[0];
    const double exact = 0.5 * c.stiffness.z * strain * strain * (1 - 2 * strain / 3);
    EXPECT_NEAR(figures_of(group, state).sum[RodFigures::stretch], exact,
                1e-8 * exact); // nodes are rounded to 1e-9 of the strain
}

} // namespace
} // namespace skein
