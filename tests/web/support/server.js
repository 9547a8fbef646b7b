import {spawn} from 'node:child_process';
import {createInterface} from 'node:readline';
import {once} from 'node:events';

/// Starts `isochor serve` on a free port, or on the one given: {url, port, stop()}. ISOCHOR_BINARY names the program.
export async function start_server(port = 0, options = []) {
  if (process.env.ISOCHOR_URL) return {url: process.env.ISOCHOR_URL, stop() {}};
  const binary = process.env.ISOCHOR_BINARY;
  if (!binary) throw new Error('set ISOCHOR_BINARY to the built isochor program');
  const child = spawn(binary, ['serve', '--port', String(port), '--json', ...options], {stdio: ['ignore', 'pipe', 'inherit']});
  const lines = createInterface({input: child.stdout});
  const [first] = await Promise.race([once(lines, 'line'), once(child, 'exit').then(([code]) => {
    throw new Error(`isochor serve ended with ${code}`);
  })]);
  const {url} = JSON.parse(first);
  return {
    url: url.replace(/\/?$/, '/'),
    port: Number(new URL(url).port),
    async stop() {
      child.kill('SIGTERM');
      const [code] = await once(child, 'exit');
      if (code !== 0) throw new Error(`isochor serve ended with ${code}`);  // as a sanitizer that found something does
    },
  };
}
