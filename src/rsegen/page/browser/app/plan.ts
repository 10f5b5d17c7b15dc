/* The plan: north up; cells are counted below and on the left, metres above and on the right. Tools work as in 3D. */

import { ACCENT, BAD, GOOD, MARKS, START, TRAILS, TROUBLE } from "./colours";
import { Field, rgb, type Place, type Point } from "./field";
import { Ink, LEGIBLE, type Box, type Pixel } from "./ink";
import { poseAt } from "./models";
import { END, endsOf, ofPoses, ofReach, painted, type Overlay } from "./overlay";
import type { Playback, DrawnPose, PoseMap, DrawnCrossing, DrawnReach, RobotShapes, SceneData, DrawnWay } from "./protocol";
import { Grips, Tools, add, cellsBetween, gripsOf, moveTo } from "./tools";
import type { Board, Grip, Preview, Spot } from "./tools";
import type { Options, Tool, View, ViewEvents } from "./views";
import "./views.css";

const MARGINS = { left: 34, right: 44, top: 26, bottom: 26 };
/* The size of numbers, CSS pixels: on a screen of many pixels they grow as the rest of the page. */
const textSize = () => 11 * (parseFloat(getComputedStyle(document.documentElement).getPropertyValue("--small")) / 11.5 || 1);
const NARROW = 210; // CSS pixels below which there are no margins, and so no numbers

/* What lies over the map. */
interface Shown {
  preview?: Preview | null;
  ghost?: Field | null; // with an obstacle that is not added yet, the row ghostRow
  ghostRow: number;
  drawing?: RobotShapes | null;
  pose?: DrawnPose | null;
  poses?: Overlay | null;
  reach?: DrawnReach | null;
  crossing?: DrawnCrossing | null;
  way?: DrawnWay | null;
  start?: [number, number] | null;
  playback?: Playback | null;
  drawings: Map<string, RobotShapes>;
  second: number;
}

export class Plan implements View, Board {
  field: Field | null = null;
  readonly canvas = document.createElement("canvas");
  private readonly tools: Tools;
  readonly name = "Plan, north up";
  readonly moved = "arrow keys move it";
  readonly grips: Grips;
  private readonly label: HTMLElement;
  private readonly sizes: ResizeObserver;
  private readonly ends = new AbortController();
  private options: Options = { look: "recipe", grid: true, axes: true, dark: false };
  private content: HTMLCanvasElement | null = null; // a pixel for each cell
  private row = -1;
  private marked: Spot | null = null;
  private readonly shown: Shown = { ghostRow: -1, drawings: new Map(), second: 0 };
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
    this.draws({ ghost: scene && new Field(scene), ghostRow: row });
  }

  robot(drawing: RobotShapes | null, pose: DrawnPose | null): void {
    this.draws({ drawing, pose });
  }

  poseMap(map: PoseMap | null, shown: "tilt" | "margin" | "reason"): void {
    this.draws({ poses: map && ofPoses(map, shown) });
  }

  reach(reach: DrawnReach | null, crossing?: DrawnCrossing | null): void {
    this.draws({ reach, crossing });
  }

  way(way: DrawnWay | null, start: [number, number] | null): void {
    this.draws({ way, start });
  }

  play(playback: Playback | null, drawings: Map<string, RobotShapes>): void {
    this.draws({ playback, drawings, second: 0 });
  }

  at(second: number): void {
    this.draws({ second });
  }

  private draws(part: Partial<Shown>): void {
    Object.assign(this.shown, part);
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
    this.draws({ preview });
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
    const times = textSize() / 11;
    if (!this.options.axes || Math.min(width, height) < NARROW * times) return { left: 2, right: 2, top: 2, bottom: 2 };
    return { left: MARGINS.left * times, right: MARGINS.right * times, top: MARGINS.top * times, bottom: MARGINS.bottom * times };
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
    this.label.hidden = !this.marked || !this.field || this.field.width * this.scale >= LEGIBLE || Math.min(width, height) < NARROW;
    if (this.marked && this.field) {
      this.label.textContent = this.field.hover(this.marked.cell, this.marked.point).label;
      const [x, y] = this.pixel(this.marked.point);
      moveTo(this.label, Math.min(x + 12, width - 70), Math.max(2, y - 28));
    }
  }

  private paint(pen: CanvasRenderingContext2D, width: number, height: number): void {
    pen.clearRect(0, 0, width, height);
    const { field, content } = this;
    if (!field || !content) return;
    this.fit(width, height);
    const { left, right, top, bottom } = this.margins(width, height);
    const box: Box = [left, top, width - left - right, height - top - bottom];
    const [x, y] = this.centre(width, height);
    const ink = new Ink(pen, field, [x - this.middle[0] * this.scale, y + this.middle[1] * this.scale], this.scale);
    pen.save();
    ink.clip(box);
    pen.imageSmoothingEnabled = ink.size < 1;
    ink.picture(content, [field.x(0), field.y(0)], [field.nX * field.width, field.nY * field.width]);
    const { poses, reach } = this.shown;
    const over = poses ?? (reach && ofReach(reach, field.scene));
    if (over) ink.picture(over.canvas, over.low, over.size);
    if (this.options.grid) ink.grid();
    ink.heights(box);
    this.drawObstacle(ink, field);
    this.drawWays(ink);
    this.drawDrive(ink);
    this.drawRobot(ink);
    if (this.marked) ink.outline([this.marked.cell], "#ffffff", 3, "#000000");
    pen.restore();
    if (left > 2) ink.numbers(box, this.options.dark, textSize());
  }

  /* The selected obstacle, one that is not added yet, and what a brush is about to change. */
  private drawObstacle(ink: Ink, field: Field): void {
    const { ghost, ghostRow, preview } = this.shown;
    if (ghost) {
      const cells = ghost.cellsOf(ghostRow);
      ink.pen.globalAlpha = 0.75;
      ink.fill(cells, (cell) => ghost.material(...cell).colour);
      ink.pen.globalAlpha = 1;
      ink.outline(cells, ACCENT, 2);
    }
    if (this.row >= 0) {
      ink.pen.setLineDash([5, 4]);
      ink.outline(cellsBetween(field, this.row), "#ffffff", 1.5, "#000000");
      ink.pen.setLineDash([]);
      ink.outline(field.cellsOf(this.row), ACCENT, 2.5, "#ffffff");
    }
    if (!preview) return;
    const { cells, level } = preview;
    if (level !== null && level >= 0) ink.fill(cells, () => field.colourOf(level));
    ink.outline(cells, ACCENT, 2, "#ffffff");
  }

  private drawWays(ink: Ink): void {
    const { reach, crossing, way, start } = this.shown;
    const size = Math.max(3, Math.min(7, 0.3 * ink.size));
    (crossing ?? reach)?.ways.forEach(({ points, crosses }) => ink.line(points, crosses ? START : TROUBLE, 3));
    reach?.spots.forEach(({ x, y, name }) => ink.named([x, y], size, name));
    endsOf(crossing).forEach((end) => ink.named(end, size, END));
    const poses = way?.poses ?? [];
    if (start && !poses.length) ink.named(start, size, "S");
    if (!poses.length) return;
    ink.line(poses, "#ffffff", 6);
    ink.line(poses, START, 3.5);
    way!.events.forEach(({ at }) => poses[at] && ink.disc(poses[at], 0.8 * size, TROUBLE));
    ink.named(poses[0], size, "S");
    ink.named(poses[poses.length - 1], size, "G");
  }

  /* A drive that is played: what its robots have driven, where something happened, and where they are. */
  private drawDrive(ink: Ink): void {
    const { playback, drawings, second: now } = this.shown;
    for (const [k, { robot, seconds, poses, events }] of (playback?.robots ?? []).entries()) {
      if (!poses.length) continue;
      const colour = TRAILS[k % TRAILS.length];
      ink.pen.globalAlpha = 0.4;
      ink.line(poses, colour, 1.5);
      ink.pen.globalAlpha = 1;
      ink.line(poses.filter((_, n) => seconds[n] <= now), colour, 3);
      for (const { second, kind } of events) {
        ink.pen.globalAlpha = second <= now ? 1 : 0.4;
        ink.disc(poseAt(seconds, poses, second).position.toArray(), kind === "contact" ? 2.5 : 4, MARKS[kind]);
      }
      ink.pen.globalAlpha = 1;
      const { position, rotation: { x, y, z, w } } = poseAt(seconds, poses, now);
      const yaw = Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
      const drawing = drawings.get(robot);
      if (drawing) ink.footprint(position.toArray(), yaw, drawing, colour);
      else ink.disc(position.toArray(), 5, colour);
    }
  }

  /* The robot at rest, with its contacts, its support polygon and its centre of mass. */
  private drawRobot(ink: Ink): void {
    const { pose, drawing } = this.shown;
    if (!pose || !drawing) return;
    const colour = pose.stands && pose.holds ? GOOD : BAD;
    ink.footprint([pose.x, pose.y], pose.yaw, drawing, colour);
    if (pose.polygon.length > 2) {
      ink.line([...pose.polygon, pose.polygon[0]], colour, 1.5);
      ink.pen.fillStyle = `${colour}44`;
      ink.pen.fill();
      ink.disc(pose.centre, 3.5, "#1f2328");
    }
    for (const contact of pose.contacts) ink.disc(contact, 2.5, colour);
  }
}

function pictureOf(field: Field): HTMLCanvasElement {
  const colours = field.palette.map(({ colour }) => [...rgb(colour), 255]);
  return painted(field.nX, field.nY, (i, j) => colours[field.content[field.at(i, j)]]);
}
