// Library libskein_multigrid.so: PETSc's conjugate gradients and multigrid for Poisson's equation on grids of boxes.
//
// Integrals over cells make the equation symmetric for any edges. The flow between neighbours is the difference of
// their values times the area of their face over the distance of their centres, theory.md (83). Each coarser level
// joins pairs of cells, and the last three of an odd number, along the directions with the thinnest cells. Its equation
// is that of its own cells, and values pass between levels by linear interpolation and its transpose. So any number of
// cells on any number of ranks has levels down to a few cells. Rows of matrices are cells, plane by plane in the order
// of ranks, as in a DMDA with the processes (1, 1, ranks). A DMDA itself halves only even numbers and needs a plane of
// each level on every rank.
#include "fluid/fluid_grid.hpp"
#include "fluid/pressure_solver.hpp"
#include "parallel/petsc_start.hpp"
#include "skein/core/index.hpp"

#include <petscksp.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>

namespace skein {

namespace {

constexpr int fewest_cells = 64;     ///< a level of no more cells is solved directly
constexpr double alike = 1.5;        ///< directions with thinnest cells within this factor coarsen together
constexpr int most_iterations = 200; ///< ten are usual

/// Cells along a direction.
struct Line {
    std::vector<double> width; ///< m
    bool periodic = false;

    int size() const { return static_cast<int>(width.size()); }
    double thinnest() const { return *std::min_element(width.begin(), width.end()); }
    std::vector<double> centres() const {
        std::vector<double> all;
        double face = 0;
        for (const double w : width) {
            all.push_back(face + 0.5 * w);
            face += w;
        }
        return all;
    }
    /// Inverse distance of the centres of cell i and the next, which is the first after the last of a period; 0: none.
    double closeness(int i) const {
        const int next = i + 1 < size() ? i + 1 : 0;
        if (next == i || (next == 0 && !periodic)) return 0;
        return 2 / (nth(width, i) + nth(width, next));
    }
    double closeness_before(int i) const { return closeness(i > 0 ? i - 1 : size() - 1); }

    Line coarser() const {
        Line line{.width = std::vector<double>(width.size() / 2, 0.0), .periodic = periodic};
        for (std::size_t i = 0; i < width.size(); ++i) line.width[std::min(i / 2, line.width.size() - 1)] += width[i];
        return line;
    }
};

/// Weights of the values of two coarser cells for a cell.
struct Weights {
    std::array<int, 2> cell{};
    std::array<double, 2> weight{1, 0};
};

/// Linear interpolation between centres, constant beyond the outermost centres of a line with ends.
std::vector<Weights> interpolation(const Line& fine, const Line& coarse) {
    std::vector<Weights> all;
    const std::vector<double> from = coarse.centres(), to = fine.centres();
    const double length = std::accumulate(fine.width.begin(), fine.width.end(), 0.0);
    for (int i = 0; i < fine.size(); ++i) {
        if (fine.size() == coarse.size()) {
            all.push_back({{i, i}, {1, 0}});
            continue;
        }
        const int own = std::min(i / 2, coarse.size() - 1);
        const double ahead = nth(to, i) - nth(from, own);
        int other = ahead < 0 ? own - 1 : own + 1;
        double lap = 0;
        if (coarse.periodic && other < 0) {
            other = coarse.size() - 1;
            lap = -length;
        }
        if (coarse.periodic && other == coarse.size()) {
            other = 0;
            lap = length;
        }
        if (other < 0 || other >= coarse.size() || other == own) {
            all.push_back({{own, own}, {1, 0}});
            continue;
        }
        const double share = ahead / (nth(from, other) + lap - nth(from, own));
        all.push_back({{own, other}, {1 - share, share}});
    }
    return all;
}

struct Level {
    std::array<Line, 3> line;
    std::vector<int> first_plane; ///< by rank, and the end of the last one

    int size(int d) const { return nth(line, d).size(); }
    double width(int d, int i) const { return nth(nth(line, d).width, i); }
    std::int64_t cells() const { return std::int64_t{size(0)} * size(1) * size(2); }
    PetscInt cell(int i, int j, int k) const { return (static_cast<PetscInt>(k) * size(1) + j) * size(0) + i; }
    /// First cell of a rank, whose cells end at first_cell(rank + 1).
    PetscInt first_cell(int rank) const { return cell(0, 0, nth(first_plane, rank)); }
    double volume(int i, int j, int k) const { return width(0, i) * width(1, j) * width(2, k); }

    /// Directions along which the next level is coarser, none on the last level.
    std::array<bool, 3> coarsened() const {
        std::array<bool, 3> is{};
        if (cells() <= fewest_cells) return is;
        double thinnest = HUGE_VAL;
        for (const Line& l : line)
            if (l.size() > 1) thinnest = std::min(thinnest, l.thinnest());
        for (std::size_t d = 0; d < 3; ++d) is[d] = line[d].size() > 1 && line[d].thinnest() <= alike * thinnest;
        return is;
    }
};

std::vector<Level> levels_of(const TensorGrid& grid, int ranks) {
    Level level;
    for (std::size_t d = 0; d < 3; ++d) level.line[d] = {grid.width[d], grid.periodic[d]};
    for (int r = 0; r < ranks; ++r) level.first_plane.push_back(slab_of(level.size(2), r, ranks).first);
    level.first_plane.push_back(level.size(2));
    std::vector<Level> all{level};
    for (auto is = level.coarsened(); is != std::array<bool, 3>{}; is = level.coarsened()) {
        for (std::size_t d = 0; d < 3; ++d)
            if (is[d]) level.line[d] = level.line[d].coarser();
        if (is[2]) // a coarser plane belongs to the rank of its first plane
            for (int& first : level.first_plane) first = std::min((first + 1) / 2, level.size(2));
        all.push_back(level);
    }
    return all;
}

/// Entries of a row of a matrix.
struct Entries {
    int count = 0;
    PetscInt column[8];
    PetscScalar value[8];
    void add(PetscInt c, double v) {
        column[count] = c;
        value[count++] = v;
    }
};

/// Message of PETSc's last error.
std::string& complaint() {
    static std::string text;
    return text;
}
PetscErrorCode keep_complaint(MPI_Comm, int, const char*, const char*, PetscErrorCode code, PetscErrorType type,
                              const char* message, void*) {
    if (type == PETSC_ERROR_INITIAL) complaint() = message && *message ? message : "no reason given";
    return code;
}

/// Use of PETSc, which is started while there are solvers.
class Session {
public:
    PetscErrorCode begin() {
        PetscFunctionBeginUser;
        if (running++ > 0) PetscFunctionReturn(0);
        PetscCall(start_petsc(began));
        PetscCall(PetscPushErrorHandler(keep_complaint, nullptr));
        PetscFunctionReturn(0);
    }
    void end() {
        if (--running > 0) return;
        PetscPopErrorHandler();
        if (began) PetscFinalize();
    }

private:
    static inline int running = 0;
    static inline bool began = false;
};

class PetscMultigrid final : public PressureSolver {
public:
    PetscMultigrid(const Communicator& comm, const TensorGrid& grid)
        : comm_(MPI_Comm_f2c(comm.handle())), rank_(comm.rank()), levels_(levels_of(grid, comm.size())) {}
    ~PetscMultigrid() override {
        KSPDestroy(&solver_);
        VecDestroy(&right_);
        VecDestroy(&answer_);
        MatNullSpaceDestroy(&constants_);
        session_.end();
    }
    std::size_t bytes() const override { return bytes_; }

    PetscErrorCode build(double tolerance) {
        PetscFunctionBeginUser;
        PetscCall(session_.begin());
        const int count = static_cast<int>(levels_.size());
        PetscCall(KSPCreate(comm_, &solver_));
        PetscCall(KSPSetType(solver_, KSPCG));
        PetscCall(KSPSetNormType(solver_, KSP_NORM_UNPRECONDITIONED));
        PetscCall(KSPSetTolerances(solver_, tolerance, 0, PETSC_MAX_REAL, most_iterations));
        PC cycle;
        PetscCall(KSPGetPC(solver_, &cycle));
        PetscCall(PCSetType(cycle, PCMG));
        PetscCall(PCMGSetLevels(cycle, count, nullptr)); // level 0 is the coarsest
        for (int l = 0; l < count; ++l) {
            const Level& level = nth(levels_, count - 1 - l);
            Mat matrix;
            PetscCall(differences(level, l == 0, &matrix));
            KSP smoother;
            PetscCall(PCMGGetSmoother(cycle, l, &smoother));
            PetscCall(KSPSetOperators(smoother, matrix, matrix));
            if (l == 0) PetscCall(solve_directly(smoother));
            else {
                PetscCall(smooth(smoother));
                Mat between;
                PetscCall(interpolations(level, nth(levels_, count - l), &between));
                PetscCall(PCMGSetInterpolation(cycle, l, between));
                PetscCall(count_bytes(between));
                PetscCall(MatDestroy(&between));
            }
            if (l == count - 1) {
                Mat whole = matrix;
                if (l == 0) PetscCall(differences(level, false, &whole)); // few cells
                else PetscCall(PetscObjectReference(reinterpret_cast<PetscObject>(whole)));
                PetscCall(KSPSetOperators(solver_, whole, whole));
                PetscCall(MatNullSpaceCreate(comm_, PETSC_TRUE, 0, nullptr, &constants_));
                PetscCall(MatSetNullSpace(whole, constants_));
                PetscCall(MatCreateVecs(whole, &answer_, &right_));
                PetscCall(MatDestroy(&whole));
            }
            PetscCall(count_bytes(matrix));
            bytes_ += (l == count - 1 ? 10 : 7) *
                      sizeof(PetscScalar) * // vectors of the cycle, and of conjugate gradients
                      to_index(level.first_cell(rank_ + 1) - level.first_cell(rank_));
            PetscCall(MatDestroy(&matrix));
        }
        PetscCall(KSPSetUp(solver_));
        PetscFunctionReturn(0);
    }

    std::string solve(std::span<const double> f, std::span<double> phi) override {
        complaint().clear();
        KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
        double size = 0, left = 0;
        PetscInt iterations = 0;
        if (run(f, phi, size, reason, left, iterations)) return "PETSc cannot solve for the pressure: " + complaint();
        if (reason > 0) return {};
        if (!std::isfinite(size))
            return "the velocity of the fluid is not finite, and has no pressure; reduce fluid.courant or time.dt";
        char text[200];
        std::snprintf(
            text, sizeof text,
            "multigrid does not converge: the residual is %.3g of the right side after %d iterations (%s); increase "
            "fluid.pressure_tolerance",
            left / size, static_cast<int>(iterations), KSPConvergedReasons[reason]);
        return text;
    }

private:
    template <class Body> void for_cells(const Level& level, Body&& body) const {
        const std::size_t rank = to_index(rank_);
        for (int k = level.first_plane[rank]; k < level.first_plane[rank + 1]; ++k)
            for (int j = 0; j < level.size(1); ++j)
                for (int i = 0; i < level.size(0); ++i) body(i, j, k);
    }

    PetscErrorCode run(std::span<const double> f, std::span<double> phi, double& size, KSPConvergedReason& reason,
                       double& left, PetscInt& iterations) {
        PetscFunctionBeginUser;
        const Level& level = levels_.front();
        PetscScalar* numbers;
        PetscCall(VecGetArrayWrite(right_, &numbers));
        std::size_t at = 0;
        for_cells(level, [&](int i, int j, int k) {
            numbers[at] = -level.volume(i, j, k) * f[at];
            ++at;
        });
        PetscCall(VecRestoreArrayWrite(right_, &numbers));
        PetscCall(MatNullSpaceRemove(constants_, right_));
        PetscCall(VecNorm(right_, NORM_2, &size));
        if (!std::isfinite(size)) PetscFunctionReturn(0);
        PetscCall(KSPSolve(solver_, right_, answer_));
        PetscCall(KSPGetConvergedReason(solver_, &reason));
        PetscCall(KSPGetResidualNorm(solver_, &left));
        PetscCall(KSPGetIterationNumber(solver_, &iterations));
        const PetscScalar* found;
        PetscCall(VecGetArrayRead(answer_, &found));
        std::copy_n(found, phi.size(), phi.begin());
        PetscCall(VecRestoreArrayRead(answer_, &found));
        PetscFunctionReturn(0);
    }

    /// Assembles this rank's rows of a matrix; row(i, j, k, entries) gives the entries of a cell.
    template <class Row>
    PetscErrorCode assemble(const Level& rows, const Level& columns, Row&& row, Mat* matrix) const {
        PetscFunctionBeginUser;
        const PetscInt first = columns.first_cell(rank_), end = columns.first_cell(rank_ + 1),
                       mine = rows.first_cell(rank_ + 1) - rows.first_cell(rank_);
        std::vector<PetscInt> here, away;
        here.reserve(to_index(mine));
        away.reserve(to_index(mine));
        for_cells(rows, [&](int i, int j, int k) {
            Entries entries;
            row(i, j, k, entries);
            const auto inside = std::count_if(entries.column, entries.column + entries.count,
                                              [&](PetscInt c) { return c >= first && c < end; });
            here.push_back(static_cast<PetscInt>(inside));
            away.push_back(entries.count - static_cast<PetscInt>(inside));
        });
        PetscCall(MatCreate(comm_, matrix));
        PetscCall(MatSetSizes(*matrix, mine, end - first, static_cast<PetscInt>(rows.cells()),
                              static_cast<PetscInt>(columns.cells())));
        PetscCall(MatSetType(*matrix, MATAIJ));
        PetscCall(MatXAIJSetPreallocation(*matrix, 1, here.data(), away.data(), nullptr, nullptr));
        PetscErrorCode failed = 0;
        for_cells(rows, [&](int i, int j, int k) {
            Entries entries;
            row(i, j, k, entries);
            const PetscInt at = rows.cell(i, j, k);
            if (!failed)
                failed = MatSetValues(*matrix, 1, &at, entries.count, entries.column, entries.value, ADD_VALUES);
        });
        PetscCall(failed);
        PetscCall(MatAssemblyBegin(*matrix, MAT_FINAL_ASSEMBLY));
        PetscCall(MatAssemblyEnd(*matrix, MAT_FINAL_ASSEMBLY));
        PetscFunctionReturn(0);
    }

    /// Matrix of flows out of cells. With `inverted` the first cell also loses its own value, so that right sides of
    /// sum 0 have the solution with that value at 0.
    PetscErrorCode differences(const Level& level, bool inverted, Mat* matrix) const {
        PetscFunctionBeginUser;
        PetscCall(assemble(
            level, level,
            [&](int i, int j, int k, Entries& row) {
                const int at[3] = {i, j, k};
                double sum = 0;
                for (int d = 0; d < 3; ++d) {
                    const Line& line = nth(level.line, d);
                    const double area = level.volume(i, j, k) / level.width(d, at[d]);
                    const auto neighbour = [&](int place, double closeness) {
                        if (closeness == 0) return;
                        int next[3] = {i, j, k};
                        next[d] = (place + line.size()) % line.size();
                        row.add(level.cell(next[0], next[1], next[2]), -area * closeness);
                        sum += area * closeness;
                    };
                    neighbour(at[d] - 1, line.closeness_before(at[d]));
                    neighbour(at[d] + 1, line.closeness(at[d]));
                }
                if (sum == 0) sum = 1; // the only cell
                row.add(level.cell(i, j, k), inverted && i + j + k == 0 ? 2 * sum : sum);
            },
            matrix));
        PetscFunctionReturn(0);
    }

    PetscErrorCode interpolations(const Level& fine, const Level& coarse, Mat* matrix) const {
        PetscFunctionBeginUser;
        std::array<std::vector<Weights>, 3> of;
        for (std::size_t d = 0; d < 3; ++d) of[d] = interpolation(fine.line[d], coarse.line[d]);
        PetscCall(assemble(
            fine, coarse,
            [&](int i, int j, int k, Entries& row) {
                const Weights &x = nth(of[0], i), &y = nth(of[1], j), &z = nth(of[2], k);
                for (std::size_t c = 0; c < 2; ++c)
                    for (std::size_t b = 0; b < 2; ++b)
                        for (std::size_t a = 0; a < 2; ++a)
                            if (const double weight = x.weight[a] * y.weight[b] * z.weight[c]; weight != 0)
                                row.add(coarse.cell(x.cell[a], y.cell[b], z.cell[c]), weight);
            },
            matrix));
        PetscFunctionReturn(0);
    }

    static PetscErrorCode solve_directly(KSP solver) {
        PetscFunctionBeginUser;
        PetscCall(KSPSetType(solver, KSPPREONLY));
        PC direct;
        PetscCall(KSPGetPC(solver, &direct));
        PetscCall(PCSetType(direct, PCREDUNDANT)); // every rank solves for itself
        PetscFunctionReturn(0);
    }

    /// Smooths by polynomials of the matrix over its diagonal, which do not depend on ranks. Its eigenvalues are at
    /// most 2, and at least 1/3 for alternating values on cubes.
    static PetscErrorCode smooth(KSP smoother) {
        PetscFunctionBeginUser;
        PetscCall(KSPSetType(smoother, KSPCHEBYSHEV));
        PetscCall(KSPChebyshevSetEigenvalues(smoother, 2, 0.3));
        PetscCall(KSPSetTolerances(smoother, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, 2));
        PetscCall(KSPSetNormType(smoother, KSP_NORM_NONE));
        PC diagonal;
        PetscCall(KSPGetPC(smoother, &diagonal));
        PetscCall(PCSetType(diagonal, PCJACOBI));
        PetscFunctionReturn(0);
    }

    PetscErrorCode count_bytes(Mat matrix) {
        PetscFunctionBeginUser;
        MatInfo info;
        PetscCall(MatGetInfo(matrix, MAT_LOCAL, &info));
        PetscInt rows;
        PetscCall(MatGetLocalSize(matrix, &rows, nullptr));
        bytes_ += static_cast<std::size_t>(info.nz_allocated) * (sizeof(PetscScalar) + sizeof(PetscInt)) +
                  to_index(rows) * 4 * sizeof(PetscInt);
        PetscFunctionReturn(0);
    }

    MPI_Comm comm_;
    int rank_;
    std::vector<Level> levels_; ///< the finest first
    Session session_;
    KSP solver_ = nullptr;
    Vec right_ = nullptr, answer_ = nullptr;
    MatNullSpace constants_ = nullptr;
    std::size_t bytes_ = 0;
};

} // namespace

extern "C" __attribute__((visibility("default"))) PressureSolver*
skein_multigrid_1(const Communicator& comm, const TensorGrid& grid, double tolerance, std::string& fault) {
    double cells = 1;
    for (const auto& width : grid.width) cells *= static_cast<double>(width.size());
    if (cells > std::numeric_limits<PetscInt>::max()) {
        fault = "this PETSc counts to " + std::to_string(std::numeric_limits<PetscInt>::max()) +
                ", and the fluid has more cells";
        return nullptr;
    }
    auto solver = std::make_unique<PetscMultigrid>(comm, grid);
    if (solver->build(tolerance)) {
        fault = complaint();
        return nullptr;
    }
    return solver.release();
}

} // namespace skein
