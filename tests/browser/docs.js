// Every operation of /docs, executed in Chromium as a person does it: open it, "Try it out", choose a file where one is wanted,
// "Execute". Nothing is typed but the ids of things that were made before. Arguments: the browser, the folder of example programs,
// a folder for the browser's profile. TRUNNION_URL, TRUNNION_KEY (a key with every scope) and RECEIVER_PORT say where.

import { strict as assert } from "node:assert";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync } from "node:fs";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { chromium } from "playwright-core";

const [executable, examples, profile] = process.argv.slice(2);
const { TRUNNION_URL: url, TRUNNION_KEY: key, RECEIVER_PORT: receiverPort } = process.env;
const machine = "/v1/machines/example-ac-table";

// Operations that answer otherwise than 2xx, with the reason.
const REFUSED = {
  put_machine: { status: 428, reason: "the machine exists; to replace it, its ETag has to be read" },
  put_tool: { status: 428, reason: "the tool exists; to replace it, its ETag has to be read" },
};
// What comes last, because it takes away what others need. Everything else is executed in the order of the description.
const LAST = ["cancel_job", "withdraw_wear_entry", "delete_tool", "delete_machine", "revoke_api_key"];
// The files for the form of an operation; of several tools, posting takes cutter locations.
const FILES = { post_program: "flank.apt", verify_part: "dome.nc" };
// An archive of programs, made here.
const archive = join(mkdtempSync(join(tmpdir(), "programs-")), "programs.zip");
execFileSync("python3", ["-m", "zipfile", "-c", archive, join(examples, "blade.nc"), join(examples, "dome.nc")]);

const call = async (method, path, body, headers = {}) => {
  const isForm = body instanceof FormData;
  const response = await fetch(url + path, {
    method,
    headers: {
      Authorization: `Bearer ${key}`,
      Accept: "application/json",
      ...(body && !isForm ? { "Content-Type": "application/json" } : {}),
      ...headers,
    },
    body: isForm || body === undefined ? body : JSON.stringify(body),
  });
  const text = await response.text();
  assert.ok(response.ok, `${method} ${path}: ${response.status} ${text}`);
  return { headers: response.headers, json: /^[[{]/.test(text) ? JSON.parse(text) : undefined };
};

const file = (name) => new Blob([readFileSync(join(examples, name))]);
const job = async (request, name = "blade.nc", program = file(name)) => {
  const form = new FormData();
  form.append("job", JSON.stringify({ machine_id: "example-ac-table", ...request }));
  form.append("program", program, name);
  return (await call("POST", "/v1/jobs", form)).json.id;
};
const ended = async (id) => {
  for (let attempt = 0; attempt < 600; attempt += 1) {
    const { state, problem } = (await call("GET", `/v1/jobs/${id}`)).json;
    if (state === "succeeded") return id;
    assert.ok(state === "queued" || state === "running", `${id} ${state} ${JSON.stringify(problem)}`);
    await new Promise((resolve) => setTimeout(resolve, 100));
  }
  throw new Error(`${id} does not end`);
};
const told = async (id) => {
  for (let attempt = 0; attempt < 100; attempt += 1) {
    const { delivery } = (await call("GET", `/v1/jobs/${id}/deliveries`)).json;
    if (delivery?.state === "delivered") return id;
    await new Promise((resolve) => setTimeout(resolve, 100));
  }
  throw new Error(`nobody was told of ${id}`);
};

// What has to be there before, and the ids under which the operations find it.
const offset = [12, -7, 35];
const receiver = createServer((request, response) => request.resume().on("end", () => response.end()));
await new Promise((resolve) => receiver.listen(Number(receiverPort), "127.0.0.1", resolve));
const description = (await call("GET", "/openapi.json")).json;
const operations = Object.entries(description.paths).flatMap(([path, item]) =>
  Object.entries(item).map(([method, operation]) => ({ path, method, operation })),
);
const example = (path, method) =>
  description.paths[path][method].requestBody.content["application/json"].example;
const profilePath = "/v1/machines/{machine_id}";
// A program of a million blocks.
const lines = readFileSync(join(examples, "blade.nc"), "utf8").split("\n").map((line) => `${line.replace(/^N\d+ /, "")}\n`);
const first = lines.findIndex((line) => line.startsWith("G94 G1"));
const cuts = lines.filter((line) => line.startsWith("X")).join("");
const long = new Blob([...lines.slice(0, first + 1), cuts.repeat(1e6 / cuts.split("\n").length), "M30\n%\n"]);
const cc = { operation: "cc-compensation", parameters: { tool_radius_mm: 5, work_offset_mm: offset } };
const compensated = await ended(await job({ ...cc, callback_url: `http://127.0.0.1:${receiverPort}/` }));
await told(compensated);
const inOnePass = await ended(
  await job({ operation: "compensation", parameters: { location_errors: true, work_offset_mm: offset } }),
);
const dome = { kind: "sphere", radius_mm: 20, half_angle_deg: 20 };
const verified = await ended(
  await job(
    { operation: "verification", parameters: { tool: { radius_mm: 5 }, surface: dome, work_offset_mm: offset } },
    "dome.nc",
  ),
);
const run = JSON.parse(readFileSync(join(examples, "ballbar.json"), "utf8"));
const earlier = (await call("POST", `${machine}/calibrations`, run)).json.id;
const calibration = (await call("POST", `${machine}/calibrations`, run)).json.id;
await call("PUT", "/v1/machines/dmu-80-t", example(profilePath, "put"));
const toolPath = `${profilePath}/tools/{tool_id}`;
await call("PUT", `${machine}/tools/T12`, example(toolPath, "put"));
const entries = [3, 4, 5, 6, 7, 8].map((day, index) => ({
  measured_at: `2025-03-0${day}T09:26:53Z`,
  parts_cut: 30 * (index + 1),
  flank_wear_um: 61 + 10 * index,
}));
const entry = (await call("POST", `${machine}/tools/T12/wear-entries`, entries)).json[0].id;
const otherKey = (await call("POST", "/v1/keys", { name: "second", scopes: ["read"] })).json.id;
const jobIds = { get_job_changes: inOnePass, get_job_residuals: verified };
const idOf = async (operation, path) => {
  if (operation === "cancel_job") {
    // A job that waits behind long ones can still be cancelled.
    let last;
    for (let count = 0; count < 6; count += 1) last = await job(cc, "blade.nc", long);
    return last;
  }
  if (path.startsWith("/v1/jobs")) return jobIds[operation] ?? compensated;
  if (path.startsWith("/v1/keys")) return otherKey;
  return path.includes("wear-entries") ? entry : calibration;
};

const context = await chromium.launchPersistentContext(profile, {
  executablePath: executable,
  headless: true,
  viewport: { width: 1280, height: 1000 },
  args: [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
  ],
});
const page = context.pages()[0] ?? (await context.newPage());
// What is wrong is said at once, because a run takes minutes.
const faults = { count: 0, push: (fault) => console.error(`FAULT ${fault}`, (faults.count += 1)) };
page.on("pageerror", (fault) => faults.push(`the page: ${fault}`));
page.on("request", (request) => {
  if (!request.url().startsWith(url) && !/^(data|blob):/.test(request.url())) faults.push(`asks ${request.url()}`);
});
await page.goto(`${url}/docs/`);
await page.waitForSelector(".opblock");
// At first sight there are operations and no schemas.
const schemas = await page.locator(".models, .model-container, .json-schema-2020-12").count();
if (schemas > 0) faults.push(`${schemas} schemas are shown at first sight`);
if (process.env.PICTURES) await page.screenshot({ path: join(process.env.PICTURES, "docs.png") });

await page.locator(".auth-wrapper .btn.authorize").first().click();
await page.locator(".modal-ux input").first().fill(key);
await page.locator(".modal-ux .btn.authorize").click();
await page.locator(".modal-ux .btn-done").click();

// Executes an operation as it is filled in, with this media type of the body; the answer.
const execute = async (block, { path, method, operation }, kind) => {
  const choice = block.locator(".opblock-section-request-body select.content-type").first();
  if (kind && (await choice.inputValue()) !== kind) await choice.selectOption(kind);
  if (path.includes("{id}")) {
    const id = await idOf(operation.operationId, path);
    await block.locator('tr[data-param-name="id"] input').fill(id);
  }
  if (operation.operationId === "compare_calibrations")
    await block.locator('tr[data-param-name="from"] input').fill(earlier);
  if (kind === "multipart/form-data") {
    const many = operation.operationId === "create_job_batch";
    const name = FILES[operation.operationId] ?? "blade.nc";
    const field = many ? "programs" : "program";
    const row = block.locator(`.opblock-section-request-body tr[data-property-name="${field}"]`);
    await row.locator("input[type=file]").setInputFiles(many ? archive : join(examples, name));
  }
  const pattern = new RegExp(`^${url}${path.replace(/\{[^}]*\}/g, "[^/?]+")}(\\?.*)?$`);
  const answer = page.waitForResponse(
    (response) => pattern.test(response.url()) && response.request().method() === method.toUpperCase(),
    { timeout: 60_000 },
  );
  answer.catch(() => {});
  await block.locator(".btn.execute").click();
  const response = await answer;
  const shown = block.locator(".live-responses-table tbody .response-col_status").first();
  await shown.waitFor({ timeout: 60_000 });
  return { response, shown: Number((await shown.innerText()).split("\n")[0]) };
};

operations.sort((a, b) => LAST.indexOf(a.operation.operationId) - LAST.indexOf(b.operation.operationId));
let executed = 0;
for (const one of operations) {
  const { operation } = one;
  const id = operation.operationId;
  // ONLY=id,id is a shorter look.
  if (process.env.ONLY && !process.env.ONLY.split(",").includes(id)) continue;
  const block = page.locator(`#operations-${operation.tags[0]}-${id}`);
  await block.locator(".opblock-summary-control").click();
  await block.locator(".try-out__btn").click();
  const kinds = Object.keys(operation.requestBody?.content ?? { "": {} });
  for (const kind of kinds) {
    try {
      const { response, shown } = await execute(block, one, kind);
      const status = response.status();
      const name = `${id}${kind && ` as ${kind}`}`;
      const expected = REFUSED[id] ? status === REFUSED[id].status : status >= 200 && status < 300;
      if (!expected) {
        const text = await response.text().catch(() => "");
        faults.push(`${name}: ${status} ${decodeURI(response.url())} ${text.slice(0, 400)}`);
      } else if (shown !== status) faults.push(`${name}: the page shows ${shown}, the answer is ${status}`);
      else {
        const described = operation.responses[status]?.content;
        const found = (await response.headerValue("content-type"))?.split(";")[0];
        if (!operation.responses[status]) faults.push(`${name}: ${status} is not described`);
        else if (described && !described[found]) faults.push(`${name}: ${found} is not described`);
        else executed += 1;
      }
    } catch (fault) {
      faults.push(`${id} ${kind}: ${String(fault).slice(0, 600)}`);
      if (process.env.PICTURES) await page.screenshot({ path: join(process.env.PICTURES, `${id}.png`) });
    }
  }
  if (process.env.PICTURES && ["compensate_cc_path", "create_job"].includes(id))
    await block.screenshot({ path: join(process.env.PICTURES, `${id}.png`) });
  await block.locator(".opblock-summary-control").click();
}
await context.close();
receiver.close();
assert.equal(faults.count, 0);
assert.ok(executed >= 70 || process.env.ONLY, `only ${executed}`);
console.log(`${operations.length} operations of /docs executed in Chromium, ${executed} requests`);
