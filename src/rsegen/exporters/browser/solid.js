/* The 3D view: the visible faces of all blocks as one mesh, drawn by three.js. z is up, lengths are in metres. */

const MOST_SHADOWED = 90000; // cells: beyond it, shadows cost more than they show

/* The tops of all cells, and their sides where a neighbour is lower, four corners for each face.

Each corner has the colour of its cell and, as a fourth value, how much light comes into that corner. */
class Faces {
  constructor(field) {
    this.field = field;
    this.colours = field.palette.map((entry) => entry.surface.match(/\w\w/g).map((part) => parseInt(part, 16)));
    const count = field.nX * field.nY + countSides(field);
    this.positions = new Float32Array(12 * count);
    this.shades = new Uint8Array(16 * count);
    this.index = new Uint32Array(6 * count);
    this.face = 0;
    for (let i = 0; i < field.nX; i++) for (let j = 0; j < field.nY; j++) this.addTop(i, j);
    eachSide(field, (...side) => this.addSide(...side));
  }

  geometry() {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(this.positions, 3));
    geometry.setAttribute("color", new THREE.BufferAttribute(this.shades, 4, true));
    geometry.setIndex(new THREE.BufferAttribute(this.index, 1));
    return geometry;
  }

  addTop(i, j) {
    const { field } = this;
    const z = field.height(i, j);
    const [x0, x1, y0, y1] = [field.x(i), field.x(i + 1), field.y(j), field.y(j + 1)];
    const light = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([a, b]) => this.lightAt(i, j, a, b, z));
    this.add([x0, y0, z, x1, y0, z, x1, y1, z, x0, y1, z], light, i, j);
  }

  /* Less light at a corner of a top that higher blocks surround. */
  lightAt(i, j, a, b, z) {
    const { field } = this;
    let hidden = 0;
    for (const [di, dj] of [[a, 0], [0, b], [a, b]]) {
      hidden += Math.min(1, Math.max(0, field.height(i + di, j + dj) - z) / (2 * field.width));
    }
    return 1 - 0.2 * hidden;
  }

  /* The wall between two cells, from the lower top to the higher one; along: 0 where it faces x, 1 where it faces y. */
  addSide(i, j, low, high, along, towards) {
    const { field } = this;
    const at = towards > 0 ? 1 : 0;
    const foot = 0.72;
    const light = [foot, foot, 1, 1];
    if (along === 0) {
      const x = field.x(i + at);
      const [y0, y1] = towards > 0 ? [field.y(j), field.y(j + 1)] : [field.y(j + 1), field.y(j)];
      this.add([x, y0, low, x, y1, low, x, y1, high, x, y0, high], light, i, j);
    } else {
      const y = field.y(j + at);
      const [x0, x1] = towards > 0 ? [field.x(i + 1), field.x(i)] : [field.x(i), field.x(i + 1)];
      this.add([x0, y, low, x1, y, low, x1, y, high, x0, y, high], light, i, j);
    }
  }

  add(corners, light, i, j) {
    const first = 4 * this.face;
    const [red, green, blue] = this.colours[this.field.cells[i * this.field.nY + j]];
    this.positions.set(corners, 3 * first);
    for (let k = 0; k < 4; k++) this.shades.set([red, green, blue, Math.round(255 * light[k])], 4 * (first + k));
    this.index.set([first, first + 1, first + 2, first, first + 2, first + 3], 6 * this.face);
    this.face += 1;
  }
}

/* Every wall: the cell that it belongs to, which is the higher one, from where to where, and where it faces. */
function eachSide(field, visit) {
  for (let i = 0; i < field.nX; i++) {
    for (let j = 0; j < field.nY; j++) {
      const own = field.height(i, j);
      if (own === 0) continue;
      for (const towards of [-1, 1]) {
        const [besideX, besideY] = [field.height(i + towards, j), field.height(i, j + towards)];
        if (besideX < own) visit(i, j, besideX, own, 0, towards);
        if (besideY < own) visit(i, j, besideY, own, 1, towards);
      }
    }
  }
}

function countSides(field) {
  let count = 0;
  eachSide(field, () => count++);
  return count;
}

/* Colours of corners as they are, times their light, and a line along the edges of each face that is about one pixel
wide and fades where faces are small. Every face has four corners, so the number of a corner tells its place. */
function blockMaterial() {
  const material = new THREE.MeshLambertMaterial({ vertexColors: true, flatShading: true });
  material.onBeforeCompile = (shader) => {
    shader.vertexShader = shader.vertexShader
      .replace("#include <common>", "#include <common>\nvarying vec2 vFace;")
      .replace(
        "#include <begin_vertex>",
        "#include <begin_vertex>\nint corner = gl_VertexID % 4;\n" +
          "vFace = vec2(corner == 1 || corner == 2 ? 1.0 : 0.0, corner > 1 ? 1.0 : 0.0);",
      );
    shader.fragmentShader = shader.fragmentShader
      .replace("#include <common>", "#include <common>\nvarying vec2 vFace;")
      .replace(
        "#include <color_fragment>",
        `diffuseColor.rgb = pow(vColor.rgb, vec3(2.2)) * vColor.a;
        vec2 pixel = max(fwidth(vFace), vec2(1e-6));
        vec2 apart = min(vFace, 1.0 - vFace) / pixel;
        float edge = 1.0 - smoothstep(0.35, 1.35, min(apart.x, apart.y));
        float fade = 1.0 - smoothstep(0.12, 0.45, max(pixel.x, pixel.y));
        diffuseColor.rgb *= 1.0 - 0.62 * edge * fade;`,
      );
  };
  return material;
}

/* The cell that a ray meets first, as [i, j]; null if it meets none. The ray is followed from cell to cell. */
function cellOnRay(field, origin, direction) {
  const start = [origin.x / field.width + field.nX / 2, origin.y / field.width + field.nY / 2, origin.z];
  const way = [direction.x / field.width, direction.y / field.width, direction.z];
  let [now, end] = [0, Infinity];
  [field.nX, field.nY, field.highest].forEach((size, axis) => {
    const ends = [-start[axis] / way[axis], (size - start[axis]) / way[axis]];
    if (way[axis] === 0) {
      if (start[axis] < 0 || start[axis] > size) end = -1;
      return;
    }
    now = Math.max(now, Math.min(...ends));
    end = Math.min(end, Math.max(...ends));
  });
  if (now > end) return null;
  const inside = (axis, size) => Math.min(size - 1, Math.max(0, Math.floor(start[axis] + way[axis] * now)));
  let [i, j] = [inside(0, field.nX), inside(1, field.nY)];
  for (;;) {
    const untilX = way[0] === 0 ? Infinity : (i + (way[0] > 0 ? 1 : 0) - start[0]) / way[0];
    const untilY = way[1] === 0 ? Infinity : (j + (way[1] > 0 ? 1 : 0) - start[1]) / way[1];
    const until = Math.min(untilX, untilY, end);
    const lowest = start[2] + way[2] * (way[2] < 0 ? until : now);
    if (lowest <= field.height(i, j) + 1e-9) return [i, j];
    if (until >= end) return null;
    if (untilX < untilY) i += Math.sign(way[0]);
    else j += Math.sign(way[1]);
    if (i < 0 || j < 0 || i >= field.nX || j >= field.nY) return null;
    now = until;
  }
}

const DIRECTIONS = { oblique: [0.47, -0.95, 0.8], above: [0, -1e-4, 1], south: [0, -1, 0.28] };

class Solid {
  constructor(canvas, axes) {
    this.canvas = canvas;
    this.axes = axes;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.camera = new THREE.PerspectiveCamera(30, 1, 0.01, 1000);
    this.camera.up.set(0, 0, 1);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    Object.assign(this.controls, { maxPolarAngle: Math.PI / 2 - 0.02, zoomToCursor: true, dampingFactor: 0.12 });
    this.controls.enableDamping = !matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.controls.addEventListener("change", () => this.ask());
    canvas.addEventListener("keydown", (event) => this.turn(event));
    this.from = "oblique";
    this.waits = false;
    new ResizeObserver(() => this.resize()).observe(canvas);
  }

  show(field) {
    this.field = field;
    this.scene = new THREE.Scene();
    this.geometry?.dispose();
    this.geometry = new Faces(field).geometry();
    const blocks = new THREE.Mesh(this.geometry, blockMaterial());
    blocks.castShadow = blocks.receiveShadow = field.nX * field.nY <= MOST_SHADOWED;
    this.radius = Math.hypot(field.nX * field.width, field.nY * field.width, field.highest) / 2;
    this.mark = new THREE.LineSegments(unitBox(), new THREE.LineBasicMaterial({ color: "#ff2d7a" }));
    this.mark.visible = false;
    this.scene.add(blocks, this.mark, this.arrows(), this.ground(), ...this.lights());
    this.renderer.shadowMap.needsUpdate = true;
    this.look(this.from);
  }

  lights() {
    const sun = new THREE.DirectionalLight("#fff6e6", 2.1);
    sun.position.set(-0.6 * this.radius, -0.95 * this.radius, 1.8 * this.radius);
    sun.castShadow = true;
    sun.shadow.mapSize.set(2048, 2048);
    const r = 1.05 * this.radius;
    Object.assign(sun.shadow.camera, { left: -r, right: r, top: r, bottom: -r, near: 0, far: 5 * this.radius });
    sun.shadow.radius = 3;
    sun.shadow.normalBias = 0.06 * this.field.width;
    sun.shadow.bias = -0.0004;
    return [sun, new THREE.HemisphereLight("#f2f6ff", "#b8b0a6", 1.9)];
  }

  /* The floor beside the map, of which only the shadow is seen. */
  ground() {
    const plane = new THREE.Mesh(new THREE.PlaneGeometry(), new THREE.ShadowMaterial({ opacity: 0.22 }));
    plane.scale.set(8 * this.radius, 8 * this.radius, 1);
    plane.position.z = -0.001 * this.radius;
    plane.receiveShadow = true;
    return plane;
  }

  /* Lines along x before the south side, and along y before the east side, with heads. */
  arrows() {
    const { field } = this;
    const [gap, head] = [0.05 * this.radius, 0.025 * this.radius];
    const [west, east, south, length] = [field.x(0), field.x(field.nX) + gap, field.y(0) - gap, 0.35 * this.radius];
    const [x, y] = [west + length, south + gap + length];
    this.ends = [new THREE.Vector3(x + 2.5 * head, south, 0), new THREE.Vector3(east, y + 2.5 * head, 0)];
    const along = [west, south, 0, x, south, 0, x, south, 0, x - head, south + head, 0];
    const across = [east, south + gap, 0, east, y, 0, east, y, 0, east + head, y - head, 0];
    along.push(x, south, 0, x - head, south - head, 0);
    across.push(east, y, 0, east - head, y - head, 0);
    const points = [...along, ...across];
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
    return new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: "#8a8f98" }));
  }

  /* Look at the whole map from one of DIRECTIONS. */
  look(from) {
    this.from = from;
    this.controls.target.set(0, 0, 0.35 * this.field.highest);
    Object.assign(this.camera, { near: this.radius / 100, far: 60 * this.radius });
    this.camera.updateProjectionMatrix();
    const away = this.distance(from);
    Object.assign(this.controls, { minDistance: 2 * this.field.width, maxDistance: 4 * away });
    this.controls.update();
    this.ask();
  }

  /* The least distance from which the whole map is seen, found by halving; the camera is put there. */
  distance(from) {
    const { field, camera } = this;
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map(
      (k) => new THREE.Vector3(field.x(k & 1 ? field.nX : 0), field.y(k & 2 ? field.nY : 0), k & 4 ? field.highest : 0),
    );
    const fits = (away) => {
      camera.position.set(...DIRECTIONS[from]).setLength(away).add(this.controls.target);
      camera.lookAt(this.controls.target);
      camera.updateMatrixWorld();
      return corners.every((corner) => {
        const { x, y, z } = corner.clone().project(camera);
        return Math.max(Math.abs(x), Math.abs(y)) < 0.9 && z < 1;
      });
    };
    let [near, far] = [this.radius, 30 * this.radius];
    for (let k = 0; k < 20; k++) {
      const middle = (near + far) / 2;
      if (fits(middle)) far = middle;
      else near = middle;
    }
    fits(far);
    return far;
  }

  turn(event) {
    const steps = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    const nearer = { "+": 0.85, "-": 1 / 0.85 }[event.key];
    if (!steps && !nearer) return;
    event.preventDefault();
    const arm = this.camera.position.clone().sub(this.controls.target);
    if (steps) {
      const flat = Math.hypot(arm.x, arm.y);
      const round = Math.atan2(arm.y, arm.x) - 0.12 * steps[0];
      const up = Math.min(1.56, Math.max(0.03, Math.atan2(arm.z, flat) + 0.08 * steps[1]));
      const length = arm.length();
      arm.set(Math.cos(round) * Math.cos(up), Math.sin(round) * Math.cos(up), Math.sin(up)).multiplyScalar(length);
    }
    this.camera.position.copy(this.controls.target).add(arm.multiplyScalar(nearer ?? 1));
    this.controls.update();
    this.ask();
  }

  resize() {
    const { clientWidth, clientHeight } = this.canvas;
    if (!clientWidth || !clientHeight) return;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    if (this.field && !this.wasSized) this.look(this.from);
    this.wasSized = Boolean(this.field);
    this.draw();
  }

  /* Draw before long; several wishes are one picture. */
  ask() {
    if (this.waits) return;
    this.waits = true;
    requestAnimationFrame(() => {
      this.waits = false;
      this.controls.update();
      this.draw();
    });
  }

  draw() {
    if (!this.field) return;
    this.renderer.render(this.scene, this.camera);
    this.axes.forEach((label, k) => {
      const [x, y] = this.pixel(this.ends[k]);
      label.style.transform = `translate(${x}px, ${y}px) translate(-50%, -50%)`;
    });
  }

  /* Where a point is on the canvas, in CSS pixels. */
  pixel(point) {
    const { x, y } = point.clone().project(this.camera);
    return [((x + 1) / 2) * this.canvas.clientWidth, ((1 - y) / 2) * this.canvas.clientHeight];
  }

  /* Where the middle of a cell's top is on the canvas, in CSS pixels. */
  pixelOf(i, j) {
    const { field } = this;
    this.camera.updateMatrixWorld();
    return this.pixel(new THREE.Vector3(field.x(i + 0.5), field.y(j + 0.5), field.height(i, j)));
  }

  /* The cell that is seen at a place of the canvas, in CSS pixels. */
  cellAt(x, y) {
    const ray = new THREE.Raycaster();
    const place = [(2 * x) / this.canvas.clientWidth - 1, 1 - (2 * y) / this.canvas.clientHeight];
    this.camera.updateMatrixWorld();
    ray.setFromCamera(new THREE.Vector2(...place), this.camera);
    return cellOnRay(this.field, ray.ray.origin, ray.ray.direction);
  }

  highlight(cell) {
    const { field, mark } = this;
    mark.visible = Boolean(cell);
    if (cell) {
      const [i, j] = cell;
      const gap = 0.012 * field.width;
      mark.position.set(field.x(i) - gap, field.y(j) - gap, 0);
      mark.scale.set(field.width + 2 * gap, field.width + 2 * gap, field.height(i, j) + gap);
    }
    this.ask();
  }
}

/* The twelve edges of the cube from 0 to 1. */
function unitBox() {
  const points = [];
  for (const [a, b] of [[0, 0], [0, 1], [1, 0], [1, 1]]) {
    points.push(0, a, b, 1, a, b, a, 0, b, a, 1, b, a, b, 0, a, b, 1);
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
  return geometry;
}
