import {Client} from '../wire/client.js';
import '../wire/data.js';  // starts its worker

/// The first import of the page: the server works, and the worker starts, while the browser reads the rest.
export const client = new Client();
export const tables = ['/parameters', '/samples'];
export const sample_path = name => `/meshes?sample=${encodeURIComponent(name)}`;

for (const path of tables) client.ahead('GET', path);
/// The sample of a first visit, or null.
export const first_sample = location.hash ? null : client.ahead('POST', sample_path('tree'));
