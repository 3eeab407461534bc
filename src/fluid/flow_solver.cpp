#include "fluid/flow_solver.hpp"

#include "fluid/ghost_exchange.hpp"
#include "fluid/make_flow.hpp"
#include "parallel/exact_sum.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

namespace {

constexpr int of_pressure = 3,
              of_change = 4; ///< `of_change` and the next two: of changes of velocities, 0 at walls that move
constexpr Three<double> stage_rate{8.0 / 15, 5.0 / 12, 3.0 / 4}, stage_last{0, -17.0 / 60, -5.0 / 12}; // Wray

Pencils pencils_of(const Communicator& comm, const FlowConstants& constants) {
    if (const std::string fault = unshared(constants, comm.size()); !fault.empty()) throw InputError(fault);
    return {constants.grid, comm.rank(), comm.size(), ranks_across(constants, comm.size())};
}

double sum_of_lanes(const Pack<8>& p) {
    double sum = 0;
    for (int l = 0; l < 8; ++l) sum += p[l];
    return sum;
}
double largest_of_lanes(const Pack<8>& p) {
    double most = p[0];
    for (int l = 1; l < 8; ++l) most = std::max(most, p[l]);
    return most;
}

} // namespace

BoxFlow::BoxFlow(const Communicator& comm, const Threads& threads, const FlowConstants& constants)
    : comm_(comm), threads_(threads), constants_(constants), pencils_(pencils_of(comm, constants)),
      layout_(pencils_.layout()), ghosts_(std::make_unique<GhostExchange>(comm, pencils_, constants.grid)),
      speed_(static_cast<std::size_t>(layout_.nz), 0.0) {
    if (constants.pressure == PressureMethod::direct) {
        direct_.emplace(comm, threads, constants.grid, pencils_, constants.exchange);
        equations_.push_back(Helmholtz::of_pressure(constants.grid));
        for (int c = 0; constants.scheme == FlowScheme::crank_nicolson && c < 3; ++c)
            equations_.emplace_back(constants.grid, std::array{ends(c, 0), ends(c, 1), ends(c, 2)});
    } else iterated_poisson_.emplace(comm, threads, constants.grid, constants.pressure_tolerance);
    for (Three<Field>* fields : {&now_, &next_, &rate_})
        for (Field& field : *fields) field.assign(layout_.size(), 0.0);
    pressure_.assign(layout_.size(), 0.0);
}
BoxFlow::~BoxFlow() = default;

void BoxFlow::set_forcing(StageForcing* forcing) {
    forcing_ = forcing;
    if (forcing && constants_.scheme == FlowScheme::crank_nicolson) correction_.assign(layout_.size(), 0.0);
}

void BoxFlow::keep_pressure_gain() {
    keeps_gain_ = true;
    if (implicit()) gain_.assign(layout_.size(), 0.0);
}

std::size_t BoxFlow::bytes() const {
    return (10 * layout_.size() + correction_.size() + gain_.size()) * sizeof(double) +
           (direct_ ? direct_->bytes() : iterated_poisson_->bytes());
}

bool BoxFlow::has_end(int d, bool upper) const {
    if (constants_.grid.periodic(d)) return false;
    if (d == 1) return pencils_.share() == (upper ? pencils_.across() - 1 : 0);
    return d == 0 || pencils_.slab() == (upper ? pencils_.slabs() - 1 : 0);
}

BoxFlow::Edge BoxFlow::edge(int c, int d, bool upper) const {
    const FluidBoundary kind = nth(constants_.grid.boundary, d);
    if (kind == FluidBoundary::periodic) return {0, 0, true, false};
    if (c == of_pressure) return {1, 0, false, false};
    if (c >= of_change) {
        Edge same = edge(c - of_change, d, upper);
        same.fixed = 0;
        return same;
    }
    const double inflow = component_of(constants_.inflow, c);
    if (kind == FluidBoundary::through) {
        if (upper) return {1, 0, false, false}; // of the normal velocity too: pass_outflow has set it at the face
        return {-1, c == d ? inflow : 2 * inflow, false, c == d};
    }
    if (c == d) return {-1, 0, false, true};
    if (kind == FluidBoundary::free_slip) return {1, 0, false, false};
    const Vec3d& wall = nth(constants_.wall_velocity, d)[upper ? 1 : 0];
    return {-1, 2 * oscillation_ * component_of(wall, c), false, false};
}

LineEnds BoxFlow::ends(int c, int d) const {
    const Edge lower = edge(c, d, false);
    if (lower.periodic) return LineEnds::periodic;
    if (lower.on_face) return LineEnds::faces_zero;
    return lower.mirrored > 0 ? LineEnds::gradient_zero : LineEnds::value_zero;
}

namespace {

/// Ghosts beyond the lower, and beyond the upper, of n numbers `stride` apart, the first of which is `f`; of `width`
/// such lines side by side.
template <class Edge> void fill_below(double* f, std::ptrdiff_t stride, std::ptrdiff_t width, const Edge& edge) {
    const auto at = [&](int i) { return f + i * stride; };
    for (std::ptrdiff_t x = 0; x < width; ++x)
        if (edge.on_face) {
            at(-1)[x] = edge.fixed;
            at(-2)[x] = 2 * edge.fixed + edge.mirrored * at(0)[x];
        } else {
            at(-1)[x] = edge.mirrored * at(0)[x] + edge.fixed;
            at(-2)[x] = edge.mirrored * at(1)[x] + edge.fixed;
        }
}
template <class Edge> void fill_above(double* f, int n, std::ptrdiff_t stride, std::ptrdiff_t width, const Edge& edge) {
    const auto at = [&](int i) { return f + (n + i) * stride; };
    for (std::ptrdiff_t x = 0; x < width; ++x)
        if (edge.on_face) {
            at(-1)[x] = edge.fixed;
            at(0)[x] = 2 * edge.fixed + edge.mirrored * at(-2)[x];
            at(1)[x] = 2 * edge.fixed + edge.mirrored * at(-3)[x];
        } else {
            at(0)[x] = edge.mirrored * at(-1)[x] + edge.fixed;
            at(1)[x] = edge.mirrored * at(-2)[x] + edge.fixed;
        }
}
/// Both.
template <class Edge>
void fill_line(double* f, int n, std::ptrdiff_t stride, std::ptrdiff_t width, const Edge& lower, const Edge& upper) {
    if (!lower.periodic) {
        fill_below(f, stride, width, lower);
        fill_above(f, n, stride, width, upper);
        return;
    }
    const auto at = [&](int i) { return f + i * stride; };
    for (std::ptrdiff_t x = 0; x < width; ++x) {
        at(-1)[x] = at(n - 1)[x];
        at(-2)[x] = at(n - 2)[x];
        at(n)[x] = at(0)[x];
        at(n + 1)[x] = at(1)[x];
    }
}

} // namespace

void BoxFlow::fill_plane(int c, double* field, int k) const {
    const Edge lower_x = edge(c, 0, false), upper_x = edge(c, 0, true);
    const bool shared = pencils_.across() > 1;
    const int beyond = shared ? FieldLayout::ghosts : 0; // rows of neighbours as they would, where walls have changed
    const bool profile = constants_.inflow_profile != InflowProfile::uniform && lower_x.fixed != 0;
    for (int j = -beyond; j < layout_.ny + beyond; ++j) {
        Edge lower = lower_x;
        if (profile) lower.fixed *= inflow_share(constants_, pencils_.rows().first + j, pencils_.planes().first + k);
        fill_line(field + layout_.at(0, j, k), layout_.nx, 1, 1, lower, upper_x);
    }
    double* const first = field + layout_.at(0, 0, k) - FieldLayout::before;
    if (!shared) return fill_line(first, layout_.ny, layout_.row, layout_.row, edge(c, 1, false), edge(c, 1, true));
    if (has_end(1, false)) fill_below(first, layout_.row, layout_.row, edge(c, 1, false));
    if (has_end(1, true)) fill_above(first, layout_.ny, layout_.row, layout_.row, edge(c, 1, true));
}

void BoxFlow::fill_planes(int c, double* field) const {
    double* const first = field + FieldLayout::ghosts * layout_.plane;
    if (has_end(2, false)) fill_below(first, layout_.plane, layout_.plane, edge(c, 2, false));
    if (has_end(2, true)) fill_above(first, layout_.nz, layout_.plane, layout_.plane, edge(c, 2, true));
}

void BoxFlow::fill_beyond_walls() {
    for_planes(-FieldLayout::ghosts, layout_.nz + FieldLayout::ghosts, [&](int k) { // those of neighbours as they would
        for (int c = 0; c < 3; ++c) fill_plane(c, nth(now_, c).data(), k);
    });
    for (int c = 0; c < 3; ++c) fill_planes(c, nth(now_, c).data());
}

void BoxFlow::fill_ghosts(int first, std::span<double* const> fields) {
    ghosts_->exchange_rows(fields);
    ghosts_->exchange_planes(fields);
    for (std::size_t f = 0; f < fields.size(); ++f) fill_planes(first + static_cast<int>(f), fields[f]);
}

void BoxFlow::refresh(double time) {
    go_to(time);
    for_planes(0, layout_.nz, [&](int k) {
        for (int c = 0; c < 3; ++c) fill_plane(c, nth(now_, c).data(), k);
        P most(0.0);
        for (int j = 0; j < layout_.ny; ++j)
            for (int i = 0; i < layout_.nx; i += 8) {
                const auto at = static_cast<std::size_t>(layout_.at(i, j, k));
                most = max(most, first_lanes(abs(load<8>(&now_[0][at])) + abs(load<8>(&now_[1][at])) +
                                                 abs(load<8>(&now_[2][at])),
                                             layout_.nx - i));
            }
        nth(speed_, k) = largest_of_lanes(most);
    });
    fill_ghosts(0, velocities());
    fill_pressure();
    begun_ = true;
}

void BoxFlow::fill_pressure() {
    for_planes(0, layout_.nz, [&](int k) { fill_plane(of_pressure, pressure_.data(), k); });
    fill_ghosts(of_pressure, std::array{pressure_.data()});
}

std::vector<std::span<double>> BoxFlow::state() {
    std::vector<std::span<double>> all;
    for (Field& field : now_) all.emplace_back(field);
    all.emplace_back(pressure_);
    if (keeps_rates(constants_.scheme))
        for (Field& field : rate_) all.emplace_back(field);
    return all;
}

void BoxFlow::set_velocity(const VelocityRow& velocity) {
    std::fill(pressure_.begin(), pressure_.end(), 0.0);
    sample(velocity);
    // The pressure that belongs to it: that of a step of rates alone, after which the velocities are put back. Its
    // length goes by the flow, so that rates lose no more digits in one unit of time than in another.
    const double limit = step_limit(1), dt = std::isfinite(limit) ? limit : 1;
    const Field u = now_[0];
    sweep<Viscosity::of_rates>({dt, 0, 0, {0, 0, 0}}, diffusion());
    pass_outflow(0);
    project(dt, true);
    std::swap(now_, next_);
    now_[0] = u;
    refresh(0);
    begun_ = false;
    set_pressure_time(0);
}

void BoxFlow::sample(const VelocityRow& velocity) {
    const FluidGrid& grid = constants_.grid;
    const double half = 0.5 * grid.h;
    for_planes(0, layout_.nz, [&](int k) {
        for (int j = 0; j < layout_.ny; ++j) {
            const Vec3d middle =
                grid.lower + grid.h * Vec3d{0.5, pencils_.rows().first + j + 0.5, pencils_.planes().first + k + 0.5};
            const Three<Vec3d> first{middle + Vec3d{half, 0, 0}, middle + Vec3d{0, half, 0},
                                     middle + Vec3d{0, 0, half}};
            for (int c = 0; c < 3; ++c) {
                const auto component = static_cast<std::size_t>(c);
                velocity(
                    c, first[component], grid.h,
                    std::span(now_[component])
                        .subspan(static_cast<std::size_t>(layout_.at(0, j, k)), static_cast<std::size_t>(layout_.nx)));
            }
        }
    });
    refresh(0);
    pass_outflow(0);
    project(1, false);
}

template <Viscosity viscosity> void BoxFlow::sweep(const StageFactors& factors, double diffusion) {
    const StageSweep<viscosity> sweep(layout_, constants_.grid.h, diffusion, factors);
    for_planes(0, layout_.nz, [&](int k) {
        for (int j = 0; j < layout_.ny; ++j) {
            const std::ptrdiff_t row = layout_.at(0, j, k);
            for (int i = 0; i < layout_.nx; i += 8) {
                const std::ptrdiff_t at = row + i;
                sweep.run({now_[0].data() + at, now_[1].data() + at, now_[2].data() + at}, pressure_.data() + at,
                          {rate_[0].data() + at, rate_[1].data() + at, rate_[2].data() + at},
                          {next_[0].data() + at, next_[1].data() + at, next_[2].data() + at});
            }
        }
        for (int c = 0; viscosity == Viscosity::of_rates && c < 3; ++c) fill_plane(c, nth(next_, c).data(), k);
    });
    std::swap(now_, next_);
}

void BoxFlow::diffuse(Three<Field>& fields, int first, double b) {
    for (std::size_t c = 0; b > 0 && c < 3; ++c) {
        double* const u = fields[c].data();
        add_beyond_walls(first + static_cast<int>(c), u, b);
        Helmholtz& equation = equations_[1 + c];
        equation.shift = equation.scale = -1 / b;
        direct_->solve(
            equation,
            [&](int i, int j, int k) __attribute__((always_inline)) { return load<8>(u + layout_.at(i, j, k)); },
            [&](int i, int j, int k, const P& value)
                __attribute__((always_inline)) { store(u + layout_.at(i, j, k), value); });
    }
    for_planes(0, layout_.nz, [&](int k) {
        for (std::size_t c = 0; c < 3; ++c) fill_plane(first + static_cast<int>(c), fields[c].data(), k);
    });
}

/// Of neighbours beyond walls along which these move what is known goes to the right side.
void BoxFlow::add_beyond_walls(int c, double* field, double b) const {
    const auto add = [&](const Edge& wall, std::array<int, 3> first, std::array<int, 3> last) {
        for_planes(first[2], last[2], [&](int k) {
            for (int j = first[1]; j < last[1]; ++j)
                for (int i = first[0]; i < last[0]; ++i) field[layout_.at(i, j, k)] += b * wall.fixed;
        });
    };
    const std::array<int, 3> all{layout_.nx, layout_.ny, layout_.nz};
    for (int d = 0; d < 3; ++d)
        for (const bool upper : {false, true}) {
            const Edge wall = edge(c, d, upper);
            if (wall.fixed == 0 || wall.on_face || !has_end(d, upper)) continue;
            const auto along = static_cast<std::size_t>(d);
            std::array<int, 3> first{0, 0, 0}, last = all;
            if (upper) first[along] = all[along] - 1;
            else last[along] = 1;
            add(wall, first, last);
        }
}

/// The fluid leaves with the mean velocity; what comes in goes out.
void BoxFlow::pass_outflow(double dt) {
    if (constants_.grid.boundary[0] != FluidBoundary::through) return;
    const int last = layout_.nx - 1;
    const double share = dt * constants_.inflow.x / constants_.grid.h;
    Field &u = now_[0], &before = next_[0];
    std::vector<double> leaving(static_cast<std::size_t>(layout_.ny) * static_cast<std::size_t>(layout_.nz));
    for_planes(0, layout_.nz, [&](int k) {
        for (int j = 0; j < layout_.ny; ++j) {
            const auto at = static_cast<std::size_t>(layout_.at(last, j, k));
            if (dt > 0) u[at] = before[at] - share * (before[at] - before[at - 1]);
            nth(leaving, k * layout_.ny + j) = u[at];
        }
    });
    const double out = exact_sums(comm_, std::span(&leaving, 1)).front(),
                 faces = static_cast<double>(constants_.grid.cells[1]) * constants_.grid.cells[2],
                 more = constants_.inflow.x - out / faces;
    for_planes(0, layout_.nz, [&](int k) {
        for (int j = 0; j < layout_.ny; ++j) nth(u, layout_.at(last, j, k)) += more;
        fill_plane(0, u.data(), k);
    });
}

void BoxFlow::find_correction(Three<Field>& u, int first, double dt, Field& correction) {
    ghosts_->exchange_rows(std::array{u[1].data()}); // of velocities into a cell, those through faces that others have
    fill_ghosts(first + 2, std::array{u[2].data()});
    const double per_time = 1 / (dt * constants_.grid.h);
    const auto source = [&](int i, int j, int k) __attribute__((always_inline)) {
        const std::ptrdiff_t at = layout_.at(i, j, k);
        return P(per_time) * outflow_of(layout_, {u[0].data() + at, u[1].data() + at, u[2].data() + at});
    };
    const auto sink = [&](int i, int j, int k, const P& phi) __attribute__((always_inline)) {
        store(&nth(correction, layout_.at(i, j, k)), phi);
    };
    if (direct_) direct_->solve(equations_.front(), source, sink);
    else iterated_poisson_->solve(source, sink);
    for_planes(0, layout_.nz, [&](int k) { fill_plane(of_pressure, correction.data(), k); });
    fill_ghosts(of_pressure, std::array{correction.data()});
}

void BoxFlow::take_gradient(Three<Field>& u, int first, double dt, const Field& correction, bool keep) {
    const double pull = dt / constants_.grid.h;
    for_planes(0, layout_.nz + 1, [&](int k) { // the pressure of the plane above too
        const bool inside = k < layout_.nz;
        P most(0.0);
        for (int j = 0; j <= layout_.ny; ++j) {
            const std::ptrdiff_t row = layout_.at(0, j, k);
            for (int i = 0; i < layout_.nx; i += 8) {
                const std::ptrdiff_t at = row + i;
                const double* const from = correction.data() + at;
                const P phi = load<8>(from);
                if (keep) store(pressure_.data() + at, load<8>(pressure_.data() + at) + phi);
                if (!inside || j == layout_.ny) continue;
                const auto correct = [&](std::size_t c, std::ptrdiff_t ahead) __attribute__((always_inline)) {
                    double* const to = u[c].data() + at;
                    const P velocity = fnma(P(pull), load<8>(from + ahead) - phi, load<8>(to));
                    store(to, velocity);
                    return abs(velocity);
                };
                most = max(most, first_lanes(correct(0, 1) + correct(1, layout_.row) + correct(2, layout_.plane),
                                             layout_.nx - i));
            }
            if (keep && layout_.nx % 8 == 0) // else the last pack has had it
                nth(pressure_, row + layout_.nx) += nth(correction, row + layout_.nx);
        }
        if (!inside) return;
        nth(speed_, k) = largest_of_lanes(most);
        for (int c = 0; c < 3; ++c) fill_plane(first + c, nth(u, c).data(), k);
    });
    fill_ghosts(first, std::array{u[0].data(), u[1].data(), u[2].data()});
}

void BoxFlow::project(double dt, bool keep) {
    find_correction(now_, 0, dt, next_[0]);
    take_gradient(now_, 0, dt, next_[0], keep);
}

void BoxFlow::keep_diffused(const Field& correction, double times, double b) {
    for_planes(0, layout_.nz, [&](int k) {
        for (int j = 0; j < layout_.ny; ++j)
            for (int i = 0; i < layout_.nx; i += 8) {
                const std::ptrdiff_t at = layout_.at(i, j, k);
                const double* const f = correction.data() + at;
                const P here = load<8>(f), diffused = fnma(P(b), fnma(P(6.0), here, around(layout_, f)), here);
                store(pressure_.data() + at, fma(P(times), diffused, load<8>(pressure_.data() + at)));
            }
    });
}

/// What an implicit stage makes of pushes: its scratch is next_, and what makes it free of divergence correction_.
class BoxFlow::ImplicitResponse final : public StageResponse {
public:
    /// `b`: see diffuse().
    ImplicitResponse(BoxFlow& flow, double dt, double b) : flow_(flow), dt_(dt), b_(b) {}
    void clear() override {
        flow_.for_whole_planes([this](std::size_t begin, std::size_t end) {
            for (Field& field : flow_.next_) std::fill(field.data() + begin, field.data() + end, 0.0);
        });
    }
    void respond() override {
        flow_.diffuse(flow_.next_, of_change, b_);
        flow_.find_correction(flow_.next_, of_change, dt_, flow_.correction_);
        flow_.take_gradient(flow_.next_, of_change, dt_, flow_.correction_, false);
    }
    void add(double times) override {
        flow_.for_whole_planes([&](std::size_t begin, std::size_t end) {
            for (std::size_t c = 0; c < 3; ++c)
                for (std::size_t at = begin; at < end; at += 8)
                    store(&flow_.now_[c][at], fma(P(times), load<8>(&flow_.next_[c][at]), load<8>(&flow_.now_[c][at])));
        });
        flow_.keep_diffused(flow_.correction_, times, b_);
    }

private:
    BoxFlow& flow_;
    double dt_, b_;
};

FlowStage BoxFlow::forced_stage(const StageOfStep& stage, StageResponse* response) {
    return {.velocity = velocities(),
            .scratch = {next_[0].data(), next_[1].data(), next_[2].data()},
            .time = stage.end,
            .dt = stage.whole,
            .ends_step = stage.last,
            .response = response,
            .fill_beyond_walls = [this](const std::function<bool(int)>& sides, bool beyond) {
                fill_sides(sides);
                for (int c = 0; beyond && c < 3; ++c) fill_planes(c, nth(now_, c).data());
            }};
}

void BoxFlow::fill_sides(const std::function<bool(int)>& of_plane) {
    for_planes(0, layout_.nz, [&](int k) {
        if (!of_plane(k)) return;
        for (int c = 0; c < 3; ++c) fill_plane(c, nth(now_, c).data(), k);
    });
}

void BoxFlow::force(const FlowStage& stage) {
    if (!forcing_) return;
    forcing_->apply(stage);
    fill_sides([this](int k) { return forcing_->changed(k); });
}

BoxFlow::StageOfStep BoxFlow::stage_of_step(int s, double time, double dt) const {
    const StageParts parts = stage_parts(constants_.scheme);
    const bool one = parts.count == 1;
    const auto at = static_cast<std::size_t>(s);
    const double last_rate = !one     ? stage_last[at]
                             : begun_ ? -0.5
                                      : 0.0,
                 rate = one ? 1 - last_rate : stage_rate[at], whole = rate + last_rate;
    const auto after = [&](int stages) {
        return stages == parts.count ? time + dt : time + static_cast<double>(parts.until(stages)) / parts.unit * dt;
    };
    const Vec3d& a = constants_.acceleration;
    const double push = oscillation_integral(constants_, after(s), whole * dt);
    return {.factors = {rate * dt, last_rate * dt, whole * dt, {push * a.x, push * a.y, push * a.z}},
            .whole = whole * dt,
            .end = after(s + 1),
            .last = s + 1 == parts.count};
}

void BoxFlow::begin_stage(int s, double time, double dt) {
    // The last step ended at this time but for rounding, which a run that goes on from a checkpoint does not know.
    if (s == 0 && oscillation(constants_, time) != oscillation_) {
        go_to(time);
        fill_beyond_walls();
    }
    const StageOfStep stage = stage_of_step(s, time, dt);
    go_to(stage.end);
    gain_times_ = 0;                                             // its field is changed within a step
    if (constants_.scheme == FlowScheme::crank_nicolson) return; // bodies are a part of its equations
    sweep<Viscosity::of_rates>(stage.factors, diffusion());
    pass_outflow(stage.whole);
    if (forcing_) forcing_->sample(forced_stage(stage));
}

void BoxFlow::end_stage(int s, double time, double dt) {
    const StageOfStep stage = stage_of_step(s, time, dt);
    if (constants_.scheme == FlowScheme::crank_nicolson) return step_half_implicit(stage, time, dt);
    force(forced_stage(stage));
    const bool every = constants_.scheme == FlowScheme::rk3_projected, one = stage_parts(constants_.scheme).count == 1;
    if (stage.last || every) project(every || one ? stage.whole : dt, true);
    else fill_ghosts(0, velocities());
    if (!stage.last) return;
    note_pressure_time(time, dt);
    begun_ = true;
}

/// A pressure is that of the mean time of the rates that it makes free of divergence. theory.md (77a)
void BoxFlow::note_pressure_time(double time, double dt) {
    constexpr double last_stage = 5.0 / 6,
                     stage_before = 5.0 / 3; // of rk3_projected: (gamma t + zeta t')/(gamma + zeta)
    if (constants_.scheme == FlowScheme::rk3_projected) {
        gain_times_ = (1 - last_stage) / (last_stage - stage_before);
        return;
    }
    const std::optional<double> before = pressure_time_;
    const bool first = before && *before == time; // the pressure was that of the start
    const double middle = first && keeps_rates(constants_.scheme) ? time : time + 0.5 * dt;
    // Bodies that begin to act give the fluid a push, whose pressure belongs to no time; nor does that of an implicit
    // first step.
    pressure_time_ = first && (forcing_ || implicit()) ? std::nullopt : std::optional(middle);
    const bool known = pressure_time_ && before && middle > *before;
    gain_times_ = known ? (time + dt - middle) / (middle - *before) : 0;
}

/// The first step is Euler's, explicit in convection and implicit in viscosity: it damps what a start at once would
/// leave to swing.
void BoxFlow::step_half_implicit(const StageOfStep& whole, double time, double dt) {
    const double ahead = begun_ ? 0.5 : 1.0, b = ahead * dt * diffusion();
    sweep<Viscosity::of_velocity>(whole.factors, (1 - ahead) * dt * diffusion());
    ImplicitResponse response(*this, dt, b);
    const FlowStage stage = forced_stage(whole, &response);
    if (forcing_) forcing_->add_held_forces(stage);
    diffuse(now_, 0, b);
    project(dt, false);
    add_to_gain(-1);
    keep_diffused(next_[0], 1, b);
    if (forcing_) {
        forcing_->apply(stage);
        refresh(whole.end);
    } else fill_pressure();
    add_to_gain(1);
    note_pressure_time(time, dt);
    begun_ = true;
}

/// In implicit steps the gain is the pressure less what it was.
void BoxFlow::add_to_gain(double times) {
    if (gain_.empty()) return;
    for_whole_planes([&](std::size_t begin, std::size_t end) {
        for (std::size_t at = begin; at < end; at += 8) {
            const P pressure = load<8>(&pressure_[at]);
            store(&gain_[at], times < 0 ? P(0.0) - pressure : load<8>(&gain_[at]) + pressure);
        }
    });
}

double BoxFlow::step_limit(double courant) const {
    return skein::step_limit(constants_, comm_.max(largest_speed()), courant);
}

void BoxFlow::move_box(int cells) {
    const std::array<Field*, 4> fields{&now_[0], &now_[1], &now_[2], &pressure_};
    const int stay = std::max(0, layout_.nx - std::abs(cells)); // of a row
    for_planes(0, layout_.nz, [&](int k) {
        for (int j = 0; j < layout_.ny; ++j)
            for (Field* const field : fields) {
                const auto row = field->begin() + layout_.at(0, j, k), end = row + layout_.nx;
                const double from = field == &pressure_ ? (cells > 0 ? *(end - 1) : *row) : 0;
                if (cells > 0) std::fill(std::copy(end - stay, end, row), end, from);
                else std::fill(row, std::copy_backward(row, row + stay, end), from);
            }
    });
    refresh(time_);
    gain_times_ = 0;
}

std::vector<FlowFigures> BoxFlow::figures() const {
    const double h = constants_.grid.h, mass = constants_.density * h * h * h;
    std::vector<FlowFigures> rows(static_cast<std::size_t>(layout_.ny) * static_cast<std::size_t>(layout_.nz));
    for_planes(0, layout_.nz, [&](int k) {
        const std::ptrdiff_t r = layout_.row, p = layout_.plane;
        for (int j = 0; j < layout_.ny; ++j) {
            Three<P> sum{P(0.0), P(0.0), P(0.0)};
            P squares(0.0), loss(0.0), vorticity(0.0), divergence(0.0), speed(0.0);
            for (int i = 0; i < layout_.nx; i += 8) {
                const std::ptrdiff_t at = layout_.at(i, j, k);
                const auto of = [&](const P& value) { return first_lanes(value, layout_.nx - i); };
                P here_speed(0.0);
                for (std::size_t c = 0; c < 3; ++c) {
                    const double* f = now_[c].data() + at;
                    const P here = of(load<8>(f));
                    sum[c] += here;
                    here_speed += abs(here);
                    squares = fma(here, here, squares);
                    loss = fma(here, of(fms(P(6.0), here, around(layout_, f))), loss);
                }
                speed = max(speed, here_speed);
                const double *const u = now_[0].data() + at, *const v = now_[1].data() + at,
                                    *const w = now_[2].data() + at;
                const P x = of((load<8>(w + r) - load<8>(w)) - (load<8>(v + p) - load<8>(v))),
                        y = of((load<8>(u + p) - load<8>(u)) - (load<8>(w + 1) - load<8>(w))),
                        z = of((load<8>(v + 1) - load<8>(v)) - (load<8>(u + r) - load<8>(u)));
                vorticity += fma(x, x, fma(y, y, z * z));
                divergence = max(divergence, of(abs(outflow_of(layout_, {u, v, w}))));
            }
            FlowFigures& f = nth(rows, k * layout_.ny + j);
            f.kinetic_energy = 0.5 * mass * sum_of_lanes(squares);
            f.enstrophy = 0.5 * h * sum_of_lanes(vorticity);
            f.dissipation = mass * constants_.kinematic_viscosity * sum_of_lanes(loss) / (h * h);
            f.divergence = largest_of_lanes(divergence) / h;
            f.speed = largest_of_lanes(speed);
            f.momentum = mass * Vec3d{sum_of_lanes(sum[0]), sum_of_lanes(sum[1]), sum_of_lanes(sum[2])};
        }
    });
    return rows;
}

std::unique_ptr<FlowSolver> make_flow(const Communicator& comm, const Threads& threads,
                                      const FlowConstants& constants) {
    return std::make_unique<BoxFlow>(comm, threads, constants);
}

} // namespace skein
