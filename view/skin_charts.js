// Values of the contacts over the frames, a line for each.

const PANELS = [["f", "|F| / N"], ["f_z", "F<sub>z</sub> / N"], ["mu", "μ"], ["phi", "φ / °"], ["count", "contacts, dashed: dropped"]];

/** The lines of the contacts of one colour, with gaps between them. */
function linesOf(name, panel, colour) {
  const lines = new Map();
  for (let frame = 0; frame < COUNT; frame += 1) {
    for (let at = frame * given.slots; at < frame * given.slots + skin.found[frame]; at += 1) {
      const track = skin.values.track[at];
      if (track % SERIES.length !== colour) continue;
      if (!lines.has(track)) lines.set(track, []);
      lines.get(track).push([frame, tells(name, skin.status[at]) ? skin.values[name][at] : null]);
    }
  }
  const [x, y, text] = [[], [], []];
  for (const [track, points] of lines) {
    const values = points.map(([, value]) => value);
    const drawn = name === "phi" ? unwrapped(values) : values;
    points.forEach(([frame], n) => {
      if (points[n - 1]?.[0] !== frame - 1) {
        x.push(xOf(frame));
        y.push(null);
        text.push("");
      }
      x.push(xOf(frame));
      y.push(drawn[n]);
      text.push(`contact ${track}`);
    });
  }
  const title = PANELS[panel][1].split(" / ")[0];
  return {
    x, y, text, xaxis: "x", yaxis: yaxis(panel), type: "scatter", mode: COUNT > 60 ? "lines" : "lines+markers", showlegend: false,
    line: { color: series(colour).colour, width: 1.6 }, marker: { size: 4, color: series(colour).colour }, meta: name,
    hovertemplate: `%{text}: ${title} %{y:.4g}<extra></extra>`,
  };
}

/** How many contacts there are, and how many more were dropped. */
function countLines() {
  const x = Array.from({ length: COUNT }, (_, frame) => xOf(frame));
  return [["found", "solid", INK.text], ["dropped", "dash", INK.alarm]].map(([name, dash, color]) => ({
    x, y: Array.from(skin[name]), xaxis: "x", yaxis: yaxis(PANELS.length - 1), type: "scatter", mode: "lines", showlegend: false,
    line: { color, dash, width: 1.6, shape: "hvh" }, meta: name, hovertemplate: `%{y} ${name}<extra></extra>`,
  }));
}

function drawPanels(chart) {
  const named = PANELS.slice(0, -1).flatMap(([name], panel) => SERIES.map((_, colour) => linesOf(name, panel, colour)));
  return Plotly.react(chart, [...named, ...countLines()], stacked(PANELS, named, 12, 0), config(true));
}

/** Columns of the table of contacts, by the names of their values. */
const SAVED = {
  track: "track", x: "x_mm", y: "y_mm", f: "f_n", f_x: "fx_n", f_y: "fy_n", f_z: "fz_n", mu: "mu", phi: "phi_deg",
};

/** A row for each contact of each frame, under the names of its cells. */
function table() {
  const rows = Array.from({ length: COUNT }, (_, frame) =>
    contactsAt(frame).map((contact) => [
      ...cellsOf(frame), ...Object.keys(SAVED).map((name) => (tells(name, contact.status) ? single(contact[name]) : null)),
    ]),
  );
  return [[...namesOfCells(), ...Object.values(SAVED)], ...rows.flat()];
}
