"""xdmf_vtk_test.py WRITER: VTK reads the XDMF side-car, in both its readers: times, points, polylines and attributes."""
import pathlib
import subprocess
import sys
import tempfile

import h5py
import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import VTK_POLY_LINE, vtkCompositeDataSet, vtkMultiBlockDataSet
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkIOXdmf2 import vtkXdmfReader
from vtkmodules.vtkIOXdmf3 import vtkXdmf3Reader


def blocks_of(data):
    """Name and content of the leaves of a data set."""
    if not isinstance(data, vtkMultiBlockDataSet):
        return {"": data}
    found = {}
    for i in range(data.GetNumberOfBlocks()):
        name = data.GetMetaData(i).Get(vtkCompositeDataSet.NAME()) if data.HasMetaData(i) else ""
        for leaf, content in blocks_of(data.GetBlock(i)).items():
            found[leaf or name] = content
    return found


def check(reader, out):
    reader.SetFileName(str(out / "trajectory.xdmf"))
    reader.UpdateInformation()
    times = reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    assert np.allclose(times, [0, 0.1, 0.2, 0.3, 0.4]), times
    for frame, time in enumerate(times):
        reader.UpdateTimeStep(time)
        blocks = blocks_of(reader.GetOutputDataObject(0))
        assert len(blocks) == 2, blocks.keys()
        segment, row = ("000000000000", frame) if frame < 3 else ("000000000030", frame - 3)
        with h5py.File(out / f"trajectory_{segment}.h5") as file:
            for name, block in zip(("cilia", "mat"), blocks.values()):
                group = file["groups"][name]
                rods, nodes = group["connectivity"].shape
                assert block.GetNumberOfPoints() == rods * nodes and block.GetNumberOfCells() == rods
                assert block.GetCellType(0) == VTK_POLY_LINE and block.GetCell(rods - 1).GetNumberOfPoints() == nodes
                points = vtk_to_numpy(block.GetPoints().GetData())
                assert np.array_equal(points, group["position"][row].reshape(-1, 3))
                radius = vtk_to_numpy(block.GetPointData().GetArray("radius"))
                assert np.allclose(radius, np.ravel(group["point_radius"]))
                normal = vtk_to_numpy(block.GetPointData().GetArray("normal"))
                assert np.array_equal(normal, group["normal"][row].reshape(-1, 3))
                assert np.array_equal(vtk_to_numpy(block.GetCellData().GetArray("rod")).ravel(), np.arange(rods))
                if name == "cilia":
                    moment = vtk_to_numpy(block.GetCellData().GetArray("magnetisation"))
                    assert np.allclose(moment, group["magnetisation"])


with tempfile.TemporaryDirectory() as out:
    out = pathlib.Path(out)
    subprocess.run([sys.argv[1], out], check=True)
    for kind in vtkXdmf3Reader, vtkXdmfReader:
        check(kind(), out)
        print(f"{kind.__name__}: 5 times, 2 groups, points and attributes as in the HDF5 files")
