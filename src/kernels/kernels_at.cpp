// Compiled once per width, for the level that has it.
#include "kernels/kernels.hpp"
#include "kernels/make_rods_at.hpp"
#ifdef SKEIN_FLUID
#include "fluid/make_flow.hpp"
#endif

namespace skein {

#ifdef SKEIN_FLUID
constexpr auto* flow_maker = make_flow;
#else
constexpr decltype(Kernels::make_flow) flow_maker = nullptr;
#endif

extern "C" const Kernels SKEIN_KERNELS;
constinit const Kernels SKEIN_KERNELS = {SKEIN_WIDTH, make_rods_at<SKEIN_WIDTH>, make_contacts, flow_maker};

} // namespace skein
