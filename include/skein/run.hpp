// Skein within another program: scenes are read, stepped and inspected, on this process or on all ranks of
// MPI_COMM_WORLD. This header needs no other header of Skein, of MPI or of TBB. docs/embedding.md has a program.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

struct SceneSpec;

/// MPI for the life of the object, which must outlive all runs. MPI stays as it is if the program has initialised it
/// (with MPI_THREAD_FUNNELED at least).
class Session {
public:
    Session(int& argc, char**& argv);
    ~Session();
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    int rank() const;
    int ranks() const;

private:
    struct Mpi;
    std::unique_ptr<Mpi> mpi_;
};

/// Content of a scene file (docs/scene.md), checked.
class Scene {
public:
    /// Reads a scene. `overrides` are those of --set, e.g. "time.duration=10". Throws std::runtime_error with all
    /// faults, each with file, line and column.
    explicit Scene(const std::string& file, const std::vector<std::string>& overrides = {});
    /// Reads TOML from memory; `name` stands for the file in messages, and relative paths in it start there.
    static Scene from_text(const std::string& toml, const std::vector<std::string>& overrides = {},
                           const std::string& name = "scene");

private:
    friend class Run;
    explicit Scene(SceneSpec spec);
    std::shared_ptr<const SceneSpec> spec_;
};

struct RunSettings {
    /// Directory of results, as in `skein run --out`. With an empty one nothing is written, and run() must not be
    /// called.
    std::string out = {};
    /// True moves earlier results in `out` into a folder of their own and starts anew, instead of continuing.
    bool overwrite = false;
    int threads = 0; ///< threads per rank; 0: the cores that this process may use, divided among the ranks on them
    int lanes = 0;   ///< SIMD lanes: 1, 2, 4 or 8, with the same bits; 0: the most that this processor has
};

/// One rod at the time of the run, SI units.
struct RodState {
    std::string group;
    std::int64_t number;                                        ///< number in its group
    std::vector<std::array<double, 3>> position, velocity;      ///< [n + 1] nodes, lab, m and m/s
    std::vector<std::array<std::array<double, 3>, 3>> director; ///< [n] elements: d1, d2, d3, lab
    std::vector<std::array<double, 3>> spin;                    ///< [n] elements, along d1, d2, d3, rad/s
};

/// A group of a scene's rods, or of its bodies.
struct GroupInfo {
    std::string name;
    std::int64_t count; ///< number of rods in the whole scene
    int nodes;          ///< nodes of each rod; 1 for a body, its centre of mass
    int elements;       ///< elements of each rod; 1 for a body, whose axes are its directors
};

/// Quantities with three numbers at each node (position, velocity) or element (spin), or nine at each element
/// (director: d1, d2, d3).
enum class Quantity { position, velocity, director, spin };

/// Run of a scene. All ranks construct and call it alike, except for `rod`. Errors are thrown as std::runtime_error on
/// all ranks.
class Run {
public:
    explicit Run(const Scene& scene, const RunSettings& settings = {});
    ~Run();
    Run(Run&&) noexcept;
    Run& operator=(Run&&) noexcept;

    /// Plan of the run, as `skein plan -v` prints it.
    std::string plan() const;
    double dt() const;          ///< step, s
    std::int64_t steps() const; ///< steps of the whole scene
    std::int64_t step() const;  ///< steps made so far
    double time() const;        ///< time of the run, s
    bool finished() const;      ///< true where no more steps are made

    /// Makes steps until `until` have been made in all, at most those of the scene; writes nothing. Throws where rods
    /// have become invalid, naming rod, element and quantity.
    void advance(std::int64_t until);
    /// Runs to the scene's end with all outputs, as `skein run` does. Returns its exit code.
    int run();

    /// Digest of the present state of all rods: 16 hexadecimal digits, the same for any ranks, threads and lanes.
    std::string digest() const;
    /// Columns of observables.csv, with units, and their present values.
    std::vector<std::string> observable_names() const;
    std::vector<double> observables() const;

    /// All present contacts between rods, a line each, in the format of contacts_<step>.csv; empty in scenes without.
    std::string contacts() const;
    /// Points of a [[table]] of the scene.
    struct TablePoints {
        std::vector<double> at, value;
    };
    TablePoints table(const std::string& name) const;
    /// Makes the table go linearly from its last value to `value` at `until`, and stay there; formulas that name it
    /// follow. A scene with the final points makes the same run. Throws where there is no such table, where it is
    /// periodic or has points beyond the present time, or where `until` is not beyond it.
    void drive(const std::string& table, double until, double value);

    /// Puts these points in the place of a table's own: x rising, y. Formulas that name it at a place, such as `rod`,
    /// follow from the next step on, so that the points of a table by `rod` are numbers of single rods. Throws where
    /// there is no such table, or where points are none, not finite or do not rise.
    void set_table(const std::string& table, std::span<const double> at, std::span<const double> value);
    /// Returns these rods of a group to their start, with the memory of all that acts on them, while others go on.
    /// Joined rods do so together: give all of a copy. Contacts of these rods are forgotten. If rods may touch on
    /// several ranks, all ranks call this together, and each may name any rods. In other scenes a rank returns those of
    /// the named rods that it owns. Throws where rods feel a fluid or walls
    /// that they move, and in scenes with stages or time.tolerance.
    void restart(std::size_t group, std::span<const std::int64_t> rods);

    /// Name of the [[stage]] under way; empty in scenes without.
    std::string stage() const;
    /// Ends the stage now, at the present step. Throws where it is the last one.
    void next_stage();

    std::vector<GroupInfo> groups() const;
    /// Numbers in a group of the rods that this rank has, rising.
    std::vector<std::int64_t> numbers(std::size_t group) const;
    /// Reads values of these rods, rod by rod along each, at the time of the run: SI units, lab frame, spin along the
    /// directors. It is not collective.
    void read(std::size_t group, Quantity quantity, std::span<double> out) const;

    /// Number of rods that this rank has, in no particular choice.
    std::size_t rods() const;
    /// State of rod i, i < rods(). It is not collective.
    RodState rod(std::size_t i) const;

private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

} // namespace skein
