// Objects of one HDF5 file. Links to other files are not followed, and numbers in other files are not read. Foreign
// files of results or rods could otherwise show any file of this machine.
#pragma once

#include "io/h5_handle.hpp"

#include <string>

namespace skein {

/// Access to a dataset or to the object of an attribute by links within the file. A call that would follow a link out
/// of the file fails and sets `outside`, which must outlive the handle, to its target.
H5Handle own_links(hid_t property_class, std::string& outside);

/// Opens a dataset whose numbers are in the file itself. The handle is invalid without one; `outside` names another
/// file that has the numbers.
H5Handle open_own_dataset(hid_t file, const std::string& path, std::string& outside);

} // namespace skein
