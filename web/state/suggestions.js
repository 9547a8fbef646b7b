/// One-click ways on that a warning or a hint names in words: "try p_in_voxels 2.5", "set contacts to fill", "try 48 cells",
/// "try 30 cells and 60 voxels", "try the preset thin". Each is {title, values}.
export function suggestions(text, {parameters, presets, defaults}) {
  const found = [];
  const [, cells, voxels] = /\btry (\d+) cells(?: and (\d+) voxels)?\b/.exec(text) ?? [];
  if (cells && !voxels) found.push({title: `Set Cells to ${cells}`, values: {cells: Number(cells)}});
  else if (cells) found.push({title: `Set Cells to ${cells} and Voxels to ${voxels}`, values: {cells: Number(cells), voxels: Number(voxels)}});
  for (const parameter of parameters) {
    const match = new RegExp(`\\b${parameter.name}\\b(?: to)? (\\S+?)(?=[\\s,;.]*(?:$|\\s))`).exec(text);
    const value = match && read_value(parameter, match[1]);
    if (value !== null && value !== undefined) found.push({title: `Set ${parameter.title} to ${value}`, values: {[parameter.name]: value}});
  }
  const preset = presets.find(({name}) => new RegExp(`\\bpreset ${name}\\b`).test(text));
  if (preset) found.push({title: `Use the preset “${preset.title}”`, values: {...defaults, ...preset.values}});
  if (/\blargest_only\b/.test(text)) found.push({title: 'Keep the largest part', values: {largest_only: true}});
  return found;
}

/// Parameters by their titles in place of their names.
export const in_titles = (text, {parameters}) => parameters.filter(({name}) => name.includes('_'))
  .reduce((said, {name, title}) => said.replace(new RegExp(`\\b${name}\\b`, 'g'), `“${title}”`), text);

function read_value({type, choices, min, max}, word) {
  if (type === 'choice') return choices.find(choice => String(choice) === word) ?? null;
  const value = Number(word);
  return word !== '' && value >= min && value <= max ? value : null;
}
