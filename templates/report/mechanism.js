"use strict";
(() => {
const picture = document.querySelector("#mechanism-drawing svg");
const data = JSON.parse(document.getElementById("mechanism-data").textContent);
if (!picture || !data) return;
const NS = "http://www.w3.org/2000/svg", {width, height, margin, light, inset} = data;
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = a => { const n = Math.hypot(...a) || 1; return a.map(x => x / n); };
const turn = (m, v) => m.map(row => dot(row, v));
const column = (m, k) => [m[0][k], m[1][k], m[2][k]];
const product = (a, b) => a.map(row => [0, 1, 2].map(k => dot(row, column(b, k))));
const f = x => (Math.round(x * 10) / 10).toString();
const line = (points, close) => "M" + points.map(p => f(p[0]) + " " + f(p[1])).join("L") + (close ? "Z" : "");

function rotation(axis, angle) {
  const [x, y, z] = axis, c = Math.cos(angle), s = Math.sin(angle), t = 1 - c;
  return [[c + t * x * x, t * x * y - s * z, t * x * z + s * y],
    [t * x * y + s * z, c + t * y * y, t * y * z - s * x], [t * x * z - s * y, t * y * z + s * x, c + t * z * z]];
}
// Where the bodies stand when the sliders stand at values.
function placed(values) {
  const poses = [];
  for (const frame of data.frames) {
    if (!frame.motions.length) { poses.push({r: frame.rotation, o: frame.position}); continue; }
    const parent = frame.parent < 0 ? {r: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], o: [0, 0, 0]} : poses[frame.parent];
    let r = product(parent.r, frame.originRotation), o = add(parent.o, turn(parent.r, frame.origin));
    for (const m of frame.motions) {
      const value = values[m.slider] * m.factor + m.offset;
      if (m.kind === "turn") r = product(r, rotation(m.axis, value));
      else o = add(o, turn(r, m.axis.map(x => x * value)));
    }
    poses.push({r, o});
  }
  return poses;
}
function shade(colour, l) {
  const k = 0.62 + 0.5 * Math.max(0, l);
  return "rgb(" + [1, 3, 5].map(i => Math.min(255, Math.round(parseInt(colour.slice(i, i + 2), 16) * k))).join(",") + ")";
}
function hull(points) {
  const sorted = points.map(p => [p[0], p[1]]).sort((a, b) => a[0] - b[0] || a[1] - b[1]), out = [];
  for (const sweep of [sorted, sorted.slice().reverse()]) {
    const chain = [];
    for (const p of sweep) {
      while (chain.length > 1) {
        const a = chain[chain.length - 2], b = chain[chain.length - 1];
        if ((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0) break;
        chain.pop();
      }
      chain.push(p);
    }
    out.push(...chain.slice(0, -1));
  }
  return out;
}
function arrow(a, b) {
  const dx = b[0] - a[0], dy = b[1] - a[1], n = Math.hypot(dx, dy);
  if (n < 1) return line([a, b]);
  const ux = dx / n, uy = dy / n, h = Math.min(9, 0.6 * n), base = [b[0] - h * ux, b[1] - h * uy], w = 0.38 * h;
  return line([a, base]) + line([[base[0] - w * uy, base[1] + w * ux], b, [base[0] + w * uy, base[1] - w * ux]], true);
}
function zigzag(a, b, coils = 9, width = 6) {
  const dx = b[0] - a[0], dy = b[1] - a[1], n = Math.hypot(dx, dy), at = (t, w) => [a[0] + t * dx - w * dy / n, a[1] + t * dy + w * dx / n];
  if (n < 1) return line([a, b]);
  const points = [a, at(0.15, 0)];
  for (let k = 0; k < 2 * coils; k++) points.push(at(0.15 + 0.7 * (k + 0.5) / (2 * coils), k % 2 ? width : -width));
  return line([...points, at(0.85, 0), b]);
}
const make = (name, attributes) => {
  const element = document.createElementNS(NS, name);
  for (const key in attributes) element.setAttribute(key, attributes[key]);
  return element;
};
function element(s) {
  if (s.kind === "dot" || s.kind === "ball") return make("circle", {class: s.kind === "dot" ? "dot" : "", r: s.size});
  if (s.kind === "com") {
    const g = make("g", {class: "com"}), r = s.size;
    g.append(make("circle", {r}), make("path", {d: `M0 0h${r}a${r} ${r} 0 0 0-${r}-${r}zM0 0h-${r}a${r} ${r} 0 0 0 ${r} ${r}z`}));
    return g;
  }
  const classes = {face: "", glass: "glass", hull: "hull", sheet: "sheet " + s.colour, line: "line " + s.colour, arrow: "arrow", spring: "line spring"};
  const e = make("path", {class: classes[s.kind]});
  if (["line", "arrow", "spring"].includes(s.kind)) e.setAttribute("stroke-width", s.size);
  if (s.kind === "hull") { e.setAttribute("fill", s.colour); e.setAttribute("stroke", s.colour); }
  return e;
}
// A drawing that can be turned. `poses`: where the bodies stand; `extent`: points that the picture must hold, where
// those are not the points drawn; `trace`: points joined by a line; `keep`: what is drawn of the shapes.
function view(svg, poses, keep) {
  const shapes = data.shapes.filter(keep).map(s => ({...s, e: element(s)}));
  const group = svg.querySelector(".solids"), labels = [...svg.querySelectorAll(".labels>g")], corner = svg.querySelector(".inset");
  const first = data.axes.map(row => row.slice());
  let axes = first, scale = 0, middle = [0, 0, 0], extent = null, trace = null, steady = false, asked = false, held = null;
  const ground = (body, p) => body < 0 ? p : add(poses[body].o, turn(poses[body].r, p));
  const owner = (s, i) => i && i === s.points.length - 1 ? s.end : s.body;
  const seen = p => {
    const v = turn(axes, sub(p, data.centre));
    return [width / 2 + scale * (v[0] - middle[0]), height / 2 - scale * (v[1] - middle[1]), v[2]];
  };
  const see = (body, p) => seen(ground(body, p));
  function aim(onlyIfNeeded) {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    const hold = p => {
      const v = turn(axes, sub(p, data.centre));
      for (let k = 0; k < 3; k++) { low[k] = Math.min(low[k], v[k]); high[k] = Math.max(high[k], v[k]); }
    };
    for (const s of shapes) if (!extent || s.body < 0) s.points.forEach((p, i) => hold(ground(owner(s, i), p)));
    if (extent) extent.forEach(hold);
    const fit = Math.min((width - 2 * margin) / Math.max(high[0] - low[0], 1e-9), (height - 2 * margin) / Math.max(high[1] - low[1], 1e-9));
    const fits = [0, 1].every(k => Math.max(high[k] - middle[k], middle[k] - low[k]) * scale < [width, height][k] / 2 - 8);
    if (onlyIfNeeded && fits) return;
    scale = fit;
    middle = [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2];
  }
  function update(s) {
    const p = s.points.map((x, i) => see(owner(s, i), x));
    s.depth = p.reduce((sum, x) => sum + x[2], 0) / p.length + s.lift;
    s.hidden = false;
    if (s.kind === "face" || s.kind === "glass") {
      let area = 0;
      p.forEach((a, i) => { const b = p[(i + 1) % p.length]; area += a[0] * b[1] - a[1] * b[0]; });
      s.hidden = area >= 0;
      if (s.hidden) return;
      const q = p.map(x => [x[0], -x[1], x[2] * scale]);
      const colour = shade(s.colour, dot(unit(cross(sub(q[1], q[0]), sub(q[2], q[0]))), light));
      s.e.setAttribute("fill", colour); s.e.setAttribute("stroke", colour); s.e.setAttribute("d", line(p, true));
    } else if (s.kind === "sheet") s.e.setAttribute("d", line(p, true));
    else if (s.kind === "hull") s.e.setAttribute("d", line(hull(p), true));
    else if (s.kind === "line") s.e.setAttribute("d", line(p));
    else if (s.kind === "spring") s.e.setAttribute("d", zigzag(p[0], p[1]));
    else if (s.kind === "arrow") s.e.setAttribute("d", arrow(p[0], p[1]));
    else {
      s.e.setAttribute("transform", `translate(${f(p[0][0])} ${f(p[0][1])})`);
      if (s.kind === "ball") { s.e.setAttribute("r", s.size * scale); s.e.setAttribute("fill", shade(s.colour, 0.6)); }
    }
  }
  function draw() {
    aim(steady && scale > 0);
    steady = false;
    shapes.forEach(update);
    const drawn = shapes.filter(s => !s.hidden).sort((a, b) => a.depth - b.depth).map(s => s.e);
    if (trace) drawn.push(...trace.map(t => make("path", {class: t.style, d: line(t.points.map(seen))})));
    group.replaceChildren(...drawn);
    labels.forEach((g, i) => {
      const l = data.labels[i], p = see(l.body, l.point);
      g.setAttribute("transform", `translate(${f(p[0])} ${f(p[1])})`);
    });
    [...corner.children].forEach((g, i) => {
      const v = turn(axes, inset.directions[i]), n = Math.hypot(v[0], v[1]) || 1;
      const x = inset.x + inset.sizes[i] * v[0], y = inset.y - inset.sizes[i] * v[1];
      g.firstElementChild.setAttribute("d", arrow([inset.x, inset.y], [x, y]));
      g.lastElementChild.setAttribute("x", f(x + 10 * v[0] / n)); g.lastElementChild.setAttribute("y", f(y - 10 * v[1] / n + 4));
    });
  }
  function redraw() {
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => { asked = false; draw(); });
  }
  function look(yaw, pitch) {
    axes = axes.map(row => turn(rotation(data.up, -yaw), row));
    const tilted = product(rotation([1, 0, 0], pitch), axes);
    const sine = dot(tilted[2], data.up);
    if (Math.abs(sine) < 0.995 && dot(tilted[1], data.up) > 0) axes = tilted;
    redraw();
  }
  svg.addEventListener("pointerdown", e => { held = [e.clientX, e.clientY]; svg.setPointerCapture(e.pointerId); });
  svg.addEventListener("pointermove", e => {
    if (!held) return;
    look((e.clientX - held[0]) * 0.008, (e.clientY - held[1]) * 0.008);
    held = [e.clientX, e.clientY];
  });
  for (const name of ["pointerup", "pointercancel"]) svg.addEventListener(name, () => { held = null; });
  svg.addEventListener("keydown", e => {
    const step = {ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1]}[e.key];
    if (step) { e.preventDefault(); look(...step); }
  });
  svg.setAttribute("tabindex", "0");
  svg.classList.add("live");
  return {
    pose(found) { poses = found; steady = scale > 0; redraw(); },
    hold(points) { extent = points; scale = 0; redraw(); },
    trace(lines) { trace = lines; steady = scale > 0; redraw(); },
    front() { axes = first.map(row => row.slice()); scale = 0; redraw(); },
  };
}
const values = data.sliders.map(s => s.value), start = values.slice(), main = view(picture, placed(values), () => true);
const box = document.getElementById("mechanism-controls"), inputs = [];
const show = (s, x) => x.toFixed(2).replace("-", "\u2212") + "\u2009" + s.unit;
data.sliders.slice(0, 12).forEach((s, i) => {
  const label = document.createElement("label"), input = document.createElement("input"), output = document.createElement("output");
  Object.assign(input, {type: "range", min: s.low, max: s.high, step: (s.high - s.low) / 200, value: s.value});
  output.textContent = show(s, s.value);
  input.addEventListener("input", () => { values[i] = +input.value; output.textContent = show(s, values[i]); main.pose(placed(values)); });
  label.append(s.label, input, output);
  inputs.push([input, output]);
  box.append(label);
});
const reset = document.createElement("button");
reset.type = "button";
reset.textContent = "Reset";
reset.addEventListener("click", () => {
  start.forEach((x, i) => { values[i] = x; });
  inputs.forEach(([input, output], i) => { input.value = start[i]; output.textContent = show(data.sliders[i], start[i]); });
  main.pose(placed(values));
  main.front();
});
box.append(reset);
box.hidden = false;
document.getElementById("mechanism-hint").hidden = false;
// A second drawing that a motion moves: it is told where the bodies stand, and shows neither vectors nor points.
const stage = document.getElementById("motion-drawing");
if (stage) {
  const copy = picture.cloneNode(true);
  copy.querySelector(".solids").replaceChildren();
  copy.querySelector(".labels").replaceChildren();
  copy.setAttribute("aria-label", stage.dataset.title);
  stage.prepend(copy);
  const moved = view(copy, placed(values), s => !["arrow", "dot"].includes(s.kind) && s.colour !== "auxiliary");
  stage.addEventListener("symgen-motion", e => { for (const key in e.detail) moved[key](e.detail[key]); });
}
})();
