#include "immersion/given_sums.hpp"

#include "parallel/exact_sum.hpp"

#include <algorithm>

namespace skein {

namespace {

constexpr std::size_t force_columns = 3, load_columns = 6; // without and with a moment

Vec3d vector_at(const double* numbers) { return {numbers[0], numbers[1], numbers[2]}; }

} // namespace

void GivenSums::forget_kept() {
    kept_ = 0;
    for (Terms* terms : {&body_terms_, &part_terms_}) {
        terms->number.clear();
        terms->of.clear();
    }
}

void GivenSums::reset() {
    forget_kept();
    std::fill(of_body_.begin(), of_body_.end(), Vec3d{0, 0, 0});
    std::fill(of_part_.begin(), of_part_.end(), GivenMomentum{});
}

void GivenSums::keep(std::span<const Vec3d> changes, const Markers& markers) {
    const auto bodies = static_cast<std::uint32_t>(of_body_.size()),
               parts = static_cast<std::uint32_t>(of_part_.size());
    for (std::size_t m = 0; m < changes.size(); ++m) {
        const Vec3d& change = changes[m];
        body_terms_.number.insert(body_terms_.number.end(), {change.x, change.y, change.z});
        body_terms_.of.push_back(kept_ * bodies + markers.body[m]);
        if (!has_parts() || markers.part[m] == Markers::no_part) continue;
        const Vec3d moment = cross(markers.arm[m], change);
        part_terms_.number.insert(part_terms_.number.end(),
                                  {change.x, change.y, change.z, moment.x, moment.y, moment.z});
        part_terms_.of.push_back(kept_ * parts + markers.part[m]);
    }
    if (++kept_ == most_kept) sum();
}

std::vector<double> GivenSums::sums_of(const Terms& terms, std::size_t columns, std::size_t in_stage) const {
    return exact_sums(comm_, threads_,
                      {terms.number.data(), terms.of.size(), columns, columns, kept_ * in_stage, terms.of.data()});
}

void GivenSums::sum() {
    if (kept_ == 0) return;
    const std::vector<double> forces = sums_of(body_terms_, force_columns, of_body_.size());
    for (std::size_t s = 0; s < forces.size() / force_columns; ++s)
        of_body_[s % of_body_.size()] += cell_volume_ * vector_at(&forces[force_columns * s]);
    if (has_parts()) {
        const std::vector<double> loads = sums_of(part_terms_, load_columns, of_part_.size());
        for (std::size_t s = 0; s < loads.size() / load_columns; ++s) {
            const double* const load = &loads[load_columns * s];
            of_part_[s % of_part_.size()] += {cell_volume_ * vector_at(load), cell_volume_ * vector_at(load + 3)};
        }
    }
    forget_kept();
}

} // namespace skein
