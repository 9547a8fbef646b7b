// read_with_three.mjs FILE: what three.js finds in an exported .usda or .json, as JSON: points, tets, triangles (flat,
// as they stand) and `drawn`, the corners of the triangles that it would draw.
import { readFileSync } from "node:fs";
import { BufferAttribute, BufferGeometry } from "../../web/node_modules/three/build/three.module.js";
import { USDLoader } from "../../web/node_modules/three/examples/jsm/loaders/USDLoader.js";
import { USDAParser } from "../../web/node_modules/three/examples/jsm/loaders/usd/USDAParser.js";

function usda(text) {
  const { specsByPath } = new USDAParser().parseData(text);
  const array = (name) => Array.from(specsByPath[`/model/tets.${name}`].fields.default);
  const geometries = [];
  new USDLoader().parse(text).traverse((object) => object.geometry && geometries.push(object.geometry));
  if (specsByPath["/model/tets"].fields.typeName !== "TetMesh" || geometries.length !== 1) throw Error("wrong prims");
  return { points: array("points"), tets: array("tetVertexIndices"), triangles: array("surfaceFaceVertexIndices"),
           geometry: geometries[0] };
}

function tetJson(text) {
  const { verts, tetIds, tetSurfaceTriIds } = JSON.parse(text);
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float64Array(verts), 3));
  geometry.setIndex(tetSurfaceTriIds);
  return { points: verts, tets: tetIds, triangles: tetSurfaceTriIds, geometry };
}

const path = process.argv[2];
const text = readFileSync(path, "utf8");
const { geometry, ...found } = path.endsWith(".usda") ? usda(text) : tetJson(text);
const drawn = geometry.index ? geometry.toNonIndexed() : geometry;
console.log(JSON.stringify({ ...found, drawn: Array.from(drawn.attributes.position.array) }));
