// Frames of a fluid, as a plan wants them: whole, slices, boxes of means, blocks.
#include "fluid/cell_samples.hpp"
#include "io/field_series.hpp"
#include "physics/fluid/fluid_interaction.hpp"
#include "physics/fluid/fluid_plan.hpp"
#include "simulation/output.hpp"

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

/// Frames of one kind.
struct FrameSeries {
    FluidOutput what;
    FieldSeries series;
    std::optional<BoxSampler> box;
    std::optional<BlockSampler> blocks;
    std::array<int, 3> cells; ///< of the fluid

    Every every() const { return {what.every}; }
    void write(std::int64_t step, const Vec3d& moved);
};

void FrameSeries::write(std::int64_t step, const Vec3d& moved) {
    if (box) {
        BoxFrame frame(*box, what.box, what.fields);
        series.write(step, moved, frame);
        return;
    }
    blocks->find(what.criterion, what.threshold);
    BlockFrame frame(*blocks, what.edge, what.fields);
    std::vector<std::array<int, 3>> first = blocks->blocks();
    for (auto& block : first)
        for (int& cell : block) cell *= what.edge;
    series.write_blocks(step, moved, frame, first, cells);
}

class FluidFrames final : public Output {
public:
    explicit FluidFrames(const OutputParts& parts);

    std::int64_t next(std::int64_t done) const override;
    bool due(const Moment& now) const override {
        return std::any_of(all_.begin(), all_.end(), [&](const auto& one) { return one.every().due(now.step); });
    }
    void write(const Moment& now) override { write(now.step, true); }
    void write_end(const Moment& now) override { write(now.step, false); }
    std::vector<std::string> files_of_end(std::int64_t step) const override;
    void mark(CheckpointInfo& info) const override {
        for (const FrameSeries& one : all_)
            info.last_frames[FieldSeries::name_of(one.what.name)] = one.series.last_step();
    }
    bool shows_failure() const override { return false; }
    void rebind(const Rods&) override { sample(); }

private:
    void write(std::int64_t step, bool due);
    /// Takes samples of the flow that the world has now.
    void sample();

    const World& world_;
    const FluidInteraction* fluid_ = nullptr;
    std::optional<FlowPlanes> flow_;
    std::vector<FrameSeries> all_;
};

void FluidFrames::sample() {
    fluid_ = fluid_of(world_.interactions());
    for (FrameSeries& one : all_) {
        one.box.reset();
        one.blocks.reset();
    }
    flow_.emplace(world_.comm, fluid_->flow());
    for (FrameSeries& one : all_)
        if (one.what.kind == FluidOutputKind::blocks)
            one.blocks.emplace(world_.comm, world_.threads, *flow_, one.what.edge);
        else one.box.emplace(world_.comm, world_.threads, *flow_, one.what.box);
}

FluidFrames::FluidFrames(const OutputParts& parts) : world_(parts.world) {
    const FluidPlan& plan = *parts.plan().find<FluidPlan>();
    const FluidGrid& grid = plan.constants.grid;
    for (const FluidOutput& output : plan.outputs) {
        const EarlierFrames earlier{parts.resumed_step(), parts.last_frame(FieldSeries::name_of(output.name)),
                                    print_warning};
        all_.push_back(FrameSeries{output,
                                   FieldSeries(parts.comm(), names_of(output, parts.options.out), grid_of(output, grid),
                                               output.precision, parts.plan().dt, parts.world.clock.shift(), earlier),
                                   std::nullopt, std::nullopt, grid.cells});
    }
    sample();
}

std::int64_t FluidFrames::next(std::int64_t done) const {
    std::int64_t next = Every::never;
    for (const FrameSeries& one : all_) next = std::min(next, one.every().next(done));
    return next;
}

std::vector<std::string> FluidFrames::files_of_end(std::int64_t step) const {
    std::vector<std::string> names;
    for (const FrameSeries& one : all_)
        if (!one.every().due(step))
            for (std::string& name : one.series.files_of(step, one.blocks.has_value()))
                names.push_back(std::move(name));
    return names;
}

void FluidFrames::write(std::int64_t step, bool due) {
    const auto wanted = [&](const FrameSeries& one) { return one.every().due(step) == due; };
    if (std::none_of(all_.begin(), all_.end(), wanted)) return;
    flow_->take();
    for (FrameSeries& one : all_)
        if (wanted(one)) one.write(step, fluid_->box_shift());
    flow_->release();
}

} // namespace

std::unique_ptr<Output> make_fluid_frames(const OutputParts& parts) {
    const auto* fluid = parts.plan().find<FluidPlan>();
    if (!fluid || fluid->outputs.empty()) return nullptr;
    return std::make_unique<FluidFrames>(parts);
}

} // namespace skein
