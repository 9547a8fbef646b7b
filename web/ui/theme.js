const known = new Map();

/// A colour of the style sheet; read once a theme, for asking lays the page out.
export function theme_color(name) {
  const key = `${document.documentElement.dataset.theme} ${name}`;
  if (!known.has(key)) known.set(key, getComputedStyle(document.documentElement).getPropertyValue(name).trim());
  return known.get(key);
}
