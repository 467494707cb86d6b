/** The figure in space, drawn by WebGL. */

import { BAND, REACH, along, between, isLit, squares } from "./look.js";
import * as three from "./vendor/three.js";

/**
 * @typedef {import("./look.js").View} View
 * @typedef {import("./look.js").Picture} Picture
 * @typedef {import("./look.js").Body} Body
 * @typedef {import("./look.js").Color} Color
 * @typedef {import("./look.js").Palette} Palette
 */

const FIELD = 22; // degrees from bottom to top that the eye sees: nearly as flat as in films
const WAY = 30; // mm, the width of the way
const SHADE = 0.12; // of the colour of bones is in the shadow
const CORNERS = 8; // of what is round and thin: by software each corner costs time
const ORDER = { shadow: 1, way: 2, ghost: 3, lit: 4, solid: 5 }; // what is drawn later covers

/** Many strokes of one look: bars with balls at their ends, and heads, which are balls alone. */
class Strokes {
  #group;
  #material;
  #order;
  /** @type {three.InstancedMesh[]} bars, balls and heads */
  #meshes = [];
  #shapes;
  #counts = [0, 0, 0];
  #room = 0;

  /**
   * @param {three.Group} group
   * @param {three.Material} material
   * @param {number} order
   */
  constructor(group, material, order) {
    this.#group = group;
    this.#material = material;
    this.#order = order;
    this.#shapes = [
      new three.CylinderGeometry(1, 1, 1, CORNERS, 1, true),
      new three.SphereGeometry(1, CORNERS, CORNERS / 2),
      new three.SphereGeometry(1, 3 * CORNERS, 2 * CORNERS),
    ];
  }

  /**
   * Begin anew, with room for some strokes.
   * @param {number} strokes
   */
  begin(strokes) {
    this.#counts.fill(0);
    if (strokes <= this.#room) return;
    this.#room = Math.max(strokes, 2 * this.#room);
    for (const mesh of this.#meshes) {
      mesh.removeFromParent();
      mesh.dispose();
    }
    this.#meshes = this.#shapes.map((shape, kind) => {
      const count = this.#room * (kind === 1 ? 2 : 1), mesh = new three.InstancedMesh(shape, this.#material, count);
      mesh.instanceColor = new three.InstancedBufferAttribute(new Float32Array(3 * count), 3);
      mesh.frustumCulled = false;
      mesh.renderOrder = this.#order;
      this.#group.add(mesh);
      return mesh;
    });
  }

  /**
   * @param {number[]} from
   * @param {number[]} to
   * @param {number} radius
   * @param {Color} color
   */
  add(from, to, radius, color) {
    const [x, y, z] = from.map((it, axis) => to[axis] - it), length = Math.hypot(x, y, z);
    if (length < 1e-6) {
      this.#ball(2, from, radius, color);
      return;
    }
    const up = [x / length, y / length, z / length];
    const aside = Math.abs(up[1]) < 0.9 ? [up[2], 0, -up[0]] : [0, -up[2], up[1]];
    const size = radius / Math.hypot(...aside), [a, b, c] = aside.map((part) => part * size);
    const near = [b * up[2] - c * up[1], c * up[0] - a * up[2], a * up[1] - b * up[0]];
    const middle = from.map((it, axis) => (it + to[axis]) / 2);
    this.#put(0, [a, b, c, 0, x, y, z, 0, ...near, 0, ...middle, 1], color);
    this.#ball(1, from, radius, color);
    this.#ball(1, to, radius, color);
  }

  /**
   * @param {number} kind
   * @param {number[]} at
   * @param {number} radius
   * @param {Color} color
   */
  #ball(kind, at, radius, color) {
    this.#put(kind, [radius, 0, 0, 0, 0, radius, 0, 0, 0, 0, radius, 0, ...at, 1], color);
  }

  /**
   * @param {number} kind
   * @param {number[]} matrix
   * @param {Color} color
   */
  #put(kind, matrix, color) {
    const at = this.#counts[kind]++, mesh = this.#meshes[kind];
    mesh.instanceMatrix.array.set(matrix, 16 * at);
    mesh.instanceColor?.array.set(color, 3 * at);
  }

  /** Hand what was added to the graphics card. */
  end() {
    for (const [kind, mesh] of this.#meshes.entries()) {
      mesh.count = this.#counts[kind];
      mesh.visible = mesh.count > 0;
      mesh.instanceMatrix.needsUpdate = true;
      if (mesh.instanceColor) mesh.instanceColor.needsUpdate = true;
    }
  }
}

export class SpaceDrawer {
  #renderer;
  #scene = new three.Scene();
  #eye = new three.PerspectiveCamera(FIELD, 1, 10, 100000);
  #above = new three.OrthographicCamera();
  #sky = new three.HemisphereLight(0xffffff, 0xc0c0c0, 2.9);
  #sun = new three.DirectionalLight(0xffffff, 0.8);
  #low = new three.Group();
  #high = new three.Group();
  #past = new three.Group();
  #solid;
  #lit;
  #ghosts;
  #shadow;
  #floor;
  #way;

  /**
   * Return what draws on a canvas; null where WebGL is missing.
   * @param {HTMLCanvasElement} canvas
   * @param {() => void} again is called when it must be drawn again
   */
  static on(canvas, again) {
    const context = canvas.getContext("webgl2", { antialias: true, alpha: false, stencil: false });
    return context && new SpaceDrawer(canvas, context, again);
  }

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {WebGL2RenderingContext} context
   * @param {() => void} again
   */
  constructor(canvas, context, again) {
    this.#renderer = new three.WebGLRenderer({ canvas, context });
    this.#renderer.autoClear = false;
    this.#renderer.setScissorTest(true);
    canvas.addEventListener("webglcontextrestored", again);
    const flat = () => new three.MeshBasicMaterial({ depthTest: false, depthWrite: false });
    this.#shadow = new Strokes(this.#low, flat(), ORDER.shadow);
    this.#ghosts = new Strokes(this.#past, flat(), ORDER.ghost);
    this.#lit = new Strokes(this.#high, flat(), ORDER.lit);
    this.#solid = new Strokes(this.#high, new three.MeshLambertMaterial(), ORDER.solid);
    this.#floor = new three.LineSegments(
      new three.BufferGeometry(),
      new three.LineBasicMaterial({ vertexColors: true, depthTest: false, depthWrite: false }),
    );
    this.#way = new three.Mesh(
      new three.BufferGeometry(),
      new three.MeshBasicMaterial({ vertexColors: true, depthTest: false, depthWrite: false, side: three.DoubleSide }),
    );
    this.#way.renderOrder = ORDER.way;
    this.#floor.frustumCulled = this.#way.frustumCulled = false;
    this.#low.add(this.#floor, this.#way);
    this.#low.scale.y = 0; // all of it is flat, on the floor
    this.#scene.add(this.#sky, this.#sun, this.#low, this.#past, this.#high);
  }

  /**
   * @param {number} width
   * @param {number} height
   * @param {number} ratio
   */
  resize(width, height, ratio) {
    this.#renderer.setPixelRatio(ratio);
    this.#renderer.setSize(width, height, false);
  }

  dispose() {
    this.#renderer.dispose();
    this.#renderer.forceContextLoss(); // a browser has but a few of them
  }

  /**
   * @param {View[]} views
   * @param {Picture} picture
   */
  draw(views, { bodies, floor, palette }) {
    const linear = /** @type {Palette} */ (Object.fromEntries(
      Object.entries(palette).map(([name, color]) => [name, light(color)]),
    ));
    this.#bodies(bodies, palette, linear);
    this.#low.visible = floor !== null;
    this.#low.position.y = floor ?? 0;
    if (floor !== null) ways(this.#way.geometry, bodies, linear);
    const height = this.#renderer.domElement.clientHeight;
    for (const view of views) {
      const bottom = height - view.top - view.height;
      if (view.plan) this.#clear(view.left - 1, bottom - 1, view.width + 2, view.height + 2, palette.floor);
      this.#clear(view.left, bottom, view.width, view.height, palette.paper);
      if (floor !== null) this.#lines(view, linear);
      this.#past.visible = !view.plan;
      this.#renderer.render(this.#scene, this.#from(view));
    }
  }

  /**
   * @param {number} left
   * @param {number} bottom
   * @param {number} width
   * @param {number} height
   * @param {Color} color
   */
  #clear(left, bottom, width, height, color) {
    this.#renderer.setViewport(left, bottom, width, height);
    this.#renderer.setScissor(left, bottom, width, height);
    this.#renderer.setClearColor(new three.Color(...light(color)));
    this.#renderer.clear();
  }

  /**
   * Return the camera of a view.
   * @param {View} view
   */
  #from({ width, height, turn, tilt, target, span, plan }) {
    const [about, over] = [turn, tilt].map((it) => it * Math.PI / 180);
    const toward = [Math.cos(over) * Math.sin(about), Math.sin(over), Math.cos(over) * Math.cos(about)];
    const up = [-Math.sin(over) * Math.sin(about), Math.cos(over), -Math.sin(over) * Math.cos(about)];
    const camera = plan ? this.#above : this.#eye;
    const far = plan ? 20000 : span / 2 / Math.tan(FIELD / 2 * Math.PI / 180);
    if (camera instanceof three.OrthographicCamera) {
      [camera.top, camera.bottom] = [span / 2, -span / 2];
      [camera.left, camera.right] = [-span / 2 * width / height, span / 2 * width / height];
      camera.far = 2 * far;
    } else {
      camera.aspect = width / height;
      camera.near = far / 20;
      camera.far = 4 * far + 2 * REACH;
    }
    camera.updateProjectionMatrix();
    camera.position.set(target[0] + far * toward[0], target[1] + far * toward[1], target[2] + far * toward[2]);
    camera.up.set(up[0], up[1], up[2]);
    camera.lookAt(...target);
    // light comes from above the left shoulder of who looks
    this.#sun.position.set(
      toward[0] + up[0] - 0.3 * Math.cos(about), toward[1] + up[1], toward[2] + up[2] + 0.3 * Math.sin(about),
    );
    return camera;
  }

  /**
   * @param {Body[]} bodies
   * @param {Palette} palette
   * @param {Palette} linear the same, as light
   */
  #bodies(bodies, palette, linear) {
    const strokes = bodies.reduce((sum, body) => sum + body.strokes.length, 0);
    const ghosts = bodies.reduce((sum, body) => sum + body.strokes.length * (body.ghosts?.length ?? 0), 0);
    for (const some of [this.#solid, this.#lit, this.#shadow]) some.begin(strokes);
    this.#ghosts.begin(ghosts);
    const shade = light(between(palette.paper, palette.bone, SHADE));
    for (const { strokes, pose, lit, ghosts = [] } of bodies) {
      for (const { pose, faint } of ghosts) {
        for (const stroke of strokes) {
          const color = light(between(palette[stroke.color] ?? palette.bone, palette.paper, faint));
          put(this.#ghosts, stroke, pose, stroke.width, color);
        }
      }
      for (const stroke of strokes) {
        put(this.#solid, stroke, pose, stroke.width, linear[stroke.color] ?? linear.bone);
        put(this.#shadow, stroke, pose, stroke.width, shade);
        if (isLit(stroke, lit)) put(this.#lit, stroke, pose, stroke.width + BAND, linear.lit);
      }
    }
    for (const some of [this.#solid, this.#lit, this.#shadow, this.#ghosts]) some.end();
  }

  /**
   * Lay the lines of the floor around where the eye looks; they fade away.
   * @param {View} view
   * @param {Palette} palette
   */
  #lines({ target, span, plan }, { floor, paper }) {
    const wide = squares(plan ? span : 0), count = plan ? 12 : 2 * REACH / wide, half = count / 2;
    const [left, near] = [target[0], target[2]].map((at) => Math.round(at / wide) * wide);
    /** @type {number[]} */
    const places = [], /** @type {number[]} */ colors = [];
    /** @type {(x: number, z: number) => void} */
    const end = (x, z) => {
      const far = plan ? 0 : Math.hypot(x - target[0], z - target[2]) / REACH;
      places.push(x, 0, z);
      colors.push(...between(floor, paper, Math.min(far, 1) ** 1.5));
    };
    for (let line = -half; line <= half; line++) {
      for (let piece = -half; piece < half; piece++) {
        end(left + line * wide, near + piece * wide);
        end(left + line * wide, near + (piece + 1) * wide);
        end(left + piece * wide, near + line * wide);
        end(left + (piece + 1) * wide, near + line * wide);
      }
    }
    fill(this.#floor.geometry, places, colors);
  }
}

/**
 * Put corners into a geometry, which grows if it must.
 * @param {three.BufferGeometry} geometry
 * @param {number[]} places
 * @param {number[]} colors
 */
function fill(geometry, places, colors) {
  for (const [name, numbers] of /** @type {const} */ ([["position", places], ["color", colors]])) {
    const held = geometry.getAttribute(name);
    if (held instanceof three.BufferAttribute && held.array.length >= numbers.length) {
      held.array.set(numbers);
      held.needsUpdate = true;
    } else {
      if (held) geometry.dispose();
      geometry.setAttribute(name, new three.BufferAttribute(new Float32Array(numbers.concat(numbers)), 3));
    }
  }
  geometry.setDrawRange(0, places.length / 3);
}

/**
 * Add a stroke of a pose where both its ends are known.
 * @param {Strokes} strokes
 * @param {import("./look.js").Stroke} stroke
 * @param {Float32Array} pose
 * @param {number} width
 * @param {Color} color
 */
function put(strokes, { from, to, share }, pose, width, color) {
  const start = along(pose, from, to, share), end = along(pose, from, to, 1);
  if (start[0] === start[0] && end[0] === end[0]) strokes.add(start, end, width / 2, color);
}

/**
 * Return a colour as amounts of light.
 * @param {Color} color
 * @returns {Color}
 */
function light(color) {
  const { r, g, b } = new three.Color().setRGB(...color, three.SRGBColorSpace);
  return [r, g, b];
}

/**
 * Lay the ways of bodies onto the floor, the older the fainter.
 * @param {three.BufferGeometry} geometry
 * @param {Body[]} bodies
 * @param {Palette} palette
 */
function ways(geometry, bodies, palette) {
  /** @type {number[]} */
  const places = [], /** @type {number[]} */ colors = [];
  for (const { way } of bodies) {
    if (!way) continue;
    for (let at = 2; at < way.length; at += 2) {
      const [x, z, toX, toZ] = way.subarray(at - 2, at + 2), length = Math.hypot(toX - x, toZ - z);
      if (!(length > 0)) continue;
      const right = WAY / 2 * (toZ - z) / length, near = -WAY / 2 * (toX - x) / length;
      const corners = [[x - right, z - near], [x + right, z + near], [toX - right, toZ - near], [toX + right, toZ + near]];
      for (const corner of [0, 1, 2, 2, 1, 3]) places.push(corners[corner][0], 0, corners[corner][1]);
      const color = between(palette.paper, palette.way, 0.35 + 0.65 * (at / way.length) ** 2);
      for (let corner = 0; corner < 6; corner++) colors.push(...color);
    }
  }
  fill(geometry, places, colors);
}
