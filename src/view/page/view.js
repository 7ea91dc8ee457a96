// The page of `kagero view`: shows pictures that the server computes, and changes the keys of the scene.
'use strict';

const token = document.body.dataset.token;
const tab = Array.from(crypto.getRandomValues(new Uint8Array(8)), (b) => b.toString(16).padStart(2, '0')).join('');
const element = (id) => document.getElementById(id);
const picture = element('picture'), context = picture.getContext('2d');

let scene = null;  // what GET /scene returns
let keys = {};     // the changed keys of the scene
let layer = 'color';

const address = (path, query = '') => `${path}?token=${token}${query}`;
const post = (path, query, body, signal) =>
  fetch(address(path, query), {method: 'POST', headers: {'Content-Type': 'application/json'},
                               body: JSON.stringify(body), signal});

// ---- vectors ----
const add = (a, b, f = 1) => a.map((x, i) => x + f * b[i]);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const length = (a) => Math.hypot(...a);
const unit = (a) => a.map((x) => x / length(a));
/// Turns v around the unit vector k.
const turned = (v, k, angle) => {
  const c = Math.cos(angle), s = Math.sin(angle);
  return add(add(v.map((x) => x * c), cross(k, v), s), k, dot(k, v) * (1 - c));
};

// ---- the camera ----
const value = (key) => keys[key] ?? initialValue(key);
function initialValue(key) {
  const [table, name] = key.split('.');
  return table === 'camera' ? scene.camera[name] : table === 'film' ? scene.film[name] : undefined;
}
const forward = () => unit(add(value('camera.look_at'), value('camera.position'), -1));
const up = () => unit(value('camera.up'));
const right = () => unit(cross(forward(), up()));
const distance = () => Math.max(1e-9, length(add(scene.camera.look_at, scene.camera.position, -1)));

function turn(yaw, pitch) {
  const limit = 89 * Math.PI / 180, height = Math.asin(Math.max(-1, Math.min(1, dot(forward(), up()))));
  const allowed = Math.max(-limit, Math.min(limit, height + pitch)) - height;
  let d = turned(forward(), right(), allowed);
  d = turned(d, up(), yaw);
  set('camera.look_at', add(value('camera.position'), d, distance()));
}
function walk(ahead, aside, upward) {
  const move = add(add(forward().map((x) => x * ahead), right(), aside), up(), upward);
  set('camera.position', add(value('camera.position'), move));
  set('camera.look_at', add(value('camera.look_at'), move));
}
const is_orthographic = () => scene.camera.type === 'orthographic';
/// Returns the angle in degrees by which dragging over the height of the picture turns the view.
const angle_of_height = () => scene.camera.type === 'perspective' ? value('camera.fov') : 60;
function zoom(factor) {
  if (is_orthographic()) set('camera.height', value('camera.height') * factor);
  else if (scene.camera.type === 'perspective')
    set('camera.fov', Math.max(0.5, Math.min(160, value('camera.fov') * factor)));
}

// ---- requests for pictures ----
const still_after = 250;  // milliseconds without a change
const samples = [4, 16];  // rays per pixel of the pictures that follow the first whole one
let version = 0, shown = 0, sent = -1, stage = 0, last_change = 0, blocked = false, retry_at = 0, info = null;
const flights = new Set();
const deliveries = [];

function changed() {
  ++version;
  stage = 0;
  blocked = false;
  last_change = performance.now();
  for (const flight of flights) if (!flight.moving) flight.abort.abort();
  pump();
  save_hash();
}
function request(quality, spp = 1) {
  return {tab, keys, layer, quality, spp, width: scene.film.width, height: scene.film.height};
}
function pump() {
  if (!scene || performance.now() < retry_at) return;
  const moving = [...flights].filter((flight) => flight.moving).length;
  if (sent < version) {
    if (moving < 2 && moving === flights.size) fly(request('moving'), true);
    return;
  }
  if (blocked || flights.size > 0 || document.hidden || performance.now() - last_change < still_after) return;
  if (stage === 0) fly(request('full'), false);
  else if (stage <= samples.length) fly(request('fine', samples[stage - 1]), false);
}
async function fly(body, moving) {
  const flight = {moving, version, abort: new AbortController()};
  flights.add(flight);
  sent = version;
  try {
    const response = await post('picture', '', body, flight.abort.signal);
    if (response.status === 200) {
      await show(await response.blob(), JSON.parse(response.headers.get('X-Kagero')), flight);
      if (!moving && flight.version === version) ++stage;
      report_error('');
    } else if (response.status === 503 || response.status === 429) {
      retry_at = performance.now() + 500;
      sent = Math.min(sent, flight.version - 1);
    } else if (response.status !== 204 && flight.version === version) {
      blocked = true;
      report_error((await response.json()).error);
    }
  } catch (error) {
    if (error.name !== 'AbortError') {
      retry_at = performance.now() + 1000;
      sent = Math.min(sent, flight.version - 1);
      report_error('The viewer does not answer. Is `kagero view` still running?');
    }
  }
  flights.delete(flight);
  pump();
}
async function show(blob, new_info, flight) {
  const bitmap = await createImageBitmap(blob);
  if (flight.version < shown) return bitmap.close();
  shown = flight.version;
  info = new_info;
  if (picture.width !== scene.film.width || picture.height !== scene.film.height) {
    picture.width = scene.film.width;
    picture.height = scene.film.height;
  }
  context.imageSmoothingQuality = 'high';
  context.drawImage(bitmap, 0, 0, picture.width, picture.height);
  bitmap.close();
  const now = performance.now();
  deliveries.push(now);
  while (now - deliveries[0] > 2000) deliveries.shift();
  show_info(flight.moving);
}
function show_info(moving) {
  const pixels = (x) => x === 0 ? '0' : x < 1e-3 ? x.toExponential(1) : x.toPrecision(2);
  const span = (deliveries.at(-1) - deliveries[0]) / 1000;
  const fps = !moving ? 'still' : deliveries.length < 2 ? 'moving'
                                                        : `${((deliveries.length - 1) / span).toFixed(1)} pictures/s`;
  const lines = [`${info.width} × ${info.height}, ${info.spp} ray${info.spp > 1 ? 's' : ''}/pixel, ${fps}`,
                 info.integration_error === null ? `error unknown (${info.method})`
                                                 : `error ${pixels(info.integration_error)} pixel (${info.method})`];
  if (info.interpolation_error.max > 0)
    lines.push(`interpolation ${pixels(info.interpolation_error.p99)} pixel for 99 %, ` +
               `${(100 * info.traced_share).toFixed(1)} % traced`);
  element('corner').textContent = lines.join('\n');
  if (info.reuse) lines.push(`used again: ${info.reuse}`);
  element('legend').hidden = info.layer === 'color';
  element('least').textContent = Number(info.scale[0]).toPrecision(3);
  element('greatest').textContent = Number(info.scale[1]).toPrecision(3);
  element('remarks').replaceChildren(...info.remarks.map((text) => {
    const item = document.createElement('li');
    item.textContent = text;
    return item;
  }));
}
function report_error(text) {
  element('error').textContent = text;
  element('error').hidden = !text;
  for (const problem of document.querySelectorAll('.problem'))
    problem.textContent = text.includes(problem.dataset.key) ? text : '';
}
setInterval(pump, 50);
document.addEventListener('visibilitychange', pump);

// ---- the state in the URL ----
let hash_timer = 0;
function save_hash() {
  clearTimeout(hash_timer);
  hash_timer = setTimeout(() => {
    const state = Object.keys(keys).length || layer !== 'color' ? encodeURIComponent(JSON.stringify({keys, layer})) : '';
    history.replaceState(null, '', location.pathname + location.search + (state ? '#' + state : ''));
  }, 300);
}
function read_hash() {
  try {
    const state = JSON.parse(decodeURIComponent(location.hash.slice(1)) || '{}');
    keys = state.keys && typeof state.keys === 'object' ? state.keys : {};
    layer = typeof state.layer === 'string' ? state.layer : 'color';
  } catch {
    report_error('The part of the URL after # is damaged; the page shows the scene without changes.');
  }
}
window.addEventListener('hashchange', () => { read_hash(); refresh(); changed(); });

// ---- controls ----
const refreshers = [];
const refresh = () => refreshers.forEach((each) => each());
function set(key, new_value) {
  keys[key] = new_value;
  refresh();
  changed();
}
function node(name, properties = {}, children = []) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
}
/// A number with a slider. `range` contains least, greatest, and the hint below the slider.
function number_control(key, name, initial, range, hint) {
  const id = 'control-' + key.replaceAll('.', '-');
  const slider = node('input', {type: 'range', min: range[0], max: range[1], step: 'any', ariaLabel: name});
  const box = node('input', {type: 'number', step: 'any', id});
  const problem = node('div', {className: 'problem'});
  problem.dataset.key = key;
  slider.addEventListener('input', () => set(key, range.whole ? Math.round(slider.valueAsNumber) : slider.valueAsNumber));
  box.addEventListener('input', () => { if (Number.isFinite(box.valueAsNumber)) set(key, box.valueAsNumber); });
  refreshers.push(() => {
    const now = keys[key] ?? initial;
    if (document.activeElement !== slider) slider.value = now;
    if (document.activeElement !== box) box.value = Number(now.toPrecision(7));
  });
  return node('div', {className: 'control'}, [node('label', {htmlFor: id, textContent: name}), slider, box,
                                              node('div', {className: 'hint', textContent: hint}), problem]);
}
function range_of(parameter) {
  const size = Math.max(Math.abs(parameter.value), Math.abs(parameter.default), 1e-3);
  let least = parameter.least ?? parameter.value - 4 * size, greatest = parameter.greatest ?? parameter.value + 4 * size;
  if (least < -1e6 * size) least = parameter.value - 4 * size;
  if (greatest > 1e6 * size) greatest = parameter.value + 4 * size;
  const range = [least, greatest];
  range.whole = parameter.is_whole;
  return range;
}
function hint_of(parameter) {
  const bound = (x, none) => x === null ? none : Math.abs(x) >= 1e6 ? x.toExponential() : String(x);
  const legal = `${parameter.least_open ? 'above ' : 'from '}${bound(parameter.least, '−∞')} to ` +
                bound(parameter.greatest, '∞');
  return `${parameter.meaning} (${parameter.unit}, ${legal})`;
}
function text_control(key, name, initial) {
  const id = 'control-' + key.replaceAll('.', '-');
  const box = node('textarea', {id, spellcheck: false});
  const problem = node('div', {className: 'problem', role: 'status'});
  problem.dataset.key = key;
  box.addEventListener('input', () => set(key, box.value));
  refreshers.push(() => { if (document.activeElement !== box) box.value = keys[key] ?? initial; });
  return node('div', {className: 'control'}, [node('label', {htmlFor: id, textContent: name}), box, problem]);
}
function choice_control(name, options, get, choose) {
  const select = node('select', {className: 'wide', id: 'choice-' + name});
  select.append(...options.map((option) => node('option', {value: option.value, textContent: option.text})));
  select.addEventListener('change', () => choose(select.value));
  refreshers.push(() => { select.value = get(); });
  return node('div', {className: 'control'}, [node('label', {htmlFor: select.id, textContent: name}), select]);
}
function vector_control(key, name) {
  const boxes = ['x', 'y', 'z'].map((axis, i) => {
    const box = node('input', {type: 'number', step: 'any', ariaLabel: `${name} ${axis}`});
    box.addEventListener('input', () => {
      if (!Number.isFinite(box.valueAsNumber)) return;
      const vector = [...value(key)];
      vector[i] = box.valueAsNumber;
      set(key, vector);
    });
    refreshers.push(() => { if (document.activeElement !== box) box.value = Number(value(key)[i].toPrecision(7)); });
    return box;
  });
  return node('div', {className: 'control'}, [node('label', {textContent: name}),
                                              node('div', {className: 'row wide'}, boxes)]);
}
function build_controls() {
  element('space').textContent = `${scene.space.name}: ${scene.space.what}. ${scene.space.formula}`;
  element('parameters').parentElement.hidden = scene.parameters.length === 0;
  element('parameters').append(...scene.parameters.map(
    (p) => number_control(p.key, p.name, p.value, range_of(p), hint_of(p))));
  if (scene.formula) {
    element('formula-group').hidden = false;
    element('formula').append(
      ...scene.formula.texts.map((f) => text_control(f.key, f.key.replace(/^space\.(let\.)?/, ''), f.text)),
      ...scene.formula.constants.map((c) => number_control(
        c.key, c.name, c.value, range_of({...c, default: c.value, least: null, greatest: null}), 'constant')));
  }
  const choice = (name) => ({value: name, text: name});
  element('camera').append(vector_control('camera.position', 'position'), vector_control('camera.look_at', 'look at'));
  if (scene.camera.type === 'perspective')
    element('camera').append(
      number_control('camera.fov', 'field of view', scene.camera.fov, [1, 150], 'degrees, vertical, below 180'));
  if (is_orthographic())
    element('camera').append(number_control('camera.height', 'height', scene.camera.height,
                                            [scene.camera.height / 20, 5 * scene.camera.height],
                                            'height of the picture, a length above 0'));
  element('camera').append(
    choice_control('observer', scene.camera.observers.map(choice), () => value('camera.observer'),
                   (name) => set('camera.observer', name)));
  element('display').append(
    choice_control('layer', scene.layers.map((l) => ({value: l.name, text: `${l.name}: ${l.what}`})), () => layer,
                   (name) => { layer = name; refresh(); changed(); }),
    number_control('film.exposure', 'exposure', scene.film.exposure, [-8, 8], 'stops, from −64 to 64'),
    choice_control('tone', scene.film.tones.map(choice), () => value('film.tone'), (name) => set('film.tone', name)));
  refresh();
}

// ---- pointer and keyboard ----
let drag = null;
picture.addEventListener('pointerdown', (event) => {
  drag = {x: event.clientX, y: event.clientY, moved: false};
  picture.setPointerCapture(event.pointerId);
  picture.focus();
});
picture.addEventListener('pointermove', (event) => {
  if (!drag) return hover(event);
  const dx = event.clientX - drag.x, dy = event.clientY - drag.y;
  if (!drag.moved && Math.hypot(dx, dy) < 3) return;
  const angle = angle_of_height() * Math.PI / 180 / picture.clientHeight;
  drag = {x: event.clientX, y: event.clientY, moved: true};
  turn(dx * angle, dy * angle);
});
picture.addEventListener('pointerup', (event) => {
  if (drag && !drag.moved) trace_pixel(...pixel_of(event));
  drag = null;
});
picture.addEventListener('pointercancel', () => { drag = null; });
picture.addEventListener('wheel', (event) => {
  event.preventDefault();
  zoom(Math.exp(0.001 * event.deltaY));
}, {passive: false});

const held = new Set();
let last_frame = 0;
const walk_keys = {w: [1, 0, 0], s: [-1, 0, 0], a: [0, -1, 0], d: [0, 1, 0], q: [0, 0, -1], e: [0, 0, 1],
                   arrowup: [1, 0, 0], arrowdown: [-1, 0, 0], arrowleft: [0, -1, 0], arrowright: [0, 1, 0]};
const turn_keys = {'shift+arrowup': [0, 1], 'shift+arrowdown': [0, -1], 'shift+arrowleft': [1, 0],
                   'shift+arrowright': [-1, 0]};
picture.addEventListener('keydown', (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const name = event.key.toLowerCase(), with_shift = event.shiftKey && name.startsWith('arrow') ? 'shift+' + name : name;
  if (name === '+' || name === '=') zoom(0.95);
  else if (name === '-') zoom(1 / 0.95);
  else if (with_shift in walk_keys || with_shift in turn_keys) {
    if (held.size === 0) {
      last_frame = performance.now();
      requestAnimationFrame(step_keys);
    }
    held.add(with_shift);
  } else return;
  event.preventDefault();
});
window.addEventListener('keyup', (event) => {
  const name = event.key.toLowerCase();
  held.delete(name);
  held.delete('shift+' + name);
});
window.addEventListener('blur', () => held.clear());
function step_keys(now) {
  if (held.size === 0) return;
  const seconds = Math.min(0.1, Math.max(0, now - last_frame) / 1000);
  last_frame = now;
  for (const name of held) {
    const speed = 0.4 * distance() * seconds, angle = 0.6 * angle_of_height() * Math.PI / 180 * seconds;
    if (name in walk_keys) walk(...walk_keys[name].map((x) => x * speed));
    else turn(...turn_keys[name].map((x) => x * angle));
  }
  requestAnimationFrame(step_keys);
}

// ---- the pixel and its ray ----
let ray = null, ray_angle = [0.7, 0.5], hover_timer = 0, pixel_request = 0;
function pixel_of(event) {
  const box = picture.getBoundingClientRect();
  const at = (position, size, count) => Math.max(0, Math.min(count - 1, Math.floor(position / size * count)));
  return [at(event.clientX - box.left, box.width, scene.film.width),
          at(event.clientY - box.top, box.height, scene.film.height)];
}
function hover(event) {
  if (!scene) return;
  clearTimeout(hover_timer);
  const pixel = pixel_of(event);
  hover_timer = setTimeout(() => {
    if (!drag && flights.size === 0 && stage > 0) trace_pixel(...pixel);
  }, 150);
}
async function trace_pixel(x, y, attempts = 3) {
  const number = ++pixel_request;
  try {
    const response = await post('pixel', `&x=${x}&y=${y}`, request('full'));
    if (response.status === 204 && attempts > 1 && number === pixel_request)  // a picture was more urgent
      return setTimeout(() => { if (number === pixel_request) trace_pixel(x, y, attempts - 1); }, 300);
    if (number !== pixel_request || (response.status !== 200 && response.status !== 422)) return;
    const answer = await response.json();
    if (answer.error) report_error(answer.error);
    else show_pixel(answer);
  } catch { /* the requests for pictures report that the server does not answer */ }
}
function show_pixel(answer) {
  element('pixel-x').value = answer.x;
  element('pixel-y').value = answer.y;
  const error = (x) => x === null ? 'unknown' : `${x.toExponential(1)} pixel`;
  const rows = {status: answer.object ? `${answer.status}: ${answer.object}` : answer.status,
                steps: `${answer.steps} (${answer.gradients} gradients)`,
                'position error': error(answer.position_error), 'rounding error': error(answer.rounding_error),
                'error of H': answer.energy_error === null ? 'unknown' : answer.energy_error.toExponential(1),
                end: answer.position.map((v) => Number(v).toPrecision(5)).join(', '),
                direction: answer.direction.map((v) => Number(v).toPrecision(5)).join(', ')};
  element('pixel').replaceChildren(...Object.entries(rows).flatMap(
    ([name, text]) => [node('dt', {textContent: name}), node('dd', {textContent: text})]));
  ray = answer;
  draw_ray();
}
/// Draws the path of the ray in a parallel projection, with the axes of the scene around its camera.
function draw_ray() {
  const canvas = element('ray'), pen = canvas.getContext('2d');
  pen.clearRect(0, 0, canvas.width, canvas.height);
  if (!ray || ray.path.length === 0) return;
  const reach = 3 * distance(), start = ray.path[0];
  const points = [];
  for (const point of ray.path) {
    points.push(point);
    if (points.length > 1 && length(add(point, start, -1)) > reach) break;
  }
  const [a, b] = ray_angle;
  const project = (p) => {
    const d = add(p, start, -1), s = canvas.height / (2.2 * Math.max(1e-12, ...points.map((q) => length(add(q, start, -1)))));
    const across = -Math.sin(a) * d[0] + Math.cos(a) * d[1], depth = Math.cos(a) * d[0] + Math.sin(a) * d[1];
    return [canvas.width / 2 + s * across, canvas.height / 2 - s * (Math.cos(b) * d[2] - Math.sin(b) * depth)];
  };
  const line = (list, color, width) => {
    pen.strokeStyle = color;
    pen.lineWidth = width;
    pen.beginPath();
    list.forEach((p, i) => pen[i ? 'lineTo' : 'moveTo'](...project(p)));
    pen.stroke();
  };
  const size = Math.max(...points.map((q) => length(add(q, start, -1)))) / 2;
  ['#e06c6c', '#7fc97f', '#6ca8e0'].forEach((color, i) => {
    const tip = [...start];
    tip[i] += size;
    line([start, tip], color, 1);
    pen.fillStyle = color;
    pen.fillText('xyz'[i], ...project(tip));
  });
  line(points, '#ffd37a', 2);
  pen.fillStyle = '#fff';
  pen.fillRect(...project(start).map((x) => x - 2), 4, 4);
}
function turn_ray(dx, dy) {
  ray_angle = [ray_angle[0] + dx, Math.max(-1.5, Math.min(1.5, ray_angle[1] + dy))];
  draw_ray();
}
element('ray').addEventListener('pointermove', (event) => {
  if (event.buttons) turn_ray(-0.01 * event.movementX, 0.01 * event.movementY);
});
element('ray').addEventListener('keydown', (event) => {
  const step = {ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1]}[event.key];
  if (!step) return;
  event.preventDefault();
  turn_ray(...step);
});
element('pixel-show').addEventListener('click',
  () => trace_pixel(element('pixel-x').valueAsNumber || 0, element('pixel-y').valueAsNumber || 0));

// ---- saving ----
for (const button of document.querySelectorAll('[data-format]'))
  button.addEventListener('click', async () => {
    const format = button.dataset.format;
    button.disabled = true;
    try {
      const best = stage > 1 ? request('fine', samples[Math.min(stage, samples.length + 1) - 2]) : request('full');
      const response = await post('file', '&format=' + format, best);
      if (response.status !== 200) throw new Error(response.status === 204 ? 'Saving was interrupted; try again.'
                                                                           : (await response.json()).error);
      const link = node('a', {href: URL.createObjectURL(await response.blob()), download: 'kagero.' + format});
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 10000);
    } catch (error) {
      report_error(error.message);
    }
    button.disabled = false;
  });
element('reset').addEventListener('click', () => { keys = {}; layer = 'color'; refresh(); changed(); });
element('panel').addEventListener('submit', (event) => event.preventDefault());

async function start() {
  const response = await fetch(address('scene'));
  if (response.status !== 200) return report_error((await response.json()).error);
  scene = await response.json();
  read_hash();
  build_controls();
  changed();
}
start();
