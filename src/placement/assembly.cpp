#include "skein/placement/assembly.hpp"

#include "core/hash.hpp"
#include "skein/placement/places.hpp"

namespace skein {

void AssemblySpec::fields(FieldVisitor& f) {
    f.visit({.name = "name", .text = "name of the assembly, for the key `assembly` of its groups", .required = true},
            name);
    f.table({.name = "placement"}, placement);
    f.visit({.name = "scatter",
             .unit = "m",
             .text = "largest random displacement of each copy, in either direction, lab frame"},
            scatter);
    f.visit({.name = "magnetisation_scatter",
             .unit = "-",
             .text = "largest random relative change of the magnetisation's strength from copy to copy",
             .at_least = 0,
             .at_most = 1},
            magnetisation_scatter);
    f.visit({.name = "seed", .unit = "-", .text = "seed of the random numbers", .at_least = 0}, seed);
}

double even_random(long seed, std::int64_t number) {
    const std::uint64_t h = hash_end(hash_begin(number) ^ detail::hash_mixed(static_cast<std::uint64_t>(seed) + 1));
    return 0x1p-52 * static_cast<double>(h >> 11) - 1;
}

AssemblyCopies copies_of(const AssemblySpec& spec, int number, const std::string& directory) {
    const Places places(spec.placement, spec.source, directory);
    const Quaterniond frame = places.turned() ? no_turn : frame_of(spec.placement.tangent, spec.placement.normal);
    AssemblyCopies copies{.number = number, .origins = {}, .turns = {}};
    for (std::int64_t c = 0; c < places.count(); ++c) {
        const auto moved = [&](int axis) { return even_random(spec.seed, 4 * c + axis); };
        copies.origins.push_back(places.origin(c) + scale(spec.scatter, Vec3d{moved(0), moved(1), moved(2)}));
        if (spec.magnetisation_scatter > 0) copies.magnetisation.push_back(1 + spec.magnetisation_scatter * moved(3));
        copies.turns.push_back(places.turned() ? places.turn(c) : frame);
    }
    const auto unturned = [](const Quaterniond& q) { return q.w == 1; };
    if (std::all_of(copies.turns.begin(), copies.turns.end(), unturned)) copies.turns.clear();
    return copies;
}

} // namespace skein
