// Walls that rods touch: planes, tubes, balls, and boxes, which are planes. They are at rest, move steadily or are
// driven by a servo. wall_pass.hpp has their forces on rods. (A clamp's wall is another thing: mechanics/elastic.hpp.)
#pragma once

#include "contact/contact_law.hpp"

#include <string>
#include <vector>

namespace skein {

enum class WallKind { plane, tube, ball, box };
inline constexpr std::string_view wall_names[] = {"plane", "tube", "ball", "box"};
enum class WallSide { inside, outside };
inline constexpr std::string_view wall_side_names[] = {"inside", "outside"};
/// Part of a rod that touches a wall: its surface, round at the ends, or its axis. A leg that is cut off flat touches
/// with its axis.
enum class WallTouch { surface, axis };
inline constexpr std::string_view wall_touch_names[] = {"surface", "axis"};

/// A wall that goes forth until a watched wall is pressed, back until it is relieved, and so on (servo.hpp). None where
/// speed is 0.
struct ServoSpec {
    double speed = 0;            ///< m/s
    std::string watch;           ///< wall whose stress decides
    double area = 0;             ///< m^2
    double turn_back_above = 0;  ///< Pa
    double turn_forth_below = 0; ///< Pa
    double not_before = -1e9;    ///< m
    long cycles = 0;             ///< 0: without end
    double average = 0;          ///< s; 0: the stress of each step decides
    double approach = 0;         ///< m/s, until something touches the wall or it has come to:
    double approach_to = 0;      ///< m
    bool ends_run = false;       ///< with its last cycle

    bool drives() const { return speed > 0; }
    void fields(FieldVisitor& f);
};

struct Wall {
    std::string name;
    WallKind kind = WallKind::plane;
    Vec3d point{0, 0, 0};  ///< on a plane, on a tube's axis, a ball's centre; m
    Vec3d normal{0, 0, 1}; ///< normal of a plane, towards the rods
    Vec3d axis{0, 0, 1};   ///< direction of a tube
    double radius = 0;     ///< radius of a tube or ball, m
    WallSide side = WallSide::inside;
    Vec3d lower{0, 0, 0}, upper{0, 0, 0}; ///< corners of a box, m
    std::vector<std::string> open;        ///< sides that a box lacks
    std::vector<std::string> rods;        ///< groups it acts on; empty: all
    WallTouch touches = WallTouch::surface;
    bool allow_overlap = false; ///< at the start, by more than 0.1 of the diameter
    Vec3d velocity{0, 0, 0};    ///< m/s
    double from = 0;            ///< s: when it begins to move
    ContactLaw law;
    ServoSpec servo;
    std::vector<std::string> stages; ///< in which it stands; empty: all
    bool stands = true;              ///< in the present stage
    Vec3d moved{0, 0, 0};            ///< m: where stages before have moved it
    std::string source;              ///< file:line of the table, for messages

    bool moves_steadily() const { return !servo.drives() && dot(velocity, velocity) > 0; }
    bool acts_on(const std::string& group) const;
    void fields(FieldVisitor& f);
};

/// Displacement and velocity of a wall since the start.
struct WallState {
    Vec3d offset{0, 0, 0};   ///< m
    Vec3d velocity{0, 0, 0}; ///< m/s
};

/// Sides that a box has, in order; open or not.
inline constexpr std::string_view box_side_names[] = {"x-", "x+", "y-", "y+", "z-", "z+"};
/// True where a box has that side.
bool has_side(const Wall& box, std::string_view side);

/// The walls of a scene without boxes, directions of length 1: their planes, named after the box and the side ("box
/// z-"). Throws InputError where numbers contradict each other.
std::vector<Wall> expanded(const std::vector<Wall>& walls);

/// Walls of a scene, shared by passes and the interaction of walls. The latter sets the states of driven walls after
/// each step.
struct Walls {
    std::vector<Wall> wall;
    std::vector<WallState> state; ///< one per wall, of driven ones
    double state_time = 0;        ///< s: of these states, the middle of the present step

    Walls() = default;
    explicit Walls(const std::vector<Wall>& scene) : wall(expanded(scene)), state(wall.size()) {}

    std::size_t count() const { return wall.size(); }
    /// Place of wall w at `time`: by its velocity if it is steady, else by its state.
    WallState at(std::size_t w, double time) const;
    /// The same, with driven walls that go on within the present step.
    WallState within_step(std::size_t w, double time) const;
    /// Number of the wall of that name, or -1.
    int find(const std::string& name) const;
};

} // namespace skein
