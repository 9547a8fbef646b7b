/// What a person sees in the view: counts of pixels by what they look like, and a checksum of them all. The tets have
/// saturated colours of the map, the input's surface is sand, inverted tets and nothing else are crimson.
export async function look(page) {
  const box = await page.locator('canvas.view').boundingBox();
  const margin = 110;  // the controls over the view
  const clip = {x: box.x + 8, y: box.y + margin, width: box.width - 16, height: box.height - margin - 60};
  return look_at_picture(page, await page.screenshot({clip}));
}

/// The same of a PNG's rows between two shares of its height.
export async function look_at_picture(page, png, from = 0, to = 1) {
  const browser = page.context().browser();
  if (!readers.has(browser)) readers.set(browser, browser.newPage());
  return (await readers.get(browser)).evaluate(count_colors, {png: png.toString('base64'), from, to});
}

/// In the page, before it loads: counts the pictures that the graphics processor has not finished; the view sets one
/// fence each.
export function count_pictures() {
  const {prototype} = WebGL2RenderingContext, {fenceSync, deleteSync} = prototype;
  globalThis.unfinished_pictures = 0;
  prototype.fenceSync = function(...args) {
    ++globalThis.unfinished_pictures;
    return fenceSync.apply(this, args);
  };
  prototype.deleteSync = function(...args) {
    --globalThis.unfinished_pictures;
    return deleteSync.apply(this, args);
  };
}

/// Waits until what has changed is drawn, and nothing coarse any more: a change is taken over in one of the browser's
/// frames and drawn in the next, or in the first after the picture before it is finished.
export const at_rest = page => page.evaluate(async () => {
  const canvas = document.querySelector('canvas.view');
  for (let still = 0; still < 4; ++still) {
    await new Promise(requestAnimationFrame);
    if (globalThis.unfinished_pictures > 0 || canvas.width < canvas.clientWidth * devicePixelRatio - 2) still = 0;
  }
});

/// What is seen once the view is at rest, to compare what comes after with.
export const look_at_rest = async page => (await at_rest(page), look(page));

const readers = new WeakMap();  // a blank page a browser decodes the pictures

async function count_colors({png, from, to}) {
  const bytes = Uint8Array.from(atob(png), c => c.charCodeAt(0));
  const bitmap = await createImageBitmap(new Blob([bytes], {type: 'image/png'}));
  const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d');
  context.fillStyle = 'white';  // a saved view is transparent
  context.fillRect(0, 0, bitmap.width, bitmap.height);
  context.drawImage(bitmap, 0, 0);
  const {width, height} = bitmap, top = Math.round(from * height), rows = Math.round(to * height) - top;
  const {data} = context.getImageData(0, top, width, rows);
  const seen = {tets: 0, sand: 0, crimson: 0, all: data.length / 4, sum: 0};
  for (let i = 0; i < data.length; i += 4) {
    const [r, g, b] = data.subarray(i, i + 3);
    seen.sum = (seen.sum * 31 + r * 7 + g * 3 + b) % 1000000007;
    const spread = Math.max(r, g, b) - Math.min(r, g, b);
    if (r > 170 && g < 60 && b < 110) ++seen.crimson;
    else if (r > 70 && r >= g && g > b && r - b > 20 && r - b < 90 && r - g < 45) ++seen.sand;
    else if (spread > 45 && g >= r - 20) ++seen.tets;
  }
  return seen;
}
