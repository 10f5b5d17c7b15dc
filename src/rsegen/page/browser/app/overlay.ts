/* What lies on the tops of blocks, or on the plan, as a picture: the poses of a robot, and where it gets. North is up. */

import { bytesOf } from "./field";
import type { PoseMap, DrawnCrossing, DrawnReach, SceneData } from "./protocol";

export interface Overlay { canvas: HTMLCanvasElement; low: [number, number]; size: [number, number] } // metres

/* From calm to alarming: white over pink to a dark purple, of evenly falling lightness; no height has such a colour. */
export const RAMP = [[252, 240, 248], [240, 186, 222], [222, 120, 190], [172, 52, 152], [96, 8, 92]];
const REASONS = [[40, 150, 140], [230, 85, 70], [240, 165, 50], [150, 95, 200], [90, 100, 120], [210, 100, 160]];
const SEEN = 225; // of 255: the edges of blocks are seen below, and hardly their colours

export interface Scale { low: number; high: number; colours: string[] }

/* What the colours of a pose map mean: from low to high in radians. */
export function scaleOf(map: PoseMap, shown: "tilt" | "margin"): Scale {
  const high = floats(map[shown]).reduce((most, value) => (value > most ? value : most), 0.01);
  const colours = RAMP.map((part) => `rgb(${part.join(" ")})`);
  return { low: 0, high, colours: shown === "tilt" ? colours : colours.reverse() };
}

/* What the colours of the reasons mean, those that are on the map; "" for a good pose. */
export function reasonsOf(map: PoseMap): { reason: string; colour: string }[] {
  const seen = new Set(bytesOf(map.reason));
  return map.reasons.flatMap((reason, k) =>
    seen.has(k) ? [{ reason, colour: `rgb(${colourOfReason(map, reason).join(" ")})` }] : [],
  );
}

function colourOfReason(map: PoseMap, reason: string): number[] {
  const bad = map.reasons.filter((each) => each !== "");
  return reason ? REASONS[1 + (bad.indexOf(reason) % (REASONS.length - 1))] : REASONS[0];
}

export function ofPoses(map: PoseMap, shown: "tilt" | "margin" | "reason"): Overlay {
  const [nx, ny] = map.shape;
  const colour = shown === "reason" ? byReason(map) : byValue(map, shown);
  // A point is some pixels wide, so that hatching is fine.
  const fine = Math.max(1, Math.min(8, Math.floor(900 / Math.max(nx, ny))));
  const canvas = painted(nx * fine, ny * fine, (i, j) => {
    const found = colour(Math.floor(i / fine) * ny + Math.floor(j / fine));
    return found ?? ((i + j) % 8 < 4 ? [214, 40, 40, SEEN] : [214, 40, 40, 70]);
  });
  const [low, size] = [map.low.map((at) => at - map.step / 2), [nx * map.step, ny * map.step]] as [number[], number[]];
  return { canvas, low: low as [number, number], size: size as [number, number] };
}

/* What a robot does not reach is pale. */
export function ofReach(reach: DrawnReach, scene: SceneData): Overlay {
  const [nX, nY] = scene.cells;
  const region = bytesOf(reach.region);
  const canvas = painted(nX, nY, (i, j) => (region[i * nY + j] ? [0, 0, 0, 0] : [240, 240, 243, 185]));
  const size: [number, number] = [nX * scene.block_width, nY * scene.block_width];
  return { canvas, low: [-size[0] / 2, -size[1] / 2], size };
}

/* The mark where drives mostly end that do not cross, and its places: one for each side. */
export const END = "×";
export const endsOf = (crossing?: DrawnCrossing | null): [number, number][] =>
  (crossing?.sides ?? []).flatMap(({ ends: [most] }) => (most ? [[most.x, most.y] as [number, number]] : []));

type Colour = (at: number) => number[] | null; // null: hatched

function byValue(map: PoseMap, shown: "tilt" | "margin"): Colour {
  const [values, { high }] = [floats(map[shown]), scaleOf(map, shown)];
  return (at) => {
    if (Number.isNaN(values[at])) return null;
    const share = Math.min(1, Math.max(0, values[at] / high));
    const place = (shown === "tilt" ? share : 1 - share) * (RAMP.length - 1);
    const from = Math.min(RAMP.length - 2, Math.floor(place));
    const part = place - from;
    return [...RAMP[from].map((value, k) => value + part * (RAMP[from + 1][k] - value)), SEEN];
  };
}

function byReason(map: PoseMap): Colour {
  const reasons = bytesOf(map.reason);
  return (at) => {
    const reason = map.reasons[reasons[at]] ?? "";
    return [...colourOfReason(map, reason), reason ? SEEN : 90];
  };
}

function floats(base64: string): Float32Array {
  return new Float32Array(bytesOf(base64).buffer);
}

/* A canvas whose pixels have a colour each; j counts from the south. */
export function painted(wide: number, high: number, colour: (i: number, j: number) => number[]): HTMLCanvasElement {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [wide, high];
  const pen = canvas.getContext("2d")!;
  const image = pen.createImageData(wide, high);
  for (let i = 0; i < wide; i++) {
    for (let j = 0; j < high; j++) image.data.set(colour(i, j), 4 * ((high - 1 - j) * wide + i));
  }
  pen.putImageData(image, 0, 0);
  return canvas;
}
