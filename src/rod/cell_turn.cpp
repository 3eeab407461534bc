#include "rod/cell_turn.hpp"

#include "parallel/pieces.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"
#include "skein/rod/rod_group.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace skein {

namespace {

/// Largest turn under the curvature `profile`, or `uniform` where that is empty, 1/m.
CellTurn turn_by(const Shape& shape, const Vec3d& uniform, const std::vector<Vec3d>& profile) {
    const std::size_t n = to_index(shape.elements), cells = to_index(shape.cells());
    const std::vector<double>& parts = shape.length_profile;
    CellTurn most;
    if (shape.elements < 2 || (!profile.empty() && profile.size() != cells) || (!parts.empty() && parts.size() != n))
        return most;
    if (profile.empty() && zero(uniform)) return most;
    const double sum = parts.empty() ? static_cast<double>(n) : std::accumulate(parts.begin(), parts.end(), 0.0);
    const auto part = [&](std::size_t k) { return parts.empty() ? 1.0 : parts[k]; };
    for (std::size_t k = 0; k < cells; ++k) {
        const double length = 0.5 * (part(k) + part((k + 1) % n)) / sum * shape.length;
        const double angle = length * norm(profile.empty() ? uniform : profile[k]);
        if (!(angle <= most.angle)) most = {angle, static_cast<long>(k), length};
    }
    return most;
}

} // namespace

CellTurn rest_turn(const Shape& shape) { return turn_by(shape, shape.rest_curvature, shape.rest_curvature_profile); }
CellTurn start_turn(const Shape& shape) {
    return turn_by(shape, shape.start_curvature.value_or(Vec3d{0, 0, 0}), shape.start_curvature_profile);
}
LargestTurn largest_turn(const Shape& shape) {
    const CellTurn rest = rest_turn(shape), start = start_turn(shape);
    return rest.angle >= start.angle ? LargestTurn{rest, "rest"} : LargestTurn{start, "start"};
}

std::string text_of(const CellTurn& turn) {
    return fmt::format("turns element {} against element {} by {:.3g} rad", turn.cell + 1, turn.cell, turn.angle);
}

void refuse_large_turns(const RodGroup& group, const Threads* threads) {
    const Places& places = group.places();
    const RodSpec& spec = group.spec();
    std::vector<RodSpec> own_of_thread(threads_in(threads), spec);
    const auto look_at = [&](std::int64_t i, std::size_t thread = 0) {
        RodSpec& own = own_of_thread[thread];
        if (group.heterogeneous()) group.put_own_sizes(i, own);
        const auto [most, curvature] = largest_turn(own.shape);
        if (most.angle < CellTurn::largest) return;
        throw InputError(fmt::format("{}: the {} curvature of rod {} of '{}', {:g} m long by file '{}', {}; neighbours "
                                     "can be distinguished up to pi: at most {:.4g} 1/m there",
                                     spec.source, curvature, i, spec.name, own.shape.length, spec.placement.file,
                                     text_of(most), most.curvature(CellTurn::largest)));
    };
    const std::vector<std::int64_t> held = places.held();
    if (held.empty()) return;
    if (!group.heterogeneous()) return look_at(held.front());
    if (places.columns().nodes) {
        constexpr std::size_t piece = 512;
        in_pieces(threads, held.size(), piece,
                  [&](std::size_t begin, std::size_t end, std::size_t thread, std::size_t) {
                      for (std::size_t i = begin; i < end; ++i) look_at(held[i], thread);
                  });
        return;
    }
    // Rods that differ in length alone: the longest turns most.
    look_at(*std::max_element(held.begin(), held.end(), [&](std::int64_t a, std::int64_t b) {
        return places.length(a, 0) < places.length(b, 0);
    }));
}

} // namespace skein
