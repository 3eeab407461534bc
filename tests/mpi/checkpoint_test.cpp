#include "io/checkpoint.hpp"

#include "io/disk.hpp"
#include "io/files.hpp"
#include "io/h5_file.hpp"
#include "partition/partition.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"
#include "support/fake_rods.hpp"
#include "support/shared_directory.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>

namespace fs = std::filesystem;

namespace skein {
namespace {

const std::string scene = R"({"rods":[{"name":"cilia","length":1.0}],"time":{"dt":0.001}})";

struct CheckpointTest : testing::Test {
    const Communicator comm = Communicator::world();
    const test::SharedDirectory directory{comm};
    const std::vector<RodGroup> groups = test::two_groups();
    test::FakeRods rods{groups, partition(comm, groups)};
    std::vector<std::string> warnings; ///< root's

    std::uint64_t digest() const { return comm.sum_wrapping(rods.digest()); }
    std::uint64_t digest_at(std::int64_t step) {
        rods.set(step);
        return digest();
    }
    std::string path_of(std::int64_t step) const {
        std::string number = std::to_string(step);
        return directory.path() + "/checkpoint_" + std::string(12 - number.size(), '0') + number + ".h5";
    }
    void write(std::int64_t step, const std::string& of_scene = scene) {
        const auto whole = digest_at(step);
        write_checkpoint(comm, directory.path(), groups, rods, {step, 0.001, whole, of_scene, {}});
    }
    std::optional<CheckpointInfo> read(const std::string& for_scene = scene) {
        rods.set(-1);
        warnings.clear();
        return read_checkpoint(comm, directory.path(), groups, rods, for_scene,
                               [this](const std::string& text) { warnings.push_back(text); });
    }
    std::vector<std::string> names() const { return directory.names(); }
    /// Changes a file on root, between two barriers.
    template <class Change> void damage(const std::string& path, Change change) const {
        on_root(comm, [&] { change(path); });
    }
    /// The error's text, the same on all ranks.
    template <class E, class Deed> std::string error_of(Deed deed) const {
        std::string text;
        try {
            deed();
        } catch (const E& error) {
            text = error.what();
        }
        EXPECT_NE(text, "");
        EXPECT_EQ(text, comm.broadcast(text));
        return text;
    }
};

TEST_F(CheckpointTest, brings_back_every_rod) {
    write(120);
    const auto info = read();
    ASSERT_TRUE(info);
    EXPECT_EQ(info->step, 120);
    EXPECT_EQ(info->dt, 0.001);
    EXPECT_EQ(info->scene, scene);
    EXPECT_EQ(info->file, path_of(120));
    EXPECT_EQ(info->digest, digest());
    for (std::size_t i = 0; i < rods.local().size(); ++i) {
        const RodGroup& group = nth(groups, rods.local()[i].group);
        std::vector<Slot<1>> found(static_cast<std::size_t>(group.slots()));
        rods.export_rod(i, found);
        const auto expected = test::fake_state(group, rods.local()[i].index, 120);
        EXPECT_EQ(hash_rod(0, found), hash_rod(0, expected));
    }
    EXPECT_TRUE(warnings.empty());
}

TEST_F(CheckpointTest, keeps_the_works_of_an_audit) {
    const auto whole = digest_at(120);
    write_checkpoint(comm, directory.path(), groups, rods, {120, 0.001, whole, scene, {}, 0.25});
    auto info = read();
    ASSERT_TRUE(info && info->audited_from);
    EXPECT_EQ(*info->audited_from, 0.25);
    for (std::size_t i = 0; i < rods.local().size(); ++i) {
        const RodBudget found = rods.budget(i), expected = test::FakeRods::fake_budget(rods.local()[i].gid, 120);
        EXPECT_EQ(found.loads, expected.loads);
        EXPECT_EQ(found.walls, expected.walls);
        EXPECT_EQ(found.dissipated, expected.dissipated);
    }
    write(130);
    info = read();
    ASSERT_TRUE(info);
    EXPECT_EQ(info->step, 130);
    EXPECT_FALSE(info->audited_from);
    EXPECT_EQ(rods.budget(0).walls, test::FakeRods::fake_budget(rods.local()[0].gid, -1).walls)
        << "energy budget from a file without any";
}

TEST_F(CheckpointTest, keeps_the_newest_two_and_milestones) {
    for (const std::int64_t step : {10, 20, 90, 92, 95, 100}) write(step);
    EXPECT_EQ(names(), (std::vector<std::string>{"checkpoint_000000000010.h5", "checkpoint_000000000020.h5",
                                                 "checkpoint_000000000090.h5", "checkpoint_000000000095.h5",
                                                 "checkpoint_000000000100.h5"}));
    EXPECT_EQ(read()->step, 100);
}

TEST_F(CheckpointTest, neither_removes_nor_writes_over_files_that_are_none) {
    const std::string text = "of another program";
    for (const std::int64_t step : {1, 5, 30, 1000})
        for (const char* ending : {"", ".tmp"})
            damage(path_of(step) + ending, [&](const std::string& path) { write_file(path, text); });
    for (const std::int64_t step : {10, 20, 30, 40}) write(step);
    EXPECT_EQ(read()->step, 40);
    on_root(comm, [&] {
        for (const std::int64_t step : {1, 5, 30, 1000})
            for (const char* ending : {"", ".tmp"}) {
                const std::string path = path_of(step) + ending;
                EXPECT_EQ(read_file(step == 30 ? path + ".foreign" : path), text) << path;
            }
    });
}

TEST_F(CheckpointTest, finds_nothing_in_an_empty_directory_and_clears_unfinished_files) {
    damage(path_of(5) + ".tmp",
           [](const std::string& path) { write_file(path, "\x89HDF\r\n\x1a\ncut off by a kill"); });
    EXPECT_FALSE(read());
    EXPECT_TRUE(names().empty());
}

TEST_F(CheckpointTest, takes_a_scene_of_any_length) {
    const std::string long_scene = "{\"text\":\"" + std::string(300000, 'x') + "\"}";
    write(1, long_scene);
    EXPECT_EQ(read(long_scene)->scene, long_scene);
}

TEST_F(CheckpointTest, refuses_a_state_that_is_not_the_announced_one) {
    write(1);
    const auto wrong = digest_at(2) + 1;
    const auto text = error_of<IoError>([&] {
        write_checkpoint(comm, directory.path(), groups, rods, {2, 0.001, wrong, scene, {}});
    });
    EXPECT_NE(text.find("checkpoint_000000000002"), text.npos) << text;
    EXPECT_EQ(names(), std::vector<std::string>{"checkpoint_000000000001.h5"});
}

TEST_F(CheckpointTest, of_another_scene_is_refused_with_the_keys_that_differ) {
    write(7);
    const auto text = error_of<InputError>(
        [&] { read(R"({"rods":[{"name":"cilia","length":2.0}],"title":"new","time":{"dt":0.001}})"); });
    EXPECT_NE(text.find(path_of(7)), text.npos) << text;
    EXPECT_NE(text.find("/rods/0/length: was 1.0, now 2.0"), text.npos) << text;
    EXPECT_NE(text.find("/title: was absent, now \"new\""), text.npos) << text;
    EXPECT_EQ(text.find("/time/dt"), text.npos) << text;
    const auto long_text = error_of<InputError>([&] { read(R"({"list":[1,2,3,4,5,6,7,8,9,10,11,12]})"); });
    EXPECT_NE(long_text.find("and 7 more"), long_text.npos) << long_text;
}

TEST_F(CheckpointTest, that_is_damaged_is_named_and_the_one_before_used) {
    write(1);
    write(2);
    const auto expected = digest_at(1);
    const auto garbage = [](const std::string& path) { write_file(path, std::string(5000, '?')); };
    const auto empty = [](const std::string& path) { write_file(path, ""); };
    const auto zeros = [](const std::string& path) { write_file(path, std::string(fs::file_size(path), '\0')); };
    const auto other_hdf5 = [](const std::string& path) { fs::resize_file(path, fs::file_size(path) / 2); };
    for (const auto& change : std::vector<std::function<void(const std::string&)>>{garbage, empty, zeros, other_hdf5}) {
        damage(path_of(2), change);
        const auto info = read();
        ASSERT_TRUE(info);
        EXPECT_EQ(info->step, 1);
        EXPECT_EQ(digest(), expected);
        if (!comm.root()) continue;
        ASSERT_EQ(warnings.size(), 1u);
        EXPECT_NE(warnings[0].find(path_of(2)), std::string::npos) << warnings[0];
    }
    damage(path_of(1), garbage);
    const auto text = error_of<IoError>([&] { read(); });
    EXPECT_NE(text.find("none of its 2 checkpoints"), text.npos) << text;
}

/// Damage of a random kind, tried many times: never a wrong state.
struct DamagedCheckpointTest : CheckpointTest {
    std::string sound; ///< root's: the newest file
    std::uint64_t newest = 0, previous = 0;
    int refused = 0;

    void SetUp() override {
        write(1);
        const auto whole = digest_at(2);
        write_checkpoint(comm, directory.path(), groups, rods, {2, 0.001, whole, scene, {}, 0.25});
        previous = digest_at(1);
        newest = digest_at(2);
        on_root(comm, [&] { sound = read_file(path_of(2)); });
    }
    void try_damaged(const std::string& bytes, const std::string& what) {
        on_root(comm, [&] { write_file(path_of(2), bytes); });
        const auto info = read();
        ASSERT_TRUE(info) << what;
        ASSERT_EQ(digest(), info->step == 2 ? newest : previous) << what;
        ASSERT_EQ(info->digest, info->step == 2 ? newest : previous) << what;
        ASSERT_EQ(info->dt, 0.001) << what;
        ASSERT_EQ(info->audited_from.value_or(0), info->step == 2 ? 0.25 : 0.0) << what;
        for (std::size_t i = 0; info->step == 2 && i < rods.local().size(); ++i)
            ASSERT_EQ(rods.budget(i).walls, test::FakeRods::fake_budget(rods.local()[i].gid, 2).walls) << what;
        if (info->step != 2) ++refused;
        if (!comm.root()) return;
        ASSERT_EQ(warnings.size(), info->step == 2 ? 0u : 1u) << what;
        for (const auto& warning : warnings) ASSERT_NE(warning.find(path_of(2)), std::string::npos) << warning;
    }
};

TEST_F(DamagedCheckpointTest, truncated_files_are_refused) {
    std::mt19937 random(3);
    for (int i = 0; i < 50; ++i) {
        const auto length = comm.root() ? random() % sound.size() : 0;
        ASSERT_NO_FATAL_FAILURE(
            try_damaged(comm.root() ? sound.substr(0, length) : "", "cut to " + std::to_string(length)));
    }
    EXPECT_EQ(refused, 50);
}

TEST_F(DamagedCheckpointTest, flipped_bytes_are_refused_or_harmless) {
    std::mt19937 random(5);
    for (int i = 0; i < 200; ++i) {
        std::string bytes = sound;
        std::string what;
        if (comm.root()) {
            const auto place =
                random() %
                (i % 2 ? sound.size() : std::min<std::size_t>(sound.size(), 3000)); // every other one in metadata
            bytes[place] = static_cast<char>(bytes[place] ^ static_cast<char>(1 + random() % 255));
            what = "byte " + std::to_string(place);
        }
        ASSERT_NO_FATAL_FAILURE(try_damaged(bytes, what));
    }
    EXPECT_GT(refused, 120);
    if (comm.root()) std::printf("%d of 200 flips refused\n", refused);
}

TEST_F(CheckpointTest, full_disk_is_an_error_with_figures_and_leaves_the_old_ones) {
    const test::SmallDisk disk(comm, "4m");
    if (!disk.mounted()) GTEST_SKIP() << "mounting a small tmpfs is not permitted here";
    const std::vector<RodGroup> many = test::two_groups(4200, 1); // 2.6 MB
    test::FakeRods rods_of_many(many, partition(comm, many));
    const auto write_many = [&](std::int64_t step) {
        rods_of_many.set(step);
        write_checkpoint(comm, disk.path(), many, rods_of_many,
                         {step, 0.001, comm.sum_wrapping(rods_of_many.digest()), scene, {}});
    };
    write_many(1);
    const auto text = error_of<IoError>([&] { write_many(2); });
    EXPECT_NE(text.find("disk full: 2."), text.npos) << text;
    EXPECT_NE(text.find("MB available"), text.npos) << text;
    EXPECT_EQ(disk.names(), std::vector<std::string>{"checkpoint_000000000001.h5"});
}

TEST_F(CheckpointTest, room_that_no_figure_shows_is_missing_is_found_out_before_writing) {
    const test::SmallDisk disk(comm, "4m");
    if (!disk.mounted()) GTEST_SKIP() << "mounting a small tmpfs is not permitted here";
    const auto text = error_of<IoError>([&] {
        H5File file(comm, disk.path() + "/big.h5", H5File::Mode::create);
        file.reserve(8 << 20);
    });
    EXPECT_NE(text.find("big.h5: disk full: no room for a file of 8."), text.npos) << text;
}

} // namespace
} // namespace skein
