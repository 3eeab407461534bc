#include "loads/magnetic_formula.hpp"

#include "skein/core/index.hpp"
#include "skein/rod/rod_group.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

void MagneticFormula::use(const FormulaScope& scope) {
    reading_ = nullptr;
    uniform_ = true;
    if (!faults(scope).empty()) return; // faults of names are reported elsewhere
    FormulaReading reading(scope);
    nodes_ = reading.read("field", field, "T");
    if (!nodes_.empty()) {
        for (std::size_t i = 0; i < 3; ++i)
            for (const Variable axis : {Variable::x, Variable::y, Variable::z}) {
                nodes_.push_back(reading.graph.derivative(nodes_[i], axis));
                uniform_ = uniform_ && reading.graph.number(nodes_.back()) == 0;
            }
    }
    values_ = reading.compile("field", nodes_);
    moment_nodes_ = reading.read("magnetisation", magnetisation, "A/m");
    moments_ = reading.compile("magnetisation", moment_nodes_);
    reading_ = std::make_shared<FormulaReading>(std::move(reading));
}

void MagneticFormula::check(RodSpecs groups, Objections& objections) const {
    if (reading_) reading_->add_faults(objections);
    if (!groups.empty() &&
        std::none_of(groups.begin(), groups.end(), [this](const RodSpec* rods) { return acts_on(*rods); }))
        objections.add("", "none of the groups that this magnetic_formula acts on has a [rods.magnetisation], and it "
                           "has no 'magnetisation'");
    if (moments_.given && (moments_.program.changes & ~with_place) != 0)
        objections.add("magnetisation",
                       "'magnetisation': it is fixed in the material, and may change with s, L, rod, X, Y, Z alone");
    for (const Variable v : {Variable::vx, Variable::vy, Variable::vz})
        if (values_.given && values_.program.uses(v))
            objections.add("field", "'field': a field that changes with velocities has no energy; "
                                    "use places and time");
}

std::string MagneticFormula::fault_at_start(const RodGroup& group) const {
    if (!reading_) return {};
    const std::string fault = reading_->fault("field", group, nodes_, true);
    return fault.empty() ? reading_->fault("magnetisation", group, moment_nodes_, true) : fault;
}

DragRate MagneticFormula::largest_stiffness(const RodGroup& group) const {
    if (nodes_.empty()) return {};
    FormulaReading reading = *reading_;
    std::vector<int> second; // d2 B_i/dx_j dx_l
    for (std::size_t i = 3; i < nodes_.size(); ++i)
        for (const Variable axis : {Variable::x, Variable::y, Variable::z})
            second.push_back(reading.graph.derivative(nodes_[i], axis));
    const double strength = group.largest_magnetisation(), density = group.spec().material.density;
    return reading.largest(group, true, [&](const std::vector<double>& values, int k) {
        const auto size = [&](const std::vector<int>& of, std::size_t first, std::size_t count) {
            double sum = 0;
            for (std::size_t i = first; i < first + count; ++i) sum += std::pow(nth(values, of[i]), 2);
            return std::sqrt(sum);
        };
        const ElementConstants& c = nth(group.element, k);
        const double inertia = std::min({c.inertia.x, c.inertia.y, c.inertia.z}), mass = density * c.volume,
                     moment = c.volume * (moment_nodes_.empty() ? strength : size(moment_nodes_, 0, 3));
        const double shift = moment * size(second, 0, 27) / mass, turn = moment * size(nodes_, 0, 3) / inertia,
                     both = moment * size(nodes_, 3, 9) / std::sqrt(mass * inertia);
        return 0.5 * (shift + turn) + std::hypot(0.5 * (shift - turn), both);
    });
}

} // namespace skein
