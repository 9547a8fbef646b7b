// Makes web/bundle, the folder that the server serves: the page's modules with three.js and uPlot in one file and its
// style sheets in another, since every file more is a connection more before the first picture. And web/report/bundle,
// the script and the style sheet that stand inside a self-contained report.
import {copyFile, mkdir} from 'node:fs/promises';
import {fileURLToPath} from 'node:url';

const here = path => fileURLToPath(new URL(path, import.meta.url));
const {build} = await import('esbuild').catch(() => {
  console.error('the page cannot be bundled: npm ci --prefix web installs what it needs; ISOCHOR_SERVER=OFF builds the library alone');
  process.exit(1);
});

await mkdir(here('bundle'), {recursive: true});
const bundle = (outdir, entryPoints) => build({
  absWorkingDir: here('.'), outdir, entryPoints, entryNames: '[name]', bundle: true, minify: true, format: 'esm',
  target: 'es2022', logLevel: 'warning', external: ['*.svg'],
});
await bundle('bundle', ['main.js', 'styles/page.css', 'wire/data_worker.js', 'wire/stream_worker.js']);
await bundle('report/bundle', ['report/report.js', 'report/report.css']);
for (const file of ['index.html', 'icon.svg']) await copyFile(here(file), here(`bundle/${file}`));
