// The loads that scenes know. A new one: its file among these #includes, and its name in the list. Read by one source
// of each level (kernels/load_passes_at.cpp) and by load_list.cpp: nothing else depends on which loads there are.
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
