// Wave of couple, equal and opposite on the two elements of every vertex: the common part of muscles.
//   c_k += Q_k (m_k - m_{k+1}) d        [N m] body, vertex j between elements j-1 and j; d a lab direction,
//                                       or a moment m_j d about body axes, d in the material: loads/vertex_couples.hpp
// Ends of an open rod are vertices where they are clamped: the element has m_0 d, or -m_n d, and the clamp the
// opposite. In a ring vertex 0 joins the last element to the first. A joint has the moments of the ends
// (tiles/end_moments.hpp).
//   m_j(t) = r(t) A_j sin(2 pi t/T - a_j) = A_j cos(a_j) r sin(wt) - A_j sin(a_j) r cos(wt): one sine and cosine a step
//   in all
// Cost: 33 flop per element; about body axes 102.
#pragma once

#include "loads/load_frame.hpp"
#include "loads/vertex_couples.hpp"
#include "skein/core/fields.hpp"
#include "skein/core/index.hpp"
#include "skein/core/objections.hpp"
#include "skein/loads/ramp.hpp"
#include "skein/tiles/mapping.hpp"
#include "tiles/end_moments.hpp"

#include <cmath>
#include <numbers>
#include <span>
#include <vector>

namespace skein {

class VertexWave {
public:
    /// Sets all vertices to 0. `frame`: axes of the direction.
    void resize(int elements, LoadFrame frame) {
        parts_.assign(to_index(elements), {0, 0});
        start_ = at_start_ = at_end_ = {0, 0};
        frame_ = frame;
    }
    /// Sets amplitude A_j, N m, and phase a_j, rad, at vertex j between two elements, once for each; j = 0 exists in
    /// rings alone.
    void set(int j, double amplitude, double phase) {
        const std::size_t after = to_index(j), before = (j > 0 ? after : parts_.size()) - 1;
        const Parts<double> m = parts_of(amplitude, phase);
        if (frame_ == LoadFrame::body) {
            parts_[before] = m;
            return;
        }
        add(after, m, 1);
        add(before, m, -1);
    }
    /// Moments at the ends of an open rod, for its half cells and for joints; 0 until they are set.
    void set_ends(const RodGroup& group, double start_amplitude, double start_phase, double end_amplitude,
                  double end_phase) {
        if (group.closed()) return;
        at_start_ = parts_of(start_amplitude, start_phase);
        at_end_ = parts_of(end_amplitude, end_phase);
        const bool in_body = frame_ == LoadFrame::body;
        if (group.spec().start == EndKind::clamped) {
            if (in_body) start_ = at_start_;
            else add(0, at_start_, 1);
        }
        if (group.spec().end == EndKind::clamped) {
            if (in_body) parts_.back() = at_end_;
            else add(parts_.size() - 1, at_end_, -1);
        }
    }
    template <int W> void add_end_moments(const Step& step, const Vec3d& direction, EndMoments<W>& moments) const {
        const auto add = [&](const Parts<double>& parts, EndMoment<Pack<W>>& at) {
            const double m = parts.in_phase * sine_[step.slot] - parts.quadrature * cosine_[step.slot];
            (frame_ == LoadFrame::body ? at.body : at.lab) += broadcast<W>(m * direction);
        };
        add(at_start_, moments.start);
        add(at_end_, moments.end);
    }
    void prepare(std::span<const Step> steps, double period, const Ramp& ramp) {
        for (const Step& step : steps) {
            const double angle = 2 * std::numbers::pi / period * step.time, r = ramp.at(step.time);
            sine_[step.slot] = r * std::sin(angle);
            cosine_[step.slot] = r * std::cos(angle);
        }
    }
    template <int W> auto bind(const RodTile<W>& rod) const { return in_lanes<Parts>(rod, parts_); }

    template <int W, class Map> void add(const RodTile<W>& rod, const auto& in_lanes, SlotLoad<W>* load,
                                         const Step& step, const Vec3d& direction) const {
        const auto d = broadcast<W>(direction);
        if (frame_ == LoadFrame::body) return add_about_body_axes<Map>(rod, in_lanes, load, step, d);
        for (int k = 0; k < rod.n; ++k) {
            const auto& parts = Map::row(parts_, in_lanes, k);
            const auto m = parts.in_phase * sine_[step.slot] - parts.quadrature * cosine_[step.slot];
            load[k].couple = fma(Pack<W>(m), rod.slot[k].director * d, load[k].couple);
        }
    }

    /// Parts of m_k - m_{k+1}, N m; about body axes of m_{k+1}, the last of which acts where a ring closes or a clamp
    /// holds.
    template <class N> struct Parts { N in_phase, quadrature; };

private:
    static Parts<double> parts_of(double amplitude, double phase) {
        return {amplitude * std::cos(phase), amplitude * std::sin(phase)};
    }
    void add(std::size_t k, const Parts<double>& m, double sign) {
        parts_[k].in_phase += sign * m.in_phase;
        parts_[k].quadrature += sign * m.quadrature;
    }

    template <class Map, int W> void add_about_body_axes(const RodTile<W>& rod, const auto& in_lanes, SlotLoad<W>* load,
                                                         const Step& step, const Vec3<Pack<W>>& d) const {
        using P = Pack<W>;
        const int n = rod.n;
        const auto now = [&](const auto& parts) __attribute__((always_inline)) {
            return P(parts.in_phase * sine_[step.slot] - parts.quadrature * cosine_[step.slot]);
        };
        const auto vertex = [&](int k, const Quaternion<P>& next) __attribute__((always_inline)) {
            const P m = now(Map::row(parts_, in_lanes, k));
            const Quaternion<P>& here = rod.slot[k].director;
            VertexCouples<P> c;
            if constexpr (Map::along) { // no turn is computed where a rod ends
                const Mask<W> inner = Map::cell(rod, k).inner;
                c = about_body_axes(select(inner, next, here), here, m * d);
                c = {select(inner, c.before, -(m * d)), select(inner, c.after, Vec3<P>{})};
            } else c = about_body_axes(next, here, m * d);
            return c;
        };
        // One vertex serves both sides where a ring closes, or where a lane's rod goes on in the next.
        VertexCouples<P> seam;
        Vec3<P> before = now(start_) * d;
        if constexpr (Map::along) {
            seam = vertex(n - 1, from_lane_after(rod.slot[0].director));
            before = select(rod.strands->first, before, from_lane_before(seam.after));
        } else if (rod.group->closed()) {
            seam = vertex(n - 1, rod.slot[0].director);
            before = seam.after;
        } else seam.before = -(now(parts_.back()) * d);
        for (int k = 0; k < n - 1; ++k) {
            const VertexCouples<P> c = vertex(k, rod.slot[k + 1].director);
            load[k].couple += before + c.before;
            before = c.after;
        }
        load[n - 1].couple += before + seam.before;
    }

    LoadFrame frame_ = LoadFrame::lab;
    std::vector<Parts<double>> parts_; ///< [elements]
    Parts<double> start_{0, 0};        ///< m_0 about body axes
    Parts<double> at_start_{0, 0}, at_end_{0, 0};
    double sine_[Clock::largest_batch], cosine_[Clock::largest_batch];
};

/// Base of the loads with one such wave. `L` has the members phase, direction, frame, period and ramp.
template <class L> struct WaveLoad {
    void prepare(std::span<const Step> steps) { wave.prepare(steps, self().period, self().ramp); }

    static constexpr bool data_along_only = true;
    template <int W> using TileData = LaneRows<VertexWave::Parts<Pack<W>>>;
    template <int W> TileData<W> bind(const RodTile<W>& rod) const { return wave.bind(rod); }
    template <int W, class Map = Across<W>>
    void add(const RodTile<W>& rod, const TileData<W>& data, SlotLoad<W>* load, const Step& step) const {
        wave.add<W, Map>(rod, data, load, step, self().direction);
    }
    template <int W> void add_end_moments(const RodTile<W>&, const Step& step, EndMoments<W>& moments) const {
        wave.add_end_moments<W>(step, self().direction, moments);
    }

    VertexWave wave;

protected:
    static void common_fields(FieldVisitor& f, L& load) {
        f.visit({.name = "phase", .unit = "rad", .text = "phi"}, load.phase);
        f.visit({.name = "direction", .unit = "-", .text = "axis of the couple"}, load.direction);
        f.choice(
            {.name = "frame", .text = "axes of `direction`; body axes (d1, d2, d3) turn with the rod, like muscles"},
            load.frame, load_frame_names);
        load.ramp.fields(f);
    }
    void check_direction(Objections& objections) const {
        if (zero(self().direction)) objections.add("direction", "'direction' has no direction");
    }

private:
    const L& self() const { return static_cast<const L&>(*this); }
};

} // namespace skein
