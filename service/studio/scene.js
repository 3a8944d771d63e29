// A spatial cam turning under its rollers, drawn by the browser's WebGL. The body, the rollers and
// where they go come from the service; here they are only shown.

import { along, bodyOf, cross, cylinder, dot, minus, perspective, times, turn, unitOf, view } from "./space.js";

const VERTEX = `#version 300 es
uniform mat4 model, camera, lens;
in vec3 place, normal;
out vec3 seen, facing;
void main() {
  vec4 at = camera * model * vec4(place, 1.0);
  seen = at.xyz;
  vec3 turned = mat3(camera) * (inverse(transpose(mat3(model))) * normal);
  facing = turned / max(length(turned), 1e-6);
  gl_Position = lens * at;
}`;
const FRAGMENT = `#version 300 es
precision highp float;
uniform vec3 colour;
in vec3 seen, facing;
out vec4 shown;
void main() {
  vec3 toward = normalize(-seen);
  // where a smooth strip has a corner, or no area, the cell's own normal is the better one
  vec3 flat_ = normalize(cross(dFdx(seen), dFdy(seen)));
  vec3 n = abs(dot(facing, flat_)) < 0.8 * length(facing) || length(facing) < 0.5 ? flat_ : normalize(facing);
  n = dot(n, toward) < 0.0 ? -n : n;
  vec3 light = normalize(vec3(-0.45, 0.65, 0.75));
  float bright = 0.34 + 0.58 * max(dot(n, light), 0.0) + 0.12 * max(dot(n, toward), 0.0);
  float gloss = 0.18 * pow(max(dot(reflect(-light, n), toward), 0.0), 24.0);
  shown = vec4(colour * bright + gloss, 1.0);
}`;
const ANGLE = 0.5; // of the lens [rad]

export class Scene {
  /** Throws where the browser has no WebGL 2. */
  constructor(canvas) {
    this.canvas = canvas;
    this.gl = canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
    if (!this.gl) throw new Error("This browser shows no pictures in space (WebGL 2).");
    this.program = linked(this.gl);
    this.places = Object.fromEntries(
      ["model", "camera", "lens", "colour"].map((name) => [name, this.gl.getUniformLocation(this.program, name)]),
    );
    this.roller = this.#held(cylinder());
    Object.assign(this, { yaw: -0.7, pitch: 0.45, away: 1, angle: 0 });
    new ResizeObserver(() => this.draw()).observe(canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
  }

  /** The surfaces of a cam, as `surfaces.json` tells them. */
  show({ body, follower }) {
    this.clear();
    const made = bodyOf(body);
    this.body = this.#held(made);
    this.follower = follower;
    this.#frame(made.places, follower.seats.flatMap((seat) => this.#ends(seat, 0)));
    this.draw();
  }

  /** Shows nothing. */
  clear() {
    if (this.body) this.#let(this.body);
    this.body = null;
    this.draw();
  }

  /** Shows a cam angle [°]. */
  turnTo(angle) {
    this.angle = angle;
    this.draw();
  }

  /** Looks at the middle of all that is there, from so far that it fits as it turns. */
  #frame(places, ends) {
    const radius = Math.sqrt(places.reduce((most, _, k) => (k % 3 ? most : Math.max(most, places[k] ** 2 + places[k + 1] ** 2)), 0));
    const heights = places.filter((_, k) => k % 3 === 2);
    const sides = [0, 1, 2].map((k) => {
      const cam = k === 2 ? heights : [-radius, radius];
      const all = [...ends.map((end) => end[k]), cam.reduce((a, b) => Math.min(a, b)), cam.reduce((a, b) => Math.max(a, b))];
      return [Math.min(...all), Math.max(...all)];
    });
    this.centre = sides.map(([low, high]) => 0.5 * (low + high));
    this.reach = 0.5 * Math.hypot(...sides.map(([low, high]) => high - low));
  }

  /** Turns the view by a movement of the pointer [pixels]. */
  orbit(right, down) {
    this.yaw -= 0.008 * right;
    this.pitch = Math.max(-1.5, Math.min(1.5, this.pitch + 0.008 * down));
    this.draw();
  }

  zoom(factor) {
    this.away = Math.max(0.3, Math.min(4, this.away * factor));
    this.draw();
  }

  draw() {
    const { gl, canvas } = this;
    const scale = Math.min(devicePixelRatio || 1, 2);
    [canvas.width, canvas.height] = [canvas.clientWidth * scale, canvas.clientHeight * scale].map(Math.round);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(...colour("--ground"), 1);
    gl.enable(gl.DEPTH_TEST);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    if (!this.body) return;
    gl.useProgram(this.program);
    const aspect = canvas.width / canvas.height;
    const distance = (0.85 * this.away * this.reach) / Math.tan(ANGLE / 2) / Math.min(1, aspect);
    gl.uniformMatrix4fv(this.places.camera, false, view(this.yaw, this.pitch, distance, this.centre));
    const lens = perspective(ANGLE, aspect, 0.05 * distance, 10 * distance);
    gl.uniformMatrix4fv(this.places.lens, false, lens);
    const turns = (this.follower.cam_turns * this.angle * Math.PI) / 180;
    this.#put(this.body, turn(turns), colour("--steel"));
    for (const seat of this.follower.seats) {
      const [inner, outer] = this.#ends(seat, this.#moved());
      this.#put(this.roller, along(inner, minus(outer, inner), this.follower.radius_mm), colour("--brass"));
    }
    for (const model of this.#turret()) this.#put(this.roller, model, colour("--cast"));
  }

  /** q at the present cam angle. */
  #moved() {
    const { q } = this.follower;
    const place = (this.angle / 360) * (q.length - 1);
    const k = Math.max(0, Math.min(Math.floor(place), q.length - 2));
    return q[k] + (place - k) * (q[k + 1] - q[k]);
  }

  /** Both ends of a roller when the follower has moved by q. */
  #ends({ start }, q) {
    const { origin_mm: origin, along: way, inner_mm: inner, outer_mm: outer } = this.follower;
    const [from, direction] = [placed(origin, start + q), placed(way, start + q)];
    return [inner, outer].map((rho) => from.map((value, k) => value + rho * direction[k]));
  }

  /** What radial rollers sit on: a disc about the axis that they turn about, and their pins. */
  #turret() {
    const { origin_mm: origin, along: way, inner_mm: inner, radius_mm: radius, seats } = this.follower;
    const axis = cross(way[1], way[2]);
    if (dot(axis, axis) < 0.5) return [];
    const thick = unitOf(axis).map((value) => value * 1.3 * radius);
    const centre = origin[0].map((value, k) => value - 0.5 * thick[k]);
    const pins = seats.map((seat) => {
      const [end] = this.#ends(seat, this.#moved());
      return along(origin[0], minus(end, origin[0]), 0.45 * radius);
    });
    return [along(centre, thick, 0.72 * inner), ...pins];
  }

  #put(mesh, model, shade) {
    const { gl } = this;
    gl.uniformMatrix4fv(this.places.model, false, model);
    gl.uniform3fv(this.places.colour, shade);
    gl.bindVertexArray(mesh.array);
    gl.drawElements(gl.TRIANGLES, mesh.count, gl.UNSIGNED_INT, 0);
  }

  #held({ places, normals, corners }) {
    const { gl } = this;
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    const buffers = [["place", places], ["normal", normals]].map(([name, values]) => {
      const buffer = gl.createBuffer();
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
      const at = gl.getAttribLocation(this.program, name);
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, 3, gl.FLOAT, false, 0, 0);
      return buffer;
    });
    const order = gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, order);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, corners, gl.STATIC_DRAW);
    return { array, buffers: [...buffers, order], count: corners.length };
  }

  #let({ array, buffers }) {
    buffers.forEach((buffer) => this.gl.deleteBuffer(buffer));
    this.gl.deleteVertexArray(array);
  }
}

/** a + b cos q + c sin q + d q */
const placed = ([a, b, c, d], q) => a.map((value, k) => value + b[k] * Math.cos(q) + c[k] * Math.sin(q) + d[k] * q);

/** A colour of the page's style, red, green and blue from 0 to 1. */
function colour(name) {
  const text = getComputedStyle(document.documentElement).getPropertyValue(name).trim().slice(1);
  const full = text.length === 3 ? [...text].map((digit) => digit + digit).join("") : text;
  return [0, 2, 4].map((at) => parseInt(full.slice(at, at + 2), 16) / 255);
}

function linked(gl) {
  const program = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  return program;
}
