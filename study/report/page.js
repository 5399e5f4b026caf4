"use strict";
// Charts follow the filters; rows of tables and sentences that belong to another choice are hidden.
const charts = JSON.parse(document.getElementById("charts").textContent);
const filters = [...document.querySelectorAll("select[data-filter]")];
const rows = [...document.querySelectorAll("tbody tr, section > p")];
const narrow = matchMedia("(max-width: 640px)");
const buttons = [["zoom2d", "pan2d", "resetScale2d", "toImage"]];

function draw(id) {
  const chosen = charts[id].filters.map((name) => filters.find((filter) => filter.dataset.filter === name).value);
  const { data, layout } = charts[id].figures[chosen.join(" ")];
  // A finger that moves over a chart scrolls the page.  Nothing here may send a chart anywhere.
  const config = { responsive: true, displaylogo: false, showSendToCloud: false, modeBarButtons: buttons };
  if (narrow.matches) config.displayModeBar = false;
  Plotly.react(id, data, { ...layout, dragmode: narrow.matches ? false : "zoom" }, config);
}

function hide() {
  const other = (row, { dataset, value }) => dataset.filter in row.dataset && row.dataset[dataset.filter] !== value;
  for (const row of rows) row.hidden = filters.some((filter) => other(row, filter));
}

// The page of a running study is loaded again and again: what was chosen stays so.
for (const filter of filters) {
  const kept = sessionStorage.getItem(filter.dataset.filter);
  if ([...filter.options].some((option) => option.value === kept)) filter.value = kept;
  filter.addEventListener("change", () => {
    sessionStorage.setItem(filter.dataset.filter, filter.value);
    Object.keys(charts).filter((id) => charts[id].filters.includes(filter.dataset.filter)).forEach(draw);
    hide();
  });
}
narrow.addEventListener("change", () => Object.keys(charts).forEach(draw));
Object.keys(charts).forEach(draw);
hide();
