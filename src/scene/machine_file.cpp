#include "scene/machine_file.hpp"

#include "scene/scene_file.hpp"
#include "scene/scene_reader.hpp"

namespace skein {

void MachineFile::Network::fields(FieldVisitor& f) {
    f.visit({"latency_s", "s", "time of a short message", true, 0}, latency);
    f.visit({"overhead_s", "s", "time of a message sent and one received, beyond the first", true, -HUGE_VAL, 0},
            overhead);
    f.visit({"bandwidth_B_per_s", "B/s", "of one pair of ranks alone", true, 0}, bandwidth);
    f.visit({"bandwidth_all_B_per_s", "B/s", "of a rank, while all send and receive at once", true, 0}, bandwidth_all);
    f.visit({"allreduce_s", "s", "time of one number over all ranks", false, -HUGE_VAL, 0}, allreduce);
    f.visit({"misfit", "-", "largest ratio of message_s to latency_s + message_bytes / bandwidth_B_per_s"}, misfit);
    f.visit({"message_bytes", "B", "sizes of messages that were measured"}, message_bytes);
    f.visit({"message_s", "s", "their times, one way"}, message_s);
}

void MachineFile::Nodes::fields(FieldVisitor& f) {
    f.visit({"processor", "", "name of the processor"}, processor);
    f.visit({"ranks", "-", "ranks that were measured", false, 0}, ranks);
    f.visit({"nodes", "-", "nodes that they were on"}, nodes);
    f.visit({"ranks_per_node", "-", "ranks of a node"}, ranks_per_node);
    f.visit({"cores_per_node", "-", "cores that the ranks of a node may use"}, cores_per_node);
    f.visit({"threads_per_rank", "-", "cores that a rank may use"}, threads_per_rank);
    f.visit({"copy_B_per_s", "B/s", "by one core of each rank, from memory to memory", false, 0}, copy);
    f.visit({"copy_all_B_per_s", "B/s", "by each of all cores at once"}, copy_all);
}

MachineFile read_machine_file(const std::string& file) {
    const std::string text = read_scene_text(file);
    const TomlValue root = parse_toml(text, source_text(file, text));
    Problems problems;
    MachineFile machine = read_machine_tables(root, problems);
    problems.raise();
    return machine;
}

} // namespace skein
