"use strict";
// Plays one face. The surface is bent here, shape by shape, and only lit on the graphics card:
// a face moves few vertices at a time, and normals come out right however it is bent.

const at = (id) => document.getElementById(id);
const scene = JSON.parse(at("scene").textContent);
const arrays = unpack(scene.arrays, at("arrays").textContent);
const count = arrays.positions.length / 3;
const frames = scene.fps ? arrays.weights.length / Math.max(scene.shapes.length, 1) : 0;
const holes = arrays.rim.reduce((most, rim) => Math.max(most, rim + 1), 0);
const points = new Float32Array(3 * (count + holes));
const normals = new Float32Array(3 * (count + holes));
const weights = new Float32Array(scene.shapes.length);

function unpack(table, text) {
  const kinds = { float32: Float32Array, uint32: Uint32Array, uint16: Uint16Array, int16: Int16Array, uint8: Uint8Array };
  const characters = atob(text), bytes = new Uint8Array(characters.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = characters.charCodeAt(i);
  const found = {};
  for (const [name, [kind, start, length]] of Object.entries(table)) found[name] = new kinds[kind](bytes.buffer, start, length);
  return found;
}

// ---- bending

function bend(frame) {
  points.set(arrays.positions);
  for (let k = 0; k < weights.length; k++) {
    const much = weights[k] * arrays.step[k];
    if (much === 0) continue;
    for (let i = arrays.first[k]; i < arrays.first[k + 1]; i++) {
      const v = 3 * arrays.moved[i];
      points[v] += much * arrays.steps[3 * i];
      points[v + 1] += much * arrays.steps[3 * i + 1];
      points[v + 2] += much * arrays.steps[3 * i + 2];
    }
  }
  if (arrays.bones) follow(arrays.bones.subarray(frame * (arrays.bones.length / frames)));
  closeHoles();
  findNormals();
}

function follow(bones) {
  for (let v = 0; v < count; v++) {
    const x = points[3 * v], y = points[3 * v + 1], z = points[3 * v + 2];
    let a = 0, b = 0, c = 0;
    for (let i = 4 * v; i < 4 * v + 4; i++) {
      const grip = arrays.grips[i], m = 12 * arrays.joints[i];
      if (grip === 0) continue;
      a += grip * (bones[m] * x + bones[m + 1] * y + bones[m + 2] * z + bones[m + 3]);
      b += grip * (bones[m + 4] * x + bones[m + 5] * y + bones[m + 6] * z + bones[m + 7]);
      c += grip * (bones[m + 8] * x + bones[m + 9] * y + bones[m + 10] * z + bones[m + 11]);
    }
    points[3 * v] = a; points[3 * v + 1] = b; points[3 * v + 2] = c;
  }
}

// Every rim is closed by a fan around its middle; drawn behind all else, it darkens what shows through.
function closeHoles() {
  const ends = new Float32Array(holes);
  points.fill(0, 3 * count);
  for (let i = 0; i < arrays.rims.length; i++) {
    const rim = arrays.rim[i >> 1], v = 3 * arrays.rims[i], m = 3 * (count + rim);
    ends[rim]++;
    for (let axis = 0; axis < 3; axis++) points[m + axis] += (points[v + axis] - points[m + axis]) / ends[rim];
  }
}

function findNormals() {
  const corner = arrays.triangles, same = arrays.same;
  normals.fill(0);
  for (let t = 0; t < corner.length; t += 3) {
    const a = 3 * corner[t], b = 3 * corner[t + 1], c = 3 * corner[t + 2];
    const ux = points[b] - points[a], uy = points[b + 1] - points[a + 1], uz = points[b + 2] - points[a + 2];
    const vx = points[c] - points[a], vy = points[c + 1] - points[a + 1], vz = points[c + 2] - points[a + 2];
    const nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    for (let i = t; i < t + 3; i++) {
      const n = 3 * same[corner[i]];
      normals[n] += nx; normals[n + 1] += ny; normals[n + 2] += nz;
    }
  }
  for (let v = 0; v < count; v++) {
    const n = 3 * same[v];
    const length = Math.hypot(normals[n], normals[n + 1], normals[n + 2]) || 1;
    for (let axis = 0; axis < 3; axis++) normals[3 * v + axis] = normals[n + axis] / (n === 3 * v ? length : 1);
  }
}

// ---- lighting, as in the pictures

const VERTEX = `#version 300 es
in vec3 place, normal, colour, gaze;
uniform mat4 lens, camera, head;
uniform float lid;
out vec3 way, tint, towards, seen;
void main() {
  vec4 p = camera * head * vec4(place, 1.0);
  seen = p.xyz;
  way = mat3(camera) * mat3(head) * normal;
  tint = mix(colour / 12.92, pow((colour + 0.055) / 1.055, vec3(2.4)), step(0.04045, colour));
  towards = gaze;
  gl_Position = lens * p;
  if (lid > 0.0) gl_Position.z = 0.99999 * gl_Position.w;
}`;

const FRAGMENT = `#version 300 es
precision highp float;
in vec3 way, tint, towards, seen;
uniform vec3 key, fill, rim, wrap, hollow, hole, iris, pupil;
uniform vec2 cosines;
uniform float knee, lid;
out vec4 result;
vec3 lit(vec3 base, vec3 n) {
  vec3 eye = vec3(seen.xy / seen.z, 1.0);
  float even = 0.17 * max(dot(n, fill) + 0.25, 0.0) + 0.15 + 0.05 * n.y;
  float away = 1.0 - max(dot(n, normalize(eye)), 0.0);
  float edge = 0.35 * pow(away, 4.0) * max(dot(n, rim) + 0.3, 0.0);
  float gleam = 0.055 * pow(max(dot(n, normalize(key + eye)), 0.0), 24.0);
  vec3 soft = 0.8 * max((dot(n, key) + wrap) / (1.0 + wrap), 0.0);
  return base * (soft + even + edge) + gleam + 0.3 * edge;
}
void main() {
  vec3 n = normalize(way), base = tint, light;
  if (dot(towards, towards) > 0.0) {
    float ahead = normalize(towards).z;
    base = ahead > cosines.y ? pupil : ahead > cosines.x ? iris : base;
  }
  if (lid > 0.0) light = hole;
  else if (!gl_FrontFacing) light = base * hollow * (0.4 + 0.6 * abs(n.z));
  else light = lit(base, n);
  vec3 rolled = knee + (1.0 - knee) * tanh((light - knee) / (1.0 - knee));
  light = mix(light, rolled, step(knee, light));
  result = vec4(mix(12.92 * light, 1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, light)), 1.0);
}`;

const stage = at("stage");
const gl = stage.getContext("webgl2", { antialias: true });
if (!gl) {
  at("trouble").hidden = false;
  at("trouble").textContent = "This browser does not offer WebGL 2, which this page draws with.";
  throw new Error("no WebGL 2");
}
const program = link();
const place = (name) => gl.getUniformLocation(program, name);
const lens = place("lens"), camera = place("camera"), head = place("head"), lid = place("lid");
const placeBuffer = stream("place"), normalBuffer = stream("normal");

function link() {
  const made = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  gl.useProgram(made);
  return made;
}

function stream(name, values, kind = gl.FLOAT, normalized = false) {
  const slot = gl.getAttribLocation(program, name), buffer = gl.createBuffer();
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  if (values) gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
  gl.enableVertexAttribArray(slot);
  gl.vertexAttribPointer(slot, 3, kind, normalized, 0, 0);
  return buffer;
}

function padded(values) {
  const longer = new values.constructor(3 * (count + holes));
  longer.set(values);
  return longer;
}

function setUp() {
  stream("colour", padded(arrays.colours), gl.UNSIGNED_BYTE, true);
  stream("gaze", padded(arrays.gaze || new Int16Array(3)), gl.SHORT, true);
  const corners = new Uint32Array(arrays.triangles.length + 3 * arrays.rim.length);
  corners.set(arrays.triangles);
  arrays.rim.forEach((rim, e) => {
    corners.set([arrays.rims[2 * e], arrays.rims[2 * e + 1], count + rim], arrays.triangles.length + 3 * e);
  });
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, corners, gl.STATIC_DRAW);
  gl.enable(gl.DEPTH_TEST);
  for (const name of ["key", "fill", "rim", "wrap", "hollow", "hole", "iris", "pupil"]) {
    gl.uniform3fv(place(name), scene.light[name]);
  }
  gl.uniform2fv(place("cosines"), scene.light.cosines);
  gl.uniform1f(place("knee"), scene.light.knee);
}

// ---- the camera

const first = scene.camera, back = first.position.map((p, i) => p - first.target[i]);
const home = { turn: Math.atan2(back[0], back[2]), lift: Math.asin(back[1] / Math.hypot(...back)), away: Math.hypot(...back) };
let eye = { ...home };

function look() {
  const width = stage.clientWidth, height = stage.clientHeight, dense = window.devicePixelRatio || 1;
  if (stage.width !== Math.round(width * dense) || stage.height !== Math.round(height * dense)) {
    stage.width = Math.round(width * dense);
    stage.height = Math.round(height * dense);
  }
  gl.viewport(0, 0, stage.width, stage.height);
  const focus = 1 / Math.tan(first.angle / 2), narrow = Math.min(1, width / height);
  const near = 0.02 * eye.away, far = 20 * eye.away, depth = near - far;
  gl.uniformMatrix4fv(lens, false, [
    focus * narrow * height / width, 0, 0, 0, 0, focus * narrow, 0, 0, 0, 0, (near + far) / depth, -1, 0, 0, 2 * near * far / depth, 0]);
  const [ct, st, cl, sl] = [Math.cos(eye.turn), Math.sin(eye.turn), Math.cos(eye.lift), Math.sin(eye.lift)];
  const right = [ct, 0, -st], up = [-st * sl, cl, -ct * sl], out = [st * cl, sl, ct * cl];
  const shift = (axis) => -axis.reduce((sum, a, i) => sum + a * first.target[i], 0);
  gl.uniformMatrix4fv(camera, false, [
    right[0], up[0], out[0], 0, right[1], up[1], out[1], 0, right[2], up[2], out[2], 0,
    shift(right), shift(up), shift(out) - eye.away, 1]);
}

function draw() {
  const h = arrays.head ? arrays.head.subarray(12 * now, 12 * now + 12) : [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0];
  gl.uniformMatrix4fv(head, false, [h[0], h[4], h[8], 0, h[1], h[5], h[9], 0, h[2], h[6], h[10], 0, h[3], h[7], h[11], 1]);
  look();
  for (const [buffer, values] of [[placeBuffer, points], [normalBuffer, normals]]) {
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.DYNAMIC_DRAW);
  }
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.uniform1f(lid, 0);
  gl.drawElements(gl.TRIANGLES, arrays.triangles.length, gl.UNSIGNED_INT, 0);
  gl.uniform1f(lid, 1);
  gl.drawElements(gl.TRIANGLES, 3 * arrays.rim.length, gl.UNSIGNED_INT, 4 * arrays.triangles.length);
}

stage.addEventListener("pointerdown", (event) => stage.setPointerCapture(event.pointerId));
stage.addEventListener("pointermove", (event) => {
  if (!event.buttons) return;
  eye.turn -= event.movementX / 150;
  eye.lift = Math.max(-1.5, Math.min(1.5, eye.lift + event.movementY / 150));
  stale = true;
});
stage.addEventListener("wheel", (event) => {
  event.preventDefault();
  eye.away = Math.max(0.2 * home.away, Math.min(5 * home.away, eye.away * Math.exp(event.deltaY / 900)));
  stale = true;
}, { passive: false });
stage.addEventListener("dblclick", () => { eye = { ...home }; stale = true; });
window.addEventListener("resize", () => { stale = true; });

// ---- time

let now = 0, clock = 0, before = null, playing = false, stale = true;

function show(frame) {
  now = frame;
  if (frames) weights.set(arrays.weights.subarray(frame * weights.length, (frame + 1) * weights.length));
  rows.forEach(tell);
  if (frames) {
    at("scrub").value = frame;
    at("clock").textContent = `${(frame / scene.fps).toFixed(2)} s · ${frame + 1} / ${frames}`;
  }
  stale = true;
}

function play(on) {
  playing = on;
  before = null;
  at("play").textContent = on ? "❚❚" : "▶";
}

function tick(time) {
  if (playing) {
    clock = (clock + (before === null ? 0 : time - before) / 1000) % (frames / scene.fps);
    before = time;
    const frame = Math.min(frames - 1, Math.floor(clock * scene.fps + 1e-6));
    if (frame !== now) show(frame);
  }
  if (stale) {
    stale = false;
    bend(now);
    draw();
  }
  requestAnimationFrame(tick);
}

// ---- the list of shapes

const rows = scene.shapes.map((name, k) => {
  if (scene.still.includes(name)) return null;
  const label = document.createElement("label"), word = document.createElement("span");
  const number = document.createElement("output"), slider = document.createElement("input");
  word.textContent = word.title = name;
  Object.assign(slider, { type: "range", min: 0, max: 1, step: 0.01 });
  slider.addEventListener("input", () => {
    if (playing) play(false);
    weights[k] = Number(slider.value);
    tell(rows[k], k);
    stale = true;
  });
  label.append(word, number, slider);
  at("list").append(label);
  return { label, number, slider };
});

function tell(row, k) {
  if (!row) return;
  const text = weights[k].toFixed(2);
  if (row.number.textContent === text) return;
  row.number.textContent = text;
  row.slider.value = weights[k];
  row.label.classList.toggle("on", Math.abs(weights[k]) >= 0.005);
}

at("name").textContent = scene.name;
at("bar").hidden = frames < 2;
at("scrub").max = Math.max(frames - 1, 0);
at("scrub").addEventListener("input", () => {
  play(false);
  clock = at("scrub").valueAsNumber / scene.fps;
  show(at("scrub").valueAsNumber);
});
at("play").addEventListener("click", () => play(!playing));
window.addEventListener("keydown", (event) => {
  if (event.code === "Space" && frames > 1 && event.target === document.body) play(!playing);
});

setUp();
const asked = /^#t=([0-9.]+)$/.exec(window.location.hash);
if (asked && frames) clock = Math.min(Number(asked[1]), (frames - 1) / scene.fps);
show(frames ? Math.min(frames - 1, Math.floor(clock * scene.fps + 1e-6)) : 0);
play(frames > 1 && !asked);
requestAnimationFrame(tick);
