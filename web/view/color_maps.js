// Perceptual colour maps, interpolated in Oklab between a few anchors whose lightness grows evenly.
const anchors = {
  /// violet → blue → teal → yellow; readable with every kind of colour blindness
  sequential: [[70, 16, 98], [64, 68, 142], [42, 112, 146], [36, 150, 138], [88, 192, 108], [178, 218, 76], [252, 231, 84]],
  /// for errors: calm where small, glowing where large
  error: [[40, 52, 84], [48, 96, 140], [76, 150, 160], [190, 196, 120], [244, 158, 66], [226, 60, 48]],
};

const linear = channel => {
  const c = channel / 255;
  return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
};
const encoded = c => Math.round(255 * Math.min(1, Math.max(0, c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055)));

// Oklab [Ottosson 2020].
function to_oklab(rgb) {
  const [r, g, b] = rgb.map(linear);
  const l = Math.cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
  const m = Math.cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
  const s = Math.cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
  return [0.2104542553 * l + 0.793617785 * m - 0.0040720468 * s,
    1.9779984951 * l - 2.428592205 * m + 0.4505937099 * s,
    0.0259040371 * l + 0.7827717662 * m - 0.808675766 * s];
}

function from_oklab([L, a, b]) {
  const l = (L + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (L - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (L - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s].map(encoded);
}

/// 256 sRGB triples.
function make_map(colors) {
  const points = colors.map(to_oklab);
  const map = new Uint8Array(256 * 4);
  for (let i = 0; i < 256; ++i) {
    const at = i / 255 * (points.length - 1);
    const k = Math.min(points.length - 2, Math.floor(at));
    const mixed = points[k].map((value, axis) => value + (at - k) * (points[k + 1][axis] - value));
    map.set([...from_oklab(mixed), 255], 4 * i);
  }
  return map;
}

export const color_maps = Object.fromEntries(Object.entries(anchors).map(([name, colors]) => [name, make_map(colors)]));

export function css_color(map, fraction) {
  const i = 4 * Math.round(255 * Math.min(1, Math.max(0, fraction)));
  return `rgb(${map[i]} ${map[i + 1]} ${map[i + 2]})`;
}
