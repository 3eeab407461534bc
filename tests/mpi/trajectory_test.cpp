#include "io/trajectory.hpp"

#include "io/disk.hpp"
#include "io/files.hpp"
#include "io/h5_file.hpp"
#include "io/xdmf.hpp"
#include "mechanics/rod_copies.hpp"
#include "partition/partition.hpp"
#include "skein/core/error.hpp"
#include "support/fake_rods.hpp"
#include "support/shared_directory.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <numeric>

namespace skein {
namespace {

constexpr double dt = 0.25;

struct TrajectoryTest : testing::Test {
    const Communicator comm = Communicator::world();
    const test::SharedDirectory directory{comm};
    const std::vector<RodGroup> groups = test::two_groups();
    test::FakeRods rods{groups, partition(comm, groups)};
    OutputSpec spec{.precision = Precision::double_};

    std::string told; ///< warnings, root only
    std::uint64_t flush_bytes = FrameWriter::default_flush_bytes;

    std::unique_ptr<FrameWriter> writer(std::int64_t resume_step, FrameKind kind = FrameKind::trajectory,
                                        std::uint64_t buffer_bytes = FrameWriter::default_buffer_bytes,
                                        std::optional<std::int64_t> expected = {}) {
        told.clear();
        const EarlierFrames earlier{resume_step, expected, [this](const std::string& text) { told += text + "\n"; }};
        return std::make_unique<FrameWriter>(
            comm, FrameWriter::Settings{directory.path(), kind, spec, "a <test>", earlier, buffer_bytes, flush_bytes},
            groups, rods);
    }
    void expect_told(const std::string& text) const {
        EXPECT_TRUE(!comm.root() || told.find(text) != told.npos) << told;
    }
    void write(FrameWriter& frames, std::vector<std::int64_t> steps) {
        for (const auto step : steps) {
            rods.set(step);
            frames.write(step, static_cast<double>(step) * dt, 0.5 * dt);
        }
    }
    std::string path_of(const std::string& name) const { return directory.path() + "/" + name; }

    template <class T> std::vector<T> read(const std::string& name, H5Type type, const std::string& dataset) const {
        const H5File file(comm, path_of(name), H5File::Mode::read);
        H5Box box;
        box.count = file.shape(dataset);
        box.start.assign(box.count.size(), 0);
        std::vector<T> values(std::accumulate(box.count.begin(), box.count.end(), std::size_t{1}, std::multiplies<>()));
        file.read(dataset, type, box, values.data());
        return values;
    }
    std::vector<std::int64_t> steps_in(const std::string& name) const {
        return read<std::int64_t>(name, H5Type::int64, "/step");
    }

    /// What dataset [frames, rods, ...] must hold: numbers(state) of each rod, frame by frame.
    template <class Numbers>
    std::vector<double> expected(const RodGroup& group, const std::vector<std::int64_t>& steps, Numbers numbers) const {
        std::vector<double> all;
        for (const auto step : steps)
            for (std::int64_t i = 0; i < group.count(); ++i) {
                auto state = test::fake_state(group, i, step);
                synchronise(group, state, 0.5 * dt);
                numbers(std::span<const Slot<1>>(state), all);
            }
        return all;
    }
};

void put(std::vector<double>& out, const Vec3<Pack<1>>& v) { out.insert(out.end(), {v.x[0], v.y[0], v.z[0]}); }
void positions(std::span<const Slot<1>> state, std::vector<double>& out) {
    for (const auto& slot : state) put(out, slot.position);
}
void directors(std::span<const Slot<1>> state, std::vector<double>& out) {
    for (const auto& slot : state.first(state.size() - 1)) {
        const Mat3<Pack<1>> q = matrix(slot.director);
        put(out, q.d1);
        put(out, q.d2);
        put(out, q.d3);
    }
}
void tips(std::span<const Slot<1>> state, std::vector<double>& out) { put(out, state.back().position); }

const std::string first = "trajectory_000000000000.h5", second = "trajectory_000000000030.h5";

TEST_F(TrajectoryTest, holds_the_synchronised_state_of_every_rod) {
    const auto frames = writer(-1);
    write(*frames, {0, 10, 20});
    frames->close_segment();
    EXPECT_EQ(directory.names(), (std::vector<std::string>{"trajectory.xdmf", first}));
    EXPECT_EQ(steps_in(first), (std::vector<std::int64_t>{0, 10, 20}));
    EXPECT_EQ(read<double>(first, H5Type::float64, "/time"), (std::vector<double>{0, 2.5, 5}));
    for (const RodGroup& group : groups) {
        const std::string path = "/groups/" + group.name();
        EXPECT_EQ(read<double>(first, H5Type::float64, path + "/position"), expected(group, {0, 10, 20}, positions));
        EXPECT_EQ(read<double>(first, H5Type::float64, path + "/directors"), expected(group, {0, 10, 20}, directors));
    }
}

TEST_F(TrajectoryTest, keeps_tips_of_both_ends_when_a_run_resumes) {
    spec.both_ends = true;
    {
        const auto frames = writer(-1, FrameKind::tips);
        write(*frames, {0, 10, 20});
        frames->close_segment();
    }
    const auto frames = writer(10, FrameKind::tips);
    EXPECT_TRUE(told.empty()) << told;
    EXPECT_EQ(frames->last_step(), 10);
    EXPECT_EQ(steps_in("tips_000000000000.h5"), (std::vector<std::int64_t>{0, 10}));
}

TEST_F(TrajectoryTest, shows_single_frames_under_names_of_their_own) {
    const auto frames = writer(-1);
    write(*frames, {0, 10});
    frames->close_segment();
    EXPECT_EQ(H5File(comm, path_of(first), H5File::Mode::read).shape("/groups/mat/frames/1/position"),
              (std::vector<std::uint64_t>{9, 9, 3}));
    for (const std::string& file : {path_of(first), path_of("absent.h5")})
        EXPECT_THROW(on_root(comm, [&] { make_frame_views(file, "/groups/mat", {"absent"}, 2); }), IoError);
}

TEST_F(TrajectoryTest, of_single_precision_holds_the_same_rounded) {
    spec = {.directors = false, .precision = Precision::single};
    const auto frames = writer(-1);
    write(*frames, {0, 10});
    frames->close_segment();
    const auto exact = expected(groups[1], {0, 10}, positions);
    EXPECT_EQ(read<float>(first, H5Type::float32, "/groups/mat/position"),
              std::vector<float>(exact.begin(), exact.end()));
    EXPECT_THROW(read<float>(first, H5Type::float32, "/groups/mat/directors"), IoError);
}

TEST_F(TrajectoryTest, of_tips_holds_last_nodes) {
    const auto frames = writer(-1, FrameKind::tips);
    write(*frames, {5, 6});
    frames->close_segment();
    EXPECT_EQ(directory.names(), std::vector<std::string>{"tips_000000000005.h5"});
    EXPECT_EQ(read<double>("tips_000000000005.h5", H5Type::float64, "/groups/cilia/position"),
              expected(groups[0], {5, 6}, tips));
}

TEST_F(TrajectoryTest, has_the_same_bytes_however_many_frames_wait_in_memory) {
    std::vector<std::int64_t> steps(12);
    std::iota(steps.begin(), steps.end(), 0);
    for (const auto& [kind, flush] : {std::pair{FrameKind::trajectory, FrameWriter::default_flush_bytes},
                                      std::pair{FrameKind::trajectory, std::uint64_t{80} << 10},
                                      std::pair{FrameKind::tips, FrameWriter::default_flush_bytes}}) {
        flush_bytes = flush;
        const std::string name = kind == FrameKind::tips ? "tips_000000000000.h5" : first;
        std::string expected_bytes;
        // A frame has 33 kB, of tips 1.1 kB: one at a time, a few, all.
        for (const std::uint64_t buffer_bytes : {0, 1500, 4000, 30 << 10, 100 << 10, 1 << 20}) {
            const auto frames = writer(-1, kind, buffer_bytes);
            write(*frames, steps);
            frames->close_segment();
            EXPECT_EQ(steps_in(name), steps);
            const auto numbers = kind == FrameKind::tips ? tips : positions;
            for (const RodGroup& group : groups)
                EXPECT_EQ(read<double>(name, H5Type::float64, "/groups/" + group.name() + "/position"),
                          expected(group, steps, numbers));
            const std::string bytes = read_file(path_of(name));
            if (expected_bytes.empty()) expected_bytes = bytes;
            EXPECT_TRUE(bytes == expected_bytes)
                << name << " differs where " << buffer_bytes << " bytes of frames may wait";
        }
    }
}

TEST_F(TrajectoryTest, waits_in_memory_until_it_is_full_or_closed) {
    const auto frames =
        writer(-1, FrameKind::trajectory, 70000 / static_cast<std::uint64_t>(comm.size()) + 2000); // two frames
    write(*frames, {0});
    EXPECT_TRUE(directory.names().empty());
    write(*frames, {10});
    EXPECT_EQ(directory.names(), std::vector<std::string>{first + ".tmp"});
    write(*frames, {20});
    frames->close_segment();
    EXPECT_EQ(steps_in(first), (std::vector<std::int64_t>{0, 10, 20}));
    frames->close_segment();
    EXPECT_EQ(directory.names(), (std::vector<std::string>{"trajectory.xdmf", first}));
}

TEST_F(TrajectoryTest, has_a_frame_of_every_step_once_across_segments_and_restarts) {
    {
        const auto frames = writer(-1, FrameKind::trajectory, 0);
        write(*frames, {0, 10, 20});
        frames->close_segment();
        write(*frames, {20, 30, 40});
        frames->close_segment();
        write(*frames, {50, 60}); // killed before it is closed
    }
    const std::string third = "trajectory_000000000050.h5", unreadable = "lost_" + third + ".unreadable";
    EXPECT_EQ(directory.names(), (std::vector<std::string>{"trajectory.xdmf", first, second, third + ".tmp"}));
    {
        const auto frames = writer(40);
        EXPECT_EQ(directory.names(), (std::vector<std::string>{unreadable, "trajectory.xdmf", first, second}));
        write(*frames, {40});
        frames->close_segment();
        EXPECT_EQ(directory.names(), (std::vector<std::string>{unreadable, "trajectory.xdmf", first, second}));
        write(*frames, {50});
        frames->close_segment();
    }
    EXPECT_EQ(steps_in(second), (std::vector<std::int64_t>{30, 40}));
    EXPECT_EQ(steps_in("trajectory_000000000050.h5"), std::vector<std::int64_t>{50});
}

TEST_F(TrajectoryTest, is_cut_back_to_the_step_that_a_run_resumes_at) {
    {
        const auto frames = writer(-1);
        write(*frames, {0, 10, 20});
        frames->close_segment();
        write(*frames, {30, 40});
        frames->close_segment();
    }
    const auto frames = writer(15);
    const std::string lost = "lost_" + first, lost_too = "lost_" + second;
    EXPECT_EQ(directory.names(), (std::vector<std::string>{lost, lost_too, "trajectory.xdmf", first}));
    EXPECT_EQ(steps_in(lost), (std::vector<std::int64_t>{0, 10, 20}));
    EXPECT_EQ(steps_in(lost_too), (std::vector<std::int64_t>{30, 40}));
    EXPECT_EQ(steps_in(first), (std::vector<std::int64_t>{0, 10}));
    EXPECT_EQ(read<double>(first, H5Type::float64, "/groups/mat/directors"), expected(groups[1], {0, 10}, directors));
    write(*frames, {10, 20});
    frames->close_segment();
    EXPECT_EQ(steps_in("trajectory_000000000020.h5"), std::vector<std::int64_t>{20});
    const std::string third = "trajectory_000000000020.h5";
    EXPECT_EQ(directory.names(), (std::vector<std::string>{lost, lost_too, "trajectory.xdmf", first, third}));
    writer(-1);
    EXPECT_EQ(directory.names(),
              (std::vector<std::string>{lost, lost + ".2", "lost_" + third, lost_too, "trajectory.xdmf"}));
}

TEST_F(TrajectoryTest, frames_that_a_killed_run_left_are_kept) {
    spec.precision = Precision::single;
    flush_bytes = 0;
    const std::string tmp = path_of(first + ".tmp"), copy = path_of("copy");
    {
        const auto frames = writer(-1, FrameKind::trajectory, 0);
        write(*frames, {0, 10, 20});
        on_root(comm,
                [&] { std::filesystem::copy_file(tmp, copy); }); // as a process leaves it that ends in this moment
    }
    on_root(comm, [&] { std::filesystem::rename(copy, tmp); });
    const auto frames = writer(-1);
    expect_told("3 good frames of a killed run");
    EXPECT_EQ(directory.names(), std::vector<std::string>{"lost_" + first});
    EXPECT_EQ(steps_in("lost_" + first), (std::vector<std::int64_t>{0, 10, 20}));
    const auto exact = expected(groups[1], {0, 10, 20}, positions);
    EXPECT_EQ(read<float>("lost_" + first, H5Type::float32, "/groups/mat/position"),
              std::vector<float>(exact.begin(), exact.end()));
}

TEST_F(TrajectoryTest, a_changed_number_of_the_last_segment_is_found) {
    for (const Precision precision : {Precision::single, Precision::double_})
        for (const char* dataset : {"/step", "/time", "/digest", "/groups/mat/position", "/groups/cilia/directors"}) {
            spec.precision = precision;
            {
                const auto frames = writer(-1, FrameKind::trajectory, 0);
                write(*frames, {0, 10});
                frames->close_segment();
                write(*frames, {20, 30, 40});
                frames->finish();
            }
            const std::string name = "trajectory_000000000020.h5";
            on_root(comm, [&] {
                H5File file(Communicator::alone(), path_of(name), H5File::Mode::modify);
                H5Box box;
                box.count = file.shape(dataset);
                box.start.assign(box.count.size(), 0);
                for (std::size_t d = 0; d < box.count.size(); ++d) {
                    box.start[d] = box.count[d] - 1;
                    box.count[d] = 1;
                }
                double number = 0; // as many bytes as any type has
                const H5Type type = file.type(dataset);
                file.read(dataset, type, box, &number);
                reinterpret_cast<unsigned char*>(&number)[0] ^= 1;
                file.write(dataset, type, box, &number);
                file.close();
            });
            const auto frames = writer(40, FrameKind::trajectory, FrameWriter::default_buffer_bytes, 40);
            expect_told("is damaged");
            expect_told("the frames after step 10 and up to step 40 are missing");
            EXPECT_EQ(frames->last_step(), 10);
            on_root(comm, [&] {
                EXPECT_TRUE(std::filesystem::exists(path_of(name + ".damaged"))) << dataset;
                for (const auto& entry : std::filesystem::directory_iterator(directory.path()))
                    std::filesystem::remove(entry);
            });
        }
}

TEST_F(TrajectoryTest, goes_on_without_a_segment_that_is_damaged_or_gone) {
    const std::vector<std::string> names = {first, "trajectory_000000000010.h5", "trajectory_000000000020.h5"};
    for (const bool gone : {true, false})
        for (std::size_t bad = 0; bad < names.size(); ++bad) {
            {
                const auto frames = writer(-1);
                for (const std::int64_t step : {0, 10, 20}) {
                    write(*frames, {step});
                    frames->close_segment();
                }
            }
            on_root(comm, [&] {
                if (gone) std::filesystem::remove(path_of(names[bad]));
                else std::filesystem::resize_file(path_of(names[bad]), 1000);
            });
            const auto frames = writer(20, FrameKind::trajectory, FrameWriter::default_buffer_bytes, 20);
            const auto from = 10 * static_cast<std::int64_t>(bad) - 10;
            expect_told("the frames after step " + std::to_string(from < 0 ? -1 : from) + " and up to step " +
                        std::to_string(10 * bad) + " are missing");
            if (!gone) expect_told("renamed to");
            EXPECT_EQ(frames->last_step(), bad == 2 ? 10 : 20);
            const std::string xml = read_file(path_of("trajectory.xdmf"));
            for (std::size_t i = 0; i < names.size(); ++i) EXPECT_EQ(xml.find(names[i]) == xml.npos, i == bad) << i;
            write(*frames, {30});
            frames->close_segment();
            comm.barrier();
            on_root(comm, [&] {
                for (const auto& entry : std::filesystem::directory_iterator(directory.path()))
                    std::filesystem::remove(entry);
            });
        }
}

TEST_F(TrajectoryTest, files_of_others_stay) {
    const std::vector<std::string> names = {first, first + ".tmp", "trajectory.xdmf"};
    on_root(comm, [&] {
        for (const auto& name : names) write_file(path_of(name), "of another program: " + name);
    });
    const auto frames = writer(-1);
    write(*frames, {0, 10});
    frames->finish();
    EXPECT_EQ(steps_in(first), (std::vector<std::int64_t>{0, 10}));
    on_root(comm, [&] {
        std::vector<std::string> found;
        for (const auto& entry : std::filesystem::directory_iterator(directory.path())) {
            const std::string text = read_file(entry.path().string());
            if (text.starts_with("of another")) found.push_back(text.substr(20));
        }
        std::sort(found.begin(), found.end());
        EXPECT_EQ(found, (std::vector<std::string>{"trajectory.xdmf", first, first + ".tmp"}));
    });
}

TEST(SideCar, costs_in_proportion_to_the_segments) {
    std::size_t listed = 0, written = 0;
    for (std::size_t segments = 1; segments <= 20000; ++segments) {
        if (document_lags(segments, listed)) written += listed = segments;
        ASSERT_LE(static_cast<double>(written),
                  19.0 * static_cast<double>(segments)); // 10 000 where it is always written
        ASSERT_GE(static_cast<double>(listed), 0.94 * static_cast<double>(segments) - 1);
    }
}

TEST_F(TrajectoryTest, side_car_is_complete_at_the_end) {
    spec.directors = false;
    const auto frames = writer(-1);
    for (std::int64_t step = 0; step < 17; ++step) {
        write(*frames, {step});
        frames->close_segment();
    }
    const auto names_last = [&] {
        return read_file(path_of("trajectory.xdmf")).find("trajectory_000000000016.h5") != std::string::npos;
    };
    EXPECT_FALSE(names_last());
    comm.barrier();
    frames->finish();
    EXPECT_TRUE(names_last());
}

TEST_F(TrajectoryTest, on_a_full_disk_is_an_error_and_leaves_whole_segments_only) {
    const std::vector<RodGroup> many = test::two_groups(1000, 1); // 0.65 MB per frame
    test::FakeRods rods_of_many(many, partition(comm, many));
    // Found full by a frame, and by the end of the segment.
    for (const std::uint64_t buffer_bytes : {std::uint64_t{0}, std::uint64_t{FrameWriter::default_buffer_bytes}}) {
        const test::SmallDisk disk(comm, "3m");
        if (!disk.mounted()) GTEST_SKIP() << "mounting a small tmpfs is not permitted here";
        FrameWriter frames(comm, {.directory = disk.path(), .spec = spec, .buffer_bytes = buffer_bytes}, many,
                           rods_of_many);
        frames.write(0, 0, 0);
        frames.close_segment();
        std::string text;
        std::int64_t step = 1;
        try {
            for (; step < 20; ++step) frames.write(step, 0, 0);
            frames.close_segment();
        } catch (const IoError& error) {
            text = error.what();
        }
        EXPECT_EQ(step < 20, buffer_bytes == 0) << step;
        EXPECT_NE(text.find(buffer_bytes == 0 ? " kB needed" : "disk full: 13."), text.npos) << text;
        EXPECT_EQ(text, comm.broadcast(text));
        // What was written before the disk was full is kept.
        std::vector<std::string> names = {"trajectory.xdmf", first};
        if (buffer_bytes == 0) names.emplace_back("trajectory_000000000001.h5");
        EXPECT_EQ(disk.names(), names);
    }
}

} // namespace
} // namespace skein
