"""The same spheres by VTK's sphere mapper: vtk_spheres.py FILE.xyzr X Y Z FOV SIZE REPEATS, the eye looking along +x.

Prints the median milliseconds of a frame with its read-back, by wall clock and by the process, and the part covered.
Needs python3-vtk9 and python3-numpy, and a display.
"""
import sys
import time

import numpy as np
import vtkmodules.all as vtk
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy

path, x, y, z, fov, size, repeats = sys.argv[1], *map(float, sys.argv[2:5]), float(sys.argv[5]), *map(int, sys.argv[6:8])
data = np.loadtxt(path, usecols=(0, 1, 2, 3), dtype=np.float32)
points = vtk.vtkPoints()
points.SetData(numpy_to_vtk(data[:, :3].copy(), deep=1))
spheres = vtk.vtkPolyData()
spheres.SetPoints(points)
radii = numpy_to_vtk(data[:, 3].copy(), deep=1)
radii.SetName("radius")
spheres.GetPointData().AddArray(radii)
cells = vtk.vtkCellArray()
for i in range(len(data)):
    cells.InsertNextCell(1, [i])
spheres.SetVerts(cells)
mapper = vtk.vtkOpenGLSphereMapper()
mapper.SetInputData(spheres)
mapper.SetScaleArray("radius")
mapper.ScalarVisibilityOff()
actor = vtk.vtkActor()
actor.SetMapper(mapper)
renderer = vtk.vtkRenderer()
renderer.AddActor(actor)
window = vtk.vtkRenderWindow()
window.SetOffScreenRendering(1)
window.SetMultiSamples(0)
window.SetSize(size, size)
window.AddRenderer(renderer)
camera = renderer.GetActiveCamera()
camera.SetViewAngle(fov)
camera.SetPosition(x, y, z)
camera.SetFocalPoint(x + 1, y, z)
camera.SetViewUp(0, 0, 1)
renderer.ResetCameraClippingRange()
pixels = vtk.vtkUnsignedCharArray()
wall, spent = [], []
for i in range(repeats + 1):
    start, process = time.perf_counter(), time.process_time()
    window.Render()
    window.GetPixelData(0, 0, size - 1, size - 1, 0, pixels, 0)
    wall.append(time.perf_counter() - start)
    spent.append(time.process_time() - process)
image = vtk_to_numpy(pixels).reshape(size, size, 3)
print(1e3 * np.median(wall[1:]), 1e3 * np.median(spent[1:]), (image.sum(2) > 0).mean())
