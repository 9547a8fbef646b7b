/// The JSON Schema of /parameters as a list of parameters, in its order.
export function read_schema(schema) {
  return Object.entries(schema.properties).map(([name, row]) => ({
    name,
    title: row.title ?? name,
    meaning: row.description ?? '',
    unit: row['x-unit'] ?? '',
    stage: row['x-stage'],
    type: row.enum ? 'choice' : row.type,
    choices: row.enum ?? [],
    min: row.minimum,
    max: row.maximum,
    step: row['x-step'] ?? row.multipleOf ?? (row.type === 'integer' ? 1 : 'any'),
    fallback: row.default ?? null,
  }));
}

export const default_params = parameters => Object.fromEntries(parameters.map(({name, fallback}) => [name, fallback]));
