// Skein within another program: a scene read, stepped and looked at, on this process or on all ranks of MPI_COMM_WORLD.
// Nothing here shows how it is done: no other header of Skein, of MPI or of TBB is needed. docs/embedding.md has a
// program.
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

/// MPI for the life of the object, which outlives all runs. Where the program has initialised MPI itself (with
/// MPI_THREAD_FUNNELED at least) it stays as it is.
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

/// What a scene file says (docs/scene.md), checked.
class Scene {
public:
    /// `overrides`: as those of --set, e.g. "time.duration=10". Throws std::runtime_error with all that is wrong, each
    /// with file, line and column.
    explicit Scene(const std::string& file, const std::vector<std::string>& overrides = {});
    /// Of TOML in memory; `name` stands for the file in messages, and relative paths in it start there.
    static Scene from_text(const std::string& toml, const std::vector<std::string>& overrides = {},
                           const std::string& name = "scene");

private:
    friend class Run;
    explicit Scene(SceneSpec spec);
    std::shared_ptr<const SceneSpec> spec_;
};

struct RunSettings {
    std::string out =
        {}; ///< directory of results, as `skein run --out` has it; empty: nothing is written, and run() not called
    bool overwrite =
        false;       ///< put earlier results in `out` into a folder of their own and start anew, instead of going on
    int threads = 0; ///< per rank; 0: the cores that this process may use, shared among the ranks on them
    int lanes = 0;   ///< SIMD lanes: 1, 2, 4 or 8, the same bits; 0: the most that this processor has
};

/// One rod at the time of the run, SI units.
struct RodState {
    std::string group;
    std::int64_t number;                                        ///< in its group
    std::vector<std::array<double, 3>> position, velocity;      ///< of the n + 1 nodes, lab
    std::vector<std::array<std::array<double, 3>, 3>> director; ///< d1, d2, d3 of the n elements, lab
    std::vector<std::array<double, 3>> spin;                    ///< of the elements, along d1, d2, d3, rad/s
};

/// A group of a scene's rods, or of its bodies.
struct GroupInfo {
    std::string name;
    std::int64_t count; ///< of the whole scene
    int nodes;          ///< of each; 1 of a body, its centre of mass
    int elements;       ///< of each; 1 of a body, whose axes are its directors
};

/// Three numbers at each node (position, velocity) or element (spin), nine at each element (director: d1, d2, d3).
enum class Quantity { position, velocity, director, spin };

/// A run of a scene. All ranks make and call it alike, but for `rod`. Errors are thrown as std::runtime_error on all of
/// them.
class Run {
public:
    explicit Run(const Scene& scene, const RunSettings& settings = {});
    ~Run();
    Run(Run&&) noexcept;
    Run& operator=(Run&&) noexcept;

    /// What it does, as `skein plan` prints it.
    std::string plan() const;
    double dt() const;          ///< s
    std::int64_t steps() const; ///< of the whole scene
    std::int64_t step() const;  ///< that have been made
    double time() const;        ///< s

    /// Makes steps until so many have been made in all, at most those of the scene; writes nothing. Throws where rods
    /// have become invalid, naming rod, element and quantity.
    void advance(std::int64_t until);
    /// To the scene's end with all outputs, as `skein run` does. Returns its exit code.
    int run();

    /// Of the present state of all rods: 16 hexadecimal digits, the same for any ranks, threads and lanes.
    std::string digest() const;
    /// Columns of observables.csv, with units, and their values now.
    std::vector<std::string> observable_names() const;
    std::vector<double> observables() const;

    /// Every contact between rods now, a line each, as contacts_<step>.csv has them; empty in scenes without.
    std::string contacts() const;
    /// Points of a [[table]] of the scene.
    struct TablePoints {
        std::vector<double> at, value;
    };
    TablePoints table(const std::string& name) const;
    /// From now on the table goes linearly from its last value to `value` at `until`, and stays there; formulas that
    /// name it follow. A scene with the points that it has in the end makes the same run. Throws where there is no such
    /// table, where it is periodic or has points beyond the present time, or where `until` is not beyond it.
    void drive(const std::string& table, double until, double value);

    std::vector<GroupInfo> groups() const;
    /// Numbers in a group of the rods that this rank has, rising.
    std::vector<std::int64_t> numbers(std::size_t group) const;
    /// Values of these rods, rod by rod along each, at the time of the run: SI units, lab frame, spin along the
    /// directors. Not collective.
    void read(std::size_t group, Quantity quantity, std::span<double> out) const;

    /// Rods that this rank has; which ones is its own affair.
    std::size_t rods() const;
    /// Rod i of them, i < rods(). Not collective.
    RodState rod(std::size_t i) const;

private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

} // namespace skein
