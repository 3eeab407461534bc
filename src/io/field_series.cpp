#include "io/field_series.hpp"

#include "io/disk.hpp"
#include "io/files.hpp"
#include "io/own_files.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>

namespace skein {

namespace {

constexpr std::string_view format_name = "skein fields", prefix = "fields_", suffix = ".h5";

std::string file_of(std::int64_t step) { return fmt::format("{}{:012d}{}", prefix, step, suffix); }

/// Steps of the frames in a directory, rising.
std::vector<std::int64_t> steps_in(const std::string& directory) {
    std::vector<std::int64_t> steps;
    for (const auto& entry : std::filesystem::directory_iterator(directory)) {
        const std::string name = entry.path().filename().string();
        if (!name.starts_with(prefix) || !name.ends_with(suffix) || !is_result_name(name)) continue;
        steps.push_back(std::stoll(name.substr(prefix.size())));
    }
    std::sort(steps.begin(), steps.end());
    return steps;
}

} // namespace

FieldSeries::FieldSeries(const Communicator& comm, std::string directory, FieldGrid grid, double dt, double shift)
    : comm_(comm), directory_(std::move(directory)), grid_(grid), dt_(dt), shift_(shift) {}

void FieldSeries::write(std::int64_t step, const std::vector<CellField>& fields) {
    const std::string path = directory_ + "/" + file_of(step), temporary = path + ".tmp", format(format_name);
    const auto [nx, ny, nz] = grid_.cells;
    std::uint64_t numbers = 0;
    for (const CellField& field : fields)
        numbers += static_cast<std::uint64_t>(field.components) * static_cast<std::uint64_t>(nx) * static_cast<std::uint64_t>(ny) *
                   static_cast<std::uint64_t>(nz);
    on_root(comm_, [&] {
        require_space(directory_, numbers * sizeof(float));
        make_way(temporary, format);
    });
    {
        H5File file(comm_, temporary, H5File::Mode::create);
        file.reserve(numbers * sizeof(float));
        file.set("/", "format", format);
        file.set("/", "step", step);
        file.set("/", "time", shift_ + static_cast<double>(step) * dt_);
        file.set("/", "spacing", grid_.spacing);
        for (const CellField& field : fields) {
            std::vector<std::uint64_t> shape{static_cast<std::uint64_t>(nz), static_cast<std::uint64_t>(ny),
                                             static_cast<std::uint64_t>(nx)};
            if (field.components > 1) shape.push_back(static_cast<std::uint64_t>(field.components));
            file.make_dataset("/" + field.name, H5Type::float32, shape);
            file.set("/" + field.name, "unit", field.unit);
            H5Box box{std::vector<std::uint64_t>(shape.size(), 0), shape};
            box.start[0] = static_cast<std::uint64_t>(grid_.first_plane), box.count[0] = static_cast<std::uint64_t>(grid_.planes);
            file.write("/" + field.name, H5Type::float32, box, field.value.data());
        }
        file.close();
    }
    on_root(comm_, [&] {
        make_way(path, format);
        publish(temporary, path);
        write_file(directory_ + "/fields.xdmf", document(fields));
    });
}

std::string FieldSeries::document(const std::vector<CellField>& fields) const {
    const auto [nx, ny, nz] = grid_.cells;
    std::string text = "<?xml version=\"1.0\" ?>\n<Xdmf Version=\"3.0\">\n<Domain>\n<Grid Name=\"fluid\" GridType=\"Collection\" "
                       "CollectionType=\"Temporal\">\n";
    for (const std::int64_t step : steps_in(directory_)) {
        text += fmt::format(
            "<Grid Name=\"fluid\" GridType=\"Uniform\">\n<Time Value=\"{:.17g}\"/>\n<Topology TopologyType=\"3DCoRectMesh\" "
            "Dimensions=\"{} {} {}\"/>\n<Geometry GeometryType=\"ORIGIN_DXDYDZ\">\n",
            shift_ + static_cast<double>(step) * dt_, nz + 1, ny + 1, nx + 1);
        for (const Vec3d& v : {grid_.lower, Vec3d{grid_.spacing, grid_.spacing, grid_.spacing}})
            text += fmt::format("<DataItem Dimensions=\"3\" NumberType=\"Float\" Precision=\"8\" Format=\"XML\">{:.17g} {:.17g} "
                                "{:.17g}</DataItem>\n",
                                v.z, v.y, v.x);
        text += "</Geometry>\n";
        for (const CellField& field : fields)
            text += fmt::format("<Attribute Name=\"{}\" AttributeType=\"{}\" Center=\"Cell\">\n<DataItem Dimensions=\"{} {} {}{}\" "
                                "NumberType=\"Float\" Precision=\"4\" Format=\"HDF\">{}:/{}</DataItem>\n</Attribute>\n",
                                field.name, field.components == 3 ? "Vector" : "Scalar", nz, ny, nx,
                                field.components == 3 ? " 3" : "", file_of(step), field.name);
        text += "</Grid>\n";
    }
    return text + "</Grid>\n</Domain>\n</Xdmf>\n";
}

} // namespace skein
