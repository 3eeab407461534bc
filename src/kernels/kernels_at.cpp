// Compiled once per width, for the level that has it.
#include "fluid/make_flow.hpp"
#include "kernels/kernels.hpp"
#include "kernels/make_rods_at.hpp"
#include "kernels/make_static_rods.hpp"

namespace skein {

extern "C" const Kernels SKEIN_KERNELS;
constinit const Kernels SKEIN_KERNELS = {SKEIN_WIDTH, make_rods_at<SKEIN_WIDTH>, make_contacts,
                                         make_flow,   make_static_rods_at,       make_static_contacts};

} // namespace skein
