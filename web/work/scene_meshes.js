import {Problem} from '../wire/client.js';
import {file_name, mesh_files} from '../state/scene_templates.js';
import {choose_files} from '../ui/dom.js';

export const mesh_types = '.obj,.stl,.ply,.off,.glb';

/// The meshes that a scene names by their files: those of the samples, those that a person opened, and those that the
/// server has under that name.
export const scene_meshes = app => {
  const {client, meshing} = app;
  const ids = new Map(), chosen = new Map();  // by the name that a scene has for the file
  const sample = name => app.samples.meshes.find(({file}) => file_name(file) === name);

  const find = async (name, stored) => {
    const file = chosen.get(name) ?? [...meshing.files.values()].findLast(opened => opened.name === name);
    const known = file ? stored.filter(({id}) => meshing.files.get(id) === file) : stored.filter(mesh => mesh.name === name);
    if (known.length === 1) return known[0].id;
    return file ? (await meshing.upload(file)).id : null;
  };

  return {
    /// What the server knows the mesh by, once it was found.
    mesh_of_file: path => sample(file_name(path))?.file ?? ids.get(file_name(path)) ?? path,
    /// Finds all meshes of a scene; those that are missing are asked for.
    async find_meshes(scene) {
      const wanted = mesh_files(scene).map(file_name).filter(name => name.includes('.') && !sample(name));
      if (!wanted.length) return;
      const {meshes: stored} = await client.get('/meshes');
      const found = await Promise.all(wanted.map(name => find(name, stored)));
      wanted.forEach((name, k) => ids.set(name, found[k]));
      const missing = wanted.filter((_, k) => !found[k]);
      if (missing.length) throw missing_meshes(scene, missing);
    },
    /// Files for the scene's meshes; a single one may have another name than the scene has for it.
    async take_meshes(files, missing = []) {
      for (const file of files) {
        await meshing.upload(file);
        chosen.set(files.length === 1 && missing.length === 1 ? missing[0] : file.name, file);
      }
    },
    choose_meshes: async missing => app.take_meshes(await choose_files(mesh_types), missing),
  };
};

const missing_meshes = ({name}, missing) => new Problem({
  code: 'mesh_missing', missing, detail: `The scene “${name}” needs ${missing.join(' and ')}, which ${missing.length > 1 ? 'are' : 'is'} not open.`,
  hint: 'Open the mesh here, or drop the scene on the page together with its meshes.',
});
