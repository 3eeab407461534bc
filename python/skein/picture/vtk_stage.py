"""Drawing by VTK, off the screen: on a display of its own (Xvfb) where VTK needs one and there is none."""

import os
import shutil
import subprocess
import sys
from functools import cache

import numpy as np

from . import sky

DEPTH_PIXELS = {1: 576, 2: 1024}  # by samples: of movies and of pictures


def why_not():
    """Why VTK cannot draw here; empty where it can."""
    try:
        import vtkmodules.vtkRenderingOpenGL2  # noqa: F401
    except ImportError:
        return f"{sys.executable} has no VTK (Debian: python3-vtk9, or ParaView's python3-paraview)"
    if _needs_display() and not _display():
        return "VTK needs a display, and there is neither one nor Xvfb (Debian: xvfb)"
    return ""


@cache
def _needs_display():
    from vtkmodules.vtkRenderingCore import vtkRenderWindow
    return vtkRenderWindow().GetClassName() == "vtkXOpenGLRenderWindow"


@cache
def _display():
    """Whether there is a display; one of our own is started where there is none, and ends with this program."""
    if os.environ.get("DISPLAY"):
        return True
    if not shutil.which("Xvfb"):
        return False
    import atexit
    read, write = os.pipe()
    server = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "64x64x24", "-nolisten", "tcp", "-noreset"], pass_fds=(write,),
                              stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    os.close(write)
    with os.fdopen(read) as answer:
        number = answer.readline().strip()
    if not number:
        return False
    os.environ["DISPLAY"] = ":" + number

    def end():
        Stage.close_all()
        server.terminate()
        server.wait()

    atexit.register(end)
    return True


class Picture:
    """A window that is never shown, with one renderer and one mesh after another in it."""

    def __init__(self, width, height):
        from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper, vtkRenderer, vtkRenderWindow
        import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  (what draws)
        self.width, self.height = width, height
        self.renderer = vtkRenderer()
        self.renderer.SetBackground(1, 1, 1)
        self.window = vtkRenderWindow()
        self.window.SetOffScreenRendering(1)
        self.window.SetMultiSamples(0)
        self.window.SetSize(width, height)
        self.window.AddRenderer(self.renderer)
        self.mapper = vtkPolyDataMapper()
        actor = vtkActor()
        actor.SetMapper(self.mapper)
        actor.GetProperty().LightingOff()  # colours have their light
        self.renderer.AddActor(actor)
        self.camera = self.renderer.GetActiveCamera()

    def put(self, points, faces, colours=None):
        from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
        from vtkmodules.vtkCommonCore import vtkPoints
        from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
        data, where, polygons = vtkPolyData(), vtkPoints(), vtkCellArray()
        where.SetData(numpy_to_vtk(np.ascontiguousarray(points, np.float32), deep=True))
        data.SetPoints(where)
        polygons.SetData(numpy_to_vtkIdTypeArray(np.arange(0, faces.size + 1, 4), deep=True), numpy_to_vtkIdTypeArray(np.ascontiguousarray(faces, np.int64).ravel(), deep=True))
        data.SetPolys(polygons)
        if colours is not None:
            data.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(np.clip(255 * colours + 0.5, 0, 255), np.uint8), deep=True))
        self.mapper.SetInputData(data)

    def image(self):
        """[height, width, 3], bytes, first row at the top."""
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkCommonCore import vtkUnsignedCharArray
        self.window.Render()
        pixels = vtkUnsignedCharArray()
        self.window.GetRGBACharPixelData(0, 0, self.width - 1, self.height - 1, 0, pixels)
        return vtk_to_numpy(pixels).reshape(self.height, self.width, 4)[::-1, :, :3]

    def depths(self):
        """[height, width] from near (0) to far (1), first row at the bottom."""
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkCommonCore import vtkFloatArray
        self.window.Render()
        values = vtkFloatArray()
        self.window.GetZbufferData(0, 0, self.width - 1, self.height - 1, values)
        return vtk_to_numpy(values).reshape(self.height, self.width)


class Stage:
    """Draws shown frames as images [height, width, 3]."""

    _all = []

    def __init__(self, width, height, samples=2):
        self.width, self.height, self.samples = width, height, samples
        self.picture = Picture(samples * width, samples * height)
        self.depth_pixels = DEPTH_PIXELS[min(samples, 2)]
        self.shade = Picture(self.depth_pixels, self.depth_pixels)
        Stage._all.append(self)

    @staticmethod
    def close_all():
        for stage in Stage._all:
            for picture in (stage.picture, stage.shade):
                picture.window.Finalize()
        Stage._all.clear()

    def draw(self, view, shown):
        surface = shown.mesh if shown.ground is None else type(shown.mesh).joined([shown.mesh, shown.ground])
        bright = self._light(view, shown, surface)
        if shown.ground is not None:
            side = round(np.sqrt(len(shown.ground.points)))
            bright[-side * side:] = sky.smoothed(bright[-side * side:].reshape(side, side), 2).ravel()
        rods = slice(0, len(shown.mesh.points))
        bright[rods] += sky.from_the_eye(shown.mesh.points, shown.mesh.normals, view.camera.eye)
        colours = surface.colours * bright[:, None]
        colours[rods] += sky.highlight(shown.mesh.points, shown.mesh.normals, view.camera.eye, self._sun(view))[:, None] * np.clip(bright[rods, None] - 0.3, 0, 1)
        if shown.flat is not None:
            surface, colours = type(shown.mesh).joined([surface, shown.flat]), np.concatenate([colours, shown.flat.colours])
        self.picture.put(surface.points - view.centre, surface.faces, colours)
        camera = self.picture.camera
        camera.SetPosition(*(view.camera.eye - view.centre))
        camera.SetFocalPoint(*(view.camera.target - view.centre))
        camera.SetViewUp(*view.camera.up)
        camera.SetViewAngle(view.camera.angle)
        self.picture.renderer.ResetCameraClippingRange()
        image = self.picture.image()
        if self.samples == 1:
            return image
        blocks = image.reshape(self.height, self.samples, self.width, self.samples, 3)
        return blocks.mean(axis=(1, 3), dtype=np.float32).astype(np.uint8)

    @staticmethod
    def _sun(view):
        right, _, back = view.camera.axes
        return 0.9 * view.up - 0.5 * right + 0.35 * back

    def _light(self, view, shown, surface):
        if not len(shown.casts.points):
            return np.ones(len(surface.points))
        low, high = shown.casts.points.min(axis=0), shown.casts.points.max(axis=0)
        centre, size = 0.5 * (low + high), 0.51 * np.linalg.norm(high - low)
        self.shade.put(shown.casts.points - centre, shown.casts.faces)
        camera = self.shade.camera
        camera.ParallelProjectionOn()
        camera.SetParallelScale(size)
        camera.SetFocalPoint(0, 0, 0)
        camera.SetClippingRange(0.01 * size, 2.01 * size)

        def depth_from(right, above, towards):
            camera.SetPosition(*(1.01 * size * towards))
            camera.SetViewUp(*above)
            depth = self.shade.depths()
            return np.where(depth < 1, 2 * size * depth, np.inf)

        return sky.light(surface.points, surface.normals, depth_from, view.up, self._sun(view), centre, size, self.depth_pixels)
