// All loads that scenes know. A new load adds its file to these #includes and its name to the list. One source of each
// level (kernels/load_passes_at.cpp) and load_list.cpp read it: nothing else depends on the loads that exist.
#pragma once

#include "loads/end_couple.hpp"
#include "loads/end_force.hpp"
#include "loads/formula_load.hpp"
#include "loads/gravity.hpp"
#include "loads/guide.hpp"
#include "loads/magnetic_field.hpp"
#include "loads/magnetic_formula.hpp"
#include "loads/muscle_formula.hpp"
#include "loads/muscle_torques.hpp"
#include "loads/muscle_wave.hpp"
#include "loads/plane_friction.hpp"
#include "loads/sinusoidal_end_force.hpp"
#include "loads/slender_body_drag.hpp"
#include "loads/uniform_couple.hpp"
#include "loads/uniform_force.hpp"

namespace skein {

template <class... L> struct LoadTypes {};

using LoadList = LoadTypes<Gravity, UniformForce, UniformCouple, EndForce, MagneticField, MuscleWave,
                           SinusoidalEndForce, SlenderBodyDrag, MuscleTorques, PlaneFriction, EndCouple, FormulaLoad,
                           MagneticFormula, MuscleFormula, Guide>;

} // namespace skein
