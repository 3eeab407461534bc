// Loads of reference files as passes. Where src/loads has the same formula it is taken; what differs in the published code (shares
// by number instead of by length, tables) or exists for one file only (moments per element) is here. W = 1.
#pragma once

#include "entry.hpp"

#include "loads/load_pass.hpp"
#include "rod/tile.hpp"

#include <memory>

namespace skein::replay {

/// The pass of an entry of `forces_in_order`. Throws NotBuilt.
std::unique_ptr<TilePass<1>> make_load(const Entry& entry, const RodGroup& group);

/// External loads of one rod, summed apart from the internal ones: within a step of several stages published codes add those of
/// every stage to what the stages before have left.
class External final : public TilePass<1> {
public:
    External(std::vector<std::unique_ptr<TilePass<1>>> loads, std::size_t slots) : loads_(std::move(loads)), sum_(slots) {}
    std::string_view name() const override { return "external loads"; }
    void prepare(std::span<const Step> steps) override {
        for (const auto& pass : loads_) pass->prepare(steps);
    }
    void run(const RodTile<1>& rod, SlotLoad<1>* load, const Step& step) const override {
        if (step.index != index_) sum_.assign(sum_.size(), SlotLoad<1>{});
        index_ = step.index;
        for (const auto& pass : loads_) pass->run(rod, sum_.data(), step);
        for (std::size_t k = 0; k < sum_.size(); ++k) load[k].force += sum_[k].force, load[k].couple += sum_[k].couple;
    }
    /// What acted last: force at nodes (lab, N), couple at elements (body, N m).
    const std::vector<SlotLoad<1>>& sum() const { return sum_; }

private:
    std::vector<std::unique_ptr<TilePass<1>>> loads_;
    mutable std::vector<SlotLoad<1>> sum_; ///< [n + 1]; one tile, one thread
    mutable std::int64_t index_ = 0;
};

} // namespace skein::replay
