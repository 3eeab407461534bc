// ParaView's list of the files of a series (.pvd): one per time. It is whole whenever someone looks: a new line goes over the
// closing tags, with new ones behind it.
#pragma once

#include <string>
#include <vector>

namespace skein {

class PvdFile {
public:
    struct Entry {
        double time;
        std::string file; ///< relative to the list
    };

    explicit PvdFile(std::string path) : path_(std::move(path)) {}
    /// Writes the list anew, with these entries.
    void restart(const std::vector<Entry>& entries);
    void append(const Entry& entry);

private:
    std::string path_;
    std::string text_; ///< all but the closing tags
};

} // namespace skein
