// Bodies with sharp surfaces: each stage sets velocities of nodes within them, and nodes next to them get an implicit
// change of the centre weight of the Laplacian. theory.md (139)
#pragma once

#include "fluid/stage_forcing.hpp"
#include "immersion/given_momentum.hpp"
#include "immersion/held_forcing.hpp"
#include "immersion/held_vectors.hpp"
#include "immersion/rigid_fit.hpp"
#include "immersion/sharp_nodes.hpp"
#include "immersion/surface_work.hpp"
#include "parallel/communicator.hpp"

#include <array>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace skein {

/// All results have the same bits on any ranks and threads.
class SharpForcing final : public HeldForcing {
public:
    SharpForcing(const Communicator& comm, const Threads& threads, const FluidGrid& grid, double kinematic_viscosity,
                 std::vector<SharpBody> bodies, int across = 1);

    /// Changes velocities of an explicit stage before its markers act. Collective.
    void act(const FlowStage& stage);
    /// Adds pushes by forces of the last step to the velocity of an implicit stage. Collective.
    void add_held_forces(const FlowStage& stage);
    void find_slips(const FlowStage& stage) override;
    double largest_slip() const override;
    void push(const FlowStage& stage) override;
    void find_response(const FlowStage& stage) override;
    void add_terms(std::array<std::vector<double>, 2>& terms) const override;
    void take(double times, const FlowStage& stage) override;
    void end_sweeps(const FlowStage& stage) override;
    /// Forces of implicit stages by node and body, m/s^2, along x in place of the node's direction.
    const HeldVectors& held() const { return held_; }
    /// Continues from saved() of held(). Not collective.
    void restore_held(std::span<const double> saved);
    bool changed(int plane) const { return nodes_.reaches(plane); }

    /// Since reset_given(); moments of rods are about their first nodes. All ranks have all bodies.
    const std::vector<GivenMomentum>& given() const { return given_; }
    void reset_given() { std::fill(given_.begin(), given_.end(), GivenMomentum{}); }
    /// Finds the work of bodies in each stage from now on.
    void measure_work() { work_.emplace(comm_, h_ * h_ * h_); }
    std::optional<SurfaceWorkSums>& work() { return work_; }
    const std::optional<SurfaceWorkSums>& work() const { return work_; }
    /// In the last stage.
    const GivenMomentum& given_in_stage(std::size_t body) const { return of_piece_[nodes_.first_piece(body)].whole; }
    /// In the last stage, by an element of a rod: `whole` with its moment about the axis, and the part at its end.
    struct GivenByElement {
        GivenMomentum whole;
        Vec3d at_end{0, 0, 0};
        std::array<Vec3d, 2> relative{}; ///< m^4/s, at its begin and end: of the fluid within, (155b)
    };
    std::span<const GivenByElement> given_by_rod(std::size_t body) const {
        return std::span(of_piece_).subspan(nodes_.first_piece(body),
                                            nodes_.first_piece(body + 1) - nodes_.first_piece(body));
    }
    /// Impulse that an element of a rod would give the fluid in the stage that begins at its present rates, at its
    /// begin and its end and about its axis, and by how much more for each of a velocity and of a spin about d1, d2,
    /// d3, over density. theory.md (154), (155a)
    struct Response {
        std::array<Vec3d, 2> given{}, drag{};          ///< m^4/s, m^3
        Vec3d shared{0, 0, 0};                         ///< m^3: of drag, what the velocity of the other end decides
        std::array<Vec3d, 2> relative{};               ///< m^4/s, as in GivenByElement
        Vec3d turn_given{0, 0, 0}, turn_drag{0, 0, 0}; ///< m^5/s, m^5
        std::array<Vec3d, 2> turn_shared{}; ///< m^5: of turn_drag, what spins of the elements before and behind decide
    };
    /// Finds the responses of all rods from the flow at the end of an explicit stage without bodies, which are at
    /// their expected places. Collective.
    void find_responses(const FlowStage& stage);
    std::span<const Response> responses(std::size_t body) const {
        return std::span(response_of_piece_)
            .subspan(nodes_.first_piece(body), nodes_.first_piece(body + 1) - nodes_.first_piece(body));
    }
    /// Sets the motion of a body that has none of its own, at the begin and the end of a stage.
    void set_motion(std::size_t body, const BodyMotion& begin, const BodyMotion& end) {
        nodes_.set_motion(body, begin, end);
    }
    void set_motion(std::size_t body, const Vec3d& begin_place, RodMotion begin, const Vec3d& end_place,
                    RodMotion end) {
        nodes_.set_motion(body, begin_place, std::move(begin), end_place, std::move(end));
    }
    /// Rigid motions of the fluid within bodies other than rods relative to theirs, by least squares over the nodes
    /// within them, at their places at a time. Collective.
    std::vector<RigidMotion> inner_motions(double time, const std::array<const double*, 3>& velocity);
    /// Wall time since the last call, s.
    double take_seconds() { return std::exchange(seconds_, 0); }

private:
    SharpForcing(const Communicator& comm, const Threads& threads, const FluidGrid& grid, double kinematic_viscosity,
                 std::vector<SharpBody> bodies, const Pencils& pencils);
    /// Sums over nodes of a row by one body: of changes of a component, m/s, of their moments, m^2/s, and of velocities
    /// relative to the axis.
    struct RowSum {
        double change = 0, at_end = 0, relative = 0, relative_at_end = 0;
        Vec3d moment{0, 0, 0}, moment_of_other{0, 0, 0};
        std::uint32_t of, other; ///< 3 piece + component
    };
    /// Moment of a change of 1 at a node about the axis, m, and what its element and another one take of it.
    struct Moments {
        Vec3d whole, own, of_other;
    };
    Moments moments(const SharpNode& node) const;
    void add(const SharpNode& node, double change, std::vector<RowSum>& sums, bool next_row) const;
    /// The same of what Response has.
    struct ResponseSum {
        std::array<double, 2> given{}, drag{}, relative{};
        double shared = 0;
        Vec3d turn_given{0, 0, 0}, turn_drag{0, 0, 0}, turn_given_of_other{0, 0, 0}, turn_drag_of_other{0, 0, 0};
        std::array<Vec3d, 2> turn_shared{};
        std::uint32_t of, other; ///< 3 piece + component
    };
    struct Change;
    void add(const SharpNode& node, const Change& change, std::vector<ResponseSum>& sums, bool next_row) const;
    /// The change of a node by one of the bodies that have it, and the share of it in the velocity of the body.
    struct Change {
        double given, share;
    };
    /// Calls give(node, change) for all bodies at a node of a list, the first of which is n. Returns its velocity after
    /// the stage, and sets n to the last of them.
    template <class Give>
    double velocity_after(std::span<const SharpNode> nodes, std::size_t& n, const FlowStage& stage, Give&& give) const;
    /// Changes the nodes of a list and appends the sums of its rows, and the work done there if it is asked for.
    void act_on(std::span<const SharpNode> nodes, const FlowStage& stage, std::vector<RowSum>& sums,
                std::vector<SurfaceWork>& works) const;
    /// Adds the changes of all rows to the momentum given by bodies. Collective.
    void add_given(const std::vector<std::vector<RowSum>>& of_planes);
    /// The same about the first node, of an element of a rod.
    static GivenMomentum about_first_node(const GivenByElement& given, const SweptSurface& rod, std::size_t element);

    /// Sum of (139) over a body and the neighbours of a node in a field, m/s.
    double pull_of(const SharpNode& node, const std::array<double*, 3>& fields) const;
    /// Lists nodes in one order, and brings their forces to this rank. Collective.
    void list_nodes();
    /// body(number in the list, node) for all nodes, by threads.
    template <class Body> void for_nodes(Body&& body) const;
    /// h^2 over viscosity, excess and length of the stage, 0 within bodies, and more where markers have a share.
    double slack(const SharpNode& node) const;

    Communicator comm_;
    const Threads& threads_;
    double h_, viscosity_;
    std::array<int, 3> cells_;
    Slab rows_, planes_; ///< of this rank
    FieldLayout layout_;
    SharpNodes nodes_;
    std::vector<GivenMomentum> given_;     ///< by body
    std::vector<GivenByElement> of_piece_; ///< in the last stage
    std::optional<SurfaceWorkSums> work_;  ///< absent: nothing needs it
    std::vector<Response> response_of_piece_;
    std::vector<SharpNode> list_;                ///< all nodes of this rank, in implicit stages
    HeldVectors held_;                           ///< by number in list_
    std::vector<double> slip_, push_, response_; ///< m/s
    bool listed_ = false;
    double stage_dt_ = 0; ///< s
    double seconds_ = 0;
};

} // namespace skein
