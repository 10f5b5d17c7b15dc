/* The blocks of a map as one mesh: the tops of all cells, and sides where a neighbour is lower.

Each face has four corners of its own. What the shader must know of a face stands at each of them, in eight bytes:
red, green, blue and the edges that have a line; where it faces, its layer of grain, along which axis the grain lies,
and how much of the grain is seen.
*/

import { BufferAttribute, BufferGeometry, Sphere, Vector3 } from "three";
import { rgb, type Field } from "./field";
import { KINDS } from "./wood";

export enum Faces { Up, West, East, South, North }

export interface Dress {
  look: "recipe" | "heights";
  floor: string; // its colour
  isSeen(i: number, j: number): boolean; // false: neither drawn nor hiding its neighbours' sides
}

/* How much of the grain is seen: all of it on wood, a little through paint, none where colour means height. */
const GRAIN = { wood: 1, painted: 0.34, plain: 0.22, none: 0 };

export function blocksOf(field: Field, dress: Dress): BufferGeometry {
  const { nX, nY } = field;
  // Where no block is one sees the floor.
  const colours = field.palette.map(({ level, surface, colour }) => {
    if (dress.look === "heights") return rgb(colour);
    return rgb(level === 0 ? dress.floor : surface);
  });
  const grains = field.palette.map(({ level }) => {
    if (level === 0) return GRAIN.none;
    if (dress.look === "heights") return level === null ? GRAIN.plain : GRAIN.none;
    if (field.scene.look === "wood") return GRAIN.wood;
    return level === null ? GRAIN.painted : GRAIN.plain;
  });
  const height = (i: number, j: number) => (field.has(i, j) && dress.isSeen(i, j) ? field.height(i, j) : 0);
  const count = countFaces();
  const positions = new Float32Array(12 * count);
  const colour = new Uint8Array(16 * count);
  const face = new Uint8Array(16 * count);
  const index = new Uint32Array(6 * count);
  let next = 0;

  for (let i = 0; i < nX; i++) {
    for (let j = 0; j < nY; j++) {
      if (!dress.isSeen(i, j)) continue;
      const own = field.heights[i * nY + j];
      addTop(i, j, own);
      if (own === 0) continue;
      const [x0, x1, y0, y1] = [field.x(i), field.x(i + 1), field.y(j), field.y(j + 1)];
      addSide(i, j, height(i - 1, j), own, Faces.West, x0, y1, x0, y0);
      addSide(i, j, height(i + 1, j), own, Faces.East, x1, y0, x1, y1);
      addSide(i, j, height(i, j - 1), own, Faces.South, x0, y0, x1, y0);
      addSide(i, j, height(i, j + 1), own, Faces.North, x1, y1, x0, y1);
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(positions, 3));
  geometry.setAttribute("colour", new BufferAttribute(colour, 4));
  geometry.setAttribute("face", new BufferAttribute(face, 4));
  geometry.setIndex(new BufferAttribute(index, 1));
  geometry.boundingSphere = new Sphere(new Vector3(), Math.hypot(field.x(nX), field.y(nY), field.highest));
  return geometry;

  function countFaces(): number {
    let faces = 0;
    for (let i = 0; i < nX; i++) {
      for (let j = 0; j < nY; j++) {
        if (!dress.isSeen(i, j)) continue;
        const own = field.heights[i * nY + j];
        const [west, east, south, north] = [height(i - 1, j), height(i + 1, j), height(i, j - 1), height(i, j + 1)];
        faces += 1 + +(west < own) + +(east < own) + +(south < own) + +(north < own);
      }
    }
    return faces;
  }

  function isFrame(i: number, j: number): boolean {
    return field.has(i, j) && field.material(i, j).level === null;
  }

  function addTop(i: number, j: number, z: number): void {
    const [x0, x1, y0, y1] = [field.x(i), field.x(i + 1), field.y(j), field.y(j + 1)];
    const [west, east, south, north] = [isFrame(i - 1, j), isFrame(i + 1, j), isFrame(i, j - 1), isFrame(i, j + 1)];
    const board = isFrame(i, j);
    // Boards are long: no line crosses them, and their grain lies along them.
    const lines = board ? +!west + 2 * +!east + 4 * +!south + 8 * +!north : 15;
    const layer = board ? KINDS + (((south || north) && !(west || east) ? i : j) % KINDS) : hash(i, j) % KINDS;
    const along = board && (west || east) ? 1 : 0;
    put([x0, y0, z, x1, y0, z, x1, y1, z, x0, y1, z], i, j, lines, Faces.Up, layer, board, along);
  }

  /* The side of a cell from a lower neighbour's top upward, between two corners of the plan, seen from outside. */
  function addSide(
    i: number, j: number, low: number, high: number, faces: Faces, xa: number, ya: number, xb: number, yb: number,
  ): void {
    if (low >= high) return;
    const board = isFrame(i, j);
    const [di, dj] = faces <= Faces.East ? [0, 1] : [1, 0];
    const [before, after] = [isFrame(i - di, j - dj), isFrame(i + di, j + dj)];
    const [left, right] = faces === Faces.West || faces === Faces.North ? [after, before] : [before, after];
    const lines = board ? +!left + 2 * +!right + 8 : 11;
    const layer = KINDS + (board ? 3 : hash(i, j) % KINDS);
    put([xa, ya, low, xb, yb, low, xb, yb, high, xa, ya, high], i, j, lines, faces, layer, board, board ? 1 : 0);
  }

  function put(
    corners: number[], i: number, j: number, lines: number, faces: Faces, layer: number, board: boolean, along: number,
  ): void {
    const varied = board ? 3 : hash(j, i) % 8; // all of a board is of one tree
    const first = 4 * next;
    const material = field.content[i * nY + j];
    const [red, green, blue] = colours[material];
    const isFloor = field.palette[material].level === 0;
    const grain = Math.round(255 * grains[material]);
    positions.set(corners, 3 * first);
    for (let at = 4 * first; at < 4 * first + 16; at += 4) {
      colour[at] = red;
      colour[at + 1] = green;
      colour[at + 2] = blue;
      colour[at + 3] = lines + (isFloor ? 16 : 0); // fainter ones there
      face[at] = faces;
      face[at + 1] = layer;
      face[at + 2] = along + 2 * varied;
      face[at + 3] = grain;
    }
    const at = 6 * next;
    index[at] = index[at + 3] = first;
    index[at + 1] = first + 1;
    index[at + 2] = index[at + 4] = first + 2;
    index[at + 5] = first + 3;
    next += 1;
  }
}

/* A number that looks random, so that neighbours differ. */
function hash(i: number, j: number): number {
  const mixed = Math.imul(i * 374761393 + j * 668265263, 1274126177);
  return (mixed ^ (mixed >>> 15)) >>> 8;
}
