import * as THREE from 'three';
import {CameraControls} from './camera_controls.js';
import {h} from '../ui/dom.js';

const fov = 32, margin = 16;  // degrees; pixels around what fits
const slow_picture = 30, very_slow_picture = 60, settled = 250, poll = 2;  // milliseconds

/// three.js' layer of what is drawn only when the picture is sharp.
export const fine_layer = 1;

/// The canvas, its camera and its light; draws only when asked to. Layers add their objects to `scene` (world) or
/// `model` (the mesh's own coordinates, placed as the body stands in the world). Events: picture (drawn: begun when, in how many ms).
export class Viewport extends EventTarget {
  constructor(store) {
    super();
    this.store = store;
    this.bars = [];  // controls over the view, which a fit keeps clear of
    this.canvas = h('canvas', {class: 'view', tabindex: '0', role: 'application',
      'aria-label': '3D view. Arrow keys orbit, with Shift they pan; plus and minus zoom; F fits.'});
    this.renderer = make_renderer(this.canvas);
    this.scene = new THREE.Scene();
    this.model = new THREE.Group();
    this.model.matrixAutoUpdate = false;
    this.scene.add(this.model);
    this.perspective = new THREE.PerspectiveCamera(fov, 1, 0.01, 100);
    this.orthographic = new THREE.OrthographicCamera(-1, 1, 1, -1, -100, 100);
    this.controls = new CameraControls(this.canvas, (camera, done) => this.moved(camera, done));
    this.bounds = new THREE.Box3(new THREE.Vector3(-0.5, -0.5, -0.5), new THREE.Vector3(0.5, 0.5, 0.5));
    this.canvas.addEventListener('webglcontextrestored', () => this.invalidate());
    this.size = {width: 1, height: 1};
    this.covered = {top: 0, bottom: 0};
    new ResizeObserver(([{contentRect}]) => this.resize(contentRect)).observe(this.canvas);
    store.on(['view.camera', 'view.orthographic'], () => this.adopt_camera());
  }

  get camera() {
    return this.store.get('view.orthographic') ? this.orthographic : this.perspective;
  }

  moved(camera, done) {
    this.store.preview({'view.camera': camera}, 'move the camera');
    if (done) this.store.commit();
  }

  adopt_camera() {
    const camera = this.store.get('view.camera');
    if (!camera) this.fit(null, false);
    else this.controls.camera = structuredClone(camera);
    this.invalidate();
  }

  /// World box of what there is to see.
  set_bounds(min, max) {
    this.bounds.min.set(...min);
    this.bounds.max.set(...max);
    if (!this.store.get('view.camera')) this.fit(null, false);
    this.invalidate();
  }

  /// direction: from the target to the eye; null keeps it. A fit that nobody asked for leaves no entry to undo.
  fit(direction = null, by_person = true) {
    const {on_move} = this.controls;
    if (!by_person) this.controls.on_move = () => this.invalidate();
    this.look_at(this.bounds.getCenter(new THREE.Vector3()), this.bounds.getSize(new THREE.Vector3()), direction);
    this.controls.on_move = on_move;
  }

  /// Shows the ball around a point.
  fly(center, radius) {
    this.look_at(new THREE.Vector3(...center), new THREE.Vector3().setScalar(2 * radius), null);
  }

  look_at(center, size, direction) {
    this.measure_covered();
    const box = new THREE.Box3().setFromCenterAndSize(center, size).expandByScalar(1e-6);
    const {width, height} = this.size, clear = Math.max(0.3 * height, height - this.covered.top - this.covered.bottom - 2 * margin);
    const tangent = Math.tan(fov * Math.PI / 360) * clear / height;
    this.controls.look(box, direction, tangent, Math.max(0.1, (width - 2 * margin) / clear));
  }

  /// How many pixels of the view's upper and lower edge lie under controls. Known anew with each fit only: a bar that
  /// gets longer must not move the picture.
  measure_covered() {
    const view = this.canvas.getBoundingClientRect(), middle = (view.top + view.bottom) / 2;
    this.covered = {top: 0, bottom: 0};
    for (const {top, bottom} of this.bars.map(bar => bar.getBoundingClientRect())) {
      if (bottom > view.top && bottom < middle) this.covered.top = Math.max(this.covered.top, bottom - view.top);
      if (top < view.bottom && top > middle) this.covered.bottom = Math.max(this.covered.bottom, view.bottom - top);
    }
  }

  radius() {
    return Math.max(1e-6, this.bounds.getSize(new THREE.Vector3()).length() / 2);
  }

  /// A point of the mesh's own coordinates, from the origin of what is drawn, in the world.
  model_point(point) {
    return new THREE.Vector3(...point).applyMatrix4(this.model.matrix).toArray();
  }

  /// A ring that faces the eye, around what was flown to; null takes it away.
  mark(point, radius) {
    this.marker ??= make_marker(this.scene);
    this.marker.visible = point !== null;
    this.invalidate();
    if (!point) return;
    this.marker.position.set(...point);
    this.marker.scale.setScalar(radius);
  }

  aspect() {
    return Math.max(0.1, this.size.width / Math.max(1, this.size.height));
  }

  resize({width, height}) {
    if (!width || !height || !this.renderer) return;
    this.size = {width, height};
    this.measure_covered();
    this.fence = null;
    this.set_sharpness(1);
    if (!this.store.get('view.camera')) this.fit(null, false);
    this.draw();
  }

  invalidate() {
    if (!this.renderer) return;
    this.pending ??= requestAnimationFrame(() => this.draw());
  }

  /// Where a sharp picture is known to take long, changes are shown coarse at once, and sharp once they rest.
  coarsen() {
    if (!(this.sharp_ms > slow_picture)) return;
    this.set_sharpness(this.sharp_ms > very_slow_picture ? 0.5 : 0.7);
    this.rest_soon();
  }

  rest_soon() {
    clearTimeout(this.rest);
    this.rest = setTimeout(() => {
      if (this.pending || this.fence) return this.rest_soon();
      this.set_sharpness(1);
      this.draw(true);
    }, Math.max(settled, 1.5 * this.sharp_ms));  // a sharp picture keeps the next change waiting
  }

  set_sharpness(sharpness) {
    this.sharpness = sharpness;
    for (const camera of [this.perspective, this.orthographic]) camera.layers[sharpness < 1 ? 'disable' : 'enable'](fine_layer);
    const {width, height} = this.size, ratio = sharpness * Math.min(2, devicePixelRatio);
    // One new drawing buffer, which costs tens of milliseconds without a graphics processor.
    if (this.drawn_at?.join() === [width, height, ratio].join()) return;
    this.drawn_at = [width, height, ratio];
    this.renderer.setDrawingBufferSize(width, height, ratio);
  }

  /// sharp: however long it takes.
  draw(sharp = false) {
    if (!this.renderer) return;
    cancelAnimationFrame(this.pending);
    this.pending = null;
    if (this.fence) return this.invalidate();  // pictures must not pile up before a slow graphics processor
    if (!sharp) this.coarsen();
    this.place_cameras();
    this.marker?.quaternion.copy(this.camera.quaternion);
    this.renderer.render(this.scene, this.camera);
    this.await_picture();
  }

  /// Learns when the picture is drawn, and how long a sharp one takes.
  await_picture() {
    const gl = this.renderer.getContext(), from = performance.now(), {sharpness} = this;
    const fence = this.fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    const look = () => {
      if (gl.clientWaitSync(fence, 0, 0) === gl.TIMEOUT_EXPIRED) return void setTimeout(look, poll);
      gl.deleteSync(fence);
      const ms = performance.now() - from;
      if (sharpness === 1) this.sharp_ms = ms;
      if (this.fence === fence) this.fence = null;
      this.dispatchEvent(new CustomEvent('picture', {detail: {from, ms}}));
    };
    setTimeout(look);
  }

  place_cameras() {
    const {position, target} = this.controls.camera;
    const eye = new THREE.Vector3(...position), at = new THREE.Vector3(...target);
    const distance = eye.distanceTo(at);
    const reach = this.bounds.getSize(new THREE.Vector3()).length() + this.bounds.distanceToPoint(eye);
    for (const camera of [this.perspective, this.orthographic]) {
      camera.position.copy(eye);
      camera.lookAt(at);
    }
    this.perspective.aspect = this.aspect();
    this.perspective.near = Math.max(distance, reach) / 1000;
    this.perspective.far = 20 * Math.max(distance, reach);
    const half = distance * Math.tan(fov * Math.PI / 360);
    Object.assign(this.orthographic, {left: -half * this.aspect(), right: half * this.aspect(), top: half, bottom: -half,
      near: -20 * reach, far: 20 * reach});
    // The target stands in the middle of what is clear.
    const {width, height} = this.size, up = (this.covered.bottom - this.covered.top) / 2;
    for (const camera of [this.perspective, this.orthographic]) {
      camera.setViewOffset(width, height, 0, up, width, height);
      camera.updateMatrixWorld();
    }
  }

  /// World ray through a point of the page.
  ray(event) {
    const box = this.canvas.getBoundingClientRect();
    const at = new THREE.Vector2(2 * (event.clientX - box.left) / box.width - 1, 1 - 2 * (event.clientY - box.top) / box.height);
    const caster = new THREE.Raycaster();
    this.place_cameras();
    caster.setFromCamera(at, this.camera);
    return caster.ray;
  }

  screenshot() {
    this.fence = null;
    this.set_sharpness(1);
    this.draw(true);
    return new Promise(resolve => this.canvas.toBlob(resolve, 'image/png'));
  }
}

/// Null where the browser has no WebGL 2: all but the picture works without. Without a graphics processor smoothed edges
/// cost more than all else.
function make_renderer(canvas) {
  const context = canvas.getContext('webgl2', {antialias: !drawn_by_software(), alpha: true, premultipliedAlpha: true});
  if (!context) return null;
  const renderer = new THREE.WebGLRenderer({canvas, context});
  renderer.outputColorSpace = THREE.LinearSRGBColorSpace;  // the materials encode by themselves
  return renderer;
}

function drawn_by_software() {
  const trial = new OffscreenCanvas(1, 1).getContext('webgl2');
  const name = trial?.getExtension('WEBGL_debug_renderer_info')?.UNMASKED_RENDERER_WEBGL;
  const renderer = name ? trial.getParameter(name) : '';
  trial?.getExtension('WEBGL_lose_context')?.loseContext();
  return /SwiftShader|llvmpipe|softpipe|Basic Render|Software/i.test(renderer);
}

function make_marker(scene) {
  const material = new THREE.MeshBasicMaterial({color: '#ff6a4d', depthTest: false, transparent: true});
  const marker = new THREE.Mesh(new THREE.RingGeometry(0.86, 1, 48), material);
  marker.renderOrder = 3;
  scene.add(marker);
  return marker;
}
