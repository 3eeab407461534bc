// write_files OUT [FROM]: every kind of HDF5 file, of rods whose states are known. With FROM, the checkpoint of that
// directory is read and written again instead. For tests that compare or read the files from outside.
#include "io/checkpoint.hpp"
#include "io/trajectory.hpp"
#include "partition/partition.hpp"
#include "support/fake_rods.hpp"

#include <cstdio>

using namespace skein;

int main(int argc, char** argv) {
    const MpiSession session(argc, argv);
    const auto comm = Communicator::world();
    const std::string out = argv[1];
    const auto groups = test::two_groups();
    test::FakeRods rods(groups, partition(comm, groups));
    const std::string scene = R"({"title":"files"})";
    if (argc > 2) {
        rods.set(-1);
        const auto info = read_checkpoint(comm, argv[2], groups, rods, scene,
                                          [](const std::string& text) { std::puts(text.c_str()); });
        write_checkpoint(comm, out, groups, rods, info.value());
        return 0;
    }

    const std::uint64_t buffer_bytes = 20 << 10; // as many frames of the trajectory as there are ranks
    FrameWriter trajectory(comm, {.directory = out, .title = "files", .buffer_bytes = buffer_bytes}, groups, rods);
    FrameWriter tips(comm, {.directory = out, .kind = FrameKind::tips, .title = "files", .buffer_bytes = buffer_bytes},
                     groups, rods);
    for (std::int64_t step = 0; step <= 40; step += 10) {
        rods.set(step);
        for (FrameWriter* frames : {&trajectory, &tips}) frames->write(step, 0.01 * static_cast<double>(step), 0.005);
        if (step % 20 != 0 || step == 0) continue;
        for (FrameWriter* frames : {&trajectory, &tips}) frames->close_segment();
        write_checkpoint(comm, out, groups, rods, {step, 0.01, comm.sum_wrapping(rods.digest()), scene, {}});
    }
    return 0;
}
