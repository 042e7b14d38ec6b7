// Types that openapi-typescript made, in use by openapi-fetch: a machine, kinematics, a program compensated, a posted job, a
// problem, a key. TRUNNION_URL and TRUNNION_KEY (a key with every scope) say where; the argument is a program.

import { strict as assert } from "node:assert";
import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";
import createClient from "openapi-fetch";
import type { components, paths } from "./trunnion.js";

const url = process.env.TRUNNION_URL ?? "";
const program = readFileSync(process.argv[2] ?? "", "utf8");
const connect = (key: string) =>
  createClient<paths>({
    baseUrl: url,
    headers: { Authorization: `Bearer ${key}` },
    // Commas separate the elements of an array.
    querySerializer: { array: { style: "form", explode: false } },
  });
const client = connect(process.env.TRUNNION_KEY ?? "");
const path = { machine_id: "typescript-client" };

const profile: components["schemas"]["MachineProfile"] = {
  name: "made by a TypeScript client",
  kinematics: {
    rotary_axes: [
      { name: "A", side: "table", direction: [1, 0, 0], point_mm: [0, 0, 0], limits_deg: [-120, 120] },
      { name: "C", side: "table", direction: [0, 0, 1], point_mm: [0, 0, 0], limits_deg: null },
    ],
  },
};
const machine = await client.PUT("/v1/machines/{machine_id}", { params: { path }, body: profile });
assert.equal(machine.data?.revision, 1);

const solved = await client.POST("/v1/machines/{machine_id}/inverse-kinematics", {
  params: { path },
  body: { poses: [{ x: 10, y: 20, z: 30, i: 0.3, j: -0.2, k: 0.93 }] },
});
// The same operation answers CSV where that is accepted.
const joints = (solved.data as components["schemas"]["SolvedPoses"]).joints ?? [];
const back = await client.POST("/v1/machines/{machine_id}/forward-kinematics", { params: { path }, body: { joints } });
const found = (back.data as components["schemas"]["ForwardAnswer"]).poses[0];
assert.ok(found && Math.hypot(found.x - 10, found.y - 20, found.z - 30) < 1e-9);

// Text in, text out: the program is what is answered unless something else is accepted.
const compensated = await client.POST("/v1/machines/{machine_id}/cc-compensation", {
  params: { path, query: { tool_radius_mm: 5, work_offset_mm: [12, -7, 35] } },
  headers: { "Content-Type": "text/plain" },
  body: program,
  bodySerializer: (text: unknown) => text as string,
  parseAs: "text",
});
const answered = compensated.data as unknown as string;
assert.ok(answered.split("\n").length > program.split("\n").length);

const post = () =>
  client.POST("/v1/jobs", {
    params: { header: { "Idempotency-Key": "WO-4711/20 typescript" } },
    body: {
      job: {
        machine_id: path.machine_id,
        operation: "cc-compensation",
        parameters: { tool_radius_mm: 5, work_offset_mm: [12, -7, 35] },
        external_id: "WO-4711/20",
      },
      program,
    },
    bodySerializer: (body) => {
      const form = new FormData();
      form.append("job", new Blob([JSON.stringify(body.job)], { type: "application/json" }));
      form.append("program", new Blob([body.program]), "blade.nc");
      return form;
    },
  });
let job = (await post()).data;
assert.ok(job);
const id = job.id;
assert.equal((await post()).data?.id, id);
const deadline = Date.now() + 60_000;
while (job.state === "queued" || job.state === "running") {
  assert.ok(Date.now() < deadline, job.state);
  await new Promise((resolve) => setTimeout(resolve, 50));
  const told = await client.GET("/v1/jobs/{id}", { params: { path: { id } } });
  assert.ok(told.data);
  job = told.data;
}
assert.equal(job.state, "succeeded");
const download = await client.GET("/v1/jobs/{id}/program", { params: { path: { id } }, parseAs: "text" });
assert.equal(download.data, answered);
assert.equal(createHash("sha256").update(answered).digest("hex"), job.output_sha256);

const refused = await client.POST("/v1/machines/{machine_id}/inverse-kinematics", {
  params: { path },
  body: { poses: [{ x: 0, y: 0, z: 0, i: 0, j: 0, k: 0 }] },
});
assert.equal(refused.error?.status, 422);
assert.equal(refused.error?.type, "/problems/invalid-request");
assert.ok(refused.error?.errors?.[0]?.pointer.startsWith("/poses/0"));

const made = await client.POST("/v1/keys", { body: { name: "reader", scopes: ["read"] } });
const reader = connect(made.data?.key ?? "");
const kept = await reader.PUT("/v1/machines/{machine_id}", { params: { path }, body: profile });
assert.equal(kept.response.status, 403);
console.log("the TypeScript client works");
