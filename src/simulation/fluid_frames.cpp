#include "simulation/fluid_frames.hpp"

#include "skein/core/index.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

namespace skein {

namespace {

std::uint64_t unsigned_of(int x) { return static_cast<std::uint64_t>(x); }

/// Planes of a box, as many at a time as keep a piece small.
class BoxFrame final : public FieldFrame {
public:
    BoxFrame(BoxSampler& sampler, const CellBox& box, const std::vector<CellField>& fields)
        : sampler_(sampler), fields_(fields) {
        const std::size_t plane = 3 * static_cast<std::size_t>(box.count[0]) * static_cast<std::size_t>(box.count[1]);
        const int most = static_cast<int>(std::max<std::size_t>(1, FieldSeries::most_numbers / plane));
        const Slab planes = sampler.planes();
        for (int first = 0; first < planes.count; first += most) {
            const int count = std::min(most, planes.count - first);
            first_.push_back(first);
            pieces_.push_back({{unsigned_of(planes.first + first), 0, 0},
                               {unsigned_of(count), unsigned_of(box.count[1]), unsigned_of(box.count[0])}});
        }
    }
    void begin(std::size_t field) override { sampler_.begin(fields_[field]); }
    const std::vector<H5Box>& pieces() const override { return pieces_; }
    void fill(std::size_t piece, std::span<double> out) override {
        sampler_.sample(first_[piece], static_cast<int>(pieces_[piece].count[0]), out);
    }

private:
    BoxSampler& sampler_;
    const std::vector<CellField>& fields_;
    std::vector<int> first_;
    std::vector<H5Box> pieces_;
};

class BlockFrame final : public FieldFrame {
public:
    BlockFrame(const BlockSampler& sampler, int edge, const std::vector<CellField>& fields)
        : sampler_(sampler), fields_(fields), parts_(sampler.pieces(FieldSeries::most_numbers)) {
        for (const BlockSampler::Piece& part : parts_)
            pieces_.push_back({{part.first, unsigned_of(part.plane), 0, 0},
                               {part.count, unsigned_of(part.planes), unsigned_of(edge), unsigned_of(edge)}});
    }
    void begin(std::size_t field) override { field_ = fields_[field]; }
    const std::vector<H5Box>& pieces() const override { return pieces_; }
    void fill(std::size_t piece, std::span<double> out) override { sampler_.sample(field_, parts_[piece], out); }

private:
    const BlockSampler& sampler_;
    const std::vector<CellField>& fields_;
    std::vector<BlockSampler::Piece> parts_;
    std::vector<H5Box> pieces_;
    CellField field_ = CellField::velocity;
};

FieldSeries::Names names_of(const FluidOutput& output, const std::string& directory) {
    FieldSeries::Names names{directory, output.name, {}, {{"kind", std::string(nth(fluid_output_names, output.kind))}}};
    if (output.kind == FluidOutputKind::slice)
        names.labels.emplace_back("across", std::string(nth(direction_names, output.across)));
    for (const CellField field : output.fields) {
        const CellFieldEntry& entry = entry_of(field);
        names.fields.push_back({std::string(entry.name), std::string(entry.unit), entry.components});
    }
    return names;
}

FieldGrid grid_of(const FluidOutput& output, const FluidGrid& fluid) {
    if (output.kind == FluidOutputKind::blocks) return {{output.edge, output.edge, output.edge}, fluid.h, fluid.lower};
    const auto corner = [&](std::size_t d) { return fluid.h * output.box.first[d]; };
    return {output.box.count, output.box.average * fluid.h, fluid.lower + Vec3d{corner(0), corner(1), corner(2)}};
}

} // namespace

struct FluidFrames::Output {
    FluidOutput what;
    FieldSeries series;
    std::optional<BoxSampler> box;
    std::optional<BlockSampler> blocks;
    std::array<int, 3> cells; ///< of the fluid

    bool is_due(std::int64_t step) const { return step % what.every == 0; }
};

FluidFrames::FluidFrames(const Communicator& comm, const Threads& threads, const FlowSolver& flow,
                         const FluidPlan& plan, const std::string& directory, double dt, double shift,
                         const Earlier& earlier)
    : flow_(comm, flow) {
    const FluidGrid& grid = plan.constants.grid;
    for (const FluidOutput& output : plan.outputs) {
        Output& made = outputs_.emplace_back(
            Output{output,
                   FieldSeries(comm, names_of(output, directory), grid_of(output, grid), output.precision, dt, shift,
                               earlier(FieldSeries::name_of(output.name))),
                   std::nullopt, std::nullopt, grid.cells});
        if (output.kind == FluidOutputKind::blocks) made.blocks.emplace(comm, threads, flow_, output.edge);
        else made.box.emplace(comm, threads, flow_, output.box);
    }
}

FluidFrames::~FluidFrames() = default;

std::int64_t FluidFrames::next(std::int64_t done) const {
    std::int64_t next = std::numeric_limits<std::int64_t>::max();
    for (const Output& output : outputs_) next = std::min(next, (done / output.what.every + 1) * output.what.every);
    return next;
}

std::vector<std::string> FluidFrames::files_of_end(std::int64_t step) const {
    std::vector<std::string> names;
    for (const Output& output : outputs_)
        if (!output.is_due(step))
            for (std::string& name : output.series.files_of(step, output.blocks.has_value()))
                names.push_back(std::move(name));
    return names;
}

void FluidFrames::mark(std::map<std::string, std::int64_t>& last) const {
    for (const Output& output : outputs_) last[FieldSeries::name_of(output.what.name)] = output.series.last_step();
}

void FluidFrames::write(std::int64_t step, const Vec3d& moved, bool due) {
    const auto wanted = [&](const Output& output) { return output.is_due(step) == due; };
    if (std::none_of(outputs_.begin(), outputs_.end(), wanted)) return;
    flow_.take();
    for (Output& output : outputs_)
        if (wanted(output)) write(step, moved, output);
    flow_.release();
}

void FluidFrames::write(std::int64_t step, const Vec3d& moved, Output& output) {
    if (output.box) {
        BoxFrame frame(*output.box, output.what.box, output.what.fields);
        output.series.write(step, moved, frame);
        return;
    }
    output.blocks->find(output.what.criterion, output.what.threshold);
    BlockFrame frame(*output.blocks, output.what.edge, output.what.fields);
    std::vector<std::array<int, 3>> first = output.blocks->blocks();
    for (auto& block : first)
        for (int& cell : block) cell *= output.what.edge;
    output.series.write_blocks(step, moved, frame, first, output.cells);
}

} // namespace skein
