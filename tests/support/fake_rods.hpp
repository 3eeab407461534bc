// Rods without physics: their state is a function of gid and step, so that a test knows what any file must hold.
#pragma once

#include "core/rotation.hpp"
#include "mechanics/rod_copies.hpp"
#include "skein/core/index.hpp"
#include "tiles/rods.hpp"

#include <algorithm>
#include <random>
#include <utility>

namespace skein::test {

/// A magnetised row and a mat of longer rods: two groups of unlike records.
inline std::vector<RodGroup> two_groups(long row = 37, long mat_side = 3) {
    RodSpec cilia;
    cilia.name = "cilia";
    cilia.material = {.density = 1000, .youngs_modulus = 1e6};
    cilia.section = {.radius = 0.02, .taper = 0.5};
    cilia.shape = {.length = 1, .elements = 5};
    cilia.placement = {.kind = PlacementKind::line, .counts = {row}, .spacing = {0.3}};
    cilia.magnetisation = {.pattern = MagnetisationPattern::wave_x, .strength = 1, .wavelength_x = 2};
    RodSpec mat = cilia;
    mat.name = "mat";
    mat.shape.elements = 8;
    mat.placement = {
        .kind = PlacementKind::lattice, .origin = {0, 2, 0}, .counts = {mat_side, mat_side}, .spacing = {0.5, 0.5}};
    mat.magnetisation = {};
    std::vector<RodGroup> groups;
    groups.emplace_back(cilia, 0, 0, "");
    groups.emplace_back(mat, 1, groups[0].count(), "");
    return groups;
}

/// State of a rod at a step: the start state, shaken.
inline std::vector<Slot<1>> fake_state(const RodGroup& group, std::int64_t index, std::int64_t step) {
    std::mt19937_64 random(static_cast<std::uint64_t>(group.first_gid() + index) * 1000003 +
                           static_cast<std::uint64_t>(step));
    std::uniform_real_distribution<double> uniform(-0.1, 0.1);
    const auto vector = [&] {
        const double x = uniform(random), y = uniform(random), z = uniform(random);
        return Vec3d{x, y, z};
    };
    std::vector<Slot<1>> state(static_cast<std::size_t>(group.slots()));
    group.start_state(index, state);
    for (std::size_t k = 0; k < state.size(); ++k) {
        set_lane(state[k].position, 0, lane(state[k].position, 0) + vector());
        set_lane(state[k].velocity, 0, vector());
        if (k + 1 == state.size()) break;
        set_lane(state[k].director, 0, rotation(vector()) * lane(state[k].director, 0));
        set_lane(state[k].spin, 0, vector());
    }
    return state;
}

class FakeRods : public Rods {
public:
    FakeRods(std::span<const RodGroup> groups, std::vector<LocalRod> local)
        : groups_(groups), local_(std::move(local)) {
        set(0);
    }

    /// Every rod to its state at a step.
    void set(std::int64_t step) {
        states_.clear();
        budgets_.clear();
        for (const LocalRod& rod : local_) {
            states_.push_back(fake_state(nth(groups_, rod.group), rod.index, step));
            budgets_.push_back(fake_budget(rod.gid, step));
        }
    }
    static RodBudget fake_budget(std::int64_t gid, std::int64_t step) {
        const double x = static_cast<double>(gid) + 1e-3 * static_cast<double>(step);
        return {1 / (1 + x * x), -x, 3 + x};
    }

    bool advance(std::span<const Step>, bool) override { return true; }
    void drift(const Step&) override {}
    bool kick(const Step&, bool) override { return true; }
    void kick_and_drift(const Step&, const Step&) override {}
    void begin_within(const Step&) override {}
    void keep(std::size_t) override {}
    void go_back(std::size_t) override {}
    double farthest_from(std::size_t) const override { return 0; }
    std::string near_limit() const override { return {}; }
    bool budgets_fluid(std::size_t) const override { return false; }
    std::vector<std::string_view> passes(std::size_t) const override { return {}; }
    std::span<const LocalRod> local() const override { return local_; }
    RodPlace place(std::size_t i) const override { return {0, i, 0}; }
    void renew_formulas() override {}
    void export_rod(std::size_t i, std::span<Slot<1>> out) const override {
        std::copy(states_[i].begin(), states_[i].end(), out.begin());
    }
    void import_rod(std::size_t i, std::span<const Slot<1>> in) override { states_[i].assign(in.begin(), in.end()); }
    void read(std::span<const std::size_t> rods, Copy copy, double lag, const RodReader& reader,
              double time) const override {
        for (std::size_t i = 0; i < rods.size(); ++i) {
            const RodGroup& group = group_of(rods[i]);
            std::vector<Slot<1>> state = states_[rods[i]];
            std::vector<Mat3d> frames;
            std::vector<NodeProfile> profile(copy == Copy::strained ? state.size() : 0);
            if (copy == Copy::positions) synchronise_positions(group, state, lag);
            else if (copy != Copy::canonical) synchronise(group, state, lag);
            if (has_frames(copy))
                for (std::size_t k = 0; k + 1 < state.size(); ++k) frames.push_back(frame(state[k]));
            if (copy == Copy::strained) rod_profile(group, state, time, profile);
            reader(0, i, {state, frames, profile, copy == Copy::canonical ? hash_rod(local_[rods[i]].gid, state) : 0});
        }
    }
    void figures(double time, double lag, std::span<RodFigures> out) const override {
        for (std::size_t i = 0; i < local_.size(); ++i) {
            std::vector<Slot<1>> state = states_[i];
            synchronise(group_of(i), state, lag);
            out[i] = figures_of(group_of(i), state, time);
        }
    }
    std::uint64_t digest() const override {
        std::uint64_t sum = 0;
        for (std::size_t i = 0; i < local_.size(); ++i) sum += hash_rod(local_[i].gid, states_[i]);
        return sum;
    }
    void inspect(std::int64_t, double) const override {}
    RodBudget budget(std::size_t i) const override { return budgets_[i]; }
    bool budgets_steps(std::size_t) const override { return false; }
    void set_budget(std::size_t i, const RodBudget& budget) override { budgets_[i] = budget; }
    std::vector<double> memory(std::size_t) const override { return {}; }
    void set_memory(std::size_t, std::span<const double>) override {}
    int threads() const override { return 2; }
    std::size_t bytes() const override { return 0; }

private:
    const RodGroup& group_of(std::size_t i) const { return nth(groups_, local_[i].group); }

    std::span<const RodGroup> groups_;
    std::vector<LocalRod> local_;
    std::vector<std::vector<Slot<1>>> states_;
    std::vector<RodBudget> budgets_;
};

} // namespace skein::test
