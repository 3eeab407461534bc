// ParaView's list of the files of a series (.pvd), one for each time. Readers always find a complete list, because a
// new line and new closing tags overwrite the closing tags in one write.
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

    /// Continues after `entries`. The file is written by write() or the first append().
    PvdFile(std::string path, const std::vector<Entry>& entries);
    /// Writes the whole list.
    void write();
    /// Throws IoError and restores the list on failure.
    void append(const Entry& entry);

private:
    std::string path_;
    std::string text_; ///< list without the closing tags
    bool begun_ = false;
};

/// True if the text is a list that a run has written.
bool is_pvd_document(std::string_view text);

} // namespace skein
