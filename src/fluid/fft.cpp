#include "fluid/fft.hpp"

#include "skein/core/aligned.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <dlfcn.h>
#include <fftw3.h>

#include <string>

namespace skein {

namespace {

/// Functions of FFTW.
struct Library {
    decltype(&fftw_plan_many_dft) plan;
    decltype(&fftw_execute_dft) execute;
    decltype(&fftw_destroy_plan) destroy;

    static const Library& get() {
        static const Library loaded;
        return loaded;
    }

private:
    Library() {
        void* const library = dlopen("libfftw3.so.3", RTLD_NOW | RTLD_LOCAL);
        if (!library)
            throw InputError(
                std::string("a fluid needs the library FFTW 3 (Debian: libfftw3-double3), which was not found: ") +
                dlerror());
        find(library, "fftw_plan_many_dft", plan);
        find(library, "fftw_execute_dft", execute);
        find(library, "fftw_destroy_plan", destroy);
    }
    template <class F> static void find(void* library, const char* name, F& function) {
        function = reinterpret_cast<F>(dlsym(library, name));
        if (!function) throw InputError(std::string("the library FFTW 3 has no function ") + name);
    }
};

fftw_complex* complex(double* numbers) { return reinterpret_cast<fftw_complex*>(numbers); }

} // namespace

struct Fft::Plan {
    fftw_plan plan;
    ~Plan() {
        if (plan) Library::get().destroy(plan); // without a plan there may be no library
    }
};

Fft::Fft(int n, int lines, Way way) : plan_(new Plan{nullptr}) {
    AlignedVector<double> from(to_index(2 * n * lines)), to(from.size());
    plan_->plan = Library::get().plan(1, &n, lines, complex(from.data()), nullptr, lines, 1, complex(to.data()),
                                      nullptr, lines, 1, static_cast<int>(way), FFTW_ESTIMATE | FFTW_DESTROY_INPUT);
}
Fft::Fft(Fft&&) noexcept = default;
Fft& Fft::operator=(Fft&&) noexcept = default;
Fft::~Fft() = default;

void Fft::run(double* from, double* to) const { Library::get().execute(plan_->plan, complex(from), complex(to)); }

} // namespace skein
