/* Grain of wood as tones: end grain for tops, long grain for sides and boards, in layers of which each block takes one.

Wood grows in rings: the tone is 1 in spring and falls until autumn, where the next ring begins with a sharp edge. On a
top the time is the distance from a pith in or beside the block; on a side the distance from the plane through the
pith, in which rings are farther apart. Smooth noise bends both. Lengths are shares of a block's width.
*/

import { DataArrayTexture, LinearFilter, LinearMipmapLinearFilter, MirroredRepeatWrapping, RedFormat } from "three";

export const KINDS = 16; // layers of end grain, and as many of long grain
export const MEAN = 0.62; // tone
const PIXELS = 128;

let grain: DataArrayTexture | null = null;

/* The layers, drawn once: KINDS of end grain, then KINDS of long grain, whose length is two blocks. */
export function grainOf(): DataArrayTexture {
  if (grain) return grain;
  const tones = new Uint8Array(2 * KINDS * PIXELS * PIXELS);
  const random = numbers(20);
  for (let layer = 0; layer < 2 * KINDS; layer++) {
    const tone = layer < KINDS ? endGrain(random) : longGrain(random);
    for (let k = 0; k < PIXELS * PIXELS; k++) {
      const [u, v] = [((k % PIXELS) + 0.5) / PIXELS, (Math.floor(k / PIXELS) + 0.5) / PIXELS];
      tones[layer * PIXELS * PIXELS + k] = 255 * Math.min(1, Math.max(0, tone(u, v)));
    }
  }
  grain = new DataArrayTexture(tones, PIXELS, PIXELS, 2 * KINDS);
  grain.format = RedFormat;
  grain.wrapS = grain.wrapT = MirroredRepeatWrapping;
  grain.magFilter = LinearFilter;
  grain.minFilter = LinearMipmapLinearFilter;
  grain.generateMipmaps = true;
  grain.needsUpdate = true;
  return grain;
}

type Tone = (u: number, v: number) => number;
type Random = (low?: number, high?: number) => number;

function endGrain(random: Random): Tone {
  const [pithX, pithY, oval] = [random(-0.35, 1.35), random(-0.35, 1.35), random(0.8, 1.25)];
  const [ring, light] = [random(0.055, 0.1), random(0.58, 0.68)];
  const [bend, wave, fleck, cloud] = [noise(random, 3), noise(random, 11), noise(random, 48), noise(random, 2)];
  const [turn, from, until] = [random(0, 2 * Math.PI), random(0, 0.1), random(0.25, 0.7)];
  const cracked = random() < 0.45;
  return (u, v) => {
    const [x, y] = [u - pithX, v - pithY];
    const radius = Math.sqrt(oval * x * x + y * y) + 0.05 * bend(u, v) + 0.008 * wave(u, v);
    const outward = x * Math.cos(turn) + y * Math.sin(turn);
    const aside = Math.abs(x * Math.sin(turn) - y * Math.cos(turn) + 0.02 * wave(u, v));
    const inCrack = cracked && outward > from && outward < until ? Math.max(0, 1 - aside / 0.011) : 0;
    return light + 0.27 * (spring(radius / ring) - 0.5) + 0.07 * cloud(u, v) + 0.05 * fleck(u, v) - 0.36 * inCrack;
  };
}

function longGrain(random: Random): Tone {
  const [pith, ring, light] = [random(-0.3, 1.3), random(0.05, 0.1), random(0.6, 0.7)];
  const [bend, fibre, fine, cloud] = [noise(random, 2, 3), noise(random, 40, 3), noise(random, 90, 9), noise(random, 2)];
  const knots = random() < 0.4 ? [[random(0.15, 0.85), random(0.1, 0.9), random(0.05, 0.09)]] : [];
  return (u, v) => {
    let apart = Math.abs(u - pith + 0.09 * bend(u, v));
    let dark = 0;
    for (const [x, y, size] of knots) {
      const far = Math.hypot(u - x, 1.1 * (v - y)) / size;
      apart += ((u > x ? 1.1 : -1.1) * size) / (1 + far * far);
      dark += 0.36 * Math.max(0, 1 - far) * (0.7 + 0.3 * spring(2.5 * far));
    }
    const years = (2.2 * apart * apart + 0.6 * apart) / ring;
    return light + 0.2 * (spring(years) - 0.5) + 0.05 * cloud(u, v) + 0.05 * fibre(u, v) + 0.03 * fine(u, v) - dark;
  };
}

/* 1 in spring, down to 0 in autumn; the edge of the next ring is a little soft, so that it does not flicker. */
function spring(years: number): number {
  const time = years - Math.floor(years);
  return time < 0.9 ? 1 - (time / 0.9) ** 3 : (time - 0.9) / 0.1;
}

/* Smooth noise, -1 to 1, between random values on a grid over the unit square. */
function noise(random: Random, across: number, along = across): Tone {
  const values = Float32Array.from({ length: (across + 2) * (along + 2) }, () => random(-1, 1));
  const smooth = (part: number) => part * part * (3 - 2 * part);
  return (u, v) => {
    const [x, y] = [u * across, v * along];
    const [i, j] = [Math.floor(x), Math.floor(y)];
    const [a, b] = [smooth(x - i), smooth(y - j)];
    const at = (p: number, q: number) => values[p * (along + 2) + q];
    return (1 - a) * ((1 - b) * at(i, j) + b * at(i, j + 1)) + a * ((1 - b) * at(i + 1, j) + b * at(i + 1, j + 1));
  };
}

/* Random numbers that are the same in every browser (a congruential generator; its high bits suffice for looks). */
function numbers(seed: number): Random {
  let state = seed;
  return (low = 0, high = 1) => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return low + ((high - low) * state) / 2 ** 32;
  };
}
