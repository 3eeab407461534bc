// Twist, writhe and link of framed curves in a file, against diagnostics/knots. A curve is an object that has a centre
// line under one of the names below; its values are all numbers at or below keys that speak of twist, writhe or link
// (or are called tw, wr, lk), in the same object or, in order, in the entries of another list of the file. The kind of
// the segments added at the ends is part of a value's path ("writhe.end_to_end") or a text beside it; the published
// default is next_tangent. A curve is closed where it says so
// ("closed": true) or has as many frames as nodes: then nothing is added, unless a value names the segments it was
// taken with.
#include "replay.hpp"

#include "diagnostics/knots.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <initializer_list>
#include <optional>

namespace skein::replay {

namespace {

constexpr auto centre_line_names = {"center_line", "centre_line",         "centerline", "centreline",     "position",
                                    "positions",   "position_collection", "nodes",      "node_positions", "points"};
constexpr auto normal_names = {"normal_collection",   "normals", "normal", "d1", "directors", "director",
                               "director_collection", "frames",  "frame"};
constexpr auto radius_names = {"radius", "radii", "offset"};
constexpr auto length_names = {"segment_length", "additional_segment_length", "length_of_additional_segment"};
constexpr auto closed_names = {"closed", "is_closed", "ring", "periodic"};

using Names = std::initializer_list<const char*>;
std::optional<Entry> find(const Entry& e, const Names& names) {
    for (const char* name : names)
        if (e.has(name)) return e[name];
    return {};
}

/// Vectors as [item][component] or, where the first index is the component, [component][item]; one frame in a list is
/// taken out.
std::vector<Vec3d> vectors_of(const Entry& e) {
    const auto outer = e.list();
    if (outer.size() == 1) return vectors_of(outer[0]);
    if (outer.empty()) e.fail("is empty");
    const auto inner = outer[0].list();
    if (outer.size() == 3 && inner.size() != 3) {
        const auto x = outer[0].numbers(inner.size()), y = outer[1].numbers(inner.size()),
                   z = outer[2].numbers(inner.size());
        std::vector<Vec3d> vectors;
        for (std::size_t i = 0; i < x.size(); ++i) vectors.push_back({x[i], y[i], z[i]});
        return vectors;
    }
    if (!inner.empty() && inner[0].json().is_array()) { // frames: rows are directors
        std::vector<Vec3d> first;
        for (const Entry& frame : outer) first.push_back(frame.matrix().d1);
        return first;
    }
    return e.vectors(outer.size());
}

struct FramedCurve {
    std::vector<Vec3d> node, d1; ///< [n + 1], [n]; lab
    std::vector<double> radius;  ///< [n], m
    double length;               ///< of the segments added at the ends, m
    bool closed = false;         ///< the last segment returns to node 0; as nodes are then, [n], it is not repeated
};

FramedCurve read_curve(const Entry& e) {
    FramedCurve curve;
    curve.node = vectors_of(*find(e, centre_line_names));
    if (curve.node.size() < 3) e.fail("has a centre line of fewer than 3 nodes");
    const auto normal = find(e, normal_names);
    if (!normal) e.fail("has a centre line but no normals");
    curve.d1 = vectors_of(*normal);
    const auto says = find(e, closed_names);
    curve.closed = (says && says->json() == true) || curve.d1.size() == curve.node.size();
    if (curve.closed && curve.node.size() == curve.d1.size() + 1) {
        if (norm(curve.node.back() - curve.node.front()) > 1e-9 * norm(curve.node[1] - curve.node[0]))
            e.fail("is closed, but its last node is not its first");
        curve.node.pop_back();
    }
    const std::size_t n = curve.closed ? curve.node.size() : curve.node.size() - 1;
    if (curve.d1.size() != n)
        normal->fail("has " + std::to_string(curve.d1.size()) + " vectors, not " + std::to_string(n));
    if (const auto radius = find(e, radius_names))
        curve.radius = radius->json().is_number() ? std::vector(n, radius->number()) : radius->positives(n);
    curve.length = 0;
    for (std::size_t k = 0; k < n; ++k) curve.length += norm(curve.node[(k + 1) % curve.node.size()] - curve.node[k]);
    if (const auto length = find(e, length_names)) curve.length = length->positive();
    return curve;
}

void find_curves(const Entry& e, std::vector<Entry>& curves) {
    if (e.json().is_object()) {
        if (find(e, centre_line_names)) return curves.push_back(e);
        for (const auto& item : e.json().items()) find_curves(Entry(item.value(), e.path() + "." + item.key()), curves);
    } else if (e.json().is_array() && !e.json().empty() && e.json()[0].is_structured()) {
        for (const Entry& item : e.list()) find_curves(item, curves);
    }
}

struct Value {
    std::string path, kind_of_segments; ///< path below the object, lower case
    std::vector<double> numbers;
};

bool contains(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }
std::string lower(std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

enum class Quantity { none, twist, local_twist, writhe, link };

/// Of a value, from its path. Letters stand alone: "lk", "wr.end_to_end".
Quantity kind_of(const std::string& path) {
    const auto called = [&](const char* word, const std::string& letters) {
        return contains(path, word) || ("." + path + ".").find("." + letters + ".") != std::string::npos;
    };
    if (called("writhe", "wr")) return Quantity::writhe;
    if (called("twist", "tw")) return contains(path, "local") ? Quantity::local_twist : Quantity::twist;
    if (called("link", "lk")) return Quantity::link;
    return Quantity::none;
}

void flatten(const Entry& e, std::vector<double>& list) {
    if (!e.json().is_array()) return list.push_back(e.number());
    for (const Entry& item : e.list()) flatten(item, list);
}

/// Values at and below `e`; `kind`: the last text on the way down that names end segments.
void find_values(const Entry& e, const std::string& path, std::string kind, std::vector<Value>& values) {
    const auto& json = e.json();
    if (json.is_object()) {
        for (const auto& item : json.items())
            if (item.value().is_string() && contains(lower(item.key()), "segment"))
                kind = lower(item.value().get<std::string>());
        for (const auto& item : json.items())
            find_values(Entry(item.value(), e.path() + "." + item.key()),
                        path + (path.empty() ? "" : ".") + lower(item.key()), kind, values);
        return;
    }
    const bool named = kind_of(path) != Quantity::none;
    const bool judged = contains(path, "tolerance") || contains(path, "sensitivity") || contains(path, "scale");
    if (!named || judged) return;
    if (json.is_array() && !json.empty() && json[0].is_object()) {
        std::size_t i = 0;
        for (const Entry& item : e.list()) find_values(item, path + "." + std::to_string(i++), kind, values);
    } else if (json.is_number() || json.is_array()) {
        Value value{path, kind, {}};
        flatten(e, value.numbers);
        values.push_back(value);
    }
}

std::optional<EndSegments> end_segments(const Value& value) {
    for (const std::string& text : {value.path, value.kind_of_segments}) {
        if (contains(text, "next_tangent")) return EndSegments::next_tangent;
        if (contains(text, "end_to_end")) return EndSegments::end_to_end;
        if (contains(text, "net_tangent")) return EndSegments::net_tangent;
        if (contains(text, "none") || contains(text, "null") || contains(text, "without")) return EndSegments::none;
    }
    return {};
}

/// Of a closed curve: a line beside it, node i pushed along d1 of the segment before it.
double closed_link(const FramedCurve& c, const Value& value) {
    if (c.radius.empty()) throw InputError("'" + value.path + "' needs a radius of the curve");
    const std::size_t n = c.node.size();
    std::vector<Vec3d> beside;
    for (std::size_t i = 0; i < n; ++i) beside.push_back(c.node[i] + c.radius[(i + n - 1) % n] * c.d1[(i + n - 1) % n]);
    return linking(c.node, Curve::closed, beside, Curve::closed);
}

std::vector<double> evaluate(const FramedCurve& c, const Value& value) {
    const auto named = end_segments(value);
    const EndSegments ends = named.value_or(EndSegments::next_tangent);
    const Curve curve = c.closed ? Curve::closed : Curve::open;
    const Quantity kind = kind_of(value.path);
    if (contains(value.path, "local") && kind != Quantity::local_twist) throw NotBuilt("'" + value.path + "'");
    switch (kind) {
    case Quantity::local_twist:
        return local_twist(c.node, c.d1, curve);
    case Quantity::writhe:
        return {c.closed && !named ? writhe(c.node, Curve::closed)
                                   : writhe(with_end_segments(c.node, c.length, ends), Curve::open)};
    case Quantity::link:
        if (c.closed && !named) return {closed_link(c, value)};
        if (c.radius.empty()) throw InputError("'" + value.path + "' needs a radius of the curve");
        return {auxiliary_link(c.node, c.d1, c.radius, c.length, ends)};
    default:
        return {twist(c.node, c.d1, curve)};
    }
}

/// Added segments lie in a plane with their neighbours, where each of the published arcsines of 1 is up to 2e-8 rad off
/// and which way is chance: no other arithmetic gives the same digits beyond that.
double tolerance_of(const FramedCurve& c, const Value& value) {
    const Quantity kind = kind_of(value.path);
    const bool published_ends = (kind == Quantity::writhe || kind == Quantity::link) &&
                                (end_segments(value) ? *end_segments(value) != EndSegments::none : !c.closed);
    return published_ends ? 2e-8 : 1e-10;
}

/// Lists of objects in the file that are as many as the curves, and hold values.
std::vector<Entry> results_apart(const Entry& file, std::size_t curves) {
    for (const auto& item : file.json().items()) {
        std::vector<Entry> entries;
        for (const auto& inner : item.value().items())
            if (inner.value().is_object())
                entries.emplace_back(inner.value(), file.path() + "." + item.key() + "." + inner.key());
        std::vector<Value> values;
        if (!entries.empty()) find_values(entries[0], "", "", values);
        if (entries.size() == curves && !values.empty()) return entries;
    }
    return {};
}

} // namespace

std::vector<Deviation> replay_curves(const Entry& file) {
    std::vector<Entry> objects;
    find_curves(file, objects);
    if (objects.empty()) file.fail("has neither 'systems' nor framed curves");
    std::vector<FramedCurve> curves;
    for (const Entry& e : objects) curves.push_back(read_curve(e));
    std::vector<Value> inside;
    for (const Entry& e : objects) find_values(e, "", "", inside);
    const auto results = inside.empty() ? results_apart(file, curves.size()) : objects;
    if (results.empty()) file.fail("holds no twist, writhe or link");

    std::vector<Deviation> deviations;
    for (std::size_t i = 0; i < curves.size(); ++i) {
        std::vector<Value> values;
        find_values(results[i], "", "", values);
        for (const Value& value : values) {
            const auto computed = evaluate(curves[i], value);
            if (computed.size() != value.numbers.size())
                results[i].fail("has " + std::to_string(value.numbers.size()) + " numbers in '" + value.path +
                                "', not " + std::to_string(computed.size()));
            double worst = 0, scale = 1; // turns
            for (const double v : value.numbers) scale = std::max(scale, std::abs(v));
            for (std::size_t j = 0; j < computed.size(); ++j) {
                const double d = std::abs(computed[j] - value.numbers[j]) / scale;
                if (!(d <= worst)) worst = std::isnan(d) ? INFINITY : d;
            }
            deviations.push_back(
                {0, "curve " + std::to_string(i) + " " + value.path, worst, tolerance_of(curves[i], value)});
        }
    }
    return deviations;
}

} // namespace skein::replay
