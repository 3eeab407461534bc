#include "studies/fit_study.hpp"

#include "core/nearest.hpp"
#include "core/timer.hpp"
#include "scene/scene_file.hpp"
#include "simulation/simulation.hpp"
#include "skein/core/error.hpp"
#include "studies/scene_number.hpp"

#include <Eigen/Dense>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

namespace skein {

namespace {

/// A place on the rod that was measured.
struct MeasuredPlace {
    double s;
    Vec3d place;
};
struct MeasuredValue {
    std::string name;
    double value;
};
/// Rows that were measured with the same keys.
struct Experiment {
    std::vector<std::string> overrides;
    std::vector<MeasuredPlace> places;
    std::vector<MeasuredValue> values;
    std::optional<StaticState> state; ///< its last equilibrium
    std::size_t size() const { return 3 * places.size() + values.size(); }
};

std::size_t column(const CsvTable& data, const std::string& name) {
    const auto at = std::find(data.names.begin(), data.names.end(), name);
    return at == data.names.end() ? SIZE_MAX : static_cast<std::size_t>(at - data.names.begin());
}

std::vector<Experiment> experiments_of(const CsvTable& data) {
    const std::size_t s = column(data, "s"), x = column(data, "x"), y = column(data, "y"), z = column(data, "z");
    const bool shape = s != SIZE_MAX || x != SIZE_MAX || y != SIZE_MAX || z != SIZE_MAX;
    if (shape && (s == SIZE_MAX || x == SIZE_MAX || y == SIZE_MAX || z == SIZE_MAX))
        throw InputError("data of a shape need the columns s, x, y and z [m]");
    std::vector<Experiment> all;
    std::map<std::vector<std::string>, std::size_t> known;
    for (std::size_t row = 0; row < data.columns.front().size(); ++row) {
        std::vector<std::string> keys;
        std::vector<MeasuredValue> values;
        for (std::size_t c = 0; c < data.names.size(); ++c) {
            if (shape && (c == s || c == x || c == y || c == z)) continue;
            const std::string& name = data.names[c];
            const double value = data.columns[c][row];
            if (name.find('.') != std::string::npos) keys.push_back(fmt::format("{}={:.17g}", name, value));
            else if (!std::isnan(value)) values.push_back({name, value});
        }
        const auto [at, fresh] = known.try_emplace(keys, all.size());
        if (fresh) all.push_back({keys, {}, {}, {}});
        Experiment& own = all[at->second];
        own.values.insert(own.values.end(), values.begin(), values.end());
        if (shape)
            own.places.push_back(
                {data.columns[s][row], {data.columns[x][row], data.columns[y][row], data.columns[z][row]}});
    }
    return all;
}

/// Factor of the 95 % interval of Student's t with so many degrees of freedom (Abramowitz and Stegun 26.7.5).
double student(double freedom) {
    const double z = 1.959963984540054, z3 = z * z * z, z5 = z3 * z * z, z7 = z5 * z * z;
    return z + (z3 + z) / (4 * freedom) + (5 * z5 + 16 * z3 + 3 * z) / (96 * freedom * freedom) +
           (3 * z7 + 19 * z5 + 17 * z3 - 15 * z) / (384 * freedom * freedom * freedom);
}

class Fit {
public:
    Fit(const Communicator& comm, const Threads& threads, const Machine& machine, SceneText text, const CsvTable& data,
        FitOptions options)
        : comm_(comm), threads_(threads), machine_(machine), text_(std::move(text)), options_(std::move(options)),
          experiments_(experiments_of(data)) {
        const SceneSpec scene = parse_scene(text_.file, text_.text, text_.overrides);
        for (const std::string& key : options_.keys) {
            value_.push_back(number_at(scene, key).value);
            scale_.push_back(value_.back() != 0 ? std::abs(value_.back()) : 1);
        }
        for (const Experiment& one : experiments_) size_ += one.size();
        if (size_ <= value_.size())
            throw InputError(fmt::format("{} measured values are too few for {} numbers", size_, value_.size()));
    }

    FitReport run() {
        FitReport report;
        const auto numbers = static_cast<Eigen::Index>(value_.size());
        Unknown residual = predict(value_, true);
        double damping = 0;
        for (report.iterations = 1; report.iterations <= options_.most_iterations; ++report.iterations) {
            refuse_undetermined();
            const Eigen::MatrixXd square = slopes_.transpose() * slopes_;
            const Unknown down = slopes_.transpose() * residual;
            Eigen::MatrixXd damped = square;
            damped.diagonal() *= 1 + damping;
            const Unknown step = -damped.ldlt().solve(down);
            std::vector<double> trial = value_;
            for (Eigen::Index i = 0; i < numbers; ++i) trial[at(i)] += scale_[at(i)] * step[i];
            const double size = step.cwiseAbs().maxCoeff();
            std::optional<Unknown> next = try_to_predict(trial);
            if (next && next->squaredNorm() <= residual.squaredNorm() * (1 + 1e-12)) {
                value_ = std::move(trial);
                damping = damping > 1e-6 ? 0.1 * damping : 0;
                if (size < options_.tolerance) break;
                residual = predict(value_, true);
            } else {
                if (size < 1e3 * options_.tolerance) break; // as exact as slopes are
                damping = std::max(10 * damping, 1e-3);
                if (damping > 1e12) throw NumericalError("the fit finds no better numbers, and no minimum");
            }
        }
        residual = predict(value_, true);
        const auto freedom = static_cast<double>(size_ - value_.size());
        const double variance = residual.squaredNorm() / freedom;
        const Eigen::MatrixXd inverse = (slopes_.transpose() * slopes_).inverse();
        for (Eigen::Index i = 0; i < numbers; ++i)
            report.numbers.push_back({options_.keys[at(i)], value_[at(i)],
                                      student(freedom) * scale_[at(i)] * std::sqrt(variance * inverse(i, i))});
        report.values = size_;
        report.experiments = experiments_.size();
        report.misfit = std::sqrt(residual.squaredNorm() / static_cast<double>(size_));
        return report;
    }

private:
    static std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

    std::unique_ptr<StaticCase> case_of(const Experiment& experiment, std::span<const double> value) const {
        SceneText own = text_;
        own.overrides.insert(own.overrides.end(), experiment.overrides.begin(), experiment.overrides.end());
        for (std::size_t i = 0; i < value.size(); ++i)
            own.overrides.push_back(fmt::format("{}={:.17g}", options_.keys[i], value[i]));
        return static_case(own, machine_, options_.time);
    }

    /// Columns of observables.csv in a state.
    std::pair<std::vector<std::string>, std::vector<double>> observe(const StaticCase& one,
                                                                     const StaticState& state) const {
        Simulation simulation(comm_, threads_, one.scene, one.groups, one.plan, {.quiet = true});
        Rods& rods = simulation.world().rods();
        for (std::size_t i = 0; i < rods.local().size(); ++i) {
            const auto rod = static_cast<std::size_t>(rods.local()[i].gid);
            const auto begin = state.slot.begin();
            std::vector<Slot<1>> own(begin + static_cast<std::ptrdiff_t>(one.system->first_slot(rod)),
                                     begin + static_cast<std::ptrdiff_t>(one.system->first_slot(rod + 1)));
            rods.import_rod(i, own);
        }
        return {simulation.observation().names(), simulation.observation().values()};
    }

    /// Predicted values of an experiment, places first.
    Unknown values_of(const Experiment& experiment, const StaticCase& one, const StaticState& state) const {
        Unknown all(static_cast<Eigen::Index>(experiment.size()));
        Eigen::Index row = 0;
        std::size_t rod = 0;
        if (!options_.rods.empty())
            while (rod < one.rods.size() && nth(one.groups, one.rods[rod].group).name() != options_.rods) ++rod;
        if (rod == one.rods.size()) throw InputError(fmt::format("there are no rods '{}'", options_.rods));
        const RodGroup& group = nth(one.groups, one.rods[rod].group);
        const Slot<1>* slot = state.slot.data() + one.system->first_slot(rod);
        for (const MeasuredPlace& place : experiment.places) {
            double left = place.s;
            int k = 0;
            while (k + 1 < group.elements() && left > nth(group.element, k).rest_length)
                left -= nth(group.element, k++).rest_length;
            const double share = left * nth(group.element, k).inv_rest_length;
            const Vec3d x = (1 - share) * lane(slot[k].position, 0) + share * lane(slot[k + 1].position, 0);
            for (const double part : {x.x, x.y, x.z}) all[row++] = part;
        }
        if (experiment.values.empty()) return all;
        const auto [names, values] = observe(one, state);
        for (const MeasuredValue& value : experiment.values) {
            const auto found = std::find_if(names.begin(), names.end(), [&](const std::string& name) {
                return name.substr(0, name.find('[')) == value.name;
            });
            if (found == names.end())
                throw InputError(fmt::format(
                    "'{}' is no observable of the scene, nor a key of it, which has a dot{}", value.name,
                    suggestion(value.name, std::vector<std::string_view>(names.begin(), names.end()), "there are")));
            all[row++] = values[static_cast<std::size_t>(found - names.begin())];
        }
        return all;
    }

    static Unknown measured(const Experiment& experiment) {
        Unknown all(static_cast<Eigen::Index>(experiment.size()));
        Eigen::Index row = 0;
        for (const MeasuredPlace& place : experiment.places)
            for (const double part : {place.place.x, place.place.y, place.place.z}) all[row++] = part;
        for (const MeasuredValue& value : experiment.values) all[row++] = value.value;
        return all;
    }

    StaticState equilibrium(Experiment& experiment, StaticCase& one) const {
        if (experiment.state) {
            StaticState state = *experiment.state;
            one.system->lead_ends(state);
            NewtonSolver newton(*one.system, {});
            if (newton.solve(state, Unknown::Zero(one.system->unknowns())).converged) {
                one.system->refresh(state);
                return state;
            }
        }
        StaticState state = start_of(*one.system, one.groups, one.rods);
        NewtonSolver newton(*one.system, {});
        const Equilibrium found = newton.find(state, options_.time);
        if (!found.found) throw NumericalError(fmt::format("no equilibrium was found: {}", found.reason));
        one.system->refresh(state);
        return state;
    }

    /// Residuals at these numbers and, where asked for, their slopes by numbers over their scales.
    Unknown predict(const std::vector<double>& value, bool with_slopes) {
        Unknown all(static_cast<Eigen::Index>(size_));
        if (with_slopes) slopes_.resize(static_cast<Eigen::Index>(size_), static_cast<Eigen::Index>(value.size()));
        Eigen::Index row = 0;
        for (Experiment& experiment : experiments_) {
            const auto count = static_cast<Eigen::Index>(experiment.size());
            const std::unique_ptr<StaticCase> one = case_of(experiment, value);
            StaticState state = equilibrium(experiment, *one);
            all.segment(row, count) = values_of(experiment, *one, state) - measured(experiment);
            if (with_slopes) slopes_.middleRows(row, count) = slopes_of(experiment, *one, state, value);
            experiment.state = std::move(state);
            row += count;
        }
        return all;
    }
    std::optional<Unknown> try_to_predict(const std::vector<double>& value) {
        try {
            return predict(value, false);
        } catch (const Error&) { // such numbers are none
            return {};
        }
    }

    Eigen::MatrixXd slopes_of(const Experiment& experiment, StaticCase& one, const StaticState& state,
                              const std::vector<double>& value) const {
        constexpr double share = 1e-4;
        Eigen::MatrixXd all(static_cast<Eigen::Index>(experiment.size()), static_cast<Eigen::Index>(value.size()));
        StaticSystem::Balance balance = one.system->balance(state, true);
        const StaticSolution solution(*one.system, state, balance);
        for (std::size_t i = 0; i < value.size(); ++i) {
            const auto beside = [&](double side) {
                std::vector<double> other = value;
                other[i] += side * share * scale_[i];
                return case_of(experiment, other);
            };
            const std::unique_ptr<StaticCase> low = beside(-1), high = beside(1);
            const auto residual = [&](StaticCase& at) {
                StaticState own = state;
                at.system->lead_ends(own);
                return at.system->balance(own, false).residual;
            };
            const Unknown along = solution.solve((residual(*high) - residual(*low)) / (2 * share));
            const auto moved = [&](StaticCase& at, double side) {
                StaticState own = state;
                at.system->lead_ends(own);
                at.system->correct(own, side * share * along, 1);
                return values_of(experiment, at, own);
            };
            all.col(static_cast<Eigen::Index>(i)) = (moved(*high, 1) - moved(*low, -1)) / (2 * share);
        }
        return all;
    }

    /// Refuses numbers whose changes leave all values as they are.
    void refuse_undetermined() const {
        constexpr double least = 1e-6; // of the largest singular value, which slopes are exact to
        const Eigen::JacobiSVD<Eigen::MatrixXd> svd(slopes_, Eigen::ComputeThinV);
        const Unknown size = svd.singularValues();
        const Eigen::Index last = size.size() - 1;
        if (size[last] > least * size[0]) return;
        std::vector<std::string> together;
        for (Eigen::Index i = 0; i <= last; ++i)
            if (std::abs(svd.matrixV()(i, last)) > 0.1)
                together.push_back(fmt::format("{} ({:+.2g})", options_.keys[at(i)], svd.matrixV()(i, last)));
        throw InputError(
            together.size() == 1
                ? fmt::format("the data do not depend on {}", together.front())
                : fmt::format("the data do not determine {} apart: relative changes in these proportions change "
                              "nothing that was measured; hold one of them",
                              fmt::join(together, ", ")));
    }

    const Communicator& comm_;
    const Threads& threads_;
    Machine machine_;
    SceneText text_;
    FitOptions options_;
    std::vector<Experiment> experiments_;
    std::vector<double> value_, scale_;
    std::size_t size_ = 0;
    Eigen::MatrixXd slopes_;
};

} // namespace

FitReport fit(const Communicator& comm, const Threads& threads, const Machine& machine, const SceneText& text,
              const CsvTable& data, const FitOptions& options) {
    const double began = wall_seconds();
    FitReport report = Fit(comm, threads, machine, text, data, options).run();
    report.seconds = wall_seconds() - began;
    return report;
}

std::string to_text(const FitReport& report) {
    std::string text = fmt::format("Fit: {} values of {} experiments, {} iterations, {:.3g} s; misfit {:.3g} (rms)\n",
                                   report.values, report.experiments, report.iterations, report.seconds, report.misfit);
    for (const FittedNumber& one : report.numbers)
        text += fmt::format("  {:<40} {:>14.7g} +- {:.2g} (95 %)\n", one.key, one.value, one.half_width);
    return text;
}

std::string to_csv(const FitReport& report) {
    std::string text = "key,value,half_width_95\n";
    for (const FittedNumber& one : report.numbers)
        text += fmt::format("{},{:.17g},{:.6g}\n", one.key, one.value, one.half_width);
    return text;
}

} // namespace skein
