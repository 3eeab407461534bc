// Library libskein_factor.so: PETSc's interface to MUMPS, L D L^T with pivots of symmetric matrices, L U of others.
// Ranks that share a matrix all have the whole of it; each gives MUMPS a block of its rows, and all get the whole
// solution.
#include "equilibrium/factor.hpp"

#include "core/hash.hpp"
#include "parallel/petsc_start.hpp"

#include <petscmat.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <mutex>
#include <numeric>
#include <span>
#include <vector>

namespace skein {

namespace {

/// PETSc and MUMPS serve one thread at a time.
std::mutex& turn() {
    static std::mutex one;
    return one;
}

PetscErrorCode keep_quiet(MPI_Comm, int, const char*, const char*, PetscErrorCode code, PetscErrorType, const char*,
                          void*) {
    return code;
}

/// Starts PETSc, which ends with the process, and keeps its complaints off the terminal during a call.
class Quiet {
public:
    PetscErrorCode begin() {
        bool began = false;
        PetscFunctionBegin;
        PetscCall(start_petsc(began));
        PetscCall(PetscPushErrorHandler(keep_quiet, nullptr));
        pushed_ = true;
        PetscFunctionReturn(0);
    }
    ~Quiet() {
        if (pushed_) PetscPopErrorHandler();
    }

private:
    bool pushed_ = false;
};

class PetscFactor final : public Factor {
public:
    PetscFactor(bool symmetric, const Communicator* ranks)
        : symmetric_(symmetric), comm_(ranks ? MPI_Comm_f2c(ranks->handle()) : MPI_COMM_SELF),
          ranks_(ranks ? ranks->size() : 1) {}
    ~PetscFactor() override {
        const std::lock_guard<std::mutex> own(turn());
        MatDestroy(&factor_);
    }
    std::string_view name() const override {
        return symmetric_ ? "L D L^T with pivots (MUMPS)" : "L U with pivots (MUMPS)";
    }

    bool suits(const Stiffness&, bool symmetric) const override { return symmetric == symmetric_; }

    bool factorise(const Stiffness& matrix) override {
        const std::lock_guard<std::mutex> own(turn());
        scale_ = scales_of(matrix);
        return on_all(make(matrix) == 0);
    }
    Unknown solve(const Unknown& right) const override {
        const std::lock_guard<std::mutex> own(turn());
        Unknown in = scale_.cwiseProduct(right), out(right.size());
        if (!on_all(apply(in.data() + begin_, out.data() + begin_) == 0))
            out.setConstant(std::numeric_limits<double>::quiet_NaN());
        else if (ranks_ > 1) gather(out);
        return scale_.cwiseProduct(out);
    }
    long negative() const override { return symmetric_ ? negative_ : -1; }
    double entries() const override { return entries_; }

private:
    bool on_all(bool well) const {
        int all = well;
        if (ranks_ > 1) MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_INT, MPI_MIN, comm_);
        return all != 0;
    }
    /// Completes a solution, of which this rank has its block.
    void gather(Unknown& solution) const {
        std::vector<int> counts(static_cast<std::size_t>(ranks_)), begins(counts.size());
        MPI_Allgather(&rows_, 1, MPI_INT, counts.data(), 1, MPI_INT, comm_);
        std::exclusive_scan(counts.begin(), counts.end(), begins.begin(), 0);
        MPI_Allgatherv(MPI_IN_PLACE, 0, MPI_DOUBLE, solution.data(), counts.data(), begins.data(), MPI_DOUBLE, comm_);
    }

    static std::uint64_t pattern_of(std::span<const PetscInt> rows, std::span<const PetscInt> columns) {
        std::uint64_t hash = hash_begin(rows.size());
        for (const PetscInt at : rows) hash = hash_with(hash, static_cast<double>(at));
        for (const PetscInt at : columns) hash = hash_with(hash, static_cast<double>(at));
        return hash_end(hash);
    }

    /// Rows of PETSc are columns of the matrix: of a symmetric one the same, of others the transposed is factorised.
    PetscErrorCode make(const Stiffness& matrix) {
        const auto size = static_cast<PetscInt>(matrix.rows());
        int rank = 0;
        MPI_Comm_rank(comm_, &rank);
        begin_ = size / ranks_ * rank + std::min<PetscInt>(rank, size % ranks_);
        rows_ = size / ranks_ + (rank < size % ranks_);
        const int *first = matrix.outerIndexPtr() + begin_, *at = matrix.innerIndexPtr();
        std::vector<PetscInt> rows, columns(at + first[0], at + first[rows_]);
        std::vector<PetscScalar> values;
        values.reserve(columns.size());
        for (int j = 0; j < rows_; ++j) {
            rows.push_back(first[j] - first[0]);
            for (int e = first[j]; e < first[j + 1]; ++e)
                values.push_back(matrix.valuePtr()[e] * scale_[begin_ + j] * scale_[at[e]]);
        }
        rows.push_back(first[rows_] - first[0]);
        Mat whole = nullptr;
        Quiet quiet;
        PetscFunctionBegin;
        PetscCall(quiet.begin());
        if (ranks_ > 1)
            PetscCall(MatCreateMPIAIJWithArrays(comm_, rows_, rows_, size, size, rows.data(), columns.data(),
                                                values.data(), &whole));
        else
            PetscCall(MatCreateSeqAIJWithArrays(comm_, size, size, rows.data(), columns.data(), values.data(), &whole));
        const PetscErrorCode code = factorise_whole(whole, pattern_of(rows, columns));
        MatDestroy(&whole);
        PetscFunctionReturn(code);
    }

    PetscErrorCode factorise_whole(Mat whole, std::uint64_t pattern) {
        PetscFunctionBegin;
        if (symmetric_) {
            PetscCall(MatSetOption(whole, MAT_SYMMETRIC, PETSC_TRUE));
            PetscCall(MatSetOption(whole, MAT_SPD, PETSC_FALSE));
        }
        const bool known = on_all(factor_ && pattern == analysed_);
        PetscErrorCode code = known ? factorise_known(whole) : PETSC_ERR_MAT_LU_ZRPVT;
        if (!known || !on_all(code == 0)) { // pivots may ask for more memory than those of the first values
            analysed_ = pattern;
            code = analyse(whole);
            if (on_all(code == 0)) code = factorise_known(whole);
        }
        PetscFunctionReturn(code);
    }

    PetscErrorCode analyse(Mat whole) {
        PetscFunctionBegin;
        MatFactorInfo info;
        PetscCall(MatFactorInfoInitialize(&info));
        MatDestroy(&factor_);
        const MatFactorType kind = symmetric_ ? MAT_FACTOR_CHOLESKY : MAT_FACTOR_LU;
        PetscCall(MatGetFactor(whole, MATSOLVERMUMPS, kind, &factor_));
        PetscCall(MatMumpsSetIcntl(factor_, 13, 1));  // leaves the last front to one process, or signs are not counted
        PetscCall(MatMumpsSetIcntl(factor_, 14, 60)); // more memory for pivots, %
        PetscCall(MatMumpsSetIcntl(factor_, 24, 1));  // finds rows of zeros
        if (symmetric_) PetscCall(MatCholeskyFactorSymbolic(factor_, whole, nullptr, &info));
        else PetscCall(MatLUFactorSymbolic(factor_, whole, nullptr, nullptr, &info));
        PetscFunctionReturn(0);
    }

    /// Factor of a matrix whose pattern is that of the last analysis.
    PetscErrorCode factorise_known(Mat whole) {
        PetscFunctionBegin;
        MatFactorInfo info;
        PetscCall(MatFactorInfoInitialize(&info));
        if (symmetric_) PetscCall(MatCholeskyFactorNumeric(factor_, whole, &info));
        else PetscCall(MatLUFactorNumeric(factor_, whole, &info));
        MatFactorError fault = MAT_FACTOR_NOERROR;
        PetscCall(MatFactorGetError(factor_, &fault));
        if (fault != MAT_FACTOR_NOERROR) PetscFunctionReturn(PETSC_ERR_MAT_LU_ZRPVT);
        PetscInt negative = 0, zeros = 0, positive = 0;
        if (symmetric_) PetscCall(MatGetInertia(factor_, &negative, &zeros, &positive));
        negative_ = negative;
        PetscInt entries = 0; // of the factor; below 0: in millions
        PetscCall(MatMumpsGetInfog(factor_, 29, &entries));
        entries_ = entries < 0 ? -1e6 * entries : entries;
        PetscFunctionReturn(zeros > 0 ? PETSC_ERR_MAT_LU_ZRPVT : 0);
    }

    /// `in`, `out`: blocks of this rank.
    PetscErrorCode apply(double* in, double* out) const {
        const auto size = static_cast<PetscInt>(scale_.size());
        Vec from = nullptr, to = nullptr;
        Quiet quiet;
        PetscFunctionBegin;
        PetscCall(quiet.begin());
        PetscCall(VecCreateMPIWithArray(comm_, 1, rows_, size, in, &from));
        PetscCall(VecCreateMPIWithArray(comm_, 1, rows_, size, out, &to));
        if (symmetric_) PetscCall(MatSolve(factor_, from, to));
        else PetscCall(MatSolveTranspose(factor_, from, to));
        VecDestroy(&from);
        VecDestroy(&to);
        PetscFunctionReturn(0);
    }

    bool symmetric_;
    MPI_Comm comm_;
    int ranks_;
    PetscInt begin_ = 0, rows_ = 0; ///< block of this rank
    Mat factor_ = nullptr;
    std::uint64_t analysed_ = 0; ///< pattern of this rank's block that the factor knows
    Unknown scale_;
    long negative_ = 0;
    double entries_ = 0;
};

} // namespace

extern "C" [[gnu::visibility("default")]] Factor* skein_factor_4(bool symmetric, const Communicator* ranks) {
    return new PetscFactor(symmetric, ranks);
}

} // namespace skein
