// Contacts between rods: candidates, pairs in contact, their forces and memory.                              theory.md section 18
//   list of candidates, rebuilt when elements have moved half its skin
//   push:  of a block of bodies the pairs that touch, packed; their forces eight at a time; loads of both elements in order of
//          pairs, but those of second elements in other blocks, which are deferred (drawing: deferred_loads.hpp)
//   add:   loads that other blocks have deferred; a thread that goes on along the bodies does it as it pushes, while all is at hand
// No atomic, no order among threads: the bits of a body's loads depend on the bodies alone. A contact's friction spring is kept by
// pair. A contact that passes over a joint is shared by both elements (joints.hpp); the pair that comes into it goes on from the
// spring of the other. Cost: see docs/performance.md.
#pragma once

#include "contact/contact_solver.hpp"
#include "contact/deferred_loads.hpp"
#include "contact/joints.hpp"
#include "contact/pair_list.hpp"
#include "contact/response.hpp"

#include <optional>

namespace skein {

class Contacts final : public ContactSolver {
public:
    Contacts(ContactScene scene, const Threads& threads);

    bool lasts() const override { return !list_.first.empty() && !rebuild_pays(); }
    bool holds(const Exposure& bodies) const override;
    double next_skin() override;
    void let_go(const Exposure& bodies) override;
    std::int64_t search(const Exposure& near, std::span<std::uint8_t> wanted) override;
    const Candidates& found() const override { return found_; }
    void settle(const Exposure& bodies, std::span<const std::uint32_t> slot, std::int64_t inactive) override;
    void restore(std::span<const KeptContact> kept, double friction_work = 0, double viscous_work = 0) override;
    std::vector<KeptContact> kept(const Exposure& bodies) const override;
    bool begin(const Exposure& bodies, double time, double h, std::span<ExertedLoad> loads, bool look) override;
    void finish(const Exposure& bodies, double h, std::span<ExertedLoad> loads) override;
    std::span<const std::uint8_t> touched() const override { return touched_; }
    ContactFigures figures() const override { return figures_; }
    std::vector<double> work(const Exposure& bodies) const override;
    std::vector<Contact> active(const Exposure& bodies) const override;

private:
    /// Figures of the contacts of a block.
    struct alignas(64) BlockFigures {
        std::int64_t active = 0;
        double weight = 0, max_overlap = 0, max_stiffness = 0, elastic_energy = 0, friction_work = 0, viscous_work = 0;
    };
    /// Memory of contacts from the step before, and the springs that they go on from.
    template <int W> struct Remembered {
        ContactMemory<Pack<W>> own;
        FrictionSpring<Pack<W>> from;

        static Remembered of_spring(const FrictionSpring<double>& spring) {
            const FrictionSpring<Pack<W>> it{broadcast<W>(spring.x), spring.stiffness};
            return {{.spring = it}, it};
        }
    };
    static constexpr int places_at_once = 8;
    using Places = Vec3<Pack<places_at_once>>;
    struct PairContact;
    struct Packed;
    struct Sums;
    /// An element in contact with a box, with all of its points: sums, and both of memory and place of the nearest one.
    struct BoxContact {
        bool touches = false;
        ContactForce<Pack<1>> force{};
        ContactMemory<double> memory{};
        ElementLoad on_element{}, on_box{};
        double s = 0, overlap = 0, diameter = 1, weight = 1;
        Vec3d place{}, normal{}, slip{}; ///< as of Contact, the element being the first
    };

    static Places places(const Exposure& bodies, std::size_t tile);
    bool far(const Exposure& bodies, std::size_t first_slot, std::size_t last_slot) const;
    bool rebuild_pays() const;
    void swap_steps();
    std::vector<KeptContact> touching_pairs(const Exposure& bodies, bool of_own) const;
    void place_kept(const Exposure& bodies);

    void push(const Exposure& bodies, double h, std::size_t block, std::vector<std::size_t>& next, std::span<ExertedLoad> loads);
    void add_deferred(const Exposure& bodies, std::size_t block, std::span<ExertedLoad> loads);
    /// Nearest points, and the share that a pair has in a contact with its neighbours'.
    template <int W> struct Crossing {
        ClosestPoints<Pack<W>> at;
        Pack<W> weight;
    };
    template <int W> Crossing<W> crossing_at_joints(const Exposure& bodies, Pack<W> s, Pack<W> t, const Pair* pair,
                                                    const std::int8_t (*sides)[2]) const;
    Crossing<1> crossing(const Exposure& bodies, std::uint32_t pair) const;
    static const ExposedNode* neighbour_node(const Exposure& bodies, std::uint32_t slot, int side);
    void end_contact(const Exposure& bodies, std::uint32_t pair, BlockFigures& figures) const;
    void weigh(const Exposure& bodies, Packed& packed, BlockFigures& figures);
    void pack(const Exposure& bodies, std::uint32_t begin, std::uint32_t end, Packed& packed, BlockFigures& figures);
    void push_packed(const Exposure& bodies, double h, const Packed& packed, const ContactBlock& block,
                     std::vector<std::size_t>& next, BlockFigures& figures, Sums& sums, std::span<ExertedLoad> loads);
    template <int W> Remembered<W> memory_before(const Exposure& bodies, const std::uint32_t* pair, Pack<W> s, Pack<W> t) const;
    /// A pair whose spring another one follows; `turned`: its first element is on the body of the other's second.
    struct Followed {
        std::uint32_t pair;
        bool turned = false;
    };
    Followed spring_at_joint(const Exposure& bodies, std::uint32_t pair, int da, int db, std::uint32_t own) const;
    Followed spring_at_seam(const Exposure& bodies, std::uint32_t pair, int da, int db, Followed otherwise) const;
    std::optional<std::uint32_t> beyond_seam(const Exposure& bodies, std::uint32_t slot, int step) const;
    PairContact evaluate_pair(const Exposure& bodies, double h, std::uint32_t pair,
                              const ContactMemory<double>* now = nullptr) const;
    const PartBox* box_at(const Exposure& bodies, std::uint32_t slot) const;
    void find_boxes(const Exposure& bodies);
    BoxContact evaluate_box(const Exposure& bodies, double h, std::uint32_t pair, const ContactMemory<double>* now = nullptr) const;
    Contact contact_with_box(const Exposure& bodies, std::uint32_t pair) const;
    void push_boxes(const Exposure& bodies, double h, const ContactBlock& block, std::vector<std::size_t>& next,
                    BlockFigures& figures, std::span<ExertedLoad> loads);
    template <int W> ContactNumbers<Pack<W>> numbers(const Exposure& bodies, const std::uint32_t* pair) const;

    const ContactScene scene_;
    const ContactLaws& laws_ = scene_.laws;
    ContactKinds kinds_;
    bool remembers_;                              ///< contacts have memory to keep
    bool has_rings_;                              ///< among the groups
    std::vector<ContactNumbers<double>> numbers_; ///< now, as the laws are ordered
    const Threads& threads_;
    BroadPhase search_;
    Candidates found_; ///< between search and settle
    PairList list_;
    DeferredLoads deferred_;
    AlignedVector<Places> place_; ///< of nodes when the list was made, so many at once
    /// Status of a pair, as bits.
    enum : std::uint8_t { touching = 1 };
    std::vector<std::uint8_t> status_, previous_status_;        ///< by pair; now and before; padded
    AlignedVector<ContactMemory<double>> memory_, last_memory_; ///< by pair, a cache line each; behind them one of zeros
    std::vector<std::uint32_t> box_pairs_;                      ///< pairs with a box, rising
    std::vector<std::uint8_t> has_box_;                         ///< by pair, padded; empty where no pair has one
    std::vector<KeptContact> kept_;                             ///< until they have their places in a list; rising
    std::vector<BlockFigures> block_figures_;                   ///< by block
    std::vector<std::size_t> now_, later_;                      ///< blocks that need no ghosts, and those that do
    std::vector<std::vector<std::size_t>> next_;                ///< by thread: where next loads are deferred to, by block
    std::vector<std::uint8_t> touched_, added_;                 ///< by window; by block, of this step
    bool begun_ = false;                                        ///< a step
    std::int64_t age_ = 0;                                      ///< steps since the list was made
    std::int64_t inactive_ = 0;                                 ///< pairs, of all ranks, that did not touch then
    ContactFigures figures_;
};

} // namespace skein
