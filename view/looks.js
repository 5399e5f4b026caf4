// How charts look, and the cursor over them.

/** The colours of the page's style sheet, which are others in the dark. */
const INK = {};
function readInks() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ["text", "paper", "faint", "edge", "grid", "veil", "alarm", "blue"]) INK[name] = style.getPropertyValue(`--${name}`).trim();
}
readInks();

const SERIES = [
  { get colour() { return INK.blue; }, dash: "solid" }, { colour: "#D55E00", dash: "dash" }, { colour: "#009E73", dash: "dashdot" },
  { colour: "#CC79A7", dash: "longdash" }, { colour: "#E69F00", dash: "longdashdot" },
];
const PANEL = 118;
const axis = () => ({
  gridcolor: INK.grid, linecolor: INK.edge, ticks: "outside", tickcolor: INK.edge, showline: true, zeroline: false,
});
const looks = () => ({
  font: { family: "system-ui, sans-serif", size: 12, color: INK.text },
  paper_bgcolor: INK.paper, plot_bgcolor: INK.paper, hovermode: "closest",
  hoverlabel: { bgcolor: INK.paper, bordercolor: INK.edge, font: { size: 12, color: INK.text }, align: "left" },
});
const MARGIN = { l: 58, r: 12, t: 40, b: 50 };
const narrow = matchMedia("(max-width: 640px)");
const dark = matchMedia("(prefers-color-scheme: dark)");
const series = (n) => SERIES[n % SERIES.length];

function config(bar) {
  const buttons = [["zoom2d", "pan2d", "resetScale2d", "toImage"]];
  const chosen = { responsive: true, displaylogo: false, showSendToCloud: false, modeBarButtons: buttons };
  return narrow.matches || !bar ? { ...chosen, displayModeBar: false } : chosen;
}

const xOf = (frame) => (times ? times[frame] : numberOf(frame));

const yaxis = (panel) => `y${panel ? panel + 1 : ""}`;

/** A text within a chart, at a share of its height. */
const inside = (text, y, size) => ({
  text, x: 0, xref: "paper", xanchor: "left", xshift: 4, y, yref: "paper", yanchor: "top", showarrow: false,
  bgcolor: INK.veil, font: { size, color: INK.text }, borderpad: 1,
});

/** Angles with whole turns added so that none differs by more than a half from the one before, the first from `near`. */
function unwrapped(angles, near) {
  let last = near;
  return angles.map((angle) => {
    if (angle === null) return null;
    last = angle + 360 * Math.round(((last ?? angle) - angle) / 360);
    return last;
  });
}

/** Degrees between the ticks of an axis with these angles: parts of a turn, unless it is a small one. */
function angleTicks(traces) {
  let [low, high] = [Infinity, -Infinity];
  for (const { y } of traces) {
    for (const angle of y) {
      if (angle !== null) [low, high] = [Math.min(low, angle), Math.max(high, angle)];
    }
  }
  return high - low > 120 ? { dtick: 90 * Math.ceil((high - low) / 360) } : {};
}

/** Panels over the frames below each other, each with name and title; space above and below them in pixels. */
function stacked(panels, traces, above, foot) {
  const total = panels.length * PANEL + foot;
  const margin = { ...MARGIN, t: above };
  const layout = {
    ...looks(), height: total + margin.t + margin.b, margin, dragmode: narrow.matches ? false : "zoom",
    legend: { orientation: "h", x: 0, xref: "container", y: 1, yref: "container", yanchor: "top" },
    xaxis: { ...axis(), title: { text: times ? "time / s" : "frame" }, anchor: yaxis(panels.length - (foot ? 0 : 1)) },
    annotations: panels.map(([, title], panel) => inside(`<b>${title}</b>`, 1 - (panel * PANEL) / total, 12)),
  };
  if (COUNT === 1) layout.xaxis.range = [xOf(0) - 1, xOf(0) + 1];
  panels.forEach(([name], panel) => {
    const top = 1 - (panel * PANEL) / total;
    layout[`yaxis${panel ? panel + 1 : ""}`] = {
      ...axis(), domain: [top - (PANEL - 16) / total, top], anchor: "x", nticks: 5,
      ...(name === "phi" ? angleTicks(traces.filter(({ meta }) => meta === "phi")) : {}),
    };
  });
  return layout;
}

/** Move the cursor line over the chart; drawing the chart again would be too slow. */
function moveCursor(cursor, chart, frame) {
  const [first, last] = chart.layout.xaxis.range;
  const share = (xOf(frame) - first) / (last - first);
  cursor.hidden = share < 0 || share > 1;
  if (cursor.hidden) return;
  cursor.style.transform = `translateX(${MARGIN.l + share * (chart.clientWidth - MARGIN.l - MARGIN.r)}px)`;
  cursor.style.top = `${chart.layout.margin.t}px`;
  cursor.style.bottom = `${MARGIN.b}px`;
}
