// Fourier transforms of complex lines side by side, by FFTW, which is loaded when the first plan is made: a run without
// a fluid never sees it.
#pragma once

#include <memory>

namespace skein {

/// Of `lines` lines of n complex numbers: number i of line l at 2 (i lines + l). Plans are made without measurements:
/// on one machine the bits depend on n and `lines` alone.
class Fft {
public:
    enum class Way { forward = -1, inverse = 1 }; ///< without a factor
    /// Throws InputError where FFTW cannot be loaded.
    Fft(int n, int lines, Way way);
    Fft(Fft&&) noexcept;
    Fft& operator=(Fft&&) noexcept;
    ~Fft();

    /// Both on cache lines. What was in `from` is lost. Any thread.
    void run(double* from, double* to) const;

private:
    struct Plan;
    std::unique_ptr<Plan> plan_;
};

} // namespace skein
