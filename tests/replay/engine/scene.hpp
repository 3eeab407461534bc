// The systems of a reference file and a step of all of them: first every system moves, then the external loads act in
// the order of the file, within one system or between two, then every system is kicked.
#pragma once

#include "fields.hpp"
#include "plane_friction.hpp"

#include <variant>

namespace skein::replay {

class Scene {
public:
    /// Throws InputError, NotBuilt.
    Scene(const Entry& file, const Stepping& stepping);
    Scene(const Scene&) = delete;

    /// Whole steps.
    void run(std::span<const Step> steps);
    /// Of every system at the end of the last step; none of a plane. `lag`: how far positions are behind, s.
    std::vector<Fields> fields(double lag, double time) const;
    double largest_inv_length() const; ///< over all elements, 1/m; 0 without rods
    /// Largest stiffness of an element, N, where an external load answers internal ones (of two rods, of a plane); else
    /// 0.
    double answering_stiffness() const;

private:
    using System = std::variant<Rod, RigidBody, Plane>;
    using Load = std::function<void(const Step&)>;

    Load load_of(const Entry& entry);
    Load load_on_rod(const Entry& entry, Rod& rod);
    void clear_loads();

    std::size_t place(const Entry& system) const {
        return static_cast<std::size_t>(system.index(static_cast<int>(systems_.size())));
    }
    template <class Kind> Kind& system(const Entry& number, const char* what);
    Rod& open_rod(const Entry& number);

    std::vector<System> systems_; ///< as in the file; what follows refers to them
    std::vector<RodProgram> rods_;
    std::vector<BodyProgram> bodies_;
    TilePasses<1> passes_; ///< of loads on one rod
    std::vector<Load> loads_;
    bool answers_ = false; ///< a load reads internal loads
    std::int64_t step_ = 0;
};

} // namespace skein::replay
