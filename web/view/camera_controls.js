import * as THREE from 'three';

const pole = 0.01;  // radians kept from straight up and down

/// Orbit, pan and zoom by mouse, touch and keys. The camera is data: {position, target}; on_move(camera, done) is
/// told of each change, done at the end of a gesture.
export class CameraControls {
  constructor(element, on_move) {
    this.element = element;
    this.on_move = on_move;
    this.camera = {position: [2, 1.5, 3], target: [0, 0, 0]};
    this.enabled = true;
    this.pointers = new Map();
    element.addEventListener('pointerdown', event => this.down(event));
    element.addEventListener('pointermove', event => this.move(event));
    for (const name of ['pointerup', 'pointercancel']) element.addEventListener(name, event => this.up(event));
    element.addEventListener('wheel', event => this.wheel(event), {passive: false});
    element.addEventListener('contextmenu', event => event.preventDefault());
  }

  down(event) {
    if (!this.enabled || event.defaultPrevented) return;
    this.element.setPointerCapture(event.pointerId);
    this.take(event);
    this.moving = false;
    this.panning = event.button !== 0 || event.shiftKey;
  }

  /// From where a pointer stands that is down.
  take({pointerId, clientX, clientY}) {
    this.pointers.set(pointerId, {x: clientX, y: clientY});
  }

  move(event) {
    const last = this.pointers.get(event.pointerId);
    if (!last) return;
    const before = this.pinch();
    this.moving = true;
    const dx = event.clientX - last.x, dy = event.clientY - last.y;
    Object.assign(last, {x: event.clientX, y: event.clientY});
    if (this.pointers.size === 2) {
      const after = this.pinch();
      this.zoom(before.spread / Math.max(1, after.spread), false);
      this.pan(after.x - before.x, after.y - before.y, false);
    } else if (this.panning) {
      this.pan(dx, dy, false);
    } else {
      this.orbit(-dx * 0.008, -dy * 0.008, false);
    }
  }

  up(event) {
    if (!this.pointers.delete(event.pointerId)) return;
    if (this.pointers.size === 0 && this.moving) this.on_move(this.camera, true);
  }

  pinch() {
    const [a, b] = [...this.pointers.values()];
    if (!b) return null;
    return {x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, spread: Math.hypot(a.x - b.x, a.y - b.y)};
  }

  wheel(event) {
    if (!this.enabled) return;
    event.preventDefault();
    this.zoom(Math.exp(event.deltaY * (event.deltaMode ? 0.03 : 0.001)), false);
    clearTimeout(this.wheel_end);
    this.wheel_end = setTimeout(() => this.on_move(this.camera, true), 250);
  }

  vectors() {
    const position = new THREE.Vector3(...this.camera.position);
    const target = new THREE.Vector3(...this.camera.target);
    return {position, target, offset: position.clone().sub(target)};
  }

  orbit(yaw, pitch, done = true) {
    const {target, offset} = this.vectors();
    const spherical = new THREE.Spherical().setFromVector3(offset);
    spherical.theta += yaw;
    spherical.phi = Math.min(Math.PI - pole, Math.max(pole, spherical.phi + pitch));
    offset.setFromSpherical(spherical);
    this.place(target.clone().add(offset), target, done);
  }

  /// By pixels on the screen at the target's distance.
  pan(dx, dy, done = true) {
    const {position, target, offset} = this.vectors();
    const scale = 0.6 * offset.length() / this.element.clientHeight;
    const right = new THREE.Vector3().crossVectors(new THREE.Vector3(0, 1, 0), offset).normalize();
    const up = new THREE.Vector3().crossVectors(offset, right).normalize();
    const shift = right.multiplyScalar(-dx * scale).add(up.multiplyScalar(dy * scale));
    this.place(position.add(shift), target.add(shift), done);
  }

  zoom(factor, done = true) {
    const {target, offset} = this.vectors();
    this.place(target.clone().addScaledVector(offset, factor), target, done);
  }

  place(position, target, done) {
    this.camera = {position: position.toArray(), target: target.toArray()};
    this.on_move(this.camera, done);
  }

  /// Looks from a direction (kept when null) at the middle of a box, from where its corners just fit into a view of
  /// this half angle's tangent, upwards, and aspect.
  look({min, max}, direction, tangent, aspect) {
    const toward = (direction ? new THREE.Vector3(...direction) : this.vectors().offset).normalize();
    const right = new THREE.Vector3(0, 1, 0).cross(toward).normalize(), up = toward.clone().cross(right);
    const half = max.clone().sub(min).divideScalar(2), target = min.clone().add(half);
    let distance = 0;
    for (let k = 0; k < 8; ++k) {
      const corner = half.clone().multiply(new THREE.Vector3(...[0, 1, 2].map(axis => k >> axis & 1 ? 1 : -1)));
      const aside = Math.max(Math.abs(corner.dot(right)) / aspect, Math.abs(corner.dot(up)));
      distance = Math.max(distance, corner.dot(toward) + aside / tangent);
    }
    this.place(toward.multiplyScalar(distance).add(target), target, true);
  }
}

/// Keys on the focused view. Returns whether the key was used.
export function camera_key(controls, event) {
  const step = 0.12, shift = 40;
  const actions = event.shiftKey ? {
    ArrowLeft: () => controls.pan(shift, 0), ArrowRight: () => controls.pan(-shift, 0),
    ArrowUp: () => controls.pan(0, shift), ArrowDown: () => controls.pan(0, -shift),
  } : {
    ArrowLeft: () => controls.orbit(-step, 0), ArrowRight: () => controls.orbit(step, 0),
    ArrowUp: () => controls.orbit(0, -step), ArrowDown: () => controls.orbit(0, step),
  };
  actions['+'] = actions['='] = () => controls.zoom(0.85);
  actions['-'] = () => controls.zoom(1 / 0.85);
  const action = event.ctrlKey || event.metaKey || event.altKey ? null : actions[event.key];
  action?.();
  return Boolean(action);
}
