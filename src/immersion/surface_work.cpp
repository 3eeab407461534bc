#include "immersion/surface_work.hpp"

#include "parallel/exact_sum.hpp"
#include "skein/core/index.hpp"

namespace skein {

void SurfaceWorkSums::add(const SurfaceWork& work, bool same_row) {
    if (same_row) {
        terms_.back() += work;
        return;
    }
    terms_.push_back(work);
    stage_.push_back(kept_);
}

void SurfaceWorkSums::end_stage() {
    if (++kept_ == most_kept) sum();
}

void SurfaceWorkSums::sum() {
    if (kept_ == 0) return;
    std::vector<std::vector<double>> columns(2 * std::size_t{kept_});
    for (std::size_t n = 0; n < terms_.size(); ++n) {
        columns[2 * std::size_t{stage_[n]}].push_back(terms_[n].given);
        columns[2 * std::size_t{stage_[n]} + 1].push_back(terms_[n].lost);
    }
    const std::vector<double> sums = exact_sums(comm_, columns);
    for (std::size_t s = 0; s < kept_; ++s) whole_ += {cell_volume_ * sums[2 * s], cell_volume_ * sums[2 * s + 1]};
    kept_ = 0;
    terms_.clear();
    stage_.clear();
}

void SurfaceWorkSums::reset() {
    kept_ = 0;
    terms_.clear();
    stage_.clear();
    whole_ = {};
}

} // namespace skein
