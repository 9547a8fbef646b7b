// What npm installs runs on Debian 12's Node 18, whatever Node this machine has; without it there is no page.
import assert from 'node:assert/strict';
import {spawnSync} from 'node:child_process';
import {copyFileSync, existsSync, mkdtempSync, readFileSync, rmSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {test} from 'node:test';

const DEBIAN_12_NODE = 18;

for (const folder of ['.', '../../web']) {
  const lock = JSON.parse(readFileSync(new URL(`${folder}/package-lock.json`, import.meta.url)));
  for (const [name, {engines}] of Object.entries(lock.packages)) {
    if (!engines?.node) continue;
    test(`${name} runs on Node ${DEBIAN_12_NODE}`, () => {
      // One alternative of a range such as ">=4" or "^14 || >=16" has to reach down to it.
      const oldest = Math.min(...[...engines.node.matchAll(/(\d+)(\.\d+)*/g)].map((match) => Number(match[1])));
      assert.ok(oldest <= DEBIAN_12_NODE, `${name} asks for Node ${engines.node}`);
    });
  }
}

test('a build without npm\'s packages ends with what to do', () => {
  const folder = mkdtempSync(join(tmpdir(), 'isochor-'));
  copyFileSync(new URL('../../web/bundle.js', import.meta.url), join(folder, 'bundle.mjs'));
  const {status, stderr} = spawnSync(process.execPath, [join(folder, 'bundle.mjs')], {encoding: 'utf8'});
  assert.equal(status, 1);
  assert.match(stderr, /npm ci --prefix web/);
  assert.ok(!existsSync(join(folder, 'bundle')));
  rmSync(folder, {recursive: true});
});
