// The arm as capsules, its axes, and an arrow for each lost direction: solid for translation, dotted for rotation.

const ARROW = 0.34; // length of an arrow, per reach
const SHARE = 0.25; // of the size of the arm as it stands that an arrow is long at most: it does not make the arm small
const BODY = 0.043; // radius of a joint, per reach
const ARROW_COLOURS = ["--lost1", "--lost2", "--lost3", "--lost4"];

// One lost freedom (v; ω) as one arrow and the axis of its ring, as `rankdrop.local.arrow_of` makes it.
function arrowOf({ v, w }) {
  const whole = Math.hypot(length(v), length(w)), slide = length(v) / whole, turn = length(w) / whole;
  if (turn < 0.02) return { along: unit(v), ring: [0, 0, 0], turns: false };
  if (slide < 0.02) return { along: unit(w), ring: [0, 0, 0], turns: true };
  return { along: unit(v).map((x) => x * (0.35 + 0.65 * slide)), ring: unit(w).map((x) => x * (0.07 + 0.25 * turn)), turns: false };
}

// The corners of the box about points.
function bounding(points) {
  const ends = [0, 1, 2].map((k) => [Math.min(...points.map((p) => p[k])), Math.max(...points.map((p) => p[k]))]);
  return ends[0].flatMap((x) => ends[1].flatMap((y) => ends[2].map((z) => [x, y, z])));
}

// The diagonal of that box.
const spread = (points) => length([0, 1, 2].map((k) => Math.max(...points.map((p) => p[k])) - Math.min(...points.map((p) => p[k]))));

class Arm {
  constructor(robot, canvas, view) {
    this.robot = robot;
    this.scene = new Scene(canvas, view);
    this.scene.draw = () => this.draw();
    this.standing = [[0, 0, 0]];
    this.state = { q: robot.joints.map(() => 0), blamed: [], arrows: [], trail: [], dots: [] };
  }

  // arrows: [{v, w, colour, faint}] in the base frame, at `point`; trail: [{points, colour, width}], dots: [{at, colour}]
  show(state) {
    Object.assign(this.state, state);
    this.draw();
  }

  points(configurations) {
    const points = [[0, 0, 0]];
    for (const q of configurations) {
      const moved = displacements(this.robot, q);
      this.robot.chain.forEach((joint, i) => points.push(place(moved[i + 1], joint.point)));
      const tip = tipPose(this.robot, moved);
      points.push([tip[3], tip[7], tip[11]]);
    }
    return points;
  }

  // The view that these configurations fill.
  fit(configurations) {
    this.standing = this.points(configurations);
  }

  // The view grows where the arm would leave it.
  widen(q) {
    this.standing.push(...this.points([q]));
    if (this.standing.length > 4000) this.standing = bounding(this.standing);
  }

  // What a reader may measure: size of the picture, shares of it that the arm spans, boxes of the words.
  drawn() {
    const { scene } = this, flat = this.points([this.state.q]).map((p) => scene.project(p)), body = 2 * BODY * this.robot.reach * scene.scale;
    const spans = [0, 1].map((k) => Math.max(...flat.map((p) => p[k])) - Math.min(...flat.map((p) => p[k])) + body);
    return { width: scene.width, height: scene.height, shares: [spans[0] / scene.width, spans[1] / scene.height], words: scene.boxes };
  }

  draw() {
    const scene = this.scene, robot = this.robot, unitSize = robot.reach, moved = displacements(robot, this.state.q);
    const point = taskFrame(robot, moved).point, small = scene.width <= 260;
    this.arrow = Math.min(ARROW * unitSize, SHARE * spread(this.points([this.state.q])));
    const ends = this.state.arrows.filter((one) => !one.faint).map((one) => plus(point, arrowOf(one).along, this.arrow));
    scene.held = [...this.standing, ...ends];
    scene.margin = (small ? 0.045 : 0.05) * unitSize;
    scene.begin();
    this.ground(unitSize);
    const link = ink("--link"), joint = ink("--joint"), slide = ink("--slide"), blame = ink("--blame");
    const tip = tipPose(robot, moved), tipPoint = [tip[3], tip[7], tip[11]];
    const meshes = robot.meshes && robot.meshes.length && !robot.bare;
    if (meshes) robot.meshes.forEach((one) => this.mesh(one, linkPose(robot, moved, one.link)));
    else robot.chain.forEach((one, i) => {
      const from = i === 0 ? [0, 0, 0] : place(moved[i], robot.chain[i - 1].point);
      const held = place(moved[i], one.point), carried = place(moved[i + 1], one.point);
      scene.tube(from, held, 0.026 * unitSize, link, { caps: false });
      scene.ball(held, 0.0262 * unitSize, link);
      const colour = this.state.blamed.includes(one.variable + 1) ? blame : joint;
      if (one.kind === "prismatic") {
        scene.tube(held, carried, 0.017 * unitSize, slide, { sides: 8 });
        this.slider(held, rotate(moved[i], one.screw.slice(0, 3)), colour, unitSize);
      } else {
        const axis = rotate(moved[i], one.screw.slice(3)), middle = place(moved[i], one.drawn);
        scene.tube(plus(middle, axis, -0.052 * unitSize), plus(middle, axis, 0.052 * unitSize), BODY * unitSize, colour, { sides: 24, pieces: 3 });
      }
    });
    const last = place(moved[moved.length - 1], robot.chain[robot.chain.length - 1].point);
    if (!meshes) scene.tube(last, tipPoint, 0.02 * unitSize, link, { end: 0.012 * unitSize });
    this.axes(moved, unitSize);
    this.triad(tip, tipPoint, 0.085 * unitSize);
    for (const one of this.state.trail) scene.line(one.points, ink(one.colour), one.width);
    for (const one of this.state.dots) scene.ball(one.at, 0.016 * unitSize, ink(one.colour));
    this.arrows(point);
    scene.finish();
  }

  // The shape of a link, both sides of its triangles: makers do not agree on which is the outer one.
  mesh(one, pose) {
    const corners = [];
    for (let i = 0; i < one.points.length; i += 3) {
      corners.push(place(pose, [0, 1, 2].map((k) => one.low[k] + one.step * one.points[i + k])));
    }
    for (let i = 0; i < one.faces.length; i += 3) {
      const [a, b, c] = [corners[one.faces[i]], corners[one.faces[i + 1]], corners[one.faces[i + 2]]];
      const normal = unit(cross(plus(b, a, -1), plus(c, a, -1)));
      const facing = dot(normal, this.scene.toward) < 0 ? normal.map((x) => -x) : normal;
      this.scene.polygon([a, b, c], this.scene.shade(one.colour, facing));
    }
  }

  ground(size) {
    const colour = ink("--grid"), step = 0.2 * size, half = 3;
    for (let i = -half; i <= half; i++) {
      for (const [a, b] of [[[i * step, -half * step, 0], [i * step, half * step, 0]], [[-half * step, i * step, 0], [half * step, i * step, 0]]]) {
        this.scene.line([a, b], colour, 0.8, { lift: -9 });
      }
    }
    this.scene.tube([0, 0, 0], [0, 0, 0.02 * size], 0.07 * size, ink("--base"), { sides: 28, pieces: 1 });
    if (this.scene.width > 260) this.scene.text([0, 0, -0.05 * size], "base", ink("--soft"), { size: 11 });
  }

  slider(at, axis, colour, size) {
    this.scene.tube(plus(at, axis, -0.06 * size), plus(at, axis, 0.06 * size), 0.036 * size, colour, { sides: 4, pieces: 3 });
  }

  // Axes to blame long and marked, the others short.
  axes(moved, size) {
    this.robot.chain.forEach((one, i) => {
      const slides = one.kind === "prismatic", blamed = this.state.blamed.includes(one.variable + 1);
      const axis = rotate(moved[i], slides ? one.screw.slice(0, 3) : one.screw.slice(3)), middle = place(moved[i], one.drawn);
      const reach = (blamed ? 0.3 : 0.1) * size, ends = [plus(middle, axis, -reach), plus(middle, axis, reach)];
      this.scene.line(ends, ink(blamed ? "--blame" : "--faint"), blamed ? 2.2 : 1, { dash: [9, 3, 2, 3], over: true });
      if (this.scene.width > 260) {
        const words = String(one.variable + 1), far = blamed ? 0.325 : 0.13;
        this.scene.text(plus(middle, axis, far * size), words, ink(blamed ? "--blame" : "--soft"), { size: blamed ? 14 : 11, bold: blamed });
      }
    });
  }

  triad(tip, point, size) {
    [0, 1, 2].forEach((k) => {
      const axis = [tip[k], tip[4 + k], tip[8 + k]];
      this.scene.line([point, plus(point, axis, size)], ink("--soft"), 1.6, { over: true });
      if (this.scene.width > 260) this.scene.text(plus(point, axis, size * 1.25), "xyz"[k], ink("--soft"), { size: 11 });
    });
  }

  // As `rankdrop.local.ring_about`: a ring about an axis, with a head at its end.
  ring(at, axis, size) {
    const z = unit(axis), x = unit(cross(z, Math.abs(z[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0])), y = cross(z, x), radius = length(axis);
    const points = Array.from({ length: 41 }, (_, i) => {
      const turn = (i * 7.5 * Math.PI) / 180;
      return plus(x.map((c) => c * radius * Math.cos(turn)), y, radius * Math.sin(turn));
    });
    const end = points[40], back = plus(end, cross(z, end), -0.36);
    return [...points, plus(back, end, 0.2), end, plus(back, end, -0.2)].map((p) => plus(at, p, size));
  }

  arrows(point) {
    const small = this.scene.width <= 260;
    this.state.arrows.forEach((one, i) => {
      const colour = ink(ARROW_COLOURS[i % 4]), width = small ? 2 : 3.4, alpha = one.faint ? 0.35 : 1;
      const { along, ring, turns } = arrowOf(one), dash = turns ? [0.1, small ? 4 : 6.5] : [];
      if (length(ring)) this.scene.line(this.ring(point, ring, this.arrow), colour, 0.6 * width, { alpha, over: true });
      this.scene.arrow(point, plus(point, along, this.arrow), colour, { width, dash, alpha });
    });
  }
}
