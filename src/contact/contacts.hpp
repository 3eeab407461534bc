// Contacts between rods: who may touch, who does, and what that does to them.                                theory.md section 18
//   list of candidates, renewed when elements have moved half its skin
//   push:    of a block of rods the pairs that touch, packed; their forces eight at a time; loads of both elements in order of
//            pairs, but those of second elements in other blocks, which go into the mail
//   receive: what others have sent; a thread that goes on along the rods does it as it pushes, while all is at hand
// No atomic, no order among threads: the bits of a rod's loads depend on the rods alone. A contact's friction spring is kept by
// pair. Where a contact passes over a joint both elements touch, one at its end: that one follows the other's spring, and has it
// when it takes over. Cost: see docs/performance.md.
#pragma once

#include "contact/contact_solver.hpp"
#include "contact/mail.hpp"
#include "contact/pair_list.hpp"
#include "contact/response.hpp"
#include "contact/transposed.hpp"
#include "core/timer.hpp"

namespace skein {

class Contacts final : public ContactSolver {
public:
    Contacts(const Capsules& capsules, ContactLaws laws, const Threads& threads, std::vector<std::uint8_t> owned_rods = {});

    void restore(std::span<const KeptContact> kept, double rubbed = 0, double damped = 0) override;
    std::vector<KeptContact> kept() const override;
    void evaluate(const Capsules& capsules, double time, double h, AlignedVector<ContactLoad>& loads) override;
    std::span<const std::uint8_t> touched_rods() const override { return touched_; }
    ContactFigures figures() const override { return figures_; }
    std::vector<Contact> active(const Capsules& capsules) const override;

private:
    /// What a block finds.
    struct alignas(64) Finds {
        std::int64_t active = 0;
        double deepest = 0, stiffest = 0, stored = 0, rubbed = 0, damped = 0;
    };
    /// What contacts left behind, and the x that they go on from.
    template <int W> struct Remembered {
        ContactMemory<Pack<W>> own;
        Vec3<Pack<W>> from;
    };
    static constexpr int places_at_once = 8;
    using Places = Vec3<Pack<places_at_once>>;
    struct Alone;
    struct Packed;
    struct Sums;

    bool owns(std::size_t rod) const { return owned_.empty() || owned_[rod]; }
    static Places places(const Capsules& capsules, std::size_t tile);
    bool far(const Capsules& capsules, const RodBlock& block) const;
    bool is_wasteful() const;
    bool evaluate_listed(const Capsules& capsules, double h, AlignedVector<ContactLoad>& loads);
    void renew_list(const Capsules& capsules);
    void carry_over(const PairList& fresh, const Capsules& capsules);

    void push(const Capsules& capsules, double h, std::size_t block, std::vector<std::size_t>& post,
              AlignedVector<ContactLoad>& loads);
    void receive(const Capsules& capsules, std::size_t block, AlignedVector<ContactLoad>& loads);
    void pack(const Capsules& capsules, std::uint32_t begin, std::uint32_t end, Packed& packed, Finds& finds);
    void push_packed(const Capsules& capsules, double h, const Packed& packed, const RodBlock& block,
                     std::vector<std::size_t>& post, Finds& finds, Sums& sums, AlignedVector<ContactLoad>& loads);
    template <int W> Remembered<W> memory_before(const std::uint32_t* pair, Pack<W> s, Pack<W> t) const;
    std::uint32_t spring_at_joint(std::uint32_t pair, int da, int db, std::uint32_t own) const;
    Alone alone(const Capsules& capsules, double h, std::uint32_t pair, const ContactMemory<double>* now = nullptr) const;
    template <int W> ContactNumbers<Pack<W>> numbers(const Capsules& capsules, const std::uint32_t* pair) const;

    ContactLaws laws_;
    ContactKinds kinds_;
    bool remembers_;                              ///< contacts have memory to keep
    std::vector<ContactNumbers<double>> numbers_; ///< now, as the laws are ordered
    const Threads& threads_;
    std::vector<std::uint8_t> owned_; ///< by rod; none: all
    BroadPhase search_;
    double diameter_;                      ///< mean of the elements', m
    std::vector<std::int32_t> first_slot_; ///< as in the capsules
    PairList list_;
    Mail mail_;
    AlignedVector<Places> place_; ///< of nodes when the list was made, so many at once
    /// What a pair is doing, as bits.
    enum : std::uint8_t { touching = 1, inside = 4 };           ///< inside: at no end of either element
    std::vector<std::uint8_t> what_, was_;                      ///< by pair; now and before; padded
    AlignedVector<ContactMemory<double>> memory_, last_memory_; ///< by pair, a cache line each; behind them one of zeros
    std::vector<Finds> finds_;                                  ///< by block
    std::vector<std::vector<std::size_t>> post_;                ///< by thread: where next letters go, by block
    std::vector<std::uint8_t> touched_;
    std::int64_t age_ = 0;  ///< steps since the list was made
    std::int64_t idle_ = 0; ///< pairs, of all ranks, that did not touch then
    ContactFigures figures_;
};

} // namespace skein
