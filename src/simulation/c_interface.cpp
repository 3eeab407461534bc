#include "skein/core/index.hpp"
#include "skein/run.hpp"
#include "skein/skein.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <exception>
#include <memory>
#include <string>
#include <utility>
#include <vector>

struct skein_run {
    skein_run(const skein::Scene& scene, const skein::RunSettings& settings)
        : run(scene, settings), groups(run.groups()) {}

    skein::Run run;
    std::vector<skein::GroupInfo> groups;
    std::string text; // that the last call has returned
};

namespace {

thread_local std::string last_error;

skein::Session& session() {
    static int none = 0;
    static char** no_words = nullptr;
    static skein::Session session(none, no_words);
    return session;
}

/// Result of `work`; `failed`, and a note of the reason, if it throws.
template <class F, class T> T guarded(F&& work, T failed) {
    try {
        return work();
    } catch (const std::exception& e) {
        last_error = e.what();
    } catch (...) {
        last_error = "an error of unknown kind";
    }
    return failed;
}

template <class F> const char* text_of(skein_run* run, F&& work) {
    return guarded(
        [&] {
            run->text = work();
            return run->text.c_str();
        },
        static_cast<const char*>(nullptr));
}

} // namespace

const char* skein_error() { return last_error.c_str(); }
int skein_rank() { return session().rank(); }
int skein_ranks() { return session().ranks(); }

skein_run* skein_open(const char* file, const char* toml, const char* const* overrides, int override_count, int threads,
                      int lanes) {
    return guarded(
        [&] {
            session();
            const std::vector<std::string> changes(overrides, overrides + override_count);
            const skein::Scene scene =
                toml ? skein::Scene::from_text(toml, changes, file) : skein::Scene(file, changes);
            return std::make_unique<skein_run>(scene, skein::RunSettings{.threads = threads, .lanes = lanes}).release();
        },
        static_cast<skein_run*>(nullptr));
}

void skein_close(skein_run* run) { delete run; }

const char* skein_plan(skein_run* run) {
    return text_of(run, [&] { return run->run.plan(); });
}
double skein_dt(skein_run* run) { return run->run.dt(); }
double skein_time(skein_run* run) { return run->run.time(); }
std::int64_t skein_step(skein_run* run) { return run->run.step(); }
std::int64_t skein_steps(skein_run* run) { return run->run.steps(); }

int skein_advance(skein_run* run, std::int64_t until) {
    return guarded(
        [&] {
            run->run.advance(until);
            return 0;
        },
        -1);
}
const char* skein_digest(skein_run* run) {
    return text_of(run, [&] { return run->run.digest(); });
}

const char* skein_observable_names(skein_run* run) {
    return text_of(run, [&] { return fmt::format("{}", fmt::join(run->run.observable_names(), ",")); });
}
int skein_observables(skein_run* run, double* out, int count) {
    return guarded(
        [&] {
            const std::vector<double> values = run->run.observables();
            std::copy_n(values.begin(), std::min(values.size(), static_cast<std::size_t>(std::max(count, 0))), out);
            return static_cast<int>(values.size());
        },
        -1);
}
const char* skein_contacts(skein_run* run) {
    return text_of(run, [&] { return run->run.contacts(); });
}
int skein_drive(skein_run* run, const char* table, double until, double value) {
    return guarded(
        [&] {
            run->run.drive(table, until, value);
            return 0;
        },
        -1);
}
int skein_set_table(skein_run* run, const char* table, const double* at, const double* value, std::int64_t count) {
    return guarded(
        [&] {
            const auto points = static_cast<std::size_t>(std::max(count, std::int64_t{0}));
            run->run.set_table(table, {at, points}, {value, points});
            return 0;
        },
        -1);
}
int skein_restart(skein_run* run, int group, const std::int64_t* rods, std::int64_t count) {
    return guarded(
        [&] {
            run->run.restart(static_cast<std::size_t>(group),
                             {rods, static_cast<std::size_t>(std::max(count, std::int64_t{0}))});
            return 0;
        },
        -1);
}
std::int64_t skein_table(skein_run* run, const char* table, double* at, double* value, std::int64_t count) {
    return guarded(
        [&] {
            const auto points = run->run.table(table);
            const auto copied = std::min(points.at.size(), static_cast<std::size_t>(std::max(count, std::int64_t{0})));
            std::copy_n(points.at.begin(), copied, at);
            std::copy_n(points.value.begin(), copied, value);
            return static_cast<std::int64_t>(points.at.size());
        },
        std::int64_t{-1});
}

int skein_finished(skein_run* run) { return run->run.finished() ? 1 : 0; }
const char* skein_stage(skein_run* run) {
    return text_of(run, [&] { return run->run.stage(); });
}
int skein_next_stage(skein_run* run) {
    return guarded(
        [&] {
            run->run.next_stage();
            return 0;
        },
        -1);
}

int skein_group_count(skein_run* run) { return static_cast<int>(run->groups.size()); }
const char* skein_group_name(skein_run* run, int group) { return nth(run->groups, group).name.c_str(); }
std::int64_t skein_group_rods(skein_run* run, int group) {
    return guarded([&] { return static_cast<std::int64_t>(run->run.numbers(static_cast<std::size_t>(group)).size()); },
                   std::int64_t{-1});
}
int skein_group_nodes(skein_run* run, int group) { return nth(run->groups, group).nodes; }
int skein_group_elements(skein_run* run, int group) { return nth(run->groups, group).elements; }
int skein_numbers(skein_run* run, int group, std::int64_t* out) {
    return guarded(
        [&] {
            const auto numbers = run->run.numbers(static_cast<std::size_t>(group));
            std::copy(numbers.begin(), numbers.end(), out);
            return 0;
        },
        -1);
}
int skein_read(skein_run* run, int group, int quantity, double* out, std::int64_t count) {
    return guarded(
        [&] {
            run->run.read(static_cast<std::size_t>(group), static_cast<skein::Quantity>(quantity),
                          {out, static_cast<std::size_t>(count)});
            return 0;
        },
        -1);
}
