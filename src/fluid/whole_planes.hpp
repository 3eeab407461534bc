// Fields of a flow in whole planes for files and digests. Ranks that share the rows of a slab take some of its planes
// each.
#pragma once

#include "fluid/flow.hpp"
#include "skein/core/index.hpp"

#include <array>
#include <span>
#include <vector>

namespace skein {

/// Exchange between rows and planes. A rank has the planes that it would have if no rows were shared.
class PlaneExchange {
public:
    /// `ghosts` counts planes and rows of ghosts that are exchanged too.
    PlaneExchange(const Communicator& comm, const FluidGrid& grid, const Pencils& pencils, int ghosts);

    const Slab& planes() const { return planes_; }
    const FieldLayout& layout() const { return layout_; }
    /// Copies a field from this rank's rows to its planes. Collective.
    void to_planes(std::span<const double> rows, std::span<double> planes) const;
    /// Copies a field back, without ghosts. Collective.
    void to_rows(std::span<const double> planes, std::span<double> rows) const;

private:
    /// Calls body(share, j, k) for this rank's rows in planes of each share.
    template <class Body> void for_sent(Body&& body) const;
    /// Calls body(share, j, k) for rows of this rank's planes from each share.
    template <class Body> void for_received(Body&& body) const;
    /// Sends rows of `from` and receives rows of `to`, which both functions list.
    template <class ForSent, class ForReceived>
    void exchange(std::span<const double> from, const FieldLayout& of_from, ForSent&& for_sent_rows,
                  std::span<double> to, const FieldLayout& of_to, ForReceived&& for_received_rows) const;
    Slab planes_of(int share) const;
    Slab rows_with_ghosts(int share) const;
    /// Sends `counts` rows to each share and returns received rows. Collective.
    std::vector<double> exchanged(std::span<const double> sent, std::span<const std::int64_t> counts) const;

    Communicator comm_;
    FluidGrid grid_;
    Pencils pencils_;
    int ghosts_;
    Slab planes_;
    FieldLayout layout_, of_rows_;
};

/// Velocities and pressure with ghosts.
class FlowPlanes {
public:
    FlowPlanes(const Communicator& comm, const FlowSolver& flow);

    /// Takes the present flow, which must not change until release(). It is copied if ranks share rows. Collective.
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
    std::array<std::vector<double>, 4> copies_; ///< empty if ranks have whole planes
};

/// FlowSolver::state() without ghosts.
class WholeState {
public:
    /// Takes the present state, which must not change meanwhile. It is copied if ranks share rows. Collective.
    WholeState(const Communicator& comm, FlowSolver& flow);

    const Slab& planes() const { return exchange_.planes(); }
    std::size_t numbers_of_plane() const;
    /// Calls body(row of a field) for a plane of this rank, in the order of files.
    template <class Body> void for_rows(int k, Body&& body) {
        const FieldLayout& layout = exchange_.layout();
        for (const std::span<double> field : fields_)
            for (int j = 0; j < layout.ny; ++j) body(field.subspan(to_index(layout.at(0, j, k)), to_index(layout.nx)));
    }
    /// Copies rows that for_rows() has written to the flow; its refresh() must follow. Collective.
    void put_back();

private:
    FlowSolver& flow_;
    PlaneExchange exchange_;
    std::vector<std::span<double>> fields_;
    std::vector<std::vector<double>> copies_; ///< empty if ranks have whole planes
};

} // namespace skein
