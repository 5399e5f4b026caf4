// The controls of the frame shown: slider, keys, a click on the chart.  What a page adds: state, play and drawAll.

const $ = (id) => document.getElementById(id);

/** Replace a text, unless it is the same, which would cause a new layout. */
function say(place, text) {
  if (place.textContent !== text) place.textContent = text;
}

/** Say which frame is shown. */
function tellFrame() {
  const where = `frame ${numberOf(state.frame)}${times ? `, ${figures(times[state.frame])} s` : ""}`;
  $("where").textContent = where;
  $("frame").value = state.frame;
  $("frame").setAttribute("aria-valuetext", where);
  document.body.dataset.frame = state.frame;
}

function show(frame) {
  state.frame = Math.min(COUNT - 1, Math.max(0, Math.round(frame)));
  drawAll();
}

const STEPS = {
  ArrowLeft: () => state.frame - 1, ArrowRight: () => state.frame + 1, ArrowDown: () => state.frame - 1, ArrowUp: () => state.frame + 1,
  PageDown: () => state.frame - Math.ceil(COUNT / 20), PageUp: () => state.frame + Math.ceil(COUNT / 20), Home: () => 0, End: () => COUNT - 1,
};

/** Keys of the page, except those that the focused field or scrolling needs. */
function onKey(event) {
  if (event.ctrlKey || event.altKey || event.metaKey || event.target.closest("select, input:not(#frame):not([type=checkbox])")) return;
  const slider = event.target.id === "frame";
  if (event.key === " " && !event.target.closest("button, [type=checkbox], summary, a")) {
    event.preventDefault();
    play(!state.playing);
  } else if (event.key in STEPS && (slider || ["ArrowLeft", "ArrowRight"].includes(event.key))) {
    event.preventDefault();
    play(false);
    show(STEPS[event.key]());
  }
}

function listenToFrames() {
  document.addEventListener("keydown", onKey);
  $("play").addEventListener("click", () => play(!state.playing));
  $("frame").addEventListener("input", (event) => { play(false); show(Number(event.target.value)); });
}

/** Draw again when the page gets another width. */
function listenToWidth() {
  let width = document.body.clientWidth;
  new ResizeObserver(() => {
    if (document.body.clientWidth === width) return;
    width = document.body.clientWidth;
    drawAll();
  }).observe(document.body);
  narrow.addEventListener("change", () => drawPanels($("panels")));
}

/** The chart over the frames has been drawn: its cursor moves, and a click goes to a frame. */
function followChart() {
  $("panels").on("plotly_click", ({ points }) => {
    play(false);
    const x = points[0].x;
    let frame = 0;
    while (frame < COUNT - 1 && xOf(frame) < x) frame += 1;
    show(frame);
  });
  $("panels").on("plotly_afterplot", () => moveCursor($("cursor"), $("panels"), state.frame));
  moveCursor($("cursor"), $("panels"), state.frame);
}
