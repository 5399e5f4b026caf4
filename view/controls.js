// The controls of the frame shown: slider, keys, a click on the chart.  What a page adds: state, play, link and drawAll.

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
  link();
}

function show(frame) {
  state.frame = Math.min(COUNT - 1, Math.max(0, Math.round(frame)));
  drawAll();
}

/** Frames that a key goes on by; beyond the first and the last there is none. */
const STEPS = { ArrowLeft: -1, ArrowRight: 1, PageDown: -100, PageUp: 100, ArrowDown: -1, ArrowUp: 1, Home: -Infinity, End: Infinity };
/** Keys of the page; the others are those of the slider. */
const ANYWHERE = ["ArrowLeft", "ArrowRight", "PageDown", "PageUp"];

/** Keys of the page, except those that the focused field or scrolling needs. */
function onKey(event) {
  if (event.ctrlKey || event.altKey || event.metaKey || event.target.closest("select, input:not(#frame):not([type=checkbox])")) return;
  const slider = event.target.id === "frame";
  if (event.key === " " && !event.target.closest("button, [type=checkbox], summary, a")) {
    event.preventDefault();
    play(!state.playing);
  } else if (event.key in STEPS && (slider || ANYWHERE.includes(event.key))) {
    event.preventDefault();
    play(false);
    show(state.frame + STEPS[event.key] * (event.shiftKey && event.key.startsWith("Arrow") ? 100 : 1));
  }
}

function listenToFrames() {
  document.addEventListener("keydown", onKey);
  $("play").addEventListener("click", () => play(!state.playing));
  $("frame").addEventListener("input", (event) => { play(false); show(Number(event.target.value)); });
}

/** Draw again when the page gets another width, or other colours. */
function listenToLooks() {
  let width = document.body.clientWidth;
  new ResizeObserver(() => {
    if (document.body.clientWidth === width) return;
    width = document.body.clientWidth;
    drawAll();
  }).observe(document.body);
  narrow.addEventListener("change", () => drawPanels($("panels")));
  dark.addEventListener("change", () => {
    readInks();
    drawAll();
    settle();
    drawPanels($("panels"));
  });
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
