// Fields of a flow in whole planes, as files and digests have them: where ranks share the rows of a slab, each takes
// some of its planes.
#pragma once

#include "fluid/flow.hpp"
#include "skein/core/index.hpp"

#include <array>
#include <span>
#include <vector>

namespace skein {

/// Between rows and planes. Planes of a rank are those that it would have if ranks shared nothing but planes.
class PlaneExchange {
public:
    /// `ghosts`: planes and rows around those of a rank that come with them.
    PlaneExchange(const Communicator& comm, const FluidGrid& grid, const Pencils& pencils, int ghosts);

    const Slab& planes() const { return planes_; }
    const FieldLayout& layout() const { return layout_; }
    /// From a field of this rank's rows to its planes, and back without ghosts. Collective.
    void to_planes(std::span<const double> rows, std::span<double> planes) const;
    void to_rows(std::span<const double> planes, std::span<double> rows) const;

private:
    /// body(share, j, k) of this rank's rows that go to the planes of each share.
    template <class Body> void for_sent(Body&& body) const;
    /// body(share, j, k) of rows of this rank's planes, as they come from each share.
    template <class Body> void for_received(Body&& body) const;
    Slab planes_of(int share) const;
    Slab rows_with_ghosts(int share) const;
    std::vector<double> exchanged(std::span<const double> sent, std::span<const std::int64_t> counts) const;

    Communicator comm_;
    FluidGrid grid_;
    Pencils pencils_;
    int ghosts_;
    Slab planes_;
    FieldLayout layout_, of_rows_;
};

/// Velocities and pressure, with ghosts.
class FlowPlanes {
public:
    FlowPlanes(const Communicator& comm, const FlowSolver& flow);

    /// What the flow is now, from here to release(), while it must not change: copies where ranks share rows.
    /// Collective.
    void take();
    void release();

    const FlowConstants& constants() const { return flow_.constants(); }
    Slab planes() const { return exchange_.planes(); }
    FieldLayout layout() const { return exchange_.layout(); }
    std::span<const double> velocity(int component) const { return nth(fields_, component); }
    std::span<const double> pressure() const { return fields_[3]; }

private:
    const FlowSolver& flow_;
    PlaneExchange exchange_;
    std::array<std::span<const double>, 4> fields_;
    std::array<std::vector<double>, 4> copies_; ///< none where ranks have whole planes
};

/// What the next step of a flow depends on, without ghosts.
class WholeState {
public:
    /// As it is now, while the flow does not change: copies where ranks share rows. Collective.
    WholeState(const Communicator& comm, FlowSolver& flow);

    const Slab& planes() const { return exchange_.planes(); }
    std::size_t numbers_of_plane() const;
    /// body(row of a field), of a plane of this rank in the order of files.
    template <class Body> void for_rows(int k, Body&& body) {
        const FieldLayout& layout = exchange_.layout();
        for (const std::span<double> field : fields_)
            for (int j = 0; j < layout.ny; ++j)
                body(field.subspan(static_cast<std::size_t>(layout.at(0, j, k)), static_cast<std::size_t>(layout.nx)));
    }
    /// To the flow, after for_rows() has written; its refresh() follows. Collective.
    void put_back();

private:
    FlowSolver& flow_;
    PlaneExchange exchange_;
    std::vector<std::span<double>> fields_;
    std::vector<std::vector<double>> copies_; ///< none where ranks have whole planes
};

} // namespace skein
