import {h} from '../ui/dom.js';
import {button} from '../ui/fields.js';

/// In place of the view, where the browser cannot draw it.
export const no_view = () => h('div', {class: 'no-view', role: 'alert'},
  h('h2', {}, 'No picture: this browser offers no WebGL 2'),
  h('p', {}, 'All else works: meshing, the reports, simulation and export. For the picture, turn on hardware acceleration in the '
    + 'browser’s settings, or open this address in a current Firefox, Chromium or Safari.'),
  button('Try again', () => location.reload(), {class: 'primary'}));
