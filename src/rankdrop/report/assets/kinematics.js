// Forward kinematics of the page, the same as rankdrop.pose: T(q) = exp(S1 q1) … exp(SN qN) · home.
// Poses are arrays of 12 numbers: rows of [R | p]. Screws are (v; ω), linear part first.

const IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0];

function multiply(a, b) {
  const c = new Array(12);
  for (let i = 0; i < 3; i++) {
    for (let j = 0; j < 4; j++) {
      c[4 * i + j] = a[4 * i] * b[j] + a[4 * i + 1] * b[4 + j] + a[4 * i + 2] * b[8 + j] + (j === 3 ? a[4 * i + 3] : 0);
    }
  }
  return c;
}

const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const plus = (a, b, s = 1) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
const length = (a) => Math.hypot(a[0], a[1], a[2]);
const unit = (a) => { const l = length(a) || 1; return [a[0] / l, a[1] / l, a[2] / l]; };
const rotate = (t, v) => [0, 1, 2].map((i) => t[4 * i] * v[0] + t[4 * i + 1] * v[1] + t[4 * i + 2] * v[2]);
const place = (t, p) => plus(rotate(t, p), [t[3], t[7], t[11]]);

// exp(S t): for ω = 0 a translation, else R = I + sin t [ω] + (1 − cos t) [ω]², |ω| = 1.
function exponential(screw, t) {
  const v = screw.slice(0, 3), w = screw.slice(3);
  if (dot(w, w) === 0) return [1, 0, 0, v[0] * t, 0, 1, 0, v[1] * t, 0, 0, 1, v[2] * t];
  const s = Math.sin(t), c = 1 - Math.cos(t), along = dot(w, v), wv = cross(w, v);
  const out = new Array(12);
  for (let i = 0; i < 3; i++) {
    const e = [0, 0, 0];
    e[i] = 1;
    const we = cross(w, e);
    for (let k = 0; k < 3; k++) out[4 * k + i] = e[k] + s * we[k] + c * (w[k] * w[i] - e[k]);
    // p = (I t + (1 − cos t)[ω] + (t − sin t)[ω]²) v
    out[4 * i + 3] = v[i] * t + c * wv[i] + (t - s) * (w[i] * along - v[i]);
  }
  return out;
}

// Displacements of the links: 0 is the base, i the link after joint i.
function displacements(robot, q) {
  const all = [IDENTITY];
  for (const joint of robot.chain) {
    const value = joint.multiplier * q[joint.variable] + joint.offset;
    all.push(multiply(all[all.length - 1], exponential(joint.screw, value)));
  }
  return all;
}

const tipPose = (robot, moved) => multiply(moved[moved.length - 1], robot.home);

function linkPose(robot, moved, index) {
  if (index === 0) return IDENTITY;
  return index > robot.chain.length ? tipPose(robot, moved) : multiply(moved[index], robot.chain[index - 1].frame);
}

// Axes and reference point of the task's frame, in the base frame.
function taskFrame(robot, moved) {
  return { axes: linkPose(robot, moved, robot.frame.axes), point: place(linkPose(robot, moved, robot.frame.origin), robot.frame.point) };
}

// Rows of the task Jacobian, translations divided by the length scale: a list of columns, one per variable.
function taskJacobian(robot, q) {
  const moved = displacements(robot, q), frame = taskFrame(robot, moved);
  const columns = robot.joints.map(() => new Array(robot.rows.length).fill(0));
  robot.chain.forEach((joint, i) => {
    const t = moved[i], w = rotate(t, joint.screw.slice(3));
    const v = plus(rotate(t, joint.screw.slice(0, 3)), cross([t[3], t[7], t[11]], w));
    const there = plus(v, cross(w, frame.point));
    const a = frame.axes, turned = (x) => [0, 1, 2].map((k) => a[k] * x[0] + a[4 + k] * x[1] + a[8 + k] * x[2]);
    const twist = [...turned(there).map((x) => x / robot.length_scale), ...turned(w)];
    robot.rows.forEach((row, k) => { columns[joint.variable][k] += joint.multiplier * twist[row]; });
  });
  return columns;
}

// Singular values (descending) and left singular vectors of the task Jacobian: one-sided Jacobi on its transpose.
function decompose(robot, q) {
  const columns = taskJacobian(robot, q), m = robot.rows.length, n = columns.length;
  const a = robot.rows.map((_, k) => columns.map((column) => column[k])); // m vectors of length n
  const u = a.map((_, k) => a.map((__, l) => (k === l ? 1 : 0)));
  for (let sweep = 0; sweep < 40; sweep++) {
    let off = 0;
    for (let i = 0; i < m - 1; i++) {
      for (let j = i + 1; j < m; j++) {
        let x = 0, y = 0, z = 0;
        for (let k = 0; k < n; k++) { x += a[i][k] ** 2; y += a[j][k] ** 2; z += a[i][k] * a[j][k]; }
        if (Math.abs(z) <= 1e-16 * Math.sqrt(x * y) || z === 0) continue;
        off = Math.max(off, Math.abs(z) / Math.sqrt(x * y || 1));
        const tau = (y - x) / (2 * z), t = Math.sign(tau || 1) / (Math.abs(tau) + Math.hypot(1, tau));
        const c = 1 / Math.hypot(1, t), s = c * t;
        for (const [p, r] of [[a[i], a[j]], [u[i], u[j]]]) {
          for (let k = 0; k < p.length; k++) [p[k], r[k]] = [c * p[k] - s * r[k], s * p[k] + c * r[k]];
        }
      }
    }
    if (off < 1e-15) break;
  }
  const order = a.map((row, k) => [Math.sqrt(row.reduce((sum, x) => sum + x * x, 0)), u[k]]).sort((p, r) => r[0] - p[0]);
  return { sigma: order.slice(0, Math.min(m, n)).map((one) => one[0]), u: order.map((one) => one[1]) };
}

// A left singular vector as a direction (v; ω) in the task's frame, of length one: what cannot be made.
function direction(robot, u) {
  const full = new Array(6).fill(0);
  robot.rows.forEach((row, k) => { full[row] = row < 3 ? u[k] / robot.length_scale : u[k]; });
  const size = Math.hypot(...full) || 1;
  return full.map((x) => x / size);
}
