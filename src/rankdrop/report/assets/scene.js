// A small 3-D scene on a 2-D canvas: polygons, balls and lines, far ones first. Turned by dragging or the arrow keys.

const ink = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

function mixed(hex, other, share) {
  const parse = (h) => [1, 3, 5].map((i) => parseInt(h.slice(i, i + 2), 16));
  const a = parse(hex), b = parse(other);
  return `rgb(${a.map((x, i) => Math.round(x + (b[i] - x) * share)).join(",")})`;
}

class Scene {
  static widest = Infinity; // of width to height: wide pictures are small in the columns of a printed page

  constructor(canvas, view = {}) {
    this.canvas = canvas;
    this.view = { turn: -0.9, tilt: 0.42, zoom: 1, ...view };
    this.start = { ...this.view };
    this.centre = [0, 0, 0];
    this.radius = 1;
    this.aside = [0, 0];
    this.held = []; // points that the picture holds, filling it; without any it shows a ball of this radius
    this.margin = 0; // of solid bodies about those points
    this.items = [];
    this.over = [];
    this.draw = () => {};
    if (canvas.dataset.still === undefined) this.listen();
  }

  listen() {
    const canvas = this.canvas;
    let from = null;
    canvas.addEventListener("pointerdown", (e) => { from = [e.clientX, e.clientY]; canvas.setPointerCapture(e.pointerId); });
    canvas.addEventListener("pointermove", (e) => {
      if (!from) return;
      this.view.turn -= (e.clientX - from[0]) * 0.009;
      this.view.tilt = Math.max(-1.55, Math.min(1.55, this.view.tilt + (e.clientY - from[1]) * 0.009));
      from = [e.clientX, e.clientY];
      this.draw();
    });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => { from = null; });
    canvas.addEventListener("dblclick", () => { Object.assign(this.view, this.start); this.draw(); });
    canvas.addEventListener("wheel", (e) => {
      if (!e.ctrlKey && document.activeElement !== canvas) return;
      e.preventDefault();
      this.view.zoom = Math.max(0.3, Math.min(6, this.view.zoom * Math.exp(-e.deltaY * 0.0015)));
      this.draw();
    }, { passive: false });
    canvas.addEventListener("keydown", (e) => {
      const step = { ArrowLeft: ["turn", 0.1], ArrowRight: ["turn", -0.1], ArrowUp: ["tilt", 0.1], ArrowDown: ["tilt", -0.1] }[e.key];
      if (step) { this.view[step[0]] += step[1]; e.preventDefault(); }
      if (e.key === "+" || e.key === "-") this.view.zoom *= e.key === "+" ? 1.1 : 1 / 1.1;
      this.draw();
    });
  }

  begin() {
    const box = this.canvas.getBoundingClientRect(), dots = Math.max(2, window.devicePixelRatio || 1);
    this.height = box.height || this.canvas.height;
    this.width = Math.min(box.width || this.canvas.width, Scene.widest * this.height);
    this.canvas.width = Math.round(this.width * dots);
    this.canvas.height = Math.round(this.height * dots);
    this.pen = this.canvas.getContext("2d");
    this.pen.setTransform(dots, 0, 0, dots, 0, 0);
    this.pen.clearRect(0, 0, this.width, this.height);
    const { turn, tilt } = this.view;
    this.right = [-Math.sin(turn), Math.cos(turn), 0];
    this.toward = [Math.cos(turn) * Math.cos(tilt), Math.sin(turn) * Math.cos(tilt), Math.sin(tilt)];
    this.up = cross(this.toward, this.right);
    this.light = unit(plus(plus(this.toward, this.up, 0.9), this.right, -0.55));
    this.scale = (0.5 * Math.min(this.width, this.height) / this.radius) * this.view.zoom * 0.94;
    if (this.held.length) this.fill();
    this.items = [];
    this.over = [];
  }

  // Centre, scale and shift with which what is held fills the picture.
  fill() {
    const bounds = (points) => points[0].map((_, k) => [Math.min(...points.map((p) => p[k])), Math.max(...points.map((p) => p[k]))]);
    this.centre = bounds(this.held).map(([low, high]) => (low + high) / 2);
    this.radius = Math.max(...this.held.map((p) => length(plus(p, this.centre, -1))), 2 * this.margin) + this.margin;
    const flat = bounds(this.held.map((p) => {
      const d = plus(p, this.centre, -1), near = 1 / (1 - 0.13 * dot(d, this.toward) / this.radius);
      return [dot(d, this.right) * near, dot(d, this.up) * near];
    }));
    const edge = this.width > 260 ? 22 : 6, room = [this.width - 2 * edge, this.height - 2 * edge];
    const size = flat.map(([low, high]) => Math.max(high - low, 4 * this.margin) + 2 * this.margin);
    this.scale = Math.min(room[0] / size[0], room[1] / size[1]) * this.view.zoom;
    this.aside = flat.map(([low, high]) => (low + high) / 2);
  }

  // Pixel of a point and its depth (larger is nearer); mild perspective.
  project(p) {
    const d = plus(p, this.centre, -1), depth = dot(d, this.toward) / this.radius, near = 1 / (1 - 0.13 * depth);
    const x = dot(d, this.right) * near - this.aside[0], y = dot(d, this.up) * near - this.aside[1];
    return [this.width / 2 + x * this.scale, this.height / 2 - y * this.scale, depth, near];
  }

  shade(colour, normal, lift = 0.42) {
    const bright = Math.max(0, dot(normal, this.light));
    return mixed(colour, bright > 0.72 ? "#ffffff" : "#000000", bright > 0.72 ? (bright - 0.72) * 0.9 : (1 - lift) * (0.72 - bright) * 0.85);
  }

  polygon(points, fill, alpha = 1, edge = true) {
    const flat = points.map((p) => this.project(p));
    this.items.push({ depth: flat.reduce((s, p) => s + p[2], 0) / flat.length, flat, fill, alpha, edge });
  }

  ball(p, radius, colour) {
    const [x, y, depth, near] = this.project(p);
    this.items.push({ depth: depth + 0.2 * radius / this.radius, ball: [x, y, radius * this.scale * near], fill: colour });
  }

  line(points, colour, width, { dash = [], alpha = 1, over = false, lift = 0 } = {}) {
    const flat = points.map((p) => this.project(p));
    const item = { depth: lift + flat.reduce((s, p) => s + p[2], 0) / flat.length, line: flat, stroke: colour, width, dash, alpha };
    (over ? this.over : this.items).push(item);
  }

  text(p, words, colour, { shift = [0, 0], size = 12, bold = false, align = "center" } = {}) {
    const [x, y] = this.project(p);
    this.over.push({ words, at: [x + shift[0], y + shift[1]], fill: colour, size, bold, align });
  }

  // A cylinder (or prism) from a to b, cut into short pieces so that it sorts well.
  tube(a, b, radius, colour, { sides = 16, pieces = 0, end = radius, caps = true } = {}) {
    const along = plus(b, a, -1), size = length(along);
    if (size < 1e-12) return;
    const z = unit(along), x = unit(cross(Math.abs(z[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0], z)), y = cross(z, x);
    const count = pieces || Math.max(1, Math.ceil(size / (this.radius * 0.1)));
    const ring = (s, k) => {
      const angle = (2 * Math.PI * k) / sides, r = radius + (end - radius) * s;
      return plus(plus(plus(a, along, s), x, r * Math.cos(angle)), y, r * Math.sin(angle));
    };
    for (let k = 0; k < sides; k++) {
      const middle = (2 * Math.PI * (k + 0.5)) / sides;
      const normal = plus([0, 0, 0].map((_, i) => x[i] * Math.cos(middle)), y, Math.sin(middle));
      if (dot(normal, this.toward) < -0.25) continue;
      const fill = this.shade(colour, normal);
      for (let i = 0; i < count; i++) {
        const s = i / count, t = (i + 1) / count;
        this.polygon([ring(s, k), ring(s, k + 1), ring(t, k + 1), ring(t, k)], fill);
      }
    }
    if (!caps) return;
    for (const [s, sign] of [[0, -1], [1, 1]]) {
      const normal = [sign * z[0], sign * z[1], sign * z[2]];
      if (dot(normal, this.toward) > -0.15) this.polygon(Array.from({ length: sides }, (_, k) => ring(s, k)), this.shade(colour, normal));
    }
  }

  arrow(a, b, colour, { width = 3, dash = [], alpha = 1 } = {}) {
    const p = this.project(a), r = this.project(b);
    this.over.push({ arrow: [p, r], stroke: colour, width, dash, alpha });
  }

  finish() {
    this.items.sort((a, b) => a.depth - b.depth);
    this.place(this.over.filter((item) => item.words));
    for (const item of [...this.items, ...this.over]) this.paint(item);
  }

  // Words go where no other words stand, as near to their places as may be, inside the picture; bold ones first.
  place(words) {
    const taken = this.boxes = [];
    for (const one of words.sort((a, b) => (b.bold ? 1 : 0) - (a.bold ? 1 : 0))) {
      this.pen.font = this.font(one);
      const half = [this.pen.measureText(one.words).width / 2 + 2, one.size / 2 + 1], [x, y] = one.at;
      const inside = (v, k) => Math.max(half[k], Math.min([this.width, this.height][k] - half[k], v));
      const tries = [[0, 0]];
      for (const far of [1, 1.7, 2.5, 3.5]) for (let k = 0; k < 8; k++) tries.push([far * Math.cos(k * Math.PI / 4), far * Math.sin(k * Math.PI / 4)]);
      const boxes = tries.map(([dx, dy]) => [inside(x + dx * 2 * half[0], 0), inside(y + dy * 2 * half[1], 1)]);
      const free = ([a, b]) => taken.every(([c, d, w, h]) => Math.abs(a - c) >= half[0] + w || Math.abs(b - d) >= half[1] + h);
      one.at = boxes.find(free) || boxes[0];
      taken.push([...one.at, ...half]);
    }
  }

  font(item) {
    return `${item.bold ? "600 " : ""}${item.size}px system-ui, sans-serif`;
  }

  paint(item) {
    const pen = this.pen;
    pen.globalAlpha = item.alpha ?? 1;
    pen.lineJoin = pen.lineCap = "round";
    if (item.flat) {
      pen.beginPath();
      item.flat.forEach((p, i) => (i ? pen.lineTo(p[0], p[1]) : pen.moveTo(p[0], p[1])));
      pen.closePath();
      pen.fillStyle = pen.strokeStyle = item.fill;
      pen.fill();
      if (item.edge) { pen.lineWidth = 0.7; pen.stroke(); }
    } else if (item.ball) {
      const [x, y, r] = item.ball, glow = pen.createRadialGradient(x - 0.3 * r, y - 0.4 * r, 0.1 * r, x, y, r);
      glow.addColorStop(0, mixed(item.fill, "#ffffff", 0.3));
      glow.addColorStop(0.6, item.fill);
      glow.addColorStop(1, mixed(item.fill, "#000000", 0.3));
      pen.beginPath();
      pen.arc(x, y, r, 0, 2 * Math.PI);
      pen.fillStyle = glow;
      pen.fill();
    } else if (item.line || item.arrow) {
      this.stroke(item);
    } else if (item.words) {
      pen.font = this.font(item);
      pen.textAlign = item.align;
      pen.textBaseline = "middle";
      pen.lineWidth = 3;
      pen.strokeStyle = ink("--paper");
      pen.strokeText(item.words, ...item.at);
      pen.fillStyle = item.fill;
      pen.fillText(item.words, ...item.at);
    }
    pen.globalAlpha = 1;
  }

  stroke(item) {
    const pen = this.pen, points = item.line || item.arrow;
    pen.strokeStyle = item.stroke;
    pen.lineWidth = item.width;
    pen.setLineDash(item.dash);
    pen.beginPath();
    points.forEach((p, i) => (i ? pen.lineTo(p[0], p[1]) : pen.moveTo(p[0], p[1])));
    pen.stroke();
    pen.setLineDash([]);
    if (!item.arrow) return;
    const [p, r] = item.arrow, far = Math.hypot(r[0] - p[0], r[1] - p[1]);
    if (far < 4) { // seen end on
      pen.beginPath();
      pen.arc(r[0], r[1], item.width * 1.6, 0, 2 * Math.PI);
      pen.stroke();
      return;
    }
    const [dx, dy] = [(r[0] - p[0]) / far, (r[1] - p[1]) / far], head = Math.min(4.2 * item.width, far);
    pen.beginPath();
    pen.moveTo(r[0] + dx * head * 0.6, r[1] + dy * head * 0.6);
    pen.lineTo(r[0] - dx * head * 0.5 - dy * head * 0.5, r[1] - dy * head * 0.5 + dx * head * 0.5);
    pen.lineTo(r[0] - dx * head * 0.5 + dy * head * 0.5, r[1] - dy * head * 0.5 - dx * head * 0.5);
    pen.closePath();
    pen.fillStyle = item.stroke;
    pen.fill();
  }
}
