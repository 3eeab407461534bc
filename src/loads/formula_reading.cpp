#include "loads/formula_reading.hpp"

#include "skein/core/error.hpp"
#include "skein/core/index.hpp"
#include "skein/rod/rod_group.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace skein {

FormulaPlaces::FormulaPlaces(const RodGroup& group, std::int64_t index, bool middles, bool with_start)
    : length(group.spec().shape.length), rod(static_cast<double>(index)) {
    s.assign(1, 0.0);
    for (const ElementConstants& c : group.element) s.push_back(s.back() + c.rest_length);
    if (with_start) {
        std::vector<Slot<1>> state(to_index(group.slots()));
        group.start_state(index, state);
        for (const Slot<1>& slot : state) start.push_back(lane(slot.position, 0));
    }
    if (!middles) return;
    for (std::size_t k = 0; k + 1 < s.size(); ++k) s[k] = 0.5 * (s[k] + s[k + 1]);
    s.pop_back();
    for (std::size_t k = 0; k + 1 < start.size(); ++k) start[k] = 0.5 * (start[k] + start[k + 1]);
}

double FormulaPlaces::value(Variable v, std::size_t slot) const {
    const Vec3d at = start.empty() ? Vec3d{0, 0, 0} : start[slot];
    switch (v) {
    case Variable::s:
        return s[slot];
    case Variable::length:
        return length;
    case Variable::rod:
        return rod;
    case Variable::start_x:
        return at.x;
    case Variable::start_y:
        return at.y;
    case Variable::start_z:
        return at.z;
    default:
        return 0;
    }
}

namespace {

/// A node, or the middle of an element, of a rod in its start state at some time.
struct Sample {
    std::array<double, variables> at;
    std::int64_t rod;
    int place;
};

/// A subset of 0 to count - 1, with the first and the last.
std::vector<std::int64_t> some_of(std::int64_t count, std::int64_t most) {
    std::vector<std::int64_t> chosen;
    for (std::int64_t i = 0; i < std::min(count, most); ++i)
        chosen.push_back(count <= most ? i : i * (count - 1) / (most - 1));
    return chosen;
}

/// Begin and end of a part of the run, and times between them without a common period.
std::vector<double> some_times(const TimeSpan& span) {
    if (span.empty()) return {};
    const bool lasts = span.end > span.begin;
    std::vector<double> times = {span.begin};
    if (lasts) times.push_back(span.end);
    for (int i = 1; lasts && i < 15; ++i) times.push_back(span.at(std::fmod(0.6180339887498949 * i, 1.0)));
    return times;
}

/// Calls `sample` for some rods of a group until it returns false. Rods of a file are those that this rank holds.
template <class Use> void over_samples(const RodGroup& group, const TimeSpan& span, bool middles, Use use) {
    if (!group.strained()) return;
    const std::vector<double> times = some_times(span);
    const bool from_file = group.places().from_file();
    const std::vector<std::int64_t> held = from_file ? group.places().held() : std::vector<std::int64_t>{};
    for (const std::int64_t rod : some_of(group.count(), 32)) {
        if (from_file && !std::binary_search(held.begin(), held.end(), rod)) continue;
        std::vector<Slot<1>> state(to_index(group.slots()));
        group.start_state(rod, state);
        const FormulaPlaces along =
            with_rod(group, rod, [&](const RodGroup& own) { return FormulaPlaces(own, rod, middles, true); });
        for (const std::int64_t place : some_of(static_cast<std::int64_t>(along.s.size()), 33)) {
            const std::size_t k = to_index(place);
            Sample sample{{}, rod, static_cast<int>(place)};
            const auto set = [&](Variable v, double value) { nth(sample.at, v) = value; };
            Vec3d x = lane(state[k].position, 0), v = lane(state[k].velocity, 0);
            if (middles) {
                x = 0.5 * (x + lane(state[k + 1].position, 0));
                v = 0.5 * (v + lane(state[k + 1].velocity, 0));
            }
            set(Variable::x, x.x);
            set(Variable::y, x.y);
            set(Variable::z, x.z);
            set(Variable::vx, v.x);
            set(Variable::vy, v.y);
            set(Variable::vz, v.z);
            for (int i = static_cast<int>(Variable::s); i < variables; ++i)
                set(static_cast<Variable>(i), along.value(static_cast<Variable>(i), k));
            for (const double t : times) {
                set(Variable::t, t);
                if (!use(sample)) return;
            }
        }
    }
}

/// True where a value divides by 0, or by a difference that is nothing but round-off.
bool divides_by_zero(const Graph& graph, const std::vector<double>& values, int node) {
    if (graph[node].op != Op::divide) return false;
    const auto of = [&](int operand) { return nth(values, operand); };
    const Graph::Node& below = graph[graph[node].of[1]];
    const double divisor = of(graph[node].of[1]);
    if (below.op != Op::add && below.op != Op::subtract) return divisor == 0;
    return std::abs(divisor) <= 1e-15 * (std::abs(of(below.of[0])) + std::abs(of(below.of[1])));
}

/// First operand value that is not finite and spoils the result, or -1.
int where_it_breaks(const Graph& graph, const std::vector<double>& values, int result) {
    std::vector<bool> reached(to_index(result) + 1, false);
    reached.back() = true;
    for (int i = result; i >= 0; --i) {
        if (!nth(reached, i)) continue;
        const Graph::Node& n = graph[i];
        for (int k = 0; k < operands_of(n.op); ++k) {
            const bool holds = nth(values, n.of[0]) != 0;
            if (n.op == Op::choice && k > 0 && holds != (k == 1)) continue; // the other one is taken
            nth(reached, nth(n.of, k)) = true;
        }
    }
    const bool finite = std::isfinite(nth(values, result));
    for (int i = 0; i <= result; ++i)
        if (nth(reached, i) && (divides_by_zero(graph, values, i) || (!finite && !std::isfinite(nth(values, i)))))
            return i;
    return -1;
}

} // namespace

std::vector<int> FormulaReading::read(const char* key, const std::vector<std::string>& texts, std::string_view unit) {
    std::vector<int> values;
    if (texts.empty()) return values;
    if (texts.size() != 3) {
        faults_.push_back({key, {}, fmt::format("'{}' needs 3 formulas, not {}", key, texts.size())});
        return values;
    }
    for (std::size_t i = 0; i < texts.size(); ++i) {
        std::vector<FormulaFault> found;
        const int number = static_cast<int>(text_.size());
        text_.push_back(texts[i]);
        if (const auto value = read_formula(graph, scope_, texts[i], number, unit, found))
            values.push_back(value->node);
        for (const FormulaFault& fault : found)
            faults_.push_back({fmt::format("{}.{}", key, i), fault.part, fmt::format("'{}': {}", key, fault.message)});
    }
    if (values.size() < 3) values.clear();
    return values;
}

FormulaVector FormulaReading::compile(const char* key, const std::vector<int>& values) {
    if (values.empty()) return {};
    if (auto program = compiled(graph, values)) return {true, std::move(*program), {}};
    faults_.push_back({key, {}, fmt::format("'{}' needs too many values at once: use fewer terms, or two loads", key)});
    return {};
}

void require_read(const FormulaReading* reading, std::string_view kind) {
    if (!reading || !reading->faults().empty())
        throw InputError(fmt::format("a load of kind {} whose formulas have not been read", kind));
}

void FormulaReading::add_faults(Objections& objections) const {
    for (const Fault& t : faults_) objections.add_within(t.key, t.part.begin, t.part.length, t.message);
}

std::string FormulaReading::fault(const char* key, const RodGroup& group, const std::vector<int>& nodes,
                                  bool middles) const {
    std::string fault;
    over_samples(group, scope_.tried(), middles, [&](const Sample& sample) {
        const std::vector<double> values = graph.values(sample.at);
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            const int where = where_it_breaks(graph, values, nodes[i]);
            if (where < 0) continue;
            const Graph::Node& bad = graph[where];
            const auto of = [&](std::size_t k) { return nth(values, bad.of[k]); };
            const std::string_view what = divides_by_zero(graph, values, where) ? "divides by 0"
                                          : bad.op == Op::root                  ? "is the root of a negative number"
                                          : bad.op == Op::logarithm && of(0) <= 0
                                              ? "is the logarithm of a number that is not above 0"
                                              : "is not finite";
            const std::string written =
                bad.part.formula >= 0 ? nth(text_, bad.part.formula).substr(bad.part.begin, bad.part.length) : text_[0];
            const auto value = [&](Variable v) { return nth(sample.at, v); };
            fault = fmt::format("'{}': \"{}\" {} at t = {:.6g} s at {} {} of rod {} of '{}', where x, y, z = {:.6g}, "
                                "{:.6g}, {:.6g} m and "
                                "s = {:.6g} m",
                                key, written, what, value(Variable::t), middles ? "element" : "node", sample.place,
                                sample.rod, group.name(), value(Variable::x), value(Variable::y), value(Variable::z),
                                value(Variable::s));
            return false;
        }
        return true;
    });
    return fault;
}

DragRate FormulaReading::largest(const RodGroup& group, bool middles, const Worth& worth) const {
    DragRate largest;
    if (group.places().from_file()) return largest; // ranks that hold other rods would choose other steps
    over_samples(group, scope_.run(), middles, [&](const Sample& sample) {
        const double here = worth(graph.values(sample.at), sample.place);
        if (std::isfinite(here) && here > largest.value) // else the formula does not act at that time
            largest = {here, std::min(sample.place, group.elements() - 1)};
        return true;
    });
    return largest;
}

DragRate steepest(const FormulaReading& reading, const RodGroup& group, const std::vector<int>& force, Variable first,
                  const std::function<double(int)>& weight) {
    if (force.empty()) return {};
    FormulaReading with_slopes = reading;
    std::vector<int> slope;
    bool any = false;
    for (const int f : force)
        for (int axis = 0; axis < 3; ++axis) {
            slope.push_back(with_slopes.graph.derivative(f, static_cast<Variable>(static_cast<int>(first) + axis)));
            any = any || with_slopes.graph.number(slope.back()) != 0;
        }
    if (!any) return {};
    return with_slopes.largest(group, false, [&](const std::vector<double>& values, int node) {
        double most = 0;
        for (std::size_t row = 0; row < 3; ++row) {
            double sum = 0;
            for (std::size_t axis = 0; axis < 3; ++axis) sum += std::abs(nth(values, slope[3 * row + axis]));
            most = std::max(most, sum);
        }
        return most * weight(node);
    });
}

} // namespace skein
