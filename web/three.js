// The one place that names where three.js is served; no import map, so the content security policy needs no hash.
export * from './vendor/three/three.module.js';
