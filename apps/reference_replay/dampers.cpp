#include "dampers.hpp"

#include "loads/damping.hpp"
#include "loads/laplacian_filter.hpp"

#include <algorithm>

namespace skein::replay {

namespace {

/// exp(-z) on all rates: the published kick without loads.
class Decay final : public TilePass<1> {
public:
    /// One z for every kick of a step, whatever its length.
    Decay(const RodGroup& group, const Damping& damping, double time_step)
        : kick_(std::vector(largest_stages, KickConstants(group, damping_rates(group, {&damping, 1}), time_step, DampingScheme::after))) {}
    std::string_view name() const override { return "damper"; }
    void run(const RodTile<1>& rod, SlotLoad<1>* load, const Step& step) const override {
        std::fill_n(load, rod.n + 1, SlotLoad<1>{});
        kick_.run(rod, load, step);
    }

private:
    static constexpr std::size_t largest_stages = 2; ///< distinct kick lengths of a scheme
    KickPass<KickKind::elastica, 1> kick_;
};

} // namespace

std::unique_ptr<TilePass<1>> make_damper(const Entry& e, const RodGroup& group) {
    const std::string kind = e["kind"].text();
    if (group.closed()) throw NotBuilt("damper '" + kind + "' on a ring (" + e.path() + ")");
    if (kind == "laplace_filter") return std::make_unique<LaplacianFilterPass<1>>(e["filter_order"].integer());
    if (kind != "analytical_linear") throw NotBuilt("damper '" + kind + "' (" + e.path() + ")");
    const double h = e["time_step"].positive();
    if (e.has("uniform_damping_constant"))
        return std::make_unique<Decay>(group, Damping{.kind = DampingKind::uniform, .rate = e["uniform_damping_constant"].number()}, h);
    if (e.has("damping_constant")) return std::make_unique<Decay>(group, Damping{.kind = DampingKind::legacy, .rate = e["damping_constant"].number()}, h);
    return std::make_unique<Decay>(group, Damping{.kind = DampingKind::physical,
                                                  .translational = e["translational_damping_constant"].number(),
                                                  .rotational = e["rotational_damping_constant"].number()}, h);
}

} // namespace skein::replay
