// A wave of couple that stands equal and opposite on the two elements of every vertex: what muscles have in common.
//   c_j += Q_j m_j d,   c_{j-1} -= Q_{j-1} m_j d                  [N m] body, vertex j between elements j-1 and j; d a lab
//   direction
// In a ring vertex 0 joins the last element to the first.
//   m_j(t) = r(t) A_j sin(2 pi t/T - a_j) = A_j cos(a_j) r sin(wt) - A_j sin(a_j) r cos(wt): one sine and cosine a step in all
// Cost: 30 flop per element.
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
        const auto act = [&](int before, int j) {
            const double m = in_phase_[static_cast<std::size_t>(j)] * sine_[step.slot] - quadrature_[static_cast<std::size_t>(j)] * cosine_[step.slot];
            const auto couple = broadcast<W>(m * direction);
            load[j].couple += rod.slot[j].director * couple;
            load[before].couple -= rod.slot[before].director * couple;
        };
        for (int j = 1; j < rod.n; ++j) act(j - 1, j);
        if (rod.group->closed()) act(rod.n - 1, 0);
    }

private:
    std::vector<double> in_phase_, quadrature_; ///< [elements], by vertex
    double sine_[Clock::largest_batch], cosine_[Clock::largest_batch];
};

} // namespace skein
