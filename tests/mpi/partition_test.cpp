#include "partition/partition.hpp"

#include "core/hilbert.hpp"
#include "skein/core/index.hpp"
#include "support/fake_rods.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>

namespace skein {

void PrintTo(const LocalRod& rod, std::ostream* out) {
    *out << "rod " << rod.gid << " (group " << rod.group << ", " << rod.index << ")";
}
static bool operator==(const LocalRod& a, const LocalRod& b) {
    return a.gid == b.gid && a.group == b.group && a.index == b.index;
}

namespace {

TEST(HilbertKey, visits_every_cell_once_and_goes_to_a_neighbour_each_time) {
    constexpr int side = 8;
    std::map<std::uint64_t, std::array<int, 3>> cells;
    for (int x = 0; x < side; ++x)
        for (int y = 0; y < side; ++y)
            for (int z = 0; z < side; ++z)
                cells[hilbert_key({(x + 0.5) / side, (y + 0.5) / side, (z + 0.5) / side})] = {x, y, z};
    ASSERT_EQ(cells.size(), static_cast<std::size_t>(side * side * side));
    for (auto cell = cells.begin(), next = std::next(cell); next != cells.end(); ++cell, ++next) {
        int distance = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) distance += std::abs(cell->second[axis] - next->second[axis]);
        EXPECT_EQ(distance, 1);
    }
}

TEST(HilbertKey, takes_points_on_and_beyond_the_faces) {
    EXPECT_EQ(hilbert_key({0, 0, 0}), 0u);
    EXPECT_EQ(hilbert_key({1, 1, 1}), hilbert_key({2, 3, 1e300}));
    EXPECT_EQ(hilbert_key({-1, -1e300, 0}), 0u);
    EXPECT_LT(hilbert_key({1, 0, 0}), 1ull << 63);
}

/// The same by one sort of everything.
std::vector<LocalRod> serial_twin(std::span<const RodGroup> groups, int rank, int ranks) {
    struct Rod {
        std::uint64_t key;
        LocalRod rod;
        std::int64_t weight;
    };
    constexpr double infinity = std::numeric_limits<double>::infinity();
    Vec3d low{infinity, infinity, infinity}, high{-infinity, -infinity, -infinity};
    for (const RodGroup& group : groups)
        for (std::int64_t i = 0; i < group.count(); ++i) {
            const Vec3d c = group.centre(i);
            low = {std::min(low.x, c.x), std::min(low.y, c.y), std::min(low.z, c.z)};
            high = {std::max(high.x, c.x), std::max(high.y, c.y), std::max(high.z, c.z)};
        }
    const double side = std::max({high.x - low.x, high.y - low.y, high.z - low.z});
    std::vector<Rod> rods;
    std::int64_t whole = 0;
    for (const RodGroup& group : groups)
        for (std::int64_t i = 0; i < group.count(); ++i) {
            const Vec3d d = group.centre(i) - low;
            const auto key = side > 0 ? hilbert_key({d.x / side, d.y / side, d.z / side}) : 0;
            rods.push_back({key, {group.first_gid() + i, group.id(), i}, group.elements()});
            whole += group.elements();
        }
    std::sort(rods.begin(), rods.end(),
              [](const Rod& a, const Rod& b) { return std::pair(a.key, a.rod.gid) < std::pair(b.key, b.rod.gid); });
    std::vector<LocalRod> mine;
    std::int64_t before = 0;
    for (const Rod& rod : rods) {
        if (before >= whole * rank / ranks && (rank + 1 == ranks || before < whole * (rank + 1) / ranks))
            mine.push_back(rod.rod);
        before += rod.weight;
    }
    std::stable_sort(mine.begin(), mine.end(), [](const LocalRod& a, const LocalRod& b) { return a.group < b.group; });
    return mine;
}

struct PartitionTest : testing::Test {
    const Communicator comm = Communicator::world();

    void expect_sound(std::span<const RodGroup> groups) const {
        const auto mine = partition(comm, groups);
        EXPECT_EQ(mine, serial_twin(groups, comm.rank(), comm.size()));

        std::int64_t count = 0, whole = 0, heaviest = 0, weight = 0;
        for (const RodGroup& group : groups) {
            count += group.count();
            whole += group.count() * group.elements();
            heaviest = std::max<std::int64_t>(heaviest, group.elements());
        }
        std::vector<std::int64_t> owners(static_cast<std::size_t>(count), 0);
        for (const LocalRod& rod : mine) {
            ++nth(owners, rod.gid);
            weight += nth(groups, rod.group).elements();
        }
        comm.sum(owners);
        EXPECT_EQ(owners, std::vector<std::int64_t>(static_cast<std::size_t>(count), 1));
        EXPECT_LE(std::abs(weight * comm.size() - whole), heaviest * comm.size());
    }
};

RodSpec lattice(std::vector<long> counts, long elements) {
    RodSpec spec = test::two_groups(1, 1)[1].spec();
    spec.shape.elements = elements;
    spec.placement.counts = std::move(counts);
    spec.placement.spacing.assign(spec.placement.counts.size(), 0.37);
    return spec;
}

TEST_F(PartitionTest, equals_its_serial_twin) {
    expect_sound(test::two_groups(100, 7));
    std::vector<RodGroup> groups;
    groups.emplace_back(lattice({11, 7, 5}, 20), 0, 0, "");
    expect_sound(groups);
    groups.emplace_back(lattice({5, 3}, 200), 1, groups[0].count(), "");
    groups.emplace_back(lattice({64, 2}, 3), 2, groups[0].count() + groups[1].count(), "");
    expect_sound(groups);
}

TEST_F(PartitionTest, copes_with_fewer_rods_than_ranks) {
    for (const long count : {1, 2, 3}) {
        std::vector<RodGroup> groups;
        groups.emplace_back(lattice({count, 1}, 10), 0, 0, "");
        expect_sound(groups);
    }
}

TEST_F(PartitionTest, shares_out_rods_that_stand_at_one_point) {
    RodSpec spec = lattice({1, 1}, 10);
    spec.placement.kind = PlacementKind::list;
    spec.placement.counts.clear();
    spec.placement.spacing.clear();
    spec.placement.origins.assign(50, {1, 2, 3});
    std::vector<RodGroup> groups;
    groups.emplace_back(spec, 0, 0, "");
    expect_sound(groups);
}

/// Rods on a helix, each with its own direction; counts how many were asked for.
class Helix final : public RodSource {
public:
    explicit Helix(std::int64_t count) : count_(count) {}
    std::int64_t count() const override { return count_; }
    RodColumns columns() const override { return {.tangent = true}; }
    RodRows read(std::int64_t begin, std::int64_t end, const Threads*) const override {
        RodRows rows;
        for (std::int64_t i = begin; i < end; ++i) {
            rows.origins.push_back(origin(i));
            rows.tangents.push_back({1, 0.01 * double(i), 2});
        }
        asked += end - begin;
        return rows;
    }
    static Vec3d origin(std::int64_t i) {
        return {std::cos(0.1 * double(i)), std::sin(0.1 * double(i)), 0.01 * double(i)};
    }
    mutable std::int64_t asked = 0;

private:
    std::int64_t count_;
};

TEST_F(PartitionTest, of_a_file_every_rank_reads_its_block_and_keeps_its_own) {
    RodSpec spec = lattice({1, 1}, 10);
    spec.placement = {.kind = PlacementKind::list};
    for (std::int64_t i = 0; i < 1001; ++i) {
        spec.placement.origins.push_back(Helix::origin(i));
        spec.placement.tangents.push_back({1, 0.01 * double(i), 2});
    }
    std::vector<RodGroup> list, file;
    list.emplace_back(spec, 0, 0, "");
    spec.placement = {.kind = PlacementKind::file};
    const auto helix = std::make_shared<Helix>(1001);
    file.emplace_back(spec, 0, 0, "", nullptr, helix);
    read_rods(comm, file);
    EXPECT_EQ(comm.sum(helix->asked), 1001);
    const auto own = partition(comm, file);
    EXPECT_EQ(own, partition(comm, list));
    keep_own_rods(comm, file, own);
    const Places& places = file[0].places();
    const Places all = list[0].places();
    EXPECT_GE(places.bytes(), own.size() * places.record_bytes());
    EXPECT_LE(places.bytes(),
              own.size() * (places.record_bytes() + sizeof(std::int64_t))); // their numbers, if not consecutive
    EXPECT_EQ(comm.sum_wrapping(places.digest()), all.digest());
    EXPECT_EQ(file[0].file_digest(), all.digest());
    keep_own_rods(comm, list, own);
    for (const LocalRod& rod : own) {
        EXPECT_EQ(norm(places.origin(rod.index) - Helix::origin(rod.index)), 0);
        EXPECT_EQ(places.turn(rod.index).w, list[0].places().turn(rod.index).w);
    }
    EXPECT_EQ(list[0].places().bytes(), places.bytes());
    RodGroup whole(spec, 0, 0, "", nullptr, helix);
    whole.read_all();
    EXPECT_EQ(whole.file_digest(), all.digest());
}

TEST_F(PartitionTest, places_of_lattices_take_no_memory) {
    const RodGroup group(lattice({11, 7, 5}, 3), 0, 0, "");
    EXPECT_EQ(group.places().bytes(), 0u);
    EXPECT_EQ(group.count(), 385);
    for (std::int64_t i = 0, z = 0; z < 5; ++z)
        for (int y = 0; y < 7; ++y)
            for (int x = 0; x < 11; ++x, ++i)
                EXPECT_EQ(norm(group.origin(i) -
                               (Vec3d{0.37 * x, 0.37 * y, 0.37 * double(z)} + group.spec().placement.origin)),
                          0);
}

TEST_F(PartitionTest, is_foretold_by_one_rank) {
    std::vector<RodGroup> groups;
    groups.emplace_back(lattice({11, 7, 5}, 3), 0, 0, "");
    groups.emplace_back(lattice({5, 6, 2}, 9), 1, groups[0].count(), "");
    const std::vector<int> foretold = owners(groups, comm.size());
    std::int64_t mine = 0;
    for (const LocalRod& rod : partition(comm, groups)) {
        EXPECT_EQ(nth(foretold, rod.gid), comm.rank());
        ++mine;
    }
    EXPECT_EQ(std::count(foretold.begin(), foretold.end(), comm.rank()), mine);
}

TEST(OwnerDirectory, finds_owners_and_blocks) {
    const auto comm = Communicator::world();
    for (const std::int64_t bodies : {std::int64_t{1}, std::int64_t{3}, std::int64_t{200}}) {
        const auto owner_of = [&](std::int64_t gid) { return static_cast<int>((7 * gid + gid / 3) % comm.size()); };
        std::vector<std::int64_t> own;
        for (std::int64_t gid = 0; gid < bodies; ++gid)
            if (owner_of(gid) == comm.rank()) own.push_back(gid);
        const OwnerDirectory directory(comm, own, bodies);
        struct Record {
            std::int64_t gid, from, number;
        };
        std::vector<Record> records;
        std::vector<std::int64_t> gids;
        for (std::int64_t i = 0; i < 50 + comm.rank(); ++i) {
            gids.push_back((7 * i + comm.rank()) % bodies);
            records.push_back({gids.back(), comm.rank(), i});
        }
        const auto received = [](const std::vector<std::byte>& bytes) {
            std::vector<Record> all(bytes.size() / sizeof(Record));
            if (!all.empty()) std::memcpy(all.data(), bytes.data(), bytes.size());
            return all;
        };
        const auto sent = std::as_bytes(std::span(records));
        std::int64_t count = 0;
        for (const Record& record : received(directory.to_owners(sent, sizeof(Record), gids))) {
            EXPECT_EQ(owner_of(record.gid), comm.rank());
            EXPECT_EQ((7 * record.number + record.from) % bodies, record.gid);
            ++count;
        }
        EXPECT_EQ(comm.sum(count), comm.sum(static_cast<std::int64_t>(records.size())));
        count = 0;
        for (const Record& record : received(directory.to_blocks(sent, sizeof(Record), gids))) {
            EXPECT_GE(record.gid, block_begin(bodies, comm.rank(), comm.size()));
            EXPECT_LT(record.gid, block_begin(bodies, comm.rank() + 1, comm.size()));
            ++count;
        }
        EXPECT_EQ(comm.sum(count), comm.sum(static_cast<std::int64_t>(records.size())));
    }
}

TEST(BlockBegin, deals_out_evenly_without_overflow) {
    EXPECT_EQ(block_begin(10, 0, 4), 0);
    EXPECT_EQ(block_begin(10, 1, 4), 2);
    EXPECT_EQ(block_begin(10, 4, 4), 10);
    EXPECT_EQ(block_begin(std::int64_t{1} << 60, 1000, 1024), (std::int64_t{1} << 50) * 1000);
}

struct IndexBlocksTest : testing::TestWithParam<std::int64_t> {
    const Communicator comm = Communicator::world();
};

TEST_P(IndexBlocksTest, go_there_and_back) {
    struct Record {
        std::int64_t index;
        double values[2];
    };
    const std::int64_t count = GetParam();
    std::vector<std::int64_t> owned;
    for (std::int64_t i = count - 1; i >= 0; --i)
        if ((i * i + i / 3) % comm.size() == comm.rank()) owned.push_back(i);
    std::vector<Record> records;
    for (const auto i : owned) records.push_back({i, {0.5 * static_cast<double>(i), -1}});

    const IndexBlocks blocks(comm, owned, count);
    EXPECT_EQ(blocks.begin(), block_begin(count, comm.rank(), comm.size()));
    EXPECT_EQ(comm.sum(blocks.size()), count);
    RecordBuffers buffers;
    buffers.begin(blocks, 1); // for smaller records before: what is left of them does no harm
    for (std::size_t i = 0; i < records.size(); ++i) *buffers.record(i) = std::byte{7};
    buffers.exchange();
    buffers.begin(blocks, sizeof(Record));
    for (std::size_t i = 0; i < records.size(); ++i) std::memcpy(buffers.record(i), &records[i], sizeof(Record));
    const auto block = buffers.exchange();
    ASSERT_EQ(block.size(), static_cast<std::size_t>(blocks.size()) * sizeof(Record));
    for (std::int64_t i = 0; i < blocks.size(); ++i) {
        Record record;
        std::memcpy(&record, &block[static_cast<std::size_t>(i) * sizeof record], sizeof record);
        EXPECT_EQ(record.index, blocks.begin() + i);
        EXPECT_EQ(record.values[0], 0.5 * static_cast<double>(record.index));
    }
    const auto back = blocks.to_owners(block, sizeof(Record));
    ASSERT_EQ(back.size(), records.size() * sizeof(Record));
    EXPECT_TRUE(back.empty() || std::memcmp(back.data(), records.data(), back.size()) == 0);
}

INSTANTIATE_TEST_SUITE_P(Counts, IndexBlocksTest, testing::Values(0, 1, 2, 3, 7, 1000));

} // namespace
} // namespace skein
