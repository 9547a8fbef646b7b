// Takes the pictures of the README anew: `node tests/web/take_pictures.js [NAME…]` with ISOCHOR_BINARY set. Those that
// are kept were reduced to 200 colours afterwards.
import {chromium} from 'playwright-core';
import {writeFile} from 'node:fs/promises';
import {fileURLToPath} from 'node:url';
import {flags, open_page} from './support/browser.js';
import {at_rest} from './support/pixels.js';
import {start_server} from './support/server.js';

const folder = fileURLToPath(new URL('pictures/', import.meta.url));
const time = page => page.locator('.transport .time').textContent().then(Number.parseFloat);

/// By file name: the colour scheme, and what a person does before the picture is taken.
const states = {
  page: {scheme: 'dark', async reach() {}},
  votes: {scheme: 'dark', async reach(page) {
    for (const key of '132') await page.keyboard.press(key);
    await page.getByLabel('Colour voxels by').selectOption('votes');
    const plot = page.getByRole('img', {name: /^P along the ray/});
    for (; !await plot.isVisible(); await page.waitForTimeout(200)) await page.keyboard.press('p');  // once the voxels are there
    await plot.scrollIntoViewIfNeeded();
  }},
  simulation: {scheme: 'light', async reach(page) {
    await page.getByRole('button', {name: 'Play (Space)'}).click();
    while (!(await time(page) >= 0.6)) await page.waitForTimeout(50);
    await page.getByRole('button', {name: 'Pause (Space)'}).click();
    await page.getByRole('button', {name: 'Play (Space)'}).waitFor();
  }},
  report: {scheme: 'light', async reach(page) {
    const report = page.getByRole('region', {name: 'Error against run time'});
    await report.getByRole('button', {name: 'Measure error against run time'}).click();
    await report.getByRole('button', {name: 'Cancel'}).waitFor();
    await report.getByRole('button', {name: 'Cancel'}).waitFor({state: 'hidden', timeout: 300000});
    await page.getByRole('button', {name: 'Run the stability suite'}).click();
    await page.locator('.map td').nth(34).waitFor();
    await report.evaluate(section => section.scrollIntoView({block: 'start'}));
  }},
};

/// At half the size, each pixel the mean of four: without a graphics processor the view has no smooth edges of its own.
async function halve(page, png) {
  const halved = await page.evaluate(async base64 => {
    const bitmap = await createImageBitmap(await (await fetch(`data:image/png;base64,${base64}`)).blob());
    const canvas = Object.assign(document.createElement('canvas'), {width: bitmap.width / 2, height: bitmap.height / 2});
    const context = canvas.getContext('2d');
    context.imageSmoothingQuality = 'high';
    context.drawImage(bitmap, 0, 0, canvas.width, canvas.height);
    return canvas.toDataURL('image/png').split(',')[1];
  }, png.toString('base64'));
  return Buffer.from(halved, 'base64');
}

const wanted = process.argv.slice(2);
const server = await start_server();
const browser = await chromium.launch({executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: flags});
try {
  const blank = await browser.newPage();
  for (const [name, {scheme, reach}] of Object.entries(states)) {
    if (wanted.length && !wanted.includes(name)) continue;
    const page = await open_page({browser, server}, {width: 1280, height: 768, deviceScaleFactor: 1.6, colorScheme: scheme});
    await reach(page);
    await at_rest(page);
    await writeFile(`${folder}${name}.png`, await halve(blank, await page.screenshot()));
    await page.context().close();
  }
} finally {
  await browser.close();
  await server.stop();
}
