#include "scene/scene_check.hpp"

#include "scene/nearest.hpp"
#include "scene/scene_file.hpp"
#include "scene/scene_keys.hpp"
#include "skein/core/error.hpp"
#include "skein/core/objections.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>

#include <fmt/format.h>

namespace skein {

namespace {

bool good_name(const std::string& name) {
    return !name.empty() &&
           std::all_of(name.begin(), name.end(), [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-'; });
}

class Checker {
public:
    Checker(const SceneSpec& scene, const std::set<std::string>& given) : scene_(scene), given_(given) {}

    std::vector<Contradiction> run() {
        groups();
        time_and_output();
        for (std::size_t i = 0; i < scene_.rods.size(); ++i) {
            if (scene_.rods[i].material.rotary_inertia_for_dt > 0)
                unused(fmt::format("rods.{}.material", i), {"rotary_inertia_scale"},
                       "beside 'rotary_inertia_for_dt', which chooses it");
            rigid(scene_.rods[i], fmt::format("rods.{}", i));
            section(scene_.rods[i], fmt::format("rods.{}.section", i));
            shape(scene_.rods[i], fmt::format("rods.{}.shape", i));
            placement(scene_.rods[i], fmt::format("rods.{}.placement", i));
            magnetisation(scene_.rods[i], fmt::format("rods.{}.magnetisation", i));
            motion(scene_.rods[i].start_motion, scene_.rods[i].start, scene_.rods[i], fmt::format("rods.{}.start_motion", i));
            motion(scene_.rods[i].end_motion, scene_.rods[i].end, scene_.rods[i], fmt::format("rods.{}.end_motion", i));
            hold(scene_.rods[i], fmt::format("rods.{}.hold", i));
        }
        for (std::size_t i = 0; i < scene_.loads.size(); ++i) {
            const std::string path = fmt::format("load.{}", i);
            const auto groups = acted_on(scene_.loads[i].rods, path);
            TableObjections objections(*this, path);
            scene_.loads[i].load.check(groups, objections);
        }
        for (std::size_t i = 0; i < scene_.damping.size(); ++i) {
            const std::string path = fmt::format("damping.{}", i);
            damping(scene_.damping[i].damping, acted_on(scene_.damping[i].rods, path), path);
        }
        contact();
        walls();
        return std::move(found_);
    }

private:
    using Groups = std::vector<const RodSpec*>;

    void add(const std::string& path, const std::string& message) { found_.push_back({path, message}); }
    bool given(const std::string& path) const { return given_.contains(path); }
    /// Against one table, in which structs name their keys.
    class TableObjections final : public Objections {
    public:
        TableObjections(Checker& checker, std::string table) : checker_(checker), table_(std::move(table)) {}
        void add(std::string_view key, const std::string& message) override { checker_.add(path(key), message); }
        bool given(std::string_view key) const override { return checker_.given(path(key)); }

    private:
        std::string path(std::string_view key) const { return key.empty() ? table_ : fmt::format("{}.{}", table_, key); }
        Checker& checker_;
        std::string table_;
    };
    void unused(const std::string& table, std::initializer_list<std::string_view> keys, const std::string& where) {
        TableObjections(*this, table).unused(keys, where);
    }

    void groups() {
        if (scene_.rods.empty()) add("", "the scene has no rods: give at least one [[rods]]");
        for (std::size_t i = 0; i < scene_.rods.size(); ++i) {
            const std::string& name = scene_.rods[i].name;
            const std::string path = fmt::format("rods.{}.name", i);
            if (!good_name(name)) add(path, fmt::format("'{}' cannot name a group of rods: use letters, digits, _ and -", name));
            for (std::size_t j = 0; j < i; ++j)
                if (scene_.rods[j].name == name) {
                    add(path, fmt::format("two groups of rods are named '{}'", name));
                    break;
                }
        }
        count_rods();
    }

    void count_rods() {
        constexpr double most = 1099511627776.0; // 2^40: rods are numbered in 64 bits, and shared among ranks by sums of them
        double rods = 0;
        for (std::size_t i = 0; i < scene_.rods.size(); ++i) {
            double here = 1;
            for (const long n : scene_.rods[i].placement.counts) here *= static_cast<double>(n);
            if (scene_.rods[i].placement.kind == PlacementKind::packing)
                here = static_cast<double>(scene_.rods[i].placement.packing.count);
            rods += here;
            if (rods <= most) continue;
            add(fmt::format("rods.{}.placement.counts", i), fmt::format("{:.3g} rods are more than 2^40", rods));
            return;
        }
    }

    void time_and_output() {
        const double duration = scene_.time.duration;
        if (scene_.time.dt > duration)
            add("time.dt", fmt::format("'dt' of {} s is longer than 'duration' of {} s", scene_.time.dt, duration));
        const OutputSpec& out = scene_.output;
        const std::pair<const char*, double> intervals[] = {{"trajectory", out.trajectory},
                                                            {"tips", out.tips},
                                                            {"series", out.series},
                                                            {"contacts", out.contacts},
                                                            {"checkpoint", out.checkpoint}};
        for (const auto& [key, interval] : intervals)
            if (interval > duration)
                add(fmt::format("output.{}", key),
                    fmt::format("'{}' every {} s never comes due within 'duration' of {} s", key, interval, duration));
        if (scene_.start.from.empty()) unused("start", {"time"}, "without 'from'");
        else start();
        if (out.trajectory == 0) unused("output", {"paraview"}, "without 'trajectory' [s]");
        if (out.contacts > 0 && !scene_.contact) add("output.contacts", "'contacts' has no use without [contact]");
        if (scene_.time.rest_speed > 0 && out.series == 0)
            add("time.rest_speed", "'rest_speed' is looked at in the rows of the series: give output.series [s]");
        for (const RodSpec& rods : scene_.rods)
            if (out.audit && rods.material.law == Law::elastica)
                add("output.audit", fmt::format("there is no audit of group '{}': its law \"elastica\" has no energy", rods.name));
        for (const RodSpec& rods : scene_.rods)
            if (out.audit && rods.material.law == Law::rigid)
                add("output.audit", fmt::format("there is no audit of the rigid bodies of group '{}'", rods.name));
        for (std::size_t i = 0; i < out.observables.size(); ++i) {
            const std::string& set = out.observables[i];
            const std::string path = fmt::format("output.observables.{}", i);
            const std::vector<std::string_view> known(std::begin(observable_set_names), std::end(observable_set_names));
            if (std::find(known.begin(), known.end(), set) == known.end())
                add(path, fmt::format("there are no observables '{}'{}", set, suggestion(set, known, "the choices are")));
            else if (std::find(out.observables.begin(), out.observables.begin() + static_cast<long>(i), set) !=
                     out.observables.begin() + static_cast<long>(i))
                add(path, fmt::format("'{}' is named twice", set));
        }
    }

    void start() {
        try {
            checkpoint_name(scene_.start.from);
        } catch (const InputError& e) {
            add("start.from", e.what());
        }
        for (const RodSpec& rods : scene_.rods)
            if (scene_.start.time == StartTime::zero &&
                (rods.start_motion.moves() || rods.start_motion.turns() || rods.end_motion.moves() || rods.end_motion.turns()))
                add("start.time", fmt::format("the ends of group '{}' are moved as functions of time: at time zero they would jump "
                                              "back; let time go on",
                                              rods.name));
    }

    void rigid(const RodSpec& rods, const std::string& path) {
        if (rods.material.law != Law::rigid) return;
        const char* const where = "in a rigid body";
        unused(path + ".material",
               {"youngs_modulus", "shear_modulus", "shear_factor", "rotary_inertia_scale", "rotary_inertia_for_dt"}, where);
        unused(path + ".section", {"taper", "profile", "torsion_constant", "shear_factors", "bending_stiffness"}, where);
        unused(path + ".shape",
               {"length_profile", "rest_curvature", "rest_curvature_profile", "rest_strain", "closed", "start_curvature",
                "start_curvature_profile", "element_spin"},
               where);
        if (rods.shape.elements != 1)
            add(path + ".shape.elements", fmt::format("a rigid body is one element, and not {}", rods.shape.elements));
        if (rods.section.kind != SectionKind::circular) add(path + ".section.kind", "a rigid body has a circular section");
        if (rods.start != EndKind::free || rods.end != EndKind::free) add(path, "the ends of a rigid body must be free");
        if (rods.hold.any()) add(path + ".hold", "a rigid body cannot be held");
    }

    void section(const RodSpec& rods, const std::string& path) {
        const Section& s = rods.section;
        if (s.kind == SectionKind::elliptic && s.radius_2 == 0)
            add(path, "an elliptic section needs 'radius_2', its semi-axis along d2 [m]");
        if (s.kind == SectionKind::circular) unused(path, {"radius_2"}, "in a circular section; kind = \"elliptic\" has two radii");
        if (!s.shear_factors.empty()) {
            length(path + ".shear_factors", s.shear_factors.size(), 2, "one along d1 and one along d2");
            const std::string material = path.substr(0, path.rfind('.')) + ".material";
            unused(material, {"shear_factor"}, "beside 'shear_factors' of the section");
        }
        if (!s.bending_stiffness.empty())
            length(path + ".bending_stiffness", s.bending_stiffness.size(), 2, "E I1 about d1 and E I2 about d2");
        if (s.profile.empty()) return;
        unused(path, {"taper"}, "beside 'profile', which says the radius of every element");
        length(path + ".profile", s.profile.size(), rods.shape.elements, "one for each of the elements");
    }

    void shape(const RodSpec& rods, const std::string& path) {
        const Shape& s = rods.shape;
        if (s.closed && s.elements < 3) add(path + ".elements", "a ring needs at least 3 elements");
        if (s.closed && (rods.start != EndKind::free || rods.end != EndKind::free))
            add(path + ".closed", "a ring has no ends: 'start' and 'end' must be free");
        const auto clamped = [](EndKind end) { return end == EndKind::clamped || end == EndKind::clamped_frozen; };
        const bool both = rods.start != EndKind::free && rods.end != EndKind::free;
        if (!zero(s.angular_velocity) && (both || clamped(rods.start) || clamped(rods.end)))
            add(path + ".angular_velocity", "'angular_velocity' turns a rod as a whole, which must be free or pinned at one end "
                                            "only; 'element_spin' is that of elements in their places");
        if (s.rest_strain.z <= -1)
            add(path + ".rest_strain",
                fmt::format("'rest_strain' of {} along d3 leaves no length: it must be above -1", s.rest_strain.z));
        if (!s.length_profile.empty())
            length(path + ".length_profile", s.length_profile.size(), s.elements, "one for each of the elements");
        if (!s.start_curvature_profile.empty()) {
            unused(path, {"start_curvature"}, "beside 'start_curvature_profile'");
            length(path + ".start_curvature_profile", s.start_curvature_profile.size(), s.closed ? s.elements : s.elements - 1,
                   s.closed ? "one for each vertex of the ring" : "one for each inner vertex (elements - 1)");
        }
        if (s.rest_curvature_profile.empty()) return;
        unused(path, {"rest_curvature"}, "beside 'rest_curvature_profile'");
        length(path + ".rest_curvature_profile", s.rest_curvature_profile.size(), s.closed ? s.elements : s.elements - 1,
               s.closed ? "one for each vertex of the ring" : "one for each inner vertex (elements - 1)");
    }

    void motion(const EndMotion& m, EndKind end, const RodSpec& rods, const std::string& path) {
        if (!m.moves() && !m.turns()) {
            unused(path, {"times", "amplitude", "rotation_amplitude", "period", "phase", "smooth"},
                   "in a motion that neither moves nor turns its end");
            return;
        }
        if (end == EndKind::free) add(path, "a free end cannot be moved: hold it (\"pinned\" or \"clamped\")");
        if (end == EndKind::pinned && m.turns())
            add(path, "a pinned end turns freely: to prescribe its rotation it must be clamped");
        if (rods.material.law == Law::elastica && end == EndKind::clamped)
            add(path, "the walls of the law \"elastica\" stand still: use \"clamped_frozen\"");
        if (std::adjacent_find(m.times.begin(), m.times.end(), std::greater_equal<>()) != m.times.end())
            add(path + ".times", "'times' must rise from entry to entry");
        if (!m.translation.empty())
            length(path + ".translation", m.translation.size(), static_cast<long>(m.times.size()), "one for each of 'times'");
        if (!m.rotation.empty())
            length(path + ".rotation", m.rotation.size(), static_cast<long>(m.times.size()), "one for each of 'times'");
    }

    void hold(const RodSpec& rods, const std::string& path) {
        const auto within = [&](const std::vector<long>& numbers, const char* key, long count) {
            for (const long i : numbers)
                if (i >= count || i < -count) {
                    add(path + "." + key, fmt::format("'{}' names {}, but there are {}: give 0 to {}, or -1 to {} from the end",
                                                      key, i, count, count - 1, -count));
                    return;
                }
        };
        within(rods.hold.nodes, "nodes", rods.shape.closed ? rods.shape.elements : rods.shape.elements + 1);
        within(rods.hold.elements, "elements", rods.shape.elements);
        for (const auto& [key, letters] : {std::pair{"directions", &rods.hold.directions}, std::pair{"axes", &rods.hold.axes}})
            if (letters->empty() || letters->find_first_not_of("xyz") != std::string::npos)
                add(path + "." + key, fmt::format("'{}' is \"{}\"; it names lab axes, such as \"x\" or \"xy\"", key, *letters));
        if (rods.hold.nodes.empty()) unused(path, {"directions"}, "without 'nodes'");
        if (rods.hold.elements.empty()) unused(path, {"axes"}, "without 'elements'");
    }

    void length(const std::string& path, std::size_t has, long needs, const char* why) {
        const std::size_t dot = path.rfind('.');
        TableObjections(*this, path.substr(0, dot)).length(path.substr(dot + 1), has, needs, why);
    }

    void placement(const RodSpec& rods, const std::string& path) {
        const Placement& p = rods.placement;
        if (zero(p.tangent)) add(path + ".tangent", "'tangent' has no direction");
        else if (p.normal && zero(*p.normal)) add(path + ".normal", "'normal' has no direction");
        else if (p.normal && parallel(p.tangent, *p.normal))
            add(path + ".normal", "'tangent' and 'normal' are parallel; d1 needs a direction across the rod");
        const bool own = p.kind == PlacementKind::file || !p.tangents.empty();
        if (own && rods.ends_move())
            add(path, "rods with directions of their own have walls of their own, which cannot be moved: their ends must be still");
        if (own && rods.material.law == Law::elastica && (rods.start == EndKind::clamped || rods.end == EndKind::clamped))
            add(path,
                "the walls of the law \"elastica\" are the same for all rods of a group: use \"clamped_frozen\" for rods with "
                "directions of their own");
        const std::string where = fmt::format("for a placement of kind \"{}\"", placement_names[static_cast<std::size_t>(p.kind)]);
        if (p.kind != PlacementKind::packing)
            unused(path,
                   {"count", "seed", "region", "lower", "upper", "point", "radius", "height", "elevation", "azimuth",
                    "elevation_law", "gap", "attempts"},
                   where);
        switch (p.kind) {
        case PlacementKind::single:
            unused(path, {"counts", "spacing", "file", "origins", "tangents", "normals"}, where);
            break;
        case PlacementKind::line:
            unused(path, {"file", "origins", "tangents", "normals"}, where);
            counts_and_spacing(p, path, where, 1, 1);
            break;
        case PlacementKind::lattice:
            unused(path, {"file", "origins", "tangents", "normals"}, where);
            counts_and_spacing(p, path, where, 2, 3);
            break;
        case PlacementKind::mask:
            unused(path, {"counts", "origins", "tangents", "normals"}, where);
            if (p.file.empty()) add(path, fmt::format("'file', the bitmap, is needed {}", where));
            if (p.spacing.size() != 2)
                add(path + ".spacing", fmt::format("'spacing' needs 2 values {}, and has {}", where, p.spacing.size()));
            break;
        case PlacementKind::list:
            unused(path, {"counts", "spacing", "file"}, where);
            if (p.origins.empty()) add(path, fmt::format("'origins' are needed {}", where));
            directions(p, path);
            break;
        case PlacementKind::file:
            unused(path, {"counts", "spacing", "origins", "tangents", "normals"}, where);
            if (p.file.empty()) add(path, fmt::format("'file', with a row per rod, is needed {}", where));
            break;
        case PlacementKind::packing:
            unused(path, {"origin", "tangent", "normal", "counts", "spacing", "file", "origins", "tangents", "normals"}, where);
            packing(rods, path, where);
            break;
        }
    }

    /// Of a list whose rods have directions of their own.
    void directions(const Placement& p, const std::string& path) {
        if (!p.tangents.empty()) {
            unused(path, {"tangent", "normal"}, "beside 'tangents'");
            length(path + ".tangents", p.tangents.size(), static_cast<long>(p.origins.size()), "one for each of 'origins'");
        }
        for (std::size_t i = 0; i < p.tangents.size(); ++i)
            if (zero(p.tangents[i])) return add(fmt::format("{}.tangents.{}", path, i), "a tangent without direction");
        if (p.normals.empty()) return;
        if (p.tangents.empty()) return add(path + ".normals", "'normals' has no use without 'tangents'");
        length(path + ".normals", p.normals.size(), static_cast<long>(p.tangents.size()), "one for each of 'tangents'");
        for (std::size_t i = 0; i < std::min(p.normals.size(), p.tangents.size()); ++i)
            if (zero(p.normals[i]) || parallel(p.tangents[i], p.normals[i]))
                return add(fmt::format("{}.normals.{}", path, i), "a normal that has no direction, or that of its tangent");
    }

    /// Packed rods start straight, each in a frame of its own: there are no walls for them.
    void packing(const RodSpec& rods, const std::string& path, const std::string& where) {
        const Packing& p = rods.placement.packing;
        if (p.count == 0) add(path, fmt::format("'count', the number of rods, is needed {}", where));
        if (rods.start != EndKind::free || rods.end != EndKind::free)
            add(path, fmt::format("the ends of the rods must be free {}", where));
        const Shape& s = rods.shape;
        const bool curved =
            !s.start_curvature_profile.empty() ||
            (s.start_curvature ? !zero(*s.start_curvature) : !zero(s.rest_curvature) || !s.rest_curvature_profile.empty());
        if (s.closed || curved || !zero(s.rest_strain))
            add(path, fmt::format(
                          "the rods must start straight, without rest_strain, {}: curved ones can with start_curvature = [0, 0, 0]",
                          where));
        for (const auto& [key, range] : {std::pair{"elevation", &p.elevation}, std::pair{"azimuth", &p.azimuth}})
            if (range->size() != 2 || (*range)[0] > (*range)[1])
                add(path + "." + key, fmt::format("'{}' needs two angles, the least and the largest", key));
        if (p.region == PackingRegion::cylinder) {
            unused(path, {"lower", "upper"}, "for the region \"cylinder\"");
            if (p.radius == 0 || p.height == 0) add(path, "'radius' and 'height' [m] are needed for the region \"cylinder\"");
            return;
        }
        const std::string region = fmt::format("for the region \"{}\"", packing_region_names[static_cast<std::size_t>(p.region)]);
        unused(path, {"point", "radius", "height"}, region);
        if (!(p.upper.x > p.lower.x && p.upper.y > p.lower.y && (p.region == PackingRegion::slab || p.upper.z > p.lower.z)))
            add(given(path + ".upper") ? path + ".upper" : path, fmt::format("'upper' must lie beyond 'lower' {}", region));
    }

    void counts_and_spacing(const Placement& p, const std::string& path, const std::string& where, std::size_t fewest,
                            std::size_t most) {
        const std::size_t n = p.counts.size();
        const std::string needed = fewest == most ? fmt::format("{} value", fewest) : fmt::format("{} or {} values", fewest, most);
        if (n < fewest || n > most) add(path + ".counts", fmt::format("'counts' needs {} {}, and has {}", needed, where, n));
        else if (p.spacing.size() != n)
            add(path + ".spacing", fmt::format("'spacing' needs one value per count, {} in all, and has {}", n, p.spacing.size()));
    }

    void magnetisation(const RodSpec& rods, const std::string& path) {
        const Magnetisation& m = rods.magnetisation;
        const std::string where =
            fmt::format("for a magnetisation of pattern \"{}\"", magnetisation_names[static_cast<std::size_t>(m.pattern)]);
        if (m.pattern == MagnetisationPattern::none) {
            unused(path, {"strength", "direction", "wavelength_x", "wavelength_y", "phase"}, where);
            return;
        }
        if (m.strength == 0) add(path, fmt::format("'strength' [A/m] is needed {}", where));
        if (m.pattern == MagnetisationPattern::uniform) {
            unused(path, {"wavelength_x", "wavelength_y", "phase"}, where);
            if (zero(m.direction)) add(path + ".direction", "'direction' has no direction");
            return;
        }
        unused(path, {"direction"}, where);
        if (m.wavelength_x == 0) add(path, fmt::format("'wavelength_x' [m], not 0, is needed {}", where));
        if (m.pattern == MagnetisationPattern::wave_x) unused(path, {"wavelength_y"}, where);
        else if (m.wavelength_y == 0) add(path, fmt::format("'wavelength_y' [m], not 0, is needed {}", where));
    }

    /// Null where there is none, which is told.
    const RodSpec* group_named(const std::string& name, const std::string& path) {
        std::vector<std::string_view> known;
        for (const RodSpec& rods : scene_.rods) {
            if (rods.name == name) return &rods;
            known.push_back(rods.name);
        }
        add(path, fmt::format("there is no group of rods '{}'{}", name, suggestion(name, known, "the groups are")));
        return nullptr;
    }

    /// The groups that `names` stand for: all where it is empty.
    Groups acted_on(const std::vector<std::string>& names, const std::string& path) {
        Groups groups;
        if (names.empty()) {
            for (const RodSpec& rods : scene_.rods) groups.push_back(&rods);
            if (given(path + ".rods")) add(path + ".rods", "'rods' names no group; leave it out to mean all");
        }
        for (std::size_t i = 0; i < names.size(); ++i) {
            const std::string item = fmt::format("{}.rods.{}", path, i);
            const RodSpec* group = group_named(names[i], item);
            if (!group) continue;
            if (std::find(names.begin(), names.begin() + static_cast<long>(i), names[i]) != names.begin() + static_cast<long>(i))
                add(item, fmt::format("the group '{}' is named twice", names[i]));
            else groups.push_back(group);
        }
        return groups;
    }

    void damping(const Damping& d, const Groups& groups, const std::string& path) {
        if (d.kind == DampingKind::legacy || d.kind == DampingKind::laplacian) {
            TableObjections objections(*this, path);
            object_to_rigid_bodies(fmt::format("a damping of kind \"{}\"", damping_names[static_cast<std::size_t>(d.kind)]), groups,
                                   objections);
        }
        const std::string where = fmt::format("for a damping of kind \"{}\"", damping_names[static_cast<std::size_t>(d.kind)]);
        if (d.kind == DampingKind::laplacian) {
            unused(path, {"translational", "rotational"}, where);
            if (d.order == 0) add(path, fmt::format("'order', at least 1, is needed {}", where));
            if (!given(path + ".rate"))
                add(path, fmt::format("'rate' [1/s] is needed {}: that of motion which alternates from node to node", where));
            if (scene_.time.integrator != Integrator::verlet)
                add(path + ".kind", "a damping of kind \"laplacian\" needs integrator = \"verlet\": the kicks of \"pefrl\" go "
                                    "backwards too");
            return;
        }
        unused(path, {"order"}, where);
        if (d.kind == DampingKind::physical) {
            unused(path, {"rate"}, where);
            if (!given(path + ".translational") && !given(path + ".rotational"))
                add(path, fmt::format("'translational' [kg/s] or 'rotational' [kg m^2/s] is needed {}", where));
            return;
        }
        unused(path, {"translational", "rotational"}, where);
        if (!given(path + ".rate")) add(path, fmt::format("'rate' [1/s] is needed {}", where));
    }

    void law(const ContactLaw& law, const std::string& path) {
        if (law.stiffness == 0 && law.restitution <= 0)
            add(path, "it needs 'stiffness', a number or \"auto\", or 'restitution' and 'collision_time' [s]");
        if (law.stiffness_is_automatic() && law.restitution > 0)
            add(path + ".stiffness", "'stiffness' = \"auto\" has no use beside 'restitution', which chooses it");
        const bool of_rods = scene_.contact && !path.starts_with("wall");
        const double assumed = of_rods ? scene_.contact->overlap : ContactSpec{}.overlap;
        if (!law.stiffness_is_automatic()) unused(path, {"accepted_overlap"}, "without stiffness = \"auto\"");
        else if (law.accepted_overlap > assumed)
            add(given(path + ".accepted_overlap") ? path + ".accepted_overlap" : path + ".stiffness",
                fmt::format("an accepted overlap of {:g} is more than the {:g} that the time step allows for", law.accepted_overlap,
                            assumed));
        if (law.restitution <= 0) {
            unused(path, {"collision_time", "collision_speed"}, "without 'restitution'");
        } else {
            if (law.collision_time <= 0) add(path, "'restitution' needs 'collision_time' [s]");
            if (law.normal == ContactNormal::linear) unused(path, {"collision_speed"}, "for the linear law");
            else if (law.collision_speed <= 0) add(path, "'restitution' of the hertz law needs 'collision_speed' [m/s]");
        }
        if (law.friction == ContactFriction::none)
            unused(path, {"static_friction", "kinetic_friction", "friction_from"}, "without 'friction'");
        else if (law.static_friction <= 0 && law.kinetic_friction <= 0)
            add(path, "friction needs 'static_friction' or 'kinetic_friction'");
        const bool slips = law.friction == ContactFriction::regularised || law.friction == ContactFriction::published;
        if (slips && law.slip_speed <= 0) add(path, "this friction needs 'slip_speed' [m/s]");
        if (law.soft_until == 0) unused(path, {"soft_stiffness", "soft_damping"}, "without 'soft_until' [s]");
    }

    void contact() {
        if (!scene_.contact) {
            for (std::size_t i = 0; i < scene_.contact_pairs.size(); ++i)
                add(fmt::format("contact_pair.{}", i), "a [[contact_pair]] needs [contact]");
            return;
        }
        law(scene_.contact->law, "contact");
        if (!scene_.contact->self) unused("contact", {"self_gap"}, "without 'self'");
        if (scene_.time.integrator != Integrator::verlet)
            add("contact", "contact needs integrator = \"verlet\": the kicks of \"pefrl\" go backwards too");
        for (std::size_t i = 0; i < scene_.rods.size(); ++i)
            if (scene_.contact->self && scene_.rods[i].shape.closed)
                add(fmt::format("rods.{}.shape.closed", i), "rings do not touch themselves: contact.self is for open rods");
        for (std::size_t i = 0; i < scene_.contact_pairs.size(); ++i) {
            const ContactPair& pair = scene_.contact_pairs[i];
            const std::string path = fmt::format("contact_pair.{}", i);
            if (pair.between.size() != 2) add(path + ".between", "'between' names two groups, or one group twice");
            for (std::size_t j = 0; j < pair.between.size(); ++j)
                group_named(pair.between[j], fmt::format("{}.between.{}", path, j));
            law(pair.law, path);
            if (pair.law.normal != scene_.contact->law.normal || pair.law.friction != scene_.contact->law.friction)
                add(path, "'normal' and 'friction' must be those of [contact]; the numbers may differ");
        }
    }

    void walls() {
        for (std::size_t i = 0; i < scene_.walls.size(); ++i) {
            const Wall& wall = scene_.walls[i];
            const std::string path = fmt::format("wall.{}", i);
            if (!good_name(wall.name))
                add(path + ".name", fmt::format("'{}' cannot name a wall: use letters, digits, _ and -", wall.name));
            for (std::size_t j = 0; j < i; ++j)
                if (scene_.walls[j].name == wall.name) add(path + ".name", fmt::format("two walls are named '{}'", wall.name));
            acted_on(wall.rods, path);
            law(wall.law, path);
            if (wall.servo.drives()) watched(wall.servo.watch, path + ".servo.watch");
        }
        if (!scene_.walls.empty() && scene_.time.integrator != Integrator::verlet)
            add("wall.0", "walls need integrator = \"verlet\"");
    }

    /// A wall or a side of a box.
    void watched(const std::string& name, const std::string& path) {
        std::vector<std::string> names;
        for (const Wall& wall : scene_.walls) {
            if (wall.kind != WallKind::box) names.push_back(wall.name);
            else
                for (const std::string_view side : box_side_names)
                    if (has_side(wall, side)) names.push_back(fmt::format("{} {}", wall.name, side));
        }
        if (std::find(names.begin(), names.end(), name) != names.end()) return;
        const std::vector<std::string_view> known(names.begin(), names.end());
        add(path, fmt::format("there is no wall '{}' to watch{}", name, suggestion(name, known, "the walls are")));
    }

    const SceneSpec& scene_;
    const std::set<std::string>& given_;
    std::vector<Contradiction> found_;
};

/// "file:line: " of the table that a path starts with.
std::string source_prefix(const SceneSpec& scene, const std::string& path) {
    const auto prefix = [&](const auto& specs, std::size_t skip) {
        const std::string& source = specs.at(static_cast<std::size_t>(std::stoul(path.substr(skip)))).source;
        return (source.empty() ? path.substr(0, path.find('.', skip)) : source) + ": ";
    };
    if (path.starts_with("rods.")) return prefix(scene.rods, 5);
    if (path.starts_with("load.")) return prefix(scene.loads, 5);
    if (path.starts_with("damping.")) return prefix(scene.damping, 8);
    if (path.starts_with("contact_pair.")) return prefix(scene.contact_pairs, 13);
    if (path.starts_with("wall.")) return prefix(scene.walls, 5);
    return scene.file.empty() ? "" : scene.file + ": ";
}

} // namespace

std::vector<Contradiction> contradictions(const SceneSpec& scene, const std::set<std::string>& given) {
    return Checker(scene, given).run();
}

void check_scene(const SceneSpec& scene) {
    std::string text;
    for (const auto& [path, message] : contradictions(scene, changed_keys(scene)))
        text.append(text.empty() ? "" : "\n").append(source_prefix(scene, path) + message);
    if (!text.empty()) throw InputError(text);
}

} // namespace skein
