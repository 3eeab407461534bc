#include "fluid/start_velocity.hpp"

namespace skein {

namespace {

/// Whether a value depends on anything but the place.
bool varies_otherwise(const Graph& graph, int node) {
    const Graph::Node& n = graph[node];
    if (n.op == Op::variable) return n.index > static_cast<int>(Variable::z);
    for (int k = 0; k < operands_of(n.op); ++k)
        if (varies_otherwise(graph, n.of[static_cast<std::size_t>(k)])) return true;
    return false;
}

} // namespace

StartVelocity::StartVelocity(const std::vector<std::string>& texts, const FormulaScope& names) : graph_(names.tables) {
    if (!skein::faults(names).empty()) return; // told of themselves
    if (texts.size() != 3) {
        faults_.push_back({{}, "a vector is 3 formulas, not " + std::to_string(texts.size())});
        return;
    }
    for (std::size_t i = 0; i < 3; ++i) {
        const auto read = read_formula(graph_, names, texts[i], static_cast<int>(i), "m/s", faults_);
        if (!read) continue;
        node_[i] = static_cast<std::size_t>(read->node);
        if (varies_otherwise(graph_, read->node))
            faults_.push_back(
                {{0, texts[i].size(), static_cast<int>(i)}, "it may name 'x', 'y', 'z', constants, tables and functions alone"});
    }
}

Vec3d StartVelocity::operator()(const Vec3d& place) const {
    std::array<double, variables> at{};
    at[static_cast<std::size_t>(Variable::x)] = place.x;
    at[static_cast<std::size_t>(Variable::y)] = place.y;
    at[static_cast<std::size_t>(Variable::z)] = place.z;
    const std::vector<double> values = graph_.values(at);
    return {values[node_[0]], values[node_[1]], values[node_[2]]};
}

} // namespace skein
