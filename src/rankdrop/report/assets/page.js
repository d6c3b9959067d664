// What the page does: sliders move the arm, a button per family goes to its witness, σ follows.

const data = JSON.parse(document.getElementById("data").textContent);
const robot = data.robot;
robot.meshes = data.meshes;
const byId = (id) => document.getElementById(id);
const state = { q: [...data.start], family: null, arrows: [], sigma: [], singular: false };
const arm = new Arm(robot, byId("arm"), data.view);
arm.fit([data.start]);

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
  byId("arm").setAttribute("aria-label", described());
}

// The picture in words: what stands there and what is drawn on it.
function described() {
  const at = robot.joints.map((joint, i) => `joint ${i + 1} at ${shown(joint, state.q[i])}`).join(", ");
  const family = state.family && state.singular ? ` in ${state.family.id}, ${state.family.title}` : "";
  return `The arm ${robot.name}${family}: ${at}. ${byId("verdict").textContent}. Arrow keys turn the view.`;
}

function tell() {
  const kept = state.sigma.slice(0, data.generic_rank), lost = kept.filter((s) => s <= data.live_tolerance).length;
  const verdict = byId("verdict");
  verdict.className = lost ? "bad" : kept[kept.length - 1] < 0.02 ? "near" : "good";
  verdict.textContent = lost ? `Singular: rank ${data.generic_rank - lost} of ${data.generic_rank}` : `Regular: rank ${data.generic_rank}, σ${data.generic_rank} = ${kept[kept.length - 1].toPrecision(3)}`;
  const top = Math.max(...kept, 1e-9);
  byId("sigma").innerHTML = kept.map((s, i) => `<div class="${s <= data.live_tolerance ? "zero" : ""}"><b>σ${i + 1}</b><i style="width:${(100 * s / top).toFixed(2)}%"></i><span>${s <= data.live_tolerance ? "0" : s.toPrecision(3)}</span></div>`).join("");
  const family = state.family, at = family && lost > 0;
  byId("facts").innerHTML = at
    ? family.facts
    : data.generic_rank === 0 ? "" : `<p>The faint arrow is the weakest direction: what is lost first as σ${data.generic_rank} shrinks.</p>`;
  offer(at ? family : null);
}

// Ways out of the witness, as buttons; none where the arm stands elsewhere.
function offer(family) {
  const at = family && family.witness.every((x, i) => Math.abs(x - state.q[i]) < 1e-9);
  const name = at ? family.id : "";
  if (byId("ways").dataset.of === name) return;
  byId("ways").dataset.of = name;
  byId("ways").replaceChildren(...(at ? ways(family) : []));
}

function ways(family) {
  const head = document.createElement("p");
  head.className = "small";
  head.textContent = family.ways.length ? "Ways out, and what they give:" : "No way out inside the joint limits was found.";
  const buttons = family.ways.map((way) => {
    const button = document.createElement("button");
    button.textContent = `${way.label} → ${way.after}`;
    button.addEventListener("click", () => move(way.q));
    return button;
  });
  return [head, ...buttons];
}

// A slow motion from where the arm stands; whoever begins another one ends it.
function move(q, done = () => {}) {
  const from = state.q, begun = performance.now(), mine = (state.motion = (state.motion || 0) + 1);
  if (matchMedia("(prefers-reduced-motion: reduce)").matches) { setQ(q); done(); return; }
  const step = (now) => {
    if (state.motion !== mine) return;
    const s = Math.max(0, Math.min(1, (now - begun) / 600)), eased = s * s * (3 - 2 * s);
    setQ(s >= 1 ? q : from.map((x, i) => x + (q[i] - x) * eased));
    if (s < 1) requestAnimationFrame(step); else done();
  };
  requestAnimationFrame(step);
}

function goTo(id, animate = true) {
  const family = data.families.find((one) => one.id === id);
  state.family = family;
  for (const button of document.querySelectorAll("[data-go]")) button.setAttribute("aria-pressed", String(button.dataset.go === id));
  arm.fit(animate ? [state.q, family.witness] : [family.witness]);
  if (animate) { move(family.witness, () => { arm.fit([family.witness]); arm.draw(); }); return; }
  state.motion = (state.motion || 0) + 1;
  setQ(family.witness);
}

// Sliders end at the joint limits while the box is ticked, and families outside them cannot be gone to.
const ends = robot.joints.map((_, i) => [byId(`slider${i + 1}`).min, byId(`slider${i + 1}`).max]);
function keepLimits(kept) {
  robot.joints.forEach((joint, i) => {
    const slider = byId(`slider${i + 1}`), [low, high] = kept && joint.limits ? joint.limits : ends[i];
    slider.min = Math.min(low, kept ? state.q[i] : low);
    slider.max = Math.max(high, kept ? state.q[i] : high);
    slider.value = state.q[i];
    slider.title = joint.limits ? `limits ${shown(joint, joint.limits[0])} … ${shown(joint, joint.limits[1])}` : "no limits known";
  });
  for (const button of document.querySelectorAll("[data-go]")) {
    const standing = data.families.find((one) => one.id === button.dataset.go).standing;
    button.disabled = kept && (standing === "outside" || standing === "none found");
  }
}

for (const [i, joint] of robot.joints.entries()) {
  byId(`slider${i + 1}`).addEventListener("input", (e) => {
    const q = [...state.q];
    q[i] = Number(e.target.value);
    state.motion = (state.motion || 0) + 1;
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
  arm.fit([state.q, data.start]);
  move(data.start);
});
if (byId("limits")) byId("limits").addEventListener("change", (e) => keepLimits(e.target.checked));
if (byId("meshes")) byId("meshes").addEventListener("change", (e) => { robot.bare = !e.target.checked; arm.draw(); });

// Downloads: what the page holds, written by the browser; nothing is asked for.
function save(name, parts, type) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob(parts, { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}
byId("save-csv").addEventListener("click", () => save(`${data.downloads.file}.csv`, ["\ufeff", data.downloads.csv], "text/csv"));
byId("save-json").addEventListener("click", () => save(`${data.downloads.file}.json`, [JSON.stringify(data.downloads.record)], "application/json"));
byId("save-png").addEventListener("click", () => byId("arm").toBlob((blob) => save(`${data.downloads.file}.png`, [blob], "image/png")));

// A figure as a file of its own: colours of the page are written into it.
function standalone(svg) {
  const copy = svg.cloneNode(true), from = [svg, ...svg.querySelectorAll("*")], to = [copy, ...copy.querySelectorAll("*")];
  from.forEach((one, i) => {
    const seen = getComputedStyle(one);
    for (const name of ["fill", "stroke", "stroke-width", "stroke-dasharray", "font-size", "font-family", "font-weight"]) to[i].style.setProperty(name, seen.getPropertyValue(name));
  });
  copy.setAttribute("xmlns", "http://www.w3.org/2000/svg");
  return new XMLSerializer().serializeToString(copy);
}
for (const [i, svg] of [...document.querySelectorAll("figure > svg")].entries()) {
  const button = document.createElement("button");
  button.className = "figure-save screen";
  button.textContent = "SVG";
  button.setAttribute("aria-label", `download figure ${i + 1} as SVG: ${svg.getAttribute("aria-label")}`);
  button.addEventListener("click", () => save(`${data.downloads.file}-figure${i + 1}.svg`, [standalone(svg)], "image/svg+xml"));
  svg.parentElement.querySelector("figcaption").append(" ", button);
}

// Only tables that are wider than the screen say so.
const swipes = () => document.querySelectorAll(".scroll").forEach((one) => one.classList.toggle("wider", one.scrollWidth > one.clientWidth + 2));

// Small still pictures, one per family, and the sets in three joints.
const stills = [...document.querySelectorAll("canvas[data-still]")].map((canvas) => {
  const family = data.families.find((one) => one.id === canvas.dataset.still), small = new Arm(robot, canvas, data.view);
  small.fit([family.witness]);
  small.show({ q: family.witness, arrows: asArrows(family.lost_directions, family.witness), blamed: family.blamed });
  return small;
});
const solids = data.solids.map((one, i) => new SolidView(one, byId(`solid${i + 1}`)));

const redraw = () => { swipes(); [arm, ...stills, ...solids].forEach((one) => one.draw()); };
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
const printing = (widest) => () => { Scene.widest = widest; redraw(); };
addEventListener("beforeprint", printing(1.25));
addEventListener("afterprint", printing(Infinity));
new ResizeObserver(redraw).observe(document.body);
const first = data.families.find((one) => one.standing === "inside" || one.standing === "");
if (first) goTo(first.id, false);
else setQ(data.start);
keepLimits(byId("limits") !== null);

window.rankdropReport = {
  data, state, pose, setQ, goTo, solids, keepLimits, standalone,
  singularValues: (q) => decompose(robot, q).sigma,
  lostAt: (q) => lostAt(q, decompose(robot, q)),
  project: (p) => arm.scene.project(p),
  drawn: () => [arm, ...stills].map((one) => one.drawn()),
};
