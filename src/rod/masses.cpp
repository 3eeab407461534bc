#include "rod/masses.hpp"

#include "rod/end_weights.hpp"
#include "rod/time_limits.hpp"

#include <algorithm>

namespace skein {

double nodal_density(const RodSpec& spec, const Sections& sections) {
    const bool weighted = takes_end_weights(spec) && (weighs_masses(spec.start) || weighs_masses(spec.end));
    double inverse_mass = weighted ? inverse_mass_of_ends() : 1; // largest 1/m + 1/m' over that of halves
    for (std::size_t k = 0; sections.vary() && k < to_index(spec.shape.elements); ++k) {
        const double before = sections.mass_share_before(k);
        inverse_mass = std::max(inverse_mass, 0.25 / (before * (1 - before)));
    }
    return spec.material.density / inverse_mass;
}

std::vector<double> rotary_inertia_scales(const RodGroup& group) {
    const Material& m = group.spec().material;
    std::vector<double> scales;
    if (m.rotary_inertia_for_dt > 0) scales = rotary_inertia_for(group, m.rotary_inertia_for_dt);
    else if (m.rotary_inertia_scale > 1) scales.assign(group.element.size(), m.rotary_inertia_scale);
    const bool scaled = std::any_of(scales.begin(), scales.end(), [](double j) { return j > 1; });
    return scaled ? scales : std::vector<double>{};
}

void scale_rotary_inertia(ElementConstants& c, double j) {
    c.inertia = {j * c.inertia.x, j * c.inertia.y, c.inertia.z};
    c.inv_inertia = {1 / c.inertia.x, 1 / c.inertia.y, c.inv_inertia.z};
    c.inertia_ratio = c.inertia.z / c.inertia.x;
}

void divide_among_nodes(const RodSpec& spec, const Sections& sections, const std::vector<ElementConstants>& element,
                        std::vector<double>& node_mass, std::vector<double>& node_length) {
    node_mass.assign(element.size() + 1, 0.0);
    node_length.assign(element.size() + 1, 0.0);
    for (std::size_t k = 0; k < element.size(); ++k) {
        const auto divide = [k](std::vector<double>& of_node, double whole, double share_before) {
            const double before = share_before * whole;
            of_node[k] += before;
            of_node[k + 1] += whole - before;
        };
        divide(node_mass, spec.material.density * element[k].volume, sections.mass_share_before(k));
        divide(node_length, element[k].rest_length, 0.5);
    }
    for (std::vector<double>* of_node : {&node_mass, &node_length}) {
        if (!spec.shape.closed) continue;
        of_node->front() += of_node->back();
        of_node->back() = 0;
    }
    with_end_weights(spec, weighs_masses, [&](std::size_t i, double weight) {
        node_mass[i] *= weight;
        node_length[i] *= weight;
    });
}

} // namespace skein
