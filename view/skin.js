// The frame shown of a skin: the map with its contacts, and their table.

const unpackResult = (result) => ({
  ...result,
  values: unpackAll(result.values), status: unpack(result.status), found: unpack(result.found),
  dropped: unpack(result.dropped), stress: unpackAll(result.stress),
});

const results = given.results.map(unpackResult);
const [skin] = results;
const judged = skin.threshold !== undefined;
let times = given.time && unpack(given.time);
let COUNT = skin.found.length;
const state = { frame: 0, playing: false, drawn: false, chosen: -1 };

/** The contacts of a frame: values by name, place of the values, and status. */
function contactsAt(frame) {
  return Array.from({ length: skin.found[frame] }, (_, n) => {
    const at = frame * given.slots + n;
    const values = Object.fromEntries(Object.entries(skin.values).map(([name, all]) => [name, all[at]]));
    return { ...values, status: skin.status[at] };
  });
}

/** Whether a contact determines a value: without a tangential force there is no angle. */
function tells(name, status) {
  if (["mu", "phi"].includes(name) && status & given.bits.withoutForce) return false;
  return name !== "phi" || !(status & given.bits.noDirection);
}

let [PEAKS, STRESS] = [];

/** The largest magnitudes of these frames. */
function peaksOf(first, end) {
  let [stress, force, pressing] = [0, 0, 0];
  for (let frame = first; frame < end; frame += 1) {
    stress = Math.max(stress, TOP * skin.stress.scale[frame]);
    for (let at = frame * given.slots; at < frame * given.slots + skin.found[frame]; at += 1) {
      force = Math.max(force, modulus(skin.values.f_x[at], skin.values.f_y[at]));
      pressing = Math.max(pressing, Math.abs(skin.values.f_z[at]));
    }
  }
  return { stress, force, pressing };
}

function measure() {
  PEAKS = peaksOf(0, COUNT);
  STRESS = unitFor(PEAKS.stress, "Pa");
  for (const place of document.querySelectorAll("[data-unit]")) place.textContent = STRESS.name;
}

const checked = (id) => $(id).checked;
const colourOfTrack = (track) => series(track).colour;
const implausible = ({ status }) => (status & given.bits.implausible) !== 0;

/** The corners of a contact's window in a grid: left, top, width and height. */
function windowOf(grid, { top, left }) {
  const [rows, columns] = given.window;
  const [x, y] = grid.at([(left - 0.5) * given.pitch[0], (top + rows - 0.5) * given.pitch[1]]);
  return [x, y, columns * grid.across, rows * grid.down];
}

function drawContact(pen, grid, contact, peaks) {
  const [x, y] = grid.at([contact.x, contact.y]);
  const colour = colourOfTrack(contact.track);
  const chosen = contact.track === state.chosen;
  if (checked("windows") || chosen) {
    pen.setLineDash(chosen ? [] : [4, 3]);
    rimmed(pen, () => pen.rect(...windowOf(grid, contact)), chosen ? 2 : 1, colour);
    pen.setLineDash([]);
  }
  const most = 0.15 * (grid.across * given.columns + grid.down * given.rows);
  if (checked("circles")) circle(pen, [x, y], 0.5 * most, contact.f_z / peaks.pressing, 1.5, colour);
  if (checked("arrows") && peaks.force > 0 && tells("mu", contact.status)) {
    const size = most / peaks.force;
    arrow(pen, [x, y], [size * contact.f_x, -size * contact.f_y], 3.5, colour);
  }
  rimmed(pen, () => pen.arc(x, y, 9, 0, 2 * Math.PI), implausible(contact) ? 4 : 2, implausible(contact) ? "#9A2F00" : colour);
  pen.fillStyle = "#fff";
  pen.fill();
  pen.fillStyle = "#111";
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  pen.fillText(String(contact.track), x, y + 0.5);
}

function drawSkin(contacts, peaks) {
  const root = $("scale").value === "root";
  const { pen, grid } = drawPlane($("map"), { values: plane(skin.stress, state.frame), peak: peaks.stress, root, dead: skin.dead });
  contacts.toReversed().forEach((contact) => drawContact(pen, grid, contact, peaks));
  const told = contacts.map(({ track, f }) => `${track} with ${figures(f)} N`).join(", ");
  $("map").setAttribute("aria-label", `Map of the stress, frame ${numberOf(state.frame)}; contacts: ${told || "none"}`);
  drawTicks(peaks.stress, root);
  const unit = unitFor(Math.max(PEAKS.force, PEAKS.pressing), "N");
  drawKey([
    ...(checked("arrows") ? [`arrows: tangential forces, longest ${unit.of(peaks.force)} ${unit.name}`] : []),
    ...(checked("circles") ? [`area of a large circle: |F_z|, largest ${unit.of(peaks.pressing)} ${unit.name}; dashed: pulls`] : []),
    "numbers: centroids of the regions, red where the force is implausible", ...(skin.dead.length ? [CROSSED] : []),
  ]);
}

/** Columns of the table: name, head, and the text of a contact's cell. */
const COLUMNS = [
  ["track", "no.", ({ track }) => track],
  ...[["x", 1, "x / mm"], ["y", 1, "y / mm"], ["f", 3, "|F| / N"], ["mu", 3, "μ"], ["phi", 1, "φ / °"]].map(numbered),
  ["status", "marks", ({ status }) => given.statuses.filter(({ bit }) => status & bit).map(({ words }) => words).join(", ") || "–"],
  ...[...(judged ? [["uncertainty", 1, "unsure, %"]] : []), ...["x", "y", "z"].map((axis) => [`f_${axis}`, 3, `F<sub>${axis}</sub> / N`])].map(numbered),
  ["taxels", "taxels", ({ taxels }) => taxels],
];

/** A column of numbers with so many digits behind the point. */
function numbered([name, digits, head]) {
  return [name, head, (contact) => (tells(name, contact.status) && Number.isFinite(contact[name]) ? contact[name].toFixed(digits).replace("-", "−") : "–")];
}

function drawTable(found) {
  const contacts = found.toSorted((a, b) => a.track - b.track);
  const body = $("contacts").tBodies[0];
  while (body.rows.length > contacts.length) body.deleteRow(-1);
  contacts.forEach((contact, n) => {
    const row = body.rows[n] ?? body.insertRow();
    row.classList.toggle("chosen", contact.track === state.chosen);
    COLUMNS.forEach(([name, , of], column) => {
      const cell = row.cells[column] ?? row.insertCell();
      cell.dataset.column = name;
      say(cell, String(of(contact)));
      cell.classList.toggle("flagged", name === "status" && implausible(contact));
    });
  });
  const dropped = skin.dropped[state.frame];
  const more = dropped ? `; ${dropped} more peaks are dropped` : "";
  say($("counts-now"), `${contacts.length} ${contacts.length === 1 ? "contact" : "contacts"}${more}`);
}

function drawAll() {
  const contacts = contactsAt(state.frame);
  drawSkin(contacts, $("over").value === "all" ? PEAKS : peaksOf(state.frame, state.frame + 1));
  if (state.drawn) moveCursor($("cursor"), $("panels"), state.frame);
  drawTable(contacts);
  tellFrame();
}

/** Nothing is left out while frames play. */
function settle() {}

/** Mark the contact whose window has the taxel, the nearest of several. */
function pick(taxel) {
  if (taxel < 0) return;
  const [x, y] = placeOf(taxel);
  const [rows, columns] = given.window;
  const [row, column] = [Math.floor(taxel / given.columns), taxel % given.columns];
  const over = contactsAt(state.frame).filter(({ top, left }) => row >= top && row < top + rows && column >= left && column < left + columns);
  over.sort((a, b) => modulus(a.x - x, a.y - y) - modulus(b.x - x, b.y - y));
  const chosen = over.length ? over[0].track : -1;
  if (chosen === state.chosen) return;
  state.chosen = chosen;
  drawAll();
}

function listen() {
  listenToFrames();
  for (const id of ["arrows", "circles", "windows", "over", "scale"]) $(id).addEventListener("change", drawAll);
  for (const kind of ["pointermove", "pointerdown"]) {
    $("map").addEventListener(kind, ({ offsetX, offsetY }) => pick(gridOf($("map").clientWidth).taxelAt(offsetX, offsetY)));
  }
  listenToSaving();
  listenToLooks();
}

/** Show `frame`, and start to listen to events. */
function begin(frame) {
  paintBar();
  $("heads").innerHTML = COLUMNS.map(([, head]) => `<th scope="col">${head}</th>`).join("");
  measure();
  state.frame = frame;
  listen();
  drawAll();
  return drawPanels($("panels")).then(() => {
    state.drawn = true;
    followChart();
    document.body.dataset.ready = "yes";
  });
}
