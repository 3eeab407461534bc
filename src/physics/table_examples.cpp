#include "physics/table_examples.hpp"

#include <algorithm>
#include <iterator>

namespace skein {

namespace {

struct Example {
    std::string_view table, toml;
};

constexpr Example examples[] = {
    {"", R"toml(title = "a carpet of cilia"
include = ["material.toml"]       # its tables are added to the scene
)toml"},
    {"time", R"toml([time]
duration = 2.0
dt = "auto"
safety = 0.8
)toml"},
    {"rods", R"toml([[rods]]
name = "filament"
start = "clamped"
material = {density = 1200.0, youngs_modulus = 2e6}
section.radius = 3e-3
shape = {length = 0.2, elements = 30}
placement = {origin = [0.5, 0.0, 0.0], tangent = [0.0, 1.0, 0.0]}
)toml"},
    {"rods.material", R"toml([rods.material]
density = 1200.0
youngs_modulus = 2e6
law = "neo_hookean"
)toml"},
    {"rods.section", R"toml([rods.section]
kind = "elliptic"
radius = 3e-3
radius_2 = 1e-3
taper = 0.5
)toml"},
    {"rods.shape", R"toml([rods.shape]
length = 0.1
elements = 20
rest_curvature = [3.0, 0.0, 0.0]
)toml"},
    {"rods.placement", R"toml([rods.placement]
kind = "lattice"
origin = [0.0, 0.0, 0.1]
counts = [4, 3]
spacing = [0.1, 0.1]
stagger = 0.05
)toml"},
    {"rods.start_motion", R"toml([rods.start_motion]
times = [0.0, 0.5, 1.0]
translation = [[0.0, 0.0, 0.0], [0.02, 0.0, 0.0], [0.0, 0.0, 0.0]]
smooth = true
)toml"},
    {"rods.end_motion", R"toml([[rods]]
name = "twisted"
start = "clamped"
end = "clamped"
end_motion.rotation_formula = ["0", "0", "6*t"]
material = {density = 1200.0, youngs_modulus = 2e6}
section.radius = 3e-3
shape = {length = 0.2, elements = 30}
placement.origin = [0.5, 0.0, 0.0]
)toml"},
    {"rods.hold", R"toml([rods.hold]
nodes = [10, -1]
directions = "xy"
)toml"},
    {"rods.magnetisation", R"toml([rods.magnetisation]
pattern = "uniform"
strength = 2e4
direction = [0.0, 0.0, 1.0]
)toml"},
    {"bodies", R"toml([[bodies]]
name = "ball"
density = 800.0
spheres.radii = [0.01]
placement.origin = [0.2, 0.0, 0.1]
)toml"},
    {"bodies.spheres", R"toml([bodies.spheres]
centres = [[0.0, 0.0, 0.0], [0.03, 0.0, 0.0]]
radii = [0.02, 0.01]
)toml"},
    {"bodies.capsules", R"toml([bodies.capsules]
from = [[0.0, 0.0, -0.02]]
to = [[0.0, 0.0, 0.02]]
radii = [5e-3]
)toml"},
    {"bodies.boxes", R"toml([bodies.boxes]
sizes = [[0.04, 0.02, 0.02]]
radii = [2e-3]
)toml"},
    {"bodies.placement", R"toml([bodies.placement]
kind = "list"
origins = [[0.2, 0.0, 0.1], [0.2, 0.1, 0.1]]
)toml"},
    {"constants", R"toml([constants]
f = {value = 0.01, unit = "N/m"}
turns = 3
)toml"},
    {"contact", R"toml([contact]
law = "hertz"
stiffness = 1e4
damping = 10.0
friction = "memory"
static_friction = 0.3
)toml"},
    {"fluid", R"toml([fluid]
cells = [32, 32, 64]
spacing = 0.01
lower = [-0.16, -0.16, 0.0]
density = 1000.0
viscosity = 0.1
along_z = "no_slip"
)toml"},
    {"immersion", R"toml([immersion]
coupling = "one_way"
sweeps = 3
)toml"},
    {"table", R"toml([[table]]
name = "gust"
at = [0.0, 0.5, 1.0]
value = [0.0, 0.02, 0.0]
unit = "N/m"
periodic = true
)toml"},
    {"stage", R"toml([[stage]]
name = "fall"
duration = 0.5

[[stage]]
name = "rest"
change = ["damping.0.rate=20"]
)toml"},
    {"load.gravity", R"toml([[load]]
kind = "gravity"
acceleration = [0.0, 0.0, -1.62]
)toml"},
    {"load.uniform_force", R"toml([[load]]
kind = "uniform_force"
force = [1e-3, 0.0, 0.0]
ramp = 0.1
)toml"},
    {"load.uniform_couple", R"toml([[load]]
kind = "uniform_couple"
couple = [0.0, 1e-5, 0.0]
)toml"},
    {"load.end_force", R"toml([[load]]
kind = "end_force"
rods = ["arm"]
end = [0.0, 1e-3, 0.0]
ramp = 0.2
ramp_shape = "cosine"
)toml"},
    {"load.magnetic_field", R"toml([[load]]
kind = "magnetic_field"
rods = ["arm"]
rotating = 0.01
period = 0.5
)toml"},
    {"load.muscle_wave", R"toml([[load]]
kind = "muscle_wave"
amplitude = 1e-5
period = 1.0
wavelength = 0.1
frame = "body"
direction = [1.0, 0.0, 0.0]
)toml"},
    {"load.sinusoidal_end_force", R"toml([[load]]
kind = "sinusoidal_end_force"
end = 1e-4
period = 0.5
)toml"},
    {"load.slender_body_drag", R"toml([[load]]
kind = "slender_body_drag"
viscosity = 1e-3
)toml"},
    {"load.muscle_torques", R"toml([[load]]
kind = "muscle_torques"
coefficients = [0.0, 1e-5, 2e-5, 0.0]
period = 1.0
wave_number = 6.283
direction = [1.0, 0.0, 0.0]
frame = "body"
)toml"},
    {"load.anisotropic_plane", R"toml([[load]]
kind = "anisotropic_plane"
stiffness = 10.0
kinetic_forward = 0.1
kinetic_backward = 0.15
kinetic_sideways = 0.2
)toml"},
    {"load.end_couple", R"toml([[load]]
kind = "end_couple"
end = [1e-4, 0.0, 0.0]
frame = "body"
)toml"},
    {"load.formula", R"toml([[load]]
kind = "formula"
force = ["0.01*sin(2*pi*s/L)", "0", "0"]
per = "length"
)toml"},
    {"load.magnetic_formula", R"toml([[load]]
kind = "magnetic_formula"
rods = ["arm"]
field = ["0", "0.01*cos(6*t)", "0"]
)toml"},
    {"load.muscle_formula", R"toml([[load]]
kind = "muscle_formula"
moment = ["1e-5*sin(6*t)", "0", "0"]
)toml"},
    {"load.guide", R"toml([[load]]
kind = "guide"
rods = ["leg"]
stiffness = 0.1
along = "x"
place = ["0.01*t", "0", "0"]
)toml"},
    {"damping", R"toml([[damping]]
kind = "uniform"
rate = 2.0

[[damping]]
kind = "laplacian"
rate = 500.0
order = 2
)toml"},
    {"assembly", R"toml([[assembly]]
name = "robot"
placement = {kind = "line", counts = [4], spacing = [0.3]}

[[rods]]
name = "spine"
assembly = "robot"
material = {density = 1200.0, youngs_modulus = 2e6}
section.radius = 3e-3
shape = {length = 0.1, elements = 20}
placement.origin = [0.5, 0.0, 0.0]
)toml"},
    {"assembly.placement", R"toml([assembly.placement]
kind = "lattice"
counts = [4, 4]
spacing = [0.3, 0.3]
)toml"},
    {"joint", R"toml([[joint]]
kind = "hinge"
between = ["arm", "leg"]          # the end of each arm and the start of its leg
axis = [0.0, 1.0, 0.0]
stiffness = 1e3
damping = 0.1
torsional_stiffness = 1e-2

[[joint]]
kind = "spherical"
between = ["leg", "world"]
at = [1.0, 0.0]
stiffness = 1e3
)toml"},
    {"joint.motor", R"toml([joint.motor]
kind = "position"
value = "0.5*sin(6*t)"
stiffness = 1e-2
damping = 1e-4
most = 1e-2
)toml"},
    {"joint.about_second", R"toml([[joint]]
kind = "universal"
between = ["arm", "leg"]
axis = [1.0, 0.0, 0.0]
second_axis = [0.0, 1.0, 0.0]
stiffness = 1e3
torsional_stiffness = 1e-2
about_second = {spring = 1e-3, axis_damping = 1e-5}
)toml"},
    {"joint.about_second.motor", R"toml([[joint]]
kind = "universal"
between = ["arm", "leg"]
axis = [1.0, 0.0, 0.0]
second_axis = [0.0, 1.0, 0.0]
stiffness = 1e3
torsional_stiffness = 1e-2
about_second.motor = {kind = "force", value = "1e-4*sin(6*t)"}
)toml"},
    {"contact_pair", R"toml([[contact_pair]]
between = ["arm", "leg"]
law = "hertz"                     # law and friction have the same kind as in [contact]
stiffness = 2e3
friction = "memory"
static_friction = 0.6
)toml"},
    {"wall", R"toml([[wall]]
name = "floor"
kind = "plane"
point = [0.0, 0.0, 0.0]
normal = [0.0, 0.0, 1.0]
stiffness = 1e4

[[wall]]
name = "tube"
kind = "tube"
radius = 2.0
stiffness = 1e4
)toml"},
    {"wall.servo", R"toml([[wall]]
name = "lid"
kind = "plane"
point = [0.0, 0.0, 0.6]
normal = [0.0, 0.0, -1.0]
stiffness = 1e4
servo = {speed = 0.1, watch = "floor", area = 0.04, turn_back_above = 100.0, turn_forth_below = 10.0}
)toml"},
    {"obstacle", R"toml([[obstacle]]
name = "post"
kind = "sphere"
centre = [0.1, 0.1, 0.4]
radius = 0.04
)toml"},
    {"fluid_output", R"toml([[fluid_output]]
name = "middle"
kind = "slice"
every = 0.1
across = "y"
at = 0.0
fields = ["velocity", "pressure"]
)toml"},
    {"fluid_probe", R"toml([[fluid_probe]]
name = "wake"
at = [0.1, 0.1, 0.3]
)toml"},
    {"probe", R"toml([[probe]]
name = "tip"
of = "arm"
at = 1.0
quantity = "position"
)toml"},
    {"expect", R"toml([[expect]]
column = "kinetic_translation"
take = "end"
value = 0.0
scale = 1e-3
tolerance = 0.01
reference = "a state of rest"
)toml"},
    {"output", R"toml([output]
trajectory = 0.05
series = 0.01
audit = true
checkpoint = 0.5
)toml"},
    {"start", R"toml([start]
from = "out/first"                # the newest checkpoint of this run
time = "zero"
)toml"},
};

} // namespace

std::string_view example_of(std::string_view table) {
    const auto* const found = std::ranges::find(examples, table, &Example::table);
    return found == std::end(examples) ? std::string_view() : found->toml;
}

} // namespace skein
