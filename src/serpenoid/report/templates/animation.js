"use strict";
(() => {
  const trials = JSON.parse(document.getElementById("data").textContent);
  if (!trials.length) return;
  document.getElementById("animation").hidden = false;
  const pick = document.getElementById("which"), play = document.getElementById("play");
  const scrub = document.getElementById("scrub"), clock = document.getElementById("clock");
  const stage = document.getElementById("stage"), pen = stage.getContext("2d");
  const hidden = new Set();
  let trial = trials[0], frame = 0, running = false, begun = 0, place = null;

  trials.forEach((t, i) => pick.add(new Option(t.name, i)));
  function keys() {
    const box = document.getElementById("keys");
    box.replaceChildren();
    for (const [name, c] of Object.entries(trial.classes)) {
      const label = document.createElement("label"), tick = document.createElement("input"), bar = document.createElement("i");
      label.className = "key"; tick.type = "checkbox"; tick.checked = !hidden.has(name); bar.style.background = c.colour;
      tick.onchange = () => { if (tick.checked) hidden.delete(name); else hidden.add(name); draw(); };
      label.append(tick, bar, c.label);
      box.append(label);
    }
  }
  function fit() {
    let x0 = Infinity, x1 = -Infinity, y0 = Infinity, y1 = -Infinity;
    for (const c of Object.values(trial.classes)) for (const b of c.bodies) for (const [x, y] of b) {
      x0 = Math.min(x0, x); x1 = Math.max(x1, x); y0 = Math.min(y0, y); y1 = Math.max(y1, y);
    }
    const k = Math.min((stage.width - 80) / (x1 - x0 || 1), (stage.height - 80) / (y1 - y0 || 1));
    place = ([x, y]) => [stage.width / 2 + k * (x - (x0 + x1) / 2), stage.height / 2 - k * (y - (y0 + y1) / 2)];
    place.scale = k;
  }
  function line(points, colour, width, alpha) {
    pen.beginPath(); pen.globalAlpha = alpha; pen.strokeStyle = colour; pen.lineWidth = width;
    pen.lineJoin = pen.lineCap = "round";
    points.forEach((p, i) => { const [x, y] = place(p); if (i) pen.lineTo(x, y); else pen.moveTo(x, y); });
    pen.stroke(); pen.globalAlpha = 1;
  }
  function draw() {
    pen.clearRect(0, 0, stage.width, stage.height);
    pen.fillStyle = "#6b6b6b"; pen.font = "18px system-ui, sans-serif";
    pen.fillRect(30, stage.height - 26, place.scale / 4, 3); pen.fillText("a quarter body length", 30, stage.height - 34);
    for (const [name, c] of Object.entries(trial.classes)) {
      if (hidden.has(name)) continue;
      line(c.path, c.colour, 1.5, 0.35);
      line(c.path.slice(0, frame + 1), c.colour, 3, 0.9);
      line(c.bodies[frame], c.colour, c.width, 0.85);
      const head = place(c.bodies[frame][c.bodies[frame].length - 1]);
      pen.beginPath(); pen.fillStyle = c.colour; pen.arc(head[0], head[1], 10, 0, 7); pen.fill();
    }
    scrub.value = frame;
    clock.textContent = trial.time[frame].toFixed(2) + " s";
  }
  function choose() {
    trial = trials[+pick.value]; frame = 0; begun = performance.now();
    scrub.max = trial.time.length - 1; fit(); keys(); draw();
  }
  function tick(now) {
    if (!running) return;
    const time = ((now - begun) / 1000) % (trial.time[trial.time.length - 1] + 0.5);
    frame = trial.time.findIndex((t) => t >= time);
    if (frame < 0) frame = trial.time.length - 1;
    draw(); requestAnimationFrame(tick);
  }
  function run(on) {
    running = on; play.textContent = on ? "Pause" : "Play";
    if (on) { begun = performance.now() - 1000 * trial.time[frame]; requestAnimationFrame(tick); }
  }
  pick.onchange = choose;
  scrub.oninput = () => { run(false); frame = +scrub.value; draw(); };
  play.onclick = () => run(!running);
  choose();
  document.body.dataset.ready = "yes";
})();
