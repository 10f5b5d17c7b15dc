/* The light on a map, as a texture that blocks, floor and sides share: no shadow is drawn twice while a map stays.

The sun does not move, so for each point of the plan one number says all of its shadow: the height below which it is
dark. It is found in one sweep away from the sun, n steps for n texels: the highest block that a ray has met, less what
the ray has fallen since. A point is lit if it is above. Beside it stands the mean height around the point: below it,
a corner sees little of the sky.
*/

import { ClampToEdgeWrapping, DataTexture, DataUtils, HalfFloatType, LinearFilter, RGFormat, Vector2 } from "three";
import type { Field } from "./field";

export const SUN = [-0.8, -0.42, 1.0] as const; // towards it; x is the longest of x and y, along which the sweep goes
const TEXELS = 700_000; // of which a map of 400 x 400 cells has two along each
const FINEST = 8; // texels along a cell
const AROUND = 0.8; // cells around a point whose mean height matters

export interface Light {
  texture: DataTexture; // along y and x: the height of the shadow, the mean height
  low: Vector2;
  size: Vector2;
  fall: number; // metres that a ray of the sun falls in a texel
  texel: number; // metres
}

export function lightOn(field: Field): Light {
  const { nX, nY, width } = field;
  const slope = SUN[1] / SUN[0];
  const fallOfCell = (SUN[2] / -SUN[0]) * width;
  const rim = Math.min(60, Math.ceil(field.highest / fallOfCell) + 3);
  const fine = Math.max(1, Math.min(FINEST, Math.floor(Math.sqrt(TEXELS / (nX * nY)))));
  const [wide, high] = [(nX + 2 * rim) * fine, (nY + 2 * rim) * fine];
  const fall = fallOfCell / fine;
  const heights = new Float32Array(wide * high);
  for (let i = 0; i < nX; i++) {
    const first = (rim + i) * fine * high;
    for (let j = 0; j < nY; j++) {
      heights.fill(field.heights[i * nY + j], first + (rim + j) * fine, first + (rim + j + 1) * fine);
    }
    for (let k = 1; k < fine; k++) heights.copyWithin(first + k * high, first, first + high);
  }
  const shadow = shadowOf(heights, wide, high, slope, fall);
  const radius = Math.max(1, Math.round(AROUND * fine));
  const mean = blurred(blurred(heights, wide, high, radius), wide, high, Math.max(1, radius >> 1));
  const both = new Uint16Array(2 * wide * high);
  for (let k = 0; k < shadow.length; k++) {
    // A lit top counts as dark just below itself, so that the foot of every wall is dark alike.
    both[2 * k] = DataUtils.toHalfFloat(Math.max(shadow[k], heights[k] - fall));
    both[2 * k + 1] = DataUtils.toHalfFloat(mean[k]);
  }
  const texture = new DataTexture(both, high, wide, RGFormat, HalfFloatType);
  texture.minFilter = texture.magFilter = LinearFilter;
  texture.wrapS = texture.wrapT = ClampToEdgeWrapping;
  texture.unpackAlignment = 4;
  texture.needsUpdate = true;
  const [low, size] = [new Vector2(field.x(-rim), field.y(-rim)), new Vector2(wide, high).multiplyScalar(width / fine)];
  return { texture, low, size, fall, texel: width / fine };
}

/* The height below which each texel is dark. Rays leave the side of the sun one texel apart, and go from column to
column; a texel is between two of them. */
function shadowOf(heights: Float32Array, wide: number, high: number, slope: number, fall: number): Float32Array {
  const shadow = new Float32Array(wide * high).fill(-fall);
  const before = Math.ceil(slope * wide) + 1; // rays that come in from below the first row
  const rays = new Float32Array(before + high + 2).fill(-fall);
  for (let i = 1; i < wide; i++) {
    for (let k = 0; k < rays.length; k++) {
      const j = Math.round(k - before + slope * (i - 1));
      const met = j >= 0 && j < high ? heights[(i - 1) * high + j] : 0;
      rays[k] = Math.max(rays[k], met) - fall;
    }
    const first = before - slope * i;
    const [whole, part] = [Math.floor(first), first - Math.floor(first)];
    for (let j = 0; j < high; j++) {
      shadow[i * high + j] = (1 - part) * rays[j + whole] + part * rays[j + whole + 1];
    }
  }
  return shadow;
}

/* The mean of the square around each texel, by running sums along one axis and then the other. */
function blurred(values: Float32Array, wide: number, high: number, radius: number): Float32Array {
  return along(along(values, wide, high, 1, high), high, wide, high, 1);

  function along(from: Float32Array, count: number, length: number, step: number, stride: number): Float32Array {
    const made = new Float32Array(from.length);
    for (let line = 0; line < count; line++) {
      const first = line * stride;
      const at = (k: number) => from[first + step * Math.min(length - 1, Math.max(0, k))];
      let sum = 0;
      for (let k = -radius; k <= radius; k++) sum += at(k);
      for (let k = 0; k < length; k++) {
        made[first + step * k] = sum / (2 * radius + 1);
        sum += at(k + radius + 1) - at(k - radius);
      }
    }
    return made;
  }
}
