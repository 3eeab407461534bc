#include "io/trajectory.hpp"

#include "core/error.hpp"
#include "io/disk.hpp"
#include "io/files.hpp"
#include "io/h5_file.hpp"
#include "partition/partition.hpp"
#include "support/fake_rods.hpp"
#include "support/shared_directory.hpp"

#include <gtest/gtest.h>

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

    std::unique_ptr<FrameWriter> writer(std::int64_t resume_step, FrameKind kind = FrameKind::trajectory,
                                        std::uint64_t buffer_bytes = FrameWriter::default_buffer_bytes) const {
        return std::make_unique<FrameWriter>(comm, directory.path(), kind, spec, groups, rods, resume_step, "a <test>",
                                             buffer_bytes);
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
    std::vector<std::int64_t> steps_in(const std::string& name) const { return read<std::int64_t>(name, H5Type::int64, "/step"); }

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
    EXPECT_EQ(read<float>(first, H5Type::float32, "/groups/mat/position"), std::vector<float>(exact.begin(), exact.end()));
    EXPECT_THROW(read<float>(first, H5Type::float32, "/groups/mat/directors"), IoError);
}

TEST_F(TrajectoryTest, of_tips_holds_last_nodes) {
    const auto frames = writer(-1, FrameKind::tips);
    write(*frames, {5, 6});
    frames->close_segment();
    EXPECT_EQ(directory.names(), std::vector<std::string>{"tips_000000000005.h5"});
    EXPECT_EQ(read<double>("tips_000000000005.h5", H5Type::float64, "/groups/cilia/position"), expected(groups[0], {5, 6}, tips));
}

TEST_F(TrajectoryTest, has_the_same_bytes_however_many_frames_wait_in_memory) {
    std::vector<std::int64_t> steps(12);
    std::iota(steps.begin(), steps.end(), 0);
    for (const FrameKind kind : {FrameKind::trajectory, FrameKind::tips}) {
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
            EXPECT_TRUE(bytes == expected_bytes) << name << " differs where " << buffer_bytes << " bytes of frames may wait";
        }
    }
}

TEST_F(TrajectoryTest, waits_in_memory_until_it_is_full_or_closed) {
    const auto frames = writer(-1, FrameKind::trajectory, 70000 / static_cast<std::uint64_t>(comm.size()) + 2000); // two frames
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
    EXPECT_EQ(directory.names(), (std::vector<std::string>{"trajectory.xdmf", first, second, "trajectory_000000000050.h5.tmp"}));
    {
        const auto frames = writer(40);
        EXPECT_EQ(directory.names(), (std::vector<std::string>{"trajectory.xdmf", first, second}));
        write(*frames, {40});
        frames->close_segment();
        EXPECT_EQ(directory.names(), (std::vector<std::string>{"trajectory.xdmf", first, second}));
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
    EXPECT_EQ(directory.names(), (std::vector<std::string>{"trajectory.xdmf", first}));
    EXPECT_EQ(steps_in(first), (std::vector<std::int64_t>{0, 10}));
    EXPECT_EQ(read<double>(first, H5Type::float64, "/groups/mat/directors"), expected(groups[1], {0, 10}, directors));
    write(*frames, {10, 20});
    frames->close_segment();
    EXPECT_EQ(steps_in("trajectory_000000000020.h5"), std::vector<std::int64_t>{20});
    EXPECT_EQ(directory.names(), (std::vector<std::string>{"trajectory.xdmf", first, "trajectory_000000000020.h5"}));
    writer(-1);
    EXPECT_TRUE(directory.names().empty());
}

TEST_F(TrajectoryTest, side_car_names_all_frames_of_all_segments) {
    const auto frames = writer(-1);
    write(*frames, {0, 10, 20});
    frames->close_segment();
    write(*frames, {30});
    frames->close_segment();
    const std::string xml = read_file(path_of("trajectory.xdmf"));
    const auto count = [&xml](const std::string& text) {
        int found = 0;
        for (auto at = xml.find(text); at != xml.npos; at = xml.find(text, at + 1)) ++found;
        return found;
    };
    EXPECT_EQ(count("<Time "), 4);
    EXPECT_EQ(count("a &lt;test&gt;"), 1);
    EXPECT_EQ(count(first + ":/groups/cilia/frames/2/position<"), 1);
    EXPECT_EQ(count(first + ":/groups/cilia/frames/"), 6);
    EXPECT_EQ(count(second + ":/groups/mat/frames/0/normal<"), 1);
    EXPECT_EQ(count("Name=\"magnetisation\""), 4);
}

TEST_F(TrajectoryTest, on_a_full_disk_is_an_error_and_leaves_whole_segments_only) {
    const std::vector<RodGroup> many = test::two_groups(1000, 1); // 0.65 MB per frame
    test::FakeRods rods_of_many(many, partition(comm, many));
    // Found full by a frame, and by the end of the segment.
    for (const std::uint64_t buffer_bytes : {std::uint64_t{0}, std::uint64_t{FrameWriter::default_buffer_bytes}}) {
        const test::SmallDisk disk(comm, "3m");
        if (!disk.mounted()) GTEST_SKIP() << "mounting a small tmpfs is not permitted here";
        FrameWriter frames(comm, disk.path(), FrameKind::trajectory, spec, many, rods_of_many, -1, "", buffer_bytes);
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
        EXPECT_NE(text.find(buffer_bytes == 0 ? "disk full: 0." : "disk full: 13."), text.npos) << text;
        EXPECT_EQ(text, comm.broadcast(text));
        EXPECT_EQ(disk.names(), (std::vector<std::string>{"trajectory.xdmf", first}));
    }
}

} // namespace
} // namespace skein
