// A wave of couple that stands equal and opposite on the two elements of every vertex: what muscles have in common.
//   c_k += Q_k (m_k - m_{k+1}) d                  [N m] body; vertex j between elements j-1 and j; d a lab direction
// In a ring vertex 0 joins the last element to the first.
//   m_j(t) = r(t) A_j sin(2 pi t/T - a_j) = A_j cos(a_j) r sin(wt) - A_j sin(a_j) r cos(wt): one sine and cosine a step in all
// Cost: 33 flop per element.
#pragma once

#include "loads/ramp.hpp"
#include "rod/tile.hpp"

#include <cmath>
#include <numbers>
#include <span>
#include <vector>

namespace skein {

class VertexWave {
public:
    /// Silent at all vertices until they are set.
    void resize(int elements) {
        in_phase_.assign(static_cast<std::size_t>(elements), 0);
        quadrature_.assign(static_cast<std::size_t>(elements), 0);
    }
    /// Amplitude A_j, N m, and phase a_j, rad, at vertex j; an open rod has no vertex 0.
    void set(int j, double amplitude, double phase) {
        in_phase_[static_cast<std::size_t>(j)] = amplitude * std::cos(phase);
        quadrature_[static_cast<std::size_t>(j)] = amplitude * std::sin(phase);
    }
    void prepare(std::span<const Step> steps, double period, double ramp) {
        for (const Step& step : steps) {
            const double angle = 2 * std::numbers::pi / period * step.time, r = ramp_at(step.time, ramp);
            sine_[step.slot] = r * std::sin(angle);
            cosine_[step.slot] = r * std::cos(angle);
        }
    }
    template <int W> void add(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step, const Vec3d& direction) const {
        const auto at_vertex = [&](int j) {
            return in_phase_[static_cast<std::size_t>(j)] * sine_[step.slot] - quadrature_[static_cast<std::size_t>(j)] * cosine_[step.slot];
        };
        // By elements, so that each turns one couple into its frame and not two.
        const double closing = rod.group->closed() ? at_vertex(0) : 0;
        double before = closing;
        for (int k = 0; k < rod.n; ++k) {
            const double after = k + 1 < rod.n ? at_vertex(k + 1) : closing;
            load[k].couple += rod.slot[k].director * broadcast<W>((before - after) * direction);
            before = after;
        }
    }

private:
    std::vector<double> in_phase_, quadrature_; ///< [elements], by vertex
    double sine_[Clock::largest_batch], cosine_[Clock::largest_batch];
};

} // namespace skein
