// A palletising arm: its form, the target, every way of being there with what it takes.

import { ArmPictures } from "./arm_pictures.js";
import { byId, element, figure } from "./dom.js";
import { field } from "./fields.js";
import { words } from "./names.js";
import { showStatus, tableParts, terms } from "./result.js";

const LENGTHS = ["shoulder_height_mm", "shoulder_offset_mm", "upper_arm_mm", "forearm_mm", "wrist_offset_mm", "tool_mm"];
const LIMITS = ["base_deg", "upper_arm_deg", "forearm_deg", "opening_deg", "tool_deg"];
const HEAD = ["", "base", "elbow", "axis 1", "upper arm", "forearm", "tool", "in line", "axis 2 [N m]", "axis 3 [N m]", "exceeds"];

export class Arm {
  constructor(api, store, ask) {
    Object.assign(this, { api, store, ask, box: byId("arm"), index: null, way: "" });
    this.pictures = new ArmPictures((place) => this.#move(place));
  }

  // -- the form -----------------------------------------------------------------------------

  sections(form) {
    return [
      ["Target", this.#target(form)],
      ["Lengths", form.some(LENGTHS, { slider: true })],
      ["Limits of the joints", form.some(LIMITS)],
      ["Load", [...form.some(["payload_kg"], { slider: true }), ...form.some(["masses"])]],
      ["Name", form.some(["name"])],
    ];
  }

  #target(form) {
    const poses = this.store.at("/poses") ?? [];
    if (!(this.index in poses)) this.index = Math.max(0, poses.findIndex(({ kind }) => kind === "point"));
    const select = element(
      "select",
      { id: "pose", onchange: () => this.#choose(Number(select.value)) },
      ...poses.map(({ name }, k) => element("option", { value: k }, name || `pose ${k + 1}`)),
    );
    select.value = this.index;
    const button = (text, disabled, onclick) => element("button", { type: "button", class: "small", disabled, onclick }, text);
    const { items } = form.schemas.spec.properties.poses;
    return [
      element(
        "p", { class: "buttons" },
        element("label", { for: "pose" }, "Pose"), select,
        button("Add one", false, () => this.#add(poses)),
        button("Remove it", poses.length < 2, () => this.store.set(`/poses/${this.index}`, undefined, true)),
      ),
      poses.length > 0 ? field(form, `/poses/${this.index}`, items, { label: "given by", slider: true, required: true }) : null,
    ].filter(Boolean);
  }

  #choose(index) {
    this.index = index;
    this.store.set("/poses", this.store.at("/poses"), true);
    this.#draw();
  }

  #add(poses) {
    const { x_mm = 1000, y_mm = 0, z_mm = 500 } = this.found?.poses[this.index] ?? {};
    this.index = poses.length;
    this.store.set(`/poses/${poses.length}`, { kind: "point", name: `pose ${poses.length + 1}`, x_mm, y_mm, z_mm }, true);
  }

  /** Takes the target elsewhere: {x_mm, y_mm, z_mm}, or some of them. */
  #move(place) {
    const asked = this.store.at(`/poses/${this.index}`);
    const { name } = asked;
    const before = { ...this.found.poses[this.index], ...asked };
    const [x_mm, y_mm, z_mm, yaw_deg] = ["x_mm", "y_mm", "z_mm", "yaw_deg"].map((key) => tidy(place[key] ?? before[key]));
    this.store.set(`/poses/${this.index}`, { kind: "point", name, x_mm, y_mm, z_mm, yaw_deg }, true);
    this.ask();
  }

  // -- what comes out -----------------------------------------------------------------------

  async show(found, signal) {
    const scene = await this.api.get(`${found.links.self}/animation.json`, { signal });
    Object.assign(this, { found, scene });
    this.box.hidden = false;
    byId("regions").replaceChildren(...tableParts(["elbow", "radius", "level", "area", "volume"], found.regions.map(region)));
    byId("torques").replaceChildren(...tableParts(["axis", "torque", "at its angle"], found.torques.map(torque)));
    byId("singular").replaceChildren(...singular(found.singular));
    this.#draw();
  }

  #draw() {
    const { found, scene } = this;
    if (!found) return;
    const pose = found.poses[this.index];
    showStatus(describe(found, pose), found.status);
    byId("pose-note").textContent = pose?.note ?? "";
    const ways = pose?.solutions ?? [];
    const chosen = Math.max(0, ways.findIndex((each) => nameOf(each) === this.way));
    const rows = ways.map((each, k) => this.#row(each, k === chosen));
    byId("ways").replaceChildren(...(ways.length > 0 ? tableParts(HEAD, rows) : []));
    byId("target").replaceChildren(...(pose ? terms({ x_mm: pose.x_mm, y_mm: pose.y_mm, z_mm: pose.z_mm, yaw_deg: pose.yaw_deg }) : []));
    const asked = this.store.at(`/poses/${this.index}`);
    const fresh = ["x_mm", "y_mm", "z_mm"].every((key) => (asked?.[key] ?? 0) === (found.spec.poses[this.index]?.[key] ?? 0));
    this.pictures.show(scene, pose, this.index, chosen, fresh);
  }

  #row(each, chosen) {
    const name = nameOf(each);
    const radio = element("input", {
      type: "radio", name: "way", "aria-label": `show ${name}`, id: `way-${name.replaceAll(" ", "-")}`, checked: chosen,
      onchange: () => {
        this.way = name;
        this.#draw();
        byId(radio.id)?.focus();
      },
    });
    const numbers = [
      [each.base_deg, 5, "°"], [each.upper_arm_deg, 5, "°"], [each.forearm_deg, 5, "°"], [each.tool_deg, 5, "°"],
      [each.in_line, 3, ""], [each.torque_upper_nm, 5, ""], [each.torque_forearm_nm, 5, ""],
    ];
    const beyond = each.beyond.map(({ joint, excess_deg: by }) => `${words(joint)} by ${figure(by, 4)}°`).join(", ");
    return element(
      "tr",
      { class: beyond ? "broken" : "" },
      element("td", {}, radio),
      element("th", { scope: "row" }, each.base),
      ...[each.elbow, ...numbers.map(([value, digits, unit]) => `${figure(value, digits)}${unit}`), beyond || "nothing"].map((text) => element("td", {}, text)),
    );
  }
}

/** A coordinate as a person would write it. */
const tidy = (value) => Number(value.toFixed(3));

/** A way of being somewhere, as long as base and tool turn no further than once. */
const nameOf = ({ base, elbow, base_deg, tool_deg }) => `${base} ${elbow} ${Math.round(base_deg / 360)} ${Math.round(tool_deg / 360)}`;

function describe(found, pose) {
  const taken = found.poses.filter((each) => each.reachable).length;
  const all = found.poses.length === 0 ? "No pose is asked for." : `${taken} of ${found.poses.length} poses can be taken.`;
  const reach = `Reach ${figure(found.reach_mm, 6)} mm.`;
  if (!pose) return `${all} ${reach}`;
  const can = pose.solutions.filter((each) => each.beyond.length === 0).length;
  const ways = can === 1 ? "one way" : `${can} ways`;
  return `${pose.name || "The target"}: ${pose.reachable ? `${ways} within the limits` : "out of reach"}. ${all} ${reach}`;
}

const cells = (head, ...texts) => element("tr", {}, element("th", { scope: "row" }, head), ...texts.map((text) => element("td", {}, text)));

function region({ elbow, r_min: inner, r_max: outer, z_min: low, z_max: high, area_mm2: area, volume_mm3: volume }) {
  const span = (from, to) => `${figure(from.value_mm, 6)} to ${figure(to.value_mm, 6)} mm`;
  return cells(elbow, span(inner, outer), span(low, high), `${figure(area * 1e-6, 5)} m²`, volume === null ? "–" : `${figure(volume * 1e-9, 5)} m³`);
}

const torque = ({ axis, torque_nm: value, angle_deg: angle }) => cells(words(axis), `${figure(value, 6)} N m`, `${figure(angle, 5)}°`);

function singular(all) {
  if (all.length === 0) return tableParts(["Nowhere within the limits."], []);
  const pair = ([upper, fore]) => `${figure(upper, 5)}°, ${figure(fore, 5)}°`;
  return tableParts(["difference", "from upper arm, forearm", "to"], all.map((each) => cells(`${figure(each.opening_deg, 5)}°`, pair(each.from_deg), pair(each.to_deg))));
}
