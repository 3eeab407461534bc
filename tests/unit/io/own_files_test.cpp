#include "io/own_files.hpp"

#include <gtest/gtest.h>

namespace skein {
namespace {

TEST(OwnFiles, are_known_by_their_whole_name) {
    for (const char* name : {"checkpoint_000000000064.h5",
                             "checkpoint_000000000064.h5.tmp",
                             "checkpoint_000000000064.h5.damaged",
                             "trajectory_000000000000.h5",
                             "tips_1000000000000.h5",
                             "lost_trajectory_000000000000.h5",
                             "contacts_000000000010.csv",
                             "lost_tips_000000000000.h5.unreadable",
                             "lost_tips_000000000000.h5.2",
                             "trajectory.xdmf",
                             "trajectory.xdmf.foreign",
                             "observables.csv",
                             "observables.lost.csv",
                             "observables.csv.damaged.3",
                             "summary.json",
                             "physics.json.tmp",
                             "failure.h5",
                             "failure.h5.tmp",
                             "failure.xdmf",
                             "rods.pvd",
                             "walls.pvd.foreign",
                             "vtp/rods_000000000064.vtp",
                             "vtp/rods_000000000064.vtp.tmp",
                             "vtp/walls_000000000000.vtp.damaged",
                             "fields_000000000000.h5",
                             "fluid_mid_plane_000000000010.h5.tmp",
                             "fluid_mid_plane_000000000010.xdmf",
                             "fluid_mid_plane.xdmf"})
        EXPECT_TRUE(is_result_name(name)) << name;
    for (const char* name : {"mydata.h5",
                             "fluid_000000000010.h5",
                             "fluid_plane.h5",
                             "fluid_plane_64.h5",
                             "fluid_plane_00000000001x.h5",
                             "thesis.tmp",
                             "other.xdmf",
                             "trajectory.h5",
                             "trajectory_.h5",
                             "trajectory_64.h5",
                             "checkpoint_best.h5",
                             "checkpoint_00000000006x.h5",
                             "my_checkpoint_000000000064.h5",
                             "checkpoint_000000000064.hdf5",
                             "observables.csv.bak",
                             "my_observables.csv",
                             "summary.json~",
                             "contacts_000000000010.h5",
                             ".tmp",
                             "",
                             ".2",
                             "previous_1",
                             "vtp",
                             "vtp/",
                             "vtp/notes.txt",
                             "vtp/rods_64.vtp",
                             "vtp/rods.pvd",
                             "rods_000000000064.vtp",
                             "my.pvd",
                             "trajectory.xdmf.gz",
                             "scene.toml"})
        EXPECT_FALSE(is_result_name(name)) << name;
}

} // namespace
} // namespace skein
