// The page of a path: a slider and a button move the arm along it; the plots have a cursor.

const data = JSON.parse(document.getElementById("data").textContent);
const robot = data.robot;
const byId = (id) => document.getElementById(id);
const state = { x: data.x[0], q: data.q[0], playing: false };
const first = data.x[0], last = data.x[data.x.length - 1], span = last - first || 1;
const arm = new Arm(robot, byId("arm"), data.view);

const number = (x, digits = 4) => (x === null || x === undefined ? "–" : String(Number(x.toPrecision(digits))).replace("-", "−"));
const stretchAt = (x) => {
  const met = data.stretches.find((one) => !one.free && x >= one.start - 1e-5 * span && x <= one.end + 1e-5 * span);
  return met || data.stretches.find((one) => x >= one.start && x <= one.end) || data.stretches[0];
};

// Index of the last place not after x, and the share of the way to the next.
function find(list, x) {
  let low = 0, high = list.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (list[middle] <= x) low = middle;
    else high = middle;
  }
  const way = list[high] - list[low];
  return [low, high, way > 0 ? Math.max(0, Math.min(1, (x - list[low]) / way)) : 0];
}

function between(list, [low, high, s]) {
  return list[low] === null || list[high] === null ? null : list[low] + s * (list[high] - list[low]);
}

// The way of the tip in short pieces, one colour each, so that they sort well; a ball where a singularity is met.
const trail = [];
for (let i = 0; i + 1 < data.tip.length; i += 1) {
  const colour = stretchAt((data.x[i] + data.x[i + 1]) / 2).ink, before = trail[trail.length - 1];
  if (before && before.colour === colour && before.points.length < 6) before.points.push(data.tip[i + 1]);
  else trail.push({ points: [data.tip[i], data.tip[i + 1]], colour, width: 2.6 });
}
const dots = data.stretches.filter((one) => !one.free).slice(0, 60).map((one) => ({ at: data.tip[find(data.x, one.closest)[0]], colour: one.ink }));

function setX(x, from = "") {
  state.x = Math.max(first, Math.min(last, x));
  const place = find(data.x, state.x), [low, high, s] = place;
  state.q = data.q[low].map((v, i) => v + s * (data.q[high][i] - v));
  const seen = decompose(robot, state.q), r = data.generic_rank, lost = seen.sigma.slice(0, r).filter((v) => v <= data.live_tolerance).length;
  const axes = taskFrame(robot, displacements(robot, state.q)).axes;
  const arrows = Array.from({ length: r ? Math.max(lost, 1) : 0 }, (_, k) => {
    const d = direction(robot, seen.u[r - Math.max(lost, 1) + k]);
    return { v: rotate(axes, d.slice(0, 3)), w: rotate(axes, d.slice(3)), faint: !lost };
  });
  arm.show({ q: state.q, arrows, blamed: [], trail, dots });
  if (from !== "slider") byId("at").value = (state.x - first) / span;
  tell(place, seen.sigma);
  plots.forEach((one) => one.draw());
}

function tell(place, sigma) {
  const one = stretchAt(state.x), verdict = byId("verdict"), r = data.generic_rank, inside = find(data.at, state.x);
  verdict.className = one.free ? "good" : "bad";
  verdict.textContent = one.free ? "free: proven" : `${one.verdict}: ${one.name || "no family known"}`;
  const near = data.family[inside[2] < 0.5 ? inside[0] : inside[1]], named = data.stretches.find((other) => other.family === near);
  const rows = [];
  if (data.timed) rows.push(["time", `${number(state.x, 5)} s`]);
  rows.push(["row", number(between(data.row, place), 6)]);
  if (data.pose) rows.push(["pose", number(between(data.pose, place), 5)]);
  for (const series of data.series) {
    const value = between(series.values, inside);
    if (series.name !== "σ") rows.push([series.name, `${number(value !== null && value < 1e-6 ? 0 : value, 3)} ${series.unit}`]);
  }
  if (r) rows.push([`σ${r}`, number(sigma[r - 1] <= data.live_tolerance ? 0 : sigma[r - 1], 3)]);
  if (near) rows.push(["nearest", named ? `${near} ${named.name}` : near]);
  robot.joints.forEach((joint, i) => rows.push([joint.name, joint.kind === "prismatic" ? `${state.q[i].toFixed(4)} m` : `${(state.q[i] * 180 / Math.PI).toFixed(2).replace(/^-(?=[0.]+$)/, "")}°`]));
  const list = byId("numbers");
  list.replaceChildren(...rows.flatMap(([name, value]) => ["dt", "dd"].map((tag, k) => {
    const cell = document.createElement(tag);
    cell.textContent = (k ? value : name).replace("-", "−");
    return cell;
  })));
  byId("place").textContent = data.timed ? `${state.x.toFixed(3)} of ${number(last, 5)} s` : `row ${number(state.x, 6)} of ${number(last, 6)}`;
}

// One number along the path: bands of the stretches, marks where a singularity is met, and the cursor.
class Plot {
  constructor(series, last) {
    this.series = series;
    this.last = last;
    this.canvas = document.createElement("canvas");
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", `${series.name} along the path`);
    byId("plots").append(this.canvas);
    const numbers = series.values.filter((v) => v !== null);
    this.top = 1.08 * Math.max(...numbers, series.name === "distance" ? data.min_distance : series.unit === "" && series.name !== "σ" ? 1 : 0, 1e-9);
    let held = false;
    const go = (e) => { stop(); setX(first + ((e.offsetX - this.left) / this.wide) * span); };
    this.canvas.addEventListener("pointerdown", (e) => { held = true; this.canvas.setPointerCapture(e.pointerId); go(e); });
    this.canvas.addEventListener("pointermove", (e) => { if (held) go(e); });
    for (const end of ["pointerup", "pointercancel"]) this.canvas.addEventListener(end, () => { held = false; });
  }

  draw() {
    const box = this.canvas.getBoundingClientRect(), dots = Math.max(1, window.devicePixelRatio || 1), pen = this.canvas.getContext("2d");
    this.canvas.width = Math.round(box.width * dots);
    this.canvas.height = Math.round(box.height * dots);
    pen.setTransform(dots, 0, 0, dots, 0, 0);
    this.left = 52;
    this.wide = box.width - this.left - 14;
    const foot = box.height - (this.last ? 22 : 10), high = foot - 22, px = (x) => this.left + ((x - first) / span) * this.wide, py = (v) => foot - (v / this.top) * high;
    for (const one of data.stretches) {
      pen.globalAlpha = 0.16;
      pen.fillStyle = ink(one.ink);
      pen.fillRect(px(one.start), foot - high, Math.max(px(one.end) - px(one.start), one.free ? 0 : 2), high);
    }
    pen.globalAlpha = 1;
    pen.font = "11px system-ui, sans-serif";
    pen.fillStyle = ink("--soft");
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const v of [0, this.top / 1.08]) {
      pen.fillText(number(v, 2), this.left - 6, py(v));
      this.rule(pen, [this.left, py(v)], [this.left + this.wide, py(v)], "--grid", []);
    }
    const bound = this.series.name === "distance" ? data.min_distance : this.series.name === "rate / limit" ? 1 : 0;
    if (bound > 0) this.rule(pen, [this.left, py(bound)], [this.left + this.wide, py(bound)], "--soft", [3, 3]);
    pen.textAlign = "left";
    pen.font = "600 12px system-ui, sans-serif";
    pen.fillStyle = ink("--ink");
    pen.fillText(this.series.name + (this.series.unit ? ` [${this.series.unit}]` : ""), this.left, 11);
    this.curve(pen, px, py);
    for (const one of data.stretches) if (!one.free) this.mark(pen, px(one.closest), foot, one);
    if (this.last) this.ticks(pen, px, foot);
    this.rule(pen, [px(state.x), foot - high - 2], [px(state.x), foot], "--ink", []);
    const value = between(this.series.values, find(data.at, state.x));
    if (value === null) return;
    pen.fillStyle = ink("--ink");
    pen.beginPath();
    pen.arc(px(state.x), py(value), 3.5, 0, 2 * Math.PI);
    pen.fill();
  }

  rule(pen, [x0, y0], [x1, y1], colour, dash) {
    pen.strokeStyle = ink(colour);
    pen.lineWidth = 1;
    pen.setLineDash(dash);
    pen.beginPath();
    pen.moveTo(x0, y0);
    pen.lineTo(x1, y1);
    pen.stroke();
    pen.setLineDash([]);
  }

  curve(pen, px, py) {
    pen.strokeStyle = ink("--ink");
    pen.lineWidth = 1.4;
    pen.lineJoin = "round";
    pen.beginPath();
    let down = false;
    this.series.values.forEach((v, i) => {
      if (v === null) { down = false; return; }
      if (down) pen.lineTo(px(data.at[i]), py(v));
      else pen.moveTo(px(data.at[i]), py(v));
      down = true;
    });
    pen.stroke();
  }

  // A cross where it crosses, a triangle where it touches, a square where it is undecided.
  mark(pen, x, foot, one) {
    pen.strokeStyle = pen.fillStyle = ink(one.ink);
    pen.lineWidth = 2.2;
    pen.beginPath();
    if (one.verdict === "crossing") {
      for (const [a, b] of [[-4, -4], [-4, 4]]) { pen.moveTo(x + a, foot + b); pen.lineTo(x - a, foot - b); }
      pen.stroke();
    } else if (one.verdict === "touching") {
      pen.moveTo(x, foot + 4); pen.lineTo(x - 5, foot - 5); pen.lineTo(x + 5, foot - 5); pen.fill();
    } else pen.fillRect(x - 4, foot - 4, 8, 8);
  }

  ticks(pen, px, foot) {
    pen.font = "11px system-ui, sans-serif";
    pen.fillStyle = ink("--soft");
    pen.textAlign = "center";
    const raw = span / Math.max(2, Math.floor(this.wide / 90)), power = 10 ** Math.floor(Math.log10(raw));
    const step = power * [1, 2, 5, 10].find((m) => m * power >= raw);
    for (let v = Math.ceil(first / step) * step; v <= last + 1e-9 * span; v += step) pen.fillText(number(v, 6), px(v), foot + 12);
    pen.textAlign = "right";
    pen.fillText(data.timed ? "over time [s]" : "over rows", this.left + this.wide, 11);
  }
}

// A path plays at its own speed where it lasts from two seconds to a minute, else in ten seconds.
const lasts = data.timed && span >= 2 && span <= 60 ? span : 10;
let begun = null;

function stop() {
  state.playing = false;
  byId("play").textContent = "▶ play";
  byId("play").setAttribute("aria-label", "play");
}

function step(now) {
  if (!state.playing) return;
  const x = first + ((now - begun) / 1000 / lasts) * span;
  setX(x);
  if (x >= last) stop();
  else requestAnimationFrame(step);
}

function play() {
  if (state.playing) { stop(); return; }
  state.playing = true;
  byId("play").textContent = "❚❚ pause";
  byId("play").setAttribute("aria-label", "pause");
  const done = state.x >= last - 1e-9 * span ? 0 : (state.x - first) / span;
  begun = performance.now() - 1000 * lasts * done;
  requestAnimationFrame(step);
}

byId("play").addEventListener("click", play);
byId("at").addEventListener("input", (e) => { stop(); setX(first + Number(e.target.value) * span, "slider"); });
for (const button of document.querySelectorAll("[data-stretch]")) {
  button.addEventListener("click", () => { stop(); setX(data.stretches[Number(button.dataset.stretch)].closest); });
}

const plots = data.series.map((series, i) => new Plot(series, i === data.series.length - 1));
const some = data.q.filter((_, i) => i % Math.ceil(data.q.length / 40) === 0);
arm.fit([...some, data.q[data.q.length - 1]]);
const worst = data.stretches.find((one) => !one.free) || data.stretches[0];
setX(worst.closest);
const redraw = () => setX(state.x);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
const printing = (widest) => () => { Scene.widest = widest; redraw(); };
addEventListener("beforeprint", printing(1.25));
addEventListener("afterprint", printing(Infinity));
new ResizeObserver(redraw).observe(document.body);

window.rankdropPath = { data, state, setX, play, find, stretchAt, drawn: () => arm.state.q };
