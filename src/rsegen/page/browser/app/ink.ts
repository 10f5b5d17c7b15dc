/* What is drawn on the plan, at places of the map in metres: cells, lines, ways, robots, and numbers around it. */

import { ACCENT, START, TROUBLE } from "./colours";
import { lettered, metres, outline, rgb, type Field, type Place, type Point } from "./field";
import { boundsOf } from "./models";
import { END } from "./overlay";
import type { RobotShapes } from "./protocol";

export const LEGIBLE = 17; // CSS pixels that a cell must have so that its height is written into it
const LINED = 5; // and so that it has an outline

export type Pixel = [number, number];
export type Box = [left: number, top: number, wide: number, high: number];
type Spot = Point | Pixel | readonly number[];

export class Ink {
  readonly size: number; // CSS pixels of a cell
  private readonly corners: [Pixel, Pixel]; // south-west and north-east, in CSS pixels

  /* centre: where the middle of the map is seen; scale: CSS pixels of a metre */
  constructor(readonly pen: CanvasRenderingContext2D, readonly field: Field, readonly centre: Pixel, readonly scale: number) {
    this.size = field.width * scale;
    this.corners = [this.at([field.x(0), field.y(0)]), this.at([field.x(field.nX), field.y(field.nY)])];
  }

  at([x, y]: Spot): Pixel {
    return [this.centre[0] + x * this.scale, this.centre[1] - y * this.scale];
  }

  /* Draw nothing beside the map, such as ways that begin there, nor outside of a box. */
  clip([left, top, wide, high]: Box): void {
    const [[west, south], [east, north]] = this.corners;
    const [x0, y0] = [Math.max(left, west) - 2, Math.max(top, north) - 2];
    this.pen.beginPath();
    this.pen.rect(x0, y0, Math.min(left + wide, east) + 2 - x0, Math.min(top + high, south) + 2 - y0);
    this.pen.clip();
  }

  picture(canvas: HTMLCanvasElement, low: Pixel, size: Pixel): void {
    const [x, y] = this.at([low[0], low[1] + size[1]]);
    this.pen.drawImage(canvas, x, y, size[0] * this.scale, size[1] * this.scale);
  }

  grid(): void {
    const { pen, size, field, corners: [[west, south], [east, north]] } = this;
    if (size < LINED) return;
    pen.strokeStyle = `rgb(0 0 0 / ${size >= LEGIBLE ? 0.3 : 0.18})`;
    pen.lineWidth = 1;
    pen.beginPath();
    for (let i = 0; i <= field.nX; i++) this.segment([west + i * size, south], [west + i * size, north]);
    for (let j = 0; j <= field.nY; j++) this.segment([west, south - j * size], [east, south - j * size]);
    pen.stroke();
  }

  private segment(from: Pixel, to: Pixel): void {
    this.pen.moveTo(...from);
    this.pen.lineTo(...to);
  }

  /* Write the height into each cell that is seen in a box. */
  heights([left, top, wide, high]: Box): void {
    const { pen, size, field } = this;
    if (size < LEGIBLE) return;
    const longest = field.palette.reduce((most, { label }) => Math.max(most, label.length), 1);
    const dark = new Map(field.palette.map((material) => [material, isDim(material.colour)]));
    Object.assign(pen, { textAlign: "center", textBaseline: "middle" });
    pen.font = `${Math.min(15, size * 0.5, (size * 1.5) / longest)}px system-ui, sans-serif`;
    for (let i = 0; i < field.nX; i++) {
      for (let j = 0; j < field.nY; j++) {
        const material = field.material(i, j);
        const [x, y] = this.at(field.top(i, j));
        if (material.level === null || x < left || y < top || x > left + wide || y > top + high) continue;
        pen.fillStyle = dark.get(material) ? "#ffffff" : "#000000";
        pen.fillText(material.label, x, y);
      }
    }
  }

  fill(cells: Place[], colour: (cell: Place) => string): void {
    for (const cell of cells) {
      this.pen.fillStyle = colour(cell);
      this.pen.fillRect(...this.at([this.field.x(cell[0]), this.field.y(cell[1] + 1)]), this.size, this.size);
    }
  }

  /* Outline some cells, with a wider line below, so that it is seen on any colour. */
  outline(cells: Place[], colour: string, width: number, below = ""): void {
    const { pen } = this;
    const points = outline(this.field, cells);
    pen.beginPath();
    for (let k = 0; k < points.length; k += 2) this.segment(this.at(points[k]), this.at(points[k + 1]));
    pen.lineCap = "round";
    const thin = Math.min(1, Math.max(0.4, this.size / 12)); // where cells are small
    for (const [style, wide] of below ? [[below, width + 2], [colour, width]] as const : [[colour, width]] as const) {
      pen.strokeStyle = style;
      pen.lineWidth = thin * wide;
      pen.stroke();
    }
  }

  line(points: readonly Spot[], colour: string, width: number): void {
    const { pen } = this;
    pen.beginPath();
    points.forEach((point, k) => (k ? pen.lineTo(...this.at(point)) : pen.moveTo(...this.at(point))));
    Object.assign(pen, { strokeStyle: colour, lineWidth: width, lineCap: "round", lineJoin: "round" });
    pen.stroke();
  }

  disc(point: Spot, radius: number, colour: string): void {
    const { pen } = this;
    pen.beginPath();
    pen.arc(...this.at(point), radius, 0, 2 * Math.PI);
    Object.assign(pen, { fillStyle: colour, lineWidth: 1.5, strokeStyle: "#ffffff" });
    pen.fill();
    pen.stroke();
  }

  /* The start or the goal of a way. */
  named(point: Spot, radius: number, name: "S" | "G" | typeof END): void {
    lettered(this.pen, this.at(point), Math.max(8, 1.3 * radius), name, name === "S" ? START : name === END ? TROUBLE : ACCENT);
  }

  /* A robot from above, with a head that shows where it faces. */
  footprint([x, y]: Spot, yaw: number, drawing: RobotShapes, colour: string): void {
    const [cos, sin] = [Math.cos(yaw), Math.sin(yaw)];
    const [back, front, right, left] = boundsOf(drawing);
    const shoulder = front - 0.2 * (front - back);
    const tip = [front, (left + right) / 2];
    const corners = [[back, right], [shoulder, right], tip, [shoulder, left], [back, left], [back, right]];
    const points = corners.map(([along, across]): Pixel => [x + along * cos - across * sin, y + along * sin + across * cos]);
    this.line(points, "#ffffff", 4);
    this.line(points, colour, 2.5);
    this.pen.fillStyle = `${colour}33`;
    this.pen.fill();
  }

  /* Cells are counted below and on the left of the map, metres above and on the right. */
  numbers([left, top, wide, high]: Box, isDark: boolean, textSize: number): void {
    const { pen, size, field, scale, corners: [[west, south], [east, north]] } = this;
    const [edgeX, edgeY] = [Math.min(left + wide, east), Math.min(top + high, south)];
    const [startX, startY] = [Math.max(left, west), Math.max(top, north)];
    const text = (
      value: string | number, x: number, y: number, textAlign: CanvasTextAlign, textBaseline: CanvasTextBaseline,
    ) => {
      Object.assign(pen, { textAlign, textBaseline });
      pen.fillText(String(value), x, y);
    };
    const isIn = (value: number, from: number, to: number) => value >= from - 0.5 && value <= to + 0.5;
    pen.font = `${textSize}px system-ui, sans-serif`;
    pen.fillStyle = pen.strokeStyle = isDark ? "#a9b1bc" : "#5b626c";
    const every = niceStep((2 * textSize) / size, 1);
    field.blockX.forEach((block, i) => {
      const x = west + (i + 0.5) * size;
      if (block >= 0 && block % every === 0 && isIn(x, startX, edgeX)) text(block, x, edgeY + 5, "center", "top");
    });
    field.blockY.forEach((block, j) => {
      const y = south - (j + 0.5) * size;
      if (block >= 0 && block % every === 0 && isIn(y, startY, edgeY)) text(block, startX - 6, y, "right", "middle");
    });
    text("cell", Math.max(0, startX - 2.7 * textSize), edgeY + 5, "left", "top");
    text("m", edgeX + 8, edgeY + 5, "left", "top");
    const step = niceStep((4.7 * textSize) / scale, 0.01);
    pen.lineWidth = 1;
    pen.beginPath();
    for (const value of marks((field.nX * field.width) / 2, step)) {
      const [x] = this.at([value, 0]);
      if (!isIn(x, startX, edgeX)) continue;
      text(metres(value), x, startY - 7, "center", "bottom");
      this.segment([x, startY - 5], [x, startY - 1]);
    }
    for (const value of marks((field.nY * field.width) / 2, step)) {
      const [, y] = this.at([0, value]);
      if (!isIn(y, startY, edgeY)) continue;
      text(metres(value), edgeX + 8, y, "left", "middle");
      this.segment([edgeX + 1, y], [edgeX + 5, y]);
    }
    pen.stroke();
  }
}

function isDim(colour: string): boolean {
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
