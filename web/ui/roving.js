const steps = {ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1};

/// One stop of the tab key for many parts: the arrow keys, Home and End go along them. choose(k) on Enter or Space;
/// extend(k) when Shift and an arrow arrive at the k-th. Each carries its number in data-part.
export function rove(nodes, {choose, extend}) {
  nodes.forEach((node, k) => {
    node.dataset.part = k;
    node.setAttribute('tabindex', k === 0 ? '0' : '-1');
    node.addEventListener('focus', () => nodes.forEach(other => other.setAttribute('tabindex', other === node ? '0' : '-1')));
    node.addEventListener('keydown', event => {
      const to = {Home: 0, End: nodes.length - 1}[event.key] ?? k + steps[event.key];
      const chosen = event.key === 'Enter' || event.key === ' ';
      if (!chosen && !nodes[to]) return;
      event.preventDefault();
      event.stopPropagation();
      if (chosen) return choose(k);
      nodes[to].focus();
      if (event.shiftKey) extend?.(to);
    });
  });
}

/// Draws parts anew; the one that held the focus keeps it.
export function redraw(holder, draw) {
  const part = holder.contains(document.activeElement) ? document.activeElement.dataset.part : undefined;
  draw();
  if (part !== undefined) holder.querySelector(`[data-part="${part}"]`)?.focus();
}
