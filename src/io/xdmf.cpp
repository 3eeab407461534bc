#include "io/xdmf.hpp"

#include <fmt/format.h>

#include <string_view>

namespace skein {

namespace {

constexpr std::string_view document_begin = "<?xml version=\"1.0\" ?>\n<Xdmf Version=\"3.0\">\n<Domain>\n";

std::string escaped(std::string_view text) {
    std::string out;
    for (const char c : text) {
        switch (c) {
        case '&':
            out += "&amp;";
            break;
        case '<':
            out += "&lt;";
            break;
        case '>':
            out += "&gt;";
            break;
        case '"':
            out += "&quot;";
            break;
        default:
            out += c;
        }
    }
    return out;
}

/// XML of one frame of one group.
class Frame {
public:
    Frame(const XdmfGroup& group, const XdmfSegment& segment, std::size_t frame, int number_bytes)
        : group_(group), segment_(segment), frame_(frame), number_bytes_(number_bytes) {}

    std::string grid(const std::string& time) const {
        std::string xml = fmt::format("<Grid Name=\"{}\" GridType=\"Uniform\">\n{}", escaped(group_.name), time);
        xml += fmt::format(
            "<Topology TopologyType=\"{}\" NodesPerElement=\"{}\" NumberOfElements=\"{}\">\n{}</Topology>\n",
            group_.nodes == 1 ? "Polyvertex" : "Polyline", group_.nodes, group_.rods,
            item("connectivity", rods_nodes(), "Int", 8));
        xml += fmt::format("<Geometry GeometryType=\"XYZ\">\n{}</Geometry>\n", frame_item("position"));
        xml += attribute("radius", "Scalar", "Node", item("point_radius", rods_nodes(), "Float", 8));
        if (group_.normals) xml += attribute("normal", "Vector", "Node", frame_item("normal"));
        xml += attribute("rod", "Scalar", "Cell", item("rod", fmt::format("{} 1", group_.rods), "Int", 8));
        if (group_.magnetised)
            xml += attribute("magnetisation", "Vector", "Cell",
                             item("magnetisation", fmt::format("{} 3", group_.rods), "Float", 8));
        return xml + "</Grid>\n";
    }

private:
    static std::string attribute(std::string_view name, std::string_view type, std::string_view centre,
                                 const std::string& data) {
        return fmt::format("<Attribute Name=\"{}\" AttributeType=\"{}\" Center=\"{}\">\n{}</Attribute>\n", name, type,
                           centre, data);
    }
    std::string rods_nodes() const { return fmt::format("{} {}", group_.rods, group_.nodes); }
    std::string item(std::string_view dataset, const std::string& dimensions, std::string_view type, int bytes) const {
        return fmt::format("<DataItem Dimensions=\"{}\" NumberType=\"{}\" Precision=\"{}\" "
                           "Format=\"HDF\">{}:/groups/{}/{}</DataItem>\n",
                           dimensions, type, bytes, escaped(segment_.file), escaped(group_.name), dataset);
    }
    /// Item of vectors at nodes in this frame.
    std::string frame_item(std::string_view dataset) const {
        return item(fmt::format("frames/{}/{}", frame_, dataset), rods_nodes() + " 3", "Float", number_bytes_);
    }

    const XdmfGroup& group_;
    const XdmfSegment& segment_;
    std::size_t frame_;
    int number_bytes_;
};

std::string frame_grids(std::span<const XdmfGroup> groups, const XdmfSegment& segment, std::size_t frame,
                        int number_bytes) {
    const std::string time = fmt::format("<Time Value=\"{:.17g}\"/>\n", segment.times[frame]);
    if (groups.size() == 1) return Frame(groups[0], segment, frame, number_bytes).grid(time);
    std::string xml = "<Grid Name=\"rods\" GridType=\"Collection\" CollectionType=\"Spatial\">\n" + time;
    for (const XdmfGroup& group : groups) xml += Frame(group, segment, frame, number_bytes).grid("");
    return xml + "</Grid>\n";
}

} // namespace

std::string xdmf_document(const std::string& title, std::span<const XdmfGroup> groups,
                          std::span<const XdmfSegment> segments, int number_bytes) {
    std::string xml(document_begin);
    xml += fmt::format("<Grid Name=\"{}\" GridType=\"Collection\" CollectionType=\"Temporal\">\n", escaped(title));
    for (const XdmfSegment& segment : segments)
        for (std::size_t frame = 0; frame < segment.times.size(); ++frame)
            xml += frame_grids(groups, segment, frame, number_bytes);
    return xml + "</Grid>\n</Domain>\n</Xdmf>\n";
}

bool is_xdmf_document(std::string_view text) { return text.starts_with(document_begin); }

} // namespace skein
