// Progress of a solution: its plan, once a correction shows what one costs, and lines now and then while it goes on.
#pragma once

#include "equilibrium/newton.hpp"

#include <cstdint>
#include <mutex>
#include <string>

namespace skein {

/// Cost of a solution before it is made.
struct SolutionPlan {
    std::int64_t pieces = 0, unknowns = 0; ///< of all ranks
    std::string factor;
    double factor_bytes = 0; ///< of the largest piece
    double seconds = 0;      ///< a correction of it
};
std::string to_text(const SolutionPlan& plan);

/// Bytes of a factor that keeps so many numbers: values and, of sparse ones, rows.
double factor_bytes(std::string_view factor, double entries);

/// Lines on standard output, which it ends. Calls may come from any thread.
class SolutionWatch {
public:
    SolutionWatch(bool shown, std::int64_t pieces, std::int64_t unknowns);
    ~SolutionWatch();
    SolutionWatch(const SolutionWatch&) = delete;
    SolutionWatch& operator=(const SolutionWatch&) = delete;

    /// After a correction of a piece.
    void see(const NewtonProgress& now);
    /// Cost of a correction of the piece with the largest factor.
    const SolutionPlan& plan() const { return plan_; }

private:
    void show(const NewtonProgress& now);

    bool shown_, rewrites_;
    SolutionPlan plan_;
    std::mutex one_;
    std::int64_t corrections_ = 0;
    double began_, last_;
    bool open_ = false, told_plan_ = false;
};

} // namespace skein
