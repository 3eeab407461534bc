#include "fluid/flow_solver.hpp"

#include "fluid/flow_figures.hpp"
#include "fluid/make_flow.hpp"
#include "parallel/exact_sum.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

namespace {

constexpr Three<double> stage_rate{8.0 / 15, 5.0 / 12, 3.0 / 4}, stage_last{0, -17.0 / 60, -5.0 / 12}; // Wray

Pencils pencils_of(const Communicator& comm, const FlowConstants& constants) {
    if (const std::string fault = unshared(constants, comm.size()); !fault.empty()) throw InputError(fault);
    return {constants.grid, comm.rank(), comm.size(), ranks_across(constants, comm.size())};
}

} // namespace

BoxFlow::BoxFlow(const Communicator& comm, const Threads& threads, const FlowConstants& constants)
    : comm_(comm), threads_(threads), constants_(constants), pencils_(pencils_of(comm, constants)),
      layout_(pencils_.layout()), boundary_(comm, threads, constants_, pencils_), speed_(to_index(layout_.nz), 0.0) {
    if (constants.pressure == PressureMethod::direct) {
        direct_.emplace(comm, threads, constants.grid, pencils_, constants.exchange);
        equations_.push_back(Helmholtz::of_pressure(constants.grid));
        for (int c = 0; constants.scheme == FlowScheme::crank_nicolson && c < 3; ++c)
            equations_.emplace_back(constants.grid,
                                    std::array{boundary_.ends(c, 0), boundary_.ends(c, 1), boundary_.ends(c, 2)});
    } else iterated_poisson_.emplace(comm, threads, constants.grid, constants.pressure_tolerance);
    for (Three<Field>* fields : {&now_, &next_, &rate_})
        for (Field& field : *fields) field.assign(layout_.size(), 0.0);
    pressure_.assign(layout_.size(), 0.0);
}

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

void BoxFlow::refresh(double time) {
    go_to(time);
    for_planes(0, layout_.nz, [&](int k) {
        for (int c = 0; c < 3; ++c) boundary_.fill_plane(c, nth(now_, c).data(), k);
        P most(0.0);
        for (int j = 0; j < layout_.ny; ++j)
            for (int i = 0; i < layout_.nx; i += 8) {
                const std::size_t at = to_index(layout_.at(i, j, k));
                most = max(most, first_lanes(abs(load<8>(&now_[0][at])) + abs(load<8>(&now_[1][at])) +
                                                 abs(load<8>(&now_[2][at])),
                                             layout_.nx - i));
            }
        nth(speed_, k) = largest_of_lanes(most);
    });
    boundary_.fill_ghosts(0, velocities());
    fill_pressure();
    begun_ = true;
}

void BoxFlow::fill_pressure() {
    for_planes(0, layout_.nz, [&](int k) { boundary_.fill_plane(FlowBoundary::pressure, pressure_.data(), k); });
    boundary_.fill_ghosts(FlowBoundary::pressure, std::array{pressure_.data()});
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
    // The pressure is that of a step of rates alone, after which the velocities are restored. Its length follows from
    // the flow, so that units of time do not change the accuracy of rates.
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
                const std::size_t component = to_index(c);
                velocity(c, first[component], grid.h,
                         std::span(now_[component]).subspan(to_index(layout_.at(0, j, k)), to_index(layout_.nx)));
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
        for (int c = 0; viscosity == Viscosity::of_rates && c < 3; ++c)
            boundary_.fill_plane(c, nth(next_, c).data(), k);
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
        for (std::size_t c = 0; c < 3; ++c) boundary_.fill_plane(first + static_cast<int>(c), fields[c].data(), k);
    });
}

/// Adds known values of neighbours beyond moving walls to the right side.
void BoxFlow::add_beyond_walls(int c, double* field, double b) const {
    const auto add = [&](const FlowBoundary::Edge& wall, std::array<int, 3> first, std::array<int, 3> last) {
        for_planes(first[2], last[2], [&](int k) {
            for (int j = first[1]; j < last[1]; ++j)
                for (int i = first[0]; i < last[0]; ++i) field[layout_.at(i, j, k)] += b * wall.fixed;
        });
    };
    const std::array<int, 3> all{layout_.nx, layout_.ny, layout_.nz};
    for (int d = 0; d < 3; ++d)
        for (const bool upper : {false, true}) {
            const FlowBoundary::Edge wall = boundary_.edge(c, d, upper);
            if (wall.fixed == 0 || wall.on_face || !boundary_.has_end(d, upper)) continue;
            const std::size_t along = to_index(d);
            std::array<int, 3> first{0, 0, 0}, last = all;
            if (upper) first[along] = all[along] - 1;
            else last[along] = 1;
            add(wall, first, last);
        }
}

/// Convects the outflow with the mean velocity, and corrects it to balance the inflow.
void BoxFlow::pass_outflow(double dt) {
    if (constants_.grid.boundary[0] != FluidBoundary::through) return;
    const int last = layout_.nx - 1;
    const double share = dt * constants_.inflow.x / constants_.grid.h;
    Field &u = now_[0], &before = next_[0];
    std::vector<double> leaving(to_index(layout_.ny) * to_index(layout_.nz));
    for_planes(0, layout_.nz, [&](int k) {
        for (int j = 0; j < layout_.ny; ++j) {
            const std::size_t at = to_index(layout_.at(last, j, k));
            if (dt > 0) u[at] = before[at] - share * (before[at] - before[at - 1]);
            nth(leaving, k * layout_.ny + j) = u[at];
        }
    });
    const double out = exact_sums(comm_, std::span(&leaving, 1)).front(),
                 faces = static_cast<double>(constants_.grid.cells[1]) * constants_.grid.cells[2],
                 more = constants_.inflow.x - out / faces;
    for_planes(0, layout_.nz, [&](int k) {
        for (int j = 0; j < layout_.ny; ++j) nth(u, layout_.at(last, j, k)) += more;
        boundary_.fill_plane(0, u.data(), k);
    });
}

void BoxFlow::find_correction(Three<Field>& u, int first, double dt, Field& correction) {
    boundary_.exchange_rows(std::array{u[1].data()}); // for velocities into cells through faces of other ranks
    boundary_.fill_ghosts(first + 2, std::array{u[2].data()});
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
    for_planes(0, layout_.nz, [&](int k) { boundary_.fill_plane(FlowBoundary::pressure, correction.data(), k); });
    boundary_.fill_ghosts(FlowBoundary::pressure, std::array{correction.data()});
}

void BoxFlow::take_gradient(Three<Field>& u, int first, double dt, const Field& correction, bool keep) {
    const double pull = dt / constants_.grid.h;
    for_planes(0, layout_.nz + 1, [&](int k) { // the plane above for its pressure
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
            if (keep && layout_.nx % 8 == 0) // else the last pack includes it
                nth(pressure_, row + layout_.nx) += nth(correction, row + layout_.nx);
        }
        if (!inside) return;
        nth(speed_, k) = largest_of_lanes(most);
        for (int c = 0; c < 3; ++c) boundary_.fill_plane(first + c, nth(u, c).data(), k);
    });
    boundary_.fill_ghosts(first, std::array{u[0].data(), u[1].data(), u[2].data()});
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

/// Response of an implicit stage to pushes. Its scratch is next_, and correction_ makes it free of divergence.
class BoxFlow::ImplicitResponse final : public StageResponse {
public:
    /// `b` is that of diffuse().
    ImplicitResponse(BoxFlow& flow, double dt, double b) : flow_(flow), dt_(dt), b_(b) {}
    void clear() override {
        flow_.for_whole_planes([this](std::size_t begin, std::size_t end) {
            for (Field& field : flow_.next_) std::fill(field.data() + begin, field.data() + end, 0.0);
        });
    }
    void respond() override {
        flow_.diffuse(flow_.next_, FlowBoundary::change, b_);
        flow_.find_correction(flow_.next_, FlowBoundary::change, dt_, flow_.correction_);
        flow_.take_gradient(flow_.next_, FlowBoundary::change, dt_, flow_.correction_, false);
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
            .begin = {next_[0].data(), next_[1].data(), next_[2].data()},
            .time = stage.end,
            .dt = stage.whole,
            .ends_step = stage.last,
            .response = response,
            .fill_beyond_walls = [this](const std::function<bool(int)>& sides, bool beyond) {
                fill_sides(sides);
                for (int c = 0; beyond && c < 3; ++c) boundary_.fill_planes(c, nth(now_, c).data());
            }};
}

void BoxFlow::fill_sides(const std::function<bool(int)>& of_plane) {
    for_planes(0, layout_.nz, [&](int k) {
        if (!of_plane(k)) return;
        for (int c = 0; c < 3; ++c) boundary_.fill_plane(c, nth(now_, c).data(), k);
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
    const std::size_t at = to_index(s);
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
    // The last step ended at this time within rounding, which a resumed run does not know.
    if (s == 0 && oscillation(constants_, time) != boundary_.oscillation()) {
        go_to(time);
        boundary_.fill_beyond_walls(velocities());
    }
    const StageOfStep stage = stage_of_step(s, time, dt);
    go_to(stage.end);
    gain_times_ = 0;        // its field changes within a step
    if (implicit()) return; // bodies are part of its equations
    sweep<Viscosity::of_rates>(stage.factors, diffusion());
    pass_outflow(stage.whole);
    if (forcing_) forcing_->sample(forced_stage(stage));
}

void BoxFlow::end_stage(int s, double time, double dt) {
    const StageOfStep stage = stage_of_step(s, time, dt);
    if (implicit()) return step_half_implicit(stage, time, dt);
    force(forced_stage(stage));
    const bool every = constants_.scheme == FlowScheme::rk3_projected, one = stage_parts(constants_.scheme).count == 1;
    if (stage.last || every) project(every || one ? stage.whole : dt, true);
    else boundary_.fill_ghosts(0, velocities());
    if (!stage.last) return;
    note_pressure_time(time, dt);
    begun_ = true;
}

/// A pressure belongs to the mean time of the rates that it makes free of divergence. theory.md (77a)
void BoxFlow::note_pressure_time(double time, double dt) {
    constexpr double last_stage = 5.0 / 6, stage_before = 5.0 / 3; // rk3_projected: (gamma t + zeta t')/(gamma + zeta)
    if (constants_.scheme == FlowScheme::rk3_projected) {
        gain_times_ = (1 - last_stage) / (last_stage - stage_before);
        return;
    }
    const std::optional<double> before = pressure_time_;
    const bool first = before && *before == time; // the pressure belonged to the start
    const double middle = first && keeps_rates(constants_.scheme) ? time : time + 0.5 * dt;
    // Bodies that begin to act push the fluid, and the pressure of that belongs to no time. The same holds for an
    // implicit first step.
    pressure_time_ = first && (forcing_ || implicit()) ? std::nullopt : std::optional(middle);
    const bool known = pressure_time_ && before && middle > *before;
    gain_times_ = known ? (time + dt - middle) / (middle - *before) : 0;
}

/// The first step is Euler's, explicit in convection and implicit in viscosity, which damps oscillations after a sudden
/// start.
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

/// The gain of an implicit step is the new pressure less the old one.
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
    const int stay = std::max(0, layout_.nx - std::abs(cells)); // cells of a row that stay
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
    std::vector<FlowFigures> rows(to_index(layout_.ny) * to_index(layout_.nz));
    for_planes(0, layout_.nz, [&](int k) {
        for (int j = 0; j < layout_.ny; ++j)
            nth(rows, k * layout_.ny + j) =
                row_figures(constants_, layout_, {now_[0].data(), now_[1].data(), now_[2].data()}, j, k);
    });
    return rows;
}

std::unique_ptr<FlowSolver> make_flow(const Communicator& comm, const Threads& threads,
                                      const FlowConstants& constants) {
    return std::make_unique<BoxFlow>(comm, threads, constants);
}

} // namespace skein
