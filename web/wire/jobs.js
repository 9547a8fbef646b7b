import {Problem} from './client.js';

const active = job => job.status === 'queued' || job.status === 'running';

/// Unless it has ended.
export const cancel_job = (client, job) => active(job) && client.request('DELETE', `/jobs/${job.id}`).catch(() => {});

/// Follows a job until it ends; on_progress(job). Aborting the signal cancels it on the server.
export async function finish_job(client, job, {signal, on_progress = () => {}} = {}) {
  const cancel = () => cancel_job(client, job);
  signal?.addEventListener('abort', cancel, {once: true});
  try {
    while (active(job)) {
      on_progress(job);
      job = await client.get(`/jobs/${job.id}?wait_ms=250`, {signal});
    }
  } finally {
    signal?.removeEventListener('abort', cancel);
  }
  if (job.status === 'done') return job.result;
  if (job.status === 'cancelled') throw new DOMException('The job was cancelled.', 'AbortError');
  throw new Problem(job.problem ?? {title: 'The job failed'});
}
