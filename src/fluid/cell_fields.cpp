#include "fluid/cell_fields.hpp"

namespace skein {

CellReader::CellReader(const FlowPlanes& flow)
    : layout_(flow.layout()), ahead_{1, layout_.row, layout_.plane}, velocity_{flow.velocity(0).data(),
                                                                               flow.velocity(1).data(),
                                                                               flow.velocity(2).data()},
      pressure_(flow.pressure().data()), h_(flow.constants().grid.h), density_(flow.constants().density) {}

CellReader::Gradient CellReader::gradient(std::ptrdiff_t at) const {
    Gradient gradient{};
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t d = 0; d < 3; ++d)
            gradient[c][d] = c == d ? (velocity_[c][at] - velocity_[c][at - ahead_[c]]) / h_
                                    : (centred(c, at + ahead_[d]) - centred(c, at - ahead_[d])) / (2 * h_);
    return gradient;
}

void CellReader::row(CellField field, int i, int j, int k, int count, double* out) const {
    const std::ptrdiff_t begin = layout_.at(i, j, k), end = begin + count;
    switch (field) {
    case CellField::velocity:
        for (std::ptrdiff_t at = begin; at < end; ++at)
            for (std::size_t c = 0; c < 3; ++c) *out++ = centred(c, at);
        break;
    case CellField::vorticity:
        for (std::ptrdiff_t at = begin; at < end; ++at) {
            const Gradient g = gradient(at);
            for (std::size_t c = 0; c < 3; ++c) *out++ = g[(c + 2) % 3][(c + 1) % 3] - g[(c + 1) % 3][(c + 2) % 3];
        }
        break;
    case CellField::q:
        for (std::ptrdiff_t at = begin; at < end; ++at) {
            const Gradient g = gradient(at);
            double q = 0;
            for (std::size_t c = 0; c < 3; ++c) q -= 0.5 * g[c][c] * g[c][c] + g[c][(c + 1) % 3] * g[(c + 1) % 3][c];
            *out++ = q;
        }
        break;
    case CellField::pressure:
        for (std::ptrdiff_t at = begin; at < end; ++at) *out++ = density_ * pressure_[at];
        break;
    }
}

} // namespace skein
