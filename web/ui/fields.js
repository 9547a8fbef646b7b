import {h, unique_id} from './dom.js';
import {icon} from './icons.js';

/// A value of the state as slider and exact number, with unit, explanation and reset.
/// options: {path, title, unit, meaning, type, min, max, step, fallback, logarithmic, settle}.
export function number_field(store, options) {
  const {path, title, unit = '', min, max, step, fallback, logarithmic} = options;
  const id = unique_id('field');
  const to_slider = value => logarithmic ? Math.log10(Math.max(value, min)) : value;
  const from_slider = at => logarithmic ? Number((10 ** at).toPrecision(3)) : Number(at);
  // The slider's stops are counted from its lowest, which may not be a multiple of the step: 4 would not be one.
  const first = Number.isFinite(step) ? Number((Math.ceil(min / step - 1e-9) * step).toPrecision(12)) : min;
  const bounds = logarithmic ? {min: to_slider(min), max: to_slider(max), step: 0.05} : {min: first, max, step};
  const slider = h('input', {type: 'range', id, ...text(bounds), 'aria-describedby': `${id}-tip`});
  const exact = h('input', {type: 'number', 'aria-label': `${title}, exact value`, min: String(min), max: String(max),
    step: logarithmic ? 'any' : String(step)});
  const changes = value => options.settle ? options.settle({[path]: value}) : {[path]: value};
  slider.addEventListener('input', () => store.preview(changes(from_slider(slider.value)), title));
  slider.addEventListener('change', () => store.commit());
  exact.addEventListener('change', () => {
    const typed = Number(exact.value), value = Math.min(max, Math.max(min, options.type === 'integer' ? Math.round(typed) : typed));
    if (exact.value !== '' && Number.isFinite(value)) store.set(changes(value), title);
    exact.value = short(store.get(path) ?? fallback);  // as it was taken
  });
  const reset = reset_button(title, () => store.set(changes(fallback), `reset ${title}`));
  const show = () => {
    const value = store.get(path) ?? fallback;
    if (value === undefined || value === null) return;
    slider.value = to_slider(value);
    slider.setAttribute('aria-valuetext', `${value} ${unit}`);
    if (document.activeElement !== exact) exact.value = short(value);
    slider.style.setProperty('--fill', `${100 * (to_slider(value) - bounds.min) / (bounds.max - bounds.min)}%`);
    reset.hidden = fallback === undefined || value === fallback;
  };
  store.on(path, show);
  show();
  const tip = tooltip(id, options.meaning);
  return h('div', {class: 'field number', 'data-path': path},
    h('label', {for: id}, title), reset, exact, h('span', {class: 'unit'}, unit), slider, tip);
}

/// Six digits; small numbers in powers of ten, which the narrow field can show.
function short(value) {
  const rounded = Number(Number(value).toPrecision(6));
  return rounded !== 0 && Math.abs(rounded) < 1e-3 ? rounded.toExponential() : String(rounded);
}

const text = values => Object.fromEntries(Object.entries(values).map(([key, value]) => [key, String(value)]));

/// choices: [{value, title}].
export function choice_field(store, {path, title, choices, meaning, fallback}) {
  const id = unique_id('field');
  const select = h('select', {id, 'aria-describedby': `${id}-tip`},
    choices.map(({value, title: name}) => h('option', {value: String(value)}, name)));
  select.addEventListener('change', () => store.set({[path]: choices[select.selectedIndex].value}, title));
  const reset = reset_button(title, () => store.set({[path]: fallback}, `reset ${title}`));
  const show = () => {
    const value = store.get(path) ?? fallback;
    select.value = String(value);
    reset.hidden = fallback === undefined || value === fallback;
  };
  store.on(path, show);
  show();
  return h('div', {class: 'field choice', 'data-path': path}, h('label', {for: id}, title), reset, select, tooltip(id, meaning));
}

export function toggle_field(store, {path, title, meaning, fallback}) {
  const id = unique_id('field');
  const box = h('input', {type: 'checkbox', id, 'aria-describedby': `${id}-tip`});
  box.addEventListener('change', () => store.set({[path]: box.checked}, title));
  const reset = reset_button(title, () => store.set({[path]: fallback}, `reset ${title}`));
  const show = () => {
    const value = store.get(path) ?? fallback ?? false;
    box.checked = value;
    reset.hidden = fallback === undefined || value === fallback;
  };
  store.on(path, show);
  show();
  return h('div', {class: 'field toggle', 'data-path': path}, box, h('label', {for: id}, title), reset, tooltip(id, meaning));
}

function reset_button(title, onclick) {
  return h('button', {type: 'button', class: 'reset', 'aria-label': `Reset ${title}`, title: 'Reset', onclick, hidden: true}, icon('reset'));
}

/// Shown by the style sheet while the field is hovered or holds the focus.
function tooltip(id, meaning) {
  return meaning ? h('span', {role: 'tooltip', id: `${id}-tip`, class: 'tip'}, meaning) : h('span', {id: `${id}-tip`, hidden: true}, '');
}

/// Escape takes a tooltip away from what it covers (WCAG 1.4.13), until its field is come back to.
export function dismiss_tooltip() {
  for (const field of document.querySelectorAll('.field:is(:hover, :focus-within)')) {
    field.classList.add('no-tip');
    for (const event of ['focusout', 'pointerleave']) field.addEventListener(event, () => field.classList.remove('no-tip'), {once: true});
  }
}

export function button(title, onclick, {name, label, ...more} = {}) {
  return h('button', {type: 'button', onclick, ...(label ? {'aria-label': label, title: label} : {}), ...more},
    name ? icon(name) : null, title ? h('span', {}, title) : null);
}

/// A button that stays pressed, tied to a value of the state.
export function toggle_button(store, path, title, {label, name} = {}) {
  const element = button(title, () => store.set({[path]: !store.get(path)}, label ?? title), {name, label, class: 'toggle'});
  const show = () => element.setAttribute('aria-pressed', String(Boolean(store.get(path))));
  store.on(path, show);
  show();
  return element;
}
