const superscripts = '⁰¹²³⁴⁵⁶⁷⁸⁹';
const english = new Intl.NumberFormat('en', {maximumFractionDigits: 6});  // toLocaleString makes one a call

/// 3 significant digits; powers of ten where they are easier to read.
export function number(value, digits = 3) {
  if (value === null || value === undefined || Number.isNaN(value)) return '–';
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (!Number.isFinite(value)) return value > 0 ? '∞' : '−∞';
  if (size >= 1e5 || size < 1e-3) return power(value);
  return english.format(Number(value.toPrecision(digits))).replace('-', '−');
}

function power(value) {
  const exponent = Math.floor(Math.log10(Math.abs(value)));
  const mantissa = (value / 10 ** exponent).toFixed(1).replace('-', '−');
  const raised = String(Math.abs(exponent)).replace(/\d/g, digit => superscripts[digit]);
  return `${mantissa}·10${exponent < 0 ? '⁻' : ''}${raised}`;
}

export const count = value => Number.isFinite(value) ? english.format(Math.round(value)) : '–';
export const milliseconds = ms =>
  !Number.isFinite(ms) ? '–' : ms >= 1000 ? `${(ms / 1000).toFixed(ms < 1e4 ? 1 : 0)} s` : `${ms < 10 ? ms.toFixed(1) : Math.round(ms)} ms`;
/// An estimate, with no more digits than it has.
export function about(seconds) {
  const minutes = seconds / 60;
  if (seconds < 10) return `about ${Math.max(1, Math.round(seconds))} s`;
  if (seconds < 90) return `about ${5 * Math.round(seconds / 5)} s`;
  return minutes < 10 ? `about ${Math.round(minutes)} min` : minutes < 90 ? `about ${5 * Math.round(minutes / 5)} min` : `about ${Math.round(minutes / 30) / 2} h`;
}
export const percent = value => Number.isFinite(value) ? `${(100 * value).toFixed(value < 0.9995 && value > 0 ? 1 : 0)} %` : '–';

export function bytes(value) {
  if (!Number.isFinite(value)) return '–';
  const units = ['B', 'KB', 'MB', 'GB'];
  let unit = 0;
  while (value >= 1000 && unit < 3) value /= 1000, ++unit;
  return `${value < 10 && unit ? value.toFixed(1) : Math.round(value)} ${units[unit]}`;
}

/// A first word in small letters begins with a capital; names of files and programs stay as they are.
export const capital = text => text.replace(/^[a-z]+(?=[\s,:])/, word => word.charAt(0).toUpperCase() + word.slice(1));
/// What the server says, as a sentence of its own.
export const sentence = text => capital(text).replace(/[^.!?]$/, '$&.');

export const words = name => String(name).replaceAll('_', ' ');

/// "1 edge", "2 edges", "1 vertex": a count with its noun, given in the plural.
export const counted = (n, nouns) => `${count(n)} ${n === 1 ? nouns.replace(/ices$/, 'exs').replace(/s$/, '') : nouns}`;
