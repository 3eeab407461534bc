// A wave of couple that stands equal and opposite on the two elements of every vertex: what muscles have in common.
//   c_k += Q_k (m_k - m_{k+1}) d                  [N m] body, vertex j between elements j-1 and j; d a lab direction
// An open rod has no couple at its ends; in a ring vertex 0 joins the last element to the first.
//   m_j(t) = r(t) A_j sin(2 pi t/T - a_j) = A_j cos(a_j) r sin(wt) - A_j sin(a_j) r cos(wt): one sine and cosine a step in all
// Cost: 33 flop per element.
#pragma once

#include "skein/loads/ramp.hpp"
#include "skein/rod/mapping.hpp"

#include <cmath>
#include <numbers>
#include <span>
#include <vector>

namespace skein {

class VertexWave {
public:
    /// Silent at all vertices until they are set.
    void resize(int elements) { parts_.assign(static_cast<std::size_t>(elements), {0, 0}); }
    /// Amplitude A_j, N m, and phase a_j, rad, at vertex j, once for each; an open rod has no vertex 0.
    void set(int j, double amplitude, double phase) {
        const auto after = static_cast<std::size_t>(j), before = (j > 0 ? after : parts_.size()) - 1;
        const double in_phase = amplitude * std::cos(phase), quadrature = amplitude * std::sin(phase);
        parts_[after].in_phase += in_phase, parts_[after].quadrature += quadrature;
        parts_[before].in_phase -= in_phase, parts_[before].quadrature -= quadrature;
    }
    void prepare(std::span<const Step> steps, double period, double ramp) {
        for (const Step& step : steps) {
            const double angle = 2 * std::numbers::pi / period * step.time, r = ramp_at(step.time, ramp);
            sine_[step.slot] = r * std::sin(angle);
            cosine_[step.slot] = r * std::cos(angle);
        }
    }
    template <int W> auto bind(const RodTile<W>& rod) const { return in_lanes<Parts>(rod, parts_); }

    template <int W, class Map>
    void add(const RodTile<W>& rod, const auto& in_lanes, SlotLoad<W>* load, const Step& step, const Vec3d& direction) const {
        const auto d = broadcast<W>(direction);
        for (int k = 0; k < rod.n; ++k) {
            const auto& parts = Map::row(parts_, in_lanes, k);
            const auto m = parts.in_phase * sine_[step.slot] - parts.quadrature * cosine_[step.slot];
            load[k].couple = fma(Pack<W>(m), rod.slot[k].director * d, load[k].couple);
        }
    }

    /// Of m_k - m_{k+1}, N m.
    template <class N> struct Parts { N in_phase, quadrature; };

private:
    std::vector<Parts<double>> parts_; ///< [elements]
    double sine_[Clock::largest_batch], cosine_[Clock::largest_batch];
};

} // namespace skein
