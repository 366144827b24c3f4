"use strict";
(() => {
const stage = document.getElementById("motion-drawing"), source = document.getElementById("motion-data");
if (!stage || !source) return;
const data = JSON.parse(source.textContent), {end, frames, speed, points} = data, last = frames.length - 1;
const tell = detail => stage.dispatchEvent(new CustomEvent("symgen-motion", {detail}));
const panels = [...document.querySelectorAll("#motion .plot[data-span]")].map(plot => ({
  span: +plot.dataset.span, cursor: plot.querySelector(".cursor"), plot,
}));
const format = x => x.toFixed(2).replace("-", "\u2212");

// Where the bodies stand at a time: between frames positions go straight, quaternions along the great circle, nearly.
function poses(time) {
  const place = Math.min(Math.max(time / end, 0), 1) * last, k = Math.min(Math.floor(place), last - 1), t = place - k;
  const found = [];
  for (let i = 0; i < frames[k].length; i += 7) {
    const [x, y, z, a, b, c, d] = frames[k].slice(i, i + 7).map((p, j) => p + t * (frames[k + 1][i + j] - p));
    const n = 2 / (a * a + b * b + c * c + d * d);
    found.push({o: [x, y, z], r: [
      [1 - n * (b * b + c * c), n * (a * b - d * c), n * (a * c + d * b)],
      [n * (a * b + d * c), 1 - n * (a * a + c * c), n * (b * c - d * a)],
      [n * (a * c - d * b), n * (b * c + d * a), 1 - n * (a * a + b * b)]]});
  }
  return found;
}
const ground = (pose, p) => pose.o.map((x, k) => x + pose.r[k][0] * p[0] + pose.r[k][1] * p[1] + pose.r[k][2] * p[2]);
const times = frames.map((_, k) => k / last * end), still = times.map(poses);

// The picture holds the corners of every body, wherever it goes.
const extent = [];
still.forEach((found, k) => {
  if (k % Math.ceil(last / 60) === 0) data.corners.forEach((box, body) => { for (const p of box) extent.push(ground(found[body], p)); });
});

let time = 0, playing = false, before = null, rate = speed, path = [];
const byId = id => document.getElementById(id);
const play = byId("motion-play"), scrub = byId("motion-time"), readout = byId("motion-readout");
const faster = byId("motion-speed"), traced = byId("motion-trace"), front = byId("motion-front");

function show(whole) {
  const detail = {pose: poses(time)};
  if (path.length) {
    const k = Math.min(Math.floor(time / end * last), last), p = points[+traced.value];
    const past = [...path.slice(0, k + 1), ground(detail.pose[p.body], p.point)];
    detail.trace = [{style: "trace all", points: path}, {style: "trace", points: past}];
  } else detail.trace = null;
  tell(detail);
  if (whole !== "scrub") scrub.value = time;
  readout.textContent = format(time) + "\u2009s of " + format(end) + "\u2009s";
  scrub.setAttribute("aria-valuetext", readout.textContent);
  for (const {span, cursor} of panels) cursor.setAttribute("transform", `translate(${(time / end * span).toFixed(1)} 0)`);
}
function tick(now) {
  if (!playing) return;
  if (before !== null) time += (now - before) / 1000 * rate;
  before = now;
  if (time > end) time %= end;
  show();
  requestAnimationFrame(tick);
}
function toggle(on) {
  playing = on;
  play.textContent = on ? "Pause" : "Play";
  play.setAttribute("aria-pressed", on);
  if (on) { before = null; requestAnimationFrame(tick); }
}
function go(to, how) { time = Math.min(Math.max(to, 0), end); show(how); }
function choose() {
  const p = points[+traced.value];
  path = p ? still.map(found => ground(found[p.body], p.point)) : [];
  show();
}
play.addEventListener("click", () => toggle(!playing));
scrub.addEventListener("input", () => { toggle(false); go(+scrub.value, "scrub"); });
faster.addEventListener("change", () => { rate = +faster.value; });
traced.addEventListener("change", choose);
front.addEventListener("click", () => tell({front: null}));
byId("motion-player").addEventListener("keydown", e => {
  if (["SELECT", "BUTTON"].includes(e.target.tagName) || e.ctrlKey || e.metaKey || e.altKey) return;
  if (e.key === " " || e.key === "k") { e.preventDefault(); toggle(!playing); }
  if (e.key === "," || e.key === ".") { toggle(false); go(time + (e.key === "," ? -1 : 1) * end / last); }
});
for (const {span, plot} of panels) {
  plot.addEventListener("click", e => {
    const box = plot.getBoundingClientRect(), x = (e.clientX - box.left) / box.width * plot.viewBox.baseVal.width;
    toggle(false);
    go((x - plot.dataset.start) / span * end);
  });
}
for (const button of document.querySelectorAll("#motion .still button")) {
  button.disabled = false;
  button.addEventListener("click", () => { toggle(false); go(+button.dataset.time); });
}
stage.addEventListener("pointerdown", e => { if (e.target.closest("svg")) e.target.closest("svg").focus({preventScroll: true}); });
byId("motion-player").hidden = false;
tell({hold: extent});
choose();
})();
