// Print the Khronos validator's errors about glTF files as JSON, one list per file given.
import { readFile } from "node:fs/promises";
import { basename, dirname, resolve } from "node:path";
import validator from "gltf-validator";

const reports = [];
for (const path of process.argv.slice(2)) {
  const report = await validator.validateBytes(new Uint8Array(await readFile(path)), {
    uri: basename(path),
    maxIssues: 100,
    externalResourceFunction: async (uri) => new Uint8Array(await readFile(resolve(dirname(path), decodeURIComponent(uri)))),
  });
  reports.push(report.issues.messages);
}
console.log(JSON.stringify(reports));
