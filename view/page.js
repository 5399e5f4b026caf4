// The frame shown: its maps, its numbers, its sweep.

const maps = results.map((_, n) => $(`map-${n}`));
const state = { frame: 0, taxel: 0, playing: false, turn: -0.6, tilt: 0.5, drawn: false, sweepAgain: 0 };
/** While frames play: milliseconds between two sweeps, at least, and as a multiple of the time that one takes. */
const PAUSE = { least: 150, times: 20 };
const TURNS = { turn: [-Math.PI, Math.PI], tilt: [0.1, 1.5] };

const detailed = () => results[Number($("detail").value)];
const checked = (id) => $(id).checked;

const peaksOf = (frame) => ($("over").value === "all" ? PEAKS : peaksAt(frame));

/** All that the page shows of one frame of one result. */
function sceneOf(result, frame) {
  const stress = plane(result.stress, frame);
  const regular = !has(result, frame, given.bits.withoutForce);
  const { f_x: x, f_y: y, f_z: z } = result.values;
  return {
    stress,
    left: result.left && plane(result.left, frame),
    dead: result.dead,
    forces: result.forces?.map((force) => plane(force, frame)),
    resultant: [x[frame], y[frame], z[frame]],
    c: has(result, frame, given.bits.noContact) ? undefined : centroid(stress, -1),
    t: regular ? centroid(stress, 1) : undefined,
    directed: Boolean(result.sweep),
    implausible: has(result, frame, given.bits.implausible),
  };
}

function drawLegend(peaks) {
  const of = $("of").value;
  drawTicks(peaks[of], $("scale").value === "root");
  say($("coloured"), of === "stress" ? "stress" : "residual");
  const legend = [];
  const unit = unitFor(Math.max(PEAKS.resultant, PEAKS.pressing), "N");
  if (checked("resultant")) {
    legend.push(`green arrow from c: tangential part of the resultant, longest ${unit.of(peaks.resultant)} ${unit.name}`);
    legend.push(`area of the green circle: |F_z| of the resultant, largest ${unit.of(peaks.pressing)} ${unit.name}; dashed: pulls`);
  }
  if (distributed && checked("arrows")) legend.push(`longest small arrow (tangential, 1.6 taxels): ${FORCE.of(peaks.tangential)} ${FORCE.name}`);
  if (distributed && checked("circles")) legend.push(`largest circle (normal): ${FORCE.of(peaks.normal)} ${FORCE.name}; dashed: pulls`);
  if (checked("centroids")) legend.push(`c, t: centroids of compression and traction${swept ? "; TFRA finds φ as the direction from t to c" : ""}`);
  if (results.some(({ dead }) => dead.length)) legend.push(CROSSED);
  drawKey(legend);
}

const pair = (place) => (place ? place.map((length) => length.toFixed(2)).join(", ") : "–");

/** The uncertainty beside its threshold, as the status was decided. */
function uncertainty(result, frame) {
  const share = valueOf(result, "uncertainty", frame);
  if (share === undefined) return "–";
  if (result.values.f_z[frame] >= 0) return "F does not press";
  return `${figures(share)} ${has(result, frame, given.bits.implausible) ? ">" : "≤"} ${figures(result.threshold)}`;
}

/** The cells of a row of numbers: a function of result and scene, and the name of a reference value. */
const ROWS = {
  ...Object.fromEntries(["phi", "mu", "f", "f_x", "f_y", "f_z", "residual"].map((name) => [name, (result, frame) => figures(valueOf(result, name, frame))])),
  mu_x: (result, frame) => figures(valueOf(result, "mu_x", frame)),
  mu_y: (result, frame) => figures(valueOf(result, "mu_y", frame)),
  uncertainty,
  c: (_, __, scene) => pair(scene.c),
  t: (_, __, scene) => pair(scene.t),
  status: (result, frame) => given.statuses.filter(({ bit }) => has(result, frame, bit)).map(({ words }) => words).join(", ") || "contact",
  "taxel-stress": (_, __, scene) => STRESS.of(scene.stress[state.taxel]),
  "taxel-left": (_, __, scene) => STRESS.of(scene.left?.[state.taxel]),
  "taxel-x": (_, __, scene) => FORCE.of(scene.forces?.[0][state.taxel]),
  "taxel-y": (_, __, scene) => FORCE.of(scene.forces?.[1][state.taxel]),
  "taxel-z": (_, __, scene) => FORCE.of(scene.forces?.[2][state.taxel]),
};

function drawNumbers(frame, scenes) {
  for (const row of document.querySelectorAll("#now tr[data-row]")) {
    const name = row.dataset.row;
    const cells = row.querySelectorAll("td");
    results.forEach((result, n) => {
      say(cells[n], ROWS[name](result, frame, scenes[n]));
      cells[n].classList.toggle("flagged", name === "status" && scenes[n].implausible);
    });
    references.filter(({ values }) => values[name]).forEach(({ values }) => {
      say(cells[results.length + references.findIndex((known) => known.values === values)], figures(values[name][frame]));
    });
  }
  const [column, row] = [state.taxel % given.columns, Math.floor(state.taxel / given.columns)];
  $("row").value = row;
  $("column").value = column;
}

/** Canvases and the cursor come first: they read sizes, which a changed text invalidates. */
function drawMaps(frame, scenes) {
  const peaks = peaksOf(frame);
  const chosen = { whole: checked("resultant"), arrows: checked("arrows"), circles: checked("circles"), centroids: checked("centroids") };
  const shown = { ...chosen, of: $("of").value, root: $("scale").value === "root", peaks, taxel: state.taxel };
  maps.forEach((map, n) => {
    drawMap(map, { ...scenes[n], ...shown });
    map.parentElement.classList.toggle("flagged", scenes[n].implausible);
    const told = ["phi", "mu", "f"].map((name) => ROWS[name](results[n], frame));
    const label = `Map of the ${shown.of === "stress" ? "stress" : "residual"} under ${results[n].label}, frame ${numberOf(frame)}`;
    map.setAttribute("aria-label", `${label}: φ ${told[0]}°, μ ${told[1]}, |F| ${told[2]} N${scenes[n].implausible ? ", implausible" : ""}; the table This frame has all numbers`);
  });
  drawHeights(frame, scenes, peaks, shown.root);
  if (state.drawn) moveCursor($("cursor"), $("panels"), frame);
  drawLegend(peaks);
}

function drawHeights(frame, scenes, peaks, root) {
  const scene = scenes[Number($("detail").value)];
  $("height").options[1].disabled = !scene.forces;
  if (!scene.forces) $("height").value = "stress";
  const stress = $("height").value === "stress";
  drawSurface($("surface"), {
    values: stress ? scene.stress : scene.forces[2], unit: stress ? STRESS : FORCE,
    peak: stress ? peaks.stress : peaks.normal, root, turn: state.turn, tilt: state.tilt,
  });
  say($("height-unit"), stress ? STRESS.name : FORCE.name);
}

/** Draw what is left out while frames play: the sweep. */
function settle() {
  if (!swept) return;
  const begun = performance.now();
  const of = drawSweep($("sweep"), detailed(), state.frame);
  $("sweep-of").textContent = of === state.frame ? "" : `The sweep shown is that of frame ${numberOf(of)}.`;
  const done = performance.now();
  state.sweepAgain = done + Math.max(PAUSE.least, PAUSE.times * (done - begun));
}

function drawAll() {
  const { frame } = state;
  const scenes = results.map((result) => sceneOf(result, frame));
  drawMaps(frame, scenes);
  drawNumbers(frame, scenes);
  tellFrame();
  if (!state.playing || performance.now() > state.sweepAgain) settle();
}

function pick(taxel) {
  if (taxel < 0 || taxel === state.taxel) return;
  state.taxel = taxel;
  show(state.frame);
}

function listen() {
  listenToFrames();
  for (const id of ["resultant", "arrows", "circles", "centroids", "of", "over", "scale", "detail", "height"]) $(id).addEventListener("change", drawAll);
  for (const map of maps) {
    for (const kind of ["pointermove", "pointerdown"]) {
      map.addEventListener(kind, ({ offsetX, offsetY }) => pick(gridOf(map.clientWidth).taxelAt(offsetX, offsetY)));
    }
  }
  for (const [id, most, each] of [["row", given.rows, given.columns], ["column", given.columns, 1]]) {
    $(id).addEventListener("change", ({ target }) => {
      const other = id === "row" ? state.taxel % given.columns : state.taxel - (state.taxel % given.columns);
      state.taxel = other + each * Math.min(most - 1, Math.max(0, Math.round(Number(target.value)) || 0));
      drawAll();
    });
  }
  for (const [id, [low, high]] of Object.entries(TURNS)) {
    const set = () => { $(id).value = (100 * (state[id] - low)) / (high - low); };
    set();
    $(id).addEventListener("input", () => { state[id] = low + (Number($(id).value) / 100) * (high - low); drawAll(); });
    $("surface").addEventListener("pointermove", ({ buttons, movementX, movementY }) => {
      if (!buttons) return;
      const turned = state[id] + (id === "turn" ? movementX : movementY) / 120;
      state[id] = id === "turn" ? ((turned + 3 * Math.PI) % (2 * Math.PI)) - Math.PI : Math.min(high, Math.max(low, turned));
      set();
      drawAll();
    });
  }
  listenToSaving();
  listenToLooks();
}

function strongest(frame) {
  const stress = plane(results[0].stress, frame);
  return stress.reduce((best, value, k) => (Math.abs(value) > Math.abs(stress[best]) ? k : best), 0);
}

/** What is shown only if a result has it. */
const PARTS = {
  "#swept": swept, "#explained, [data-row=residual]": tested, "[data-row=uncertainty], #judged, #shaded": judged, "#alone": results.some(({ forces }) => !forces),
  "label:has(#of), label:has(#arrows), label:has(#circles), [data-row=taxel-left], [data-row=taxel-x], [data-row=taxel-y], [data-row=taxel-z]": distributed,
};

function hideMissing() {
  for (const [places, present] of Object.entries(PARTS)) {
    for (const place of document.querySelectorAll(places)) place.hidden = !present;
  }
  $("alone").textContent = results.filter(({ forces }) => !forces).map(({ label }) => `${label}: ${given.resultantAlone}.`).join(" ");
}

/** Show `frame`, and start to listen to events. */
function begin(frame) {
  paintBar();
  measure();
  hideMissing();
  state.frame = frame;
  state.taxel = strongest(frame);
  listen();
  drawAll();
  return drawPanels($("panels")).then(() => {
    state.drawn = true;
    followChart();
    document.body.dataset.ready = "yes";
  });
}
