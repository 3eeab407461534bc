// The progress line as an output.
#include "simulation/output.hpp"
#include "simulation/progress.hpp"

namespace skein {

namespace {

class ProgressOutput final : public Output {
public:
    explicit ProgressOutput(const OutputParts& parts)
        : world_(parts.world), observation_(parts.observation), last_step_(parts.last_step),
          columns_(parts.progress_columns.begin(), parts.progress_columns.end()),
          line_(world_.comm.root() && (!parts.options.quiet || parts.options.place), parts.options.progress,
                world_.clock.done(), last_step_, world_.plan.dt, static_cast<double>(world_.plan.elements),
                parts.scene.output.progress, parts.options.place) {
        parts.warnings.set_before([this] { line_.finish(); });
    }

    bool due(const Moment& now) const override { return now.step > 0; }
    void tick() override {
        if (!columns_.empty())
            show_ = world_.comm.broadcast(static_cast<std::int64_t>(line_.due(world_.clock.done()))) != 0;
    }
    void write(const Moment& now) override;
    bool needs_state_alone() const override { return false; }
    Phase phase() const override { return Phase::observe; }

private:
    const World& world_;
    Observation& observation_;
    std::int64_t last_step_;
    std::vector<std::size_t> columns_; ///< of the series
    Progress line_;
    bool show_ = false;
};

void ProgressOutput::write(const Moment& now) {
    std::vector<double> values;
    if (!columns_.empty() && (show_ || now.step >= last_step_ || world_.ended()))
        for (const std::size_t column : columns_) values.push_back(observation_.sample()[column]);
    show_ = false;
    std::string more;
    for (const auto& interaction : world_.interactions()) more += interaction->progress();
    line_.show(now.step, values, more);
}

} // namespace

std::unique_ptr<Output> make_progress(const OutputParts& parts) { return std::make_unique<ProgressOutput>(parts); }

} // namespace skein
