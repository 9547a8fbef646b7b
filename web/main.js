import {client, first_sample} from './work/first_requests.js';
import {make_app, load_tables} from './work/app.js';
import {ask_for_picture} from './work/meshing.js';
import {accept_drops} from './work/dropping.js';
import {watch_server} from './work/connection.js';
import {listen_to_keys} from './work/shortcuts.js';
import {no_view} from './panels/no_view.js';
import {header} from './panels/header.js';
import {stages_panel} from './panels/stages.js';
import {inspector} from './panels/inspector.js';
import {camera_bar, view_bar} from './panels/view_bar.js';
import {transport} from './panels/transport.js';
import {status_line} from './panels/status.js';
import {problem_cards} from './panels/problem_cards.js';
import {ask_for_token} from './panels/token_dialog.js';
import {progress_card} from './panels/progress_card.js';
import {h} from './ui/dom.js';

const preferred = matchMedia('(prefers-color-scheme: light)').matches ? 'light' : 'dark';
document.documentElement.dataset.theme = localStorage.getItem('isochor-theme') ?? preferred;

const app = make_app(client);
const cards = problem_cards(app);

function lay_out() {
  const look = view_bar(app), camera = camera_bar(app);
  app.viewport.bars = [look, camera];
  const view = h('main', {class: 'viewport', 'aria-label': 'View'},
    app.viewport.renderer ? [app.viewport.canvas, camera] : no_view(), h('div', {class: 'notices'}, progress_card(app), cards));
  document.body.append(header(app), view, transport(app), look, stages_panel(app), inspector(app), status_line(app));
}

async function start() {
  await load_tables(app);
  await first_sample?.then(mesh => ask_for_picture(client, mesh, app.sample_params('tree')), () => {});
  lay_out();
  listen_to_keys(app);
  accept_drops(app);
  watch_server(app);
  if (!await app.restore(location.hash)) await app.open_sample('tree');
}

start().catch(problem => {
  if (problem.status === 401) ask_for_token(app.client);
  else document.body.append(h('div', {class: 'notices'}, cards)), app.report(problem);
});
