import test, {after, before} from 'node:test';
import assert from 'node:assert/strict';
import {createServer} from 'node:http';
import {once} from 'node:events';
import {browser_tests} from './support/browser.js';

// A page that the person has open elsewhere, and that knows where Isochor listens. It is served from another port of
// the same host, which is another origin though the same site: the hardest case; and from a name of its own.
const suite = browser_tests();
let stranger;

before(async () => {
  stranger = createServer((request, response) => {
    response.writeHead(200, {'Content-Type': 'text/html'});
    response.end('<!doctype html><title>elsewhere</title><body>');
  });
  stranger.listen(0, '127.0.0.1');
  await once(stranger, 'listening');
});
after(() => stranger.close());

const places = () => [`http://127.0.0.1:${stranger.address().port}/`, `http://localhost:${stranger.address().port}/`];

/// What the server holds: nothing of it may change.
async function holdings() {
  const read = async name => (await (await fetch(`${suite.server.url}api/v1/${name}`)).json())[name];
  const [meshes, models, simulations] = await Promise.all(['meshes', 'models', 'simulations'].map(read));
  return {meshes: meshes.map(mesh => mesh.id), models: models.map(model => model.id), simulations: simulations.map(s => s.id)};
}

/// The sample that the server makes at its start is no stranger's doing.
async function settled() {
  for (;;) {
    const {jobs} = await (await fetch(`${suite.server.url}api/v1/jobs`)).json();
    if (jobs.every(job => job.status === 'done')) return holdings();
    await new Promise(resolve => setTimeout(resolve, 50));
  }
}

async function from_elsewhere(attack) {
  const before_it = await settled();
  for (const place of places()) {
    const context = await suite.browser.newContext();
    const page = await context.newPage();
    await page.goto(place);
    await attack(page, suite.server.url);
    await context.close();
  }
  assert.deepEqual(await holdings(), before_it);
}

test('its requests change nothing and read nothing', () => from_elsewhere(async (page, url) => {
  const read = await page.evaluate(async base => {
    const seen = [];
    const tries = [
      ['api/v1/meshes', {}], ['', {}], ['api/v1/health', {mode: 'no-cors'}],
      ['api/v1/meshes?sample=cube', {method: 'POST'}],
      ['api/v1/meshes?sample=cube', {method: 'POST', mode: 'no-cors'}],
      ['api/v1/meshes?sample=cube', {method: 'POST', headers: {Authorization: 'Bearer guess'}}],
      ['api/v1/simulations', {method: 'POST', mode: 'no-cors', body: '{"sample":"drop"}'}],
      ['api/v1/simulations', {method: 'POST', headers: {'Content-Type': 'application/json'}, body: '{"sample":"drop"}'}],
      ['api/v1/meshes/x.obj', {method: 'PUT', body: 'v 0 0 0'}], ['api/v1/models/d1', {method: 'DELETE'}],
    ];
    for (const [path, options] of tries)
      try {
        const text = await (await fetch(base + path, {credentials: 'include', ...options})).text();
        if (text) seen.push(text);
      } catch (error) {}
    navigator.sendBeacon(base + 'api/v1/meshes?sample=sphere', 'v 0 0 0');
    return seen;
  }, url);
  assert.deepEqual(read, []);
}));

test('its forms change nothing', () => from_elsewhere(async (page, url) => {
  for (const type of ['application/x-www-form-urlencoded', 'text/plain', 'multipart/form-data']) {
    const answered = page.waitForResponse(response => response.url().startsWith(url));
    await page.evaluate(([base, enctype]) => {
      document.body.innerHTML = `<iframe name="sink"></iframe>
        <form method="post" target="sink" enctype="${enctype}" action="${base}api/v1/meshes?sample=torus">
        <input name='{"sample":"drop","x":"' value='"}'></form>`;
      document.querySelector('form').submit();
    }, [url, type]);
    assert.equal((await answered).status(), 403);
  }
}));

test('images, scripts, styles and frames bring it nothing', () => from_elsewhere(async (page, url) => {
  const loaded = await page.evaluate(async base => {
    const load = (tag, attributes) => new Promise(resolve => {
      const element = Object.assign(document.createElement(tag), attributes);
      element.onload = () => resolve(element);
      element.onerror = () => resolve(null);
      document.body.append(element);
      setTimeout(() => resolve(null), 3000);
    });
    const found = [];
    for (const [tag, attributes] of [['img', {src: base + 'icon.svg'}], ['script', {src: base + 'main.js'}],
      ['script', {src: base + 'main.js', type: 'module'}], ['link', {href: base + 'styles/theme.css', rel: 'stylesheet'}]])
      if (await load(tag, attributes)) found.push(tag);
    const frame = await load('iframe', {src: base});
    let inside = null;
    try {
      inside = frame?.contentDocument?.body?.textContent || frame?.contentWindow?.document?.title || null;
    } catch (error) {}
    return {found, inside};
  }, url);
  assert.deepEqual(loaded, {found: [], inside: null});
  const framed = page.frames().find(frame => frame.url().startsWith(url));
  assert.ok(!framed || !(await framed.content()).includes('isochor-token'), 'the page cannot be framed');
}));

test('a window that it opens tells it nothing', () => from_elsewhere(async (page, url) => {
  const popup = page.waitForEvent('popup');
  await page.evaluate(base => { window.other = window.open(base); }, url);
  const opened = await popup;
  await opened.waitForLoadState().catch(() => {});
  const seen = await page.evaluate(() => {
    try {
      return window.other.document.documentElement.innerHTML;
    } catch (error) {
      return null;
    }
  });
  assert.ok(!seen?.includes('isochor-token'), 'the opener does not read the page');
  const linked = page.waitForResponse(response => response.url().startsWith(url));
  await page.evaluate(base => { location.href = base + 'api/v1/meshes?sample=cube'; }, url);
  assert.equal((await linked).status(), 403, 'a link from another origin does not reach the API');
}));
