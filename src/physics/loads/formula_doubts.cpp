#include "physics/loads/formula_doubts.hpp"

#include "core/field_looker.hpp"
#include "formula/formula.hpp"
#include "physics/scene_spec.hpp"
#include "skein/core/index.hpp"

#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

namespace skein {

namespace {

constexpr int looks = 2048;               ///< over the time in which formulas act
constexpr int halvings = 100;             ///< of the interval between two
constexpr double vanishing = 1e-6;        ///< of the largest denominator: 0, but for rounding
constexpr double near = 1e-8, far = 1e-4; ///< of that time, from the pole
constexpr double steep = 100;             ///< times that a formula is larger near than far; of a simple pole 1e4

/// Values of a graph as functions of time alone; places and velocities are 1, so that no factor vanishes.
class OfTime {
public:
    explicit OfTime(const Graph& graph) : graph_(graph) { at_.fill(1); }
    double operator()(int node, double time) {
        nth(at_, Variable::t) = time;
        return nth(graph_.values(at_), node);
    }

private:
    const Graph& graph_;
    std::array<double, variables> at_{};
};

/// A time in [begin, end] at which the value is 0, where its sign changes between the ends or it is smallest between
/// them.
double zero_between(OfTime& value, int node, double begin, double end) {
    double at_begin = value(node, begin);
    const bool changes = (at_begin < 0) != (value(node, end) < 0);
    constexpr double golden = 0.381966;
    for (int i = 0; i < halvings && end > begin; ++i) {
        if (changes) {
            const double middle = 0.5 * (begin + end), here = value(node, middle);
            if ((here < 0) == (at_begin < 0)) {
                begin = middle;
                at_begin = here;
            } else end = middle;
        } else {
            const double a = begin + golden * (end - begin), b = end - golden * (end - begin);
            if (std::abs(value(node, a)) < std::abs(value(node, b))) end = b;
            else begin = a;
        }
    }
    return 0.5 * (begin + end);
}

/// The first time at which a formula, `node`, has a pole since the value of `below` is 0.
std::optional<double> pole(OfTime& value, int node, int below, const TimeSpan& span) {
    std::vector<double> found(looks + 1);
    double largest = 0;
    const double duration = span.end - span.begin;
    const auto time = [&](int i) { return span.at(static_cast<double>(i) / looks); };
    for (int i = 0; i <= looks; ++i) {
        nth(found, i) = value(below, time(i));
        if (!std::isfinite(nth(found, i))) return std::nullopt;
        largest = std::max(largest, std::abs(nth(found, i)));
    }
    for (int i = 1; i < looks; ++i) {
        const double before = found[static_cast<std::size_t>(i) - 1], here = nth(found, i),
                     after = found[static_cast<std::size_t>(i) + 1];
        const bool changes = (before < 0) != (here < 0) || (here < 0) != (after < 0),
                   least = std::abs(here) <= std::abs(before) && std::abs(here) <= std::abs(after);
        if (!changes && !least) continue;
        const double at = (before < 0) != (here < 0) ? zero_between(value, below, time(i - 1), time(i))
                          : changes                  ? zero_between(value, below, time(i), time(i + 1))
                                                     : zero_between(value, below, time(i - 1), time(i + 1));
        if (std::abs(value(below, at)) > vanishing * largest) continue; // it jumps over 0, or does not come so far
        const auto size = [&](double away) {
            return std::max(std::abs(value(node, at - away * duration)), std::abs(value(node, at + away * duration)));
        };
        if (!(size(near) <= steep * size(far))) return at;
    }
    return std::nullopt;
}

class PoleLooker final : public FieldLooker {
public:
    using FieldLooker::visit;
    PoleLooker(const FormulaScope& scope, std::vector<std::string>& found) : scope_(scope), found_(found) {}

    void look_into(std::string table) { path_ = {std::move(table)}; }
    void visit(const Field& f, std::string& text) override { look(f, text); }
    void visit(const Field& f, std::vector<std::string>& texts) override {
        for (const std::string& text : texts) look(f, text);
    }
    bool enter(const Field& f) override {
        path_.emplace_back(f.name);
        return true;
    }
    void leave() override { path_.pop_back(); }

private:
    /// Text that is no formula has faults, or divides nothing.
    void look(const Field& f, const std::string& text) {
        if (text.find_first_of("/^") == std::string::npos && text.find("tan") == std::string::npos) return;
        Graph graph(scope_.tables);
        std::vector<FormulaFault> faults;
        const auto read = read_formula(graph, scope_, text, 0, "", faults);
        const TimeSpan span = scope_.tried();
        if (!read || !(span.end > span.begin)) return;
        OfTime value(graph);
        for (const Graph::Node& node : graph.nodes()) {
            if (node.op != Op::divide || graph[node.of[1]].changes != with_time) continue;
            const auto at = pole(value, read->node, node.of[1], span);
            if (!at) continue;
            found_.push_back(
                fmt::format("{}.{}: '{}' has a pole at t = {:.6g} s, between two steps: there it divides by 0, and its "
                            "effect depends on how near a step comes; keep the divisor away from 0, or let the run "
                            "end before",
                            fmt::join(path_, "."), f.name, text, *at));
            return;
        }
    }

    const FormulaScope& scope_;
    std::vector<std::string>& found_;
    std::vector<std::string> path_;
};

} // namespace

std::vector<std::string> formula_doubts(const SceneSpec& scene) {
    std::vector<std::string> found;
    const FormulaScope scope = names_for_formulas(scene);
    if (!faults(scope).empty()) return found;
    SceneSpec copy = scene; // fields() hands out references to change
    PoleLooker looker(scope, found);
    for (RodSpec& rods : copy.rods) {
        looker.look_into((rods.body ? "bodies." : "rods.") + rods.name);
        rods.fields(looker);
    }
    for (std::size_t i = 0; i < copy.loads.size(); ++i) {
        looker.look_into(fmt::format("load.{}", i));
        copy.loads[i].fields(looker);
    }
    return found;
}

} // namespace skein
