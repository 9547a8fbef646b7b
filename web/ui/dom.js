/// h('button', {class: 'icon', onclick: f}, 'Play') makes an element. Text is always set as text, never as markup.
export function h(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  set_attributes(element, attributes);
  element.append(...children.flat(Infinity).filter(child => child !== null && child !== undefined && child !== false));
  return element;
}

export function set_attributes(element, attributes) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else if (value === false || value === null || value === undefined) element.removeAttribute(name);
    else if (name in element && typeof value !== 'string') element[name] = value;
    else element.setAttribute(name, value === true ? '' : value);
  }
}

const svg_namespace = 'http://www.w3.org/2000/svg';

export function svg(tag, attributes = {}, ...children) {
  const element = document.createElementNS(svg_namespace, tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value);
  }
  element.append(...children.flat());
  return element;
}

/// Writes what differs alone, for what is written costs the browser its layout.
export function change(element, attributes) {
  for (const [name, value] of Object.entries(attributes)) if (element.getAttribute(name) !== String(value)) element.setAttribute(name, value);
}

export function change_text(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

let counter = 0;
export const unique_id = prefix => `${prefix}-${++counter}`;

/// Calls f at most once a frame, with the last arguments.
export function once_a_frame(f) {
  let last = null;
  return (...args) => {
    if (!last) requestAnimationFrame(() => {
      const now = last;
      last = null;
      f(...now);
    });
    last = args;
  };
}

/// The files that a person chooses; none when the dialog is left.
export function choose_files(accept) {
  const picker = h('input', {type: 'file', accept, multiple: true});
  picker.click();
  return new Promise(resolve => {
    picker.addEventListener('change', () => resolve([...picker.files]));
    picker.addEventListener('cancel', () => resolve([]));
  });
}

export function download(blob, name) {
  const link = h('a', {href: URL.createObjectURL(blob), download: name});
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}
