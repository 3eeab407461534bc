// Rows of observables.csv.
#include "io/disk.hpp"
#include "io/files.hpp"
#include "simulation/output.hpp"

namespace skein {

namespace {

class SeriesOutput final : public PeriodicOutput {
public:
    /// `file`: root's.
    SeriesOutput(const OutputParts& parts, std::unique_ptr<SeriesFile> file)
        : PeriodicOutput(parts.plan().cadence.of("series")), comm_(parts.comm()), observation_(parts.observation),
          warnings_(parts.warnings), file_(std::move(file)) {}

    bool needs_state_alone() const override { return false; }
    void flush() override {
        on_root(comm_, [&] { file_->flush(); });
    }
    void mark(CheckpointInfo& info) const override;
    Phase phase() const override { return Phase::observe; }
    void write(const Moment& now) override;

private:
    std::vector<std::string> files_of(std::int64_t) const override { return {"observables.csv"}; }

    const Communicator& comm_;
    Observation& observation_;
    Warnings& warnings_;
    std::unique_ptr<SeriesFile> file_;
};

void SeriesOutput::write(const Moment& now) {
    const std::vector<double>& row = observation_.sample();
    if (due(now)) warnings_.warn_of_strain(observation_);
    const bool finite = observation_.finite();
    warnings_.warn("row", !finite, "an energy is not a number: the time series has no row of this step");
    on_root(comm_, [&] {
        if (finite) file_->append(now.step, now.time, row);
    });
}

void SeriesOutput::mark(CheckpointInfo& info) const {
    const SeriesMark mine = file_ ? file_->mark() : SeriesMark{};
    info.series = SeriesMark{static_cast<std::uint64_t>(comm_.broadcast(static_cast<std::int64_t>(mine.bytes))),
                             static_cast<std::uint64_t>(comm_.broadcast(static_cast<std::int64_t>(mine.digest))),
                             comm_.broadcast(mine.row)};
}

} // namespace

std::unique_ptr<Output> make_series(const OutputParts& parts) {
    if (parts.plan().cadence.of("series") == 0 && !parts.plan().pseudo_time) return nullptr;
    std::unique_ptr<SeriesFile> file;
    on_root(parts.comm(), [&] {
        file = std::make_unique<SeriesFile>(
            parts.options.out + "/observables.csv", parts.observation.names(), parts.resumed_step(),
            parts.resumed && parts.resumed->series ? &*parts.resumed->series : nullptr, print_warning);
    });
    return std::make_unique<SeriesOutput>(parts, std::move(file));
}

} // namespace skein
