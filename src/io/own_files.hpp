// Recognition of a run's own files in a directory. Other files are renamed if they are in the way, and never removed or
// overwritten.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace skein {

/// Folder of frames for ParaView in a run's directory.
inline const std::string frames_folder = "vtp/";

/// True for names that a run gives its files, such as trajectory_<12 digits>.h5, vtp/rods_<12 digits>.vtp or
/// observables.csv, and for their temporary and renamed forms.
bool is_result_name(std::string_view name);

/// Attribute `format` of an HDF5 file; empty if the file is unreadable or has none. Not collective.
std::string h5_format(const std::string& path);

/// True if the file may be an HDF5 file of `format` that a killed run left unfinished. Not collective.
bool is_unfinished(const std::string& path, const std::string& format);

/// First bytes of a file, up to `most`; absent if it is no regular file.
std::optional<std::string> beginning_of(const std::string& path, std::size_t most);
/// True for zeros only: a file begins with a hole until its first block is on the disk.
bool is_hole(std::string_view text);

/// Renames a file to `new_path`, with .2, .3, ... appended if that exists, and returns the new path.
std::string set_aside(const std::string& path, const std::string& new_path);

/// Renames a file at `path` that is not of `format`, before a file of `format` is written there.
void make_way(const std::string& path, const std::string& format);

} // namespace skein
