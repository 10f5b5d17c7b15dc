/* One map as it is drawn: what stands in each cell. Cell (0, 0) is in the corner of smallest x and y. */

import type { Cell, Material, SceneData } from "./protocol";
import type { Hover } from "./views";

export type Place = [number, number]; // i, j of the field, frames included
export type Point = [number, number, number]; // metres; the map's centre is the origin

export class Field {
  readonly nX: number;
  readonly nY: number;
  readonly width: number;
  readonly palette: Material[];
  readonly content: Uint8Array | Uint16Array; // the number of a material in the palette, all of the first i first
  readonly heights: Float32Array; // metres, in the same order
  readonly highest: number;
  readonly step: number;
  private readonly owners: Int16Array | null;
  readonly blockX: Int32Array; // the block of each column of cells; -1: all frame
  readonly blockY: Int32Array;
  private readonly columns: number[]; // the cells of each column of blocks
  private readonly rows: number[];

  constructor(readonly scene: SceneData) {
    [this.nX, this.nY] = scene.cells;
    this.width = scene.block_width;
    this.palette = scene.palette;
    const bytes = bytesOf(scene.content);
    this.content = scene.bytes === 1 ? bytes : new Uint16Array(bytes.buffer);
    this.heights = Float32Array.from(this.content, (material) => this.palette[material].height);
    this.highest = this.palette.reduce((most, material) => Math.max(most, material.height), 0);
    const high = this.palette.find((material) => material.level);
    this.step = scene.step || (high ? high.height / high.level! : this.width / 2);
    this.owners = scene.owners ? new Int16Array(bytesOf(scene.owners).buffer) : null;
    this.blockX = blocksOf(this.nX, this.nY, (i, j) => this.material(i, j).level !== null);
    this.blockY = blocksOf(this.nY, this.nX, (j, i) => this.material(i, j).level !== null);
    const cellsOf = (blocks: Int32Array) => [...blocks.keys()].filter((k) => blocks[k] >= 0);
    [this.columns, this.rows] = [cellsOf(this.blockX), cellsOf(this.blockY)];
  }

  private inOrder: Place[] | null = null;

  /* All blocks in the order in which one reads them: row by row from the north, each from the west. */
  get blocks(): Place[] {
    return (this.inOrder ??= [...this.rows].reverse().flatMap((j) => this.columns.map((i): Place => [i, j]))
      .filter((cell) => this.block(cell) !== null));
  }

  /* Whether another map has the same size, so that the camera may stay. */
  isLike(other: Field | null): boolean {
    return other !== null && this.nX === other.nX && this.nY === other.nY && this.width === other.width;
  }

  at(i: number, j: number): number {
    return i * this.nY + j;
  }

  has(i: number, j: number): boolean {
    return i >= 0 && j >= 0 && i < this.nX && j < this.nY;
  }

  material(i: number, j: number): Material {
    return this.palette[this.content[i * this.nY + j]];
  }

  /* Height of a cell in metres; 0 outside. */
  height(i: number, j: number): number {
    return this.has(i, j) ? this.heights[i * this.nY + j] : 0;
  }

  /* The row of the obstacle that made a cell; -1: none, or unknown. */
  owner(i: number, j: number): number {
    return this.owners && this.has(i, j) ? this.owners[i * this.nY + j] : -1;
  }

  /* Metres of the edge before cell i along x, or j along y. */
  x(i: number): number {
    return (i - this.nX / 2) * this.width;
  }

  y(j: number): number {
    return (j - this.nY / 2) * this.width;
  }

  /* The cell below a point; it may be outside of the map. */
  place(x: number, y: number): Place {
    return [Math.floor(x / this.width + this.nX / 2), Math.floor(y / this.width + this.nY / 2)];
  }

  /* The middle of a cell's top. */
  top(i: number, j: number): Point {
    return [this.x(i + 0.5), this.y(j + 0.5), this.height(i, j)];
  }

  /* The number of a cell among blocks; null for a frame and outside. */
  block([i, j]: Place): Cell | null {
    return this.has(i, j) && this.material(i, j).level !== null ? [this.blockX[i], this.blockY[j]] : null;
  }

  /* The cell of a block. */
  ofBlock([x, y]: Cell): Place {
    const clamped = (cells: number[], k: number) => cells[Math.min(cells.length - 1, Math.max(0, k))] ?? 0;
    return [clamped(this.columns, x), clamped(this.rows, y)];
  }

  /* The block next to any place, also outside of the map or on a frame. */
  nearest([i, j]: Place): Cell {
    const next = (cells: number[], k: number) =>
      cells.reduce((best, cell, block) => (Math.abs(cell - k) < Math.abs(cells[best] - k) ? block : best), 0);
    return [next(this.columns, i), next(this.rows, j)];
  }

  hover([i, j]: Place, [x, y, z]: Point): Hover {
    const { level, label } = this.material(i, j);
    const height = `${label} ${this.scene.unit}`;
    return { i, j, cell: this.block([i, j]), row: this.owner(i, j), label: level === null ? "frame" : height, x, y, z };
  }

  /* The cells of an obstacle. */
  cellsOf(row: number): Place[] {
    const cells: Place[] = [];
    if (!this.owners || row < 0) return cells;
    for (let at = this.owners.indexOf(row); at >= 0; at = this.owners.indexOf(row, at + 1)) {
      cells.push([Math.floor(at / this.nY), at % this.nY]);
    }
    return cells;
  }

  /* The colour of a level that may not be on the map yet: that of the nearest one. */
  colourOf(level: number): string {
    const levels = this.palette.filter((material) => material.level !== null);
    const apart = (material: Material) => Math.abs(material.level! - level);
    const nearest = levels.reduce((best, material) => (apart(material) < apart(best) ? material : best), levels[0]);
    return nearest?.colour ?? "#888888";
  }
}

export function bytesOf(base64: string): Uint8Array<ArrayBuffer> {
  const letters = atob(base64);
  const bytes = new Uint8Array(letters.length);
  for (let k = 0; k < letters.length; k++) bytes[k] = letters.charCodeAt(k);
  return bytes;
}

/* The number of each line of cells among those that have blocks; -1 for lines that are all frame. */
function blocksOf(count: number, across: number, isBlock: (line: number, k: number) => boolean): Int32Array {
  let next = 0;
  return Int32Array.from({ length: count }, (_, line) => {
    for (let k = 0; k < across; k++) if (isBlock(line, k)) return next++;
    return -1;
  });
}

/* Red, green and blue, 0 to 255, of "#rrggbb". */
export function rgb(colour: string): [number, number, number] {
  const value = parseInt(colour.slice(1), 16);
  return [value >> 16, (value >> 8) & 255, value & 255];
}

/* The outline of some cells: pairs of points along the tops, and upright where it goes from one height to another. */
export function outline(field: Field, cells: Place[]): Point[] {
  const inside = new Set(cells.map(([i, j]) => field.at(i, j)));
  const isIn = (i: number, j: number) => field.has(i, j) && inside.has(field.at(i, j));
  const corners = new Map<number, [number, number]>(); // lowest and highest end of a line at each corner
  const points: Point[] = [];
  const end = (i: number, j: number, z: number) => {
    const at = i * (field.nY + 1) + j;
    const [low, high] = corners.get(at) ?? [z, z];
    corners.set(at, [Math.min(low, z), Math.max(high, z)]);
    points.push([field.x(i), field.y(j), z]);
  };
  for (const [i, j] of cells) {
    const z = field.height(i, j);
    for (const [di, dj] of [[-1, 0], [1, 0], [0, -1], [0, 1]]) {
      if (isIn(i + di, j + dj)) continue;
      if (di) [0, 1].forEach((k) => end(i + (di > 0 ? 1 : 0), j + k, z));
      else [0, 1].forEach((k) => end(i + k, j + (dj > 0 ? 1 : 0), z));
    }
  }
  for (const [at, [low, high]] of corners) {
    const [x, y] = [field.x(Math.floor(at / (field.nY + 1))), field.y(at % (field.nY + 1))];
    if (low < high) points.push([x, y, low], [x, y, high]);
  }
  return points;
}

/* The cells on the line from one cell to another, without a gap. */
export function line([i0, j0]: Place, [i1, j1]: Place): Place[] {
  const steps = Math.max(Math.abs(i1 - i0), Math.abs(j1 - j0), 1);
  const cells = Array.from({ length: steps + 1 }, (_, k): Place => [
    Math.round(i0 + ((i1 - i0) * k) / steps),
    Math.round(j0 + ((j1 - j0) * k) / steps),
  ]);
  return i0 === i1 && j0 === j1 ? [cells[0]] : cells;
}

export function rectangle([i0, j0]: Place, [i1, j1]: Place): Place[] {
  const cells: Place[] = [];
  for (let i = Math.min(i0, i1); i <= Math.max(i0, i1); i++) {
    for (let j = Math.min(j0, j1); j <= Math.max(j0, j1); j++) cells.push([i, j]);
  }
  return cells;
}

/* The cells of one height that hang together with a cell, side by side. */
export function filled(field: Field, start: Place): Place[] {
  const material = field.material(...start);
  const seen = new Set([field.at(...start)]);
  const cells = [start];
  for (let next = 0; next < cells.length; next++) {
    const [i, j] = cells[next];
    for (const [a, b] of [[i - 1, j], [i + 1, j], [i, j - 1], [i, j + 1]] as Place[]) {
      if (!field.has(a, b) || seen.has(field.at(a, b)) || field.material(a, b) !== material) continue;
      seen.add(field.at(a, b));
      cells.push([a, b]);
    }
  }
  return cells;
}

/* The cell that a ray meets first, and where; null if it meets none. The ray is followed from cell to cell. */
export function onRay(field: Field, origin: Point, direction: Point): { cell: Place; point: Point } | null {
  const start = [origin[0] / field.width + field.nX / 2, origin[1] / field.width + field.nY / 2, origin[2]];
  const way = [direction[0] / field.width, direction[1] / field.width, direction[2]];
  let [now, end] = [0, Infinity];
  for (const [axis, size] of [field.nX, field.nY, field.highest].entries()) {
    if (way[axis] === 0) {
      if (start[axis] < 0 || start[axis] > size) return null;
      continue;
    }
    const ends = [-start[axis] / way[axis], (size - start[axis]) / way[axis]];
    now = Math.max(now, Math.min(...ends));
    end = Math.min(end, Math.max(...ends));
  }
  if (now > end) return null;
  const inside = (axis: number, size: number) =>
    Math.min(size - 1, Math.max(0, Math.floor(start[axis] + way[axis] * now)));
  let [i, j] = [inside(0, field.nX), inside(1, field.nY)];
  for (;;) {
    const untilX = way[0] === 0 ? Infinity : (i + (way[0] > 0 ? 1 : 0) - start[0]) / way[0];
    const untilY = way[1] === 0 ? Infinity : (j + (way[1] > 0 ? 1 : 0) - start[1]) / way[1];
    const until = Math.min(untilX, untilY, end);
    const z = field.height(i, j) + 1e-9;
    if (start[2] + way[2] * (way[2] < 0 ? until : now) <= z) {
      // It enters through a side if it is below the top there, else it comes down on the top.
      const meets = way[2] < 0 && start[2] + way[2] * now > z ? (z - start[2]) / way[2] : now;
      return { cell: [i, j], point: [0, 1, 2].map((axis) => origin[axis] + direction[axis] * meets) as Point };
    }
    if (until >= end) return null;
    if (untilX < untilY) i += Math.sign(way[0]);
    else j += Math.sign(way[1]);
    if (!field.has(i, j)) return null;
    now = until;
  }
}

export function metres(value: number): string {
  return (Math.round(value * 1000) / 1000 + 0).toString().replace("-", "−");
}

/* A letter on a disc: start and goal of a robot, in both views. */
export function lettered(
  pen: CanvasRenderingContext2D, [x, y]: [number, number], radius: number, text: string, colour: string,
): void {
  pen.beginPath();
  pen.arc(x, y, radius, 0, 2 * Math.PI);
  Object.assign(pen, { fillStyle: colour, strokeStyle: "#ffffff", lineWidth: Math.max(1.5, radius / 8) });
  pen.fill();
  pen.stroke();
  Object.assign(pen, { fillStyle: "#ffffff", textAlign: "center", textBaseline: "middle" });
  pen.font = `bold ${1.25 * radius}px system-ui, sans-serif`;
  pen.fillText(text, x, y + 0.06 * radius);
}
