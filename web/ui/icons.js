import {svg} from './dom.js';

const paths = {
  play: 'M7 4.5v15l12-7.5z', pause: 'M7 4.5h3.5v15H7zM13.5 4.5H17v15h-3.5z',
  back: 'M17 5v14L8 12zM6 5h2v14H6z', forward: 'M7 5v14l9-7zM16 5h2v14h-2z', restart: 'M12 5V1.5L7 6l5 4.5V7a5 5 0 1 1-5 5H5a7 7 0 1 0 7-7z',
  record: 'M12 6a6 6 0 1 0 .01 0z', stop: 'M6.5 6.5h11v11h-11z',
  undo: 'M8 5 3 10l5 5v-3.5h6a3.5 3.5 0 0 1 0 7H9V21h5a6 6 0 0 0 0-12H8z', redo: 'm16 5 5 5-5 5v-3.5h-6a3.5 3.5 0 0 0 0 7h5V21h-5a6 6 0 0 1 0-12h6z',
  fit: 'M4 4h6v2H6v4H4zm10 0h6v6h-2V6h-4zM4 14h2v4h4v2H4zm14 0h2v6h-6v-2h4z',
  camera: 'M9 5 7.5 7H4v12h16V7h-3.5L15 5zm3 4a4 4 0 1 1 0 8 4 4 0 0 1 0-8z', theme: 'M12 3a9 9 0 1 0 .01 0zm0 2a7 7 0 1 1-.01 14z',
  reset: 'M12 6V3L8 7l4 4V8a4 4 0 1 1-4 4H6a6 6 0 1 0 6-6z', close: 'm6.4 5 5.6 5.6L17.6 5 19 6.4 13.4 12l5.6 5.6-1.4 1.4-5.6-5.6L6.4 19 5 17.6l5.6-5.6L5 6.4z',
  flip: 'M11 3h2v18h-2zM9 7v10H3zm6 0v10h6z', open: 'M3 5h7l2 2h9v12H3zm2 4v8h14V9z', down: 'M5 8h14l-7 8z', save: 'M11 3h2v8.2l3.3-3.3 1.4 1.4L12 15l-5.7-5.7 1.4-1.4 3.3 3.3zM4 18h16v2.5H4z',
  target: 'M11 2h2v3.1A7 7 0 0 1 18.9 11H22v2h-3.1a7 7 0 0 1-5.9 5.9V22h-2v-3.1A7 7 0 0 1 5.1 13H2v-2h3.1A7 7 0 0 1 11 5.1zM12 7a5 5 0 1 0 0 10 5 5 0 0 0 0-10z',
  trash: 'M9 3h6l1 2h4v2H4V5h4zM6 8h12l-1 13H7z', plus: 'M11 5h2v6h6v2h-6v6h-2v-6H5v-2h6z',
};

export function icon(name) {
  return svg('svg', {viewBox: '0 0 24 24', class: 'icon', 'aria-hidden': 'true'}, svg('path', {d: paths[name], 'fill-rule': 'evenodd'}));
}
