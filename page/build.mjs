// Makes the page: `dist/` from `src/`. The same sources give the same bytes.
// Another folder as an argument takes the place of `dist/`.

import { createHash } from "node:crypto";
import { mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { basename, dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2] ?? join(here, "dist");
const LIMIT_KB = 300;
// What is bundled, each with its licence.
const BUNDLED = ["preact", "@preact/signals", "@preact/signals-core", "three", "uplot"];

rmSync(out, { recursive: true, force: true });
mkdirSync(out, { recursive: true });

const result = await build({
  absWorkingDir: here,
  entryPoints: ["src/main.tsx", "src/styles/main.css"],
  outdir: out,
  bundle: true,
  splitting: true,
  format: "esm",
  target: "es2022",
  minify: true,
  charset: "utf8",
  legalComments: "none",
  jsx: "automatic",
  jsxImportSource: "preact",
  entryNames: "[name]-[hash]",
  chunkNames: "part-[hash]",
  loader: { ".nc": "text", ".apt": "text" },
  metafile: true,
  logLevel: "warning",
});

const made = Object.entries(result.metafile.outputs);
const made_from = (source) => basename(made.find(([, { entryPoint }]) => entryPoint === source)[0]);
const icon = readFileSync(join(here, "src/icon.svg"));
const iconName = `icon-${createHash("sha256").update(icon).digest("hex").slice(0, 8).toUpperCase()}.svg`;
writeFileSync(join(out, iconName), icon);
const first = readFileSync(join(here, "src/index.html"), "utf8")
  .replace("{script}", made_from("src/main.tsx"))
  .replace("{style}", made_from("src/styles/main.css"))
  .replaceAll("{icon}", iconName);
writeFileSync(join(out, "index.html"), first);

const licences = BUNDLED.map((name) => {
  const folder = join(here, "node_modules", name);
  const { version, license, homepage, author } = JSON.parse(readFileSync(join(folder, "package.json"), "utf8"));
  const file = readdirSync(folder).find((one) => /^licen[cs]e/i.test(one));
  const text = file ? readFileSync(join(folder, file), "utf8").replaceAll("\r\n", "\n").trim() : "";
  const by = typeof author === "string" ? author : (author?.name ?? "");
  return `${name} ${version}, ${license}${homepage ? `, ${homepage}` : ""}${file ? "" : `, ${by}`}\n\n${text}\n`;
});
const intro = "The page of Trunnion contains these libraries. Their licences follow.\n";
writeFileSync(join(out, "LICENSES.txt"), [intro, ...licences].join(`\n${"-".repeat(72)}\n\n`));

let total = 0;
for (const name of readdirSync(out).sort()) {
  const bytes = readFileSync(join(out, name));
  const packed = gzipSync(bytes, { level: 9 }).length;
  if (name !== "LICENSES.txt") total += packed;
  console.log(`${name.padEnd(28)} ${String(bytes.length).padStart(8)} B ${String(packed).padStart(8)} B gzip`);
}
console.log(`${"all but licences".padEnd(28)} ${" ".repeat(10)} ${String(total).padStart(8)} B gzip`);
if (total > LIMIT_KB * 1000) throw new Error(`the page is larger than ${LIMIT_KB} kB`);
