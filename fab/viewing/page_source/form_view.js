// The sheet or its panels in space, from flat to folded.

import {
  BackSide,
  BufferAttribute,
  BufferGeometry,
  Color,
  DirectionalLight,
  DoubleSide,
  FrontSide,
  HemisphereLight,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  PerspectiveCamera,
  Scene,
  Spherical,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { Poses } from "./poses.js";
import { between, boxMiddle, sheetStates } from "./states.js";

const FIELD_DEG = 35;
const TURN_RAD = Math.PI / 24;
const ZOOM = 1.2;
const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;
const MOST_SMOOTH = 10_000; // triangles whose rims software smooths in good time
const FRAME = 1.06; // a margin around what is shown

let drawer; // what draws, empty where nothing does: a browser has few contexts, so that it is asked once

/** Whether the browser draws in space at all. */
export function canDraw() {
  drawer ??= drawerName();
  return drawer !== "";
}

/** Whether the processor draws, for want of a graphics card. */
function drawsBySoftware() {
  return canDraw() && SOFTWARE.test(drawer);
}

function drawerName() {
  try {
    const gl = document.createElement("canvas").getContext("webgl2");
    const names = gl?.getExtension("WEBGL_debug_renderer_info");
    return gl ? String(gl.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : gl.RENDERER)) : "";
  } catch {
    return "";
  }
}

/** One thing that folds: its states, and what is drawn of them. */
class Form {
  constructor(states) {
    this.states = states;
    this.place = new BufferAttribute(new Float32Array(states[0].length), 3);
    this.objects = [];
    this.lit = [];
  }

  geometry(index) {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", this.place);
    geometry.setIndex(new BufferAttribute(index, 1));
    return geometry;
  }

  faces(index, colour, side) {
    const material = new MeshLambertMaterial({
      color: colour,
      side,
      flatShading: true,
      polygonOffset: true,
      polygonOffsetFactor: 1,
      polygonOffsetUnits: 1,
    });
    this.#add(new Mesh(this.geometry(index), material));
  }

  /** The same triangles, each of its own colour, which `fold` finds. */
  valued(index, faces, values, ramp) {
    const [place, colour] = [0, 1].map(() => new BufferAttribute(new Float32Array(3 * index.length), 3));
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", place);
    geometry.setAttribute("color", colour);
    const material = new MeshLambertMaterial({ vertexColors: true, side: DoubleSide, flatShading: true });
    Object.assign(material, { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
    const mesh = new Mesh(geometry, material);
    this.values = { mesh, index, faces, shares: values, colours: ramp.map((hex) => new Color(hex)) };
    this.#add(mesh);
  }

  lines(index, colour, look = {}) {
    const lines = new LineSegments(this.geometry(index), new LineBasicMaterial({ color: colour, ...look }));
    lines.userData.creases = true;
    this.#add(lines);
  }

  #add(object) {
    object.frustumCulled = false; // its box changes as it folds
    this.objects.push(object);
  }

  /** Light up triangles and lines, in place of those before. */
  light(triangles, lines, colour) {
    for (const object of this.lit) object.geometry.dispose();
    const through = { color: colour, depthTest: false, transparent: true };
    const areas = new MeshBasicMaterial({ ...through, side: DoubleSide, opacity: 0.6 });
    this.lit = [
      new Mesh(this.geometry(triangles), areas),
      new LineSegments(this.geometry(lines), new LineBasicMaterial(through)),
    ];
    for (const object of this.lit) Object.assign(object, { renderOrder: 1, frustumCulled: false });
  }

  fold(place) {
    between(this.states, Math.min(place, this.states.length - 1), this.place.array);
    this.place.needsUpdate = true;
    if (this.values?.mesh.visible) this.#paint(place);
  }

  #paint(place) {
    const { mesh, index, faces, shares, colours } = this.values;
    const { position, color } = mesh.geometry.attributes;
    const count = shares.length / this.states.length;
    const first = Math.min(Math.floor(place), this.states.length - 1);
    const second = Math.min(first + 1, this.states.length - 1);
    const mixed = new Color();
    for (let corner = 0; corner < index.length; corner++) {
      for (let k = 0; k < 3; k++) {
        position.array[3 * corner + k] = this.place.array[3 * index[corner] + k];
      }
      if (corner % 3 === 0) {
        const face = faces[corner / 3];
        const [a, b] = [shares[first * count + face], shares[second * count + face]];
        const at = ((a + (place - first) * (b - a)) / 255) * (colours.length - 1);
        const low = Math.min(Math.floor(at), colours.length - 2);
        mixed.lerpColors(colours[low], colours[low + 1], at - low);
      }
      mixed.toArray(color.array, 3 * corner);
    }
    position.needsUpdate = color.needsUpdate = true;
  }
}

/** Rigid bodies that fold, of which states are boxes around them. */
class PosedForm extends Form {
  constructor(bodies, count, used) {
    const poses = new Poses(bodies, count, used);
    super(poses.boxes());
    this.poses = poses;
    this.place = new BufferAttribute(new Float32Array(bodies.positions.length), 3);
  }

  fold(place) {
    this.poses.fold(Math.min(place, this.states.length - 1), this.place.array);
    this.place.needsUpdate = true;
  }
}

/** Rows of `width` numbers of an array whose owner, one for each row, is among some. */
function rowsOf(array, width, owners, chosen) {
  const wanted = new Set(chosen);
  const rows = [];
  owners.forEach((owner, row) => {
    if (wanted.has(owner)) rows.push(...array.subarray(width * row, width * (row + 1)));
  });
  return Uint32Array.from(rows);
}

/** Numbers 0, 1, ..., each as often as is counted. */
function repeated(counts) {
  return [...counts].flatMap((count, number) => Array(count).fill(number));
}

/** Rows of vertices of bodies, each of which numbers its own from 0, with numbers of all vertices. */
function ofSheet(rows, width, rowsCount, verticesCount) {
  const out = new Uint32Array(rows.length);
  let [place, first] = [0, 0];
  rowsCount.forEach((count, body) => {
    for (const end = place + width * count; place < end; place++) out[place] = rows[place] + first;
    first += verticesCount[body];
  });
  return out;
}

export function sheetForm(data) {
  const { sheet, colours } = data;
  const form = new Form(sheetStates(sheet, data.states.length));
  const { triangles, trianglesFace: faces, edges } = sheet;
  form.faces(triangles, colours.upper, FrontSide);
  form.faces(triangles, colours.lower, BackSide);
  form.sides = [...form.objects];
  if (data.values) form.valued(triangles, faces, data.values.shares, data.colours.ramp);
  for (const [letter, colour] of Object.entries(colours.edges)) {
    const own = [];
    for (let e = 0; e < sheet.letters.length; e++) if (sheet.letters[e] === letter) own.push(e);
    const index = own.flatMap((e) => [edges[2 * e], edges[2 * e + 1]]);
    if (index.length) form.lines(Uint32Array.from(index), colour);
  }
  const numbers = Uint32Array.from({ length: edges.length / 2 }, (_, e) => e);
  form.marked = ({ creases, panels }) => [
    rowsOf(triangles, 3, faces, panels),
    rowsOf(edges, 2, numbers, creases),
  ];
  return form;
}

function bodyForm(data) {
  const { bodies } = data;
  const form = new PosedForm(bodies, data.states.length, data.panelsState + 1);
  const owners = repeated(bodies.trianglesCount);
  const triangles = ofSheet(bodies.triangles, 3, bodies.trianglesCount, bodies.verticesCount);
  bodies.colours.forEach((colour, k) => {
    const alike = bodies.bodiesColour.flatMap((own, body) => (own === k ? [body] : []));
    form.faces(rowsOf(triangles, 3, owners, alike), colour, FrontSide);
  });
  const edges = ofSheet(bodies.edges, 2, bodies.edgesCount, bodies.verticesCount);
  if (edges.length) form.lines(edges, data.colours.edges.B, { transparent: true, opacity: 0.4 });
  form.marked = ({ creases, panels }) => {
    const named = bodies.panels.flatMap((panel, body) =>
      panels.includes(panel) || creases.includes(bodies.creases[body]) ? [body] : [],
    );
    return [rowsOf(triangles, 3, owners, named), new Uint32Array()];
  };
  return form;
}

/**
 * From how far each state fits a picture whose middle is `middle`, seen along axes: to the right,
 * upwards, to the viewer.
 */
function distances(states, middle, axes, aspect) {
  const [right, up, toward] = axes.map((axis) => axis.toArray());
  const slope = Math.tan((FIELD_DEG / 2) * (Math.PI / 180));
  return states.map((coords) => {
    let distance = 0;
    for (let i = 0; i < coords.length; i += 3) {
      const [x, y, z] = [coords[i] - middle[0], coords[i + 1] - middle[1], coords[i + 2] - middle[2]];
      const along = (axis) => axis[0] * x + axis[1] * y + axis[2] * z;
      const aside = Math.max(Math.abs(along(up)), Math.abs(along(right)) / aspect);
      distance = Math.max(distance, along(toward) + (FRAME * aside) / slope);
    }
    return distance || 1;
  });
}

function triangleCount({ sheet, bodies }) {
  return Math.max(sheet ? sheet.triangles.length : 0, bodies ? bodies.triangles.length : 0) / 3;
}

/** What is drawn on a canvas; `forms` says which of "sheet" and "panels" there are. */
export class FormView {
  constructor(canvas, data) {
    this.canvas = canvas;
    this.forms = {};
    if (data.sheet) this.forms.sheet = sheetForm(data);
    if (data.bodies) this.forms.panels = bodyForm(data);
    const many = triangleCount(data) > MOST_SMOOTH;
    this.renderer = new WebGLRenderer({ canvas, antialias: !(many && drawsBySoftware()) });
    this.camera = new PerspectiveCamera(FIELD_DEG, 1, 1, 1000);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableZoom = false; // the wheel scrolls the page until the view is used
    this.controls.addEventListener("change", () => this.ask());
    this.controls.addEventListener("start", () => (this.moved = true));
    canvas.addEventListener("focus", () => (this.controls.enableZoom = true));
    canvas.addEventListener("blur", () => (this.controls.enableZoom = false));
    canvas.addEventListener("pointerdown", () => canvas.focus());
    canvas.addEventListener("keydown", (event) => this.#key(event));
    this.lights = [new HemisphereLight(0xffffff, 0xb0a898, 1.9), new DirectionalLight(0xffffff, 1.6)];
    this.direction = new Vector3(...data.view);
    this.place = 0;
    this.creases = true;
    this.byValue = false;
    this.picked = { creases: [], panels: [] };
    new ResizeObserver(() => this.#resize()).observe(canvas.parentElement);
    this.show(Object.keys(this.forms)[0]);
  }

  show(name) {
    this.shown = name;
    this.form = this.forms[name];
    this.distances = undefined;
    this.fold(this.place);
    this.pick(this.picked);
    this.reset();
  }

  fold(place) {
    this.place = place;
    if (this.form.values) {
      this.form.values.mesh.visible = this.byValue;
      for (const side of this.form.sides) side.visible = !this.byValue;
    }
    this.form.fold(place);
    if (this.distances && !this.moved) this.#follow();
    this.ask();
  }

  pick(finding) {
    this.picked = finding;
    this.form.light(...this.form.marked(finding), getColour("--light"));
    this.scene = new Scene();
    this.scene.background = new Color(getColour("--space"));
    this.scene.add(...this.lights, ...this.form.objects, ...this.form.lit);
    this.ask();
  }

  showValues(shown) {
    this.byValue = shown;
    this.fold(this.place);
  }

  showCreases(shown) {
    this.creases = shown;
    this.ask();
  }

  reset() {
    this.moved = false;
    const toward = this.direction.clone().normalize();
    const right = new Vector3(0, 0, 1).cross(toward).normalize();
    const axes = [right, toward.clone().cross(right), toward];
    const { states } = this.form;
    const middle = boxMiddle(states);
    this.distances = distances(states, middle, axes, this.camera.aspect);
    this.far = Math.max(...this.distances);
    this.controls.target.set(...middle);
    this.camera.near = this.far / 100;
    this.camera.far = this.far * 20;
    this.camera.updateProjectionMatrix();
    this.camera.position.copy(toward).add(this.controls.target);
    this.#follow();
  }

  /** Come nearer as the form gets smaller, by half as much: it is large, and seen to shrink. */
  #follow() {
    const first = Math.min(Math.floor(this.place), this.distances.length - 1);
    const second = Math.min(first + 1, this.distances.length - 1);
    const share = this.place - first;
    const own = this.distances[first] + share * (this.distances[second] - this.distances[first]);
    const toward = this.camera.position.clone().sub(this.controls.target);
    toward.setLength((own + this.far) / 2);
    this.camera.position.copy(toward.add(this.controls.target));
    this.controls.update();
    this.ask();
  }

  turn(right, up) {
    this.moved = true;
    const way = this.camera.position.clone().sub(this.controls.target);
    way.applyQuaternion(this.#toY);
    const place = new Spherical().setFromVector3(way);
    place.theta += right;
    place.phi -= up;
    way.setFromSpherical(place.makeSafe()).applyQuaternion(this.#fromY);
    this.camera.position.copy(way.add(this.controls.target));
    this.controls.update();
    this.ask();
  }

  zoom(factor) {
    this.moved = true;
    const way = this.camera.position.clone().sub(this.controls.target);
    const length = Math.min(Math.max(way.length() / factor, this.far / 50), this.far * 10);
    this.camera.position.copy(way.setLength(length).add(this.controls.target));
    this.controls.update();
    this.ask();
  }

  /** Draw before the next picture of the browser, once however often it is asked. */
  ask() {
    this.asked ??= requestAnimationFrame(() => {
      this.asked = undefined;
      for (const object of this.form.objects) {
        if (object.userData.creases) object.visible = this.creases;
      }
      this.lights[1].position.copy(this.camera.position).sub(this.controls.target);
      this.renderer.render(this.scene, this.camera);
    });
  }

  get #toY() {
    return this.toY ??= this.#fromY.clone().invert();
  }

  get #fromY() {
    return this.fromY ??= this.camera.quaternion.clone().setFromUnitVectors(
      new Vector3(0, 1, 0),
      new Vector3(0, 0, 1),
    );
  }

  #resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    if (!width || !height) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (this.moved) this.ask();
    else this.reset();
  }

  #key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const moves = {
      ArrowLeft: () => this.turn(-TURN_RAD, 0),
      ArrowRight: () => this.turn(TURN_RAD, 0),
      ArrowUp: () => this.turn(0, TURN_RAD),
      ArrowDown: () => this.turn(0, -TURN_RAD),
      "+": () => this.zoom(ZOOM),
      "=": () => this.zoom(ZOOM),
      "-": () => this.zoom(1 / ZOOM),
      0: () => this.reset(),
    };
    if (!(event.key in moves)) return;
    event.preventDefault();
    moves[event.key]();
  }
}

function getColour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}
