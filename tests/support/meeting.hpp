// A scene whose rods meet, stepped on one process without files.
#pragma once

#include "diagnostics/observables.hpp"
#include "mechanics/rod_copies.hpp"
#include "physics/contact/contact_plan.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "skein/core/index.hpp"
#include "support/scenes_for_tests.hpp"

#include <gtest/gtest.h>

#include <memory>

namespace skein::test {

class Meeting {
public:
    explicit Meeting(SceneSpec s, int lanes = 1, int thread_count = 1)
        : scene(std::move(s)), groups(make_groups(scene)),
          plan(make_plan(scene, groups, {1, thread_count, thread_count, lanes, {}, Mapping::automatic})),
          threads(thread_count), rods(make_rods(plan, groups, all_rods(groups), threads, around)), clock(plan.dt, 0) {
        const auto* contact = plan.find<ContactPlan>();
        if (contact)
            contacts = kernels(lanes).make_contacts(contact_scene(groups, contact->spec, contact->laws), threads);
    }
    /// `check`: bodies and rods must stay valid.
    void advance(std::int64_t steps, bool check = true) {
        for (std::int64_t until = clock.done() + steps; clock.done() < until;) {
            const auto batch = clock.next(until, 1);
            const Step& step = batch.front();
            rods->drift(step);
            if (contacts) {
                contacts->evaluate(*around.exposure, step.time, step.kick, *around.loads);
                touched = touched || contacts->figures().active > 0;
            }
            EXPECT_TRUE(rods->kick(step, check)) << clock.done();
            clock.advance(batch);
        }
    }
    const RodGroup& group_of(std::size_t i) const { return nth(groups, rods->local()[i].group); }
    std::vector<Slot<1>> state(std::size_t i) const {
        std::vector<Slot<1>> out(static_cast<std::size_t>(group_of(i).slots()));
        rods->export_rod(i, out);
        synchronise(group_of(i), out, clock.lag());
        return out;
    }
    Vec3d velocity(std::size_t i) const { return lane(state(i)[0].velocity, 0); }
    Vec3d spin(std::size_t i) const {
        const auto s = state(i);
        return lane(transpose_times(s[0].director, s[0].spin), 0);
    }
    double energy() const {
        double sum = 0;
        for (std::size_t i = 0; i < rods->local().size(); ++i) {
            const RodEnergy u = rod_energy(group_of(i), state(i));
            sum += u.translation + u.rotation + u.elastic();
        }
        return sum;
    }
    Momenta momenta() const {
        Momenta sum;
        for (std::size_t i = 0; i < rods->local().size(); ++i) {
            const auto s = state(i);
            sum.linear += skein::test::momenta(group_of(i), s).linear;
            const ExtraFigures f = extra_figures(group_of(i), s, {.angular_momentum = true});
            sum.angular += Vec3d{f.sum[0], f.sum[1], f.sum[2]};
        }
        return sum;
    }

    SceneSpec scene;
    std::vector<RodGroup> groups;
    Plan plan;
    Threads threads;
    Surroundings around;
    std::unique_ptr<Rods> rods;
    std::unique_ptr<ContactSolver> contacts;
    Clock clock;
    bool touched = false;
};

} // namespace skein::test
