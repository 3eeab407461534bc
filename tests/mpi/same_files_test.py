"""same_files_test.py MPIEXEC WRITER: files have the same bytes whatever the number of ranks that wrote them."""
import pathlib
import subprocess
import sys
import tempfile

mpiexec, writer = sys.argv[1:]


def write(ranks, out, *source):
    out.mkdir()
    subprocess.run([mpiexec, "-n", str(ranks), writer, out, *source], check=True)
    return {file.name: file.read_bytes() for file in out.iterdir()}


with tempfile.TemporaryDirectory() as scratch:
    scratch = pathlib.Path(scratch)
    expected = write(1, scratch / "written_1")
    names = ["checkpoint_000000000020.h5", "checkpoint_000000000040.h5", "tips_000000000000.h5", "tips_000000000030.h5",
             "trajectory.xdmf", "trajectory_000000000000.h5", "trajectory_000000000030.h5"]
    assert sorted(expected) == names, sorted(expected)
    for ranks in 2, 3, 4:
        found = write(ranks, scratch / f"written_{ranks}")
        assert sorted(found) == names, sorted(found)
        for name in names:
            assert found[name] == expected[name], f"{name} differs between 1 and {ranks} ranks"
    newest = "checkpoint_000000000040.h5"
    for writers in 1, 2, 3, 4:
        for readers in {1, 4, writers % 4 + 1}:
            again = write(readers, scratch / f"again_{writers}_{readers}", scratch / f"written_{writers}")
            assert again == {newest: expected[newest]}, f"written on {writers}, read and written again on {readers} ranks: differs"
print("all files equal for 1 to 4 ranks")
