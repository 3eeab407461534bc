"""trajectory_h5py_test.py WRITER: the trajectory files are what docs/files.md says."""
import pathlib
import subprocess
import sys
import tempfile
from xml.etree import ElementTree

import h5py
import numpy as np


def text(value):
    return value.decode() if isinstance(value, bytes) else str(value)


with tempfile.TemporaryDirectory() as out:
    out = pathlib.Path(out)
    subprocess.run([sys.argv[1], out], check=True)
    with h5py.File(out / "trajectory_000000000000.h5") as file:
        assert text(file.attrs["format"]) == "skein-trajectory" and file.attrs["version"] == 2 and file.attrs["after"] == -1
        assert text(file.attrs["title"]) == "files" and text(file.attrs["kind"]) == "trajectory"
        assert list(file["step"]) == [0, 10, 20] and np.allclose(file["time"], [0, 0.1, 0.2])
        for name, rods, n in ("cilia", 37, 5), ("mat", 9, 8):
            group = file["groups"][name]
            position, directors, normal = (group[key] for key in ("position", "directors", "normal"))
            assert position.shape == (3, rods, n + 1, 3) and position.dtype == np.float32 and position.maxshape[0] is None
            assert directors.shape == (3, rods, n, 3, 3)
            frames = directors[:].astype(float)
            identity = np.einsum("...ij,...kj->...ik", frames, frames)
            assert np.allclose(identity, np.eye(3), atol=1e-6)
            mean = 0.5 * (frames[:, :, :-1, 0] + frames[:, :, 1:, 0])
            assert np.allclose(normal[:, :, 1:-1], mean, atol=1e-6)
            assert np.allclose(normal[:, :, 0], frames[:, :, 0, 0]) and np.allclose(normal[:, :, -1], frames[:, :, -1, 0])
            assert np.all(np.abs(position[:, :, 0] - group["origin"][:]) < 0.11)
            radius = 0.02 * (1 - 0.5 * np.clip(np.arange(n + 1), 0.5, n - 0.5) / n)  # tapers to one half
            assert np.allclose(group["radius"], radius)
            assert np.allclose(group["point_radius"], np.tile(radius, (rods, 1)))
            assert np.array_equal(group["connectivity"], np.arange(rods * (n + 1)).reshape(rods, n + 1))
            assert np.array_equal(np.ravel(group["rod"]), np.arange(rods))
            assert ("magnetisation" in group) == (name == "cilia")
        assert np.allclose(np.linalg.norm(file["groups/cilia/magnetisation"], axis=1), 1)
    # The checksums, by the code that the page gives.
    page = (pathlib.Path(__file__).parents[3] / "docs/files.md").read_text()
    names = {"np": np}
    exec(page[page.index("def digest(s, k):") : page.index("damaged = [")], names)
    for path in sorted(out.glob("trajectory_*.h5")) + sorted(out.glob("tips_*.h5")):
        with h5py.File(path) as file:
            assert [names["digest"](file, k) for k in range(len(file["step"]))] == list(file["digest"]), path.name
    with h5py.File(out / "tips_000000000030.h5") as file:
        assert file.attrs["after"] == 20
        assert text(file.attrs["kind"]) == "tips" and list(file["step"]) == [30, 40]
        with h5py.File(out / "trajectory_000000000030.h5") as whole:
            for name in "cilia", "mat":
                assert np.array_equal(file["groups"][name]["position"], whole["groups"][name]["position"][:, :, -1])
    with h5py.File(out / "checkpoint_000000000040.h5") as file:
        assert text(file.attrs["format"]) == "skein-checkpoint" and file.attrs["step"] == 40
        state = file["groups/mat/state"]
        assert state.shape == (9, 9, 13) and state.dtype == np.float64
        digests = sum(int(group["state"].attrs["digest"]) for group in file["groups"].values()) % 2**64
        assert digests == int(file.attrs["digest"])
    grids = ElementTree.parse(out / "trajectory.xdmf").getroot().find("Domain/Grid")
    assert np.allclose([float(time.get("Value")) for time in grids.iter("Time")], [0, 0.1, 0.2, 0.3, 0.4])
    seen = {}
    for item in grids.iter("DataItem"):
        name, path = item.text.strip().split(":")
        with h5py.File(out / name) as file:
            assert file[path].shape == tuple(map(int, item.get("Dimensions").split())), path
            assert file[path].dtype.itemsize == int(item.get("Precision")), path
            seen[name, path] = file[path][:]
    with h5py.File(out / "trajectory_000000000030.h5") as file:
        assert np.array_equal(seen["trajectory_000000000030.h5", "/groups/mat/frames/1/position"], file["groups/mat/position"][1])
        assert np.array_equal(seen["trajectory_000000000030.h5", "/groups/cilia/frames/0/normal"], file["groups/cilia/normal"][0])
print("trajectory, tips and checkpoint are as documented; the side-car names what is there")
