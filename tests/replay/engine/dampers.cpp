#include "dampers.hpp"

#include "loads/damping.hpp"

#include <vector>

namespace skein::replay {

namespace {

/// exp(-z) on all rates: the published kick without loads.
class Decay final : public TilePass<1> {
public:
    /// One z for every kick of a step, whatever its length.
    Decay(const RodGroup& group, const Damping& damping, double time_step)
        : kick_(std::vector(largest_stages, KickConstants(group, damping_rates(group, {&damping, 1}), time_step,
                                                          DampingScheme::after))) {}
    void run(const RodTile<1>& rod, SlotLoad<1>* load, const Step& step) const override {
        for (int k = 0; k <= rod.n; ++k) {
            load[k].force = {};
            load[k].couple = {};
        }
        kick_.run(rod, load, step);
    }

private:
    static constexpr std::size_t largest_stages = 2; ///< distinct kick lengths of a scheme
    KickPass<KickKind::elastica, 1> kick_;
};

/// The published filter of an open rod: p times f_i <- (2 f_i - f_{i-1} - f_{i+1})/4 inside, 0 at both ends; then v <-
/// v - f, and spins alike in body components. It acts per step, keeps no momentum, and its ends, which never give way,
/// may add energy: the library's damping of that name is another. Source: PyElastica's LaplaceDissipationFilter;
/// Jeanmart & Winckelmans 2007.
class OpenFilter final : public TilePass<1> {
public:
    explicit OpenFilter(long order) : order_(order) {}
    void run(const RodTile<1>& rod, SlotLoad<1>*, const Step&) const override {
        filter<&Slot<1>::velocity>(rod, rod.n + 1);
        filter<&Slot<1>::spin>(rod, rod.n);
    }

private:
    template <auto Rate> void filter(const RodTile<1>& rod, int count) const {
        const auto last = static_cast<std::size_t>(count) - 1;
        std::vector<Vec3d> f(last + 1, Vec3d{0, 0, 0}), before;
        for (std::size_t i = 0; i <= last; ++i) f[i] = lane(rod.slot[i].*Rate, 0);
        for (long p = 0; p < order_; ++p) {
            before = f;
            for (std::size_t i = 1; i < last; ++i)
                f[i] = 0.25 * (before[i] + before[i] - before[i - 1] - before[i + 1]);
            f.front() = f.back() = {0, 0, 0};
        }
        for (std::size_t i = 1; i < last; ++i) rod.slot[i].*Rate -= broadcast<1>(f[i]);
    }

    long order_;
};

/// The published filter of a ring: it takes the rates with the last one put before them and the first one after them,
/// and leaves both ends of that list alone. Of order 1 it is the same all round; of higher orders it shows where the
/// list begins.
class RingFilter final : public TilePass<1> {
public:
    explicit RingFilter(long order) : order_(order) {}
    void run(const RodTile<1>& rod, SlotLoad<1>*, const Step&) const override {
        filter<&Slot<1>::velocity>(rod);
        filter<&Slot<1>::spin>(rod);
    }

private:
    template <auto Rate> void filter(const RodTile<1>& rod) const {
        const auto n = static_cast<std::size_t>(rod.n);
        std::vector<Vec3d> f(n + 2, Vec3d{0, 0, 0}), before;
        for (std::size_t i = 0; i < n + 2; ++i) f[i] = lane(rod.slot[(i + n - 1) % n].*Rate, 0);
        for (long p = 0; p < order_; ++p) {
            before = f;
            for (std::size_t i = 1; i <= n; ++i) f[i] = 0.25 * (2.0 * before[i] - before[i - 1] - before[i + 1]);
            f.front() = f.back() = {0, 0, 0};
        }
        for (std::size_t i = 0; i < n; ++i) rod.slot[i].*Rate -= broadcast<1>(f[i + 1]);
    }

    long order_;
};

} // namespace

std::unique_ptr<TilePass<1>> make_damper(const Entry& e, const RodGroup& group) {
    const std::string kind = e["kind"].text();
    if (kind == "laplace_filter" && group.closed()) return std::make_unique<RingFilter>(e["filter_order"].integer());
    if (kind == "laplace_filter") return std::make_unique<OpenFilter>(e["filter_order"].integer());
    if (kind != "analytical_linear") throw NotBuilt("damper '" + kind + "' (" + e.path() + ")");
    const double h = e["time_step"].positive();
    if (e.has("uniform_damping_constant"))
        return std::make_unique<Decay>(
            group, Damping{.kind = DampingKind::uniform, .rate = e["uniform_damping_constant"].number()}, h);
    if (e.has("damping_constant"))
        return std::make_unique<Decay>(group,
                                       Damping{.kind = DampingKind::legacy, .rate = e["damping_constant"].number()}, h);
    return std::make_unique<Decay>(group,
                                   Damping{.kind = DampingKind::physical,
                                           .translational = e["translational_damping_constant"].number(),
                                           .rotational = e["rotational_damping_constant"].number()},
                                   h);
}

} // namespace skein::replay
