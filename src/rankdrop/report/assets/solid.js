// Singular sets in the cube of three joints: curves and surfaces (AM Figure 5).

const FAMILY_COLOURS = ["--f1", "--f2", "--f3", "--f4", "--f5", "--f6", "--f7", "--f8"];

class SolidView {
  constructor(data, canvas) {
    this.data = data;
    this.scene = new Scene(canvas, { turn: -0.95, tilt: 0.4 });
    this.scene.radius = Math.PI * 1.72;
    this.scene.draw = () => this.draw();
    this.normals = data.triangles.map((t) => {
      const [a, b, c] = t.map((i) => data.vertices[i]);
      return unit(cross(plus(b, a, -1), plus(c, a, -1)));
    });
    this.draw();
  }

  draw() {
    const scene = this.scene, data = this.data, colour = ink(FAMILY_COLOURS[data.colour]);
    scene.begin();
    this.cube();
    data.triangles.forEach((t, i) => {
      const normal = this.normals[i], facing = dot(normal, scene.toward) < 0 ? [-normal[0], -normal[1], -normal[2]] : normal;
      scene.polygon(t.map((k) => data.vertices[k]), scene.shade(colour, facing, 0.55), 0.93, true);
    });
    for (const line of data.curves) {
      for (let i = 0; i + 1 < line.length; i++) scene.line([line[i], line[i + 1]], colour, 3);
      if (line.length > 1) this.shadow(line);
    }
    scene.finish();
  }

  shadow(line) {
    this.scene.line(line.map((p) => [p[0], p[1], -Math.PI]), ink("--faint"), 1.2, { lift: -9 });
  }

  cube() {
    const scene = this.scene, p = Math.PI, names = this.data.names;
    const corners = (axis, a, b) => [-p, p].map((x) => { const c = [0, 0, 0]; c[axis] = x; c[(axis + 1) % 3] = a; c[(axis + 2) % 3] = b; return c; });
    for (let axis = 0; axis < 3; axis++) {
      for (const a of [-p, p]) for (const b of [-p, p]) scene.line(corners(axis, a, b), ink("--grid"), 1, { lift: -8 });
    }
    const near = (axis) => (scene.toward[axis] > 0 ? 1 : -1);
    const edge = [[0, [null, near(1) * p, -p]], [1, [near(0) * p, null, -p]], [2, [near(0) * p, -near(1) * p, null]]];
    for (const [axis, corner] of edge) {
      for (const [x, word] of [[-p, "−180°"], [0, "0°"], [p, "180°"]]) {
        const at = corner.map((c) => (c === null ? x : c * 1.1));
        scene.text(at, word, ink("--soft"), { size: 11 });
      }
      scene.text(corner.map((c) => (c === null ? p * 0.5 : c * 1.2)), names[axis], ink("--ink"), { size: 14, bold: true });
    }
  }
}
