// The surface over the array: quads between taxels, farthest first, on a 2-D canvas, so that no 3-D hardware is needed.

const RULER = 40;
const heightOf = (width) => Math.min(340, 0.78 * width);

/** From the array (shares of its longer side, heights in shares of the peak) to a canvas of some width. */
function cameraOf(width, turn, tilt) {
  const [cosT, sinT] = [Math.cos(turn), Math.sin(turn)];
  const [cosE, sinE] = [Math.cos(tilt), Math.sin(tilt)];
  const size = Math.min(0.66 * (width - RULER), 360);
  return ([x, y, z]) => {
    const [across, away] = [x * cosT - y * sinT, x * sinT + y * cosT];
    const depth = away * cosE - 0.5 * z * sinE;
    return [(width + RULER) / 2 + size * across, 0.62 * heightOf(width) - size * (away * sinE + 0.5 * z * cosE), depth];
  };
}

function line(pen, from, to, colour) {
  pen.strokeStyle = colour;
  pen.lineWidth = 1;
  pen.beginPath();
  pen.moveTo(from[0], from[1]);
  pen.lineTo(to[0], to[1]);
  pen.stroke();
}

/** The quads between taxels with the depth of their middle, the farthest first. */
function quadsOf(corners) {
  const quads = [];
  for (let row = 0; row + 1 < given.rows; row += 1) {
    for (let column = 0; column + 1 < given.columns; column += 1) {
      const first = row * given.columns + column;
      const around = [first, first + 1, first + given.columns + 1, first + given.columns];
      quads.push({ around, depth: around.reduce((sum, k) => sum + corners[k][2], 0) });
    }
  }
  return quads.sort((a, b) => b.depth - a.depth);
}

function drawFloor(pen, camera, ends) {
  const [x, y] = ends;
  const corners = [[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0]].map(camera);
  corners.forEach((corner, n) => line(pen, corner, corners[(n + 1) % 4], INK.edge));
  pen.fillStyle = INK.faint;
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  const label = (text, place) => pen.fillText(text, ...camera(place).slice(0, 2));
  label("x", [0, -1.14 * y - 0.02, 0]);
  label("y", [-1.14 * x - 0.02, 0, 0]);
}

function drawRuler(pen, camera, ends, unit, peak) {
  const edges = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([x, y]) => [x * ends[0], y * ends[1]]);
  const left = edges.reduce((best, edge) => (camera([...edge, 0])[0] < camera([...best, 0])[0] ? edge : best));
  line(pen, camera([...left, -0.25]), camera([...left, 1]), INK.edge);
  pen.fillStyle = INK.faint;
  pen.textAlign = "right";
  for (const share of [0, 0.5, 1]) {
    const [x, y] = camera([...left, share]);
    line(pen, [x - 4, y], [x, y], INK.edge);
    pen.fillText(unit.of(-share * peak || 0), x - 7, y);
  }
}

/** Draw `values` of a frame with pressure up; `unit` and `peak` are the ruler's. */
function drawSurface(canvas, { values, peak, unit, root, turn, tilt }) {
  const width = canvas.clientWidth;
  const pen = prepared(canvas, heightOf(width));
  const longer = Math.max(given.columns * given.pitch[0], given.rows * given.pitch[1]);
  const ends = [(given.columns - 1) * given.pitch[0], (given.rows - 1) * given.pitch[1]].map((end) => end / longer / 2);
  const camera = cameraOf(width, turn, tilt);
  const share = (k) => (peak > 0 ? values[k] / peak : 0);
  const corners = Array.from(values, (_, k) => {
    const [x, y] = placeOf(k);
    return camera([x / longer - ends[0], y / longer - ends[1], -share(k)]);
  });
  drawFloor(pen, camera, ends);
  drawRuler(pen, camera, ends, unit, peak);
  pen.lineWidth = 0.6;
  pen.strokeStyle = "#555";
  for (const { around } of quadsOf(corners)) {
    pen.beginPath();
    around.forEach((k, n) => pen[n ? "lineTo" : "moveTo"](corners[k][0], corners[k][1]));
    pen.closePath();
    pen.fillStyle = colourOf(bent(around.reduce((sum, k) => sum + share(k), 0) / 4, root));
    pen.fill();
    pen.stroke();
  }
}
