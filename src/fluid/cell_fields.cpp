#include "fluid/cell_fields.hpp"

#include <array>

namespace skein {

CellFields cell_fields(const FlowSolver& flow, const Threads& threads) {
    const FieldLayout layout = flow.layout();
    const FlowConstants& constants = flow.constants();
    const double h = constants.grid.h;
    const auto cells =
        static_cast<std::size_t>(layout.nx) * static_cast<std::size_t>(layout.ny) * static_cast<std::size_t>(layout.nz);
    CellFields out{std::vector<float>(3 * cells), std::vector<float>(3 * cells), std::vector<float>(cells),
                   std::vector<float>(cells)};
    const std::array<std::ptrdiff_t, 3> ahead{1, layout.row, layout.plane};
    const std::array<const double*, 3> velocity{flow.velocity(0).data(), flow.velocity(1).data(), flow.velocity(2).data()};
    threads.for_each(static_cast<std::size_t>(layout.nz), [&](std::size_t k, int) {
        std::size_t cell = k * static_cast<std::size_t>(layout.nx) * static_cast<std::size_t>(layout.ny);
        for (int j = 0; j < layout.ny; ++j)
            for (int i = 0; i < layout.nx; ++i, ++cell) {
                const std::ptrdiff_t at = layout.at(i, j, static_cast<int>(k));
                std::array<std::array<double, 3>, 3> gradient{}; // of component c along d
                for (std::size_t c = 0; c < 3; ++c) {
                    const auto centred = [&](std::ptrdiff_t here) {
                        return 0.5 * (velocity[c][here] + velocity[c][here - ahead[c]]);
                    };
                    out.velocity[3 * cell + c] = static_cast<float>(centred(at));
                    for (std::size_t d = 0; d < 3; ++d)
                        gradient[c][d] = c == d ? (velocity[c][at] - velocity[c][at - ahead[c]]) / h
                                                : (centred(at + ahead[d]) - centred(at - ahead[d])) / (2 * h);
                }
                double q = 0;
                for (std::size_t c = 0; c < 3; ++c) {
                    const std::size_t d = (c + 1) % 3, e = (c + 2) % 3;
                    out.vorticity[3 * cell + c] = static_cast<float>(gradient[e][d] - gradient[d][e]);
                    q -= 0.5 * gradient[c][c] * gradient[c][c] + gradient[c][d] * gradient[d][c];
                }
                out.q[cell] = static_cast<float>(q);
                out.pressure[cell] = static_cast<float>(constants.density * flow.pressure()[static_cast<std::size_t>(at)]);
            }
    });
    return out;
}

} // namespace skein
