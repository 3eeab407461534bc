// Single header for the author of a load: keys of a scene, tiles of rods and their constants, times of steps.
#pragma once

#include "skein/loads/load.hpp"
#include "skein/loads/ramp.hpp"
#include "skein/tiles/mapping.hpp"
