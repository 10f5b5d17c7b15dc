/* What the mouse, fingers and keys do on a view: hovering, picking, drags of handles, strokes, new obstacles.

3D view and plan differ in how they see, not in what tools do: each is a Board, which says what is below a pixel and
draws marks. A drag is one gesture; Escape, or a second finger, ends it and takes back what it did, as far as it can.
*/

import { filled, line, rectangle, type Field, type Place, type Point } from "./field";
import type { Cell } from "./protocol";
import type { Tool, ViewEvents } from "./views";

export interface Spot { cell: Place; point: Point }
export type End = "first" | "last" | "both" | "raise";
export interface Grip { row: number; end: End; point: Point }

/* level: that the cells get; null: they are only outlined. */
export interface Preview { cells: Place[]; level: number | null }

export interface Board {
  readonly host: HTMLElement;
  readonly canvas: HTMLCanvasElement;
  readonly grips: Grips;
  readonly name: string; // "Plan"
  readonly moved: string; // "arrow keys move it"
  field: Field | null;
  spotAt(x: number, y: number, field: Field): Spot | null; // what is seen at a pixel
  planeAt(x: number, y: number, z: number): [number, number] | null; // where a pixel is on a level plane
  heightAt(x: number, y: number, point: Point): number; // of the place above or below a point that is nearest to a pixel
  gripAt(x: number, y: number, reach: number): Grip | null;
  mark(spot: Spot | null): void;
  preview(preview: Preview | null): void;
  lets(camera: boolean, isEditing: boolean): void; // whether a drag with the first button or finger moves the camera
  turn(right: number, up: number): void; // by keys
  zoom(nearer: number): void;
  towards(right: number, up: number): Place; // the direction on the map of an arrow key
}

type Drag =
  | { kind: "click"; spot: Spot | null; x: number; y: number }
  | { kind: "end"; row: number; end: "first" | "last" | "both"; z: number; apart: [number, number]; start: Cell; now: Cell }
  | { kind: "raise"; row: number; point: Point; from: number; start: number; now: number }
  | { kind: "stroke"; field: Field; now: Place; cells: Place[] }
  | { kind: "area"; field: Field; z: number; from: Place; to: Place };

const ARROWS: Record<string, Place | undefined> = {
  ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1],
};
const NEARER: Record<string, number | undefined> = { "+": 0.85, "=": 0.85, "-": 1 / 0.85 };
const STILL = 5; // CSS pixels that the mouse may move in a click
let gestures = 0;

/* What keys do on a view with the tools that work on cells. */
const BY_KEYS: Partial<Record<Tool["name"], string>> = {
  paint: "arrow keys go from cell to cell, Enter or a digit paints",
  draw: "arrow keys go from cell to cell, Enter sets the first cell and then the last",
  robot: "arrow keys move the robot, with Shift they turn it",
  way: "arrow keys go from cell to cell, Enter sets the start and then the goal",
};

export class Tools {
  tool: Tool = { name: "select" };
  private drag: Drag | null = null;
  private gesture = "";
  private pointers = new Set<number>();
  private cursor: Place | null = null; // of keys, with a tool that works on cells
  private corner: Place | null = null; // of an area that keys span from here to the cursor
  private keyed: { cell: Cell; levels: number; when: number } | null = null; // where keys have moved a handle
  private readonly ends = new AbortController();

  constructor(private readonly board: Board, private readonly on: ViewEvents) {
    const hear = <K extends keyof HTMLElementEventMap>(name: K, heard: (event: HTMLElementEventMap[K]) => void) =>
      board.host.addEventListener(name, heard, { capture: true, passive: false, signal: this.ends.signal });
    hear("pointerdown", (event) => this.down(event));
    hear("pointermove", (event) => this.move(event));
    hear("pointerup", (event) => this.up(event));
    hear("pointercancel", (event) => (this.up(event), this.cancel()));
    hear("pointerleave", (event) => event.target === board.canvas && this.hover(null));
    hear("keydown", (event) => this.key(event));
    hear("focusin", (event) => board.grips.of(event.target) && this.begin());
    hear("wheel", (event) => this.wheel(event));
  }

  dispose(): void {
    this.ends.abort();
  }

  set(tool: Tool): void {
    if (tool.name !== this.tool.name) this.cancel();
    this.tool = tool;
    if (tool.name === "select") this.cursor = null;
    const { canvas, name, moved } = this.board;
    canvas.setAttribute("aria-label", `${name}: ${BY_KEYS[tool.name] ?? moved}, plus and minus zoom`);
  }

  /* A new map is shown: what was only a preview is now there. */
  shown(): void {
    if (!this.drag) this.board.preview(null);
  }

  private pixel(event: MouseEvent): [number, number] {
    const { left, top } = this.board.canvas.getBoundingClientRect();
    return [event.clientX - left, event.clientY - top];
  }

  private spot(event: MouseEvent): Spot | null {
    return this.board.field && this.board.spotAt(...this.pixel(event), this.board.field);
  }

  private get isEditing(): boolean {
    return this.tool.name === "paint" || this.tool.name === "draw";
  }

  private down(event: PointerEvent): void {
    const { board, tool } = this;
    if (event.target !== board.canvas || !board.field) return;
    this.pointers.add(event.pointerId);
    if (this.pointers.size > 1 || event.button !== 0) {
      this.cancel();
      board.lets(true, this.isEditing);
      return;
    }
    const [x, y] = this.pixel(event);
    const grip = tool.name === "select" ? board.gripAt(x, y, event.pointerType === "touch" ? 24 : 14) : null;
    const spot = this.spot(event);
    this.begin();
    this.drag = grip ? this.grabbed(grip, x, y, board.field) : this.begun(spot, x, y, board.field);
    board.lets(this.drag?.kind === "click", this.isEditing);
    if (this.drag && this.drag.kind !== "click") board.canvas.setPointerCapture(event.pointerId);
    if (this.drag?.kind === "stroke") this.paint(this.drag, [this.drag.now]);
    if (this.drag?.kind === "area") this.outlined(this.drag.from, this.drag.to);
  }

  /* From now on, changes are undone together. */
  private begin(): void {
    this.gesture = `hand ${Date.now().toString(36)} ${++gestures}`;
    this.keyed = null;
  }

  private grabbed(grip: Grip, x: number, y: number, field: Field): Drag | null {
    const { board } = this;
    const { row, end, point } = grip;
    board.grips.held(grip);
    if (end === "raise") {
      const start = levelsOf(field, row);
      return { kind: "raise", row, point, from: board.heightAt(x, y, point), start, now: start };
    }
    const at = board.planeAt(x, y, point[2]) ?? [point[0], point[1]];
    const start = field.nearest(field.place(point[0], point[1]));
    return { kind: "end", row, end, z: point[2], apart: [point[0] - at[0], point[1] - at[1]], start, now: start };
  }

  private begun(spot: Spot | null, x: number, y: number, field: Field): Drag | null {
    const { tool, board, on } = this;
    if (!spot || !this.isEditing) return { kind: "click", spot, x, y };
    const block = field.block(spot.cell);
    if (tool.name === "draw" || (tool.name === "paint" && tool.shape === "rectangle")) {
      return { kind: "area", field, z: spot.point[2], from: spot.cell, to: spot.cell };
    }
    if (tool.name !== "paint") return null;
    if (tool.shape === "cells") return { kind: "stroke", field, now: spot.cell, cells: [] };
    if (tool.shape === "pick" && block) on.picked?.(field.material(...spot.cell).level!);
    if (tool.shape === "fill" && block) {
      const cells = filled(field, spot.cell);
      board.preview({ cells, level: tool.level });
      on.paint?.(blocksOf(field, cells), tool.level, this.gesture);
    }
    return null;
  }

  private move(event: PointerEvent): void {
    const { board, drag } = this;
    if (event.target !== board.canvas || !board.field) return;
    if (!drag || drag.kind === "click") {
      if (event.buttons === 0) this.hover(event);
      return;
    }
    const [x, y] = this.pixel(event);
    if (drag.kind === "raise") {
      const metres = board.heightAt(x, y, drag.point) - drag.from;
      this.raise(drag, drag.start + metres / board.field.step);
    } else if (drag.kind === "end") {
      const at = board.planeAt(x, y, drag.z);
      if (at) this.moveEnd(drag, board.field.nearest(board.field.place(at[0] + drag.apart[0], at[1] + drag.apart[1])));
    } else if (drag.kind === "stroke") {
      // The browser joins moves of the mouse; each is heard, and between them lie straight lines.
      const parts = event.getCoalescedEvents?.() ?? [];
      for (const part of parts.length ? parts : [event]) {
        const spot = board.spotAt(...this.pixel(part), drag.field);
        if (!spot) continue;
        this.paint(drag, line(drag.now, spot.cell));
        drag.now = spot.cell;
      }
    } else {
      const at = board.planeAt(x, y, drag.z);
      if (!at) return;
      const [i, j] = drag.field.place(...at);
      drag.to = [Math.min(drag.field.nX - 1, Math.max(0, i)), Math.min(drag.field.nY - 1, Math.max(0, j))];
      this.outlined(drag.from, drag.to);
    }
  }

  private up(event: PointerEvent): void {
    this.pointers.delete(event.pointerId);
    const { drag, board } = this;
    if (!drag || event.type !== "pointerup") return;
    this.drag = null;
    board.grips.held(null);
    if (drag.kind === "click") {
      const [x, y] = this.pixel(event);
      if (Math.hypot(x - drag.x, y - drag.y) <= STILL) this.click(drag.spot);
    } else if (drag.kind === "area") this.made(drag.field, drag.from, drag.to);
  }

  /* Draw an obstacle over an area, or paint it. */
  private made(field: Field, from: Place, to: Place): void {
    const { tool, on, board } = this;
    if (tool.name === "draw") {
      board.preview(null);
      on.draw?.(field.nearest(from), field.nearest(to));
    } else if (tool.name === "paint") on.paint?.(blocksOf(field, rectangle(from, to)), tool.level, this.gesture);
  }

  private click(spot: Spot | null): void {
    const { tool, on, board } = this;
    const field = board.field!;
    if (tool.name === "select") on.pick?.(spot ? field.owner(...spot.cell) : -1, spot && field.block(spot.cell));
    if (spot && tool.name === "robot") on.robotPut?.(spot.point[0], spot.point[1]);
    if (spot && tool.name === "way") on.wayPoint?.(spot.point[0], spot.point[1]);
  }

  private hover(event: PointerEvent | null): void {
    const { board, tool, on } = this;
    const spot = event && this.spot(event);
    board.mark(spot);
    on.hover?.(spot && board.field!.hover(spot.cell, spot.point));
    if (spot && tool.name === "robot") on.robotAt?.(spot.point[0], spot.point[1]);
    const grip = event && tool.name === "select" ? board.gripAt(...this.pixel(event), 14) : null;
    const over = grip ? (grip.end === "raise" ? "ns-resize" : "grab") : spot && this.isEditing ? "crosshair" : "";
    board.canvas.style.cursor = spot && tool.name !== "select" ? "crosshair" : over;
  }

  private raise(drag: Drag & { kind: "raise" }, wanted: number): void {
    const levels = Math.max(1, Math.round(wanted));
    if (levels === drag.now) return;
    drag.now = levels;
    this.on.raise?.(drag.row, levels, this.gesture);
  }

  private moveEnd(drag: Drag & { kind: "end" }, cell: Cell): void {
    if (cell[0] === drag.now[0] && cell[1] === drag.now[1]) return;
    drag.now = cell;
    this.on.moveEnd?.(drag.row, drag.end, cell, this.gesture);
  }

  private paint(drag: Drag & { kind: "stroke" }, cells: Place[]): void {
    if (this.tool.name !== "paint") return;
    const known = new Set(drag.cells.map(([i, j]) => drag.field.at(i, j)));
    const more = cells.filter(([i, j]) => !known.has(drag.field.at(i, j)) && drag.field.block([i, j]));
    if (!more.length) return;
    drag.cells.push(...more);
    this.board.preview({ cells: drag.cells, level: this.tool.level });
    this.on.paint?.(blocksOf(drag.field, more), this.tool.level, this.gesture);
  }

  private outlined(from: Place, to: Place): void {
    const level = this.tool.name === "paint" ? this.tool.level : null;
    this.board.preview({ cells: rectangle(from, to), level });
  }

  /* End a drag, and take back what can be taken back: an end is where it was, an area is not made. */
  cancel(): void {
    const { drag, board } = this;
    this.drag = null;
    if (this.corner) {
      this.corner = null;
      board.preview(null);
    }
    if (!drag || drag.kind === "click") return;
    board.grips.held(null);
    if (drag.kind === "end") this.moveEnd(drag, drag.start);
    else if (drag.kind === "raise") this.raise(drag, drag.start);
    else board.preview(null);
  }

  private key(event: KeyboardEvent): void {
    const { board, tool } = this;
    if (event.ctrlKey || event.metaKey || event.altKey || !board.field) return;
    const [arrow, nearer] = [ARROWS[event.key], NEARER[event.key]];
    const grip = board.grips.of(event.target);
    if (grip && arrow) this.moveGrip(board.field, grip, arrow, event.shiftKey);
    else if (event.target !== board.canvas) return;
    else if (arrow && arrow[0] && event.shiftKey && tool.name === "robot") this.on.turn?.((-arrow[0] * Math.PI) / 36);
    else if (arrow && tool.name !== "select") this.moveCursor(board.field, board.towards(...arrow));
    else if (arrow) board.turn(...arrow);
    else if (nearer) board.zoom(nearer);
    else if (event.key === "Escape" && (this.corner || (this.drag && this.drag.kind !== "click"))) this.cancel();
    else if ((event.key === "Enter" || event.key === " ") && this.cursor) this.press(board.field, this.cursor);
    else if (event.key === "Home" && tool.name !== "select") this.putCursor(board.field, board.field.blocks[0] ?? null);
    else if (tool.name === "paint" && this.cursor && /^[0-9]$/.test(event.key)) this.typeLevel(board.field, this.cursor, Number(event.key), 1);
    else if (tool.name === "paint" && this.cursor && event.key === "Backspace") this.typeLevel(board.field, this.nextTo(board.field, this.cursor, -1), -1, 0);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  /* Move a handle by a cell, with Shift by a chunk, or its obstacle's height by a level; what keys did a moment ago holds
     until the map with it is there. */
  private moveGrip(field: Field, { row, end, point }: Grip, arrow: Place, isFar: boolean): void {
    const known = this.keyed && performance.now() - this.keyed.when < 1000 ? this.keyed : null;
    const [cell, levels] = [known?.cell ?? field.nearest(field.place(point[0], point[1])), known?.levels ?? levelsOf(field, row)];
    this.keyed = { cell, levels, when: performance.now() };
    if (end === "raise") {
      this.keyed.levels = Math.max(1, levels + arrow[1]);
      if (this.keyed.levels !== levels) this.on.raise?.(row, this.keyed.levels, this.gesture);
      return;
    }
    const step = isFar ? (this.on.chunk?.() ?? 1) : 1;
    const [i, j] = this.board.towards(...arrow);
    this.keyed.cell = field.nearest(field.ofBlock([cell[0] + step * i, cell[1] + step * j]));
    if (String(this.keyed.cell) !== String(cell)) this.on.moveEnd?.(row, end, this.keyed.cell, this.gesture);
  }

  private moveCursor(field: Field, [di, dj]: Place): void {
    const [i, j] = this.cursor ?? [Math.floor(field.nX / 2) - di, Math.floor(field.nY / 2) - dj];
    this.putCursor(field, [Math.min(field.nX - 1, Math.max(0, i + di)), Math.min(field.nY - 1, Math.max(0, j + dj))]);
  }

  private putCursor(field: Field, cell: Place | null): void {
    this.cursor = cell;
    if (!cell) return;
    const spot = { cell, point: field.top(...cell) };
    this.board.mark(spot);
    this.on.hover?.(field.hover(spot.cell, spot.point));
    if (this.corner) this.outlined(this.corner, cell);
    if (this.tool.name === "robot") this.on.robotPut?.(spot.point[0], spot.point[1]);
  }

  /* The block after or before a cell, as one reads: from the west to the east, row by row from the north. */
  private nextTo(field: Field, cell: Place, by: 1 | -1): Place {
    const at = field.blocks.findIndex(([i, j]) => j < cell[1] || (j === cell[1] && i >= cell[0]));
    const isBlock = field.block(cell) !== null;
    return field.blocks[at < 0 ? field.blocks.length - 1 : at + (by > 0 && !isBlock ? 0 : by)] ?? cell;
  }

  /* Give a cell a level, as it is typed, and go on with the next one; -1 erases it. */
  private typeLevel(field: Field, cell: Place, level: number, by: 0 | 1): void {
    this.begin();
    if (field.block(cell)) this.on.paint?.(blocksOf(field, [cell]), level, this.gesture);
    this.putCursor(field, by ? this.nextTo(field, cell, by) : cell);
  }

  /* Do at the cursor of keys what a click or a drag of the mouse does. */
  private press(field: Field, cell: Place): void {
    const { tool, on } = this;
    const [x, y] = field.top(...cell);
    if (tool.name === "robot") on.robotPut?.(x, y);
    else if (tool.name === "way") on.wayPoint?.(x, y);
    else if (tool.name !== "draw" && !(tool.name === "paint" && tool.shape === "rectangle")) this.paintCursor(field, cell);
    else if (this.corner) {
      this.begin();
      this.made(field, this.corner, cell);
      this.corner = null;
    } else {
      this.corner = cell;
      this.outlined(cell, cell);
    }
  }

  private paintCursor(field: Field, cell: Place): void {
    const { tool, on } = this;
    if (tool.name !== "paint" || !field.block(cell)) return;
    if (tool.shape === "pick") return on.picked?.(field.material(...cell).level!);
    this.begin();
    on.paint?.(blocksOf(field, tool.shape === "fill" ? filled(field, cell) : [cell]), tool.level, this.gesture);
  }

  private wheel(event: WheelEvent): void {
    if (!event.shiftKey || this.tool.name !== "robot") return;
    event.preventDefault();
    event.stopPropagation();
    this.on.turn?.((Math.sign(event.deltaY || event.deltaX) * Math.PI) / 36);
  }
}

function blocksOf(field: Field, cells: Place[]): Cell[] {
  return cells.map((cell) => field.block(cell)).filter((block): block is Cell => block !== null);
}

/* The number of levels of an obstacle, as its highest block has it. */
function levelsOf(field: Field, row: number): number {
  return 1 + field.cellsOf(row).reduce((most, cell) => Math.max(most, field.material(...cell).level ?? 0), 0);
}

/* Where the handles of an obstacle are: at its ends, in the middle, and above it one that raises it. */
export function gripsOf(field: Field, row: number, room: number): Grip[] {
  const ends = field.scene.handles?.find((handle) => handle.row === row);
  const grips: Grip[] = [];
  if (ends?.first && ends.last) {
    const [first, last] = [ends.first, ends.last];
    const middle: Cell = [(first[0] + last[0]) >> 1, (first[1] + last[1]) >> 1];
    const point = field.top(...field.ofBlock(middle));
    const apart = Math.max(Math.abs(first[0] - last[0]), Math.abs(first[1] - last[1]));
    if (apart > 1) grips.push({ row, end: "both", point }); // else there is no room between the ends
  }
  for (const end of ["first", "last"] as const) {
    const cell = ends?.[end];
    if (cell) grips.push({ row, end, point: field.top(...field.ofBlock(cell)) });
  }
  const cells = field.cellsOf(row);
  if (cells.length) {
    const z = cells.reduce((most, cell) => Math.max(most, field.height(...cell)), 0);
    const [x, y] = [0, 1].map((axis) => cells.reduce((sum, cell) => sum + field.top(...cell)[axis], 0) / cells.length);
    grips.push({ row, end: "raise", point: [x, y, z + room] });
  }
  return grips;
}

/* The cells between the ends of an obstacle. */
export function cellsBetween(field: Field, row: number): Place[] {
  const ends = field.scene.handles?.find((handle) => handle.row === row);
  return ends?.first && ends.last ? rectangle(field.ofBlock(ends.first), field.ofBlock(ends.last)) : [];
}

const NAMES: Record<End, string> = { first: "First end", last: "Last end", both: "Middle", raise: "Height" };

/* The handles over a view, which follow points of the map. They are buttons, so that Tab gets to them. */
export class Grips {
  grips: Grip[] = [];
  private readonly elements = new Map<End, HTMLElement>();

  constructor(private readonly host: HTMLElement) {}

  set(grips: Grip[]): void {
    this.grips = grips;
    for (const [end, element] of this.elements) element.hidden = !grips.some((grip) => grip.end === end);
    for (const { end } of grips) {
      if (this.elements.has(end)) continue;
      const element = document.createElement("button");
      Object.assign(element, { type: "button", className: "grip", ariaLabel: `${NAMES[end]} of the obstacle: arrow keys move it` });
      element.dataset.end = end;
      this.host.append(element);
      this.elements.set(end, element);
    }
  }

  dispose(): void {
    this.elements.forEach((element) => element.remove());
  }

  /* The handle that is an element. */
  of(element: EventTarget | null): Grip | undefined {
    return this.grips.find(({ end }) => this.elements.get(end) === element);
  }

  held(grip: Grip | null): void {
    for (const [end, element] of this.elements) element.toggleAttribute("data-held", end === grip?.end);
  }

  /* Move the elements to where their points are seen, in CSS pixels. */
  place(pixel: (point: Point) => [number, number]): void {
    for (const { end, point } of this.grips) moveTo(this.elements.get(end)!, ...pixel(point));
  }

  at(x: number, y: number, reach: number, pixel: (point: Point) => [number, number]): Grip | null {
    const near = this.grips.map((grip) => {
      const [gripX, gripY] = pixel(grip.point);
      return { grip, far: Math.hypot(gripX - x, gripY - y) };
    });
    const [best] = near.filter(({ far }) => far <= reach).sort((a, b) => a.far - b.far);
    return best?.grip ?? null;
  }
}

export function add(host: HTMLElement, kind: string, text = ""): HTMLElement {
  const element = document.createElement("div");
  element.className = kind;
  element.textContent = text;
  element.setAttribute("aria-hidden", "true");
  host.append(element);
  return element;
}

export function moveTo(element: HTMLElement, x: number, y: number): void {
  element.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
}
