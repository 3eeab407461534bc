#include "contact/contact_energy.hpp"

namespace skein {

namespace {

constexpr double Vec3d::*axes[3] = {&Vec3d::x, &Vec3d::y, &Vec3d::z};

/// Nodes on which the energy depends.
void find_nodes(const PairEnergy<double>& pair, ContactResponse& out) {
    out.nodes = 0;
    const auto add = [&](int element, int place) { out.node[out.nodes++] = {element, place, {0, 0, 0}}; };
    for (const int i : {0, 1})
        for (const int place : {1, 2}) add(i, place);
    for (const int i : {0, 1})
        for (const bool end : {false, true})
            if (pair.bends(i, end)) add(i, end ? 3 : 0);
}

/// Forces and stiffness of `nodes` nodes, from derivatives by the places of all but the first, as the energy does not
/// change with a translation.
template <int nodes>
void differentiate(NormalLaw law, const ContactElement<double> (&element)[2], ContactResponse& out) {
    constexpr int N = 3 * (nodes - 1);
    using T = SecondOrder<N>;
    ContactElement<T> moving[2];
    for (const int i : {0, 1}) {
        const ContactElement<double>& e = element[i];
        moving[i].radius = e.radius;
        for (const int end : {0, 1}) moving[i].joined[end] = e.joined[end];
        for (int place = 0; place < 4; ++place) {
            const Vec3d& x = e.node[place];
            moving[i].node[place] = {T(x.x), T(x.y), T(x.z)};
        }
    }
    for (int n = 1; n < nodes; ++n) {
        Vec3<T>& x = moving[out.node[n].element].node[out.node[n].place];
        const int first = 3 * (n - 1);
        x = {T::unknown(first, x.x.value()), T::unknown(first + 1, x.y.value()), T::unknown(first + 2, x.z.value())};
    }
    const T energy = PairEnergy<T>(law, moving).energy();
    out.energy = energy.value();
    for (int i = 0; i < N; ++i) {
        out.node[1 + i / 3].force.*axes[i % 3] = -energy.slope(i);
        out.node[0].force.*axes[i % 3] += energy.slope(i);
    }
    for (int i = 0; i < 3 * nodes; ++i)
        for (int j = 0; j < 3; ++j) out.stiffness[j][i] = out.stiffness[i][j] = 0;
    for (int i = 0; i < N; ++i)
        for (int j = 0; j < N; ++j) {
            const double k = energy.curvature(i, j);
            out.stiffness[3 + i][3 + j] = k;
            out.stiffness[i % 3][3 + j] -= k;
            out.stiffness[3 + i][j % 3] -= k;
            out.stiffness[i % 3][j % 3] += k;
        }
}

} // namespace

bool respond(NormalLaw law, const ContactElement<double> (&element)[2], ContactResponse& out) {
    PairEnergy<double> pair(law, element);
    out.overlap = pair.overlap();
    if (!(out.overlap > 0)) return false;
    pair.energy();
    for (const int i : {0, 1}) out.share[i] = pair.share(i);
    find_nodes(pair, out);
    switch (out.nodes) {
    case 4:
        differentiate<4>(law, element, out);
        break;
    case 5:
        differentiate<5>(law, element, out);
        break;
    case 6:
        differentiate<6>(law, element, out);
        break;
    case 7:
        differentiate<7>(law, element, out);
        break;
    default:
        differentiate<8>(law, element, out);
    }
    return true;
}

} // namespace skein
