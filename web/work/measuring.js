import {finish_job} from '../wire/jobs.js';
import {wire_scene} from '../state/scene_templates.js';

const grids = {
  quick: {solvers: ['newton', 'scaling'], tolerances: [1e-2, 1e-4, 1e-6], substeps: [1, 2, 4]},
  full: {solvers: ['newton', 'scaling', 'gradient'], tolerances: [1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8], substeps: [1, 2, 4, 8, 16]},
};

/// Error against run time of the present scene, as a job on the server. Events: progress, report.
export class Measuring extends EventTarget {
  constructor(app) {
    super();
    Object.assign(this, {app, report: null, job: null});
  }

  /// size: 'quick' or 'full'; duration in seconds.
  async run(size, duration) {
    const {app} = this;
    if (!app.meshing.model) return;
    const scene = {...wire_scene(app.store.get('scene'), app.meshing.model.id), duration};
    await this.follow({kind: 'scene', scene, axes: grids[size], repeats: size === 'full' ? 3 : 1}, 'report');
  }

  async stability() {
    await this.follow({kind: 'stability', quick: true}, 'stability_report');
  }

  async follow(request, name) {
    const abort = this.abort = new AbortController();
    try {
      const job = await this.app.client.send('POST', '/reports', request, {signal: abort.signal});
      const result = await finish_job(this.app.client, job, {signal: abort.signal, on_progress: now => this.show(now)});
      this[name] = result.report;
      this.dispatchEvent(new Event('report'));
    } finally {
      this.show(null);
    }
  }

  show(job) {
    this.job = job;
    this.dispatchEvent(new Event('progress'));
  }

  cancel() {
    this.abort?.abort();
  }
}

/// Settings of a point as changes of the scene.
export function settings_changes({solver, springs, substeps, tolerance}) {
  return {'scene.solver.volume': solver, 'scene.solver.springs': springs, 'scene.solver.substeps': substeps || 'auto', 'scene.solver.tolerance': tolerance};
}

/// The converged point with the smallest error within the budget, or null.
export function fit_budget({points}, field, budget_ms) {
  const fitting = points.filter(point => point.outcome === 'converged' && point.ms_per_step.median <= budget_ms);
  return fitting.sort((a, b) => a.errors[field] - b.errors[field])[0] ?? null;
}
