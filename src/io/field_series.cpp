#include "io/field_series.hpp"

#include "io/disk.hpp"
#include "io/files.hpp"
#include "io/frame_files.hpp"
#include "io/own_files.hpp"
#include "io/segments.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace skein {

namespace {

constexpr std::string_view fields_format = "skein fields";
constexpr const char *frames = ".h5", *documents = ".xdmf";

std::uint64_t product(const std::vector<std::uint64_t>& shape) {
    return std::accumulate(shape.begin(), shape.end(), std::uint64_t{1}, std::multiplies<>());
}

/// Digest of a box: part of the dataset's word_digest().
std::uint64_t box_digest(const void* numbers, std::size_t word, const std::vector<std::uint64_t>& shape,
                         const H5Box& box) {
    std::size_t inner = shape.size(); // the box is contiguous in dimensions from here on
    std::uint64_t run = 1, below = 1; // words of the box and of the dataset in these dimensions
    while (inner > 0 && run == below) {
        run *= box.count[--inner];
        below *= shape[inner];
    }
    const std::uint64_t runs = run > 0 ? product(box.count) / run : 0;
    const auto* bytes = static_cast<const std::byte*>(numbers);
    std::uint64_t sum = 0;
    for (std::uint64_t r = 0; r < runs; ++r) {
        std::uint64_t rest = r, stride = below, first = 0;
        for (std::size_t d = shape.size(), within = 1; d-- > 0;) {
            if (d < inner) {
                first += (box.start[d] + rest % box.count[d]) * stride;
                rest /= box.count[d];
                stride *= shape[d];
            } else {
                first += box.start[d] * within;
                within *= shape[d];
            }
        }
        sum += word_digest({bytes + r * run * word, run * word}, word, first);
    }
    return sum;
}

bool is_sound_frame(const FrameFile& frame) {
    const H5File file(Communicator::alone(), frame.path, H5File::Mode::read);
    if (file.get<std::string>("/", "format") != fields_format || file.get<std::int64_t>("/", "step") != frame.step)
        return false;
    for (const char* name : {"/lower", "/velocity", "/vorticity", "/q", "/pressure"}) {
        if (!file.has(name) || !file.has(name, "digest")) continue; // earlier programs wrote no digest
        if (dataset_digest(file, name) != file.get<std::uint64_t>(name, "digest")) return false;
    }
    return true;
}

/// Ending of names of datasets that show a block.
std::string suffix_of(std::size_t block) { return fmt::format("_{}", block); }
constexpr std::uint64_t view_bytes = 1 << 10;

std::string document(const std::string& grids) {
    return "<?xml version=\"1.0\" ?>\n<Xdmf Version=\"3.0\" xmlns:xi=\"http://www.w3.org/2001/XInclude\">\n<Domain>\n" +
           grids + "</Domain>\n</Xdmf>\n";
}

/// Numbers of cells as a dataset [z][y][x] has them.
std::vector<std::uint64_t> extents(const std::array<int, 3>& cells) {
    return {to_index(cells[2]), to_index(cells[1]), to_index(cells[0])};
}

std::string collection(const char* type, const std::string& grids) {
    return fmt::format("<Grid Name=\"fluid\" GridType=\"Collection\" CollectionType=\"{}\">\n{}</Grid>\n", type, grids);
}

} // namespace

FieldSeries::FieldSeries(const Communicator& comm, Names names, FieldGrid grid, Precision precision, double dt,
                         double shift, const EarlierFrames& earlier)
    : comm_(comm), names_(std::move(names)), grid_(grid),
      type_(precision == Precision::single ? H5Type::float32 : H5Type::float64), dt_(dt), shift_(shift) {
    last_step_ = check_frames(comm_, {name_of(names_.name), names_.directory, prefix(), frames}, earlier,
                              is_sound_frame, [this](const FrameFile& frame) {
                                  const H5File file(Communicator::alone(), frame.path, H5File::Mode::read);
                                  if (file.find<std::string>("/", "contents").value_or("") == contents())
                                      list(frame.step, file);
                                  return file.find<std::int64_t>("/", "after");
                              });
    on_root(comm_, [&] {
        if (!listed_.empty()) write_documents();
    });
}

void FieldSeries::list(std::int64_t step, const H5File& file) {
    if (file.has("/lower")) {
        blocks_ = true;
        Blocks blocks;
        const std::uint64_t rows = file.shape("/lower").at(0);
        blocks.lower.resize(3 * rows);
        if (rows > 0) file.read("/lower", H5Type::float64, {{0, 0}, {rows, 3}}, blocks.lower.data());
        for (std::uint64_t b = 0; b < rows; ++b) {
            const auto shown = file.shape("/blocks/" + names_.fields.front().name + suffix_of(b));
            blocks.cells.push_back(
                {static_cast<int>(shown.at(2)), static_cast<int>(shown.at(1)), static_cast<int>(shown.at(0))});
        }
        write_block_document(step, blocks);
    }
    const auto lower = [&](const char* name) { return file.get<double>("/", name); };
    listed_[step] = {lower("lower_x"), lower("lower_y"), lower("lower_z")};
}

std::string FieldSeries::prefix() const { return names_.name.empty() ? "fields_" : "fluid_" + names_.name + "_"; }

std::string FieldSeries::file_of(std::int64_t step, const char* ending) const {
    return fmt::format("{}{:012d}{}", prefix(), step, ending);
}

std::vector<std::string> FieldSeries::files_of(std::int64_t step, bool blocks) const {
    std::vector<std::string> names{file_of(step, frames)};
    if (blocks) names.push_back(file_of(step, documents));
    return names;
}

std::string FieldSeries::contents() const {
    std::string text =
        fmt::format("{} x {} x {} cells of {} m from ({}, {}, {}) m, {} B:", grid_.cells[0], grid_.cells[1],
                    grid_.cells[2], grid_.spacing, grid_.lower.x, grid_.lower.y, grid_.lower.z, bytes_of(type_));
    for (const FieldName& field : names_.fields) text += " " + field.name;
    return text;
}

std::int64_t FieldSeries::step_before(std::int64_t step) const {
    if (step > last_step_) return last_step_;
    std::int64_t before = -1;
    if (comm_.root()) {
        for (const NumberedFile& file : numbered_files(names_.directory, prefix(), frames))
            if (file.number < step) before = file.number;
        if (listed_.contains(step)) before = step;
    }
    return comm_.broadcast(before);
}

void FieldSeries::write(std::int64_t step, const Vec3d& lower, FieldFrame& frame,
                        const std::vector<std::uint64_t>& shape, const Blocks* blocks) {
    const std::int64_t before = step_before(step);
    if (before == step) return;
    const std::string path = names_.directory + "/" + file_of(step, frames), temporary = path + ".tmp",
                      format(fields_format);
    std::uint64_t bytes = 0;
    for (const FieldName& field : names_.fields)
        bytes += static_cast<std::uint64_t>(field.components) * bytes_of(type_) * product(shape);
    if (blocks) bytes += blocks->cells.size() * names_.fields.size() * view_bytes;
    on_root(comm_, [&] {
        require_space(names_.directory, bytes);
        make_way(temporary, format);
    });
    {
        H5File file(comm_, temporary, H5File::Mode::create);
        file.reserve(bytes);
        write_attributes(file, step, before, lower);
        if (blocks) write_corners(file, *blocks);
        for (std::size_t f = 0; f < names_.fields.size(); ++f) write_field(file, f, frame, shape);
        file.close();
    }
    on_root(comm_, [&] {
        if (blocks) show_blocks(temporary, *blocks);
        make_way(path, format);
        publish(temporary, path);
        listed_[step] = lower;
        blocks_ = blocks != nullptr;
    });
    last_step_ = step;
}

void FieldSeries::write_attributes(H5File& file, std::int64_t step, std::int64_t before, const Vec3d& lower) const {
    file.set("/", "format", std::string(fields_format));
    file.set("/", "step", step);
    file.set("/", "time", shift_ + static_cast<double>(step) * dt_);
    file.set("/", "spacing", grid_.spacing);
    file.set("/", "lower_x", lower.x);
    file.set("/", "lower_y", lower.y);
    file.set("/", "lower_z", lower.z);
    file.set("/", "contents", contents());
    file.set("/", "after", before);
    for (const auto& [name, text] : names_.labels) file.set("/", name, text);
}

void FieldSeries::write_corners(H5File& file, const Blocks& blocks) const {
    const std::uint64_t rows = blocks.cells.size();
    file.make_dataset("/lower", H5Type::float64, {rows, 3});
    file.set("/lower", "unit", std::string("m"));
    if (rows > 0) file.write("/lower", H5Type::float64, {{0, 0}, {comm_.root() ? rows : 0, 3}}, blocks.lower.data());
    file.set("/lower", "digest", word_digest(std::as_bytes(std::span(blocks.lower)), sizeof(double), 0));
}

void FieldSeries::write_field(H5File& file, std::size_t number, FieldFrame& frame,
                              std::vector<std::uint64_t> shape) const {
    const FieldName& field = names_.fields[number];
    const std::string dataset = "/" + field.name;
    const auto components = static_cast<std::uint64_t>(field.components);
    if (components > 1) shape.push_back(components);
    file.make_dataset(dataset, type_, shape);
    file.set(dataset, "unit", field.unit);
    frame.begin(number);
    // Transfers are collective, so ranks without a piece write an empty box.
    const auto mine = static_cast<std::int64_t>(frame.pieces().size());
    std::uint64_t digest = 0;
    for (std::int64_t piece = 0, rounds = comm_.max(mine); piece < rounds; ++piece) {
        H5Box box{std::vector<std::uint64_t>(shape.size(), 0), std::vector<std::uint64_t>(shape.size(), 0)};
        std::vector<double> numbers;
        if (piece < mine) {
            box = nth(frame.pieces(), piece);
            if (components > 1) {
                box.start.push_back(0);
                box.count.push_back(components);
            }
            numbers.resize(product(box.count));
            frame.fill(to_index(piece), numbers);
        }
        std::vector<float> singles;
        const bool single = type_ == H5Type::float32;
        if (single) singles.assign(numbers.begin(), numbers.end());
        const void* const data = single ? static_cast<const void*>(singles.data()) : numbers.data();
        file.write(dataset, type_, box, data);
        digest += box_digest(data, bytes_of(type_), shape, box);
    }
    file.set(dataset, "digest", comm_.sum_wrapping(digest));
}

/// Writes the document of all frames. Frames of blocks have documents of their own, which it lists.
void FieldSeries::write_documents() const {
    std::string grids;
    for (const auto& [at, lower] : listed_)
        grids += blocks_ ? fmt::format("<xi:include href=\"{}\" xpointer=\"xpointer(/Xdmf/Domain/Grid)\"/>\n",
                                       file_of(at, documents))
                         : fmt::format("<Grid Name=\"fluid\" GridType=\"Uniform\">\n{}{}</Grid>\n", time_text(at),
                                       grid_text(file_of(at, frames), grid_.cells, lower));
    write_file(names_.directory + "/" + name_of(names_.name) + documents, document(collection("Temporal", grids)));
}

void FieldSeries::write_block_document(std::int64_t step, const Blocks& blocks) const {
    std::string grids = time_text(step);
    for (std::size_t b = 0; b < blocks.cells.size(); ++b) {
        const double* const lower = &blocks.lower[3 * b];
        grids += fmt::format("<Grid Name=\"{}\" GridType=\"Uniform\">\n{}</Grid>\n", b,
                             grid_text(file_of(step, frames), blocks.cells[b], {lower[0], lower[1], lower[2]},
                                       "/blocks/", suffix_of(b)));
    }
    write_file(names_.directory + "/" + file_of(step, documents), document(collection("Spatial", grids)));
}

void FieldSeries::write(std::int64_t step, const Vec3d& moved, FieldFrame& frame) {
    write(step, grid_.lower + moved, frame, extents(grid_.cells), nullptr);
    on_root(comm_, [&] { write_documents(); });
}

FieldSeries::Blocks FieldSeries::blocks_of(const Vec3d& lower, std::span<const std::array<int, 3>> first_cells,
                                           const std::array<int, 3>& fluid_cells) const {
    Blocks blocks;
    for (const std::array<int, 3>& first : first_cells) {
        const Vec3d cells{static_cast<double>(first[0]), static_cast<double>(first[1]), static_cast<double>(first[2])},
            at = lower + grid_.spacing * cells;
        blocks.lower.insert(blocks.lower.end(), {at.x, at.y, at.z});
        std::array<int, 3> count{};
        for (std::size_t d = 0; d < 3; ++d) count[d] = std::min(grid_.cells[d], fluid_cells[d] - first[d]);
        blocks.cells.push_back(count);
    }
    return blocks;
}

/// Makes a dataset of each block, because not all readers of ParaView know parts of datasets.
void FieldSeries::show_blocks(const std::string& path, const Blocks& blocks) const {
    std::vector<PartView> views;
    for (std::size_t b = 0; b < blocks.cells.size(); ++b)
        for (const FieldName& field : names_.fields) {
            PartView view{field.name + suffix_of(b), "/" + field.name, {{b, 0, 0, 0}, extents(blocks.cells[b])}};
            view.part.count.insert(view.part.count.begin(), 1);
            if (field.components > 1) {
                view.part.start.push_back(0);
                view.part.count.push_back(static_cast<std::uint64_t>(field.components));
            }
            views.push_back(std::move(view));
        }
    make_part_views(path, "/blocks", views);
}

void FieldSeries::write_blocks(std::int64_t step, const Vec3d& moved, FieldFrame& frame,
                               std::span<const std::array<int, 3>> first_cells, const std::array<int, 3>& fluid_cells) {
    const Vec3d lower_of_box = grid_.lower + moved;
    const Blocks blocks = blocks_of(lower_of_box, first_cells, fluid_cells);
    std::vector<std::uint64_t> shape = extents(grid_.cells);
    shape.insert(shape.begin(), first_cells.size());
    write(step, lower_of_box, frame, shape, &blocks);
    on_root(comm_, [&] {
        write_block_document(step, blocks);
        write_documents();
    });
}

std::string FieldSeries::time_text(std::int64_t step) const {
    return fmt::format("<Time Value=\"{:.17g}\"/>\n", shift_ + static_cast<double>(step) * dt_);
}

std::string FieldSeries::grid_text(const std::string& file, const std::array<int, 3>& cells, const Vec3d& lower,
                                   const std::string& group, const std::string& suffix) const {
    const auto [nx, ny, nz] = cells;
    std::string text = fmt::format("<Topology TopologyType=\"3DCoRectMesh\" Dimensions=\"{} {} {}\"/>\n<Geometry "
                                   "GeometryType=\"ORIGIN_DXDYDZ\">\n",
                                   nz + 1, ny + 1, nx + 1);
    for (const Vec3d& v : {lower, Vec3d{grid_.spacing, grid_.spacing, grid_.spacing}})
        text += fmt::format(
            "<DataItem Dimensions=\"3\" NumberType=\"Float\" Precision=\"8\" Format=\"XML\">{:.17g} {:.17g} "
            "{:.17g}</DataItem>\n",
            v.z, v.y, v.x);
    text += "</Geometry>\n";
    for (const FieldName& field : names_.fields) {
        const bool vector = field.components == 3;
        text += fmt::format(
            "<Attribute Name=\"{}\" AttributeType=\"{}\" Center=\"Cell\">\n<DataItem Dimensions=\"{} {} {}{}\" "
            "NumberType=\"Float\" Precision=\"{}\" Format=\"HDF\">{}:{}{}{}</DataItem>\n</Attribute>\n",
            field.name, vector ? "Vector" : "Scalar", nz, ny, nx, vector ? " 3" : "", bytes_of(type_), file, group,
            field.name, suffix);
    }
    return text;
}

} // namespace skein
