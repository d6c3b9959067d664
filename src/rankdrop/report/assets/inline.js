// The arm alone, to be turned in a notebook.

const data = JSON.parse(document.getElementById("data").textContent);
const arm = new Arm(data.robot, document.getElementById("arm"), data.view);
arm.fit([data.q]);
arm.show({ q: data.q, arrows: data.arrows, blamed: data.blamed });
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => arm.draw());
new ResizeObserver(() => arm.draw()).observe(document.body);
