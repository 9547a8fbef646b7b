import {execFileSync, spawn} from 'node:child_process';
import {existsSync} from 'node:fs';
import {mkdtemp, readFile, rm, writeFile} from 'node:fs/promises';
import {connect, createServer} from 'node:net';
import {once} from 'node:events';
import {tmpdir} from 'node:os';
import {join} from 'node:path';

export const nginx = ['/usr/sbin/nginx', '/usr/bin/nginx', '/usr/local/sbin/nginx'].find(existsSync);

/// nginx with TLS in front of a server at this port, by the block that the README gives: {url, stop()}.
export async function start_proxy(port) {
  const folder = await mkdtemp(join(tmpdir(), 'isochor-proxy-'));
  execFileSync('openssl', ['req', '-x509', '-newkey', 'ec', '-pkeyopt', 'ec_paramgen_curve:P-256', '-nodes', '-days', '2', '-subj', '/CN=localhost',
    '-keyout', 'key.pem', '-out', 'cert.pem'], {cwd: folder, stdio: 'ignore'});
  const own = await free_port();
  await writeFile(join(folder, 'nginx.conf'), configuration(own, (await block_of_readme()).replace('ADDRESS:8080', `127.0.0.1:${port}`)));
  const child = spawn(nginx, ['-p', folder, '-e', 'stderr', '-c', 'nginx.conf'], {stdio: ['ignore', 'ignore', 'inherit']});
  await accepting(own, child);
  return {
    url: `https://localhost:${own}/`,
    async stop() {
      child.kill('SIGTERM');
      await once(child, 'exit');
      await rm(folder, {recursive: true});
    },
  };
}

async function block_of_readme() {
  const readme = await readFile(new URL('../../../README.md', import.meta.url), 'utf8');
  return /```nginx\n([^]*?)```/.exec(readme)[1];
}

// One process, so that no other user needs to reach the folder.
const configuration = (port, block) => `
daemon off;
master_process off;
pid nginx.pid;
events {}
http {
  access_log off;
  ${['client_body', 'proxy', 'fastcgi', 'uwsgi', 'scgi'].map(name => `${name}_temp_path ${name};`).join(' ')}
  server {
    listen 127.0.0.1:${port} ssl http2;
    ssl_certificate cert.pem;
    ssl_certificate_key key.pem;
    ${block}
  }
}
`;

async function free_port() {
  const server = createServer().listen(0, '127.0.0.1');
  await once(server, 'listening');
  const {port} = server.address();
  server.close();
  await once(server, 'close');
  return port;
}

async function accepting(port, child) {
  for (;;) {
    if (child.exitCode !== null) throw new Error(`nginx ended with ${child.exitCode}`);
    const socket = connect(port, '127.0.0.1');
    const open = await new Promise(resolve => socket.once('connect', () => resolve(true)).once('error', () => resolve(false)));
    socket.destroy();
    if (open) return;
    await new Promise(resolve => setTimeout(resolve, 20));
  }
}
