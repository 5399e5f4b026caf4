// Charts: values and errors over the frames with a cursor, and the sweep of a frame.

const [known] = references;

/** Errors beside reference values: of a result's value, by the name of that. */
const ERRORS = {
  phi: ["phi_error", "φ − φ<sub>ref</sub> / °", "phi_error_deg", (found, frame) => halfTurn(found("phi") - known.values.phi[frame])],
  mu: ["mu_error", "μ − μ<sub>ref</sub>", "mu_error", (found, frame) => found("mu") - known.values.mu[frame]],
  f: ["f_error", "|F − F<sub>ref</sub>| / N", "f_error_n", (found, frame) => modulus(...["f_x", "f_y", "f_z"].map((axis) => found(axis) - known.values[axis][frame]))],
};
/** Name, title and name in a table of the values over the frames, each with its error behind it. */
const PANELS = [
  ["phi", "φ / °", "phi_deg"], ["mu", "μ", "mu"], ["f", "|F| / N", "f_n"], ["f_x", "F<sub>x</sub> / N", "fx_n"],
  ["f_y", "F<sub>y</sub> / N", "fy_n"], ["f_z", "F<sub>z</sub> / N", "fz_n"],
  ...(judged ? [["uncertainty", "uncertainty, % of |F<sub>z</sub>|", "uncertainty_percent"]] : []),
  ...(tested ? [["residual", "residual / %", "residual_percent"]] : []),
].flatMap((panel) => (known?.values[panel[0]] && ERRORS[panel[0]] ? [panel, ERRORS[panel[0]]] : [panel]));
const LANE = 26;

/** An angle between -180 and 180. */
const halfTurn = (angle) => angle - 360 * Math.round(angle / 360);

/** The series over the frames, by name and frame: results, then reference values. */
const SOURCES = () => [
  ...results.map((result, n) => ({
    ...series(n), label: result.label,
    of: (name, frame, error) => (error ? error((value) => valueOf(result, value, frame), frame) : valueOf(result, name, frame)),
  })),
  ...references.map(({ label, values }) => ({ colour: INK.text, dash: "dot", label, of: (name, frame) => values[name]?.[frame] })),
];

/** The curves of all panels, null where there is no value; angles are unwrapped, and near each other at first. */
function curves() {
  return PANELS.flatMap(([name, title, column, error], panel) => {
    let beside;
    return SOURCES().map(({ of, ...source }) => {
      const found = Array.from({ length: COUNT }, (_, frame) => of(name, frame, error) ?? null);
      const values = found.map((value) => (Number.isFinite(value) ? value : null));
      const first = values.findIndex((value) => value !== null);
      const y = name === "phi" ? unwrapped(values, beside?.[first]) : values;
      beside ??= y;
      return { ...source, name, title, column, panel, y, empty: first < 0 };
    }).filter(({ empty }) => !empty);
  });
}

/** The curves as rows of a table, under their names. */
function table() {
  const found = curves();
  const rows = Array.from({ length: COUNT }, (_, frame) => [...cellsOf(frame), ...found.map(({ y }) => single(y[frame]))]);
  return [[...namesOfCells(), ...found.map(({ column, label }) => `${column} ${label}`)], ...rows];
}

function panelTraces() {
  const named = new Set();
  const x = Array.from({ length: COUNT }, (_, frame) => xOf(frame));
  return curves().map(({ name, title, panel, colour, dash, label, y }) => {
    const showlegend = !named.has(label);
    named.add(label);
    const hover = `${title.split(" / ")[0]} %{y:.4g}<br>${times ? "%{x:.4g} s" : "frame %{x}"}`;
    return {
      x, y, xaxis: "x", yaxis: yaxis(panel), type: "scatter",
      mode: COUNT > 60 ? "lines" : "lines+markers", name: label, legendgroup: label, showlegend,
      line: { color: colour, dash, width: 1.6 }, marker: { size: 4, color: colour },
      hovertemplate: `${hover}<extra>${label}</extra>`, meta: name,
    };
  });
}

/** Statuses that have occurred, from top to bottom. */
let lanes = [];
const occurs = (bit) => results.some(({ status }) => status.some((bits) => bits & bit));

/** Runs of frames that have a status, as lines with gaps. */
function laneTraces() {
  return lanes.flatMap(({ bit, words }, lane) =>
    results.map((result, n) => {
      const [x, y] = [[], []];
      const height = -lane - 0.45 - (0.4 * (n + 1)) / (results.length + 1);
      for (let frame = 0; frame < COUNT; frame += 1) {
        if (!has(result, frame, bit)) continue;
        const first = frame;
        while (frame + 1 < COUNT && has(result, frame + 1, bit)) frame += 1;
        x.push(xOf(first), xOf(frame), null);
        y.push(height, height, null);
      }
      return {
        x, y, type: "scatter", mode: "lines+markers", line: { color: series(n).colour, width: 3 }, showlegend: false,
        marker: { symbol: "line-ns-open", size: 6, color: series(n).colour }, legendgroup: result.label,
        yaxis: yaxis(PANELS.length), xaxis: "x", hovertemplate: `${words}<extra>${result.label}</extra>`, meta: "status",
      };
    }),
  );
}

const implausible = (frame) => results.some((result) => has(result, frame, given.bits.implausible));

/** The band of the frames that are implausible in some result: one path, since shapes are slow. */
function band() {
  const between = (a, b) => (xOf(Math.max(a, 0)) + xOf(Math.min(b, COUNT - 1))) / 2;
  let path = "";
  for (let frame = 0; frame < COUNT; frame += 1) {
    if (!implausible(frame)) continue;
    const first = between(frame - 1, frame);
    while (frame + 1 < COUNT && implausible(frame + 1)) frame += 1;
    path += `M${first},0V1H${between(frame, frame + 1)}V0Z`;
  }
  return path ? [{ type: "path", path, xref: "x", yref: "paper", layer: "below", fillcolor: "#E69F00", opacity: 0.35, line: { width: 0 } }] : [];
}

/** The thresholds of the uncertainty, each once. */
const thresholds = [...new Set(results.flatMap(({ threshold }) => threshold ?? []))];

const thresholdLine = (y, panel) => ({
  type: "line", xref: "paper", x0: 0, x1: 1, yref: yaxis(panel), y0: y, y1: y, line: { color: INK.alarm, width: 1.5, dash: "dash" },
});

/** Space above the panels for the legend of a chart of this width. */
function topOf(width) {
  const needed = SOURCES().reduce((sum, { label }) => sum + 56 + 7 * label.length, 0);
  return 12 + 29 * Math.ceil((1.15 * needed) / width);
}

function panelLayout(width, traces) {
  const foot = lanes.length * LANE;
  const total = PANELS.length * PANEL + foot;
  const layout = stacked(PANELS, traces, topOf(width), foot);
  const unsure = PANELS.findIndex(([name]) => name === "uncertainty");
  layout.shapes = band();
  if (unsure >= 0) {
    layout[`yaxis${unsure + 1}`].range = [0, 3 * Math.max(...thresholds)];
    layout.shapes.push(...thresholds.map((threshold) => thresholdLine(threshold, unsure)));
  }
  if (lanes.length) {
    layout[`yaxis${PANELS.length + 1}`] = {
      domain: [0, (foot - 8) / total], range: [-lanes.length, 0], showticklabels: false, showgrid: false, zeroline: false, anchor: "x",
    };
    lanes.forEach(({ words }, lane) => layout.annotations.push(inside(words, ((foot - 8) * (1 - lane / lanes.length)) / total, 11)));
  }
  return layout;
}

function drawPanels(chart) {
  lanes = given.statuses.filter((status) => lanes.includes(status) || occurs(status.bit));
  const traces = panelTraces();
  return Plotly.react(chart, [...traces, ...laneTraces()], panelLayout(chart.clientWidth, traces), config(true));
}

/** What stands for the sweep of a result without one. */
const NO_SWEEP = { mu: [0, 1], b_z: [0, 0], b_xy: [0, 0], plateau: [false, false], winner: -1 };

/** The sweep for a frame: its own, or that of the last frame before it that has one. */
function sweepOf({ sweep, steps, index }, frame) {
  if (!sweep) return { of: frame, ...NO_SWEEP };
  const place = Math.floor(frame / given.sweeps);
  const many = steps + 1;
  const part = (array, width) => array.subarray(place * width, (place + 1) * width);
  const bits = part(sweep.plateau, Math.ceil(many / 8));
  return {
    of: place * given.sweeps,
    mu: Array.from({ length: many }, (_, n) => sweep.start[place] + n / steps),
    b_z: part(sweep.b_z, many),
    b_xy: part(sweep.b_xy, many),
    plateau: Array.from({ length: many }, (_, n) => ((bits[n >> 3] >> (7 - (n & 7))) & 1) === 1),
    winner: index[place * given.sweeps],
  };
}

function drawSweep(chart, result, frame) {
  const found = sweepOf(result, frame);
  const still = has(result, found.of, given.bits.withoutForce) ? "nothing is under traction,<br>or nothing presses" : "";
  const none = result.sweep ? still : "the estimator of this result<br>does not search";
  const unit = unitFor(Math.max(...found.b_z, ...found.b_xy), "Pa");
  const scaled = (array) => Array.from(array, (value) => value / unit.size);
  const [b_z, b_xy] = [scaled(found.b_z), scaled(found.b_xy)];
  const low = Math.min(...b_z);
  const won = !none && found.winner >= 0 ? [found.winner] : [];
  const curve = (name, y, yaxis, colour, dash) => ({
    x: found.mu, y, yaxis, name, mode: "lines", line: { color: colour, dash, width: 2 }, hovertemplate: `%{y:.5g} ${unit.name} at μ %{x:.3g}<extra>${name}</extra>`,
  });
  const among = (y, yaxis, showlegend) => {
    const kept = found.mu.map((_, n) => n).filter((n) => found.plateau[n]);
    return {
      x: kept.map((n) => found.mu[n]), y: kept.map((n) => y[n]), yaxis, name: "plateau", legendgroup: "plateau", showlegend, mode: "markers",
      marker: { size: 5, color: "#E69F00", line: { color: INK.text, width: 0.4 } }, hoverinfo: "skip",
    };
  };
  const winner = (y, yaxis, showlegend) => ({
    x: won.map((n) => found.mu[n]), y: won.map((n) => y[n]), yaxis, name: "winner", legendgroup: "winner", showlegend, mode: "markers",
    marker: { symbol: "star", size: 14, color: "#D55E00", line: { color: INK.text, width: 1 } }, hovertemplate: `μ_ind %{x:.3g}<extra>winner</extra>`,
  });
  const data = none ? [] : [
    curve("B<sup>z</sup>", b_z, "y", INK.blue, "solid"), curve("B<sup>xy</sup>", b_xy, "y2", "#009E73", "dash"),
    among(b_z, "y", true), among(b_xy, "y2", false), winner(b_z, "y", true), winner(b_xy, "y2", false),
  ];
  const band = { type: "rect", xref: "paper", x0: 0, x1: 1, yref: "y", y0: low, y1: low + result.tolerance / unit.size, layer: "below" };
  Plotly.react(chart, data, {
    ...looks(), height: 340, margin: MARGIN, dragmode: narrow.matches ? false : "zoom",
    legend: { orientation: "h", x: 0, xref: "container", y: 1, yref: "container", yanchor: "top" },
    xaxis: { ...axis(), title: { text: "μ<sub>ind</sub>" }, anchor: "y2", range: [found.mu[0] - 0.03, found.mu.at(-1) + 0.03] },
    yaxis: { ...axis(), domain: [0.54, 1], title: { text: `B<sup>z</sup> / ${unit.name}` }, nticks: 5 },
    yaxis2: { ...axis(), domain: [0, 0.46], title: { text: `B<sup>xy</sup> / ${unit.name}` }, nticks: 5 },
    shapes: none ? [] : [{ ...band, fillcolor: "#E69F00", opacity: 0.3, line: { color: "#E69F00", width: 1 } }],
    annotations: none ? [{ text: `no sweep: ${none}`, x: 0.5, y: 0.77, xref: "paper", yref: "paper", showarrow: false }] : [],
  }, config(false));
  return found.of;
}
