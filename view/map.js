// The map of a frame: stress or residual as colours, forces as arrows and circles, the two centroids, dead taxels.

/** From compression through zero to tension: red, green and blue. */
const COLOURS = given.colours.map((hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16)));
/** Pixels of the longest number at the axis of y. */
const LABEL = 7 * Math.max(...Array.from({ length: given.rows }, (_, row) => figures(row * given.pitch[1]).length));
const EDGE = { left: 26 + LABEL, right: 10, top: 8, bottom: 36 };
const GREEN = "#00704F";
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

/** A circle whose area is that of one with the radius `most`, times a share; dashed where the share is of a force that pulls. */
function circle(pen, centre, most, share, width, colour) {
  const radius = most * Math.sqrt(Math.abs(share));
  if (!(radius > 0.8)) return;
  pen.setLineDash(share > 0 ? [3 * width, 2.5 * width] : []);
  rimmed(pen, () => pen.arc(...centre, radius, 0, 2 * Math.PI), width, colour);
  pen.setLineDash([]);
}

function drawAxes(pen, grid) {
  const ticks = (count, room) => Array.from({ length: count }, (_, n) => n).filter((n) => n % Math.ceil(count / room) === 0);
  pen.fillStyle = INK.faint;
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
  pen.translate(grid.left - LABEL - 16, grid.bottom - (grid.down * given.rows) / 2);
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
    if (scene.circles) circle(pen, centre, 0.46 * least, fz / scene.peaks.normal, 0.8 * width);
    if (scene.arrows && scene.peaks.tangential > 0) {
      const size = (1.6 * least) / scene.peaks.tangential;
      arrow(pen, centre, [size * fx, -size * fy], width);
    }
  }
}

/** The resultant at the centroid of compression: an arrow along its tangential part, a circle with the area of F_z. */
function drawResultant(pen, grid, { c, resultant, peaks }) {
  if (!c) return;
  const [x, y, z] = resultant;
  const most = 0.15 * (grid.across * given.columns + grid.down * given.rows);
  circle(pen, grid.at(c), 0.8 * most, z / peaks.pressing, 2.5, GREEN);
  if (peaks.resultant > 0) arrow(pen, grid.at(c), [(most * x) / peaks.resultant, (-most * y) / peaks.resultant], 4, GREEN);
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

/** Draw values of the taxels, scaled by the peak, in a frame with axes; returns the pen and where the taxels are. */
function drawPlane(canvas, { values, peak, root, dead }) {
  const grid = gridOf(canvas.clientWidth);
  const pen = prepared(canvas, grid.height);
  const whole = [grid.left, EDGE.top, grid.across * given.columns, grid.down * given.rows];
  pen.fillStyle = colourOf(0);  // no dark page between the taxels
  pen.fillRect(...whole);
  for (let k = 0; k < TAXELS; k += 1) {
    const [x, y] = grid.at(placeOf(k));
    pen.fillStyle = colourOf(bent(values[k] / (peak || 1), root));
    pen.fillRect(x - grid.across / 2, y - grid.down / 2, grid.across + 0.4, grid.down + 0.4);
  }
  for (const k of dead) drawCross(pen, grid, k);
  pen.lineWidth = 1;
  pen.strokeStyle = INK.edge;
  pen.strokeRect(...whole);
  drawAxes(pen, grid);
  return { pen, grid };
}

/** Draw one map; the scene has stress, residual and forces of a frame, their peaks, and what is to be shown. */
function drawMap(canvas, scene) {
  const { pen, grid } = drawPlane(canvas, { ...scene, values: scene[scene.of] ?? new Float32Array(TAXELS), peak: scene.peaks[scene.of] });
  if (scene.forces) drawForces(pen, grid, scene);
  if (scene.whole) drawResultant(pen, grid, scene);
  if (scene.centroids) drawCentroids(pen, grid, scene);
  const [x, y] = grid.at(placeOf(scene.taxel));
  rimmed(pen, () => pen.rect(x - grid.across / 2 + 1, y - grid.down / 2 + 1, grid.across - 2, grid.down - 2), 1.5);
}

/** What the legend says of dead taxels. */
const CROSSED = "×: dead, its neighbours stand in for it";

function drawCross(pen, grid, k) {
  const [x, y] = grid.at(placeOf(k));
  const [dx, dy] = [0.3 * grid.across, 0.3 * grid.down];
  rimmed(pen, () => {
    for (const side of [1, -1]) {
      pen.moveTo(x - dx, y - side * dy);
      pen.lineTo(x + dx, y + side * dy);
    }
  }, Math.min(2, Math.max(0.8, grid.across / 12)));
}

/** Say what the marks of a map mean, a line for each. */
function drawKey(lines) {
  const items = $("key").children;
  while (items.length > lines.length) items[items.length - 1].remove();
  lines.forEach((text, n) => say(items[n] ?? $("key").appendChild(document.createElement("li")), text));
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
