#include "io/field_series.hpp"

#include "io/disk.hpp"
#include "io/files.hpp"
#include "io/frame_files.hpp"
#include "io/own_files.hpp"
#include "io/segments.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <iterator>
#include <optional>

namespace skein {

namespace {

constexpr std::string_view format_name = "skein fields";
constexpr const char *frames = ".h5", *documents = ".xdmf";

std::uint64_t product(const std::vector<std::uint64_t>& shape) {
    std::uint64_t numbers = 1;
    for (const std::uint64_t extent : shape) numbers *= extent;
    return numbers;
}

/// Checksum of a box of a dataset: the sum of its words' digests, each by its place in the whole.
std::uint64_t box_digest(const void* numbers, std::size_t word, const std::vector<std::uint64_t>& shape,
                         const H5Box& box) {
    std::size_t inner = shape.size(); // dimensions from here on are side by side
    std::uint64_t run = 1, below = 1; // words, of the box and of the whole
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

/// True where a dataset is as written; files of earlier programs have no checksum.
bool is_sound(const H5File& file, const std::string& path) {
    if (!file.has(path, "digest")) return true;
    constexpr std::uint64_t most_bytes = 16 << 20; // at a time
    std::uint64_t written = 0, found = 0;
    file.get(path, "digest", written);
    const auto shape = file.shape(path);
    const H5Type type = file.type(path);
    const std::size_t word = type == H5Type::float32 ? 4 : 8;
    const std::uint64_t row = shape[0] > 0 ? product(shape) / shape[0] : 0,
                        rows = std::max<std::uint64_t>(1, most_bytes / std::max<std::uint64_t>(1, row * word));
    std::vector<std::byte> bytes;
    for (std::uint64_t begin = 0; begin < shape[0]; begin += rows) {
        H5Box box{std::vector<std::uint64_t>(shape.size(), 0), shape};
        box.start[0] = begin;
        box.count[0] = std::min(rows, shape[0] - begin);
        bytes.resize(box.count[0] * row * word);
        file.read(path, type, box, bytes.data());
        found += word_digest(bytes, word, begin * row);
    }
    return found == written;
}

bool is_sound_frame(const std::string& path, std::int64_t step) {
    const H5File file(Communicator::alone(), path, H5File::Mode::read);
    std::string format;
    std::int64_t of = -1;
    file.get("/", "format", format);
    file.get("/", "step", of);
    if (format != format_name || of != step) return false;
    for (const char* name : {"/lower", "/velocity", "/vorticity", "/q", "/pressure"})
        if (file.has(name) && !is_sound(file, name)) return false;
    return true;
}

std::optional<std::int64_t> frame_before(const std::string& path) {
    std::optional<std::int64_t> after;
    const H5File file(Communicator::alone(), path, H5File::Mode::read);
    if (file.has("/", "after")) file.get("/", "after", after.emplace());
    return after;
}

/// Of names of what shows a block.
std::string suffix_of(std::size_t block) { return fmt::format("_{}", block); }
constexpr std::uint64_t view_bytes = 1 << 10;

std::string document(const std::string& grids) {
    return "<?xml version=\"1.0\" ?>\n<Xdmf Version=\"3.0\" xmlns:xi=\"http://www.w3.org/2001/XInclude\">\n<Domain>\n" +
           grids + "</Domain>\n</Xdmf>\n";
}

std::string collection(const char* type, const std::string& grids) {
    return fmt::format("<Grid Name=\"fluid\" GridType=\"Collection\" CollectionType=\"{}\">\n{}</Grid>\n", type, grids);
}

} // namespace

FieldSeries::FieldSeries(const Communicator& comm, Names names, FieldGrid grid, Precision precision, double dt,
                         double shift, const Earlier& earlier)
    : comm_(comm), names_(std::move(names)), grid_(grid), precision_(precision), dt_(dt), shift_(shift) {
    find_earlier(earlier);
}

void FieldSeries::find_earlier(const Earlier& earlier) {
    std::vector<std::int64_t> there;
    std::vector<std::string> paths;
    on_root(comm_, [&] {
        for (const std::int64_t step : steps(frames))
            if (step <= earlier.resume_step) {
                there.push_back(step);
                paths.push_back(names_.directory + "/" + file_of(step, frames));
            }
    });
    const auto step_of = [](const std::string& path) { return std::stoll(path.substr(path.rfind('_') + 1)); };
    const std::vector<std::int64_t> damaged =
        find_damaged(comm_, paths, [&](const std::string& path) { return is_sound_frame(path, step_of(path)); });
    on_root(comm_, [&] {
        const auto tell = [&](const std::string& text) {
            if (earlier.warn) earlier.warn(text);
        };
        std::vector<FramePlace> places;
        for (std::size_t i = 0; i < there.size(); ++i) {
            FramePlace& place = places.emplace_back(FramePlace{there[i], {}});
            try {
                if (damaged[i] != 0) throw IoError(paths[i] + ": is not the frame that was written");
                place.after = frame_before(paths[i]);
                if (shows_same(paths[i])) list(there[i], paths[i]);
            } catch (const IoError& error) {
                const std::string now = set_aside(paths[i], paths[i] + ".damaged");
                tell(fmt::format("{}\n  it is put aside as {}; the run goes on without it", error.what(), now));
            }
        }
        for (const std::string& gap : missing_frames(name_of(names_.name), names_.directory, places, earlier.expected))
            tell(gap);
        last_step_ = there.empty() ? -1 : there.back();
        if (!listed_.empty()) write_documents();
    });
    last_step_ = comm_.broadcast(last_step_);
}

bool FieldSeries::shows_same(const std::string& path) const {
    const H5File file(Communicator::alone(), path, H5File::Mode::read);
    std::string text;
    if (file.has("/", "contents")) file.get("/", "contents", text);
    return text == contents();
}

/// Blocks have a document for each frame, which says no more than the frame itself.
void FieldSeries::list(std::int64_t step, const std::string& path) {
    const H5File file(Communicator::alone(), path, H5File::Mode::read);
    Vec3d lower{0, 0, 0};
    file.get("/", "lower_x", lower.x);
    file.get("/", "lower_y", lower.y);
    file.get("/", "lower_z", lower.z);
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
    listed_[step] = lower;
}

std::string FieldSeries::file_of(std::int64_t step, const char* ending) const {
    return fmt::format("{}{:012d}{}", names_.name.empty() ? "fields_" : "fluid_" + names_.name + "_", step, ending);
}

std::vector<std::string> FieldSeries::files_of(std::int64_t step, bool blocks) const {
    std::vector<std::string> names{file_of(step, frames)};
    if (blocks) names.push_back(file_of(step, documents));
    return names;
}

std::vector<std::int64_t> FieldSeries::steps(const char* ending) const {
    std::vector<std::int64_t> found;
    for (const auto& entry : std::filesystem::directory_iterator(names_.directory)) {
        const std::string name = entry.path().filename().string();
        const auto end = name.rfind(ending), begin = name.rfind('_');
        if (begin == name.npos || end == name.npos || end < begin + 13 || end > begin + 19)
            continue; // digits that a number holds
        const std::string digits = name.substr(begin + 1, end - begin - 1);
        if (digits.find_first_not_of("0123456789") == digits.npos && name == file_of(std::stoll(digits), ending))
            found.push_back(std::stoll(digits));
    }
    std::sort(found.begin(), found.end());
    return found;
}

std::string FieldSeries::contents() const {
    std::string text =
        fmt::format("{} x {} x {} cells of {} m from ({}, {}, {}) m, {} B:", grid_.cells[0], grid_.cells[1],
                    grid_.cells[2], grid_.spacing, grid_.lower.x, grid_.lower.y, grid_.lower.z, number_bytes());
    for (const FieldName& field : names_.fields) text += " " + field.name;
    return text;
}

void FieldSeries::write(std::int64_t step, const Vec3d& lower, FieldFrame& frame, std::vector<std::uint64_t> shape,
                        const Blocks* blocks) {
    std::int64_t after = last_step_;
    if (step <= last_step_) { // that a run goes on from
        if (comm_.root()) {
            const auto there = steps(frames);
            const auto here = std::lower_bound(there.begin(), there.end(), step);
            after = listed_.contains(step) ? step : here == there.begin() ? -1 : *std::prev(here);
        }
        after = comm_.broadcast(after);
        if (after == step) return;
    }
    const std::string path = names_.directory + "/" + file_of(step, frames), temporary = path + ".tmp",
                      format(format_name);
    const H5Type type = precision_ == Precision::single ? H5Type::float32 : H5Type::float64;
    std::uint64_t bytes = 0;
    for (const FieldName& field : names_.fields)
        bytes += static_cast<std::uint64_t>(field.components * number_bytes()) * product(shape);
    if (blocks) bytes += blocks->cells.size() * names_.fields.size() * view_bytes;
    on_root(comm_, [&] {
        require_space(names_.directory, bytes);
        make_way(temporary, format);
    });
    {
        H5File file(comm_, temporary, H5File::Mode::create);
        file.reserve(bytes);
        file.set("/", "format", format);
        file.set("/", "step", step);
        file.set("/", "time", shift_ + static_cast<double>(step) * dt_);
        file.set("/", "spacing", grid_.spacing);
        file.set("/", "lower_x", lower.x);
        file.set("/", "lower_y", lower.y);
        file.set("/", "lower_z", lower.z);
        file.set("/", "contents", contents());
        file.set("/", "after", after);
        for (const auto& [name, text] : names_.labels) file.set("/", name, text);
        if (blocks) {
            const std::uint64_t rows = blocks->cells.size();
            file.make_dataset("/lower", H5Type::float64, {rows, 3});
            file.set("/lower", "unit", std::string("m"));
            if (rows > 0)
                file.write("/lower", H5Type::float64, {{0, 0}, {comm_.root() ? rows : 0, 3}}, blocks->lower.data());
            file.set("/lower", "digest", word_digest(std::as_bytes(std::span(blocks->lower)), sizeof(double), 0));
        }
        for (std::size_t f = 0; f < names_.fields.size(); ++f) {
            const FieldName& field = names_.fields[f];
            const auto components = static_cast<std::uint64_t>(field.components);
            std::vector<std::uint64_t> whole = shape;
            if (components > 1) whole.push_back(components);
            file.make_dataset("/" + field.name, type, whole);
            file.set("/" + field.name, "unit", field.unit);
            frame.begin(f);
            // Every rank takes part in every transfer, those that are done with nothing.
            const auto mine = static_cast<std::int64_t>(frame.pieces().size());
            std::uint64_t digest = 0;
            for (std::int64_t piece = 0, rounds = comm_.max(mine); piece < rounds; ++piece) {
                H5Box box{std::vector<std::uint64_t>(whole.size(), 0), std::vector<std::uint64_t>(whole.size(), 0)};
                std::vector<double> numbers;
                if (piece < mine) {
                    box = nth(frame.pieces(), piece);
                    if (components > 1) {
                        box.start.push_back(0);
                        box.count.push_back(components);
                    }
                    numbers.resize(product(box.count));
                    frame.fill(static_cast<std::size_t>(piece), numbers);
                }
                std::vector<float> singles;
                if (precision_ == Precision::single) singles.assign(numbers.begin(), numbers.end());
                const void* const data =
                    precision_ == Precision::single ? static_cast<const void*>(singles.data()) : numbers.data();
                file.write("/" + field.name, type, box, data);
                digest += box_digest(data, static_cast<std::size_t>(number_bytes()), whole, box);
            }
            file.set("/" + field.name, "digest", comm_.sum_wrapping(digest));
        }
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

/// The document of all frames; those of blocks are lists of documents.
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
        const double* const lower = blocks.lower.data() + 3 * b;
        grids += fmt::format("<Grid Name=\"{}\" GridType=\"Uniform\">\n{}</Grid>\n", b,
                             grid_text(file_of(step, frames), blocks.cells[b], {lower[0], lower[1], lower[2]},
                                       "/blocks/", suffix_of(b)));
    }
    write_file(names_.directory + "/" + file_of(step, documents), document(collection("Spatial", grids)));
}

void FieldSeries::write(std::int64_t step, const Vec3d& moved, FieldFrame& frame) {
    const auto size = [&](std::size_t d) { return static_cast<std::uint64_t>(grid_.cells[d]); };
    write(step, grid_.lower + moved, frame, {size(2), size(1), size(0)}, nullptr);
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

/// ParaView's readers know datasets, but not all of them know parts of these.
void FieldSeries::show_blocks(const std::string& path, const Blocks& blocks) const {
    std::vector<PartView> views;
    for (std::size_t b = 0; b < blocks.cells.size(); ++b)
        for (const FieldName& field : names_.fields) {
            PartView view{field.name + suffix_of(b), "/" + field.name, {{b, 0, 0, 0}, {1}}};
            for (const std::size_t d : {2, 1, 0})
                view.part.count.push_back(static_cast<std::uint64_t>(blocks.cells[b][d]));
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
    const auto size = [&](std::size_t d) { return static_cast<std::uint64_t>(grid_.cells[d]); };
    write(step, lower_of_box, frame, {first_cells.size(), size(2), size(1), size(0)}, &blocks);
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
            field.name, vector ? "Vector" : "Scalar", nz, ny, nx, vector ? " 3" : "", number_bytes(), file, group,
            field.name, suffix);
    }
    return text;
}

} // namespace skein
