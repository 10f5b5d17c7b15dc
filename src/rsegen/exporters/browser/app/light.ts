/* The light on a map, as a texture that blocks, floor and sides share: no shadow is drawn twice while a map stays.

The sun does not move, so for each point of the plan one number says all of its shadow: the height below which it is
dark. It is found in one sweep away from the sun, n steps for n texels: the height of the neighbour towards the sun,
or of its shadow, less what the ray falls in between. A point is lit if it is above. Beside it stands the mean height
around the point, above which corners are open to the sky and below which they are not.
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
  const shadow = new Float32Array(wide * high);
  for (let i = 0; i < wide; i++) {
    // Rays go from texel to texel, so that shadows stay sharp however far they fall.
    const aside = Math.round(slope * i) - Math.round(slope * (i - 1));
    for (let j = 0; j < high; j++) {
      const from = (i - 1) * high + j - aside;
      const isInside = i > 0 && j >= aside;
      shadow[i * high + j] = (isInside ? Math.max(heights[from], shadow[from]) : 0) - fall;
    }
  }
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
