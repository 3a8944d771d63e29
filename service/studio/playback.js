// Time: play and pause, the slider of the cam angle, keys on the picture.

import { byId, figure } from "./dom.js";

export class Playback {
  /** `shown` receives the cam angle [°] at every step; keys are those pressed on `picture`. */
  constructor(shown, picture) {
    this.shown = shown;
    this.turns = 0;
    byId("play").addEventListener("click", () => this.#run(!this.running));
    byId("angle").addEventListener("input", () => this.turnTo(Number(byId("angle").value)));
    picture.addEventListener("keydown", (event) => this.#key(event));
    this.#run(!matchMedia("(prefers-reduced-motion: reduce)").matches);
  }

  /** Stops, and shows a cam angle [°]. */
  turnTo(angle) {
    this.#run(false);
    this.turns = Math.floor(this.turns) + Math.min(Math.max(angle, 0) / 360, 0.999999);
    this.show();
  }

  /** Whole turns so far, and the part of the present one. */
  get parts() {
    const whole = Math.floor(this.turns);
    return [whole, this.turns - whole];
  }

  show() {
    const angle = 360 * this.parts[1];
    byId("angle").value = angle;
    byId("angle-now").textContent = `${figure(Math.round(10 * angle) / 10, 4)}°`;
    this.shown(angle, this.parts);
  }

  #key(event) {
    const steps = { ArrowRight: 1, ArrowLeft: -1 };
    if (event.key === " ") this.#run(!this.running);
    else if (event.key in steps) {
      this.#run(false);
      const degrees = steps[event.key] * (event.shiftKey ? 10 : 1);
      this.turns = Math.max(0, (Math.round(this.turns * 360) + degrees) / 360);
      this.show();
    } else return;
    event.preventDefault();
  }

  #run(on) {
    this.running = on;
    this.before = null;
    byId("play").textContent = on ? "Pause" : "Play";
    byId("play").setAttribute("aria-pressed", on);
    if (on) requestAnimationFrame((now) => this.#tick(now));
  }

  #tick(now) {
    if (!this.running) return;
    if (this.before !== null) this.turns += Math.min(now - this.before, 100) / 1000 / Number(byId("pace").value);
    this.before = now;
    this.show();
    requestAnimationFrame((next) => this.#tick(next));
  }
}
