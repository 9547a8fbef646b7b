import {default_state} from './defaults.js';
import {same} from './store.js';

// The whole state as a link: what differs from the defaults, as JSON in base64url behind '#'.
const kept = ['mesh', 'params', 'template', 'scene', 'speed', 'frame', 'view'];

export function encode_link(state, defaults) {
  const base = {...default_state, params: defaults.params, scene: defaults.scene};
  const difference = Object.fromEntries(kept.map(key => [key, differ(state[key], base[key])]).filter(([, value]) => value !== undefined));
  if (!Object.keys(difference).length) return '';
  const bytes = new TextEncoder().encode(JSON.stringify(difference));
  return `#${btoa(String.fromCharCode(...bytes)).replaceAll('+', '-').replaceAll('/', '_').replace(/=+$/, '')}`;
}

/// The difference of a link, or null when there is none or it is damaged.
export function decode_link(hash) {
  if (hash.length < 2) return null;
  try {
    const binary = atob(hash.slice(1).replaceAll('-', '+').replaceAll('_', '/'));
    const value = JSON.parse(new TextDecoder().decode(Uint8Array.from(binary, c => c.charCodeAt(0))));
    return plain(value) ? value : null;
  } catch {
    return null;
  }
}

/// base with the difference laid over it; keys that the base does not have are left out, but in what stands whole.
export function merge(base, difference) {
  if (plain(difference) && 'whole' in difference) return difference.whole;
  if (!plain(base) || !plain(difference)) return difference === undefined ? base : difference;
  return Object.fromEntries(Object.entries(base).map(([key, value]) => [key, key in difference ? merge(value, difference[key]) : value]));
}

const plain = value => value !== null && typeof value === 'object' && !Array.isArray(value);

/// An object with other keys than the base's stands whole, as a scene from a file does beside a template's.
function differ(value, base) {
  if (same(value, base)) return undefined;
  if (!plain(value) || !plain(base)) return value;
  if (!same(...[value, base].map(object => Object.keys(object).sort()))) return {whole: value};
  const entries = Object.entries(value).map(([key, item]) => [key, differ(item, base[key])]).filter(([, item]) => item !== undefined);
  return Object.fromEntries(entries);
}
