"use strict";
(() => {
  // Every part has one or two columns over a turn, evenly spaced; two values are a straight line.
  const data = JSON.parse(document.getElementById("frames").textContent);
  const one = (name) => document.getElementById(name);
  const parts = data.parts.map(({ name, kind, columns }) => {
    const last = columns[0].length - 1;
    const perTurn = kind === "turn" ? columns[0][last] - columns[0][0] : 0;
    const node = document.querySelector(`[data-part="${name}"]`);
    return { node, kind, columns, perTurn };
  });
  const outputs = data.readings.map((reading) => ({ ...reading, node: one(reading.name) }));
  const play = one("play"), angle = one("angle"), speed = one("speed");
  let turns = 0;
  let running = !matchMedia("(prefers-reduced-motion: reduce)").matches;
  let before = null;

  const at = (column, part) => {
    const place = part * (column.length - 1);
    const k = Math.min(Math.floor(place), column.length - 2);
    return column[k] === null || column[k + 1] === null
      ? Infinity : column[k] + (place - k) * (column[k + 1] - column[k]);
  };
  const text = (value, digits) => {
    if (!Number.isFinite(value) || Math.abs(value) > 1e6) return "∞";
    return value.toFixed(digits).replace("-", "\u2212");
  };
  const show = () => {
    const whole = Math.floor(turns), part = turns - whole;
    for (const { node, kind, columns, perTurn } of parts) {
      const [a, b] = columns.map((column) => at(column, part));
      node.setAttribute(
        "transform", kind === "turn" ? `rotate(${a + whole * perTurn})` : `translate(${a} ${b})`,
      );
    }
    for (const { node, digits, column } of outputs) node.textContent = text(at(column, part), digits);
    one("theta").textContent = text(360 * part, 1);
    if (document.activeElement !== angle || running) angle.value = 360 * part;
  };
  const run = (on) => {
    running = on;
    before = null;
    play.textContent = on ? "Pause" : "Play";
    if (on) requestAnimationFrame(tick);
  };
  const tick = (now) => {
    if (!running) return;
    if (before !== null) turns += (Math.min(now - before, 100) / 60000) * Number(speed.value);
    before = now;
    show();
    requestAnimationFrame(tick);
  };
  const step = (degrees) => {
    run(false);
    turns = Math.max(0, (Math.round(turns * 3600) + 10 * degrees) / 3600);
    show();
  };
  const faster = (by) => {
    speed.value = Number(speed.value) + by;
    speed.dispatchEvent(new Event("input"));
  };
  const keys = {
    ArrowRight: (key) => step(key.shiftKey ? 10 : 1),
    ArrowLeft: (key) => step(key.shiftKey ? -10 : -1),
    Home: () => { run(false); turns = 0; show(); },
    " ": () => run(!running),
    "+": () => faster(2),
    "-": () => faster(-2),
  };
  document.addEventListener("keydown", (key) => {
    if (key.ctrlKey || key.altKey || key.metaKey || !(key.key in keys)) return;
    if (key.key === " " && key.target.tagName === "BUTTON") return;
    if (key.target === speed && key.key.startsWith("Arrow")) return;
    key.preventDefault();
    keys[key.key](key);
  });
  play.addEventListener("click", () => run(!running));
  one("back").addEventListener("click", () => step(-1));
  one("forward").addEventListener("click", () => step(1));
  angle.addEventListener("input", () => {
    run(false);
    turns = Math.floor(turns) + Math.min(Number(angle.value) / 360, 0.999999);
    show();
  });
  speed.addEventListener("input", () => { one("shown").textContent = speed.value; });
  document.documentElement.classList.add("live");
  show();
  run(running);
})();
