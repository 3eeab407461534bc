#include "physics/contact/speed_estimate.hpp"

#include "contact/contact_limits.hpp"
#include "rod/body_shape.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace skein {

namespace {

/// Speeds of a group that its scene states, m/s.
struct Speeds {
    Vec3d common{0, 0, 0}; ///< of all of its bodies at the start
    double own = 0;        ///< beside that: of their turning, and of ends that are moved

    double of_one() const { return norm(common) + own; }
};

/// The fastest of an end that is moved, by a look at so many times: what swings faster than that is not seen.
double fastest(const EndMotion& motion, double duration, double radius) {
    constexpr int looks = 1024;
    double most = 0;
    if (!motion.moves() && !motion.turns()) return most;
    const double span =
        motion.period > 0 ? std::min(duration, std::max(motion.period, motion.times.empty() ? 0 : motion.times.back()))
                          : duration;
    for (int i = 0; i <= looks; ++i) {
        const double t = span * i / looks;
        if (const double speed = norm(motion.displacement(t).rate) + radius * norm(motion.turn(t).rate);
            std::isfinite(speed))
            most = std::max(most, speed);
    }
    return most;
}

double thinnest(const RodGroup& group) {
    double least = HUGE_VAL;
    if (group.body())
        for (const BodyShape::Part& part : group.body()->part) least = std::min(least, part.radius);
    else
        for_each_kind(group, [&](const RodGroup& kind, double) {
            for (const ElementConstants& e : kind.element) least = std::min(least, e.radius);
        });
    return least;
}

Speeds speeds_of(const RodGroup& group, double duration) {
    const RodSpec& spec = group.spec();
    Speeds speeds{spec.shape.velocity, 0};
    if (dot(spec.shape.angular_velocity, spec.shape.angular_velocity) > 0) {
        std::vector<Slot<1>> state(static_cast<std::size_t>(group.slots()));
        double reach = 0; // of rods as they lie about their middle, of bodies about their centre of mass
        if (group.body()) {
            for (const BodyShape::Part& part : group.body()->part)
                reach = std::max({reach, norm(part.from) + part.cover(), norm(part.to) + part.cover()});
        } else {
            for (const std::int64_t i : group.heterogeneous() ? group.places().held() : std::vector<std::int64_t>{0}) {
                group.start_state(i, state);
                for (const Slot<1>& a : state) reach = std::max(reach, norm(lane(a.position, 0) - group.centre(i)));
            }
        }
        speeds.own = norm(spec.shape.angular_velocity) * reach;
    }
    if (!group.body())
        for (const EndMotion* motion : {&spec.start_motion, &spec.end_motion})
            speeds.own = std::max(speeds.own, fastest(*motion, duration, group.element.front().radius));
    return speeds;
}

/// Depth to which a law lets these sink in, whole, at that speed, against the diameter; a doubt where they pass.
std::string softness(const Meeting& meeting, const ContactLaw& given, const ContactLaw& law, double mass) {
    const ContactLaw last = law.at(HUGE_VAL);
    if (!(last.stiffness > 0)) return {};
    const double energy = 0.5 * mass * meeting.speed * meeting.speed, depth = overlap_of_energy(last, energy);
    if (!(depth > meeting.diameter)) return {};
    return fmt::format(
        "contact: {} may meet at {:.3g} m/s, and would sink {:.2g} diameters into each other: they pass through; {} "
        "would hold them at the {:g} that the time step allows for",
        meeting.who, meeting.speed, depth / meeting.diameter,
        stiffer_law(given, law, mass, energy / energy_at(last, meeting.allowed * meeting.diameter)).text,
        meeting.allowed);
}

} // namespace

double SpeedEstimate::longest_step() const { return fastest.speed > 0 ? fastest.step() : HUGE_VAL; }

std::vector<std::string> SpeedEstimate::doubts_of_step(double dt) const {
    if (!(dt > longest_step() * (1 + 1e-9))) return {};
    return {fmt::format(
        "time.dt = {:.4g} s: {} may meet at {:.3g} m/s, {:.2g} diameters in a step, and an overlap of {:g} is "
        "allowed for; dt = {:.2g} would see them meet",
        dt, fastest.who, fastest.speed, fastest.speed * dt / fastest.diameter, fastest.allowed, 0.95 * longest_step())};
}

SpeedEstimate speed_estimate(const SceneSpec& scene, const ContactLaws* laws, std::span<const RodGroup> groups) {
    SpeedEstimate out;
    if (!laws && scene.walls.empty()) return out;
    std::vector<Speeds> speeds;
    for (const RodGroup& group : groups) speeds.push_back(speeds_of(group, scene.time.duration));
    const auto take = [&](Meeting meeting) {
        if (meeting.speed > 0 && (out.fastest.speed == 0 || meeting.step() < out.fastest.step()))
            out.fastest = std::move(meeting);
    };
    for (std::size_t a = 0; laws && a < groups.size(); ++a)
        for (std::size_t b = 0; b <= a; ++b) {
            if (a == b && groups[a].count() == 1 && !scene.contact->self) continue;
            const double speed =
                a == b ? 2 * speeds[a].own : norm(speeds[a].common - speeds[b].common) + speeds[a].own + speeds[b].own;
            if (!(speed > 0)) continue;
            const Meeting meeting{a == b ? fmt::format("two of '{}'", groups[a].name())
                                         : fmt::format("'{}' and '{}'", groups[b].name(), groups[a].name()),
                                  speed, 2 * std::min(thinnest(groups[a]), thinnest(groups[b])),
                                  scene.contact->overlap};
            take(meeting);
            if (const std::string doubt =
                    softness(meeting, scene.contact->law, laws->between(a, b), reduced_mass(groups[a], groups[b]));
                !doubt.empty())
                out.doubts.push_back(doubt);
        }
    for (const Wall& wall : scene.walls) {
        const double of_wall =
            wall.servo.drives() ? std::max(wall.servo.speed, wall.servo.approach) : norm(wall.velocity);
        for (std::size_t g = 0; g < groups.size(); ++g) {
            const double speed = of_wall + speeds[g].of_one();
            if (!wall.acts_on(groups[g].name()) || !(speed > 0)) continue;
            take({fmt::format("'{}' and the wall '{}'", groups[g].name(), wall.name), speed, 2 * thinnest(groups[g]),
                  ContactSpec{}.overlap});
        }
    }
    return out;
}

} // namespace skein
