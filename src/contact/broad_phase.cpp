#include "contact/broad_phase.hpp"

#include "contact/closest_points.hpp"
#include "parallel/blocks.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace skein {

namespace {

Vec3d middle(const Capsules& c, std::size_t slot) { return 0.5 * (c.node[slot].position + c.node[slot + 1].position); }
double half_length(const Capsules& c, std::size_t slot) { return 0.5 * norm(c.node[slot + 1].position - c.node[slot].position); }

/// Keeps of a list of pairs those whose capsules are less than `skin` apart. `pairs` has room for one tile more.
std::size_t keep_near(const Capsules& c, double skin, Pair* pairs, std::size_t count) {
    constexpr int W = 8;
    using P = Pack<W>;
    if (count == 0) return 0;
    std::fill(pairs + count, pairs + count + W, pairs[count - 1]);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count; i += W) {
        Pair tile[W];
        std::copy(pairs + i, pairs + i + W, tile);
        const double* nodes[4][W];
        for (int l = 0; l < W; ++l) {
            const CapsuleNode *a = &c.node[tile[l].a], *b = &c.node[tile[l].b];
            nodes[0][l] = &a->position.x, nodes[1][l] = &(a + 1)->position.x, nodes[2][l] = &b->position.x, nodes[3][l] = &(b + 1)->position.x;
        }
        const auto a = load_transposed<W>(nodes[0]), a_end = load_transposed<W>(nodes[1]), b = load_transposed<W>(nodes[2]), b_end = load_transposed<W>(nodes[3]);
        const Vec3<P> apart = closest_points(a.vector, a_end.vector - a.vector, b.vector, b_end.vector - b.vector).apart;
        const P reach = a.behind + b.behind + P(skin);
        const auto near = dot(apart, apart) < reach * reach;
        for (int l = 0; l < W; ++l) {
            pairs[kept] = tile[l];
            kept += near[l] && i + static_cast<std::size_t>(l) < count;
        }
    }
    return kept;
}

} // namespace

/// What a task has found: runs of partners, one run for each of its elements that have any.
struct BroadPhase::Block {
    struct Run {
        std::uint32_t a, count;
    };
    std::vector<Run> runs;
    std::vector<Pair> pairs; ///< of the runs, and what is left from before

    void clear() { runs.clear(); }
};

/// The elements of a cell and its neighbours, side by side.
class BroadPhase::Neighbourhood {
public:
    void clear() { count_ = 0; }
    void append(const BroadPhase& from, std::uint32_t begin, std::uint32_t end) {
        if (begin == end) return;
        const std::size_t more = end - begin, room = count_ + more + 16;
        if (room > slot_.size()) {
            for (auto* component : {&x_, &y_, &z_, &reach_}) component->resize(2 * room);
            slot_.resize(2 * room);
        }
        const auto copy = [&](const auto& source, auto& target) { // in sixteens: rows are short, and calls cost more than numbers
            for (std::size_t i = 0; i < more; i += 16) std::memcpy(&target[count_ + i], &source[begin + i], 64);
        };
        copy(from.x_, x_), copy(from.y_, y_), copy(from.z_, z_), copy(from.reach_, reach_), copy(from.slot_, slot_);
        count_ += more;
    }
    /// Those whose spheres touch one at x, y, z of radius `reach`. `out` has room for all and 16 more.
    std::size_t touching(float x, float y, float z, float reach, std::uint32_t* out) const {
        std::size_t found = 0;
#if defined(__AVX512F__)
        for (std::size_t i = 0; i < count_; i += 16) {
            const auto less = [i](const AlignedVector<float>& v, float by) { return _mm512_sub_ps(_mm512_loadu_ps(&v[i]), _mm512_set1_ps(by)); };
            const __m512 dx = less(x_, x), dy = less(y_, y), dz = less(z_, z), r = less(reach_, -reach);
            const __m512 squared = _mm512_fmadd_ps(dx, dx, _mm512_fmadd_ps(dy, dy, _mm512_mul_ps(dz, dz)));
            const auto inside = static_cast<__mmask16>(count_ - i >= 16 ? 0xffffu : (1u << (count_ - i)) - 1);
            const __mmask16 near = _mm512_mask_cmp_ps_mask(inside, squared, _mm512_mul_ps(r, r), _CMP_LT_OQ);
            _mm512_storeu_si512(out + found, _mm512_maskz_compress_epi32(near, _mm512_loadu_si512(&slot_[i])));
            found += static_cast<std::size_t>(std::popcount(static_cast<unsigned>(near)));
        }
#else
        for (std::size_t i = 0; i < count_; ++i) {
            const float dx = x_[i] - x, dy = y_[i] - y, dz = z_[i] - z, r = reach_[i] + reach;
            out[found] = slot_[i];
            found += dx * dx + dy * dy + dz * dz < r * r;
        }
#endif
        return found;
    }
    std::size_t count() const { return count_; }

private:
    AlignedVector<float> x_, y_, z_, reach_;
    AlignedVector<std::uint32_t> slot_;
    std::size_t count_ = 0;
};

BroadPhase::BroadPhase(const Capsules& capsules, const Threads& threads) : threads_(threads), grid_of_(capsules.slots(), 0) {
    double least = std::numeric_limits<double>::infinity();
    const auto size = [&](std::size_t s) { return half_length(capsules, s) + capsules.node[s].radius; };
    for (std::size_t s = 0; s < capsules.slots(); ++s)
        if (capsules.has_element(s)) least = std::min(least, size(s));
    std::uint8_t most = 0;
    for (std::size_t s = 0; s < capsules.slots(); ++s)
        if (capsules.has_element(s)) most = std::max(most, grid_of_[s] = static_cast<std::uint8_t>(std::min(31.0, std::log2(size(s) / least))));
    grids_.resize(static_cast<std::size_t>(most) + 1);
}

void BroadPhase::size_grids(const Capsules& capsules, double skin) {
    struct Extent {
        Vec3d least{HUGE_VAL, HUGE_VAL, HUGE_VAL}, most{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
        double reach[32] = {};
        std::size_t count[32] = {};
    };
    std::vector<Extent> parts(blocks_of(capsules.slots()));
    for_blocks(threads_, capsules.slots(), [&](std::size_t begin, std::size_t end, std::size_t block) {
        Extent& e = parts[block];
        for (std::size_t s = begin; s < end; ++s) {
            if (!capsules.has_element(s)) continue;
            const Vec3d m = middle(capsules, s);
            e.least = {std::min(e.least.x, m.x), std::min(e.least.y, m.y), std::min(e.least.z, m.z)};
            e.most = {std::max(e.most.x, m.x), std::max(e.most.y, m.y), std::max(e.most.z, m.z)};
            e.reach[grid_of_[s]] = std::max(e.reach[grid_of_[s]], half_length(capsules, s) + capsules.node[s].radius + 0.5 * skin);
            ++e.count[grid_of_[s]];
        }
    });
    Extent all;
    for (const Extent& e : parts) {
        all.least = {std::min(e.least.x, all.least.x), std::min(e.least.y, all.least.y), std::min(e.least.z, all.least.z)};
        all.most = {std::max(e.most.x, all.most.x), std::max(e.most.y, all.most.y), std::max(e.most.z, all.most.z)};
        for (std::size_t g = 0; g < 32; ++g) all.reach[g] = std::max(all.reach[g], e.reach[g]), all.count[g] += e.count[g];
    }
    origin_ = 0.5 * (all.least + all.most);
    const Vec3d extent = all.most - all.least;
    slack_ = static_cast<float>(4e-7 * std::max({extent.x, extent.y, extent.z}));

    double reach = 0;
    std::uint32_t cells = 0;
    for (std::size_t g = 0; g < grids_.size(); ++g) {
        Grid& grid = grids_[g];
        reach = std::max(reach, all.reach[g]);
        const double cell = 2 * (reach + slack_);
        grid.cells_per_metre = static_cast<float>(1 / cell);
        const double sides[3] = {extent.x, extent.y, extent.z};
        for (int i = 0; i < 3; ++i)
            grid.size[i] = std::bit_ceil(static_cast<std::uint32_t>(std::clamp(sides[i] / cell + 2, 4.0, 1048576.0)));
        const std::uint64_t most = std::max<std::uint64_t>(64, 4 * all.count[g]);
        while (std::uint64_t{grid.size[0]} * grid.size[1] * grid.size[2] > most) *std::max_element(grid.size, grid.size + 3) /= 2;
        grid.first_cell = cells;
        cells += grid.cells();
    }
    cell_begin_.assign(cells + 1, 0);
}

void BroadPhase::fill_grids(const Capsules& capsules) {
    const std::size_t slots = capsules.slots();
    cell_of_.resize(slots);
    std::vector<std::uint32_t> place(slots); // of an element among those of its cell
    for_blocks(threads_, slots, [&](std::size_t begin, std::size_t end, std::size_t) {
        for (std::size_t s = begin; s < end; ++s) {
            if (!capsules.has_element(s)) continue;
            const Grid& grid = grids_[grid_of_[s]];
            const Vec3d m = middle(capsules, s) - origin_;
            const auto cell = [&](double x, int i) { return cell_at(grid, static_cast<float>(x)) & (grid.size[i] - 1); };
            cell_of_[s] = grid.first_cell + (cell(m.z, 2) * grid.size[1] + cell(m.y, 1)) * grid.size[0] + cell(m.x, 0);
            place[s] = std::atomic_ref(cell_begin_[cell_of_[s]]).fetch_add(1, std::memory_order_relaxed);
        }
    });
    const std::uint32_t elements = begins_from_counts(threads_, cell_begin_);
    slot_.resize(elements + 16);
    for_blocks(threads_, slots, [&](std::size_t begin, std::size_t end, std::size_t) {
        for (std::size_t s = begin; s < end; ++s)
            if (capsules.has_element(s)) slot_[cell_begin_[cell_of_[s]] + place[s]] = static_cast<std::uint32_t>(s);
    });
    // In order within each cell, whichever thread came first.
    for_blocks(threads_, cell_begin_.size() - 1, [&](std::size_t begin, std::size_t end, std::size_t) {
        for (std::size_t cell = begin; cell < end; ++cell)
            if (cell_begin_[cell + 1] - cell_begin_[cell] > 1) std::sort(slot_.begin() + cell_begin_[cell], slot_.begin() + cell_begin_[cell + 1]);
    });
    for (auto* component : {&x_, &y_, &z_, &reach_}) component->resize(elements + 16); // read in sixteens
    for_blocks(threads_, elements, [&](std::size_t begin, std::size_t end, std::size_t) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::size_t s = slot_[i];
            const Vec3d m = middle(capsules, s) - origin_;
            x_[i] = static_cast<float>(m.x);
            y_[i] = static_cast<float>(m.y);
            z_[i] = static_cast<float>(m.z);
            reach_[i] = static_cast<float>(half_length(capsules, s) + capsules.node[s].radius);
        }
    });
}

void BroadPhase::collect(const Grid& grid, const std::uint32_t (&cell)[3], Neighbourhood& near) const {
    const std::uint32_t mask = grid.size[0] - 1, west = (cell[0] - 1) & mask, here = cell[0] & mask, east = (cell[0] + 1) & mask;
    near.clear();
    for (std::uint32_t dz = 0; dz < 3; ++dz)
        for (std::uint32_t dy = 0; dy < 3; ++dy) {
            const std::uint32_t z = (cell[2] + dz - 1) & (grid.size[2] - 1), y = (cell[1] + dy - 1) & (grid.size[1] - 1);
            const std::uint32_t* row = &cell_begin_[grid.first_cell + (z * grid.size[1] + y) * grid.size[0]];
            if (west < here && here < east) {
                near.append(*this, row[west], row[east + 1]);
            } else {
                for (const std::uint32_t c : {west, here, east}) near.append(*this, row[c], row[c + 1]);
            }
        }
}

void BroadPhase::look(const Capsules& capsules, double skin, const Grid& grid, std::uint32_t begin, std::uint32_t end, Block& block) const {
    Neighbourhood near, far;
    std::vector<std::uint32_t> touching;
    const float margin = static_cast<float>(skin) + slack_;
    block.clear();
    std::size_t count = 0;
    const auto take = [&](const Neighbourhood& among, std::uint32_t i, bool one_size) {
        if (among.count() + 16 > touching.size()) touching.resize(2 * (among.count() + 16));
        const std::size_t found = among.touching(x_[i], y_[i], z_[i], reach_[i] + margin, touching.data());
        if (count + found + 8 > block.pairs.size()) block.pairs.resize(2 * (count + found + 8));
        const std::uint32_t a = slot_[i];
        const auto rod = static_cast<std::size_t>(capsules.rod[a]);
        const auto own_first = static_cast<std::uint32_t>(capsules.first_slot[rod]), own_last = static_cast<std::uint32_t>(capsules.first_slot[rod + 1]);
        Pair* out = block.pairs.data();
        for (std::size_t t = 0; t < found; ++t) {
            const std::uint32_t b = touching[t];
            out[count] = {a, b};
            count += (b > a || !one_size) && (b < own_first || b >= own_last || capsules.may_touch(a, b));
        }
    };
    for (std::uint32_t c = begin; c < end; ++c) {
        const std::uint32_t* cell = &cell_begin_[grid.first_cell + c];
        if (cell[0] == cell[1]) continue;
        collect(grid, {c & (grid.size[0] - 1), c / grid.size[0] & (grid.size[1] - 1), c / grid.size[0] / grid.size[1]}, near);
        for (std::uint32_t i = cell[0]; i < cell[1]; ++i) {
            take(near, i, true);
            for (const Grid* coarser = &grid + 1; coarser < grids_.data() + grids_.size(); ++coarser) {
                const auto at = [&](float x) { return cell_at(*coarser, x); };
                collect(*coarser, {at(x_[i]), at(y_[i]), at(z_[i])}, far);
                take(far, i, false);
            }
        }
    }
    if (count == 0) return;
    count = keep_near(capsules, skin, block.pairs.data(), count);
    Pair* pairs = block.pairs.data();
    for (std::size_t begin = 0, end = 0; begin < count; begin = end) {
        while (end < count && pairs[end].a == pairs[begin].a) ++end;
        std::sort(pairs + begin, pairs + end);
        block.runs.push_back({pairs[begin].a, static_cast<std::uint32_t>(end - begin)});
    }
}

BroadPhase::~BroadPhase() = default;

void BroadPhase::build(const Capsules& capsules, double skin, Candidates& candidates) {
    size_grids(capsules, skin);
    fill_grids(capsules);
    struct Task {
        const Grid* grid;
        std::uint32_t begin, end; ///< cells
    };
    std::vector<Task> tasks;
    for (const Grid& grid : grids_)
        for (std::uint32_t c = 0; c < grid.cells(); c += block_size) tasks.push_back({&grid, c, std::min<std::uint32_t>(grid.cells(), c + block_size)});
    blocks_.resize(tasks.size());
    candidates.first.assign(capsules.slots() + 1, 0);
    threads_.for_each(tasks.size(), [&](std::size_t t, int) {
        look(capsules, skin, *tasks[t].grid, tasks[t].begin, tasks[t].end, blocks_[t]);
        for (const Block::Run& run : blocks_[t].runs) candidates.first[run.a] = run.count;
    });
    candidates.partner.resize(begins_from_counts(threads_, candidates.first));
    threads_.for_each(tasks.size(), [&](std::size_t t, int) {
        const Pair* pair = blocks_[t].pairs.data();
        for (const Block::Run& run : blocks_[t].runs)
            for (std::uint32_t i = 0; i < run.count; ++i) candidates.partner[candidates.first[run.a] + i] = (pair++)->b;
    });
}

void BroadPhase::build_exhaustively(const Capsules& capsules, double skin, const BroadPhase& sizes, Candidates& candidates) {
    const auto slots = static_cast<std::uint32_t>(capsules.slots());
    candidates.first.assign(slots + 1, 0);
    candidates.partner.clear();
    std::vector<Pair> pairs;
    for (std::uint32_t a = 0; a < slots; ++a) {
        candidates.first[a] = static_cast<std::uint32_t>(candidates.partner.size());
        if (!capsules.has_element(a)) continue;
        pairs.clear();
        for (std::uint32_t b = 0; b < slots; ++b)
            if (b != a && capsules.has_element(b) && sizes.comes_first(a, b) && capsules.may_touch(a, b)) pairs.push_back({a, b});
        const std::size_t count = pairs.size();
        pairs.resize(count + 8);
        pairs.resize(keep_near(capsules, skin, pairs.data(), count));
        for (const Pair& pair : pairs) candidates.partner.push_back(pair.b);
    }
    candidates.first[slots] = static_cast<std::uint32_t>(candidates.partner.size());
}

} // namespace skein
