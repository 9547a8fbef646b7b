"""Prints what others find in FOLDER/clip.glb, .mdd, .pc2 and .tar: VTK's readers of glTF and VTU; MDD and PC2 by their formats."""
import json
import pathlib
import sys
import tarfile
import xml.etree.ElementTree as xml

import numpy
import vtk
from vtk.util.numpy_support import vtk_to_numpy

folder = pathlib.Path(sys.argv[1])


def read_mdd(data):
    frames, points = numpy.frombuffer(data, ">i4", 2)
    return numpy.frombuffer(data, ">f4", offset=8 + 4 * frames).reshape(frames, points, 3)


def read_pc2(data):
    assert data[:12] == b"POINTCACHE2\0"
    points, frames = numpy.frombuffer(data, "<i4", 5, 12)[[1, 4]]
    return numpy.frombuffer(data, "<f4", offset=32).reshape(frames, points, 3)


def read_glb(path):
    """Positions at the start and at the end, with the morph targets that VTK applied."""
    reader = vtk.vtkGLTFReader()
    reader.SetFileName(str(path))
    reader.ApplyDeformationsToGeometryOn()
    reader.UpdateInformation()
    reader.EnableAnimation(0)
    reader.SetFrameRate(60)
    reader.UpdateInformation()
    times = reader.GetOutputInformation(0).Get(vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    found = []
    for time in (times[0], times[-1]):
        reader.UpdateTimeStep(time)
        leaf = reader.GetOutput().NewIterator().GetCurrentDataObject()
        found.append(vtk_to_numpy(leaf.GetPoints().GetData()).copy())
    return found


def read_series(path):
    with tarfile.open(path) as archive:
        archive.extractall(path.parent)
    sets = xml.parse(next(path.parent.glob("*.pvd"))).getroot().iter("DataSet")
    times, tets, volumes = [], [], []
    for each in sets:
        reader = vtk.vtkXMLUnstructuredGridReader()
        reader.SetFileName(str(path.parent / each.get("file")))
        sizes = vtk.vtkCellSizeFilter()
        sizes.SetInputConnection(reader.GetOutputPort())
        sizes.Update()
        grid = sizes.GetOutput()
        assert grid.GetPointData().HasArray("displacement") and grid.GetCellData().HasArray("volume_error")
        times.append(float(each.get("timestep")))
        tets.append(grid.GetNumberOfCells())
        volumes.append(float(vtk_to_numpy(grid.GetCellData().GetArray("Volume")).sum()))
    return times, tets, volumes


mdd, pc2 = read_mdd((folder / "clip.mdd").read_bytes()), read_pc2((folder / "clip.pc2").read_bytes())
first, last = read_glb(folder / "clip.glb")
times, tets, volumes = read_series(folder / "clip.tar")
print(json.dumps({
    "largest_difference": float(numpy.abs(mdd - pc2).max()), "glb_points": len(first),
    "glb_difference": float(max(numpy.abs(first - pc2[0]).max(), numpy.abs(last - pc2[-1]).max())),
    "times": times, "tets": tets, "volumes": volumes}))
