// What the page does: sliders move the arm, a button per family goes to its witness, σ follows.

const data = JSON.parse(document.getElementById("data").textContent);
const robot = data.robot;
const byId = (id) => document.getElementById(id);
const state = { q: robot.joints.map(() => 0), family: null, arrows: [], sigma: [], singular: false };
const arm = new Arm(robot, byId("arm"), data.view);
arm.fit([...data.families.map((family) => family.witness), state.q]);

const degrees = (x) => `${(x * 180 / Math.PI).toFixed(1).replace("-", "−")}°`;
const shown = (joint, x) => (joint.kind === "prismatic" ? `${x.toFixed(3).replace("-", "−")} m` : degrees(x));

function pose(q) {
  const t = tipPose(robot, displacements(robot, q));
  return [t.slice(0, 4), t.slice(4, 8), t.slice(8, 12), [0, 0, 0, 1]];
}

// Directions (v; ω) of the task's frame as arrows in the base frame.
function asArrows(directions, q, faint = false) {
  const axes = taskFrame(robot, displacements(robot, q)).axes;
  return directions.map((d) => ({ v: rotate(axes, d.slice(0, 3)), w: rotate(axes, d.slice(3)), faint }));
}

// At a witness the directions of the analysis; elsewhere those that are lost there, turned towards them, or the weakest.
function lostAt(q, found) {
  const family = state.family;
  if (family && family.witness.every((x, i) => Math.abs(x - q[i]) < 1e-9)) return asArrows(family.lost_directions, q);
  const lost = [];
  const count = found.sigma.slice(0, data.generic_rank).filter((s) => s <= data.live_tolerance).length;
  for (let k = 0; k < count; k++) lost.push(direction(robot, found.u[data.generic_rank - count + k]));
  if (count) return asArrows(family ? turnedTowards(lost, family.lost_directions) : lost, q);
  return data.generic_rank ? asArrows([direction(robot, found.u[data.generic_rank - 1])], q, true) : [];
}

// An orthonormal basis of span(lost) as near to the wanted directions as Gram–Schmidt makes it.
function turnedTowards(lost, wanted) {
  const product = (a, b) => a.reduce((s, x, i) => s + x * b[i], 0);
  const reduce = (x, basis) => basis.reduce((r, b) => r.map((v, i) => v - product(x, b) * b[i]), x);
  const basis = [], span = [];
  for (const x of lost) {
    const r = reduce(x, span), size = Math.sqrt(product(r, r));
    if (size > 1e-9) span.push(r.map((v) => v / size));
  }
  for (const x of [...wanted, ...span]) {
    const inside = span.reduce((r, b) => r.map((v, i) => v + product(x, b) * b[i]), x.map(() => 0));
    const r = reduce(inside, basis), size = Math.sqrt(product(r, r));
    if (size > 0.05 && basis.length < span.length) basis.push(r.map((v) => v / size));
  }
  return basis;
}

function setQ(q) {
  state.q = [...q];
  const found = decompose(robot, state.q);
  arm.widen(state.q);
  state.sigma = found.sigma;
  state.singular = found.sigma.slice(0, data.generic_rank).some((s) => s <= data.live_tolerance);
  state.arrows = lostAt(state.q, found);
  const blamed = state.family && state.singular ? state.family.blamed : [];
  arm.show({ q: state.q, arrows: state.arrows, blamed });
  robot.joints.forEach((joint, i) => {
    const slider = byId(`slider${i + 1}`);
    if (document.activeElement !== slider) slider.value = state.q[i];
    byId(`value${i + 1}`).textContent = shown(joint, state.q[i]);
    slider.parentElement.classList.toggle("blamed", blamed.includes(i + 1));
  });
  tell();
}

function tell() {
  const kept = state.sigma.slice(0, data.generic_rank), lost = kept.filter((s) => s <= data.live_tolerance).length;
  const verdict = byId("verdict");
  verdict.className = lost ? "bad" : kept[kept.length - 1] < 0.02 ? "near" : "good";
  verdict.textContent = lost ? `Singular: rank ${data.generic_rank - lost} of ${data.generic_rank}` : `Regular: rank ${data.generic_rank}, σ${data.generic_rank} = ${kept[kept.length - 1].toPrecision(3)}`;
  const top = Math.max(...kept, 1e-9);
  byId("sigma").innerHTML = kept.map((s, i) => `<div class="${s <= data.live_tolerance ? "zero" : ""}"><b>σ${i + 1}</b><i style="width:${(100 * s / top).toFixed(2)}%"></i><span>${s <= data.live_tolerance ? "0" : s.toPrecision(3)}</span></div>`).join("");
  const family = state.family, at = family && lost;
  byId("told").innerHTML = at
    ? family.told
    : `<p>The faint arrow is the weakest direction: what is lost first as σ${data.generic_rank} shrinks.</p>`;
}

function goTo(id, animate = true) {
  const family = data.families.find((one) => one.id === id);
  state.family = family;
  for (const button of document.querySelectorAll("[data-go]")) button.setAttribute("aria-pressed", String(button.dataset.go === id));
  const from = state.q, still = !animate || matchMedia("(prefers-reduced-motion: reduce)").matches;
  const begun = performance.now();
  arm.fit(still ? [family.witness] : [from, family.witness]);
  const step = (now) => {
    const s = Math.min(1, (now - begun) / 600), eased = s * s * (3 - 2 * s);
    if (state.family !== family) return;
    if (s >= 1) arm.fit([family.witness]);
    setQ(s >= 1 ? family.witness : from.map((x, i) => x + (family.witness[i] - x) * eased));
    if (s < 1) requestAnimationFrame(step);
  };
  if (still) setQ(family.witness);
  else requestAnimationFrame(step);
}

for (const [i, joint] of robot.joints.entries()) {
  byId(`slider${i + 1}`).addEventListener("input", (e) => {
    const q = [...state.q];
    q[i] = Number(e.target.value);
    setQ(q);
  });
}
for (const button of document.querySelectorAll("[data-go]")) {
  button.addEventListener("click", () => {
    goTo(button.dataset.go);
    if (button.dataset.far !== undefined) byId("see").scrollIntoView({ behavior: "smooth" });
  });
}
byId("home").addEventListener("click", () => {
  state.family = null;
  for (const button of document.querySelectorAll("[data-go]")) button.setAttribute("aria-pressed", "false");
  setQ(robot.joints.map(() => 0));
});

// Small still pictures, one per family, and the sets in three joints.
const stills = [...document.querySelectorAll("canvas[data-still]")].map((canvas) => {
  const family = data.families.find((one) => one.id === canvas.dataset.still), small = new Arm(robot, canvas, data.view);
  small.fit([family.witness]);
  small.show({ q: family.witness, arrows: asArrows(family.lost_directions, family.witness), blamed: family.blamed });
  return small;
});
const solids = data.solids.map((one, i) => new SolidView(one, byId(`solid${i + 1}`)));

const redraw = () => [arm, ...stills, ...solids].forEach((one) => one.draw());
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
addEventListener("beforeprint", redraw);
new ResizeObserver(redraw).observe(document.body);
if (data.families.length) goTo(data.families[0].id, false);
else setQ(state.q);

window.rankdropReport = {
  data, state, pose, setQ, goTo, solids,
  singularValues: (q) => decompose(robot, q).sigma,
  lostAt: (q) => lostAt(q, decompose(robot, q)),
  project: (p) => arm.scene.project(p),
};
