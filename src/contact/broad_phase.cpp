#include "contact/broad_phase.hpp"

#include "contact/capsule_tiles.hpp"
#include "contact/group.hpp"
#include "contact/vertices.hpp"
#include "core/closest_points.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace skein {

namespace {

Vec3d middle(const Exposure& c, std::size_t slot) { return 0.5 * (c.node[slot].position + c.node[slot + 1].position); }
/// Half length, m, with the reach beyond vertices at both ends even if only one has a vertex.
double half_length(const Exposure& c, std::size_t slot) {
    const double half = c.vertices[slot] ? 0.5 + c.scene().searched_reach() : 0.5;
    return half * norm(c.node[slot + 1].position - c.node[slot].position);
}
Vec3d least_of(const Vec3d& a, const Vec3d& b) { return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)}; }
Vec3d most_of(const Vec3d& a, const Vec3d& b) { return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)}; }

} // namespace

/// Appends the pairs (a[i], b[i]) that may touch, with capsules less than `skin` apart and one element of an own body.
/// Both arrays have room for a tile more. The lower slot comes first before any arithmetic, so all ranks find the same
/// bits.
void BroadPhase::append_near(const Exposure& c, const SelfGaps& gaps, double skin, std::uint32_t* a, std::uint32_t* b,
                             std::size_t count, Near& near) {
    constexpr std::size_t W = CapsuleTile::width;
    if (count == 0) return;
    std::fill(a + count, a + count + W, a[0]);
    std::fill(b + count, b + count + W, b[0]);
    for (std::size_t i = 0; i < count + W; ++i) {
        const std::uint32_t low = std::min(a[i], b[i]), high = std::max(a[i], b[i]);
        a[i] = low;
        b[i] = high;
    }
    const auto node = [&](std::uint32_t slot) { return &c.node[slot]; };
    for_capsule_tiles(
        count, [&](std::size_t i) { return std::pair(node(a[i]), node(b[i])); },
        [&](std::size_t i) {
            const ExposedNode* later = node(b[std::min(i + 64, count)]);
            __builtin_prefetch(later);
            __builtin_prefetch(later + 1);
        },
        [&](std::size_t i, const CapsuleTile& tile) {
            std::uint8_t vertices[W];
            for (std::size_t l = 0; l < W; ++l) vertices[l] = vertices_of_pair(c, {a[i + l], b[i + l]});
            const auto apart =
                closest_points(tile.p, tile.d1, tile.q, tile.d2, range_of(vertices, 0, c.scene().searched_reach()),
                               range_of(vertices, 1, c.scene().searched_reach()))
                    .apart;
            const auto both = tile.radius_1 + tile.radius_2, reach = both + Pack<W>(skin), squared = dot(apart, apart);
            unsigned bits = bits_of(squared < reach * reach) & (count - i < W ? (1u << (count - i)) - 1 : 0xffu);
            const unsigned touching = bits_of(squared < both * both);
            for (; bits != 0; bits &= bits - 1) {
                const int lane = std::countr_zero(bits);
                const std::size_t l = i + to_index(lane);
                if (!may_touch(c, gaps, a[l], b[l])) continue;
                const bool own = c.owns_slot(a[l]);
                if (!own && !c.owns_slot(b[l])) continue;
                near.inactive += own & ~touching >> lane & 1;
                near.pairs.push_back({a[l], b[l]});
            }
        });
}

/// Ranges of elements, in order of cells, that a search looks at.
struct BroadPhase::Ranges {
    Range range[27];
    int count = 0;
    void add(std::uint32_t begin, std::uint32_t end) {
        if (begin < end) range[count++] = {begin, end};
    }
};

/// The elements of ranges side by side, if they are few: ranges are short, and each costs as much as sixteen spheres.
struct BroadPhase::Copies {
    static constexpr std::uint32_t most = 512;
    float x[most + 16], y[most + 16], z[most + 16], reach[most + 16];
    std::int32_t body[most + 16];
    std::uint32_t slot[most + 16];
    std::uint32_t count = 0;

    bool take(const Spheres& from, const Ranges& ranges) {
        count = 0;
        for (int r = 0; r < ranges.count; ++r) {
            const auto [begin, end] = ranges.range[r];
            if (count + (end - begin) > most) return false;
            for (std::uint32_t i = begin, to = count; i < end; i += 16, to += 16) { // in sixteens, beyond the end
                std::memcpy(x + to, from.x + i, 64);
                std::memcpy(y + to, from.y + i, 64);
                std::memcpy(z + to, from.z + i, 64);
                std::memcpy(reach + to, from.reach + i, 64);
                std::memcpy(body + to, from.body + i, 64);
                std::memcpy(slot + to, from.slot + i, 64);
            }
            count += end - begin;
        }
        return true;
    }
    Spheres spheres() const { return {x, y, z, reach, body, slot}; }
};

/// Pairs whose spheres meet, on their way to those whose capsules do.
struct BroadPhase::Found {
    static constexpr std::size_t most = 1024;
    const Exposure& bodies;
    const SelfGaps& gaps;
    double skin;
    Near& near;
    std::size_t count = 0;
    std::uint32_t a[most + 32], b[most + 32];

    void flush() {
        append_near(bodies, gaps, skin, a, b, count, near);
        count = 0;
    }
};

std::uint32_t BroadPhase::Grid::cell_at(float x) const {
    return static_cast<std::uint32_t>(static_cast<std::int32_t>(std::floor(x * cells_per_metre)));
}

BroadPhase::BroadPhase(const Threads& threads) : threads_(threads) {}
BroadPhase::~BroadPhase() = default;

/// Sizes of the first search, by which later ones are measured.
void BroadPhase::find_sizes(const Exposure& bodies) {
    smallest_ = std::numeric_limits<double>::infinity();
    Vec3d least{HUGE_VAL, HUGE_VAL, HUGE_VAL}, most = -least;
    for (std::size_t s = 0; s < bodies.slots(); ++s) {
        if (!bodies.has_element(s)) continue;
        const Vec3d m = middle(bodies, s);
        least = least_of(least, m);
        most = most_of(most, m);
        smallest_ = std::min(smallest_, half_length(bodies, s) + bodies.node[s].radius);
    }
    const Vec3d centre = 0.5 * (least + most);
    if (std::isfinite(dot(centre, centre))) next_origin_ = centre;
}

/// Extent of all elements from origin_, m, with the reach and the number of those of each size.
struct BroadPhase::Extent {
    static constexpr std::size_t sizes = 32; ///< powers of two
    Vec3d least{HUGE_VAL, HUGE_VAL, HUGE_VAL}, most{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    double reach[sizes] = {};
    std::size_t count[sizes] = {};

    void add(const Extent& other) {
        least = least_of(other.least, least);
        most = most_of(other.most, most);
        for (std::size_t g = 0; g < sizes; ++g) {
            reach[g] = std::max(reach[g], other.reach[g]);
            count[g] += other.count[g];
        }
    }
};

/// Sets the spheres round elements and the grids that these belong to.
BroadPhase::Extent BroadPhase::set_spheres(const Exposure& bodies) {
    std::vector<Extent> parts(blocks_of(bodies.slots()));
    for_blocks(threads_, bodies.slots(), [&](std::size_t begin, std::size_t end, std::size_t block) {
        Extent& e = parts[block];
        for (std::size_t s = begin; s < end; ++s) {
            if (!bodies.has_element(s)) continue;
            const Vec3d m = middle(bodies, s) - origin_;
            const double reach = half_length(bodies, s) + bodies.node[s].radius;
            grid_of_[s] = static_cast<std::uint8_t>(std::clamp(std::ilogb(reach / smallest_), 0, 31));
            sphere_[s] = {static_cast<float>(m.x), static_cast<float>(m.y), static_cast<float>(m.z),
                          static_cast<float>(reach)};
            e.least = least_of(e.least, m);
            e.most = most_of(e.most, m);
            e.reach[grid_of_[s]] = std::max(e.reach[grid_of_[s]], reach);
            ++e.count[grid_of_[s]];
        }
    });
    Extent all;
    for (const Extent& e : parts) all.add(e);
    return all;
}

/// Cells as wide as two of the largest elements reach, and no more than four to an element.
void BroadPhase::size_grids(const Extent& all, double skin) {
    const Vec3d extent = all.most - all.least;
    std::uint32_t cells = 0;
    double reach = 0;
    for (std::size_t g = 0; g < grids_.size(); ++g) {
        Grid& grid = grids_[g];
        reach = std::max(reach, all.reach[g]);
        const double cell = 2 * (reach + 0.5 * skin + slack_);
        grid.cells_per_metre = static_cast<float>(1 / cell);
        const double sides[3] = {extent.x, extent.y, extent.z};
        for (int i = 0; i < 3; ++i)
            grid.size[i] = std::bit_ceil(static_cast<std::uint32_t>(std::clamp(sides[i] / cell + 2, 4.0, 1048576.0)));
        const std::uint64_t most = std::max<std::uint64_t>(64, 4 * all.count[g]);
        while (std::uint64_t{grid.size[0]} * grid.size[1] * grid.size[2] > most)
            *std::max_element(grid.size, grid.size + 3) /= 2;
        grid.first_cell = cells;
        cells += grid.cells();
    }
    cell_begin_.assign(cells + 1, 0);
}

void BroadPhase::measure(const Exposure& bodies, double skin) {
    if (smallest_ == 0) find_sizes(bodies);
    origin_ = next_origin_;
    sphere_.resize(bodies.slots());
    grid_of_.resize(bodies.slots());
    const Extent all = set_spheres(bodies);
    std::size_t coarsest = Extent::sizes - 1;
    while (coarsest > 0 && all.count[coarsest] == 0) --coarsest;
    grids_.resize(coarsest + 1);
    next_origin_ = origin_ + 0.5 * (all.least + all.most); // next time; what moves meanwhile counts in the slack
    const Vec3d outermost = most_of(-all.least, all.most);
    const double reach = *std::max_element(std::begin(all.reach), std::end(all.reach));
    slack_ = static_cast<float>(1e-6 * (std::max({outermost.x, outermost.y, outermost.z}) + reach));
    size_grids(all, skin);
}

void BroadPhase::fill_grids(const Exposure& bodies, const SelfGaps& gaps) {
    const std::size_t slots = bodies.slots();
    const bool single_thread = threads_.count() == 1;
    cell_of_.resize(slots);
    place_.resize(slots); // place of an element within its cell
    for_blocks(threads_, slots, [&](std::size_t begin, std::size_t end, std::size_t) {
        for (std::size_t s = begin; s < end; ++s) {
            if (!bodies.has_element(s)) continue;
            const Grid& grid = grids_[grid_of_[s]];
            const Sphere& sphere = sphere_[s];
            const auto cell = [&](float x, int i) { return grid.cell_at(x) & (grid.size[i] - 1); };
            cell_of_[s] = grid.first_cell + (cell(sphere.z, 2) * grid.size[1] + cell(sphere.y, 1)) * grid.size[0] +
                          cell(sphere.x, 0);
            place_[s] = count_one(cell_begin_[cell_of_[s]], single_thread);
        }
    });
    const std::size_t room = begins_from_counts(threads_, cell_begin_) + 16; // read in sixteens
    for (auto* component : {&x_, &y_, &z_, &reach_}) component->resize(room);
    body_.resize(room);
    slot_.resize(room);
    for_blocks(threads_, slots, [&](std::size_t begin, std::size_t end, std::size_t) {
        for (std::size_t s = begin; s < end; ++s) {
            if (!bodies.has_element(s)) continue;
            const std::size_t i = cell_begin_[cell_of_[s]] + place_[s];
            const Sphere& sphere = sphere_[s];
            x_[i] = sphere.x;
            y_[i] = sphere.y;
            z_[i] = sphere.z;
            reach_[i] = sphere.reach;
            slot_[i] = static_cast<std::uint32_t>(s);
            const bool touches_itself = nth(gaps, bodies.at(s).group).touches_itself();
            body_[i] = touches_itself ? -1 - static_cast<std::int32_t>(s) : bodies.kin_of(s);
        }
    });
}

/// The elements of a cell and those east and west of it.
void BroadPhase::add_row(const Grid& grid, std::uint32_t x, std::uint32_t y, std::uint32_t z, Ranges& ranges) const {
    const std::uint32_t mask = grid.size[0] - 1, west = (x - 1) & mask, here = x & mask, east = (x + 1) & mask;
    const std::uint32_t* row =
        &cell_begin_[grid.first_cell +
                     ((z & (grid.size[2] - 1)) * grid.size[1] + (y & (grid.size[1] - 1))) * grid.size[0]];
    if (west < here && here < east) {
        ranges.add(row[west], row[east + 1]);
    } else {
        for (const std::uint32_t c : {west, here, east}) ranges.add(row[c], row[c + 1]);
    }
}

/// Spheres of some that meet the one at place i.
SKEIN_INLINE void BroadPhase::collect_overlaps(std::uint32_t i, const Spheres& others, Range range, float margin,
                                               Found& found) const {
    const std::uint32_t slot = slot_[i];
    const float x = x_[i], y = y_[i], z = z_[i], reach = reach_[i] + margin;
    const std::int32_t body = body_[i];
    std::size_t count = found.count;
    for (std::uint32_t j = range.begin; j < range.end; j += 16) {
        if (count > Found::most) {
            found.count = count;
            found.flush();
            count = 0;
        }
        std::fill_n(found.a + count, 16, slot); // all sixteen, as it costs less than to know how many
#if defined(__AVX512F__)
        const auto less = [j](const float* v, float by) {
            return _mm512_sub_ps(_mm512_loadu_ps(v + j), _mm512_set1_ps(by));
        };
        const __m512 dx = less(others.x, x), dy = less(others.y, y), dz = less(others.z, z),
                     r = less(others.reach, -reach);
        const __m512 squared = _mm512_fmadd_ps(dx, dx, _mm512_fmadd_ps(dy, dy, _mm512_mul_ps(dz, dz)));
        const auto valid = static_cast<__mmask16>((1u << std::min(range.end - j, 16u)) - 1);
        const __mmask16 foreign =
            _mm512_mask_cmpneq_epi32_mask(valid, _mm512_loadu_si512(others.body + j), _mm512_set1_epi32(body));
        const __mmask16 near = _mm512_mask_cmp_ps_mask(foreign, squared, _mm512_mul_ps(r, r), _CMP_LT_OQ);
        _mm512_storeu_si512(found.b + count, _mm512_maskz_compress_epi32(near, _mm512_loadu_si512(others.slot + j)));
        count += to_index(std::popcount(static_cast<unsigned>(near)));
#else
        for (std::uint32_t k = j; k < std::min(j + 16, range.end); ++k) {
            const float dx = others.x[k] - x, dy = others.y[k] - y, dz = others.z[k] - z, r = others.reach[k] + reach;
            found.b[count] = others.slot[k];
            count += (dx * dx + dy * dy + dz * dz < r * r) & (others.body[k] != body);
        }
#endif
    }
    found.count = count;
}

void BroadPhase::search_cells(const Grid& grid, std::uint32_t begin, std::uint32_t end, float margin,
                              Found& found) const {
    const Spheres all = spheres();
    Copies copies;
    for (std::uint32_t c = begin; c < end; ++c) {
        const std::uint32_t* cell = &cell_begin_[grid.first_cell + c];
        if (cell[0] == cell[1]) continue;
        const std::uint32_t x = c & (grid.size[0] - 1), y = c / grid.size[0] & (grid.size[1] - 1),
                            z = c / grid.size[0] / grid.size[1];
        // Its own elements and half of the neighbours; the others look here.
        const bool edge = x + 1 == grid.size[0];
        Ranges ranges;
        ranges.add(cell[0], edge ? cell[1] : cell[2]);
        if (edge) ranges.add(cell[-static_cast<std::ptrdiff_t>(x)], cell[1 - static_cast<std::ptrdiff_t>(x)]);
        add_row(grid, x, y + 1, z, ranges);
        for (const std::uint32_t dy : {~0u, 0u, 1u}) add_row(grid, x, y + dy, z + 1, ranges);
        const bool copied = copies.take(all, ranges);
        for (std::uint32_t i = cell[0]; i < cell[1]; ++i) {
            if (copied) {
                collect_overlaps(i, copies.spheres(), {i - cell[0] + 1, copies.count}, margin, found);
            } else {
                ranges.range[0].begin = i + 1;
                for (int r = 0; r < ranges.count; ++r) collect_overlaps(i, all, ranges.range[r], margin, found);
            }
            for (const Grid* coarser = &grid + 1; coarser < grids_.data() + grids_.size(); ++coarser) {
                Ranges around;
                for (const std::uint32_t dz : {~0u, 0u, 1u})
                    for (const std::uint32_t dy : {~0u, 0u, 1u})
                        add_row(*coarser, coarser->cell_at(x_[i]), coarser->cell_at(y_[i]) + dy,
                                coarser->cell_at(z_[i]) + dz, around);
                for (int r = 0; r < around.count; ++r) collect_overlaps(i, all, around.range[r], margin, found);
            }
        }
    }
    found.flush();
}

void BroadPhase::build(const Exposure& bodies, const SelfGaps& gaps, double skin, Candidates& candidates) {
    if (bodies.slots() == 0) { // a rank without bodies
        candidates = {.first = {0}, .partner = {}};
        return;
    }
    measure(bodies, skin);
    fill_grids(bodies, gaps);
    struct Task {
        const Grid* grid;
        std::uint32_t begin, end; ///< cells
    };
    std::vector<Task> tasks;
    for (const Grid& grid : grids_)
        for (std::uint32_t c = 0; c < grid.cells(); c += block_size)
            tasks.push_back({&grid, c, std::min<std::uint32_t>(grid.cells(), c + block_size)});
    near_.resize(tasks.size());
    threads_.for_each(tasks.size(), [&](std::size_t t, int) {
        near_[t].pairs.clear();
        near_[t].inactive = 0;
        Found found{.bodies = bodies, .gaps = gaps, .skin = skin, .near = near_[t]};
        search_cells(*tasks[t].grid, tasks[t].begin, tasks[t].end, static_cast<float>(skin) + slack_, found);
    });
    const auto visit = [&](auto&& body) {
        threads_.for_each(near_.size(), [&](std::size_t t, int) {
            for (const Pair& pair : near_[t].pairs) body(pair.a, pair.b);
        });
    };
    candidates.inactive = 0;
    for (const Near& near : near_) candidates.inactive += near.inactive;
    group(threads_, bodies.slots(), visit, candidates.first, candidates.partner);
}

void BroadPhase::build_exhaustively(const Exposure& bodies, const SelfGaps& gaps, double skin, Candidates& candidates) {
    const auto slots = static_cast<std::uint32_t>(bodies.slots());
    candidates.first.assign(slots + 1, 0);
    candidates.partner.clear();
    std::vector<std::uint32_t> first, second;
    Near near;
    for (std::uint32_t a = 0; a < slots; ++a) {
        candidates.first[a] = static_cast<std::uint32_t>(candidates.partner.size());
        if (!bodies.has_element(a)) continue;
        second.clear();
        near.pairs.clear();
        for (std::uint32_t b = a + 1; b < slots; ++b)
            if (bodies.has_element(b)) second.push_back(b);
        const std::size_t count = second.size();
        first.assign(count + 8, a);
        second.resize(count + 8);
        append_near(bodies, gaps, skin, first.data(), second.data(), count, near);
        for (const Pair& pair : near.pairs) candidates.partner.push_back(pair.b);
    }
    candidates.inactive = near.inactive;
    candidates.first[slots] = static_cast<std::uint32_t>(candidates.partner.size());
}

} // namespace skein
