// A service with the page of another folder: everything else is asked of the service. So a page is looked at before a binary has it.
// Arguments: the address of the service, the port to listen on, the folder of the page.

import { readFileSync } from "node:fs";
import { createServer, request } from "node:http";
import { join } from "node:path";

const [service, port, folder] = process.argv.slice(2);
const KINDS = { html: "text/html; charset=utf-8", js: "text/javascript", css: "text/css", svg: "image/svg+xml", txt: "text/plain" };

createServer((asked, answer) => {
  const passed = request(service + asked.url, { method: asked.method, headers: asked.headers }, (given) => {
    const headers = { ...given.headers };
    const name = asked.url.startsWith("/page/") ? asked.url.slice("/page/".length) : asked.url === "/" ? "index.html" : null;
    const isPage = name !== null && /^[\w.-]+$/.test(name) && (name !== "index.html" || /html/.test(asked.headers.accept ?? ""));
    if (!isPage) {
      answer.writeHead(given.statusCode, headers);
      return void given.pipe(answer);
    }
    given.resume();
    // The headers of the first page, its policy among them, are those of the service.
    for (const dropped of ["content-encoding", "content-length", "transfer-encoding", "etag"]) delete headers[dropped];
    try {
      const bytes = readFileSync(join(folder, name));
      answer.writeHead(200, { ...headers, "content-type": KINDS[name.split(".").pop()], "content-length": bytes.length });
      answer.end(bytes);
    } catch {
      answer.writeHead(404).end();
    }
  });
  passed.on("error", () => answer.destroy());
  asked.on("error", () => passed.destroy());
  answer.on("close", () => passed.destroy());
  asked.pipe(passed);
}).listen(Number(port), "127.0.0.1");
