/// Requests to /api/v1. Every refusal becomes a Problem that carries the server's RFC 9457 document.
export class Problem extends Error {
  constructor(document) {
    super(document.detail ?? document.title ?? 'The request failed.');
    Object.assign(this, {status: 0, code: 'unknown', hint: '', errors: [], ...document, name: 'Problem'});
  }
}

const lost = () => new Problem({
  code: 'server_lost', title: 'The server does not answer',
  detail: 'The server does not answer.', hint: 'Start it again with server/run; the page goes on by itself.',
});

export class Client extends EventTarget {
  constructor(base = './api/v1') {
    super();
    this.base = base;
    this.begun = new Map();
    this.keep_token(document.querySelector('meta[name=isochor-token]').content || brought_token() || sessionStorage.getItem('isochor-token'));
    addEventListener('hashchange', () => this.take_brought_token());
  }

  /// An address that differs behind its # alone does not load the page again.
  take_brought_token() {
    const token = brought_token();
    if (!token) return;
    this.keep_token(token);
    location.reload();
  }

  keep_token(token) {
    this.token = token;
    if (token) sessionStorage.setItem('isochor-token', token);
  }

  /// What every request carries: a server that others can reach asks for the token to read as well.
  credentials() {
    return this.token ? {Authorization: `Bearer ${this.token}`} : {};
  }

  url(path) {
    return path.startsWith('/') && !path.startsWith('/api/') ? this.base + path : path;
  }

  /// For workers, whose own address is another.
  absolute(path) {
    return new URL(this.url(path), location.href).href;
  }

  /// Sends a request before anybody asks for its answer; the first who does takes it.
  ahead(method, path, json) {
    const answer = this.request(method, path, {json}).then(response => response.json());
    answer.catch(() => {});
    this.begun.set(key(method, path, json), answer);
    return answer;
  }

  begun_by(method, path, json) {
    const answer = this.begun.get(key(method, path, json));
    this.begun.delete(key(method, path, json));
    return answer;
  }

  async request(method, path, {json, body, headers = {}, signal} = {}) {
    const init = {method, signal, headers: {...this.credentials(), ...headers}};
    if (json !== undefined) {
      init.headers['Content-Type'] = 'application/json';
      init.body = JSON.stringify(json);
    } else if (body !== undefined) {
      init.body = body;
    }
    let response = await this.fetch(path, init);
    if (response.status === 503) {
      await new Promise(resolve => setTimeout(resolve, 1000 * (response.headers.get('Retry-After') ?? 1)));
      response = await this.fetch(path, init);
    }
    if (!response.ok) throw await problem_of(response);
    return response;
  }

  async fetch(path, init) {
    try {
      return await fetch(this.url(path), init);
    } catch (error) {
      if (error.name === 'AbortError') throw error;
      this.dispatchEvent(new Event('lost'));
      throw lost();
    }
  }

  async get(path, options) {
    return this.begun_by('GET', path) ?? (await this.request('GET', path, options)).json();
  }

  async send(method, path, json, options) {
    const begun = this.begun_by(method, path, json);
    if (begun) return begun;
    const response = await this.request(method, path, {json, ...options});
    return response.status === 204 ? null : response.json();
  }

  /// After the server came back: a new launch has a new token, which stands in a fresh copy of the page.
  async refresh_token() {
    const page = await (await fetch('./', {cache: 'no-store'})).text();
    const fresh = new DOMParser().parseFromString(page, 'text/html').querySelector('meta[name=isochor-token]')?.content;
    if (fresh) this.keep_token(fresh);
  }
}

const key = (...request) => JSON.stringify(request);

/// From another machine a person brings the token along behind #token=; it does not stay in the address.
function brought_token() {
  const [, token] = /^#token=([^&]+)$/.exec(location.hash) ?? [];
  if (token) history.replaceState(null, '', location.pathname);
  return token && decodeURIComponent(token);
}

async function problem_of(response) {
  const document = await response.json().catch(() => ({}));
  return new Problem({title: response.statusText, status: response.status, ...document});
}
