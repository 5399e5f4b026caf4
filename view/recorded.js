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

/** The frame of the largest stress, shown first. */
function first() {
  const { scale } = results[0].stress;
  return scale.reduce((best, value, frame) => (value > scale[best] ? frame : best), 0);
}

begin(first());
