// Runs the Khronos glTF validator on files: node validate.mjs FILE...
// Exits with 1 if any file has an error or a warning, and prints the first ones; with 0 otherwise.
//
// The validator does not know the draft KHR_mesh_primitive_restart, which allows the highest value of the index type in
// strips, fans and loops. In a document that lists it in extensionsRequired, these two messages are ignored:
//   ACCESSOR_INDEX_PRIMITIVE_RESTART  for the indices of primitives of modes 2, 3, 5 and 6,
//   ACCESSOR_INDEX_OOB                for the same indices, if the index is the restart value.
// (Its UNSUPPORTED_EXTENSION is information, not a warning.)

import { readFileSync } from "node:fs";
import validator from "gltf-validator";

const EXTENSION = "KHR_mesh_primitive_restart";
const RESTART = { 5121: 0xff, 5123: 0xffff, 5125: 0xffffffff };
const MODES = new Set([2, 3, 5, 6]);
const ERROR = 0;
const WARNING = 1;

/** Returns the JSON of a GLB or glTF file. */
function documentOf(bytes) {
  if (bytes.toString("latin1", 0, 4) !== "glTF") return JSON.parse(bytes.toString("utf8"));
  return JSON.parse(bytes.toString("utf8", 20, 20 + bytes.readUInt32LE(12)));
}

/** Returns the JSON pointers of the indices that may contain a restart, with the restart value. */
function restartIndices(document) {
  const allowed = new Map();
  if (!(document.extensionsRequired ?? []).includes(EXTENSION)) return allowed;
  for (const [m, mesh] of (document.meshes ?? []).entries()) {
    for (const [p, { indices, mode = 4 }] of mesh.primitives.entries()) {
      const component = document.accessors?.[indices]?.componentType;
      if (MODES.has(mode) && component in RESTART) {
        allowed.set(`/meshes/${m}/primitives/${p}/indices`, RESTART[component]);
      }
    }
  }
  return allowed;
}

function isRestart(message, allowed) {
  if (!allowed.has(message.pointer)) return false;
  if (message.code === "ACCESSOR_INDEX_PRIMITIVE_RESTART") return true;
  const value = String(allowed.get(message.pointer));
  return message.code === "ACCESSOR_INDEX_OOB" && message.message.includes(`has value ${value} `);
}

let failed = process.argv.length < 3;
if (failed) console.error("usage: node validate.mjs FILE...");
for (const file of process.argv.slice(2)) {
  const bytes = readFileSync(file);
  const report = await validator.validateBytes(new Uint8Array(bytes), { uri: file, maxIssues: 0 });
  const counted = report.issues.messages.filter((m) => m.severity === ERROR || m.severity === WARNING);
  const allowed = counted.length > 0 ? restartIndices(documentOf(bytes)) : new Map();
  const left = counted.filter((message) => !isRestart(message, allowed));
  failed ||= left.length > 0;
  for (const message of left.slice(0, 10)) {
    const severity = message.severity === ERROR ? "error" : "warning";
    console.log(`${file}: ${severity} ${message.code} at ${message.pointer ?? message.offset}: ${message.message}`);
  }
  if (left.length > 10) console.log(`${file}: ${left.length - 10} more`);
}
process.exit(failed ? 1 : 0);
