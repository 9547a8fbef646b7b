/// Everything of the page that a person can operate and sees now, by what a mouse could reach.
const controls = 'button, input, select, textarea, summary, a[href], canvas.view, [tabindex], [role=button], [role=slider]';

/// Walks the page by Tab from its beginning until it comes round. visit(control) is called at each stop with
/// {role, name, part, value, pressed, expanded, checked} of what holds the focus. Returns all stops.
export async function walk(page, visit = () => {}) {
  await page.evaluate(() => {
    globalThis.walked = new Set();
    document.activeElement?.blur();
    getSelection().removeAllRanges();
  });
  const stops = [];
  for (;;) {
    await page.keyboard.press('Tab');
    const stop = await focused(page);
    if (!stop || stop.again) return stops;
    stops.push(stop);
    await visit(stop);
  }
}

/// What holds the focus, as assistive technology is told; null outside the page.
export async function focused(page) {
  const state = await page.evaluate(() => {
    const element = document.activeElement;
    if (!element || element === document.body) return null;
    const again = globalThis.walked?.has(element);
    globalThis.walked?.add(element);
    const {value, checked, open} = element;
    return {again, tag: element.localName, type: element.type, value, checked, open: element.localName === 'summary' ? element.parentNode.open : open,
      pressed: element.getAttribute('aria-pressed'), part: element.dataset.part !== undefined, outline: getComputedStyle(element).outlineStyle};
  });
  if (!state) return null;
  const session = await session_of(page);
  const {result} = await session.send('Runtime.evaluate', {expression: 'document.activeElement'});
  const {nodes: [node]} = await session.send('Accessibility.getPartialAXTree', {objectId: result.objectId, fetchRelatives: false});
  return {...state, role: node.role?.value, name: node.name?.value ?? ''};
}

const sessions = new WeakMap();
async function session_of(page) {
  if (!sessions.has(page)) sessions.set(page, await page.context().newCDPSession(page));
  return sessions.get(page);
}

/// What is seen and enabled but was not walked over; parts of a roving group count when the group has a stop.
export const missed = page => page.evaluate(selector => [...document.querySelectorAll(selector)]
  .filter(element => element.checkVisibility({visibilityProperty: true}) && !element.disabled && !element.closest('[hidden]'))
  .filter(element => !globalThis.walked.has(element))
  .filter(element => element.dataset.part === undefined || ![...element.parentNode.children].some(other => globalThis.walked.has(other)))
  .map(element => element.outerHTML.slice(0, 120)), controls);
