// A caller's program on the client that openapi-typescript makes of the contract: run with the
// address of a service, it prints what a design came out as, a row of its file, and a refusal.
import createClient from "openapi-fetch";
import type { components, paths } from "./camwright.js";

declare const process: { argv: string[] }; // of Node.js

type DesignSpec = components["schemas"]["DesignSpec"];
type Segment = components["schemas"]["Segment"];

const rise: Segment = { kind: "rise", angle_deg: 60, lift_mm: 30, law: { kind: "cycloidal" } };
const spec: DesignSpec = {
  name: "from TypeScript",
  program: [rise, { kind: "dwell", angle_deg: 30 }, { ...rise, kind: "return" }, { kind: "dwell", angle_deg: 210 }],
  follower: { kind: "translating_roller", roller_radius_mm: 10 },
  base_radius_mm: { min: 20, max: 120 },
  limits: [{ kind: "pressure_angle", rise_deg: 30, return_deg: 45 }],
};
// @ts-expect-error: without its kind no segment is one
export const nameless: Segment = { angle_deg: 60, lift_mm: 30 };
// @ts-expect-error: no limit is called so
export const unknown: DesignSpec = { ...spec, limits: [{ kind: "pressure_angel", rise_deg: 30 }] };
// @ts-expect-error: a field that does not exist
export const misspelt: DesignSpec = { ...spec, baseRadius: 30 };

const service = createClient<paths>({ baseUrl: process.argv[2] ?? "http://127.0.0.1:8000" });
const { data: design, error } = await service.POST("/v1/designs", { body: spec });
if (error) throw new Error(`${error.title}: ${error.detail}`);
if (!("certificate" in design)) throw new Error(`still ${design.state}`);
const { data: table } = await service.GET("/v1/designs/{design_id}/profile.csv", {
  params: { path: { design_id: design.id }, query: { points_per_degree: 1 } },
  parseAs: "text",
});
const refused = await service.POST("/v1/designs", { body: { ...spec, speed_rpm: -3 } });
console.log(
  JSON.stringify({
    status: design.status,
    certified: design.certificate?.certified,
    base_radius_mm: design.dimensions["base_radius_mm"],
    rows: table?.trim().split("\n").length,
    pointer: refused.error?.errors?.[0]?.pointer,
  }),
);
