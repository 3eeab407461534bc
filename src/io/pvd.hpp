// ParaView's list of the files of a series (.pvd): one per time. It is whole whenever someone looks: a new line goes
// over the closing tags, with new ones behind it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace skein {

class PvdFile {
public:
    struct Entry {
        double time;
        std::string file; ///< relative to the list
    };

    /// Goes on after `entries`. Nothing is written before write() or the first append().
    PvdFile(std::string path, const std::vector<Entry>& entries);
    /// Writes the whole list.
    void write();
    /// Throws IoError, with the list as it was.
    void append(const Entry& entry);

private:
    std::string path_;
    std::string text_; ///< all but the closing tags
    bool begun_ = false;
};

/// Whether a text is such a list of a run.
bool is_pvd_document(std::string_view text);

} // namespace skein
