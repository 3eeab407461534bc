#include "studies/fit_study.hpp"

#include "core/nearest.hpp"
#include "core/timer.hpp"
#include "scene/scene_file.hpp"
#include "skein/core/error.hpp"
#include "studies/fit_data.hpp"
#include "studies/number_effects.hpp"
#include "studies/scene_number.hpp"

#include <Eigen/Dense>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace skein {

namespace {

constexpr const char* places = "places"; ///< kind of values of a shape

/// Factor of the 95 % interval of Student's t with so many degrees of freedom: exact for 1 and 2, else a series
/// (Abramowitz and Stegun 26.7.5).
double student(double freedom) {
    if (freedom < 1.5) return 12.706204736;
    if (freedom < 2.5) return 4.302652730;
    const double z = 1.959963984540054, z3 = z * z * z, z5 = z3 * z * z, z7 = z5 * z * z;
    return z + (z3 + z) / (4 * freedom) + (5 * z5 + 16 * z3 + 3 * z) / (96 * freedom * freedom) +
           (3 * z7 + 19 * z5 + 17 * z3 - 15 * z) / (384 * freedom * freedom * freedom);
}

class Fit {
public:
    Fit(const Communicator& comm, const Threads& threads, const Machine& machine, SceneText text, const CsvTable& data,
        FitOptions options)
        : comm_(comm), threads_(threads), machine_(machine), text_(std::move(text)), options_(std::move(options)) {
        const SceneSpec scene = parse_scene(text_.file, text_.text, text_.overrides);
        refuse_unsolvable(scene);
        experiments_ = experiments_of(data, scene);
        const std::vector<SceneNumber> numbers = numbers_at(scene, options_.keys);
        for (std::size_t i = 0; i < numbers.size(); ++i) {
            const SceneNumber& number = numbers[i];
            const std::string& key = options_.keys[i];
            refuse_whole(number, key);
            if (std::count(options_.keys.begin(), options_.keys.end(), key) > 1)
                throw InputError(fmt::format("--number {} is given twice", key));
            for (const std::string& heading : data.names)
                if (heading_of(heading).name == key)
                    throw InputError(fmt::format("'{}' is a column of the data, and cannot be found from them", key));
            value_.push_back(number.value);
            unit_.push_back(number.unit);
            scale_.push_back(value_.back() != 0 ? std::abs(value_.back()) : 1);
        }
        for (Experiment& one : experiments_) {
            std::vector<std::string> overrides = text_.overrides;
            overrides.insert(overrides.end(), one.overrides.begin(), one.overrides.end());
            one.scene = parse_scene(text_.file, text_.text, overrides);
            refuse_unsolvable(one.scene);
            size_ += one.size();
        }
        if (size_ <= value_.size() && !options_.keep_undetermined)
            throw InputError(
                fmt::format("{} measured values are too few for {} numbers and their intervals", size_, value_.size()));
        find_kinds();
    }

    FitReport run() {
        constexpr int most_weightings = 20;
        FitReport report;
        Unknown residual;
        for (int i = 0; i < most_weightings; ++i) {
            residual = minimise(report.iterations);
            if (i + 1 == most_weightings || !weigh(residual)) break;
        }
        const auto freedom = static_cast<double>(size_) - static_cast<double>(rank_);
        const double factor = freedom > 0 ? student(freedom) * std::sqrt(residual.squaredNorm() / freedom) : HUGE_VAL;
        for (std::size_t i = 0; i < value_.size(); ++i)
            report.numbers.push_back({options_.keys[i], unit_[i], value_[i], factor * scale_[i] * deviation(i)});
        report.values = size_;
        report.experiments = experiments_.size();
        for (std::size_t k = 0; k < kinds_.size(); ++k)
            report.misfits.push_back({kinds_[k], kind_units_[k], sigma_[k] * root_mean_square(residual, k)});
        return report;
    }

private:
    /// Kinds of values, each with an error of its own, and what that is at first: its range.
    void find_kinds() {
        std::vector<double> low, high;
        for (const Experiment& one : experiments_) {
            const Unknown values = measured_values(one);
            for (std::size_t row = 0; row < one.size(); ++row) {
                const bool place = row < one.of_places();
                const std::string name = place ? places : one.values[row - one.of_places()].heading.name;
                const auto kind =
                    static_cast<std::size_t>(std::find(kinds_.begin(), kinds_.end(), name) - kinds_.begin());
                const double value = values[static_cast<Eigen::Index>(row)];
                if (kind == kinds_.size()) {
                    kinds_.push_back(name);
                    kind_units_.emplace_back(place ? "m" : "");
                    low.push_back(value);
                    high.push_back(value);
                }
                low[kind] = std::min(low[kind], value);
                high[kind] = std::max(high[kind], value);
                kind_of_.push_back(kind);
            }
        }
        for (std::size_t k = 0; k < kinds_.size(); ++k) {
            const double size = std::max(std::abs(low[k]), std::abs(high[k]));
            size_of_kind_.push_back(high[k] > low[k] ? high[k] - low[k] : size > 0 ? size : 1);
        }
        sigma_ = size_of_kind_;
    }

    double root_mean_square(const Unknown& residual, std::size_t kind) const {
        double sum = 0;
        for (std::size_t row = 0; row < size_; ++row)
            if (kind_of_[row] == kind) sum += std::pow(residual[static_cast<Eigen::Index>(row)], 2);
        return std::sqrt(sum / static_cast<double>(std::ranges::count(kind_of_, kind)));
    }

    /// Errors of kinds from what is left of them; true if weights have changed, so that the fit is made again. A kind
    /// of few values could be met exactly, which says nothing of its error: it has the share of its range that all
    /// have.
    bool weigh(const Unknown& residual) {
        constexpr double exact = 1e-9; // of a kind's range: no data are better
        if (kinds_.size() < 2) return false;
        double of_all = 0;
        for (std::size_t k = 0; k < kinds_.size(); ++k)
            of_all = std::hypot(of_all, sigma_[k] / size_of_kind_[k] * root_mean_square(residual, k));
        of_all /= std::sqrt(static_cast<double>(kinds_.size()));
        bool changed = false;
        for (std::size_t k = 0; k < kinds_.size(); ++k) {
            const bool few = static_cast<std::size_t>(std::ranges::count(kind_of_, k)) < value_.size() + 3;
            const double found = few ? of_all * size_of_kind_[k] : sigma_[k] * root_mean_square(residual, k);
            const double now = std::max(found, exact * size_of_kind_[k]);
            changed = changed || std::abs(now - sigma_[k]) > 1e-3 * sigma_[k];
            next_sigma_.push_back(now);
        }
        if (changed) sigma_ = next_sigma_;
        next_sigma_.clear();
        return changed;
    }

    /// Residuals at the best numbers, with their slopes there.
    Unknown minimise(int& iterations) {
        const auto numbers = static_cast<Eigen::Index>(value_.size());
        Unknown residual = predict(value_, true);
        double damping = 1e-2;
        for (int i = 0; i < options_.most_iterations; ++i) {
            ++iterations;
            const Unknown step = step_for(residual, damping);
            std::vector<double> trial = value_;
            for (Eigen::Index n = 0; n < numbers; ++n) trial[at(n)] += scale_[at(n)] * step[n];
            const double size = step.cwiseAbs().maxCoeff();
            // Nothing against the intervals, which are as wide as the residual is large.
            const bool small = (slopes_ * step).squaredNorm() < 1e-12 * residual.squaredNorm();
            std::optional<Unknown> next = try_to_predict(trial);
            if (next && next->squaredNorm() <= residual.squaredNorm() * (1 + 1e-12)) {
                value_ = std::move(trial);
                damping = damping > 1e-6 ? 0.1 * damping : 0;
                residual = predict(value_, true);
                if (size < options_.tolerance || small) return residual;
            } else {
                if (size < 1e3 * options_.tolerance || small) return residual; // as exact as slopes are
                damping = std::max(10 * damping, 1e-3);
                if (damping > 1e12) throw NumericalError("the fit finds no better numbers, and no minimum");
            }
        }
        throw NumericalError(fmt::format("the fit has not settled in {} iterations; begin with other numbers",
                                         options_.most_iterations));
    }

    static std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

    std::unique_ptr<StaticCase> case_of(const Experiment& experiment, std::span<const double> value) const {
        SceneSpec own = experiment.scene;
        for (std::size_t i = 0; i < value.size(); ++i) own = with_number(std::move(own), options_.keys[i], value[i]);
        check_scene(own);
        return static_case(std::move(own), machine_, options_.time);
    }

    /// The rod that a shape is of.
    std::size_t rod_of_shape(const StaticCase& one) const {
        std::size_t rod = 0;
        if (!options_.rods.empty())
            while (rod < one.rods.size() && nth(one.groups, one.rods[rod].group).name() != options_.rods) ++rod;
        if (rod == one.rods.size()) throw InputError(fmt::format("there are no rods '{}'", options_.rods));
        if (nth(one.groups, one.rods[rod].group).elements() < 1)
            throw InputError("a shape is of a rod: --rods names its group");
        return rod;
    }

    /// Values of an experiment, places first.
    RestQuantity quantity_of(const Experiment& experiment, ObservedCase& observed) {
        RestQuantity quantity;
        if (!experiment.places.empty())
            quantity.places = [&](const StaticCase& one, const StaticState& state) {
                const std::size_t rod = rod_of_shape(one);
                const RodGroup& group = nth(one.groups, one.rods[rod].group);
                return values_of_places(experiment, group, state.slot.data() + one.system->first_slot(rod));
            };
        for (const MeasuredValue& value : experiment.values)
            quantity.observables.push_back(column_of(value.heading, observed.names()));
        return quantity;
    }

    std::size_t column_of(const Heading& heading, const std::vector<std::string>& names) {
        std::vector<std::string> plain;
        for (const std::string& name : names) plain.push_back(heading_of(name).name);
        const auto found = std::find(plain.begin(), plain.end(), heading.name);
        if (found == plain.end())
            throw InputError(fmt::format(
                "'{}' is no observable of the scene, nor a key of it, which has a dot{}", heading.name,
                suggestion(heading.name, std::vector<std::string_view>(plain.begin(), plain.end()), "there are")));
        const auto column = static_cast<std::size_t>(found - plain.begin());
        const std::string unit = heading_of(names[column]).unit;
        refuse_other_unit(heading, unit);
        kind_units_[static_cast<std::size_t>(std::find(kinds_.begin(), kinds_.end(), heading.name) - kinds_.begin())] =
            unit;
        return column;
    }

    /// Refuses values of observables that are not numbers at rest.
    static void refuse_unknown(const Unknown& residual, const Experiment& experiment) {
        const auto first = static_cast<Eigen::Index>(experiment.of_places());
        for (Eigen::Index row = first; row < residual.size(); ++row)
            if (std::isnan(residual[row]))
                throw InputError(fmt::format("'{}' sums what the steps of a run do, so that it has no value at rest: "
                                             "leave its column out of the data",
                                             experiment.values[at(row - first)].heading.name));
    }

    StaticState equilibrium(Experiment& experiment, StaticCase& one) const {
        if (experiment.state && !one.system->has_history()) {
            StaticState state = *experiment.state;
            one.system->lead_ends(state);
            NewtonSolver newton(*one.system, {});
            if (newton.solve(state, Unknown::Zero(one.system->unknowns())).converged) {
                one.system->refresh(state);
                one.system->keep_joints(state);
                return state;
            }
        }
        return equilibrium_of(one, options_.time, options_.begun);
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
            ObservedCase observed(comm_, threads_, *one, options_.time);
            observed.take_friction(one->system->friction_memory(state));
            const RestQuantity quantity = quantity_of(experiment, observed);
            all.segment(row, count) = quantity.at(observed, state) - target_of(experiment);
            refuse_unknown(all.segment(row, count), experiment);
            if (with_slopes) slopes_.middleRows(row, count) = slopes_of(quantity, observed, state, value);
            experiment.state = std::move(state);
            row += count;
        }
        for (row = 0; row < all.size(); ++row) {
            const double weight = 1 / sigma_[kind_of_[at(row)]];
            all[row] *= weight;
            if (with_slopes) slopes_.row(row) *= weight;
        }
        if (with_slopes) decompose();
        return all;
    }
    std::optional<Unknown> try_to_predict(const std::vector<double>& value) {
        try {
            return predict(value, false);
        } catch (const Error&) { // such numbers are none
            return {};
        }
    }

    /// Slopes by numbers over their scales.
    Eigen::MatrixXd slopes_of(const RestQuantity& quantity, ObservedCase& observed, const StaticState& state,
                              const std::vector<double>& value) {
        constexpr double share = 1e-6;
        const StaticCase& one = observed.at();
        StaticSystem::Balance balance = one.system->balance(state, true);
        const Stiffness coupled = *balance.stiffness;
        const StaticSolution solution(*one.system, state, balance);
        if (!solution.regular()) refuse_singular();
        std::vector<ChangedNumber> numbers;
        for (std::size_t i = 0; i < value.size(); ++i)
            numbers.push_back({options_.keys[i], value[i], share * scale_[i]});
        const std::vector<NumberEffect> effects =
            NumberEffects(comm_, threads_, machine_, options_.time, one, state, coupled)
                .find(numbers, quantity, observed);
        for (std::size_t i = 0; i < value.size(); ++i)
            if (effects[i].jumps) refuse_jump(options_.keys[i], value[i]);
        Eigen::MatrixXd all(effects.front().quantity.size(), static_cast<Eigen::Index>(value.size()));
        for (std::size_t i = 0; i < value.size(); ++i) {
            const Unknown change = solution.solve(effects[i].loads);
            if (one.system->has_history() && slips_along(change, solution, *one.system, state))
                refuse_slip(options_.keys[i]);
            all.col(static_cast<Eigen::Index>(i)) =
                scale_[i] * (effects[i].quantity + slope_along(change, quantity, observed, state));
        }
        return all;
    }

    /// Parts the slopes, with columns of norm 1, into what the data determine and what they do not, which is refused
    /// unless it may stay as it is.
    void decompose() {
        constexpr double least = 1e-6; // of the largest, which slopes are exact to
        norms_ = slopes_.colwise().norm();
        const double largest = norms_.maxCoeff();
        for (Eigen::Index i = 0; i < norms_.size(); ++i) {
            if (norms_[i] > least * largest * 1e-3) continue;
            if (!options_.keep_undetermined || largest == 0)
                throw InputError(fmt::format("the data do not depend on {}: leave it out, or keep what they do not "
                                             "determine as it is with --keep-undetermined",
                                             options_.keys[at(i)]));
            slopes_.col(i).setZero();
            norms_[i] = 1;
        }
        const Eigen::MatrixXd alike = slopes_ * norms_.cwiseInverse().asDiagonal();
        svd_.compute(alike, Eigen::ComputeThinU | Eigen::ComputeThinV);
        const Unknown& size = svd_.singularValues();
        for (rank_ = size.size(); !(size[rank_ - 1] > least * size[0]);) --rank_;
        if (rank_ == size.size() || options_.keep_undetermined) return;
        const Eigen::Index last = size.size() - 1;
        const Unknown shares = svd_.matrixV().col(last).cwiseQuotient(norms_).normalized();
        std::vector<std::string> together;
        for (Eigen::Index i = 0; i <= last; ++i)
            if (std::abs(svd_.matrixV()(i, last)) > 0.1)
                together.push_back(fmt::format("{} ({:+.2g})", options_.keys[at(i)], shares[i]));
        throw InputError(fmt::format("the data do not determine {} apart: relative changes in these proportions change "
                                     "nothing that was measured; hold one of them, or keep what they do not "
                                     "determine as it is with --keep-undetermined",
                                     fmt::join(together, ", ")));
    }

    /// Step over the scales of the numbers, the shortest that the data ask for.
    Unknown step_for(const Unknown& residual, double damping) const {
        Unknown along = svd_.matrixU().leftCols(rank_).transpose() * residual;
        for (Eigen::Index i = 0; i < rank_; ++i) {
            const double size = svd_.singularValues()[i];
            along[i] *= -size / (size * size + damping);
        }
        return (svd_.matrixV().leftCols(rank_) * along).cwiseQuotient(norms_);
    }

    /// Standard deviation of a number over its scale where that of all residuals is 1; infinite if it is kept.
    double deviation(std::size_t number) const {
        const auto i = static_cast<Eigen::Index>(number);
        if (1 - svd_.matrixV().row(i).head(rank_).squaredNorm() > 0.01) return HUGE_VAL;
        const Unknown size = svd_.singularValues().head(rank_);
        return svd_.matrixV().row(i).head(rank_).transpose().cwiseQuotient(size).norm() / norms_[i];
    }

    const Communicator& comm_;
    const Threads& threads_;
    Machine machine_;
    SceneText text_;
    FitOptions options_;
    std::vector<Experiment> experiments_;
    std::vector<double> value_, scale_;
    std::vector<std::string> unit_, kinds_, kind_units_;
    std::vector<std::size_t> kind_of_;                      ///< of each value
    std::vector<double> sigma_, next_sigma_, size_of_kind_; ///< errors of kinds, and their ranges
    std::size_t size_ = 0;
    Eigen::MatrixXd slopes_;
    Unknown norms_;                           ///< of the columns of slopes_
    Eigen::JacobiSVD<Eigen::MatrixXd> svd_{}; ///< of slopes_ with columns of norm 1
    Eigen::Index rank_ = 0;                   ///< directions that the data determine
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
    std::string text = fmt::format("Fit: {} values of {} experiments, {} iterations, {:.3g} s\n", report.values,
                                   report.experiments, report.iterations, report.seconds);
    for (const Misfit& one : report.misfits)
        text += fmt::format("  misfit of {}: {:.3g} {} (rms)\n", one.of, one.size, one.unit);
    for (const FittedNumber& one : report.numbers)
        text +=
            std::isfinite(one.half_width)
                ? fmt::format("  {:<40} {:>14.7g} +- {:.2g} {} (95 %)\n", one.key, one.value, one.half_width, one.unit)
                : fmt::format("  {:<40} {:>14.7g} {}, which the data do not determine\n", one.key, one.value, one.unit);
    return text;
}

std::string to_csv(const FitReport& report) {
    std::string text = "key,value,half_width_95,unit\n";
    for (const FittedNumber& one : report.numbers)
        text += fmt::format("{},{:.17g},{:.6g},{}\n", one.key, one.value, one.half_width, one.unit);
    return text;
}

} // namespace skein
