// Which files of a directory are a run's own, and how those that are in the way are put aside: nothing that a run did
// not write is ever removed or written over.
#pragma once

#include <string>
#include <string_view>

namespace skein {

/// Of frames for ParaView, in a run's directory.
inline const std::string frames_folder = "vtp/";

/// Whether a run gives files such a name: trajectory_<12 digits>.h5, observables.csv, their temporary and put aside
/// forms; those of its folder vtp/ with that before them.
bool is_result_name(std::string_view name);

/// The attribute `format` of an HDF5 file; empty where the file cannot be read or has none. For one rank alone.
std::string h5_format(const std::string& path);

/// Whether a file may be one of `format` that a killed run left half written. For one rank alone.
bool is_unfinished(const std::string& path, const std::string& format);

/// Renames a file to `new_path`, or to that with .2, .3, ... where something is there already; returns the path it has
/// now.
std::string set_aside(const std::string& path, const std::string& new_path);

/// Before `path` is written as a file of `format`: puts aside what is there and is none.
void make_way(const std::string& path, const std::string& format);

} // namespace skein
