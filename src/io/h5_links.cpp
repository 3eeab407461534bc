#include "io/h5_links.hpp"

#include <fmt/format.h>

#include <array>
#include <string_view>

namespace skein {

namespace {

herr_t refuse_link(const char*, const char*, const char* file, const char* object, unsigned*, hid_t, void* outside) {
    *static_cast<std::string*>(outside) =
        fmt::format("a link to '{}' in another file, '{}', is not followed", object, file);
    return -1;
}

/// Name of another file that has numbers of `dataset`; empty without one.
std::string other_file(hid_t dataset) {
    const H5Handle creation(H5Dget_create_plist(dataset), H5Pclose);
    std::array<char, 1024> name{};
    if (H5Pget_layout(creation) == H5D_VIRTUAL) {
        std::size_t count = 0;
        if (H5Pget_virtual_count(creation, &count) < 0) return "?";
        for (std::size_t i = 0; i < count; ++i) {
            if (H5Pget_virtual_filename(creation, i, name.data(), name.size()) < 0) return "?";
            if (std::string_view(name.data()) != ".") return name.data();
        }
    }
    if (H5Pget_external_count(creation) > 0) {
        H5Pget_external(creation, 0, name.size() - 1, name.data(), nullptr, nullptr);
        return name.data();
    }
    return {};
}

} // namespace

H5Handle own_links(hid_t property_class, std::string& outside) {
    H5Handle access(H5Pcreate(property_class), H5Pclose);
    H5Pset_elink_cb(access, refuse_link, &outside);
    return access;
}

H5Handle open_own_dataset(hid_t file, const std::string& path, std::string& outside) {
    outside.clear();
    const H5Handle access = own_links(H5P_DATASET_ACCESS, outside);
    H5Handle dataset(H5Dopen2(file, path.c_str(), access), H5Dclose);
    if (!dataset.valid()) return dataset;
    const std::string other = other_file(dataset);
    if (other.empty()) return dataset;
    outside = fmt::format("its data is in another file, '{}', which is not read", other);
    return {-1, H5Dclose};
}

} // namespace skein
