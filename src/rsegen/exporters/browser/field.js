/* One map of the page's data: what stands in each cell. Cell (0, 0) is in the corner of smallest x and y. */

class Field {
  constructor(data) {
    [this.nX, this.nY] = data.cells;
    this.width = data.block_width;
    this.palette = data.palette;
    this.unit = data.unit;
    this.block = data.block;
    this.cells = decoded(data.content, data.bytes);
    this.tops = Float64Array.from(this.palette, (entry) => entry.height);
    this.highest = Math.max(0, ...this.tops);
    this.blockX = blockIndices(this.nX, (i) => this.hasBlock(this.nY, (k) => i * this.nY + k));
    this.blockY = blockIndices(this.nY, (j) => this.hasBlock(this.nX, (k) => k * this.nY + j));
  }

  /* Whether a line of cells has a block, and is not all frame. */
  hasBlock(count, place) {
    for (let k = 0; k < count; k++) {
      if (this.palette[this.cells[place(k)]].level !== null) return true;
    }
    return false;
  }

  entry(i, j) {
    return this.palette[this.cells[i * this.nY + j]];
  }

  /* Height of a cell in metres; 0 outside. */
  height(i, j) {
    if (i < 0 || j < 0 || i >= this.nX || j >= this.nY) return 0;
    return this.tops[this.cells[i * this.nY + j]];
  }

  /* Metres of the edge before cell i along x, or j along y; the map's centre is the origin. */
  x(i) {
    return (i - this.nX / 2) * this.width;
  }

  y(j) {
    return (j - this.nY / 2) * this.width;
  }

  /* What a cell is, in words: its place in the recipe, its level and height, its place in metres. */
  described(i, j) {
    const entry = this.entry(i, j);
    const at = `x ${metres(this.x(i + 0.5))} m, y ${metres(this.y(j + 0.5))} m`;
    const height = `${entry.label} ${this.unit}`;
    if (entry.level === null) return { height, place: "frame", at };
    return { height, place: `cell ${this.blockX[i]}, ${this.blockY[j]} · level ${entry.level}`, at };
  }
}

function decoded(text, bytes) {
  const raw = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  if (bytes === 1) return raw;
  const numbers = new DataView(raw.buffer);
  return Uint16Array.from({ length: raw.length / 2 }, (_, k) => numbers.getUint16(2 * k, true));
}

/* The number of each line among those that have blocks; -1 for lines that are all frame. */
function blockIndices(count, hasBlock) {
  let next = 0;
  return Int32Array.from({ length: count }, (_, line) => (hasBlock(line) ? next++ : -1));
}

function metres(value) {
  return (Math.round(value * 1000) / 1000 + 0).toString().replace("-", "−");
}

/* The smallest of 1, 2, 5, 10, 20, ... times `least` that is not below `wanted`. */
function niceStep(wanted, least) {
  for (let power = least; ; power *= 10) {
    for (const factor of [1, 2, 5]) {
      if (factor * power >= wanted * (1 - 1e-9)) return factor * power;
    }
  }
}
