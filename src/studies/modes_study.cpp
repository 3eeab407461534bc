#include "studies/modes_study.hpp"

#include "core/timer.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace skein {

namespace {

/// Puts neutral modes first, then by eigenvalue.
bool before(const PieceMode& a, const PieceMode& b) {
    if (a.mode.neutral != b.mode.neutral) return a.mode.neutral;
    return a.mode.eigenvalue < b.mode.eigenvalue;
}

/// Name of a piece's first rod, for tables.
std::string plain_name(const StaticScene& scene, const StaticPiece& piece) {
    const LocalRod& rod = piece.system->rods().front();
    const RodGroup& group = nth(scene.world().groups, rod.group);
    return group.count() > 1 ? fmt::format("rod {} of {}", rod.index, group.name()) : group.name();
}

/// Modes of other ranks' own pieces, without shapes. Collective.
void gather(const StaticScene& scene, std::vector<PieceMode>& modes) {
    const Communicator& comm = scene.world().comm;
    std::string own;
    for (const PieceMode& one : modes)
        if (!scene.pieces()[one.piece].shared)
            own += fmt::format("{} {} {} {} {} {}\n", one.mode.eigenvalue, one.mode.residual, one.mode.exponent.real(),
                               one.mode.exponent.imag(), one.mode.neutral, one.name);
    const std::vector<std::string> all = comm.all_gather(own);
    for (int rank = 0; rank < comm.size(); ++rank) {
        if (rank == comm.rank()) continue;
        std::size_t at = 0;
        const std::string& text = nth(all, rank);
        while (at < text.size()) {
            const std::size_t end = text.find('\n', at);
            const std::string line = text.substr(at, end - at);
            std::size_t next = 0;
            const auto number = [&] {
                std::size_t used = 0;
                const double value = std::stod(line.substr(next), &used);
                next += used;
                return value;
            };
            PieceMode one{SIZE_MAX, {}, {}};
            one.mode.eigenvalue = number();
            one.mode.residual = number();
            const double real = number();
            one.mode.exponent = {real, number()};
            one.mode.neutral = line.substr(next + 1, 4) == "true";
            one.name = line.substr(line.find(' ', next + 1) + 1);
            modes.push_back(std::move(one));
            at = end + 1;
        }
    }
}

} // namespace

ModesReport find_modes(StaticScene& scene, int count, bool undamped) {
    const double began = wall_seconds();
    const Communicator& comm = scene.world().comm;
    std::vector<ModesResult> found(scene.pieces().size());
    for_each_piece(scene, [&](std::size_t i) {
        StaticPiece& piece = scene.pieces()[i];
        piece.system->refresh(piece.state);
        found[i] = find_modes(*piece.system, piece.state, count, undamped);
    });

    ModesReport report;
    std::string reason, names, method;
    std::int64_t neutral = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
        const StaticPiece& piece = scene.pieces()[i];
        const std::string name = plain_name(scene, piece);
        for (Mode& mode : found[i].modes) report.modes.push_back({i, name, std::move(mode)});
        if (!scene.counts(piece)) continue;
        if (reason.empty() && !found[i].reason.empty())
            reason = fmt::format("{}: {}", piece.system->rod_name(0), found[i].reason);
        neutral += found[i].neutral.count();
        for (const NeutralMotions::Piece& free : found[i].neutral.pieces)
            for (Eigen::Index m = 0; m < free.motion.cols() && names.size() < 300; ++m)
                names += (names.empty() ? "" : "; ") +
                         piece.system->name_of(free, Unknown::Unit(free.motion.cols(), m), piece.state);
        report.asymmetry = std::max(report.asymmetry, found[i].asymmetry);
        report.damped |= found[i].damped;
        report.gyroscopic |= found[i].gyroscopic;
        report.slowed |= found[i].slowed;
        if (method.empty()) method = found[i].method;
    }
    reason = comm.first_text(reason);
    if (!reason.empty()) throw NumericalError("no modes: " + reason);
    if (comm.size() > 1) gather(scene, report.modes);
    std::stable_sort(report.modes.begin(), report.modes.end(), before);
    report.neutral = comm.sum(neutral);
    report.neutral_names = comm.first_text(names);
    report.method = comm.first_text(method);
    report.asymmetry = comm.max(report.asymmetry);
    report.damped = comm.max(static_cast<std::int64_t>(report.damped)) > 0;
    report.gyroscopic = comm.max(static_cast<std::int64_t>(report.gyroscopic)) > 0;
    report.slowed = comm.max(static_cast<std::int64_t>(report.slowed)) > 0;
    const auto most = static_cast<std::size_t>(count + report.neutral);
    if (report.modes.size() > most) report.modes.resize(most);
    report.seconds = wall_seconds() - began;
    return report;
}

namespace {

std::string swinging_table(const ModesReport& report) {
    std::string text = "  mode   frequency Hz    eigenvalue 1/s^2   residual   of\n";
    int number = 0;
    for (const PieceMode& one : report.modes) {
        if (one.mode.neutral) continue;
        text += fmt::format("  {:>4}   {:>12.6g}{}   {:>16.9g}   {:>8.1e}   {}\n", ++number, one.mode.frequency(),
                            one.mode.eigenvalue < 0 ? "i" : " ", one.mode.eigenvalue, one.mode.residual, one.name);
    }
    return text;
}

std::string damped_table(const ModesReport& report) {
    std::string text = "  mode   frequency Hz      decay 1/s   damping ratio   residual   of\n";
    int number = 0;
    for (const PieceMode& one : report.modes) {
        if (one.mode.neutral) continue;
        const bool swings = one.mode.exponent.imag() != 0;
        text +=
            fmt::format("  {:>4}   {:>12.6g}   {:>12.6g}   {:>13.6g}   {:>8.1e}   {}{}\n", ++number,
                        one.mode.frequency(), one.mode.decay(), one.mode.damping_ratio(), one.mode.residual, one.name,
                        one.mode.grows() ? ", grows"
                        : swings         ? ""
                                         : ", overdamped");
    }
    return text;
}

} // namespace

std::string to_text(const ModesReport& report) {
    std::string text = fmt::format("Modes: {}, {:.3g} s\n", report.method, report.seconds);
    if (report.asymmetry > 0)
        text += fmt::format("Contacts stick: by the symmetric part of the stiffness, to which friction adds {:.1g}\n",
                            report.asymmetry);
    if (report.neutral > 0)
        text += fmt::format("{} neutral motions, which change no load: {}\n", report.neutral, report.neutral_names);
    if (report.gyroscopic) text += "Rods spin about their own axes, with gyroscopic couples\n";
    if (report.slowed) text += "Rods spin about their own axes, but ends or dampers resist: that spin is left out\n";
    return text + (report.damped ? damped_table(report) : swinging_table(report));
}

std::string to_csv(const ModesReport& report) {
    std::string text = "mode,neutral,frequency[Hz],eigenvalue[1/s^2],decay[1/s],damping_ratio[-],residual[-],of\n";
    int number = 0;
    for (const PieceMode& one : report.modes)
        text += fmt::format("{},{},{:.17g},{:.17g},{:.17g},{:.17g},{:.3g},{}\n", one.mode.neutral ? 0 : ++number,
                            one.mode.neutral ? 1 : 0,
                            one.mode.eigenvalue < 0 ? -one.mode.frequency() : one.mode.frequency(), one.mode.eigenvalue,
                            one.mode.decay(), one.mode.damping_ratio(), one.mode.residual, one.name);
    return text;
}

StaticState moved_along(const StaticPiece& piece, const Mode& mode, double phase, double largest) {
    const StaticSystem& system = *piece.system;
    double most = 0;
    for (int u = 0; u < system.unknowns(); ++u) {
        const double size =
            mode.quadrature.size() > 0 ? std::hypot(mode.shape[u], mode.quadrature[u]) : std::abs(mode.shape[u]);
        most = std::max(most, size * (system.map().place(u).i < 3 ? 1 : largest));
    }
    most = std::max(most, 1e-300);
    Unknown moved = (std::sin(phase) * largest / most) * mode.shape;
    if (mode.quadrature.size() > 0) moved += (std::cos(phase) * largest / most) * mode.quadrature;
    StaticState state = piece.state;
    system.correct(state, moved, 1);
    return state;
}

} // namespace skein
