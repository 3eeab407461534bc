// Library libskein_factor.so: PETSc's interface to MUMPS, L D L^T with pivots of symmetric matrices, L U of others.
#include "equilibrium/factor.hpp"

#include "parallel/petsc_start.hpp"

#include <petscmat.h>

#include <limits>
#include <mutex>
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
    explicit PetscFactor(bool symmetric) : symmetric_(symmetric) {}
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
        return make(matrix) == 0;
    }
    Unknown solve(const Unknown& right) const override {
        const std::lock_guard<std::mutex> own(turn());
        Unknown in = scale_.cwiseProduct(right), out(right.size());
        if (apply(in.data(), out.data()) != 0) out.setConstant(std::numeric_limits<double>::quiet_NaN());
        return scale_.cwiseProduct(out);
    }
    long negative() const override { return symmetric_ ? negative_ : -1; }

private:
    /// Rows of PETSc are columns of the matrix: of a symmetric one the same, of others the transposed is factorised.
    PetscErrorCode make(const Stiffness& matrix) {
        const auto size = static_cast<PetscInt>(matrix.rows());
        const int *first = matrix.outerIndexPtr(), *at = matrix.innerIndexPtr();
        std::vector<PetscInt> rows(first, first + size + 1), columns(at, at + matrix.nonZeros());
        std::vector<PetscScalar> values(static_cast<std::size_t>(matrix.nonZeros()));
        for (int j = 0; j < size; ++j)
            for (int e = first[j]; e < first[j + 1]; ++e)
                values[static_cast<std::size_t>(e)] = matrix.valuePtr()[e] * scale_[j] * scale_[at[e]];
        Mat whole = nullptr;
        Quiet quiet;
        PetscFunctionBegin;
        PetscCall(quiet.begin());
        PetscCall(
            MatCreateSeqAIJWithArrays(PETSC_COMM_SELF, size, size, rows.data(), columns.data(), values.data(), &whole));
        const PetscErrorCode code = factorise_whole(whole);
        MatDestroy(&whole);
        PetscFunctionReturn(code);
    }

    PetscErrorCode factorise_whole(Mat whole) {
        PetscFunctionBegin;
        if (symmetric_) {
            PetscCall(MatSetOption(whole, MAT_SYMMETRIC, PETSC_TRUE));
            PetscCall(MatSetOption(whole, MAT_SPD, PETSC_FALSE));
        }
        MatFactorInfo info;
        PetscCall(MatFactorInfoInitialize(&info));
        MatDestroy(&factor_);
        const MatFactorType kind = symmetric_ ? MAT_FACTOR_CHOLESKY : MAT_FACTOR_LU;
        PetscCall(MatGetFactor(whole, MATSOLVERMUMPS, kind, &factor_));
        PetscCall(MatMumpsSetIcntl(factor_, 13, 1));  // counts signs on one process
        PetscCall(MatMumpsSetIcntl(factor_, 14, 60)); // more memory for pivots, %
        PetscCall(MatMumpsSetIcntl(factor_, 24, 1));  // finds rows of zeros
        if (symmetric_) {
            PetscCall(MatCholeskyFactorSymbolic(factor_, whole, nullptr, &info));
            PetscCall(MatCholeskyFactorNumeric(factor_, whole, &info));
        } else {
            PetscCall(MatLUFactorSymbolic(factor_, whole, nullptr, nullptr, &info));
            PetscCall(MatLUFactorNumeric(factor_, whole, &info));
        }
        MatFactorError fault = MAT_FACTOR_NOERROR;
        PetscCall(MatFactorGetError(factor_, &fault));
        if (fault != MAT_FACTOR_NOERROR) PetscFunctionReturn(PETSC_ERR_MAT_LU_ZRPVT);
        PetscInt negative = 0, zeros = 0, positive = 0;
        if (symmetric_) PetscCall(MatGetInertia(factor_, &negative, &zeros, &positive));
        negative_ = negative;
        PetscFunctionReturn(zeros > 0 ? PETSC_ERR_MAT_LU_ZRPVT : 0);
    }

    PetscErrorCode apply(double* in, double* out) const {
        const auto size = static_cast<PetscInt>(scale_.size());
        Vec from = nullptr, to = nullptr;
        Quiet quiet;
        PetscFunctionBegin;
        PetscCall(quiet.begin());
        PetscCall(VecCreateSeqWithArray(PETSC_COMM_SELF, 1, size, in, &from));
        PetscCall(VecCreateSeqWithArray(PETSC_COMM_SELF, 1, size, out, &to));
        if (symmetric_) PetscCall(MatSolve(factor_, from, to));
        else PetscCall(MatSolveTranspose(factor_, from, to));
        VecDestroy(&from);
        VecDestroy(&to);
        PetscFunctionReturn(0);
    }

    bool symmetric_;
    Mat factor_ = nullptr;
    Unknown scale_;
    long negative_ = 0;
};

} // namespace

extern "C" [[gnu::visibility("default")]] Factor* skein_factor_2(bool symmetric) { return new PetscFactor(symmetric); }

} // namespace skein
