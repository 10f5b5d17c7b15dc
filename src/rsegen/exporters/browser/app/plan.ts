/* The plan: north up; cells are counted below and on the left, metres above and on the right. Tools work as in 3D. */

import { ACCENT, BAD, GOOD, START, TRAILS, TROUBLE } from "./colours";
import { Field, lettered, metres, outline, rgb, type Place, type Point } from "./field";
import { boundsOf, poseAt } from "./models";
import { ofPoses, ofReach, painted, type Overlay } from "./overlay";
import type { Playback, Pose, PoseMap, Reach, RobotDrawing, SceneData, Way } from "./protocol";
import { Grips, Tools, add, cellsBetween, gripsOf, moveTo } from "./tools";
import type { Board, Grip, Preview, Spot } from "./tools";
import type { Options, Tool, View, ViewEvents } from "./views";
import "./views.css";

const MARGINS = { left: 34, right: 44, top: 26, bottom: 26 };
const NARROW = 210; // CSS pixels below which there are no margins, and so no numbers
const LEGIBLE = 17; // CSS pixels that a cell must have so that its height is written into it
const LINED = 5; // and so that it has an outline

export function createPlan(host: HTMLElement, on: ViewEvents): Plan {
  return new Plan(host, on);
}

type Pixel = [number, number];
type Pen = CanvasRenderingContext2D;

export class Plan implements View, Board {
  field: Field | null = null;
  readonly canvas = document.createElement("canvas");
  private readonly tools: Tools;
  readonly grips: Grips;
  private readonly label: HTMLElement;
  private readonly sizes: ResizeObserver;
  private readonly ends = new AbortController();
  private options: Options = { look: "recipe", grid: true, axes: true, dark: false };
  private content: HTMLCanvasElement | null = null; // a pixel for each cell
  private row = -1;
  private marked: Spot | null = null;
  private shownPreview: Preview | null = null;
  private shownGhost: Field | null = null;
  private ghostRow = -1;
  private drawing: RobotDrawing | null = null;
  private pose: Pose | null = null;
  private poses: Overlay | null = null;
  private shownReach: Reach | null = null;
  private shownWay: Way | null = null;
  private start: [number, number] | null = null;
  private playback: Playback | null = null;
  private drawings = new Map<string, RobotDrawing>();
  private second = 0;
  private zoomed = 1; // times as large as where the whole map is seen
  private middle: [number, number] = [0, 0]; // metres, in the middle of the canvas
  private scale = 1; // CSS pixels of a metre
  private frame = 0;
  private pans = true;
  private fingers = new Map<number, Pixel>();

  constructor(readonly host: HTMLElement, on: ViewEvents) {
    host.classList.add("view");
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "application");
    this.canvas.setAttribute("aria-label", "Plan: arrow keys move it, plus and minus zoom");
    host.append(this.canvas);
    this.tools = new Tools(this, on);
    this.grips = new Grips(host);
    this.label = add(host, "tag");
    this.label.hidden = true;
    this.sizes = new ResizeObserver(() => this.draw());
    this.sizes.observe(host);
    const { signal } = this.ends;
    this.canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false, signal });
    const put = (event: PointerEvent) => this.fingers.set(event.pointerId, [event.clientX, event.clientY]);
    this.canvas.addEventListener("pointerdown", put, { signal });
    this.canvas.addEventListener("pointermove", (event) => this.drag(event), { signal });
    for (const name of ["pointerup", "pointercancel", "pointerleave"] as const) {
      this.canvas.addEventListener(name, (event) => this.fingers.delete(event.pointerId), { signal });
    }
  }

  /* ---- what is shown */

  show(scene: SceneData | null): void {
    const before = this.field;
    this.field = scene && new Field(scene);
    this.content = this.field && pictureOf(this.field);
    if (!this.field?.isLike(before)) this.look();
    this.tools.shown();
    if (this.marked && !this.field?.has(...this.marked.cell)) this.mark(null);
    this.select(this.row);
  }

  set(options: Partial<Options>): void {
    Object.assign(this.options, options);
    this.host.toggleAttribute("data-dark", this.options.dark);
    this.ask();
  }

  tool(tool: Tool): void {
    this.tools.set(tool);
    this.lets(true);
    this.placeGrips();
  }

  select(row: number): void {
    this.row = row;
    this.placeGrips();
  }

  ghost(scene: SceneData | null, row: number): void {
    this.shownGhost = scene && new Field(scene);
    this.ghostRow = row;
    this.ask();
  }

  robot(drawing: RobotDrawing | null, pose: Pose | null): void {
    [this.drawing, this.pose] = [drawing, pose];
    this.ask();
  }

  poseMap(map: PoseMap | null, shown: "tilt" | "margin" | "reason"): void {
    this.poses = map && ofPoses(map, shown);
    this.ask();
  }

  reach(reach: Reach | null): void {
    this.shownReach = reach;
    this.ask();
  }

  way(way: Way | null, start: [number, number] | null): void {
    [this.shownWay, this.start] = [way, start];
    this.ask();
  }

  play(playback: Playback | null, drawings: Map<string, RobotDrawing>): void {
    [this.playback, this.drawings, this.second] = [playback, drawings, 0];
    this.ask();
  }

  at(second: number): void {
    this.second = second;
    this.ask();
  }

  /* Show the whole map, from whichever side the 3D view looks. */
  look(): void {
    [this.zoomed, this.middle] = [1, [0, 0]];
    this.ask();
  }

  async picture(width: number, height: number): Promise<Blob> {
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [width, height];
    this.paint(canvas.getContext("2d")!, width, height);
    this.ask();
    return new Promise((done, failed) =>
      canvas.toBlob((made) => (made ? done(made) : failed(new Error("the browser made no picture"))), "image/png"),
    );
  }

  dispose(): void {
    cancelAnimationFrame(this.frame);
    this.sizes.disconnect();
    this.tools.dispose();
    this.ends.abort();
    this.grips.dispose();
    this.canvas.remove();
    this.label.remove();
  }

  /* ---- a board for tools */

  spotAt(x: number, y: number, field: Field): Spot | null {
    const [a, b] = this.metres([x, y]);
    const cell = field.place(a, b);
    return field.has(...cell) ? { cell, point: [a, b, field.height(...cell)] } : null;
  }

  planeAt(x: number, y: number): [number, number] {
    return this.metres([x, y]);
  }

  heightAt(): number {
    return 0; // a plan has no heights to drag
  }

  gripAt(x: number, y: number, reach: number): Grip | null {
    return this.grips.at(x, y, reach, (point) => this.pixel(point));
  }

  mark(spot: Spot | null): void {
    this.marked = spot;
    this.ask();
  }

  preview(preview: Preview | null): void {
    this.shownPreview = preview;
    this.ask();
  }

  lets(camera: boolean): void {
    this.pans = camera;
  }

  turn(right: number, up: number): void {
    this.pan((-right * this.canvas.clientWidth) / 8, (up * this.canvas.clientHeight) / 8);
  }

  zoom(nearer: number): void {
    this.zoomAt([this.canvas.clientWidth / 2, this.canvas.clientHeight / 2], 1 / nearer);
  }

  towards(right: number, up: number): Place {
    return [right, up];
  }

  private placeGrips(): void {
    const isShown = this.field && this.row >= 0 && this.tools.tool.name === "select";
    this.grips.set(isShown ? gripsOf(this.field!, this.row, 0).filter(({ end }) => end !== "raise") : []);
    this.ask();
  }

  /* Where a point is, in CSS pixels. */
  pixel([x, y]: Point | [number, number]): Pixel {
    const [left, top] = this.centre(this.canvas.clientWidth, this.canvas.clientHeight);
    return [left + (x - this.middle[0]) * this.scale, top - (y - this.middle[1]) * this.scale];
  }

  private metres([x, y]: Pixel): [number, number] {
    const [left, top] = this.centre(this.canvas.clientWidth, this.canvas.clientHeight);
    return [(x - left) / this.scale + this.middle[0], (top - y) / this.scale + this.middle[1]];
  }

  pixelOf(i: number, j: number): Pixel {
    return this.pixel(this.field!.top(i, j));
  }

  cellAt(x: number, y: number): Place | null {
    return this.field && (this.spotAt(x, y, this.field)?.cell ?? null);
  }

  handles(): Record<string, Pixel> {
    return Object.fromEntries(this.grips.grips.map(({ end, point }) => [end, this.pixel(point)]));
  }

  /* ---- zoom and pan */

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    this.zoomAt([event.offsetX, event.offsetY], Math.exp(-0.0016 * event.deltaY));
  }

  private zoomAt(pixel: Pixel, times: number): void {
    if (!this.field) return;
    const before = this.metres(pixel);
    const most = Math.max(1, 90 / ((this.scale / this.zoomed) * this.field.width));
    this.zoomed = Math.min(most, Math.max(1, this.zoomed * times));
    this.fit(this.canvas.clientWidth, this.canvas.clientHeight);
    const after = this.metres(pixel);
    this.middle = [this.middle[0] + before[0] - after[0], this.middle[1] + before[1] - after[1]];
    this.ask();
  }

  private drag(event: PointerEvent): void {
    const from = this.fingers.get(event.pointerId);
    if (!from) return;
    const to: Pixel = [event.clientX, event.clientY];
    this.fingers.set(event.pointerId, to);
    const other = [...this.fingers].find(([id]) => id !== event.pointerId)?.[1];
    if (other) {
      const { left, top } = this.canvas.getBoundingClientRect();
      const apart = ([x, y]: Pixel) => Math.hypot(x - other[0], y - other[1]);
      this.pan((to[0] - from[0]) / 2, (to[1] - from[1]) / 2);
      this.zoomAt([(to[0] + other[0]) / 2 - left, (to[1] + other[1]) / 2 - top], apart(to) / Math.max(1, apart(from)));
    } else if (this.pans) this.pan(to[0] - from[0], to[1] - from[1]);
  }

  private pan(right: number, down: number): void {
    this.middle = [this.middle[0] - right / this.scale, this.middle[1] + down / this.scale];
    this.ask();
  }

  private margins(width: number, height: number): typeof MARGINS {
    return this.options.axes && Math.min(width, height) >= NARROW ? MARGINS : { left: 2, right: 2, top: 2, bottom: 2 };
  }

  private centre(width: number, height: number): Pixel {
    const { left, right, top, bottom } = this.margins(width, height);
    return [(left + width - right) / 2, (top + height - bottom) / 2];
  }

  /* The scale at which the map fits, times the zoom; the middle stays where the map is seen. */
  private fit(width: number, height: number): void {
    const field = this.field!;
    const { left, right, top, bottom } = this.margins(width, height);
    const [across, along] = [width - left - right, height - top - bottom];
    const [wide, high] = [field.nX * field.width, field.nY * field.width];
    this.scale = this.zoomed * Math.max(1e-3, Math.min(across / wide, along / high));
    this.middle = this.middle.map((at, axis) => {
      const free = Math.max(0, ([wide, high][axis] - [across, along][axis] / this.scale) / 2);
      return Math.min(free, Math.max(-free, at));
    }) as [number, number];
  }

  /* ---- drawing */

  private ask(): void {
    if (!this.frame) this.frame = requestAnimationFrame(() => this.draw());
  }

  private draw(): void {
    cancelAnimationFrame(this.frame);
    this.frame = 0;
    const [width, height] = [this.host.clientWidth, this.host.clientHeight];
    if (!width || !height) return;
    const sharp = window.devicePixelRatio || 1;
    if (this.canvas.width !== Math.round(width * sharp) || this.canvas.height !== Math.round(height * sharp)) {
      [this.canvas.width, this.canvas.height] = [Math.round(width * sharp), Math.round(height * sharp)];
    }
    const pen = this.canvas.getContext("2d")!;
    pen.setTransform(sharp, 0, 0, sharp, 0, 0);
    this.paint(pen, width, height);
    this.host.toggleAttribute("data-small", Math.min(width, height) < NARROW);
    this.grips.place((point) => this.pixel(point));
    const isLegible = this.field && this.field.width * this.scale >= LEGIBLE;
    this.label.hidden = !this.marked || !this.field || isLegible || Math.min(width, height) < NARROW;
    if (this.marked && this.field) {
      this.label.textContent = this.field.hover(this.marked.cell, this.marked.point).label;
      const [x, y] = this.pixel(this.marked.point);
      moveTo(this.label, Math.min(x + 12, width - 70), Math.max(2, y - 28));
    }
  }

  private paint(pen: Pen, width: number, height: number): void {
    pen.clearRect(0, 0, width, height);
    const { field, content } = this;
    if (!field || !content) return;
    this.fit(width, height);
    const { left, right, top, bottom } = this.margins(width, height);
    const [centreX, centreY] = this.centre(width, height);
    const { scale, middle } = this;
    const at: At = ([x, y]) => [centreX + (x - middle[0]) * scale, centreY - (y - middle[1]) * scale];
    const box: [number, number, number, number] = [left, top, width - left - right, height - top - bottom];
    pen.save();
    pen.beginPath();
    // Ways that begin beside the map do not run into the numbers.
    const [[west, south], [east, north]] = [at([field.x(0), field.y(0)]), at([field.x(field.nX), field.y(field.nY)])];
    const [x0, y0] = [Math.max(left, west) - 2, Math.max(top, north) - 2];
    pen.rect(x0, y0, Math.min(width - right, east) + 2 - x0, Math.min(height - bottom, south) + 2 - y0);
    pen.clip();
    pen.imageSmoothingEnabled = field.width * this.scale < 1;
    this.place(pen, at, content, [field.x(0), field.y(0)], [field.nX * field.width, field.nY * field.width]);
    const over = this.poses ?? (this.shownReach && ofReach(this.shownReach, field.scene));
    if (over) this.place(pen, at, over.canvas, over.low, over.size);
    if (this.options.grid) this.drawLines(pen, at, field);
    this.drawHeights(pen, at, field, box);
    this.drawObstacle(pen, at, field);
    this.drawPreview(pen, at, field);
    this.drawWays(pen, at);
    this.drawRobots(pen, at);
    if (this.marked) this.strokeCells(pen, at, field, [this.marked.cell], "#ffffff", 3, "#000000");
    pen.restore();
    if (left > 2) this.drawNumbers(pen, at, field, box);
  }

  private place(pen: Pen, at: At, canvas: HTMLCanvasElement, low: [number, number], size: [number, number]): void {
    const [x, y] = at([low[0], low[1] + size[1]]);
    pen.drawImage(canvas, x, y, size[0] * this.scale, size[1] * this.scale);
  }

  private drawLines(pen: Pen, at: At, field: Field): void {
    const size = field.width * this.scale;
    if (size < LINED) return;
    const [[west, south], [east, north]] = [at([field.x(0), field.y(0)]), at([field.x(field.nX), field.y(field.nY)])];
    pen.strokeStyle = `rgb(0 0 0 / ${size >= LEGIBLE ? 0.3 : 0.18})`;
    pen.lineWidth = 1;
    pen.beginPath();
    for (let i = 0; i <= field.nX; i++) {
      pen.moveTo(west + i * size, south);
      pen.lineTo(west + i * size, north);
    }
    for (let j = 0; j <= field.nY; j++) {
      pen.moveTo(west, south - j * size);
      pen.lineTo(east, south - j * size);
    }
    pen.stroke();
  }

  private drawHeights(pen: Pen, at: At, field: Field, [left, top, wide, high]: number[]): void {
    const size = field.width * this.scale;
    if (size < LEGIBLE) return;
    const longest = field.palette.reduce((most, { label }) => Math.max(most, label.length), 1);
    const dark = new Map(field.palette.map((material) => [material, isDark(material.colour)]));
    pen.font = `${Math.min(15, size * 0.5, (size * 1.5) / longest)}px system-ui, sans-serif`;
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    for (let i = 0; i < field.nX; i++) {
      for (let j = 0; j < field.nY; j++) {
        const material = field.material(i, j);
        const [x, y] = at(field.top(i, j));
        if (material.level === null || x < left || y < top || x > left + wide || y > top + high) continue;
        pen.fillStyle = dark.get(material) ? "#ffffff" : "#000000";
        pen.fillText(material.label, x, y);
      }
    }
  }

  private drawObstacle(pen: Pen, at: At, field: Field): void {
    if (this.shownGhost) {
      const cells = this.shownGhost.cellsOf(this.ghostRow);
      pen.globalAlpha = 0.75;
      this.fillCells(pen, at, this.shownGhost, cells, (cell) => this.shownGhost!.material(...cell).colour);
      pen.globalAlpha = 1;
      this.strokeCells(pen, at, this.shownGhost, cells, ACCENT, 2);
    }
    if (this.row < 0) return;
    const cells = field.cellsOf(this.row);
    pen.setLineDash([5, 4]);
    this.strokeCells(pen, at, field, cellsBetween(field, this.row), "#ffffff", 1.5, "#000000");
    pen.setLineDash([]);
    this.strokeCells(pen, at, field, cells, ACCENT, 2.5, "#ffffff");
  }

  private drawPreview(pen: Pen, at: At, field: Field): void {
    if (!this.shownPreview) return;
    const { cells, level } = this.shownPreview;
    if (level !== null && level >= 0) this.fillCells(pen, at, field, cells, () => field.colourOf(level));
    this.strokeCells(pen, at, field, cells, ACCENT, 2, "#ffffff");
  }

  private fillCells(pen: Pen, at: At, field: Field, cells: Place[], colour: (cell: Place) => string): void {
    const size = field.width * this.scale;
    for (const cell of cells) {
      const [x, y] = at([field.x(cell[0]), field.y(cell[1] + 1)]);
      pen.fillStyle = colour(cell);
      pen.fillRect(x, y, size, size);
    }
  }

  /* Outline some cells, with a wider line below, so that it is seen on any colour. */
  private strokeCells(pen: Pen, at: At, field: Field, cells: Place[], colour: string, width: number, below = ""): void {
    const points = outline(field, cells);
    pen.beginPath();
    for (let k = 0; k < points.length; k += 2) {
      pen.moveTo(...at(points[k]));
      pen.lineTo(...at(points[k + 1]));
    }
    pen.lineCap = "round";
    const thin = Math.min(1, Math.max(0.4, (field.width * this.scale) / 12)); // where cells are small
    for (const [style, wide] of below ? [[below, width + 2], [colour, width]] as const : [[colour, width]] as const) {
      pen.strokeStyle = style;
      pen.lineWidth = thin * wide;
      pen.stroke();
    }
  }

  private drawWays(pen: Pen, at: At): void {
    const { shownReach, shownWay, start, field } = this;
    const size = Math.max(3, Math.min(7, 0.3 * field!.width * this.scale));
    shownReach?.ways.forEach(({ points, crosses }) => this.strokeLine(pen, at, points, crosses ? START : TROUBLE, 3));
    const named = (place: readonly number[], name: "S" | "G") =>
      lettered(pen, at([place[0], place[1]]), Math.max(8, 1.3 * size), name, name === "S" ? START : ACCENT);
    shownReach?.spots.forEach(({ x, y, name }) => named([x, y], name));
    if (start && !shownWay?.poses.length) named(start, "S");
    const poses = shownWay?.poses ?? [];
    if (!poses.length) return;
    this.strokeLine(pen, at, poses, "#ffffff", 6);
    this.strokeLine(pen, at, poses, START, 3.5);
    const mark = (k: number, radius: number, colour: string) =>
      poses[k] && disc(pen, at([poses[k][0], poses[k][1]]), radius, colour);
    shownWay!.events.forEach((event) => mark(event.at, 0.8 * size, TROUBLE));
    named(poses[0], "S");
    named(poses[poses.length - 1], "G");
  }

  private strokeLine(pen: Pen, at: At, points: readonly (readonly number[])[], colour: string, width: number): void {
    pen.beginPath();
    points.forEach(([x, y], k) => (k ? pen.lineTo(...at([x, y])) : pen.moveTo(...at([x, y]))));
    Object.assign(pen, { strokeStyle: colour, lineWidth: width, lineCap: "round", lineJoin: "round" });
    pen.stroke();
  }

  private drawRobots(pen: Pen, at: At): void {
    const { pose, drawing } = this;
    for (const [k, { robot, seconds, poses, events }] of (this.playback?.robots ?? []).entries()) {
      if (!poses.length) continue;
      const colour = TRAILS[k % TRAILS.length];
      pen.globalAlpha = 0.4;
      this.strokeLine(pen, at, poses, colour, 1.5);
      pen.globalAlpha = 1;
      this.strokeLine(pen, at, poses.filter((_, n) => seconds[n] <= this.second), colour, 3);
      for (const { second } of events) {
        const { position } = poseAt(seconds, poses, second);
        pen.globalAlpha = second <= this.second ? 1 : 0.4;
        disc(pen, at([position.x, position.y]), 4, BAD);
        pen.globalAlpha = 1;
      }
      const now = poseAt(seconds, poses, this.second);
      const { x, y, z, w } = now.rotation;
      const yaw = Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
      const drawn = this.drawings.get(robot);
      if (drawn) this.drawFootprint(pen, at, [now.position.x, now.position.y], yaw, drawn, colour);
      else disc(pen, at([now.position.x, now.position.y]), 5, colour);
    }
    if (!pose || !drawing) return;
    const colour = pose.stands && pose.holds ? GOOD : BAD;
    this.drawFootprint(pen, at, [pose.x, pose.y], pose.yaw, drawing, colour);
    if (pose.polygon.length > 2) {
      this.strokeLine(pen, at, [...pose.polygon, pose.polygon[0]], colour, 1.5);
      pen.fillStyle = `${colour}44`;
      pen.fill();
    }
    for (const [x, y] of pose.contacts) disc(pen, at([x, y]), 2.5, colour);
  }

  /* The robot from above, with a head that shows where it faces. */
  private drawFootprint(
    pen: Pen, at: At, [x, y]: [number, number], yaw: number, drawing: RobotDrawing, colour: string,
  ): void {
    const [cos, sin] = [Math.cos(yaw), Math.sin(yaw)];
    const turned = (a: number, b: number): [number, number] => [x + a * cos - b * sin, y + a * sin + b * cos];
    const [back, front, right, left] = boundsOf(drawing);
    const shoulder = front - 0.2 * (front - back);
    const tip = [front, (left + right) / 2];
    const corners = [[back, right], [shoulder, right], tip, [shoulder, left], [back, left], [back, right]];
    const points = corners.map(([along, across]) => turned(along, across));
    this.strokeLine(pen, at, points, "#ffffff", 4);
    this.strokeLine(pen, at, points, colour, 2.5);
    pen.fillStyle = `${colour}33`;
    pen.fill();
  }

  private drawNumbers(pen: Pen, at: At, field: Field, [left, top, wide, high]: number[]): void {
    const size = field.width * this.scale;
    const [west, south] = at([field.x(0), field.y(0)]);
    const [edgeX, edgeY] = [Math.min(left + wide, west + field.nX * size), Math.min(top + high, south)];
    const [startX, startY] = [Math.max(left, west), Math.max(top, south - field.nY * size)];
    const text = (
      value: string | number, x: number, y: number, textAlign: CanvasTextAlign, textBaseline: CanvasTextBaseline,
    ) => {
      Object.assign(pen, { textAlign, textBaseline });
      pen.fillText(String(value), x, y);
    };
    const isIn = (value: number, from: number, to: number) => value >= from - 0.5 && value <= to + 0.5;
    pen.font = "11px system-ui, sans-serif";
    pen.fillStyle = pen.strokeStyle = this.options.dark ? "#a9b1bc" : "#5b626c";
    const every = niceStep(22 / size, 1);
    field.blockX.forEach((block, i) => {
      const x = west + (i + 0.5) * size;
      if (block >= 0 && block % every === 0 && isIn(x, startX, edgeX)) text(block, x, edgeY + 5, "center", "top");
    });
    field.blockY.forEach((block, j) => {
      const y = south - (j + 0.5) * size;
      if (block >= 0 && block % every === 0 && isIn(y, startY, edgeY)) text(block, startX - 6, y, "right", "middle");
    });
    text("cell", Math.max(0, startX - 30), edgeY + 5, "left", "top");
    text("m", edgeX + 8, edgeY + 5, "left", "top");
    const step = niceStep(52 / this.scale, 0.01);
    pen.lineWidth = 1;
    pen.beginPath();
    for (const value of marks((field.nX * field.width) / 2, step)) {
      const [x] = at([value, 0]);
      if (!isIn(x, startX, edgeX)) continue;
      text(metres(value), x, startY - 7, "center", "bottom");
      pen.moveTo(x, startY - 5);
      pen.lineTo(x, startY - 1);
    }
    for (const value of marks((field.nY * field.width) / 2, step)) {
      const [, y] = at([0, value]);
      if (!isIn(y, startY, edgeY)) continue;
      text(metres(value), edgeX + 8, y, "left", "middle");
      pen.moveTo(edgeX + 1, y);
      pen.lineTo(edgeX + 5, y);
    }
    pen.stroke();
  }
}

type At = (point: Point | [number, number]) => Pixel;

function disc(pen: Pen, [x, y]: Pixel, radius: number, colour: string): void {
  pen.beginPath();
  pen.arc(x, y, radius, 0, 2 * Math.PI);
  pen.fillStyle = colour;
  pen.fill();
  pen.lineWidth = 1.5;
  pen.strokeStyle = "#ffffff";
  pen.stroke();
}

function pictureOf(field: Field): HTMLCanvasElement {
  const colours = field.palette.map(({ colour }) => [...rgb(colour), 255]);
  return painted(field.nX, field.nY, (i, j) => colours[field.content[field.at(i, j)]]);
}

function isDark(colour: string): boolean {
  const [red, green, blue] = rgb(colour);
  return 0.3 * red + 0.59 * green + 0.11 * blue < 128;
}

/* The multiples of a step from -half to half. */
function marks(half: number, step: number): number[] {
  const most = Math.floor(half / step + 1e-9);
  return Array.from({ length: 2 * most + 1 }, (_, k) => (k - most) * step);
}

/* The smallest of 1, 2, 5, 10, 20, ... times `least` that is not below `wanted`. */
function niceStep(wanted: number, least: number): number {
  for (let power = least; ; power *= 10) {
    for (const factor of [1, 2, 5]) if (factor * power >= wanted * (1 - 1e-9)) return factor * power;
  }
}
