// One line per benchmark: the median of its repetitions per element(-step), beside the roofs measured before it in the
// same run.
#pragma once

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <fmt/os.h>

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace skein::bench {

/// Names are <what>/W<width>/[n<elements>/]<level>; peaks are peak/W<width>, streams stream-<kind>/W8/<level>.
class RoofTable final : public benchmark::BenchmarkReporter {
public:
    explicit RoofTable(const std::string& csv) {
        if (!csv.empty()) csv_.emplace(fmt::output_file(csv));
    }
    bool ReportContext(const Context&) override {
        fmt::print("{:<26}{:>3}{:>5}{:>6}{:>10}{:>9}{:>8}{:>7}{:>8}{:>8}{:>8}\n", "per element(-step)", "W", "n", "in",
                   "kB", "ns", "GF/s", "peak", "bytes", "GB/s", "update");
        if (csv_)
            csv_->print(
                "what,width,elements,level,working_set_bytes,ns,flop,bytes,gflops,share_of_peak,gbs,share_of_update\n");
        return true;
    }
    void ReportRuns(const std::vector<Run>& runs) override {
        std::vector<double> seconds;
        for (const Run& run : runs)
            if (run.run_type == Run::RT_Iteration && !run.error_occurred) seconds.push_back(run.counters.at("s").value);
        if (seconds.empty()) return; // Google Benchmark's own means and deviations
        const auto middle = seconds.begin() + static_cast<std::ptrdiff_t>(seconds.size() / 2);
        std::nth_element(seconds.begin(), middle, seconds.end());
        const double ns = 1e9 * *middle;

        const auto counter = [&](const char* name) -> double { return runs[0].counters.at(name); };
        const double flop = counter("flop"), bytes = counter("bytes"), set = counter("working_set");
        const Name name(runs[0].run_name.function_name);
        const double gflops = flop / ns, gbs = bytes / ns;
        if (name.what == "peak") peak_[name.width] = gflops;
        if (name.what == "stream-update") update_[name.level] = gbs;
        const auto share = [](double value, const std::map<std::string, double>& roofs, const std::string& key) {
            const auto roof = roofs.find(key);
            return roof == roofs.end() || value == 0 ? 0 : value / roof->second;
        };
        const double of_peak = share(gflops, peak_, name.width), of_update = share(gbs, update_, name.level);
        const auto percent = [](double s) { return s == 0 ? std::string("-") : fmt::format("{:.0f} %", 100 * s); };
        fmt::print("{:<26}{:>3}{:>5}{:>6}{:>10.1f}{:>9.3f}{:>8.1f}{:>7}{:>8.1f}{:>8.1f}{:>8}\n", name.what, name.width,
                   name.elements, name.level, 1e-3 * set, ns, gflops, percent(of_peak), bytes, gbs, percent(of_update));
        std::fflush(stdout);
        if (csv_)
            csv_->print("{},{},{},{},{:.0f},{:.5g},{:.5g},{:.5g},{:.5g},{:.4g},{:.5g},{:.4g}\n", name.what, name.width,
                        name.elements, name.level, set, ns, flop, bytes, gflops, of_peak, gbs, of_update);
    }

private:
    struct Name {
        std::string what, width, elements, level;
        explicit Name(const std::string& text) {
            for (std::size_t at = 0; at <= text.size();) {
                const std::size_t end = std::min(text.find('/', at), text.size());
                const std::string part = text.substr(at, end - at);
                if (at == 0) what = part;
                else if (part[0] == 'W') width = part.substr(1);
                else if (part[0] == 'n') elements = part.substr(1);
                else if (part[0] == 'L' || part == "DRAM") level = part;
                else what += "/" + part;
                at = end + 1;
            }
        }
    };
    std::map<std::string, double> peak_, update_; ///< GF/s by width, GB/s by level
    std::optional<fmt::ostream> csv_;
};

} // namespace skein::bench
