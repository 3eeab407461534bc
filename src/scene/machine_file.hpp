// Machine files: what messages and memory of a machine cost, as bench/scaling/netcal measures it.
#pragma once

#include "skein/core/fields.hpp"

#include <string>
#include <vector>

namespace skein {

struct MachineFile {
    /// The defaults are those of a network of 200 Gb/s, half used.
    struct Network {
        double latency = 1.5e-6;     ///< s, of a short message
        double overhead = 0.8e-6;    ///< s, per message sent and one received, beyond the first
        double bandwidth = 12.5e9;   ///< bytes/s, of one pair of ranks alone
        double bandwidth_all = 10e9; ///< bytes/s, of a rank while all send and receive at once
        double allreduce = 0;        ///< s, of one number over `ranks` of the machine; 0: from the latency
        double misfit = 1;           ///< largest ratio of message_s to latency + bytes / bandwidth
        std::vector<double> message_bytes, message_s;

        void fields(FieldVisitor& f);
    } network;
    struct Nodes {
        std::string processor;
        long ranks = 2, nodes = 1, ranks_per_node = 0, cores_per_node = 0, threads_per_rank = 0;
        double copy = 5e9; ///< bytes/s by one core of each rank, from memory to memory
        double copy_all = 0;

        void fields(FieldVisitor& f);
    } machine;
};

/// Throws InputError.
MachineFile read_machine_file(const std::string& file);

} // namespace skein
