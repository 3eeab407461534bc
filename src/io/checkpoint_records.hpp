// Numbers of the rods of a group in a checkpoint: state, works of an audit, memory of passes. Each is a dataset with a
// digest, written and read in slabs of consecutive rods by all ranks.
#pragma once

#include "io/h5_file.hpp"
#include "parallel/communicator.hpp"
#include "tiles/rods.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace skein {

/// Takes the numbers of local rod `local[j]` and their hash, on any thread.
using PutRecord = std::function<void(std::size_t j, std::span<const double> numbers, std::uint64_t hash)>;

/// Numbers of every rod of a group: a dataset [rods, rows, columns] of doubles.
struct Record {
    std::string dataset;
    std::uint64_t rows, columns;
    void (*take)(const Rods& rods, std::span<const std::size_t> local, const PutRecord& put);
    void (*put)(Rods& rods, std::size_t i, std::span<const double> in);

    std::size_t numbers() const { return rows * columns; }
    std::size_t bytes() const { return numbers() * sizeof(double); }
};

/// Records of a group; the first is its state. Collective.
std::vector<Record> records_of(const Communicator& comm, const RodGroup& group, const Rods& rods, bool audited);

/// Writes a record of a group's rods and returns its digest. Collective.
std::uint64_t write_record(const Communicator& comm, H5File& file, const RodGroup& group, const Record& record,
                           const Rods& rods);

/// Reads a record, into `rods` if given, and returns its digest. Throws IoError if the digest is wrong. Collective.
std::uint64_t read_record(const Communicator& comm, const H5File& file, const std::string& path, const RodGroup& group,
                          const Record& record, const Rods& owned_by, Rods* rods);

} // namespace skein
