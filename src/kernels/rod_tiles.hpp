// Rods at a fixed SIMD width: tiles of W rods of one group, or of strands, each with contiguous and aligned slots. Each
// group or family of groups has the passes of its step.
#pragma once

#include "implicit/cluster_step.hpp"
#include "mechanics/audit.hpp"
#include "mechanics/step_watch.hpp"
#include "parallel/threads.hpp"
#include "skein/core/aligned.hpp"
#include "skein/tiles/tile.hpp"
#include "tiles/clusters.hpp"
#include "tiles/rods.hpp"
#include "tiles/tiling.hpp"

#include <array>
#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

namespace skein {

/// Passes of a step, in order.
template <int W> struct TileProgram {
    TilePasses<W> passes;
    std::vector<std::string_view> names; ///< names of the passes, as in plans
    std::size_t before = 0;              ///< number of passes before rods interact
    std::size_t last = 0;                ///< number of last passes that read the velocities of the step's end
    std::size_t joined = SIZE_MAX;       ///< the pass that makes the step with other tiles; none

    const StepsTogether<W>* together() const {
        return joined == SIZE_MAX ? nullptr : dynamic_cast<const StepsTogether<W>*>(passes[joined].get());
    }
};

/// Joints by number of the assembly.
template <int W> using JointsOfAssemblies = std::vector<std::unique_ptr<ClusterJoints<W>>>;

template <int W> class RodTiles final : public Rods {
public:
    /// `rods` are ordered as by order_of_tiles(). There is one program per group across, then one per family along,
    /// then one for each rod across whose group is heterogeneous, and an audit for each program across or none at all.
    /// `tiling` is that of these rods. Rods take their start state.
    RodTiles(std::span<const RodGroup> groups, std::vector<LocalRod> rods, const Tiling& tiling,
             std::vector<TileProgram<W>> programs, const Threads& threads,
             std::vector<std::shared_ptr<EnergyBudget<W>>> audits = {}, StepWatch watch = {},
             JointsOfAssemblies<W> joints = {});

    bool advance(std::span<const Step> steps, bool check) override;
    void drift(const Step& step) override;
    bool kick(const Step& step, bool check) override;
    void kick_and_drift(const Step& step, const Step& next) override;
    void begin_within(const Step& step) override { prepare({Part::before, {&step, 1}}); }
    std::string near_limit() const override;
    double undamped_share() const override { return undamped_share_.load(std::memory_order_relaxed); }
    std::vector<std::string_view> passes(std::size_t group) const override;
    void renew_formulas() override;
    std::span<const LocalRod> local() const override { return local_; }
    RodPlace place(std::size_t i) const override {
        const RodTile<W>& tile = tiles_[place_[i].tile];
        return {tile.program, tile.number, place_[i].lane};
    }
    void export_rod(std::size_t i, std::span<Slot<1>> out) const override;
    void import_rod(std::size_t i, std::span<const Slot<1>> in) override;
    void read(std::span<const std::size_t> rods, Copy copy, double lag, const RodReader& reader,
              double time) const override;
    void figures(double time, double lag, std::span<RodFigures> out) const override;
    std::uint64_t digest() const override;
    void inspect(std::int64_t step, double dt) const override;
    RodBudget budget(std::size_t i) const override;
    bool budgets_fluid(std::size_t group) const override { return !audits_.empty() && audits_[group]->kicked.any(); }
    bool budgets_steps(std::size_t group) const override { return !audits_.empty() && audits_[group]->by_steps; }
    void set_budget(std::size_t i, const RodBudget& budget) override;
    std::vector<double> memory(std::size_t i) const override;
    void set_memory(std::size_t i, std::span<const double> numbers) override;
    int threads() const override { return threads_.count(); }
    std::vector<PassEffect> dissect(std::size_t i, std::span<const Step> stages) override;
    void keep(std::size_t place) override;
    void go_back(std::size_t place) override;
    double farthest_from(std::size_t place) const override;
    std::size_t bytes() const override;

private:
    enum class Part { whole, before, after }; // parts before and after the coupling
    /// Part of every step of a batch.
    struct StepPart {
        Part which = Part::whole;
        std::span<const Step> steps;
    };
    std::pair<std::size_t, std::size_t> passes(std::size_t program, Part part) const; ///< first, and end
    void prepare(const StepPart& part);
    /// Runs one part of a step and then another over all tiles, in one sweep. With `check`, returns false if a rod is
    /// invalid.
    bool run(const StepPart& first, const StepPart& second, bool check);
    struct Place {
        std::size_t tile;
        int lane;
    };
    /// Rods of a tile along, before their constants are laid out.
    struct AlongLayout {
        std::vector<LaneRange> ranges;
        std::vector<std::size_t> rods; ///< places in local()
    };
    std::vector<AlongLayout> lay_out(const Tiling& tiling);
    /// Adds a tile, and counts it among those of its program.
    RodTile<W>& open(RodTile<W> tile, std::size_t program, std::vector<std::size_t>& tiles_of_program);
    /// Fills tiles across with the first rods of each group, as many as given; the others lie along.
    void fill_across(std::vector<std::int64_t> across, std::vector<std::size_t>& tiles_of_program);
    std::vector<AlongLayout> fill_along(std::span<const AlongTile> tiles, std::vector<std::size_t>& tiles_of_program);
    /// Memory of all tiles, those of a cluster side by side.
    void give_slots();
    /// Tiles of a cluster, and their joints.
    struct Cluster {
        const ClusterJoints<W>* joints;
        bool across;
        std::vector<std::size_t> tiles;
        std::size_t slots = 0;                      ///< with that of the world
        bool muscles = false;                       ///< true where moments of muscles act through joints
        mutable AlignedVector<Pack<W>> memory = {}; ///< of its joints, from step to step
        std::array<AlignedVector<Pack<W>>, 2> kept = {};
        std::shared_ptr<ClusterStep<W>> step = nullptr; ///< of all its tiles as one; null: each by itself
        typename ClusterStep<W>::Tiles stepped = {};
    };
    /// Joints of a cluster take the numbers of its rods.
    void set_rods(const Cluster& cluster) const;
    /// Finds the clusters of the tiles across so far, which are in order and grouped by cluster.
    void find_clusters();
    /// Finds the clusters whose tiles step as one.
    void join_steps();
    /// Sets the slots of the world behind those of clusters.
    void place_worlds();
    /// Advances a cluster by a part of a step.
    void advance_cluster(const Cluster& cluster, const StepPart& part, int thread);
    /// Makes a step of all its tiles as one.
    void step_cluster(const Cluster& cluster, const Step& step, SlotLoad<W>* load, int thread);
    /// Loads of joints, by slot of the cluster.
    JoinedLoad<W>* couple(const Cluster& cluster, const Step& step, int thread) const;
    JoinedRod joined_rod(std::size_t i, int lane) const;
    /// Moments of muscles at the ends of its rods; null where none act, or no joint transmits them.
    const EndMoments<W>* end_moments(const Cluster& cluster, const Step& step, int thread) const;
    void run_passes(const RodTile<W>& tile, SlotLoad<W>* load, std::size_t first, std::size_t end,
                    const Step& step) const;
    void take_start_states(std::vector<AlongLayout> layouts);
    void take_start_states(const RodTile<W>& tile, std::size_t first_rod, std::vector<Slot<1>>& states) const;
    /// Calls f(slot of rod i, slot of its tile, lane) for each of the rod's slots.
    template <class F> void for_slots(std::size_t i, F&& f) const;
    /// Calls f(step) for the implicit steps of all groups.
    template <class F> void for_implicit_steps(F&& f);

    /// Buffers of a thread for copies, kept from one copy to the next.
    struct Reading {
        AlignedVector<Slot<W>> slot;                   ///< slots of a tile
        std::vector<Slot<1>> state;                    ///< states of its rods, one after the other
        std::vector<Mat3d> frames;                     ///< [rod][n]
        AlignedVector<NodeProfileOf<Pack<W>>> profile; ///< profile of a tile
        std::vector<NodeProfile> profiles;             ///< [rod][n + 1]
        std::vector<RodGroup> own;                     ///< groups of rods with sizes of their own, while these are read
        std::array<std::uint64_t, W> hash{};
    };
    /// Group of a single rod with a size of its own, in one of W places of a thread.
    static const RodGroup& own_group(Reading& reading, std::size_t place, const RodGroup& group, std::int64_t index);
    /// Lays out constants, start states and data of passes of a tile along, on any thread.
    void lay_out_along(RodTile<W>& tile, AlongLayout& layout, std::optional<Strands<W>>& strands, Reading& reading);
    /// Tile across in the state of a copy: the tile itself where nothing moves.
    RodTile<W> moved(const RodTile<W>& tile, Copy copy, double lag, Reading& reading) const;
    /// Assembles the states of its rods, and computes frames and hashes where needed.
    void take_apart(const RodTile<W>& tile, Copy copy, double lag, double time, const LocalRod* rods,
                    Reading& reading) const;
    /// Assembles the state of one rod along.
    void take_along(std::size_t i, Copy copy, double lag, double time, Reading& reading) const;
    /// `group`: constants of rod i.
    std::vector<PassEffect> dissect(std::size_t i, const RodGroup& group, std::span<const Step> stages);
    bool healthy(const RodTile<W>& tile);
    /// False where a step of a body is longer than its motion can be followed for.
    bool moves_as_resolved(const RodTile<W>& tile) const;

    /// Rod whose strains leave the least margin of the step.
    struct NearLimit {
        std::size_t rod = 0; ///< place in local()
        Tightest at;
    };
    NearLimit nearest_limit() const;
    std::string text_of(const NearLimit& found) const;
    std::string name_of(std::size_t i) const;

    std::span<const RodGroup> groups_;
    std::vector<LocalRod> local_;
    std::vector<TileProgram<W>> programs_;
    std::vector<std::shared_ptr<EnergyBudget<W>>> audits_;
    const Threads& threads_;
    StepWatch watch_;
    std::atomic<double> undamped_share_ = 0;
    UnsetArray<Slot<W>> slots_; ///< first written by the threads that advance them
    std::array<UnsetArray<Slot<W>>, 2> kept_;
    std::vector<RodTile<W>> tiles_;
    JointsOfAssemblies<W> joints_;
    std::vector<Cluster> clusters_;
    std::map<const ClusterJoints<W>*, std::shared_ptr<ClusterStep<W>>> steps_; ///< of assemblies
    std::vector<std::size_t> alone_;                                           ///< tiles of no cluster
    std::vector<std::size_t> cluster_of_;                         ///< cluster of each tile; none where it is alone
    mutable std::vector<AlignedVector<JoinedLoad<W>>> joined_;    ///< per thread
    mutable std::vector<AlignedVector<EndMoments<W>>> moments_;   ///< per thread, by tile of a cluster
    std::vector<std::vector<const MakesEndMoments<W>*>> muscles_; ///< by program
    std::vector<std::optional<Strands<W>>> strands_;          ///< strands of tiles along, which follow the tiles across
    std::vector<Place> place_;                                ///< place of local()[i]
    std::vector<std::size_t> first_rod_;                      ///< first rod of each tile across, in local()
    std::vector<std::size_t> along_;                          ///< rods that lie along, in local()
    mutable std::vector<Reading> reading_;                    ///< per thread
    mutable std::vector<AlignedVector<SlotLoad<W>>> scratch_; ///< per thread
    std::array<StepPart, 2> sweep_;                           ///< parts of the sweep that runs
    bool check_ = false;                                      ///< true where the sweep that runs checks rods
    std::atomic<bool> valid_ = true, near_ = false;
    std::function<void(std::size_t, int)> advance_; ///< task of a cluster or, after all clusters, of a tile
};

} // namespace skein
