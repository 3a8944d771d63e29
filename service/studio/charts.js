// Motion, pressure angle and curvature over the cam angle; the cursors of all charts are one.

import { byId, element, figure } from "./dom.js";

const OF_A_CAM = [
  { stem: "s_", name: "displacement", from: "motion" },
  { stem: "v_", name: "velocity", from: "motion", limits: ["velocity"] },
  { stem: "a_", name: "acceleration", from: "motion", limits: ["acceleration"] },
  { stem: "j_", name: "jerk", from: "motion", limits: ["jerk"] },
  { stem: "pressure_angle_", name: "pressure angle", from: "profile",
    limits: ["pressure_angle_rise", "pressure_angle_return", "pressure_angle_dwell"] },
  { stem: "pitch_curvature_", name: "curvature of the pitch curve", from: "profile" },
];

export class Charts {
  /** `moved` receives the angle [°] under the pointer; `across` begins the name of its column. */
  constructor(moved, curves = OF_A_CAM, across = "theta_") {
    Object.assign(this, { moved, curves, across, plots: [] });
    new ResizeObserver(() => this.#fit()).observe(byId("charts"));
  }

  /** Draws the curves of a design, and those of another one dashed; a line stands at every mark. */
  show(found, other) {
    this.plots.forEach((plot) => plot.destroy());
    this.plots = [];
    const boxes = [];
    const sources = { motion: found.motion, profile: found.profile };
    for (const curve of this.curves) {
      const column = columnOf(sources[curve.from], curve.stem);
      if (!column) continue;
      const box = element("figure", { class: "chart" });
      boxes.push([box, curve, column]);
    }
    byId("charts").replaceChildren(...boxes.map(([box]) => box));
    for (const [box, curve, column] of boxes) this.#plot(box, curve, column, found, other);
    this.values = boxes.map(([box, , column]) => [box.querySelector(".now"), column]);
  }

  #plot(box, curve, column, found, other) {
    const now = element("output", { class: "now" });
    box.append(element("figcaption", {}, `${curve.name} [${column.unit}] `, now));
    const x = columnOf(found[curve.from], this.across).values;
    const series = [{ label: "angle" }, line(curve.name, token("--line"))];
    const data = [x, column.values];
    const second = other && columnOf(other[curve.from], curve.stem);
    if (second && second.unit === column.unit) {
      series.push({ ...line("A", token("--other")), dash: [6, 4] });
      data.push(resampled(columnOf(other[curve.from], this.across).values, second.values, x));
    }
    const { marks = [] } = found;
    const bounds = found.design.extremes
      .filter((each) => curve.limits?.includes(each.limit) && each.bound !== null)
      .map((each) => each.bound);
    const both = curve.from === "motion" ? bounds.flatMap((bound) => [bound, -bound]) : bounds;
    const limits = [...new Set(both)].filter(Number.isFinite);
    const options = {
      width: box.clientWidth || 400, height: 140, legend: { show: false }, series,
      cursor: { sync: { key: "cam" }, drag: { x: false, y: false }, y: false },
      scales: { x: { time: false, range: [0, 360] }, y: { range: (u, low, high) => roomy(low, high, limits) } },
      axes: [axis({ size: 30, values: (u, ticks) => ticks.map((tick) => `${tick}°`), incrs: [30, 45, 60, 90, 120, 180] }), axis({ size: 62, values: (u, ticks) => ticks.map((tick) => figure(tick, 4)) })],
      hooks: {
        drawAxes: [(u) => marks.forEach((angle) => marked(u, angle))],
        draw: [(u) => limits.forEach((bound) => ruled(u, bound))],
        setCursor: [(u) => this.#hover(u)],
      },
    };
    this.plots.push(new uPlot(options, data, box));
  }

  #hover(plot) {
    if (plot.cursor.event && plot.cursor.left >= 0) this.moved(plot.posToVal(plot.cursor.left, "x"));
  }

  /** Puts the cursor of all charts at a cam angle [°] and tells the values there. */
  point(angle) {
    for (const plot of this.plots) {
      plot.cursor.event = null;
      plot.setCursor({ left: plot.valToPos(angle, "x"), top: 0 }, false);
    }
    this.values?.forEach(([box, column], i) => {
      const at = this.plots[i].valToIdx(angle);
      box.textContent = figure(column.values[at], 5);
    });
  }

  #fit() {
    for (const plot of this.plots) {
      const width = plot.root.parentElement.clientWidth;
      if (width > 0 && width !== plot.width) plot.setSize({ width, height: plot.height });
    }
  }
}

/** The first column whose name begins so. */
export function columnOf(table, stem) {
  return table?.columns.find((column) => column.name.startsWith(stem));
}

/** y over another x, straight between points: for a picture only. */
function resampled(x, y, wanted) {
  let i = 0;
  return wanted.map((at) => {
    while (i < x.length - 2 && x[i + 1] < at) i += 1;
    const part = x[i + 1] > x[i] ? (at - x[i]) / (x[i + 1] - x[i]) : 0;
    return y[i] === null || y[i + 1] === null ? null : y[i] + part * (y[i + 1] - y[i]);
  });
}

function roomy(low, high, limits) {
  const least = Math.min(low, ...limits.filter((each) => each < 0));
  const most = Math.max(high, ...limits.filter((each) => each > 0));
  const room = 0.08 * (most - least || Math.abs(most) || 1);
  return [least - room, most + room];
}

/** A limit, as a broken line across. */
function ruled(plot, bound) {
  const y = plot.valToPos(bound, "y", true);
  const { left, width } = plot.bbox;
  drawn(plot, token("--limit"), [10, 4, 2, 4], [left, y], [left + width, y]);
}

/** A marked angle, as a line upwards. */
function marked(plot, angle) {
  const x = plot.valToPos(angle, "x", true);
  const { top, height } = plot.bbox;
  drawn(plot, token("--soft"), [], [x, top], [x, top + height]);
}

function drawn({ ctx }, stroke, dashes, from, to) {
  ctx.save();
  ctx.strokeStyle = stroke;
  ctx.setLineDash(dashes);
  ctx.lineWidth = devicePixelRatio;
  ctx.beginPath();
  ctx.moveTo(...from);
  ctx.lineTo(...to);
  ctx.stroke();
  ctx.restore();
}

const line = (label, stroke) => ({ label, stroke, width: 1.5, points: { show: false } });
const axis = (more) => ({
  stroke: token("--soft"), grid: { stroke: token("--grid"), width: 1 }, ticks: { show: false },
  font: "11px system-ui, sans-serif", ...more,
});

/** A colour of the page's theme. */
export const token = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
