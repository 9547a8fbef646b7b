const period = 1500;

/// Notices that the server is gone, and rejoins when it is back: new token, the mesh opened again, settings kept.
export function watch_server(app) {
  const {client, meshing, simulation} = app;
  let lost = false;

  const notice = () => {
    if (lost) return;
    lost = true;
    end_run();
    app.tell('server', 'server lost');
    app.report({code: 'server_lost', title: 'The server does not answer', detail: 'The server does not answer; your settings are kept.',
      hint: 'Start it again with server/run. The page rejoins by itself.'});
    wait();
  };
  const wait = async () => {
    const back = await fetch(client.url('/health'), {cache: 'no-store'}).then(response => response.ok, () => false);
    if (!back) return void setTimeout(wait, period);
    lost = false;
    app.run(rejoin);
  };
  const rejoin = async () => {
    await client.refresh_token();
    app.tell('solved', 'server_lost');
    app.tell('server', '');
    app.say('The server is back');
    if (simulation.state === 'recording') return;
    const {id} = app.store.get('mesh');
    const known = id && await client.get(`/meshes/${id}`).then(() => true, () => false);
    simulation.id = null;
    app.compiled = null;
    if (known) meshing.request(false);
    const opened = known || await app.open(app.store.get('mesh'));
    if (opened && app.store.get('view.layers.sim')) await app.ready_to_step();
  };
  /// A recording plays on without a server.
  const end_run = () => simulation.state !== 'recording' && simulation.set_state('none');

  client.addEventListener('lost', notice);
  simulation.addEventListener('lost', () => fetch(client.url('/health')).catch(notice));
  setInterval(() => !lost && !document.hidden && fetch(client.url('/health'), {cache: 'no-store'}).catch(notice), 5000);
}
