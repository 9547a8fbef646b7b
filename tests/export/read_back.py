"""read_back.py READER FILE: reads an exported file with a reader of another project and prints what it found
as JSON: points, tets, triangles, the volume of the tets, the smallest one's, and that within the triangles."""
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np


def with_meshio(path):
    import meshio

    mesh = meshio.read(path)
    blocks = {block.type: block.data for block in mesh.cells}
    extra = {f"cell_data:{name}": float(np.sum(data[0])) for name, data in mesh.cell_data.items()}
    return mesh.points, blocks.get("tetra"), blocks.get("triangle"), extra


def with_gmsh(path):
    import gmsh

    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.open(path)
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    index = np.zeros(int(tags.max()) + 1, dtype=np.int64)
    index[tags] = np.arange(len(tags))

    def elements(kind, size):
        nodes = gmsh.model.mesh.getElementsByType(kind)[1]
        return index[nodes].reshape(-1, size) if len(nodes) else None

    return coordinates.reshape(-1, 3), elements(4, 4), elements(2, 3), {}


def with_vtk(path):
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOGeometry import vtkSTLReader
    from vtkmodules.vtkIOLegacy import vtkUnstructuredGridReader
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

    readers = {".vtu": vtkXMLUnstructuredGridReader, ".vtk": vtkUnstructuredGridReader, ".stl": vtkSTLReader}
    reader = readers[pathlib.Path(path).suffix]()
    reader.SetFileName(path)
    reader.Update()
    grid = reader.GetOutput()
    points = vtk_to_numpy(grid.GetPoints().GetData()).astype(float)
    cells = grid.GetPolys() if path.endswith(".stl") else grid.GetCells()
    size = 3 if path.endswith(".stl") else 4
    data = grid.GetCellData()
    arrays = [data.GetArray(i) for i in range(data.GetNumberOfArrays())]
    extra = {f"cell_data:{array.GetName()}": float(vtk_to_numpy(array).sum()) for array in arrays}
    connectivity = vtk_to_numpy(cells.GetConnectivityArray()).reshape(-1, size)
    return (points, None, connectivity, extra) if size == 3 else (points, connectivity, None, extra)


def with_tetgen(path):
    """TetGen itself reconstructs the mesh from the three files and writes it anew."""
    stem = pathlib.Path(path).with_suffix("")
    with tempfile.TemporaryDirectory() as folder:
        for suffix in (".node", ".ele", ".face"):
            pathlib.Path(folder, "set" + suffix).write_bytes(stem.with_suffix(suffix).read_bytes())
        subprocess.run(["tetgen", "-rQ", "set.node"], cwd=folder, check=True, stdout=subprocess.DEVNULL)

        def table(suffix):
            text = pathlib.Path(folder, "set.1" + suffix).read_text()
            rows = [line.split() for line in text.splitlines() if line.split() and not line.startswith("#")]
            return rows[1:]

        points = np.array([[float(x) for x in row[1:4]] for row in table(".node")])
        tets = np.array([[int(x) for x in row[1:5]] for row in table(".ele")])
        faces = np.array([[int(x) for x in row[1:4]] for row in table(".face") if row[-1] != "0"])
    return points, tets, None, {"boundary_faces": len(faces)}


def with_three(path):
    """three.js by node: the arrays as its USDA parser gives them, and the triangles that it would draw."""
    script = pathlib.Path(__file__).with_name("read_with_three.mjs")
    found = json.loads(subprocess.run(["node", script, path], check=True, capture_output=True).stdout)
    points, tets, triangles = (np.array(found[name]) for name in ("points", "tets", "triangles"))
    points, tets, triangles = points.reshape(-1, 3), tets.reshape(-1, 4), triangles.reshape(-1, 3)
    drawn = np.array(found["drawn"]).reshape(-1, 3)
    shift = np.abs(points[triangles].reshape(-1, 3) - drawn).max()
    return points, tets, triangles, {"shift_of_drawn": float(shift), **edges_of_json(path, tets)}


def edges_of_json(path, tets):
    """tetEdgeIds, which only that format has: each edge once."""
    if not path.endswith(".json"):
        return {}
    listed = np.array(json.loads(pathlib.Path(path).read_text())["tetEdgeIds"]).reshape(-1, 2)
    wanted = {tuple(sorted((int(t[a]), int(t[b])))) for t in tets for a in range(4) for b in range(a)}
    assert len(listed) == len(wanted) and {tuple(edge) for edge in listed.tolist()} == wanted
    return {"edges": len(listed)}


READERS = {"meshio": with_meshio, "gmsh": with_gmsh, "vtk": with_vtk, "tetgen": with_tetgen,
           "three": with_three}


def main():
    points, tets, triangles, extra = READERS[sys.argv[1]](sys.argv[2])
    found = {"points": len(points), "tets": 0, "triangles": 0, **extra}
    used = set()
    if tets is not None:
        a, b, c, d = (points[tets[:, i]] for i in range(4))
        volumes = np.einsum("ij,ij->i", b - a, np.cross(c - a, d - a)) / 6
        found.update(tets=len(tets), volume=float(volumes.sum()), smallest=float(volumes.min()))
        used |= set(tets.ravel().tolist())
    if triangles is not None:
        a, b, c = (points[triangles[:, i]] for i in range(3))
        found.update(triangles=len(triangles), enclosed=float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6))
        used |= set(triangles.ravel().tolist())
    found["orphans"] = len(points) - len(used)
    print(json.dumps(found))


if __name__ == "__main__":
    main()
