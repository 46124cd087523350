// Build the page's scripts into Python's package data: `npm ci && npm run build` in this folder.

import { createHash } from "node:crypto";
import { readdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { deflateSync } from "node:zlib";

import { build } from "esbuild";

const target = join(import.meta.dirname, "..", "src", "r3gw", "view", "bundle");
const libraries = ["@sparkjsdev/spark", "three"];

async function bundled(entry, options) {
  const result = await build({
    entryPoints: [join(import.meta.dirname, "src", entry)],
    bundle: true,
    format: "iife",
    target: "es2022",
    charset: "utf8",
    write: false,
    logLevel: "warning",
    logOverride: { "empty-import-meta": "silent" },
    ...options,
  });
  return result.outputFiles[0].text;
}

function licence(name) {
  const folder = join(import.meta.dirname, "node_modules", ...name.split("/"));
  const { version } = JSON.parse(readFileSync(join(folder, "package.json"), "utf8"));
  return `${name} ${version}\n\n${readFileSync(join(folder, "LICENSE"), "utf8").trim()}\n`;
}

/** The digest that tests/view/test_bundle.py compares: of every file that decides the result. */
function digest() {
  const files = readdirSync(join(import.meta.dirname, "src")).sort().map((f) => join("src", f));
  const hash = createHash("sha256");
  for (const file of [...files, "build.mjs", "package-lock.json"]) {
    hash.update(readFileSync(join(import.meta.dirname, file)));
  }
  return hash.digest("hex");
}

const vendor = await bundled("vendor.ts", { minify: true });
const reader = await bundled("reader.ts", { minify: true });
const external = [...libraries, "three/addons/*"];
const page = await bundled("main.ts", { external, minifySyntax: true, minifyWhitespace: true });
const boot = await bundled("boot.ts", { minifySyntax: true, minifyWhitespace: true });
const wrapped = `globalThis.r3gwPage=(require)=>{${page}};\n${boot}`;
writeFileSync(join(target, "libraries.js.deflate"), deflateSync(vendor, { level: 9 }));
writeFileSync(join(target, "reader.js.deflate"), deflateSync(reader, { level: 9 }));
writeFileSync(join(target, "page.js"), wrapped);
writeFileSync(join(target, "LICENCES.txt"), [...libraries, "fflate"].map(licence).join("\n\n"));
writeFileSync(join(target, "digest.txt"), digest() + "\n");
console.log(`libraries ${vendor.length} bytes, reader ${reader.length} bytes, page ${wrapped.length} bytes`);
