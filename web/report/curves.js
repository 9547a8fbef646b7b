// Log-log curves of an error over run time, shared by the page and the self-contained report.
import uPlot from 'uplot';

export const palette = ['#0b7285', '#d9480f', '#7048e8', '#2b8a3e', '#c2255c', '#1864ab', '#946200', '#5f3dc4'];
export const failed_color = '#d32f2f';
const front_color = '#888f94';
const floor = 1e-17; // round-off: a log axis has no zero

const usable = (point) => point.outcome === 'converged' || point.outcome === 'infeasible';

// Points of one series are one curve.
export function group_series(points) {
  const groups = new Map();
  points.forEach((point, index) => {
    const name = point.series;
    if (!groups.has(name)) groups.set(name, { name, color: palette[groups.size % palette.length], indices: [] });
    groups.get(name).indices.push(index);
  });
  return [...groups.values()];
}

// uPlot wants one rising axis for all series: every point gets its own place on it.
function columns(report, field) {
  const groups = group_series(report.points);
  const front = new Set(report.fronts[field]);
  const errors = report.points.map((p) => (usable(p) ? Math.max(p.errors[field] ?? floor, floor) : null));
  const top = 10 * Math.max(floor, ...errors.filter((e) => e !== null));
  const order = report.points
    .map((p, index) => ({ index, ms: p.ms_per_step.median }))
    .filter(({ ms }) => ms > 0)
    .sort((a, b) => a.ms - b.ms);
  const xs = [];
  for (const { ms } of order) xs.push(Math.max(ms, (xs.at(-1) ?? 0) * (1 + 1e-9)));
  const column = (value) => order.map(({ index }) => value(index));
  const data = [
    xs,
    column((i) => (front.has(i) ? errors[i] : null)),
    column((i) => (usable(report.points[i]) ? null : top)),
    ...groups.map((g) => column((i) => (g.indices.includes(i) ? errors[i] : null))),
  ];
  return { groups, data, order: order.map(({ index }) => index) };
}

function spread_bars(report, order) {
  return (plot) => {
    const { ctx } = plot;
    ctx.save();
    ctx.strokeStyle = front_color;
    ctx.beginPath();
    order.forEach((index, column) => {
      const { min, max } = report.points[index].ms_per_step;
      const value = plot.data.slice(3).map((s) => s[column]).find((v) => v != null);
      if (value == null || !(min > 0)) return;
      const y = plot.valToPos(value, 'y', true);
      ctx.moveTo(plot.valToPos(min, 'x', true), y);
      ctx.lineTo(plot.valToPos(max, 'x', true), y);
    });
    ctx.stroke();
    ctx.restore();
  };
}

// Draws into `element` and returns the plot; on_pick gets the index of a clicked point.
export function error_curves(element, report, field, { width = 520, height = 300, ink = '#5d676e', time = 'ms a step', on_pick } = {}) {
  const { groups, data, order } = columns(report, field);
  const grid = { stroke: `${ink}30`, width: 1 };
  const decade = (value) => (value == null ? '' : Number(value).toExponential(0).replace('e+', 'e'));
  const is_decade = (value) => value > 0 && Math.abs(Math.log10(value) - Math.round(Math.log10(value))) < 1e-6;
  const axis = (label) => ({
    label, stroke: ink, grid, ticks: grid, values: (plot, splits) => splits.map((v) => (is_decade(v) ? decade(v) : '')),
  });
  const line = (label, stroke, more) => ({ label, stroke, width: 2, spanGaps: true, points: { show: true, size: 8, fill: stroke }, ...more });
  const plot = new uPlot({
    width, height,
    scales: { x: { time: false, distr: 3 }, y: { distr: 3 } },
    axes: [axis(time), { ...axis(''), size: 60 }],
    cursor: { drag: { x: false, y: false }, points: { size: 12 } },
    series: [
      {},
      line('Pareto front', front_color, { dash: [6, 4], points: { show: false } }),
      line('blew up or failed', failed_color, { width: 0, points: { show: true, size: 10, stroke: failed_color, fill: failed_color } }),
      ...groups.map((g) => line(g.name, g.color)),
    ],
    hooks: { draw: [spread_bars(report, order)] },
  }, data, element);
  if (on_pick) plot.over.addEventListener('click', () => plot.cursor.idx != null && on_pick(order[plot.cursor.idx]));
  return plot;
}
