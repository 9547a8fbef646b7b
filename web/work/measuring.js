import {finish_job} from '../wire/jobs.js';
import {floor_of} from '../report/error_plot.js';
import {wire_scene} from '../state/scene_templates.js';

const own = [];  // an axis left as the scene has it; an absent one takes what is usual
const grids = {
  quick: {repeats: 1, refinement: 4,
    axes: {solvers: ['newton'], springs: ['auto', 'implicit'], tolerances: [1e-2, 1e-4, 1e-6], substeps: [2, 8, 16], resolutions: own}},
  full: {repeats: 3, refinement: 16,
    axes: {solvers: ['newton', 'scaling', 'gradient'], springs: ['auto', 'implicit'], tolerances: [1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8], resolutions: own}},
};

/// A report made by the server, which grows while its job runs; what was done stays when it is cancelled.
/// Events: progress, report.
export class Measuring extends EventTarget {
  constructor(app) {
    super();
    Object.assign(this, {app, report: null, job: null});
  }

  /// Error against run time of the present scene's first seconds. size: 'quick' or 'full'.
  async scene(size, duration) {
    const {app} = this;
    if (!app.meshing.model) return;
    const {id} = await app.meshing.whole_model();
    const scene = app.store.get('scene');
    await app.find_meshes(scene);
    await this.follow({kind: 'scene', scene: {...wire_scene(scene, id, app.mesh_of_file), duration}, ...grids[size]});
  }

  /// The stiff and extreme cases.
  async stability() {
    await this.follow({kind: 'stability', quick: true});
  }

  async follow(request) {
    this.abort?.abort();
    const {signal} = this.abort = new AbortController();
    this.take(null);
    try {
      const job = await this.app.client.send('POST', '/reports', request, {signal});
      this.take(await finish_job(this.app.client, job, {signal, on_progress: now => {
        this.show(now);
        this.take(now.result);
      }}));
    } finally {
      if (this.abort.signal === signal) this.show(null);
    }
  }

  take(result) {
    if (result && !result.report) return;
    this.report = result?.report ?? null;
    this.dispatchEvent(new Event('report'));
  }

  show(job) {
    this.job = job;
    this.dispatchEvent(new Event('progress'));
  }

  cancel() {
    this.abort?.abort();
  }
}

/// Seconds worth measuring: until what falls has landed where there is something to land on.
export const worth_measuring = (size, scene) => size === 'full' || scene?.bodies.some(({type}) => type === 'rigid') ? 0.5 : 0.1;

/// Settings of a point as changes of the scene.
export function settings_changes({solver, springs, substeps, tolerance}) {
  return {'scene.solver.volume': solver, 'scene.solver.springs': springs, 'scene.solver.substeps': substeps || 'auto', 'scene.solver.tolerance': tolerance};
}

/// The converged point with the smallest error that fits the budget, or null. Of errors that cannot be told from round-off
/// and the reference's own, the smallest cell error counts, then the time.
export function fit_budget(report, field, budget_ms) {
  const fitting = report.points.filter(point => point.outcome === 'converged' && point.fits_ms <= budget_ms);
  const keys = ({errors, ms_per_step}) => [Math.max(errors[field], floor_of(report, field)), errors.max_cell_volume, ms_per_step.median];
  const order = (a, b) => a.map((key, k) => key - b[k]).find(difference => difference !== 0) ?? 0;
  return fitting.sort((a, b) => order(keys(a), keys(b)))[0] ?? null;
}
