// A recording.  It plays at the chosen rate, skips frames that the screen has no time for, and stops at the last one.

function play(wanted) {
  const [begins, ends] = [wanted && !state.playing, !wanted && state.playing];
  state.playing = wanted;
  if (ends) settle();
  $("play").textContent = wanted ? "Pause" : "Play";
  if (!begins) return;
  if (state.frame === COUNT - 1) show(0);
  let [place, before] = [state.frame, performance.now()];
  const tick = (now) => {
    if (!state.playing) return;
    if (Math.floor(place) !== state.frame) place = state.frame;
    place = Math.min(COUNT - 1, place + ((now - before) / 1000) * Number($("speed").value));
    before = now;
    if (Math.floor(place) !== state.frame) show(Math.floor(place));
    if (state.frame === COUNT - 1) play(false);
    else requestAnimationFrame(tick);
  };
  requestAnimationFrame(tick);
}

/** The frame that the address names, or the one before it on the page; undefined without any. */
function linked() {
  const wanted = /^#frame=(\d+)$/.exec(location.hash)?.[1];
  return wanted && Math.min(COUNT - 1, Math.max(0, Math.floor((Number(wanted) - given.start) / given.step)));
}

let linking = 0;

/** Name the frame in the address when it has been shown for a moment: browsers refuse hundreds of changes. */
function link() {
  if (location.protocol === "about:") return;  // within a notebook, which has the address
  clearTimeout(linking);
  linking = setTimeout(() => history.replaceState(null, "", `#frame=${numberOf(state.frame)}`), 200);
}

/** The frame of the largest stress, shown first. */
function first() {
  const { scale } = results[0].stress;
  return scale.reduce((best, value, frame) => (value > scale[best] ? frame : best), 0);
}

addEventListener("hashchange", () => { play(false); show(linked() ?? state.frame); });
begin(linked() ?? first());
