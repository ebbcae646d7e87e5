// Time: which instant is shown, which span is in view, and playing. Everything on the page follows it.

/** Shortest span in s: a few communication steps. */
const SHORTEST_SPAN = 5e-4;
/** Of the whole run, if that is shorter still. */
const SHORTEST_SHARE = 1e-3;

function createClock(start, stop) {
  const listeners = { time: [], view: [], playing: [] };
  const tell = (what) => listeners[what].forEach((listener) => listener());
  let time = start;
  let hovered = null;
  let view = { from: start, to: stop };
  let playing = false;
  let speed = "fit";
  let frame = 0;
  let before = 0;

  const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
  const rate = () => (speed === "fit" ? (view.to - view.from) / 10 : speed);

  function advance(now) {
    // A tab that was in the background goes on where it was.
    const passed = Math.min(now - before, 100) / 1000;
    before = now;
    time = Math.min(time + passed * rate(), view.to);
    tell("time");
    if (time >= view.to) clock.pause();
    else frame = requestAnimationFrame(advance);
  }

  const clock = {
    start,
    stop,
    /** The time to show: that under the pointer, if it is on a chart while nothing plays. */
    get shown() {
      return playing || hovered === null ? time : hovered;
    },
    get time() {
      return time;
    },
    get view() {
      return view;
    },
    get playing() {
      return playing;
    },
    get rate() {
      return rate();
    },
    /** Calls `listener` when the shown "time", the "view" or "playing" changes. */
    on(what, listener) {
      listeners[what].push(listener);
    },
    /** Shows a time, or the end of the view that is nearest: what is shown is always in view. */
    set(wanted) {
      time = clamp(wanted, view.from, view.to);
      hovered = null;
      tell("time");
    },
    /** Shows a time for as long as the pointer is there; null ends it. */
    hover(wanted) {
      hovered = wanted === null ? null : clamp(wanted, view.from, view.to);
      if (!playing) tell("time");
    },
    /** Shows the span from `from` to `to`, as far as it is within the run. */
    look(from, to) {
      const shortest = Math.min(SHORTEST_SPAN, SHORTEST_SHARE * (stop - start));
      const span = clamp(to - from, shortest, stop - start);
      const left = clamp((from + to - span) / 2, start, stop - span);
      view = { from: left, to: left + span };
      time = clamp(time, view.from, view.to);
      tell("view");
      tell("time");
    },
    /** Makes the span `factor` times as long; `around` stays where it is. */
    zoom(factor, around) {
      const { from, to } = view;
      const pivot = around >= from && around <= to ? around : (from + to) / 2;
      clock.look(pivot + (from - pivot) * factor, pivot + (to - pivot) * factor);
    },
    setSpeed(wanted) {
      speed = wanted;
    },
    play() {
      if (playing) return;
      if (time >= view.to) time = view.from;
      playing = true;
      before = performance.now();
      frame = requestAnimationFrame(advance);
      tell("playing");
    },
    pause() {
      playing = false;
      cancelAnimationFrame(frame);
      tell("playing");
      tell("time");
    },
    toggle() {
      if (playing) clock.pause();
      else clock.play();
    },
  };
  return clock;
}
