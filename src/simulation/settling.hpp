// How far rods that relax are from rest, as all ranks know it; theory.md section 21.
#pragma once

#include "io/checkpoint.hpp"
#include "parallel/communicator.hpp"
#include "relaxation/relaxation_estimate.hpp"

#include <cmath>
#include <cstdint>
#include <memory>
#include <string>

namespace skein {

class Settling {
public:
    /// Name among the kept numbers of a checkpoint.
    static constexpr const char* saved_name = "relaxation";

    explicit Settling(double tolerance) : tolerance_(tolerance) {}

    /// Rods have been made anew.
    void watch(std::shared_ptr<const RelaxationResidual> residual) { residual_ = std::move(residual); }
    /// Collective, at steps that are alike on any ranks.
    void measure(const Communicator& comm) { correction_ = comm.max(residual_->largest()); }
    bool settled() const { return correction_ <= tolerance_; }
    double correction() const {
        return correction_;
    } ///< of all rods the largest at the last look, over the length and in rad
    double tolerance() const { return tolerance_; }

    SavedNumbers saved() const { return {.name = saved_name, .numbers = {correction_}}; }
    void restore(const SavedNumbers& kept) { correction_ = kept.numbers.front(); }

    /// Says at the end of a run whether they have settled, in the `allowed` steps or before; `quiet`: where they have
    /// not.
    void tell(std::int64_t steps, std::int64_t allowed, bool quiet) const;

private:
    double tolerance_, correction_ = HUGE_VAL;
    std::shared_ptr<const RelaxationResidual> residual_;
};

} // namespace skein
