import {download} from '../ui/dom.js';
import {export_dialog} from '../panels/export_dialog.js';
import {help_dialog} from '../panels/help_dialog.js';
import {sharing} from './sharing.js';

/// Files that leave the page.
export const exporting = app => ({
  ...sharing(app),
  stem: () => (app.meshing.mesh?.name ?? 'isochor').split('/').at(-1).replace(/\.[^.]*$/, ''),
  show_export: () => app.run(() => export_dialog(app)),
  show_help: () => help_dialog(app),
  save_export: name => app.run(async () => {
    const {id} = await app.meshing.whole_model();
    const response = await app.client.request('GET', `/models/${id}/exports/${name}`);
    const [, file] = /filename="([^"]+)"/.exec(response.headers.get('Content-Disposition') ?? '') ?? [];
    download(await response.blob(), file ?? `${app.stem()}.${name}`);
    app.say(`Saved ${file ?? name}`);
  }),
  async save_screenshot() {
    download(await app.viewport.screenshot(), `${app.stem()}.png`);
    app.say('Picture saved');
  },
});
