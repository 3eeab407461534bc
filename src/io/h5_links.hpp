// Objects of an HDF5 file, and of no other: links that lead out of it are not followed, and numbers that lie in other
// files are not read. A file of results or of rods that came from elsewhere could otherwise show any file of this
// machine.
#pragma once

#include "io/h5_handle.hpp"

#include <string>

namespace skein {

/// Access to a dataset or to the object of an attribute, by links within the file alone. Where a link leads out of it,
/// `outside` (which has to outlive the handle) says where to, and the call that would follow it fails.
H5Handle own_links(hid_t property_class, std::string& outside);

/// Opens a dataset whose numbers lie in the file itself; invalid where there is none, or they do not, which `outside`
/// says then.
H5Handle open_own_dataset(hid_t file, const std::string& path, std::string& outside);

} // namespace skein
