#include "contact/broad_phase.hpp"

#include "contact/capsule_tiles.hpp"
#include "contact/floats.hpp"
#include "contact/rows.hpp"
#include "contact/vertices.hpp"
#include "core/closest_points.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

namespace skein {

namespace {

Vec3d middle(const Exposure& c, std::size_t slot) { return 0.5 * (c.node[slot].position + c.node[slot + 1].position); }
/// Half of the axis, m.
Vec3d half_axis(const Exposure& c, std::size_t slot) {
    return 0.5 * (c.node[slot + 1].position - c.node[slot].position);
}
Vec3d least_of(const Vec3d& a, const Vec3d& b) { return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)}; }
Vec3d most_of(const Vec3d& a, const Vec3d& b) { return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)}; }

} // namespace

/// Appends the pairs (a[i], b[i]) that may touch, with capsules less than their share of `skin` apart and one element
/// of an own body. Both arrays have room for a tile more. The lower slot comes first before any arithmetic, so all
/// ranks find the same bits.
void BroadPhase::append_near(const Exposure& c, const TouchRules& rules, double skin, std::uint32_t* a,
                             std::uint32_t* b, std::size_t count, Near& near) {
    constexpr std::size_t W = CapsuleTile::width;
    if (count == 0) return;
    near.tested += static_cast<std::int64_t>(count);
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
            alignas(64) double pace[W];
            for (std::size_t l = 0; l < W; ++l) pace[l] = c.pace_of(a[i + l]) + c.pace_of(b[i + l]);
            const auto apart = closest_points(tile.p, tile.d1, tile.q, tile.d2).apart;
            const auto both = tile.radius_1 + tile.radius_2,
                       reach = both + Pack<W>(0.5 * skin) * detail::pack_at<W>(pace), squared = dot(apart, apart);
            unsigned bits = bits_of(squared < reach * reach) & (count - i < W ? (1u << (count - i)) - 1 : 0xffu);
            const unsigned touching = bits_of(squared < both * both);
            for (; bits != 0; bits &= bits - 1) {
                const int lane = std::countr_zero(bits);
                const std::size_t l = i + to_index(lane);
                if (!may_touch(c, rules, a[l], b[l])) continue;
                const bool own = c.owns_slot(a[l]);
                if (!own && !c.owns_slot(b[l])) continue;
                near.inactive += own & ~touching >> lane & 1;
                near.pairs.push_back({a[l], b[l]});
            }
        });
}

/// An element that looks for others, in all lanes.
struct BroadPhase::Element {
    Floats3 middle, half;
    Floats radius; ///< with the loss of single precision
    std::int32_t body;
    std::uint32_t slot;
    float at[3], side[3]; ///< middle, and half of the box

    Element(const Columns& all, std::uint32_t i, float slack) : body(all.body[i]), slot(all.slot[i]) {
        const auto& [x, y, z, half_x, half_y, half_z, thick] = all.number;
        const float wide = thick[i] + slack;
        middle = {x[i], y[i], z[i]};
        half = {half_x[i], half_y[i], half_z[i]};
        radius = wide;
        for (int axis = 0; axis < 3; ++axis) {
            nth(at, axis) = nth(all.number, axis)[i];
            nth(side, axis) = std::abs(nth(all.number, axis + 3)[i]) + wide;
        }
    }
    /// Cells with all elements whose boxes may overlap its own.
    Cells reached(const Grid& grid, int axis) const {
        const float reach = nth(side, axis) + nth(grid.most, axis);
        return {grid.cell_at(nth(at, axis) - reach), grid.cell_at(nth(at, axis) + reach)};
    }
};

/// Ranges of elements in order of cells. Those that follow each other become one.
struct BroadPhase::Ranges {
    static constexpr int most = 2 * 5 * 5; ///< rows that an element reaches, which may wrap round
    Range range[most];
    int count = 0;
    void add(std::uint32_t begin, std::uint32_t end) {
        if (begin >= end) return;
        assert(count < most);
        if (count > 0 && range[count - 1].end == begin) range[count - 1].end = end;
        else range[count++] = {begin, end};
    }
};

/// Elements whose boxes overlap that of another.
struct BroadPhase::Neighbours {
    static constexpr std::size_t most = 256;
    alignas(64) float number[numbers][most + 32];
    std::uint32_t slot[most + 32];
    std::size_t count = 0;

    SKEIN_INLINE void add(const Columns& from, std::uint32_t first, unsigned bits) {
        for (int n = 0; n < numbers; ++n) compress_floats(number[n] + count, bits, from.number[n] + first);
        compress_floats(slot + count, bits, from.slot + first);
        count += to_index(std::popcount(bits));
    }
};

/// Pairs that come near in single precision, on their way to those that do in double precision.
struct BroadPhase::Found {
    static constexpr std::size_t most = 1024;
    const Exposure& bodies;
    const TouchRules& rules;
    double skin;
    Near& near;
    std::size_t count = 0;
    std::uint32_t a[most + 64], b[most + 64];

    void flush() {
        append_near(bodies, rules, skin, a, b, count, near);
        count = 0;
    }
};

std::int32_t BroadPhase::Grid::cell_at(float x) const {
    return static_cast<std::int32_t>(std::floor(x * cells_per_unit));
}
/// First cell of a row along x, in cell_begin_.
std::uint32_t BroadPhase::Grid::row(std::int32_t y, std::int32_t z) const {
    const auto wrapped = [&](std::int32_t at, int axis) { return static_cast<std::uint32_t>(at) & (size[axis] - 1); };
    return first_cell + (wrapped(z, 2) * size[1] + wrapped(y, 1)) * size[0];
}

BroadPhase::BroadPhase(const Threads& threads) : threads_(threads) {}
BroadPhase::~BroadPhase() = default;

/// False of elements so far away that double precision does not resolve the smallest: those of rods that have become
/// invalid.
bool BroadPhase::resolves(const Exposure& bodies, std::size_t slot) const {
    return norm(middle(bodies, slot)) + norm(half_axis(bodies, slot)) <
           smallest_ / std::numeric_limits<double>::epsilon();
}

/// True where elements of this grid look for those of another one. Pairs of two visitors are other ranks' business.
bool BroadPhase::Grid::searches(const Grid& other) const {
    if (other.elements == 0 || (!own && !other.own)) return false;
    return size_class < other.size_class || (size_class == other.size_class && own && !other.own);
}

int BroadPhase::grids() const {
    return static_cast<int>(
        std::count_if(grids_.begin(), grids_.end(), [](const Grid& grid) { return grid.elements > 0; }));
}

/// Sizes of the first search, by which later ones are measured.
void BroadPhase::find_sizes(const Exposure& bodies) {
    smallest_ = std::numeric_limits<double>::infinity();
    for (std::size_t s = 0; s < bodies.slots(); ++s)
        if (bodies.has_element(s)) smallest_ = std::min(smallest_, norm(half_axis(bodies, s)) + bodies.node[s].radius);
    Vec3d least{HUGE_VAL, HUGE_VAL, HUGE_VAL}, most = -least;
    for (std::size_t s = 0; s < bodies.slots(); ++s) {
        if (!bodies.has_element(s) || !resolves(bodies, s)) continue;
        const Vec3d m = middle(bodies, s);
        least = least_of(least, m);
        most = most_of(most, m);
    }
    set_next_origin(0.5 * (least + most));
}

/// Centres the next search; motion until then counts in its slack. Without elements the origin stays.
void BroadPhase::set_next_origin(const Vec3d& centre) {
    if (std::isfinite(dot(centre, centre))) next_origin_ = centre;
}

/// Extent of all elements from origin_, in unit_, with the reach and the number of those of each size.
struct BroadPhase::Extent {
    static constexpr std::size_t sizes = 32, grids = 2 * sizes; ///< powers of two
    Vec3d least{HUGE_VAL, HUGE_VAL, HUGE_VAL}, most{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    double reach[grids] = {};
    Vec3d side[grids] = {}; ///< half of the largest box
    std::size_t count[grids] = {};

    void add(const Extent& other) {
        least = least_of(other.least, least);
        most = most_of(other.most, most);
        for (std::size_t g = 0; g < grids; ++g) {
            reach[g] = std::max(reach[g], other.reach[g]);
            side[g] = most_of(side[g], other.side[g]);
            count[g] += other.count[g];
        }
    }
};

/// Number of the grid for elements of a size, a power of two.
std::uint8_t BroadPhase::grid_for(int size, bool own) {
    return static_cast<std::uint8_t>(2 * std::clamp(size, 0, static_cast<int>(Extent::sizes) - 1) + !own);
}

/// Sets the bounds of elements and the grids that these belong to. Elements that are not resolved belong to none:
/// nothing is near them.
BroadPhase::Extent BroadPhase::set_bounds(const Exposure& bodies, double skin) {
    std::vector<Extent> parts(blocks_of(bodies.slots()));
    for_blocks(threads_, bodies.slots(), [&](std::size_t begin, std::size_t end, std::size_t block) {
        Extent& e = parts[block];
        for (std::size_t s = begin; s < end; ++s) {
            grid_of_[s] = no_grid;
            if (!bodies.has_element(s) || !resolves(bodies, s)) continue;
            const Vec3d m = (1 / unit_) * (middle(bodies, s) - origin_), half = (1 / unit_) * half_axis(bodies, s);
            const double radius = (bodies.node[s].radius + 0.5 * skin * bodies.pace_of(s)) / unit_,
                         reach = norm(half) + radius;
            grid_of_[s] = grid_for(std::ilogb(reach * (unit_ / smallest_)), bodies.owns_slot(s));
            bound_[s] = {{static_cast<float>(m.x), static_cast<float>(m.y), static_cast<float>(m.z),
                          static_cast<float>(half.x), static_cast<float>(half.y), static_cast<float>(half.z),
                          static_cast<float>(radius)}};
            e.least = least_of(e.least, m);
            e.most = most_of(e.most, m);
            e.reach[grid_of_[s]] = std::max(e.reach[grid_of_[s]], reach);
            e.side[grid_of_[s]] = most_of(
                e.side[grid_of_[s]], {std::abs(half.x) + radius, std::abs(half.y) + radius, std::abs(half.z) + radius});
            ++e.count[grid_of_[s]];
        }
    });
    Extent all;
    for (const Extent& e : parts) all.add(e);
    return all;
}

/// Cells are at least as wide as the largest element reaches, and wider where rows of them would have few elements: a
/// register is to be full. There are no more than four to an element.
void BroadPhase::size_grids(const Extent& all) {
    constexpr double full_row = 12; // elements
    const Vec3d extent = all.most - all.least;
    std::uint32_t cells = 0;
    double reach = 0;
    for (std::size_t g = 0; g < grids_.size(); ++g) {
        Grid& grid = grids_[g];
        grid.elements = all.count[g];
        grid.size_class = static_cast<int>(g / 2);
        grid.own = g % 2 == 0;
        reach = std::max({reach, all.reach[g], all.reach[g | 1]});
        const double sides[3] = {extent.x, extent.y, extent.z}, most[3] = {all.side[g].x, all.side[g].y, all.side[g].z};
        double cell = reach + 2 * slack_;
        const double in_row = static_cast<double>(all.count[g]) * std::min(1.0, 4 * reach / sides[0]);
        for (int i = 0; i < 4; ++i)
            if (in_row * std::min(1.0, cell / sides[1]) * std::min(1.0, cell / sides[2]) < full_row)
                cell *= std::sqrt(2.0);
        grid.cells_per_unit = static_cast<float>(1 / cell);
        for (int i = 0; i < 3; ++i) {
            grid.most[i] = static_cast<float>(most[i]) + slack_;
            grid.size[i] = std::bit_ceil(static_cast<std::uint32_t>(std::clamp(sides[i] / cell + 4, 8.0, 1048576.0)));
        }
        const std::uint64_t room = std::max<std::uint64_t>(512, 4 * all.count[g]);
        while (std::uint64_t{grid.size[0]} * grid.size[1] * grid.size[2] > room)
            *std::max_element(grid.size, grid.size + 3) /= 2;
        grid.first_cell = cells;
        cells += grid.cells();
    }
}

void BroadPhase::measure(const Exposure& bodies, double skin) {
    if (smallest_ == 0) find_sizes(bodies);
    origin_ = next_origin_;
    unit_ = std::ldexp(1.0, std::ilogb(smallest_));
    bound_.resize(bodies.slots());
    grid_of_.resize(bodies.slots());
    const Extent all = set_bounds(bodies, skin);
    std::size_t coarsest = Extent::grids - 1;
    while (coarsest > 0 && all.count[coarsest] == 0) --coarsest;
    grids_.resize(coarsest + 1);
    set_next_origin(origin_ + 0.5 * unit_ * (all.least + all.most));
    const Vec3d outermost = most_of(-all.least, all.most);
    const double reach = *std::max_element(std::begin(all.reach), std::end(all.reach));
    slack_ = static_cast<float>(1e-6 * (std::max({outermost.x, outermost.y, outermost.z}) + reach));
    size_grids(all);
}

void BroadPhase::fill_grids(const Exposure& bodies, const TouchRules& rules) {
    constexpr std::uint32_t no_cell = UINT32_MAX;
    const std::size_t slots = bodies.slots();
    cell_of_.resize(slots);
    for_blocks(threads_, slots, [&](std::size_t begin, std::size_t end, std::size_t) {
        for (std::size_t s = begin; s < end; ++s) {
            cell_of_[s] = no_cell;
            if (grid_of_[s] == no_grid) continue;
            const Grid& grid = grids_[grid_of_[s]];
            const auto& [x, y, z, half_x, half_y, half_z, radius] = bound_[s].number;
            cell_of_[s] = grid.row(grid.cell_at(y), grid.cell_at(z)) +
                          (static_cast<std::uint32_t>(grid.cell_at(x)) & (grid.size[0] - 1));
        }
    });
    const auto visit = [&](std::size_t block, auto&& body) {
        for (std::size_t s = block * block_size; s < std::min(slots, (block + 1) * block_size); ++s)
            if (cell_of_[s] != no_cell) body(cell_of_[s], static_cast<std::uint32_t>(s));
    };
    cells_.group(threads_, grids_.back().first_cell + grids_.back().cells(), blocks_of(slots), visit, cell_begin_,
                 slot_);
    const std::size_t count = slot_.size(), room = count + 16; // read in sixteens
    for (auto& column : number_) column.resize(room);
    body_.resize(room);
    slot_.resize(room);
    for_blocks(threads_, count, [&](std::size_t begin, std::size_t end, std::size_t) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::uint32_t s = slot_[i];
            for (int n = 0; n < numbers; ++n) nth(number_, n)[i] = nth(bound_[s].number, n);
            const bool touches_itself = rules.of(bodies.at(s)).touches_itself();
            body_[i] = touches_itself ? -1 - static_cast<std::int32_t>(s)
                       : rules.joined ? bodies.window_of[s]
                                      : bodies.kin_of(s);
        }
    });
}

BroadPhase::Columns BroadPhase::columns() const {
    Columns all{{}, body_.data(), slot_.data()};
    for (int n = 0; n < numbers; ++n) all.number[n] = number_[n].data();
    return all;
}

/// Elements of ranges whose boxes overlap that of one.
void BroadPhase::collect_overlaps(const Element& one, const Columns& others, const Ranges& ranges, Neighbours& near,
                                  Found& found) const {
    constexpr std::uint32_t W = Floats::lanes;
    const Floats side_x(one.side[0]), side_y(one.side[1]), side_z(one.side[2]), x = one.middle.x, y = one.middle.y,
                                                                                z = one.middle.z;
    const float *const at_x = others.number[0], *const at_y = others.number[1], *const at_z = others.number[2],
                       *const half_x = others.number[3], *const half_y = others.number[4],
                       *const half_z = others.number[5], *const radius = others.number[6];
    const std::int32_t *const body = others.body, own_body = one.body;
    for (int r = 0; r < ranges.count; ++r) {
        const auto [begin, end] = ranges.range[r];
        for (std::uint32_t j = begin; j < end; j += W) {
            const Floats reach = Floats::at(radius + j);
            const auto beside = [&](const float* at, const float* half, Floats middle, Floats side) {
                return abs(Floats::at(at + j) - middle) < abs(Floats::at(half + j)) + (reach + side);
            };
            const Floats::Integers overlap = beside(at_x, half_x, x, side_x) & beside(at_y, half_y, y, side_y) &
                                             beside(at_z, half_z, z, side_z) & Floats::differ(body + j, own_body);
            const unsigned bits = Floats::bits_of(overlap) & ((2u << (std::min(end - j, W) - 1)) - 1);
            if (bits == 0) continue;
            near.add(others, j, bits);
            if (near.count > Neighbours::most) find_near(one, near, found);
        }
    }
}

/// Closest points of the axes, from their middles by shares s and t of their halves. Where they are near-parallel,
/// rounding moves s along them: squared distances are off by no more than 4e-6 of squared lengths.
SKEIN_INLINE void BroadPhase::find_near(const Element& one, Neighbours& near, Found& found) const {
    constexpr std::uint32_t W = Floats::lanes;
    constexpr float loss = 4e-6f, tiny = 1e-30f;
    const auto within = [](Floats x) { return min(max(x, Floats(-1.0f)), Floats(1.0f)); };
    const auto& [x, y, z, half_x, half_y, half_z, radius] = near.number;
    for (std::size_t j = 0; j < near.count; j += W) {
        const Floats3 apart = Floats3::at(x + j, y + j, z + j) - one.middle,
                      half = Floats3::at(half_x + j, half_y + j, half_z + j);
        const Floats a = dot(one.half, one.half), e = dot(half, half), b = dot(one.half, half),
                     c = dot(one.half, apart), f = dot(half, apart), some_a = max(a, Floats(tiny)),
                     some_e = max(e, Floats(tiny)), both = some_a * some_e,
                     denominator = max(a * e - b * b, Floats(1e-7f) * both);
        const Floats free = within((c * e - b * f) / denominator), t = within((free * b - f) / some_e),
                     s = within((c + t * b) / some_a);
        const Floats3 between = apart + t * half - s * one.half;
        const Floats reach = Floats::at(radius + j) + one.radius, squared = reach * reach;
        const std::size_t left = near.count - j;
        const unsigned bits = Floats::bits_of(dot(between, between) < squared + Floats(loss) * (a + e + squared)) &
                              ((2u << (std::min<std::size_t>(left, W) - 1)) - 1);
        std::fill_n(found.a + found.count, W, one.slot); // all, as it costs less than to know how many
        compress_floats(found.b + found.count, bits, near.slot + j);
        found.count += to_index(std::popcount(bits));
        if (found.count > Found::most) found.flush();
    }
    near.count = 0;
}

/// Some cells of a row, which may wrap round.
SKEIN_INLINE void BroadPhase::add_row(const Grid& grid, std::uint32_t row, Cells cells, Ranges& ranges) const {
    const std::uint32_t* const begin = &cell_begin_[row];
    const std::uint32_t size = grid.size[0], first = static_cast<std::uint32_t>(cells.first) & (size - 1),
                        behind = first + static_cast<std::uint32_t>(cells.last - cells.first) + 1;
    ranges.add(begin[first], begin[std::min(behind, size)]);
    if (behind > size) ranges.add(begin[0], begin[behind - size]);
}

/// Elements of the same grid that come after the one at place i: in its cell, its row and the rows beyond. Those before
/// it find it.
void BroadPhase::add_ahead(const Element& one, std::uint32_t i, const Grid& grid, Ranges& ranges) const {
    const Cells x = one.reached(grid, 0), y = one.reached(grid, 1), z = one.reached(grid, 2);
    const std::int32_t own_x = grid.cell_at(one.at[0]), own_y = grid.cell_at(one.at[1]),
                       own_z = grid.cell_at(one.at[2]);
    const std::uint32_t own_row = grid.row(own_y, own_z),
                        own_cell = own_row + (static_cast<std::uint32_t>(own_x) & (grid.size[0] - 1));
    ranges.add(i + 1, cell_begin_[own_cell + 1]);
    if (x.last > own_x) add_row(grid, own_row, {own_x + 1, x.last}, ranges);
    for (std::int32_t row = own_y + 1; row <= y.last; ++row) add_row(grid, grid.row(row, own_z), x, ranges);
    for (std::int32_t layer = own_z + 1; layer <= z.last; ++layer)
        for (std::int32_t row = y.first; row <= y.last; ++row) add_row(grid, grid.row(row, layer), x, ranges);
}

/// Elements of another grid, at least as coarse.
void BroadPhase::add_around(const Element& one, const Grid& grid, Ranges& ranges) const {
    const Cells x = one.reached(grid, 0), y = one.reached(grid, 1), z = one.reached(grid, 2);
    for (std::int32_t layer = z.first; layer <= z.last; ++layer)
        for (std::int32_t row = y.first; row <= y.last; ++row) add_row(grid, grid.row(row, layer), x, ranges);
}

void BroadPhase::search_elements(const Grid& grid, Range elements, Found& found) const {
    const Columns all = columns();
    Neighbours near;
    Ranges ranges;
    for (std::uint32_t i = elements.begin; i < elements.end; ++i) {
        const Element one(all, i, slack_);
        if (grid.own) {
            ranges.count = 0;
            add_ahead(one, i, grid, ranges);
            collect_overlaps(one, all, ranges, near, found);
        }
        for (const Grid& other : grids_) {
            if (!grid.searches(other)) continue;
            ranges.count = 0;
            add_around(one, other, ranges);
            collect_overlaps(one, all, ranges, near, found);
        }
        find_near(one, near, found);
    }
    found.flush();
}

std::int64_t BroadPhase::tested() const {
    std::int64_t all = 0;
    for (const Near& near : near_) all += near.tested;
    return all;
}

void BroadPhase::build(const Exposure& bodies, const TouchRules& rules, double skin, Candidates& candidates) {
    if (bodies.slots() == 0) { // a rank without bodies
        candidates = {.first = {0}, .partner = {}};
        return;
    }
    measure(bodies, skin);
    fill_grids(bodies, rules);
    struct Task {
        const Grid* grid;
        Range elements;
    };
    constexpr std::uint32_t elements_of_task = 256;
    std::vector<Task> tasks;
    for (const Grid& grid : grids_) {
        const std::uint32_t end = cell_begin_[grid.first_cell + grid.cells()];
        for (std::uint32_t i = cell_begin_[grid.first_cell]; i < end; i += elements_of_task)
            tasks.push_back({&grid, {i, std::min(end, i + elements_of_task)}});
    }
    near_.resize(tasks.size());
    threads_.for_each(tasks.size(), [&](std::size_t t, int) {
        near_[t].pairs.clear();
        near_[t].inactive = near_[t].tested = 0;
        Found found{.bodies = bodies, .rules = rules, .skin = skin, .near = near_[t]};
        search_elements(*tasks[t].grid, tasks[t].elements, found);
    });
    const auto visit = [&](std::size_t task, auto&& body) {
        for (const Pair& pair : near_[task].pairs) body(pair.a, pair.b);
    };
    candidates.inactive = 0;
    for (const Near& near : near_) candidates.inactive += near.inactive;
    pairs_.group(threads_, bodies.slots(), near_.size(), visit, candidates.first, candidates.partner);
}

void BroadPhase::build_exhaustively(const Exposure& bodies, const TouchRules& rules, double skin,
                                    Candidates& candidates) {
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
        append_near(bodies, rules, skin, first.data(), second.data(), count, near);
        for (const Pair& pair : near.pairs) candidates.partner.push_back(pair.b);
    }
    candidates.inactive = near.inactive;
    candidates.first[slots] = static_cast<std::uint32_t>(candidates.partner.size());
}

} // namespace skein
