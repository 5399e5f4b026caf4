// How charts look, and the cursor over them.

const SERIES = [
  { colour: "#0072B2", dash: "solid" }, { colour: "#D55E00", dash: "dash" }, { colour: "#009E73", dash: "dashdot" },
  { colour: "#CC79A7", dash: "longdash" }, { colour: "#E69F00", dash: "longdashdot" },
];
const PANEL = 118;
const AXIS = {
  gridcolor: "#ddd", linecolor: "#767676", ticks: "outside", tickcolor: "#767676", showline: true,
  zeroline: false,
};
const LOOKS = {
  font: { family: "system-ui, sans-serif", size: 12, color: "#111" },
  paper_bgcolor: "white", plot_bgcolor: "white", hovermode: "closest",
  hoverlabel: { bgcolor: "white", bordercolor: "#767676", font: { size: 12, color: "#111" }, align: "left" },
};
const MARGIN = { l: 58, r: 12, t: 40, b: 50 };
const narrow = matchMedia("(max-width: 640px)");
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
  bgcolor: "rgba(255,255,255,.85)", font: { size, color: "#111" }, borderpad: 1,
});

/** Panels over the frames below each other, each with name and title; space above and below them in pixels. */
function stacked(panels, above, foot) {
  const total = panels.length * PANEL + foot;
  const margin = { ...MARGIN, t: above };
  const layout = {
    ...LOOKS, height: total + margin.t + margin.b, margin, dragmode: narrow.matches ? false : "zoom",
    legend: { orientation: "h", x: 0, xref: "container", y: 1, yref: "container", yanchor: "top" },
    xaxis: { ...AXIS, title: { text: times ? "time / s" : "frame" }, anchor: yaxis(panels.length - (foot ? 0 : 1)) },
    annotations: panels.map(([, title], panel) => inside(`<b>${title}</b>`, 1 - (panel * PANEL) / total, 12)),
  };
  if (COUNT === 1) layout.xaxis.range = [xOf(0) - 1, xOf(0) + 1];
  panels.forEach(([name], panel) => {
    const top = 1 - (panel * PANEL) / total;
    layout[`yaxis${panel ? panel + 1 : ""}`] = {
      ...AXIS, domain: [top - (PANEL - 16) / total, top], anchor: "x", nticks: 5,
      ...(name === "phi" ? { range: [-8, 368], tickvals: [0, 90, 180, 270, 360] } : {}),
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
