"""read_back.py READER FILE: reads an exported file with a reader of another project and prints what it found
as JSON: points, tets, triangles, the volume of the tets, the smallest one's, and that within the triangles."""
import json
import pathlib
import re
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


def with_structure_of_usda(path):
    """No USD in Debian: the prims and their arrays, by the grammar of the text."""
    text = pathlib.Path(path).read_text()
    assert text.startswith("#usda 1.0\n")
    assert text.count("{") == text.count("}") and text.count("(") == text.count(")")
    prims = {m[2]: (m[1], m[3]) for m in re.finditer(r'    def (\w+) "(\w+)"\n    \{\n(.*?)\n    \}', text, re.S)}

    def array(prim, name):
        values = re.search(rf" {name} = \[(.*?)\]\n", prims[prim][1] + "\n", re.S)[1]
        return np.array([float(x) for x in re.findall(r"[-+.\deE]+", values)])

    assert prims["tets"][0] == "TetMesh" and prims["surface"][0] == "Mesh"
    assert 'orientation = "rightHanded"' in prims["tets"][1]
    points = array("tets", r"point3f\[\] points").reshape(-1, 3)
    tets = array("tets", r"int4\[\] tetVertexIndices").astype(int).reshape(-1, 4)
    faces = array("tets", r"int3\[\] surfaceFaceVertexIndices").astype(int).reshape(-1, 3)
    own = array("surface", r"point3f\[\] points").reshape(-1, 3)
    indices = array("surface", r"int\[\] faceVertexIndices").astype(int)
    counts = array("surface", r"int\[\] faceVertexCounts")
    assert np.all(counts == 3) and len(indices) == 3 * len(counts)
    assert sorted(set(indices)) == list(range(len(own))), "orphan points in the companion mesh"
    assert np.array_equal(own[indices], points[faces].reshape(-1, 3))
    return points, tets, faces, {}


def with_json(path):
    data = json.loads(pathlib.Path(path).read_text())
    edges = {tuple(edge) for edge in np.array(data["tetEdgeIds"]).reshape(-1, 2)}
    tets = np.array(data["tetIds"]).reshape(-1, 4)
    wanted = {tuple(sorted((int(t[a]), int(t[b])))) for t in tets for a in range(4) for b in range(a)}
    assert edges == wanted and len(data["tetEdgeIds"]) == 2 * len(wanted)
    return np.array(data["verts"]).reshape(-1, 3), tets, np.array(data["tetSurfaceTriIds"]).reshape(-1, 3), {}


READERS = {"meshio": with_meshio, "gmsh": with_gmsh, "vtk": with_vtk, "tetgen": with_tetgen,
           "usda": with_structure_of_usda, "json": with_json}


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
