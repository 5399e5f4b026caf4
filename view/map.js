// The map of a frame: stress as colours, forces as arrows and circles, the two centroids.

// From compression through zero to traction: ColorBrewer's red and blue, which colour-blind readers distinguish.
const COLOURS = [
  [5, 48, 97], [33, 102, 172], [67, 147, 195], [146, 197, 222], [209, 229, 240], [247, 247, 247],
  [253, 219, 199], [244, 165, 130], [214, 96, 77], [178, 24, 43], [103, 0, 31],
];
const EDGE = { left: 38, right: 10, top: 10, bottom: 36 };
const TALLEST = 460;

/** The colour of a share of the peak, -1 to 1. */
function colourOf(share) {
  const place = (Math.min(1, Math.max(-1, share)) + 1) * 5;
  const low = Math.min(9, Math.floor(place));
  const mixed = COLOURS[low].map((from, part) => Math.round(from + (place - low) * (COLOURS[low + 1][part] - from)));
  return `rgb(${mixed.join(",")})`;
}

/** From a share of the peak to its colour's position, and back: square roots make faint traction visible. */
const bent = (share, root) => (root ? Math.sign(share) * Math.sqrt(Math.abs(share)) : share);
const straight = (share, root) => (root ? share * Math.abs(share) : share);

/** Set a canvas's resolution to its size on the page times the device pixel ratio; draw in CSS pixels. */
function prepared(canvas, height) {
  const dots = window.devicePixelRatio || 1;
  const width = canvas.clientWidth;
  const [across, down] = [Math.round(width * dots), Math.round(height * dots)];
  if (canvas.width !== across || canvas.height !== down) {
    canvas.style.height = `${height}px`;
    [canvas.width, canvas.height] = [across, down];
  }
  const pen = canvas.getContext("2d");
  pen.setTransform(dots, 0, 0, dots, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.font = "12px system-ui, sans-serif";
  return pen;
}

/** Where the taxels are in a canvas of some width; row 0 is at the bottom, as y points up. */
function gridOf(width) {
  const ratio = given.pitch[1] / given.pitch[0];
  const across = Math.min((width - EDGE.left - EDGE.right) / given.columns, TALLEST / (given.rows * ratio));
  const down = across * ratio;
  const left = EDGE.left + Math.max(0, (width - EDGE.left - EDGE.right - across * given.columns) / 2);
  const bottom = EDGE.top + down * given.rows;
  const at = ([x, y]) => [left + across * (x / given.pitch[0] + 0.5), bottom - down * (y / given.pitch[1] + 0.5)];
  const taxelAt = (x, y) => {
    const [column, row] = [Math.floor((x - left) / across), Math.floor((bottom - y) / down)];
    return column >= 0 && column < given.columns && row >= 0 && row < given.rows ? row * given.columns + column : -1;
  };
  return { across, down, left, bottom, at, taxelAt, height: bottom + EDGE.bottom };
}

/** Stroke the path of `trace` with a pale rim, visible on dark and pale colours. */
function rimmed(pen, trace, width = 2, colour = "#111") {
  for (const [shade, wide] of [["#fff", width + Math.min(2.5, 1.6 * width)], [colour, width]]) {
    pen.strokeStyle = shade;
    pen.lineWidth = wide;
    pen.beginPath();
    trace(pen);
    pen.stroke();
  }
}

function arrow(pen, [x, y], [dx, dy], width, colour) {
  const length = modulus(dx, dy);
  if (length < 1.5) return;
  const head = Math.min(7, 0.45 * length);
  const [ux, uy] = [dx / length, dy / length];
  rimmed(pen, () => {
    pen.moveTo(x, y);
    pen.lineTo(x + dx, y + dy);
    for (const side of [1, -1]) {
      pen.moveTo(x + dx, y + dy);
      pen.lineTo(x + dx - head * (ux + 0.6 * side * uy), y + dy - head * (uy - 0.6 * side * ux));
    }
  }, width, colour);
}

function drawAxes(pen, grid) {
  const ticks = (count, room) => Array.from({ length: count }, (_, n) => n).filter((n) => n % Math.ceil(count / room) === 0);
  pen.fillStyle = "#333";
  pen.textAlign = "center";
  pen.textBaseline = "top";
  for (const column of ticks(given.columns, (grid.across * given.columns) / 34)) {
    const [x] = grid.at([column * given.pitch[0], 0]);
    pen.fillText(figures(column * given.pitch[0]), x, grid.bottom + 4);
  }
  pen.fillText("x / mm", grid.left + (grid.across * given.columns) / 2, grid.bottom + 20);
  pen.textAlign = "right";
  pen.textBaseline = "middle";
  for (const row of ticks(given.rows, (grid.down * given.rows) / 20)) {
    const [, y] = grid.at([0, row * given.pitch[1]]);
    pen.fillText(figures(row * given.pitch[1]), grid.left - 5, y);
  }
  pen.save();
  pen.translate(grid.left - 32, grid.bottom - (grid.down * given.rows) / 2);
  pen.rotate(-Math.PI / 2);
  pen.textAlign = "center";
  pen.fillText("y / mm", 0, 0);
  pen.restore();
}

function drawForces(pen, grid, scene) {
  const least = Math.min(grid.across, grid.down);
  const width = Math.min(1.6, Math.max(0.5, least / 14));
  for (let k = 0; k < TAXELS; k += 1) {
    const centre = grid.at(placeOf(k));
    const [fx, fy, fz] = scene.forces.map((force) => force[k]);
    if (scene.circles && scene.peaks.normal > 0) {
      const radius = 0.46 * least * Math.sqrt(Math.abs(fz) / scene.peaks.normal);
      pen.setLineDash(fz > 0 ? [3, 3] : []);
      if (radius > 0.8) rimmed(pen, () => pen.arc(...centre, radius, 0, 2 * Math.PI), 0.8 * width);
      pen.setLineDash([]);
    }
    if (scene.arrows && scene.peaks.tangential > 0) {
      const size = (1.6 * least) / scene.peaks.tangential;
      arrow(pen, centre, [size * fx, -size * fy], width);
    }
  }
}

/** The tangential part of the resultant, from the centroid of compression. */
function drawResultant(pen, grid, { c, resultant, peaks }) {
  if (!c || !peaks.resultant) return;
  const size = (0.15 * (grid.across * given.columns + grid.down * given.rows)) / peaks.resultant;
  arrow(pen, grid.at(c), [size * resultant[0], -size * resultant[1]], 4, "#00704F");
}

function drawCentroids(pen, grid, { c, t, directed }) {
  if (directed && c && t) {
    const [from, to] = [grid.at(t), grid.at(c)];
    arrow(pen, from, [to[0] - from[0], to[1] - from[1]], 3);
  }
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  for (const [place, letter, round] of [[c, "c", true], [t, "t", false]]) {
    if (!place) continue;
    const [x, y] = grid.at(place);
    rimmed(pen, () => (round ? pen.arc(x, y, 8, 0, 2 * Math.PI) : pen.rect(x - 7.5, y - 7.5, 15, 15)));
    pen.fillStyle = "#fff";
    pen.fill();
    pen.fillStyle = "#111";
    pen.fillText(letter, x, y - 0.5);
  }
}

/** Draw the stress of a frame, scaled by the peak, in a frame with axes; returns the pen and where the taxels are. */
function drawStress(canvas, { stress, peak, root }) {
  const grid = gridOf(canvas.clientWidth);
  const pen = prepared(canvas, grid.height);
  for (let k = 0; k < TAXELS; k += 1) {
    const [x, y] = grid.at(placeOf(k));
    pen.fillStyle = colourOf(bent(stress[k] / (peak || 1), root));
    pen.fillRect(x - grid.across / 2, y - grid.down / 2, grid.across + 0.4, grid.down + 0.4);
  }
  pen.strokeStyle = "#767676";
  pen.strokeRect(grid.left, EDGE.top, grid.across * given.columns, grid.down * given.rows);
  drawAxes(pen, grid);
  return { pen, grid };
}

/** Draw one map; the scene has stress and forces of a frame, their peaks, and what is to be shown. */
function drawMap(canvas, scene) {
  const { pen, grid } = drawStress(canvas, { ...scene, peak: scene.peaks.stress });
  if (scene.forces) drawForces(pen, grid, scene);
  if (scene.whole) drawResultant(pen, grid, scene);
  if (scene.centroids) drawCentroids(pen, grid, scene);
  const [x, y] = grid.at(placeOf(scene.taxel));
  rimmed(pen, () => pen.rect(x - grid.across / 2 + 1, y - grid.down / 2 + 1, grid.across - 2, grid.down - 2), 1.5);
}

/** The legend's bar of colours. */
function paintBar() {
  $("bar").style.background = `linear-gradient(to right, ${COLOURS.map((_, n) => colourOf(n / 5 - 1)).join(",")})`;
}

/** The stress at the ticks of the legend, whose end is the peak. */
function drawTicks(peak, root) {
  for (const tick of document.querySelectorAll("#legend [data-share]")) {
    say(tick, STRESS.of(straight(Number(tick.dataset.share), root) * peak));
  }
}
