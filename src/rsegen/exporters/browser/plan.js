/* The plan: north up; cells of the recipe are counted below and on the left, metres above and on the right. */

const MARGIN = { left: 34, right: 44, top: 26, bottom: 28 };
const LEGIBLE = 17; // CSS pixels that a cell must have so that its height is written into it
const LINED = 5; // and so that it has an outline

class Plan {
  constructor(canvas, mark, note) {
    Object.assign(this, { canvas, mark, note });
    new ResizeObserver(() => this.draw()).observe(canvas.parentElement);
  }

  show(field) {
    this.field = field;
    this.picture = pictureOf(field);
    this.draw();
  }

  draw() {
    const { canvas, field } = this;
    const room = canvas.parentElement.clientWidth;
    if (!field || !room) return;
    const across = room - MARGIN.left - MARGIN.right;
    this.size = Math.min(across / field.nX, Math.max(across, 340) / field.nY);
    const [wide, high] = [this.size * field.nX, this.size * field.nY];
    this.left = MARGIN.left + (across - wide) / 2;
    const sharp = window.devicePixelRatio || 1;
    canvas.width = Math.round(room * sharp);
    canvas.height = Math.round((high + MARGIN.top + MARGIN.bottom) * sharp);
    canvas.style.height = `${high + MARGIN.top + MARGIN.bottom}px`;
    const pen = canvas.getContext("2d");
    pen.scale(sharp, sharp);
    pen.imageSmoothingEnabled = this.size < 1;
    pen.drawImage(this.picture, this.left, MARGIN.top, wide, high);
    if (this.size >= LINED) this.drawLines(pen, wide, high);
    if (this.size >= LEGIBLE) this.drawHeights(pen);
    this.note.textContent = `${this.size >= LEGIBLE ? `heights in ${field.unit}, ` : ""}cells of ${field.block}`;
    this.drawCells(pen, high);
    this.drawMetres(pen, wide);
  }

  /* Left and top of a cell, in CSS pixels. */
  corner(i, j) {
    return [this.left + i * this.size, MARGIN.top + (this.field.nY - 1 - j) * this.size];
  }

  drawLines(pen, wide, high) {
    pen.strokeStyle = `rgb(0 0 0 / ${this.size >= LEGIBLE ? 0.3 : 0.18})`;
    pen.lineWidth = 1;
    pen.beginPath();
    for (let i = 0; i <= this.field.nX; i++) {
      pen.moveTo(this.left + i * this.size, MARGIN.top);
      pen.lineTo(this.left + i * this.size, MARGIN.top + high);
    }
    for (let j = 0; j <= this.field.nY; j++) {
      pen.moveTo(this.left, MARGIN.top + j * this.size);
      pen.lineTo(this.left + wide, MARGIN.top + j * this.size);
    }
    pen.stroke();
  }

  drawHeights(pen) {
    const { field, size } = this;
    const longest = Math.max(...field.palette.map((entry) => entry.label.length));
    pen.font = `${Math.min(13, size * 0.5, (size * 1.5) / longest)}px system-ui, sans-serif`;
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    for (let i = 0; i < field.nX; i++) {
      for (let j = 0; j < field.nY; j++) {
        const entry = field.entry(i, j);
        if (entry.level === null) continue;
        const [x, y] = this.corner(i, j);
        pen.fillStyle = isDark(entry.colour) ? "#ffffff" : "#000000";
        pen.fillText(entry.label, x + size / 2, y + size / 2);
      }
    }
  }

  drawCells(pen, high) {
    const { field, size } = this;
    const step = niceStep(20 / size, 1);
    this.text(pen, "center", "top");
    field.blockX.forEach((block, i) => {
      if (block >= 0 && block % step === 0) pen.fillText(block, this.left + (i + 0.5) * size, MARGIN.top + high + 5);
    });
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    field.blockY.forEach((block, j) => {
      if (block >= 0 && block % step === 0) pen.fillText(block, this.left - 6, MARGIN.top + (field.nY - 0.5 - j) * size);
    });
    pen.textAlign = "left";
    pen.textBaseline = "top";
    pen.fillText("cell", Math.max(0, this.left - 30), MARGIN.top + high + 5);
  }

  drawMetres(pen, wide) {
    const { field, size } = this;
    const step = niceStep((52 * field.width) / size, 0.01);
    const marks = (half) => {
      const most = Math.floor(half / step + 1e-9);
      return Array.from({ length: 2 * most + 1 }, (_, k) => (k - most) * step);
    };
    this.text(pen, "center", "bottom");
    pen.strokeStyle = this.colour("--soft");
    pen.beginPath();
    for (const x of marks((field.nX * field.width) / 2)) {
      const at = this.left + (x / field.width + field.nX / 2) * size;
      pen.fillText(metres(x), at, MARGIN.top - 6);
      pen.moveTo(at, MARGIN.top - 4);
      pen.lineTo(at, MARGIN.top);
    }
    pen.textAlign = "left";
    pen.textBaseline = "middle";
    for (const y of marks((field.nY * field.width) / 2)) {
      const at = MARGIN.top + (field.nY / 2 - y / field.width) * size;
      pen.fillText(metres(y), this.left + wide + 7, at);
      pen.moveTo(this.left + wide, at);
      pen.lineTo(this.left + wide + 4, at);
    }
    pen.stroke();
    pen.textBaseline = "top";
    pen.fillText("m", this.left + wide + 8, MARGIN.top + field.nY * size + 5);
  }

  text(pen, align, baseline) {
    Object.assign(pen, { font: "11px system-ui, sans-serif", textAlign: align, textBaseline: baseline });
    pen.fillStyle = this.colour("--soft");
  }

  colour(name) {
    return getComputedStyle(this.canvas).getPropertyValue(name);
  }

  /* The cell at a place of the canvas, in CSS pixels; null outside. */
  cellAt(x, y) {
    const { field, size } = this;
    const [i, j] = [Math.floor((x - this.left) / size), field.nY - 1 - Math.floor((y - MARGIN.top) / size)];
    return i >= 0 && j >= 0 && i < field.nX && j < field.nY ? [i, j] : null;
  }

  highlight(cell) {
    this.mark.hidden = !cell;
    if (!cell) return;
    const [x, y] = this.corner(...cell);
    const size = Math.max(this.size, 5);
    const shift = (this.size - size) / 2;
    Object.assign(this.mark.style, {
      left: `${x + shift}px`,
      top: `${y + shift}px`,
      width: `${size}px`,
      height: `${size}px`,
    });
  }
}

/* A canvas with a pixel for each cell, north up. */
function pictureOf(field) {
  const picture = document.createElement("canvas");
  [picture.width, picture.height] = [field.nX, field.nY];
  const pen = picture.getContext("2d");
  const content = pen.createImageData(field.nX, field.nY);
  const colours = field.palette.map((entry) => rgb(entry.colour));
  for (let i = 0; i < field.nX; i++) {
    for (let j = 0; j < field.nY; j++) {
      const at = 4 * ((field.nY - 1 - j) * field.nX + i);
      content.data.set([...colours[field.cells[i * field.nY + j]], 255], at);
    }
  }
  pen.putImageData(content, 0, 0);
  return picture;
}

function rgb(colour) {
  return colour.match(/\w\w/g).map((part) => parseInt(part, 16));
}

function isDark(colour) {
  const [red, green, blue] = rgb(colour);
  return 0.3 * red + 0.59 * green + 0.11 * blue < 128;
}
