// Rods at rest and their small motions without a run: Newton's method on the forces and couples of the passes,
// derivatives by differences, and inverse iteration.
#pragma once

#include "core/rotation.hpp"
#include "loads/load_list.hpp"
#include "loads/load_pass.hpp"
#include "mechanics/elastic.hpp"
#include "support/rods_for_tests.hpp"

#include <cmath>
#include <stdexcept>
#include <vector>

namespace skein::test {

/// A square matrix by rows, as triangles: what solves with it, and the sign of its determinant.
class Triangles {
public:
    explicit Triangles(std::vector<std::vector<double>> rows) : row_(std::move(rows)), order_(row_.size()) {
        for (std::size_t i = 0; i < order_.size(); ++i) order_[i] = i;
        for (std::size_t c = 0; c < row_.size(); ++c) {
            std::size_t pivot = c;
            for (std::size_t r = c + 1; r < row_.size(); ++r)
                if (std::abs(row_[r][c]) > std::abs(row_[pivot][c])) pivot = r;
            if (pivot != c) {
                std::swap(row_[pivot], row_[c]);
                std::swap(order_[pivot], order_[c]);
                sign_ = -sign_;
            }
            if (row_[c][c] < 0) sign_ = -sign_;
            for (std::size_t r = c + 1; r < row_.size(); ++r) {
                const double share = row_[r][c] /= row_[c][c];
                if (share == 0) continue;
                for (std::size_t k = c + 1; k < row_.size(); ++k) row_[r][k] -= share * row_[c][k];
            }
        }
    }
    int sign() const { return sign_; }
    std::vector<double> solve(const std::vector<double>& b) const {
        std::vector<double> x(row_.size());
        for (std::size_t r = 0; r < x.size(); ++r) {
            x[r] = b[order_[r]];
            for (std::size_t k = 0; k < r; ++k) x[r] -= row_[r][k] * x[k];
        }
        for (std::size_t r = x.size(); r-- > 0;) {
            for (std::size_t k = r + 1; k < x.size(); ++k) x[r] -= row_[r][k] * x[k];
            x[r] /= row_[r][r];
        }
        return x;
    }

private:
    std::vector<std::vector<double>> row_;
    std::vector<std::size_t> order_;
    int sign_ = 1;
};

/// A rod under dead loads, at first in its start shape.
class Statics {
public:
    explicit Statics(const RodGroup& group) : group_(group), state(static_cast<std::size_t>(group.slots())) {
        group.start_state(0, state);
        for (std::size_t k = 0; k < group.element.size(); ++k)
            for (const int axis : {0, 1, 2}) unknown_.push_back({true, k, axis});
        for (int i = 0; i < group.slots(); ++i)
            for (const int axis : {0, 1, 2}) {
                const bool free =
                    !group.holds_node(i) && (!group.slides(i) || component(group.free_directions(i), axis) == 1);
                if (free) unknown_.push_back({false, static_cast<std::size_t>(i), axis});
            }
    }
    /// Leaves out the turn of an element about a body axis: of a rod that nothing keeps from turning as a whole.
    void hold_turn(std::size_t element, int axis) {
        std::erase_if(unknown_, [&](const Unknown& u) { return u.turns && u.at == element && u.axis == axis; });
    }

    std::vector<Load> loads;

    /// Goes to rest from where it is; throws where that fails.
    void rest() {
        for (int i = 0; i < 60; ++i) {
            const std::vector<double> off = Triangles(stiffness()).solve(residual());
            double largest = 0;
            for (std::size_t j = 0; j < off.size(); ++j) largest = std::max(largest, std::abs(off[j]) / scale(j));
            const double share = std::min(1.0, 0.1 / largest);
            for (std::size_t j = 0; j < off.size(); ++j) move(state, j, share * off[j]);
            if (largest < 1e-11) return;
        }
        throw std::runtime_error("no rest found");
    }
    /// 1 where small motions about this state are those of a stable rod, -1 beyond the first buckling load.
    int stability() const { return Triangles(stiffness()).sign(); }

    /// Of the small motion about this state that is nearest to a frequency, rad/s; no load may follow the rod.
    /// `wanted(turns, axis)`: whether the motion has turns about a body axis, or goes along a lab axis; it must not be
    /// coupled to what is left out.
    template <class Wanted> double frequency_near(double guess, Wanted&& wanted) const {
        const std::vector<double> inertia = this->inertia();
        auto shifted = stiffness();
        const auto rows = shifted;
        for (std::size_t j = 0; j < inertia.size(); ++j) shifted[j][j] -= guess * guess * inertia[j];
        const Triangles inverse(std::move(shifted));
        return iterate(inertia, rows, 12, [&](const std::vector<double>& x) {
            std::vector<double> y = x;
            for (std::size_t j = 0; j < y.size(); ++j)
                y[j] *= wanted(unknown(j).turns, unknown(j).axis) ? inertia[j] : 0;
            return inverse.solve(y);
        });
    }
    /// Largest of those wanted, rad/s, from below; 1e-4 of it or less is missing.
    template <class Wanted> double largest_frequency(Wanted&& wanted) const {
        const std::vector<double> inertia = this->inertia();
        const auto rows = stiffness();
        return iterate(inertia, rows, 3000, [&](const std::vector<double>& x) {
            std::vector<double> y = times(rows, x);
            for (std::size_t j = 0; j < y.size(); ++j)
                y[j] *= wanted(unknown(j).turns, unknown(j).axis) ? 1 / inertia[j] : 0;
            return y;
        });
    }

private:
    const RodGroup& group_;
    /// Of every element its turn, then of every node its place, as far as they are free.
    struct Unknown {
        bool turns;
        std::size_t at;
        int axis;
    };
    std::vector<Unknown> unknown_;
    std::size_t unknowns() const { return unknown_.size(); }
    const Unknown& unknown(std::size_t j) const { return unknown_[j]; }
    static double component(const Vec3d& v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }
    double scale(std::size_t j) const { return unknown(j).turns ? 1 : group_.spec().shape.length; }
    std::vector<double> inertia() const {
        std::vector<double> all(unknowns());
        for (std::size_t j = 0; j < all.size(); ++j) {
            const Unknown u = unknown(j);
            const Vec3d& turning = group_.element[std::min(u.at, group_.element.size() - 1)].inertia;
            all[j] = u.turns ? component(turning, u.axis) : group_.node_mass[u.at];
        }
        return all;
    }
    static std::vector<double> times(const std::vector<std::vector<double>>& rows, const std::vector<double>& x) {
        std::vector<double> y(x.size());
        for (std::size_t i = 0; i < y.size(); ++i)
            for (std::size_t j = 0; j < x.size(); ++j) y[i] += rows[i][j] * x[j];
        return y;
    }
    /// Root of the Rayleigh quotient after so many steps from a vector that is like no mode.
    template <class Next> static double iterate(const std::vector<double>& inertia,
                                                const std::vector<std::vector<double>>& rows, int steps, Next&& next) {
        std::vector<double> x(inertia.size());
        for (std::size_t j = 0; j < x.size(); ++j)
            x[j] = std::sin(1.0 + 3.7 * static_cast<double>(j * j % 101)) / std::sqrt(inertia[j]);
        for (int i = 0; i < steps; ++i) {
            x = next(x);
            double square = 0;
            for (std::size_t j = 0; j < x.size(); ++j) square += inertia[j] * x[j] * x[j];
            for (double& value : x) value /= std::sqrt(square);
        }
        const std::vector<double> force = times(rows, x);
        double quotient = 0;
        for (std::size_t j = 0; j < x.size(); ++j) quotient += x[j] * force[j];
        return std::sqrt(quotient);
    }
    static Vec3d along(int axis, double size) {
        return {axis == 0 ? size : 0, axis == 1 ? size : 0, axis == 2 ? size : 0};
    }
    void move(std::vector<Slot<1>>& s, std::size_t j, double size) const {
        const Unknown u = unknown(j);
        const Vec3d by = along(u.axis, size);
        if (u.turns) set_lane(s[u.at].director, 0, rotation(by) * lane(s[u.at].director, 0));
        else set_lane(s[u.at].position, 0, lane(s[u.at].position, 0) + by);
    }
    std::vector<double> residual() const {
        auto copy = state;
        return residual(copy);
    }
    std::vector<double> residual(std::vector<Slot<1>>& s) const {
        std::vector<SlotLoad<1>> load(s.size());
        const RodTile<1> tile = tile_of(group_, s);
        with_energy_law(group_.law(),
                        [&]<class L>(L) { ElasticPass<L, 1>(ends_of(group_)).run(tile, load.data(), Step{}); });
        for (const Load& l : loads) {
            const auto pass = make_pass<1>(l, group_);
            const Step step{.index = 1, .dt = 1, .time = 1e9, .slot = 0};
            pass->bind(tile);
            pass->prepare(std::span(&step, 1));
            pass->run(tile, load.data(), step);
        }
        std::vector<double> all(unknowns());
        for (std::size_t j = 0; j < all.size(); ++j) {
            const Unknown u = unknown(j);
            all[j] = component(lane(u.turns ? load[u.at].couple : load[u.at].force, 0), u.axis);
        }
        return all;
    }
    /// Less the derivative of the residual by the unknowns.
    std::vector<std::vector<double>> stiffness() const {
        const std::size_t count = unknowns();
        std::vector<std::vector<double>> rows(count, std::vector<double>(count));
        auto copy = state;
        for (std::size_t j = 0; j < count; ++j) {
            const double step = 1e-6 * scale(j);
            const std::size_t at = unknown(j).at;
            move(copy, j, step);
            const auto there = residual(copy);
            copy[at] = state[at];
            move(copy, j, -step);
            const auto back = residual(copy);
            copy[at] = state[at];
            for (std::size_t i = 0; i < count; ++i) rows[i][j] = (back[i] - there[i]) / (2 * step);
        }
        return rows;
    }

public:
    std::vector<Slot<1>> state;
};

} // namespace skein::test
