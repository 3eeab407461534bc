// Fourier transforms of adjacent complex lines by FFTW. The first plan loads the library, so runs without a fluid do
// not need it.
#pragma once

#include <memory>

namespace skein {

/// Transform of `lines` lines of n complex numbers, with number i of line l at 2 (i lines + l). Plans use no
/// measurements, so on one machine bits depend only on n and `lines`.
class Fft {
public:
    enum class Way { forward = -1, inverse = 1 }; ///< both without a factor
    /// Throws InputError if FFTW cannot be loaded.
    Fft(int n, int lines, Way way);
    Fft(Fft&&) noexcept;
    Fft& operator=(Fft&&) noexcept;
    ~Fft();

    /// Transforms `from`, which is overwritten. Both arrays start at cache lines. Any thread may call it.
    void run(double* from, double* to) const;

private:
    struct Plan;
    std::unique_ptr<Plan> plan_;
};

} // namespace skein
