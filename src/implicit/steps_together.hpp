// Step of the tiles of a cluster as one: what solves for it asks of the pass of each tile.
#pragma once

#include "implicit/cluster_rows.hpp"
#include "implicit/row_terms.hpp"
#include "skein/tiles/tile.hpp"

#include <memory>

namespace skein {

/// Pass whose step joins those of other tiles. It has a room for each tile during the step.
template <int W> class StepsTogether {
public:
    struct Room {
        virtual ~Room() = default;
    };
    virtual ~StepsTogether() = default;
    virtual std::unique_ptr<Room> make_room() const = 0;
    /// Sets the first guess.
    virtual void begin_step(const RodTile<W>& rod, const Step& step, Room& room) const = 0;
    /// False where one linear solution makes the step.
    virtual bool corrects() const { return true; }
    /// Adds the rows of a correction at the present guess. `load`: loads of passes before, or room, [slots]; `number`:
    /// of the correction.
    virtual void add_rows(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step, Room& room, int number,
                          RowsOfTile<W>& rows) const = 0;
    /// Constants of its rows, which say what they hold.
    virtual const RowTerms<W>& terms() const = 0;
    /// True where turns of rows are about axes of the lab, not of the element.
    virtual bool turns_about_lab() const = 0;
    /// Takes the solution, and returns its size over the length or in rad.
    virtual Pack<W> take_correction(const RodTile<W>& rod, const ClusterRows<W>& rows, std::size_t first,
                                    Room& room) const = 0;
    /// Takes a share of it; 0 where a lane is done.
    virtual void move_by(const RodTile<W>& rod, const Step& step, const Pack<W>& share, Room& room) const = 0;
    /// 1 in lanes where a contact begins that is too stiff for its stage.
    virtual Pack<W> begins_to_touch(const RodTile<W>&) const { return Pack<W>(0.0); }
    /// Such lanes put off going on to the last stage, before end_step().
    virtual void put_off(const RodTile<W>&, const Step&, const Pack<W>&) const {}
    /// Ends the step. `wrong`: NaN where corrections have not converged.
    virtual void end_step(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step, const Pack<W>& wrong,
                          Room& room) const = 0;
    /// True where it books the loads of the end.
    virtual bool books() const { return false; }
    /// Place on a body, from its centre, as the state of a correction has it, lab, m.
    virtual Vec3<Pack<W>> arm(const RodTile<W>& body, const Vec3d& arm, const Room& room) const = 0;
    /// Takes a node along with another one, in some lanes.
    virtual void follow(const RodTile<W>& rod, int k, const Vec3<Pack<W>>& position, const Vec3<Pack<W>>& velocity,
                        const Mask<W>& lanes, Room& room) const = 0;
    /// Small displacement for slopes, m.
    virtual double apart() const = 0;
    /// Number of the last row of a tile.
    virtual int last_row(const RodTile<W>& rod) const = 0;
};

} // namespace skein
