/* The 3D view: a map that is turned, edited and driven on. It is drawn only when something changed. */

import {
  BoxGeometry, InstancedMesh, MOUSE, Matrix4, Mesh, MeshLambertMaterial, Object3D, Plane,
  Raycaster, TOUCH, Vector2, Vector3, type WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { blocksOf } from "./blocks";
import { ACCENT, BAD, START, TROUBLE } from "./colours";
import { Field, onRay, outline, type Place, type Point } from "./field";
import { Player, Robot, dot, drop, letter, linesOf, pairs, restOf, rotationOf } from "./models";
import { END, endsOf, ofPoses, ofReach, type Overlay } from "./overlay";
import type { Playback, DrawnPose, PoseMap, DrawnCrossing, DrawnReach, RobotShapes, SceneData, DrawnWay } from "./protocol";
import { Stage, rendererOf, type From } from "./stage";
import { Grips, Tools, add, cellsBetween, gripsOf, moveTo } from "./tools";
import type { Board, Grip, Preview, Spot } from "./tools";
import type { Options, Tool, View, ViewEvents } from "./views";
import "./views.css";

const SLOW = 80; // milliseconds per picture beyond which the next ones have fewer pixels
const REST = 200; // milliseconds without a change after which it is drawn in full again

/* The view; an error where the browser has no WebGL 2. */
export class Solid implements View, Board {
  field: Field | null = null;
  readonly canvas = document.createElement("canvas");
  readonly stage = new Stage();
  private readonly renderer: WebGLRenderer;
  private readonly controls: OrbitControls;
  private readonly tools: Tools;
  readonly name = "3D view";
  readonly moved = "arrow keys turn it";
  readonly grips: Grips;
  private readonly label: HTMLElement;
  private readonly axes: HTMLElement[];
  private readonly sizes: ResizeObserver;
  private options: Options = { look: "recipe", grid: true, axes: true, dark: false };
  private from: From = "oblique";
  private row = -1;
  private shownReach: DrawnReach | null = null;
  private shownPoses: Overlay | null = null;
  private shownRobot: Robot | null = null;
  private player: Player | null = null;
  private playback: Playback | null = null; // that of the player
  private readonly parts = new Map<string, Object3D>(); // what is drawn besides the map, by what it is
  private ends: Point[] = [];
  private marked: Spot | null = null;
  private markedIn: Field | null = null;
  private isSized = false;
  private frame = 0;
  private isWanted = false; // another picture
  private isBusy = false; // one is being drawn
  private resting = 0;
  private scale = 1; // of pixels while something changes

  constructor(readonly host: HTMLElement, on: ViewEvents) {
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "application");
    this.renderer = rendererOf(this.canvas); // first: nothing is in the page if it fails
    host.classList.add("view");
    host.append(this.canvas);
    this.tools = new Tools(this, on);
    this.controls = new OrbitControls(this.stage.camera, this.canvas);
    Object.assign(this.controls, { maxPolarAngle: Math.PI / 2 - 0.02, zoomToCursor: true, zoomSpeed: 1.6 });
    this.controls.target = this.stage.target;
    this.controls.addEventListener("change", () => this.ask());
    this.grips = new Grips(host);
    this.axes = ["x", "y"].map((name) => add(host, "axis", name));
    this.label = add(host, "tag");
    this.label.hidden = true;
    this.canvas.addEventListener("webglcontextrestored", () => this.ask());
    this.sizes = new ResizeObserver(() => this.resize());
    this.sizes.observe(host);
    addEventListener("beforeprint", this.print);
  }

  /* ---- what is shown */

  show(scene: SceneData | null): void {
    if (!scene) {
      this.field = null;
      return;
    }
    const before = this.field;
    this.field = new Field(scene);
    this.stage.show(this.field, this.options);
    this.tools.shown();
    this.drawAxes();
    this.select(this.row);
    if (this.shownReach) this.lay();
    if (this.marked) this.mark(this.field.has(...this.marked.cell) ? this.marked : null);
    if (!this.field.isLike(before)) this.look(this.from);
    this.ask();
  }

  set(options: Partial<Options>): void {
    const { look, dark } = this.options;
    Object.assign(this.options, options);
    this.host.toggleAttribute("data-dark", this.options.dark);
    this.stage.dress(this.options);
    const isOther = look !== this.options.look || dark !== this.options.dark;
    if (this.field && isOther) this.stage.show(this.field, this.options);
    this.drawAxes();
    this.ask();
  }

  tool(tool: Tool): void {
    this.tools.set(tool);
    this.lets(true, tool.name === "paint" || tool.name === "draw");
    this.placeGrips();
    this.ask();
  }

  select(row: number): void {
    this.row = row;
    const { field } = this;
    const lines: Object3D[] = [];
    if (field) {
      const [cells, between] = [field.cellsOf(row), cellsBetween(field, row)];
      const around = outline(field, cells);
      if (cells.length) lines.push(linesOf(lifted(around, field), { colour: ACCENT, width: 3 }));
      if (cells.length) lines.push(linesOf(around, { colour: ACCENT, width: 1.5, opacity: 0.35, hidden: true }));
      const dashed = { colour: "#ffffff", width: 1.5, opacity: 0.85, hidden: true, dash: 0.3 * field.width };
      if (between.length) lines.push(linesOf(outline(field, between), dashed));
    }
    this.part("selected", lines);
    this.placeGrips();
    this.ask();
  }

  ghost(scene: SceneData | null, row: number): void {
    if (!scene) this.part("ghost", []);
    else {
      const field = new Field(scene);
      const material = new MeshLambertMaterial({
        color: ACCENT, transparent: true, opacity: 0.55, flatShading: true,
        polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -2, // in front of the blocks that it covers
      });
      const geometry = blocksOf(field, { look: "heights", floor: ACCENT, isSeen: (i, j) => field.owner(i, j) === row });
      const lines = linesOf(outline(field, field.cellsOf(row)), { colour: ACCENT, width: 2, hidden: true });
      this.part("ghost", [new Mesh(geometry, material), lines]);
    }
    this.ask();
  }

  robot(drawing: RobotShapes | null, pose: DrawnPose | null): void {
    if (this.shownRobot?.drawing !== drawing) {
      this.part("robot", []);
      this.shownRobot = drawing && new Robot(drawing);
    }
    const { shownRobot, field } = this;
    this.part("rest", shownRobot && pose ? [restOf(pose, 0.012 * Math.max(...drawing!.size, field?.width ?? 0))] : []);
    if (shownRobot && pose) {
      shownRobot.put(new Vector3(pose.x, pose.y, pose.z), rotationOf(pose.roll, pose.pitch, pose.yaw));
      shownRobot.tint(!pose.stands || !pose.holds);
      if (!this.parts.has("robot")) this.part("robot", [shownRobot.group]);
    } else if (shownRobot) {
      this.part("robot", []);
      this.shownRobot = null;
    }
    this.castShadows();
  }

  poseMap(map: PoseMap | null, shown: "tilt" | "margin" | "reason"): void {
    this.shownPoses = map && ofPoses(map, shown);
    this.lay();
  }

  reach(reach: DrawnReach | null, crossing?: DrawnCrossing | null): void {
    this.shownReach = reach;
    const ways = (crossing ?? reach)?.ways.map(({ points, crosses }) =>
      linesOf(pairs(points), { colour: crosses ? START : TROUBLE, width: 4, hidden: true }),
    ) ?? [];
    const ends = endsOf(crossing).map((end) => letter(this.ground(end), END, TROUBLE));
    const spots = (reach?.spots ?? []).map(({ x, y, z, name }) =>
      letter([x, y, z], name, name === "S" ? START : ACCENT),
    );
    this.part("reach", [...ways, ...spots, ...ends]);
    this.lay();
  }

  /* The point on the map above or below a place. */
  private ground([x, y]: [number, number]): Point {
    return [x, y, this.field ? this.field.height(...this.field.place(x, y)) : 0];
  }

  way(way: DrawnWay | null, start: [number, number] | null): void {
    const { field } = this;
    const size = 0.22 * (field?.width ?? 0.1);
    const parts: Object3D[] = [];
    if (start && !way?.poses.length) parts.push(letter(this.ground(start), "S", START));
    if (way?.poses.length) {
      const points = way.poses.map(([x, y, z]): Point => [x, y, z + 0.1 * size]);
      parts.push(linesOf(pairs(points), { colour: "#ffffff", width: 7, opacity: 0.8, hidden: true }));
      parts.push(linesOf(pairs(points), { colour: START, width: 4, hidden: true }));
      parts.push(letter(points[0], "S", START), letter(points[points.length - 1], "G", ACCENT));
      for (const { at } of way.events) if (points[at]) parts.push(dot(points[at], 0.8 * size, TROUBLE));
    }
    this.part("way", parts);
    this.ask();
  }

  play(playback: Playback | null, drawings: Map<string, RobotShapes>): void {
    this.player = playback && new Player(playback, drawings, 0.1 * (this.field?.width ?? 0.1));
    this.part("play", this.player ? [this.player.group] : []);
    this.stage.drives = this.player?.boxes ?? [];
    if (playback && playback !== this.playback) this.look(this.from);
    this.playback = playback;
    this.castShadows();
  }

  at(second: number): void {
    this.player?.at(second);
    this.castShadows();
  }

  look(from: From): void {
    this.from = from;
    const away = this.stage.look(from);
    if (this.field) Object.assign(this.controls, { minDistance: 2 * this.field.width, maxDistance: 5 * away });
    this.controls.update();
    this.ask();
  }

  async picture(width: number, height: number): Promise<Blob> {
    cancelAnimationFrame(this.frame);
    this.frame = 0;
    this.renderer.setPixelRatio(1);
    this.size(width, height);
    this.stage.render(this.renderer);
    const blob = new Promise<Blob>((done, failed) =>
      this.canvas.toBlob((made) => (made ? done(made) : failed(new Error("the browser made no picture"))), "image/png"),
    );
    this.resize();
    return blob;
  }

  dispose(): void {
    [this.field, this.isWanted] = [null, false]; // a picture that is under way is the last one
    cancelAnimationFrame(this.frame);
    clearTimeout(this.resting);
    this.sizes.disconnect();
    removeEventListener("beforeprint", this.print);
    this.tools.dispose();
    this.controls.dispose();
    for (const name of [...this.parts.keys()]) this.part(name, []);
    this.stage.dispose();
    this.renderer.dispose();
    this.renderer.forceContextLoss(); // browsers have few of them
    this.grips.dispose();
    for (const element of [this.canvas, this.label, ...this.axes]) element.remove();
  }

  /* Put objects into the scene in place of those of the same name. */
  private part(name: string, objects: Object3D[]): void {
    drop(this.parts.get(name) ?? null);
    this.parts.delete(name);
    if (!objects.length) return;
    const group = new Object3D();
    group.add(...objects);
    this.parts.set(name, group);
    this.stage.scene.add(group);
  }

  /* One picture lies on the tops: the map of poses if it is shown, else what is reached. */
  private lay(): void {
    const reached = this.shownReach && this.field && ofReach(this.shownReach, this.field.scene);
    this.stage.overlay(this.shownPoses ?? reached);
    this.ask();
  }

  private castShadows(): void {
    const robots = [...(this.shownRobot ? [this.shownRobot.group] : []), ...(this.player?.robots ?? [])];
    this.stage.cast(robots);
    this.ask();
  }

  /* Lines along x before the south side, and along y beside the east side, with heads. */
  private drawAxes(): void {
    const { field, stage } = this;
    const isShown = Boolean(field) && this.options.axes;
    this.axes.forEach((label) => (label.hidden = !isShown));
    if (!field || !isShown) return this.part("axes", []);
    const [gap, head, length] = [0.05 * stage.radius, 0.025 * stage.radius, 0.35 * stage.radius];
    const [x0, x1] = [field.x(0), field.x(0) + length];
    const south = field.y(0) - gap;
    const [east, y0, y1] = [field.x(field.nX) + gap, field.y(0), field.y(0) + length];
    this.ends = [[x1 + 2.5 * head, south, 0], [east, y1 + 2.5 * head, 0]];
    const along: Point[] = [
      [x0, south, 0], [x1, south, 0], [x1 - head, south + head, 0], [x1, south, 0], [x1 - head, south - head, 0],
    ];
    const across: Point[] = [
      [east, y0, 0], [east, y1, 0], [east + head, y1 - head, 0], [east, y1, 0], [east - head, y1 - head, 0],
    ];
    const colour = this.options.dark ? "#8d95a1" : "#5b626c";
    this.part("axes", [linesOf([...pairs(along), ...pairs(across)], { colour, width: 1.6 })]);
  }

  private placeGrips(): void {
    const { field } = this;
    const isShown = field && this.row >= 0 && this.tools.tool.name === "select";
    this.grips.set(isShown ? gripsOf(field, this.row, 0.11 * this.stage.radius) : []);
  }

  /* ---- a board for tools */

  spotAt(x: number, y: number, field: Field): Spot | null {
    const { origin, direction } = this.ray(x, y);
    const hit = onRay(field, origin.toArray() as Point, direction.toArray() as Point);
    return hit && { cell: hit.cell, point: hit.point };
  }

  planeAt(x: number, y: number, z: number): [number, number] | null {
    const point = this.ray(x, y).intersectPlane(new Plane(new Vector3(0, 0, 1), -z), new Vector3());
    return point && [point.x, point.y];
  }

  heightAt(x: number, y: number, [px, py]: Point): number {
    // The point of the upright line that is nearest to the ray: both are seen at the same pixel, or nearly so.
    const { origin, direction } = this.ray(x, y);
    const flat = direction.x ** 2 + direction.y ** 2;
    const along = ((px - origin.x) * direction.x + (py - origin.y) * direction.y) / Math.max(flat, 1e-6);
    return origin.z + along * direction.z;
  }

  gripAt(x: number, y: number, reach: number): Grip | null {
    return this.grips.at(x, y, reach, (point) => this.pixel(point));
  }

  mark(spot: Spot | null): void {
    const { field } = this;
    const isSame = String(spot?.cell) === String(this.marked?.cell) && this.markedIn === field;
    [this.marked, this.markedIn] = [spot, field];
    if (isSame) return;
    this.label.hidden = !spot;
    if (spot && field) {
      const [i, j] = spot.cell;
      this.part("mark", [linesOf(lifted(outline(field, [[i, j]]), field), { colour: "#ffffff", width: 2.5 })]);
      this.label.textContent = field.hover(spot.cell, spot.point).label;
    } else this.part("mark", []);
    this.ask();
  }

  preview(preview: Preview | null): void {
    const { field } = this;
    if (!preview || !field) this.part("preview", []);
    else if (preview.level === null || preview.level < 0) {
      const colour = preview.level === null ? ACCENT : BAD;
      this.part("preview", [linesOf(lifted(outline(field, preview.cells), field), { colour, width: 3, hidden: true })]);
    } else {
      const height = preview.level * field.step;
      const color = field.colourOf(preview.level);
      const material = new MeshLambertMaterial({ color, transparent: true, opacity: 0.72 });
      const boxes = new InstancedMesh(new BoxGeometry(1, 1, 1).translate(0, 0, 0.5), material, preview.cells.length);
      const squares = preview.cells.flatMap((cell) => squareOf(field, cell, height));
      const lines = linesOf(squares, { colour: "#ffffff", width: 1.5, hidden: true });
      preview.cells.forEach(([i, j], k) => {
        const size = new Vector3(1.01 * field.width, 1.01 * field.width, height + 0.02 * field.width);
        const [x, y] = field.top(i, j);
        boxes.setMatrixAt(k, new Matrix4().makeScale(size.x, size.y, size.z).setPosition(x, y, 0));
      });
      boxes.frustumCulled = false;
      this.part("preview", [boxes, lines]);
    }
    this.ask();
  }

  lets(camera: boolean, isEditing: boolean): void {
    const { controls } = this;
    const [left, right] = [camera ? MOUSE.ROTATE : null, isEditing ? MOUSE.ROTATE : MOUSE.PAN];
    controls.mouseButtons = { LEFT: left, MIDDLE: MOUSE.PAN, RIGHT: right };
    controls.touches = { ONE: camera ? TOUCH.ROTATE : null, TWO: TOUCH.DOLLY_PAN };
  }

  turn(right: number, up: number): void {
    const { camera, target } = this.stage;
    const arm = camera.position.clone().sub(target);
    const length = arm.length();
    const round = Math.atan2(arm.y, arm.x) - 0.12 * right;
    const rise = Math.min(1.56, Math.max(0.03, Math.asin(arm.z / length) + 0.08 * up));
    arm.set(Math.cos(round) * Math.cos(rise), Math.sin(round) * Math.cos(rise), Math.sin(rise)).multiplyScalar(length);
    camera.position.copy(target).add(arm);
    this.controls.update();
  }

  zoom(nearer: number): void {
    const { camera, target } = this.stage;
    camera.position.sub(target).multiplyScalar(nearer).add(target);
    this.controls.update();
  }

  towards(right: number, up: number): Place {
    // To the nearest quarter of a turn, "right" on the screen is a direction on the map.
    const quarters = Math.round((this.controls.getAzimuthalAngle() / Math.PI) * 2);
    const [cos, sin] = [Math.round(Math.cos((quarters * Math.PI) / 2)), Math.round(Math.sin((quarters * Math.PI) / 2))];
    return [right * cos - up * sin, right * sin + up * cos];
  }

  private ray(x: number, y: number) {
    const caster = new Raycaster();
    this.stage.camera.updateMatrixWorld();
    const place = new Vector2((2 * x) / this.canvas.clientWidth - 1, 1 - (2 * y) / this.canvas.clientHeight);
    caster.setFromCamera(place, this.stage.camera);
    return caster.ray;
  }

  /* Where a point is seen, in CSS pixels. */
  pixel(point: Point): [number, number] {
    const { x, y } = new Vector3(...point).project(this.stage.camera);
    return [((x + 1) / 2) * this.canvas.clientWidth, ((1 - y) / 2) * this.canvas.clientHeight];
  }

  /* Where the middle of a cell's top is seen, in CSS pixels. */
  pixelOf(i: number, j: number): [number, number] {
    this.stage.camera.updateMatrixWorld();
    return this.pixel(this.field!.top(i, j));
  }

  /* The cell that is seen at a pixel; null beside the map. */
  cellAt(x: number, y: number): Place | null {
    return this.field && (this.spotAt(x, y, this.field)?.cell ?? null);
  }

  /* Where each handle is seen, by the end that it moves. */
  handles(): Record<string, [number, number]> {
    return Object.fromEntries(this.grips.grips.map(({ end, point }) => [end, this.pixel(point)]));
  }

  /* ---- drawing */

  private resize(): void {
    if (!this.host.clientWidth || !this.host.clientHeight) return;
    this.size(this.host.clientWidth, this.host.clientHeight);
    if (!this.isSized && this.field) this.look(this.from); // all of the map, which was shown before there was a size
    this.isSized = true;
    this.draw(1);
  }

  private size(width: number, height: number): void {
    this.renderer.setSize(width, height, false);
    this.stage.camera.aspect = width / height;
    this.stage.camera.updateProjectionMatrix();
  }

  /* Draw what is printed: browsers keep no picture that was shown on the screen. */
  private readonly print = (): void => this.draw(1);

  /* Draw before long; several wishes are one picture. It is drawn quickly, and in full once nothing changes. */
  private ask(): void {
    this.isWanted = true;
    clearTimeout(this.resting);
    if (this.scale < 1) this.resting = window.setTimeout(() => this.finish(1), REST);
    if (this.frame || this.isBusy) return;
    this.frame = requestAnimationFrame(() => {
      this.frame = 0;
      this.isWanted = false;
      this.finish(this.scale);
    });
  }

  /* Draw, and wait until the picture is finished before the next is begun; after a slow one, it has fewer pixels. */
  private finish(scale: number): void {
    this.draw(scale);
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    const sync = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    if (!sync) return;
    gl.flush();
    const began = performance.now();
    this.isBusy = true;
    const poll = () => {
      const isFinished = gl.isContextLost() || gl.getSyncParameter(sync, gl.SYNC_STATUS) === gl.SIGNALED;
      if (!isFinished) return void setTimeout(poll, 3);
      gl.deleteSync(sync);
      this.isBusy = false;
      const took = performance.now() - began;
      if (scale !== this.scale) return void (this.isWanted && this.ask());
      if (took > SLOW) this.scale = Math.max(0.4, 0.8 * this.scale);
      else if (took < SLOW / 2.5) this.scale = Math.min(1, 1.1 * this.scale);
      if (this.isWanted) this.ask();
    };
    poll();
  }

  private draw(scale: number): void {
    if (!this.field || !this.host.clientWidth) return;
    const ratio = Math.min(window.devicePixelRatio, 2) * scale;
    if (Math.abs(this.renderer.getPixelRatio() - ratio) > 1e-6) this.renderer.setPixelRatio(ratio);
    this.stage.render(this.renderer);
    this.grips.place((point) => this.pixel(point));
    this.axes.forEach((label, k) => this.ends[k] && moveTo(label, ...shifted(this.pixel(this.ends[k]), -4, -7)));
    if (this.marked) moveTo(this.label, ...shifted(this.pixel(this.field.top(...this.marked.cell)), 14, -30));
  }
}

function shifted([x, y]: [number, number], right: number, down: number): [number, number] {
  return [x + right, y + down];
}

/* Points a little above the blocks, so that lines are not half in them. */
function lifted(points: Point[], field: Field): Point[] {
  return points.map(([x, y, z]) => [x, y, z + 0.015 * field.width]);
}

function squareOf(field: Field, [i, j]: Place, z: number): Point[] {
  const above = z + 0.02 * field.width;
  const corners = [[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]];
  return pairs(corners.map(([a, b]): Point => [field.x(i + a), field.y(j + b), above]));
}

let studio: { stage: Stage; renderer: WebGLRenderer } | null = null;
let queue: Promise<unknown> = Promise.resolve();

/* A small picture of a map, for galleries; all are drawn by one renderer, one after another. */
export function thumbnail(scene: SceneData, width: number, height: number, dark = false): Promise<Blob> {
  const made = queue.then(async () => {
    studio ??= { stage: new Stage(), renderer: rendererOf(document.createElement("canvas")) };
    const { stage, renderer } = studio;
    renderer.setSize(width, height, false);
    stage.camera.aspect = width / height;
    stage.dress({ dark, grid: true });
    stage.show(new Field(scene), { look: "recipe", dark });
    stage.look("oblique");
    stage.render(renderer);
    const canvas = renderer.domElement;
    return new Promise<Blob>((done, failed) =>
      canvas.toBlob((blob) => (blob ? done(blob) : failed(new Error(`no picture of ${scene.name}`)))),
    );
  });
  queue = made.catch(() => null);
  return made;
}
