export {default} from './vendor/uplot/uPlot.esm.js';
