#!/usr/bin/env python3
"""Writes the sample meshes into meshes/: python3 make_meshes.py. The same bytes every time; y is up."""
import itertools
import math
import random
from pathlib import Path

FOLDER = Path(__file__).parent / "meshes"


class Soup:
    """Positions and polygons; nothing is shared between the pieces that are added."""

    def __init__(self):
        self.positions, self.faces = [], []

    def add(self, positions, faces):
        first = len(self.positions)
        self.positions += positions
        self.faces += [[first + index for index in face] for face in faces]

    def write(self, name, comment):
        lines = [f"# {comment}"]
        lines += ["v " + " ".join(f"{c + 0.0:.5g}" for c in p) for p in self.positions]
        lines += ["f " + " ".join(str(index + 1) for index in face) for face in self.faces]
        (FOLDER / name).write_text("\n".join(lines) + "\n")


def add(a, b, factor=1.0):
    return tuple(x + factor * y for x, y in zip(a, b))


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def normalized(a):
    length = math.sqrt(dot(a, a))
    return tuple(x / length for x in a)


def frame(axis):
    """Two unit vectors that complete the axis to a right-handed frame."""
    side = (1.0, 0.0, 0.0) if abs(axis[0]) < 0.8 else (0.0, 0.0, 1.0)
    u = normalized(cross(side, axis))
    return u, cross(axis, u)


def tube(path, radii, sides):
    """An open tube around a path: no caps, so that the soup has boundaries."""
    positions, faces = [], []
    for index, (point, radius) in enumerate(zip(path, radii)):
        axis = normalized(add(path[min(index + 1, len(path) - 1)], path[max(index - 1, 0)], -1.0))
        u, v = frame(axis)
        for side in range(sides):
            angle = 2 * math.pi * side / sides
            ring = add(add(point, u, radius * math.cos(angle)), v, radius * math.sin(angle))
            positions.append(ring)
    for ring in range(len(path) - 1):
        for side in range(sides):
            a, b = ring * sides + side, ring * sides + (side + 1) % sides
            faces.append([a, b, b + sides, a + sides])
    return positions, faces


def leaf(base, direction, length, rng):
    """A single quad: a rhombus with its stalk at base."""
    u, v = frame(direction)
    roll = rng.uniform(0, math.pi)
    side = add(tuple(math.cos(roll) * x for x in u), v, math.sin(roll))
    middle = add(base, direction, 0.45 * length)
    corners = [base, add(middle, side, 0.3 * length), add(base, direction, length), add(middle, side, -0.3 * length)]
    return corners, [[0, 1, 2, 3]]


# One row an order of branching: children, length, radius, sides, rings, pitch from the parent in degrees.
ORDERS = [
    (8, 1.25, 0.105, 8, 8, 0),
    (6, 0.80, 0.045, 6, 5, 55),
    (4, 0.42, 0.020, 5, 4, 50),
    (0, 0.22, 0.009, 3, 3, 45),
]
GOLDEN_ANGLE = math.pi * (3 - math.sqrt(5))


def grow(soup, base, direction, order, size, rng):
    """A branch that bends up to the light, its children around it by the golden angle, then its leaves."""
    children, length, radius, sides, rings, _ = ORDERS[order]
    path, radii = [base], [size * radius]
    for ring in range(1, rings):
        bend = 0.0 if order == 0 and ring == 1 else 0.09
        wander = [rng.uniform(-bend, bend) for _ in range(3)]
        direction = normalized(add(add(direction, wander), (0.0, 1.0, 0.0), 0.16))
        path.append(add(path[-1], direction, size * length / (rings - 1)))
        radii.append(size * radius * (1 - 0.6 * ring / (rings - 1)))
    soup.add(*tube(path, radii, sides))

    phase = rng.uniform(0, 2 * math.pi)
    for child in range(children):
        # The trunk is bare below; a crown is widest at a third of its height.
        along = (0.36 if order == 0 else 0.30) + (0.64 if order == 0 else 0.70) * (child + 0.5) / children
        start, axis = on_path(path, along)
        pitch = math.radians(ORDERS[order + 1][5]) * (1.25 - 0.5 * along)
        turn = phase + child * GOLDEN_ANGLE
        u, v = frame(axis)
        out = add(tuple(math.cos(turn) * x for x in u), v, math.sin(turn))
        child_direction = normalized(add(tuple(math.cos(pitch) * x for x in axis), out, math.sin(pitch)))
        grow(soup, start, child_direction, order + 1, size * (1.12 - 0.4 * along), rng)
    if order >= 2:
        add_leaves(soup, path, 4 if order == 3 else 3, size, rng)


def on_path(path, along):
    """Point and direction at a fraction of the path."""
    where = min(along * (len(path) - 1), len(path) - 1.001)
    segment = int(where)
    edge = add(path[segment + 1], path[segment], -1.0)
    return add(path[segment], edge, where - segment), normalized(edge)


def add_leaves(soup, path, count, size, rng):
    for index in range(count):
        base, axis = on_path(path, 0.25 + 0.75 * (index + 1) / count)
        u, v = frame(axis)
        turn = rng.uniform(0, 2 * math.pi)
        out = add(tuple(math.cos(turn) * x for x in u), v, math.sin(turn))
        soup.add(*leaf(base, normalized(add(axis, out, 0.9)), size * rng.uniform(0.13, 0.19), rng))


def tree():
    soup = Soup()
    grow(soup, (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 0, 1.0, random.Random(3))
    soup.write("tree.obj", "A tree as an open soup: branches are open tubes, leaves are single quads.")


def box(low, high):
    corners = [tuple((low, high)[bit >> axis & 1][axis] for axis in range(3)) for bit in range(8)]
    return corners, [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]


def cube():
    soup = Soup()
    soup.add(*box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)))
    soup.write("cube.obj", "A cube of edge length 1 about the origin.")


def union_of_boxes(planes, inside):
    """The closed boundary of those boxes between the planes of each axis that are inside."""
    counts = [len(p) - 1 for p in planes]
    kept = {c for c in itertools.product(*map(range, counts)) if inside(*c)}
    soup, index = Soup(), {}
    for cell in sorted(kept):
        corners, faces = box(tuple(planes[a][cell[a]] for a in range(3)), tuple(planes[a][cell[a] + 1] for a in range(3)))
        for side, face in enumerate(faces):
            neighbour = list(cell)
            neighbour[side // 2] += 2 * (side % 2) - 1
            if tuple(neighbour) in kept:
                continue
            soup.faces.append([index.setdefault(corners[corner], len(index)) for corner in face])
    soup.positions = list(index)
    return soup


def table():
    """Legs three cells of 1/24 wide: each is symmetric about planes through the middle of its cells."""
    cell = 1 / 24
    across = [-12 * cell, -10 * cell, -7 * cell, 7 * cell, 10 * cell, 12 * cell]
    up = [0.0, 12 * cell, 16 * cell]
    soup = union_of_boxes([across, up, across], lambda i, j, k: j == 1 or (i in (1, 3) and k in (1, 3)))
    soup.write("table.obj", "A table: sharp corners, and legs that are symmetric each by itself.")


def sphere(subdivisions=3, radius=0.5):
    """An icosphere: each round cuts a triangle into four and lifts the midpoints to the sphere."""
    golden = (1 + math.sqrt(5)) / 2
    positions = [normalized(p) for s in (-1, 1) for t in (-golden, golden)
                 for p in ((0, s, t), (s, t, 0), (t, 0, s))]
    edge = min(math.dist(positions[0], p) for p in positions[1:]) * 1.01
    near = lambda a, b: a != b and math.dist(positions[a], positions[b]) < edge
    faces = [[a, b, c] for a in range(12) for b in range(a + 1, 12) for c in range(b + 1, 12)
             if near(a, b) and near(b, c) and near(a, c)]
    faces = [f if dot(cross(positions[f[0]], positions[f[1]]), positions[f[2]]) > 0 else f[::-1] for f in faces]
    for _ in range(subdivisions):
        middles, finer = {}, []

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                middles[key] = len(positions)
                positions.append(normalized(add(positions[a], positions[b])))
            return middles[key]

        for a, b, c in faces:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
        faces = finer
    soup = Soup()
    soup.add([tuple(radius * c for c in p) for p in positions], faces)
    soup.write("sphere.obj", f"A sphere of radius {radius} about the origin.")


def torus(around=48, across=24, major=0.35, minor=0.15):
    positions, faces = [], []
    for i in range(around):
        for j in range(across):
            u, v = 2 * math.pi * i / around, 2 * math.pi * j / across
            ring = major + minor * math.cos(v)
            positions.append((ring * math.cos(u), minor * math.sin(v), ring * math.sin(u)))
            a, b = i * across + j, i * across + (j + 1) % across
            c, d = (i + 1) % around * across + (j + 1) % across, (i + 1) % around * across + j
            faces.append([a, b, c, d])
    soup = Soup()
    soup.add(positions, faces)
    soup.write("torus.obj", f"A torus about the y axis, radii {major} and {minor}.")


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for make in (tree, cube, sphere, torus, table):
        make()
