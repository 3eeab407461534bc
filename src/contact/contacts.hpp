// Contacts between rods: candidates, pairs in contact, their forces and memory.                 theory.md section 18
//   list of candidates   rebuilt when elements have moved half its skin
//   pruned list          candidates within a margin, a fraction of the skin; steps check no others until elements have
//                        moved half of it
//   push                 a block of bodies; its work area stays in the second cache:
//     find_touching        candidates that touch, packed                            touching_scan.cpp
//     inherit_springs      springs of contacts that begin near vertices             contact_vertices.cpp
//     push_vertices        terms of vertices                                        vertex_terms.hpp
//     push_near_parallel   forces at the ends of overlaps                           overlap.hpp
//     push_touching        forces eight at a time, loads in the order of pairs      rows.hpp
//   blocks run from the last to the first; loads on other strips are deferred       deferred_loads.hpp
// Threads need no atomic and no order, so the bits of a body's loads depend on the bodies alone. Memory of a contact is
// kept by pair, a cache line each, in place. Memory of other pairs is read before any of a block's changes.
#pragma once

#include "contact/contact_solver.hpp"
#include "contact/deferred_loads.hpp"
#include "contact/pair_list.hpp"
#include "contact/pruned_list.hpp"
#include "contact/response.hpp"
#include "contact/vertex_terms.hpp"
#include "contact/vertices.hpp"
#include "core/closest_points.hpp"

#include <mutex>
#include <optional>

namespace skein {

template <class P> class MeetingOfSegment;
using SegmentMeeting = MeetingOfSegment<double>;

class Contacts final : public ContactSolver {
public:
    Contacts(ContactScene scene, const Threads& threads);
    ~Contacts() override;

    bool worth_keeping() const override { return !list_.first.empty() && !rebuild_pays(); }
    bool holds(const Exposure& bodies) override;
    double next_skin() override;
    void prepare_rebuild(const Exposure& bodies) override;
    std::int64_t search(const Exposure& near, std::span<std::uint8_t> wanted) override;
    const Candidates& found() const override { return found_; }
    void finish_rebuild(const Exposure& bodies, std::span<const std::uint32_t> slot, std::int64_t inactive) override;
    void restore(std::span<const SavedContact> kept, const BinnedTotal& friction_work,
                 const BinnedTotal& viscous_work) override;
    void keep(std::size_t place, const Exposure& bodies) override;
    void go_back(std::size_t place, const Exposure& bodies) override;
    const SumBins& energy_bins() const override { return bins_; }
    std::vector<SavedContact> saved(const Exposure& bodies) const override;
    void set_tangents(std::span<SlotTangent> tangents) override { tangents_ = tangents; }
    void begin(const Exposure& bodies, double time, double h, std::span<ExertedLoad> loads, bool may_repeat) override;
    void finish(const Exposure& bodies, double h, std::span<ExertedLoad> loads) override;
    std::span<const std::uint8_t> touched() const override { return touched_; }
    ContactFigures figures() const override { return figures_; }
    std::vector<double> work(const Exposure& bodies) const override;
    std::vector<double> normal_energies(const Exposure& bodies) const override;
    std::vector<Contact> active(const Exposure& bodies) const override;
    void arrived_in(double drift) override { drift_ = drift; }
    double largest_displacement(const Exposure& bodies) override;
    void set_largest_displacement(double way) override { largest_displacement_ = way; }
    std::span<const SideChange> side_changes() const override { return side_changes_; }

private:
    /// Figures of the contacts of a block.
    struct alignas(64) BlockFigures {
        std::int64_t active = 0, near = 0;
        double weight = 0, max_overlap = 0, max_stiffness = 0;
        BinnedSum<double> elastic_energy, friction_work, viscous_work;
    };
    static constexpr int places_at_once = 8;
    using Places = Vec3<Pack<places_at_once>>;
    struct PairContact;
    struct WorkArea;
    struct Sums;
    /// An element in contact with a box, or two boxes, of which the first one is the element: sums over all points, and
    /// their mean place.
    struct BoxContact {
        bool touches = false, intersect = false; ///< the latter of two boxes without their rounding
        ContactForce<Pack<1>> force{};
        ContactMemory<double> memory{};
        ElementLoad<double> on_element{}, on_box{};
        double s = 0, overlap = 0, diameter = 1, weight = 1;
        Vec3d place{}, normal{}, slip{}; ///< as of Contact, the element being the first

        /// Adds a force on the axis of the element at share s, and its opposite on the box; `arm`: from its centre.
        void exert(double s, const Vec3d& force, const Vec3d& arm) {
            on_element.first += (1 - s) * force;
            on_element.second += s * force;
            on_box.first -= force;
            on_box.couple -= cross(arm, force);
        }
    };

    static Places places(const Exposure& bodies, std::size_t first);
    static Pack<places_at_once> farthest_squared(const Exposure& bodies, std::size_t first, double skin);
    /// State of the lists: true where they have all pairs that may touch.
    struct Holding {
        bool list, pruned;
        double moved; ///< the longest way since pruning was last due, of elements in pairs, m
    };
    /// Consecutive tiles of places.
    struct TileRun {
        std::size_t begin, end;
        bool paired; ///< some pair may have an element of them
    };
    Holding check_lists(const Exposure& bodies, std::span<const TileRun> runs);
    void cut_tiles(const Exposure& bodies);
    void request_pruning(const Exposure& bodies);
    double idle_share() const;
    bool rebuild_pays() const;
    std::vector<SavedContact> touching_pairs(const Exposure& bodies, bool of_own) const;
    void place_saved(const Exposure& bodies);
    void set_springs(double h);

    void run_strips(const Exposure& bodies, double h, std::span<const std::uint32_t> strips, bool prune,
                    std::span<ExertedLoad> loads);
    void add_deferred(const Exposure& bodies, std::span<ExertedLoad> loads);
    /// A block, as the stages of its contacts see it.
    struct Work {
        const Exposure& bodies;
        double h;
        const ContactBlock& block;
        std::uint32_t last_slot; ///< end of the strip; loads beyond are deferred
        DeferredLoads::Deferring& deferring;
        BlockFigures& figures;
        ExertedLoad* load;
        SlotTangent* tangent;
        std::size_t number; ///< number of the block
        bool prune;         ///< all candidates are checked
    };
    void push(const Work& work, WorkArea& area);
    void save_memory(std::uint32_t begin, std::uint32_t end);
    void restore_memory(std::uint32_t begin, std::uint32_t end);
    template <bool prune> class TouchingScan;
    template <bool prune> void find_touching(const Work& work, WorkArea& area);
    bool overlaps(const WorkArea& area, std::uint32_t n) const;
    void inherit_springs(const Work& work, const WorkArea& area);
    void push_vertices(const Work& work, WorkArea& area, Sums& sums);
    void push_near_parallel(const Work& work, WorkArea& area, Sums& sums);
    template <bool tangents> class TouchingForces;
    void push_touching(const Work& work, const WorkArea& area, Sums& sums);
    void push_boxes(const Work& work, WorkArea& area);
    template <class Row> void exert(const Work& work, std::uint32_t slot, const Row& first, const Row& second);
    void exert(const Work& work, std::uint32_t slot, const ElementLoad<double>& load);
    void exert_at(const Work& work, std::uint32_t slot, const ForceRow& row, bool at_end);
    void stiffen(const Work& work, std::uint32_t slot, const PointTangent& tangent);
    void stiffen_at_box(const Work& work, std::uint32_t pair, const BoxContact& contact);
    /// Pairs whose first element is near a vertex; they are numbered so for as long as that matters.
    template <int W> struct NearVertex {
        std::uint32_t slot[2][W];
        unsigned at_start[2] = {0, 0}, at_end[2] = {0, 0}; ///< lanes near the start and near the end, as bits
        Pack<W> share[2], sine_squared{0.0};               ///< places on the elements; of the angle between them
        Vec3<Pack<W>> apart{};                             ///< from the first to the second

        /// A pair in a lane, `turned` if its second element is to be the first; `vertices` that it is near, as bits of
        /// vertices_of_pair().
        void put(int l, Pair pair, unsigned vertices, bool turned);
    };
    template <int W, int vertices_1, int vertices_2>
    VertexTerms<Pack<W>> at_vertices(const Exposure& bodies, const NearVertex<W>& pairs) const;
    VertexTerms<Pack<1>> at_vertices(const Exposure& bodies, std::uint32_t pair,
                                     const ClosestPoints<Pack<1>>& at) const;
    template <int vertices_1, int vertices_2>
    void take_packs(const Work& work, WorkArea& area, Sums& sums, std::span<const std::uint32_t> places);
    template <int vertices_1, int vertices_2, int W>
    void take_vertices(const Work& work, WorkArea& area, Sums& sums, const std::uint32_t* places, int valid);
    void exert_at_vertices(const Work& work, const WorkArea& area, bool both);
    std::uint32_t neighbour(const Exposure& bodies, std::uint32_t slot, bool at_end) const;
    void end_contact(const Work& work, std::uint32_t pair);
    FrictionSpring<double> inherited_spring(const Exposure& bodies, std::uint32_t pair, double s, double t) const;
    /// A pair whose spring another one follows; `turned`: its first element is on the body of the other's second.
    struct Inherited {
        std::uint32_t pair;
        bool turned = false;
    };
    Inherited spring_at_vertex(const Exposure& bodies, std::uint32_t pair, int da, int db, std::uint32_t own) const;
    Inherited spring_at_seam(const Exposure& bodies, std::uint32_t pair, int da, int db, Inherited otherwise) const;
    std::optional<std::uint32_t> beyond_seam(const Exposure& bodies, std::uint32_t slot, int step) const;
    template <int W> struct Ends;
    template <int W> Ends<W> at_ends(const Exposure& bodies, double h, const Pair* pair, const std::uint8_t* vertices,
                                     Pack<W> sine_squared, Pack<W> weight, Pack<W> vertex_energy,
                                     Pack<W> distance) const;
    PairContact evaluate_pair(const Exposure& bodies, std::uint32_t pair) const;
    // Elements that change sides: side_changes.cpp.
    using BodyPair = std::array<std::int64_t, 2>; ///< gids, the lower one first
    static BodyPair bodies_of(const SceneSlots& scene, std::int64_t a, std::int64_t b);
    bool is_overlapping(const BodyPair& bodies) const;
    void update_overlapping();
    void restore_overlapping(const Exposure& bodies);
    std::optional<SideChange> side_change(const Exposure& bodies, Pair pair);
    std::optional<SideChange> boxes_intersect(const Exposure& bodies, Pair pair);
    void check_side_changes(const Exposure& bodies, std::span<const std::uint32_t> pairs);
    bool moves_far(const Exposure& bodies, std::size_t slot) const;
    void mark_far_moves(const Exposure& bodies);
    void find_passed(const Exposure& near, std::span<std::uint8_t> wanted);
    void check_far_moves(const Exposure& bodies);
    const PartBox* box_at(const Exposure& bodies, std::uint32_t slot) const;
    void find_boxes(const Exposure& bodies);
    class BoxPair;
    struct BoxPressure;
    BoxPressure press_on_box(const BoxPair& pair, const SegmentMeeting& meeting, const ContactNumbers<Pack<1>>& law,
                             double h, BoxContact& out) const;
    void rub_on_box(const BoxPair& pair, const BoxPressure& mean, const ContactNumbers<Pack<1>>& law, double h,
                    ContactMemory<Pack<1>>& memory, BoxContact& out) const;
    double weight_of(const BoxPair& pair, const SegmentMeeting& meeting) const;
    ContactMemory<double> memory_before(const Exposure& bodies, std::uint32_t pair, double s, bool box_first) const;
    BoxContact evaluate_box(const Exposure& bodies, double h, std::uint32_t number,
                            const ContactMemory<double>* now = nullptr) const;
    BoxContact evaluate_boxes(const Exposure& bodies, double h, std::uint32_t number,
                              const ContactMemory<double>* now) const;
    bool box_is_first(const Exposure& bodies, std::uint32_t pair) const;
    Contact contact_with_box(const Exposure& bodies, std::uint32_t pair) const;
    double normal_energy_with_box(const Exposure& bodies, std::uint32_t pair) const;
    /// Nearest points, what vertices take, and what pushes at the ends.
    struct Points;
    Points points(const Exposure& bodies, std::uint32_t pair) const;
    template <int W> ContactNumbers<Pack<W>> numbers(const Exposure& bodies, const Pair* pair) const;
    /// Numbers for two bodies, where some rods have sizes of their own.
    ContactNumbers<double> own_numbers(ContactNumbers<double> of_groups, const Window& a, const Window& b) const;
    void set_spring(ContactNumbers<double>& numbers, double mobility) const;

    const ContactScene scene_;
    const ContactLaws& laws_ = scene_.laws;
    const SumBins bins_{scene_.largest_energy}; ///< bins of energies and works, J
    ContactKinds kinds_;
    bool remembers_;                              ///< contacts have memory to keep
    bool has_rings_;                              ///< among the groups
    std::vector<ContactNumbers<double>> numbers_; ///< now, as the laws are ordered
    bool own_numbers_ = false;                    ///< some rods have numbers by their own masses
    double spring_step_ = 0;                      ///< of springs of friction, s
    const Threads& threads_;
    BroadPhase search_;
    Candidates found_; ///< between search and settle
    PairList list_;
    DeferredLoads deferred_;
    AlignedVector<Places> place_; ///< places of nodes when the list was made, m
    /// By tile of nodes: squares of how far they may go, m^2, before two that are not in the list touch.
    AlignedVector<Pack<places_at_once>> farthest_squared_;
    std::vector<TileRun> all_tiles_, ghosts_tiles_;
    PrunedList pruned_;
    double margin_ = 0;               ///< of the pruned list, as the skin is of the list, m
    AlignedVector<Places> pruned_at_; ///< places of nodes when pruning was last due, m
    bool prunes_[2] = {true, true};   ///< strips in now_ and in later_ that prune in the next step
    /// Status of a pair, as bits.
    enum : std::uint8_t { touching = 1, began_deep = 2 }; // the latter only where contacts are kept
    std::vector<std::uint8_t> status_;                    ///< by pair; padded
    AlignedVector<ContactMemory<double>> memory_;         ///< by pair, a cache line each; zeros where it does not touch
    std::vector<std::uint32_t> box_pairs_;                ///< pairs with a box, rising
    std::vector<std::uint8_t> has_box_;                   ///< by pair, padded; empty where no pair has one
    std::vector<SavedContact> saved_;                     ///< until they have their places in a list; rising
    /// Contacts to go back to.
    struct Kept {
        std::vector<SavedContact> contacts; ///< rising
        std::int64_t rebuilds = 0;          ///< number of the list that they are in
        std::vector<BinnedTotal> works;     ///< of friction and of dashpots
    };
    std::array<Kept, 2> kept_;
    std::vector<BlockFigures> block_figures_;     ///< by block
    std::vector<std::uint32_t> now_, later_;      ///< strips that need no ghosts, and those that do
    std::vector<std::vector<std::size_t>> next_;  ///< by thread, of DeferredLoads::Deferring
    std::vector<std::unique_ptr<WorkArea>> area_; ///< by thread
    std::vector<std::uint8_t> touched_;           ///< by window
    std::span<SlotTangent> tangents_;             ///< by slot; none where nothing wants them
    std::vector<std::uint8_t> edge_;              ///< by slot: an end of a window; padded
    bool may_repeat_ = false;                 ///< the step that is under way, on this rank alone until ghosts arrive
    std::vector<std::uint8_t> status_before_; ///< status of pairs in now_ before the step
    AlignedVector<ContactMemory<double>> memory_before_; ///< memory of pairs in now_ that touched before the step
    double drift_ = 0, time_ = 0;                        ///< s; of the step that is under way
    bool watches_ = false;                               ///< for changes of sides, in that step
    double moved_ = 0;               ///< Holding::moved of the step before, 0 where pruning was due in it
    double displacement_ = HUGE_VAL; ///< within that step no element in pairs has moved farther, m
    double largest_displacement_ =
        0; ///< largest displacement of an element within that step, over all ranks, m; set before a search
    std::vector<std::uint8_t> far_;          ///< by slot: own elements that have moved far in it; empty: none has
    std::vector<std::int64_t> far_in_scene_; ///< these as slots of the scene, for a search
    std::vector<std::array<std::int64_t, 2>>
        passed_;        ///< pairs that may have changed sides unseen, as slots of the scene
    std::mutex noting_; ///< guard of the members below
    std::vector<SideChange> side_changes_;
    bool begins_ = true;                ///< no step has been looked at: bodies that are in each other may be
    std::vector<BodyPair> overlapping_; ///< bodies deep in each other since they began so; rising
    std::vector<BodyPair> overlap_now_; ///< bodies that still overlap in this step
    std::int64_t age_ = 0;              ///< steps since the list was made
    std::int64_t inactive_ = 0;         ///< pairs, of all ranks, that did not touch then
    ContactFigures figures_{bins_};
};

} // namespace skein
