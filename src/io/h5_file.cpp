#include "io/h5_file.hpp"

#include "io/disk.hpp"
#include "io/h5_links.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <mpi.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

namespace skein {

static_assert(sizeof(hid_t) == sizeof(std::int64_t) && sizeof(hsize_t) == sizeof(std::uint64_t));

namespace {

/// Reason of HDF5's last failure. It is copied as the call fails, because closing a handle erases HDF5's record.
std::string last_reason;
/// Target outside the file of the link or dataset of the last call that failed.
std::string outside;

herr_t take_down_reason(hid_t stack, void*) {
    last_reason.clear();
    return H5Ewalk2(
        stack, H5E_WALK_UPWARD,
        [](unsigned, const H5E_error2_t* error, void*) -> herr_t {
            if (last_reason.empty() && error->desc) last_reason = error->desc;
            return 0;
        },
        nullptr);
}

std::string failure_of(const std::string& path, const std::string& deed) {
    const std::string said = std::exchange(last_reason, {}), elsewhere = std::exchange(outside, {});
    const std::string& reason = elsewhere.empty() ? said : elsewhere;
    return path + ": " + deed + (reason.empty() ? "" : " (" + reason + ")");
}

/// Empties a useless file. HDF5 writes its metadata before it closes a file, and needs room for that.
void make_room(const std::string& path) { [[maybe_unused]] const int ignored = ::truncate(path.c_str(), 0); }

hid_t type_id(H5Type type) {
    switch (type) {
    case H5Type::float32:
        return H5T_IEEE_F32LE;
    case H5Type::float64:
        return H5T_IEEE_F64LE;
    case H5Type::int64:
        return H5T_STD_I64LE;
    case H5Type::uint64:
        return H5T_STD_U64LE;
    }
    return -1;
}

// Chunks of this size suit ParaView, which reads single frames, and file systems with stripes of 1 to 4 MB.
constexpr std::uint64_t largest_chunk = 4 << 20;

H5Handle file_access() {
    H5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    // Format 1.10 has checksums on all metadata, so damage there is an error and no wrong number.
    H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_LATEST);
    H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
    // Small datasets would else leave room behind them, filled with stale memory.
    H5Pset_small_data_block_size(access, 0);
#if H5_VERSION_GE(1, 10, 7) && !(H5_VERSION_GE(1, 12, 0) && !H5_VERSION_GE(1, 12, 1))
    // Parallel file systems may have no locks, and the directory has its own.
    H5Pset_file_locking(access, false, true);
#endif
    return access;
}

H5Handle file_access(const Communicator& comm) {
    H5Handle access = file_access();
    H5Pset_fapl_mpio(access, MPI_Comm_f2c(comm.handle()), MPI_INFO_NULL);
    H5Pset_coll_metadata_write(access, true);
    H5Pset_all_coll_metadata_ops(access, true);
    return access;
}

/// True if this rank can allocate memory. Open MPI opens a file with shared memory, and if one rank gets none the
/// others wait forever.
bool has_memory() {
    constexpr std::size_t bytes = 16 << 20; // HDF5 and MPI take less to open a file
    void* const some = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    return some != MAP_FAILED && ::munmap(some, bytes) == 0;
}

/// Properties of new objects without time stamps.
H5Handle untimed(hid_t property_class) {
    H5Handle creation(H5Pcreate(property_class), H5Pclose);
    H5Pset_obj_track_times(creation, false);
    return creation;
}

/// Space of a dataset, which may grow to `largest`.
H5Handle simple_space(const std::vector<std::uint64_t>& size, const std::vector<std::uint64_t>& largest = {}) {
    // hsize_t and uint64_t are equal but not one type.
    const std::vector<hsize_t> now(size.begin(), size.end()), most(largest.begin(), largest.end());
    return {H5Screate_simple(static_cast<int>(now.size()), now.data(), most.empty() ? nullptr : most.data()), H5Sclose};
}

hid_t open_file(const Communicator& comm, const std::string& path, H5File::Mode mode) {
    const H5Handle access = file_access(comm);
    if (mode == H5File::Mode::read) return H5Fopen(path.c_str(), H5F_ACC_RDONLY, access);
    if (mode == H5File::Mode::modify) return H5Fopen(path.c_str(), H5F_ACC_RDWR, access);
    return H5Fcreate(path.c_str(), H5F_ACC_TRUNC, untimed(H5P_FILE_CREATE), access);
}

H5Handle new_group(hid_t parent, const std::string& path) {
    return {H5Gcreate2(parent, path.c_str(), H5P_DEFAULT, untimed(H5P_GROUP_CREATE), H5P_DEFAULT), H5Gclose};
}

/// Allocates all space at once without fill values, since every element is written.
H5Handle dataset_creation() {
    H5Handle creation = untimed(H5P_DATASET_CREATE);
    H5Pset_alloc_time(creation, H5D_ALLOC_TIME_EARLY);
    H5Pset_fill_time(creation, H5D_FILL_TIME_NEVER);
    return creation;
}

/// One frame, several small ones, or an equal share of the rods of a frame larger than a chunk.
std::vector<hsize_t> chunk_shape(H5Type type, const std::vector<std::uint64_t>& frame_shape) {
    std::uint64_t row = bytes_of(type);
    for (std::size_t i = 1; i < frame_shape.size(); ++i) row *= frame_shape[i];
    const std::uint64_t frame = frame_shape.empty() ? row : row * frame_shape[0];
    std::vector<hsize_t> chunk{std::max<std::uint64_t>(H5File::frames_slack / frame, 1)};
    chunk.insert(chunk.end(), frame_shape.begin(), frame_shape.end());
    if (frame <= largest_chunk) return chunk;
    const std::uint64_t rows_that_fit = std::max<std::uint64_t>(largest_chunk / row, 1);
    const std::uint64_t chunks = (frame_shape[0] + rows_that_fit - 1) / rows_that_fit;
    chunk[1] = (frame_shape[0] + chunks - 1) / chunks;
    return chunk;
}

/// Open dataset of frames.
struct Frames {
    H5Handle dataset;
    std::vector<hsize_t> size, chunk;
    bool valid = false;

    Frames(hid_t file, const std::string& path) : dataset(open_own_dataset(file, path, outside)) {
        if (!dataset.valid()) return;
        const H5Handle space(H5Dget_space(dataset), H5Sclose), creation(H5Dget_create_plist(dataset), H5Pclose);
        const int dimensions = H5Sget_simple_extent_ndims(space);
        if (dimensions < 1) return;
        size.resize(to_index(dimensions));
        chunk.resize(size.size());
        valid = H5Sget_simple_extent_dims(space, size.data(), nullptr) == dimensions &&
                H5Pget_chunk(creation, dimensions, chunk.data()) == dimensions;
    }
    bool set(std::uint64_t frames) {
        size[0] = frames;
        return H5Dset_extent(dataset, size.data()) >= 0;
    }
};

struct Selection {
    H5Handle memory, file;
    bool valid;

    Selection(hid_t dataset, const H5Box& box)
        : memory(simple_space(box.count)), file(H5Dget_space(dataset), H5Sclose),
          valid(memory.valid() && file.valid()) {
        if (!valid) return;
        const std::vector<hsize_t> start(box.start.begin(), box.start.end()), count(box.count.begin(), box.count.end());
        if (std::find(count.begin(), count.end(), 0u) != count.end())
            valid = H5Sselect_none(memory) >= 0 && H5Sselect_none(file) >= 0;
        else valid = H5Sselect_hyperslab(file, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr) >= 0;
    }
};

H5Handle collective_transfer() {
    H5Handle transfer(H5Pcreate(H5P_DATASET_XFER), H5Pclose);
    H5Pset_dxpl_mpio(transfer, H5FD_MPIO_COLLECTIVE);
    return transfer;
}

H5Handle text_type(std::size_t length) {
    H5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
    H5Tset_size(type, std::max<std::size_t>(length, 1));
    H5Tset_strpad(type, H5T_STR_NULLPAD);
    H5Tset_cset(type, H5T_CSET_UTF8);
    return type;
}

bool make_attribute(hid_t file, const std::string& object, const std::string& name, hid_t type, const void* value) {
    const H5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    const H5Handle attribute(
        H5Acreate_by_name(file, object.c_str(), name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
        H5Aclose);
    return attribute.valid() && H5Awrite(attribute, type, value) >= 0;
}

std::string attribute_name(const std::string& object, const std::string& name) {
    return "attribute " + name + " of " + object;
}

} // namespace

H5File::H5File(const Communicator& comm, std::string path, Mode mode)
    : comm_(comm), path_(std::move(path)), mode_(mode) {
    H5Eset_auto2(H5E_DEFAULT, take_down_reason, nullptr); // replaces HDF5's print-out on every rank
    agree(has_memory(), fmt::format("no memory is left on rank {}", comm.rank()));
    id_ = open_file(comm, path_, mode);
    try {
        agree(id_ >= 0, mode == Mode::create ? "cannot be created" : "cannot be opened");
    } catch (...) {
        if (id_ >= 0) H5Fclose(id_);
        throw;
    }
}

H5File::~H5File() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (id_ < 0) return;
    if (mode_ != Mode::read) {
        comm_.barrier();
        if (comm_.root()) make_room(path_);
        comm_.barrier();
    }
    H5Fclose(id_);
}

void H5File::close() {
    agree(H5Fflush(id_, H5F_SCOPE_GLOBAL) >= 0, "cannot be flushed to disk");
    if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
    const bool closed = H5Fclose(std::exchange(id_, -1)) >= 0;
    agree(closed, "cannot be closed");
}

void H5File::reserve(std::uint64_t bytes) {
    reserved_ += bytes + bytes / 20 + (64 << 10);
    on_root(comm_, [&] { reserve_space(path_, reserved_); });
}

void H5File::agree(bool well, const std::string& deed) const {
    const std::string text = comm_.first_text(well ? "" : failure_of(path_, deed));
    last_reason.clear();
    if (!text.empty()) throw IoError(text);
}

void H5File::make_group(const std::string& path) { agree(new_group(id_, path).valid(), path + " cannot be made"); }

void H5File::make_dataset(const std::string& path, H5Type type, const std::vector<std::uint64_t>& shape) {
    const H5Handle dataset(
        H5Dcreate2(id_, path.c_str(), type_id(type), simple_space(shape), H5P_DEFAULT, dataset_creation(), H5P_DEFAULT),
        H5Dclose);
    agree(dataset.valid(), path + " cannot be made");
}

void H5File::make_frames(const std::string& path, H5Type type, const std::vector<std::uint64_t>& frame_shape) {
    std::vector<std::uint64_t> size{0}, largest{H5S_UNLIMITED};
    size.insert(size.end(), frame_shape.begin(), frame_shape.end());
    largest.insert(largest.end(), frame_shape.begin(), frame_shape.end());
    const H5Handle creation = dataset_creation();
    const auto chunk = chunk_shape(type, frame_shape);
    H5Pset_chunk(creation, static_cast<int>(chunk.size()), chunk.data());
    const H5Handle dataset(
        H5Dcreate2(id_, path.c_str(), type_id(type), simple_space(size, largest), H5P_DEFAULT, creation, H5P_DEFAULT),
        H5Dclose);
    agree(dataset.valid(), path + " cannot be made");
}

void H5File::set_frames(const std::vector<std::string>& paths, std::uint64_t frames, std::uint64_t flush_every) {
    std::vector<Frames> grown;
    bool well = true;
    for (const std::string& path : paths) well &= grown.emplace_back(id_, path).valid;
    agree(well, "frames cannot be opened");
    // A rank that fails continues, since others may wait for it in the following calls.
    for (std::uint64_t frame = grown.at(0).size[0]; frame < frames; ++frame) {
        const bool flush = flush_every > 0 && (frame + 1) % flush_every == 0;
        for (Frames& dataset : grown)
            if (flush || frame % dataset.chunk[0] == 0) well &= dataset.set(frame + 1);
        if (flush) well &= H5Fflush(id_, H5F_SCOPE_GLOBAL) >= 0;
    }
    for (Frames& dataset : grown) well &= dataset.set(frames);
    agree(well, fmt::format("frames cannot be made {}", frames));
}

std::vector<std::uint64_t> H5File::shape(const std::string& path) const {
    const H5Handle dataset = open_own_dataset(id_, path, outside);
    agree(dataset.valid(), path + " cannot be opened");
    const H5Handle space(H5Dget_space(dataset), H5Sclose);
    const int dimensions = space.valid() ? H5Sget_simple_extent_ndims(space) : -1;
    std::vector<hsize_t> size(to_index(std::max(dimensions, 0)));
    agree(dimensions >= 0 && H5Sget_simple_extent_dims(space, size.data(), nullptr) >= 0,
          path + " has no readable size");
    return {size.begin(), size.end()};
}

H5Type H5File::type(const std::string& path) const {
    const H5Handle dataset = open_own_dataset(id_, path, outside);
    agree(dataset.valid(), path + " cannot be opened");
    const H5Handle found(H5Dget_type(dataset), H5Tclose);
    for (const H5Type known : {H5Type::float32, H5Type::float64, H5Type::int64, H5Type::uint64})
        if (H5Tequal(found, type_id(known)) > 0) return known;
    throw IoError(path_ + ": " + path + " has numbers of another type");
}

bool H5File::has(const std::string& path) const {
    bool there = true;
    const H5Handle access = own_links(H5P_LINK_ACCESS, outside);
    for (auto end = path.find('/', 1); there; end = path.find('/', end + 1)) {
        const htri_t found = H5Lexists(id_, path.substr(0, end).c_str(), access);
        agree(found >= 0, path + " cannot be searched for");
        there = found > 0;
        if (end == path.npos) break;
    }
    return there;
}

bool H5File::has(const std::string& object, const std::string& attribute) const {
    const htri_t found = H5Aexists_by_name(id_, object.c_str(), attribute.c_str(), own_links(H5P_LINK_ACCESS, outside));
    agree(found >= 0, attribute_name(object, attribute) + " cannot be searched for");
    return found > 0;
}

template <class Call>
void H5File::transfer(const std::string& path, const H5Box& box, const std::string& failure, Call&& call) const {
    const H5Handle dataset = open_own_dataset(id_, path, outside);
    agree(dataset.valid(), path + " cannot be opened");
    const Selection selection(dataset, box);
    agree(selection.valid, path + " has no such part");
    agree(call(dataset, selection.memory, selection.file) >= 0, path + failure);
}

void H5File::write(const std::string& path, H5Type type, const H5Box& box, const void* data) {
    transfer(path, box, " cannot be written", [&](hid_t dataset, hid_t memory, hid_t file) {
        return H5Dwrite(dataset, type_id(type), memory, file, collective_transfer(), data);
    });
    std::uint64_t bytes = bytes_of(type);
    for (const std::uint64_t extent : box.count) bytes *= extent;
    start_flush(bytes);
}

void H5File::start_flush(std::uint64_t bytes) {
#if defined(SYNC_FILE_RANGE_WRITE)
    constexpr std::uint64_t least = 4 << 20; // fewer bytes only keep a busy disk from other work
    unflushed_ += bytes;
    if (unflushed_ < least) return;
    unflushed_ = 0;
    if (descriptor_ < 0) descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CLOEXEC);
    if (descriptor_ >= 0) ::sync_file_range(descriptor_, 0, 0, SYNC_FILE_RANGE_WRITE);
#endif
}

void H5File::read(const std::string& path, H5Type type, const H5Box& box, void* data) const {
    transfer(path, box, " cannot be read", [&](hid_t dataset, hid_t memory, hid_t file) {
        return H5Dread(dataset, type_id(type), memory, file, collective_transfer(), data);
    });
}

void H5File::set_number(const std::string& object, const std::string& name, H5Type type, const void* value) {
    agree(make_attribute(id_, object, name, type_id(type), value), attribute_name(object, name) + " cannot be written");
}
void H5File::set(const std::string& object, const std::string& name, const std::string& value) {
    agree(make_attribute(id_, object, name, text_type(value.size()), value.c_str()),
          attribute_name(object, name) + " cannot be written");
}

template <class Read>
void H5File::read_attribute(const std::string& object, const std::string& name, Read&& read) const {
    const H5Handle attribute(
        H5Aopen_by_name(id_, object.c_str(), name.c_str(), H5P_DEFAULT, own_links(H5P_LINK_ACCESS, outside)), H5Aclose);
    const bool well = attribute.valid() && read(attribute, H5Handle(H5Aget_type(attribute), H5Tclose));
    agree(well, attribute_name(object, name) + " cannot be read");
}
void H5File::get_number(const std::string& object, const std::string& name, H5Type type, void* value) const {
    read_attribute(object, name, [&](hid_t attribute, hid_t found) {
        return H5Tequal(found, type_id(type)) > 0 && H5Aread(attribute, type_id(type), value) >= 0;
    });
}
void H5File::get_text(const std::string& object, const std::string& name, std::string& value) const {
    read_attribute(object, name, [&](hid_t attribute, hid_t found) {
        if (H5Tget_class(found) != H5T_STRING || H5Tis_variable_str(found) != 0) return false;
        value.assign(H5Tget_size(found), '\0');
        return H5Aread(attribute, found, value.data()) >= 0;
    });
    value.erase(value.find_last_not_of('\0') + 1);
}

namespace {

bool make_view(hid_t file, const std::string& path, hid_t dataset, const std::string& dataset_path, const H5Box& box) {
    const Selection part(dataset, box);
    const H5Handle space = simple_space({box.count.begin() + 1, box.count.end()}), type(H5Dget_type(dataset), H5Tclose),
                   creation = untimed(H5P_DATASET_CREATE);
    if (!part.valid || H5Pset_virtual(creation, space, ".", dataset_path.c_str(), part.file) < 0) return false;
    return H5Handle(H5Dcreate2(file, path.c_str(), type, space, H5P_DEFAULT, creation, H5P_DEFAULT), H5Dclose).valid();
}

H5Box frame_of(const Frames& frames, std::uint64_t frame) {
    H5Box box{std::vector<std::uint64_t>(frames.size.size(), 0), {frames.size.begin(), frames.size.end()}};
    box.start[0] = frame;
    box.count[0] = 1;
    return box;
}

bool make_views(hid_t file, const std::string& group, const std::vector<std::string>& names, std::uint64_t count) {
    std::vector<Frames> frames;
    for (const std::string& name : names) frames.emplace_back(file, group + "/" + name);
    if (!new_group(file, group + "/frames").valid()) return false;
    for (std::uint64_t k = 0; k < count; ++k) {
        const std::string path = fmt::format("{}/frames/{}", group, k);
        if (!new_group(file, path).valid()) return false;
        for (std::size_t i = 0; i < names.size(); ++i)
            if (!frames[i].valid || !make_view(file, path + "/" + names[i], frames[i].dataset, group + "/" + names[i],
                                               frame_of(frames[i], k)))
                return false;
    }
    return true;
}

bool make_views(hid_t file, const std::string& group, const std::vector<PartView>& views) {
    if (!new_group(file, group).valid()) return false;
    return std::all_of(views.begin(), views.end(), [&](const PartView& view) {
        const H5Handle dataset(H5Dopen2(file, view.dataset.c_str(), H5P_DEFAULT), H5Dclose);
        return dataset.valid() && make_view(file, group + "/" + view.name, dataset, view.dataset, view.part);
    });
}

/// Changes a closed file from one rank alone, and empties it on failure.
template <class Make> void change_alone(const std::string& path, const std::string& deed, Make&& make) {
    const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, file_access());
    bool well = file >= 0 && make(file) && H5Fflush(file, H5F_SCOPE_LOCAL) >= 0;
    if (file >= 0) {
        if (!well) make_room(path);
        well &= H5Fclose(file) >= 0;
    }
    if (!well) throw IoError(failure_of(path, deed));
}

} // namespace

void make_frame_views(const std::string& path, const std::string& group, const std::vector<std::string>& names,
                      std::uint64_t frames) {
    change_alone(path, "datasets of single frames cannot be made",
                 [&](hid_t file) { return make_views(file, group, names, frames); });
}

void make_part_views(const std::string& path, const std::string& group, const std::vector<PartView>& views) {
    change_alone(path, "datasets of parts cannot be made", [&](hid_t file) { return make_views(file, group, views); });
}

} // namespace skein
