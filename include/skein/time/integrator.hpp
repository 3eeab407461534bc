// Splitting schemes: drifts and kicks within a step. Shares are of dt. theory.md (20)-(21), (45)
//   verlet   position Verlet, second order, one force evaluation
//   pefrl    Omelyan, Mryglod and Folk 2002, Comput. Phys. Commun. 146, 188, eq. (27): fourth order, four force
//            evaluations
//   implicit, implicit_damped
//            second order at steps that stability does not limit: a step that keeps energy and momenta
//            (implicit/conserving_pass.hpp), and a diagonally implicit Runge-Kutta step, which damps what it does not
//            resolve (implicit/implicit_pass.hpp). A kick is a stage of this length, the drift goes on after it, and
//            the state does not lag.
//   implicit_bed
//            first order, for rods in contact: the drift predicts the end of the step, and the kick is one linear
//            solution there (implicit/bed_pass.hpp)
// The last drift of a step and the first of the next are one, so that the state between steps lags: positions are at
// t_N - lag dt.
#pragma once

#include <span>
#include <string_view>

namespace skein {

enum class Integrator { verlet, pefrl, implicit, implicit_damped, implicit_bed };
inline constexpr std::string_view integrator_names[] = {"verlet", "pefrl", "implicit", "implicit_damped",
                                                        "implicit_bed"};
/// True where some kicks go backwards in time.
constexpr bool kicks_backwards(Integrator i) { return i == Integrator::pefrl; }
/// True for steps that stability does not limit.
constexpr bool is_implicit(Integrator i) {
    return i == Integrator::implicit || i == Integrator::implicit_damped || i == Integrator::implicit_bed;
}

/// Combination of damping and kick: an implicit midpoint, which leaves slow motion its inertia; the exact flow of both;
/// or a factor after the kick (published codes; first order).
enum class DampingScheme { midpoint, exponential, after };
inline constexpr std::string_view damping_scheme_names[] = {"midpoint", "exponential", "after"};

/// Drift, then kick.
struct Substep {
    double drift; ///< share; the first stage includes the closing drift of the step before
    double kick;
    double time;     ///< time of the kick, from the beginning of the step
    int kick_length; ///< number among the scheme's distinct kick lengths
};

struct Scheme {
    std::span<const Substep> stages;
    std::span<const double> kicks; ///< distinct kick lengths
    double lag;                    ///< closing drift
    double stability;              ///< largest stable h w of an oscillator, over Verlet's 2
    double drag;                   ///< largest stable h nu of a drag at the velocity before each kick
    double ahead = 0;              ///< share of the step by which bodies show themselves to each other, once in it
    double touching = 1;           ///< longest such step, over Verlet's limit by contacts
    double delay = 0;              ///< share of the step by which loads of contacts are later at that length
};

namespace detail {

inline constexpr Substep verlet_stages[] = {{1.0, 1.0, 0.5, 0}};
inline constexpr double verlet_kicks[] = {1.0};

inline constexpr double xi = 0.1786178958448091, lambda = -0.2123418310626054, chi = -0.06626458266981849;
inline constexpr Substep pefrl_stages[] = {{2 * xi, 0.5 - lambda, xi, 0},
                                           {chi, lambda, xi + chi, 1},
                                           {1 - 2 * (xi + chi), lambda, 1 - (xi + chi), 1},
                                           {chi, 0.5 - lambda, 1 - xi, 0}};
inline constexpr double pefrl_kicks[] = {0.5 - lambda, lambda};

inline constexpr Substep symmetric_stages[] = {{0.5, 0.5, 0.5, 0}};
inline constexpr double symmetric_kicks[] = {0.5};

inline constexpr double gamma = 0.2928932188134525; // 1 - 1/sqrt 2
/// Time of a stage at the end of a step, over its length: loads that begin there do not act in it.
inline constexpr double before_end = 1 - 1e-9;
inline constexpr Substep damped_stages[] = {{1 - 2 * gamma, gamma, gamma, 0}, {0.0, gamma, before_end, 0}};
inline constexpr double damped_kicks[] = {gamma};

inline constexpr Substep bed_stages[] = {{1.0, 1.0, before_end, 0}};

} // namespace detail

constexpr Scheme scheme_of(Integrator integrator) {
    if (integrator == Integrator::pefrl)
        return {detail::pefrl_stages, detail::pefrl_kicks, detail::xi, 1.4947247, 2.3414};
    if (integrator == Integrator::implicit)
        return {detail::symmetric_stages, detail::symmetric_kicks, 0, 1.0, 2.0, 0.5, 0.9};
    if (integrator == Integrator::implicit_damped)
        return {detail::damped_stages, detail::damped_kicks, 0, 1.0, 2.0, 0.5, 0.45, 0.05};
    if (integrator == Integrator::implicit_bed) return {detail::bed_stages, detail::verlet_kicks, 0, 1.0, 2.0};
    return {detail::verlet_stages, detail::verlet_kicks, 0.5, 1.0, 2.0};
}

} // namespace skein
