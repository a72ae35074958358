// Bundles what pages draw with and three.js, then the scripts of result pages and of the studio, which
// take the modules of this folder from that bundle; and copies the licence of three.js.
import { createHash } from "node:crypto";
import { copyFileSync, readFileSync, readdirSync } from "node:fs";
import { resolve } from "node:path";
import { build } from "esbuild";

const SHARED = "quadfoldViews"; // the global that the bundle of views.js makes
const STUDIO = "../../studio";
const COMMON = { bundle: true, minify: true, target: "es2022", charset: "ascii", legalComments: "none" };
const LICENCE = "/* with three.js, Copyright 2010-2026 three.js authors, MIT licence: see the end of the page */";

const scripts = (folder) =>
  readdirSync(folder).filter((name) => name.endsWith(".js")).sort().map((name) => `${folder}/${name}`);
const own = scripts(".");
const studios = scripts(`${STUDIO}/page_source`);

await bundle("views.js", own, "../page_assets/views.js", { format: "iife", globalName: SHARED }, LICENCE);
const shared = { name: "shared", setup: await takenFromShared() };
const taking = { format: "esm", plugins: [shared] };
await bundle("main.js", own, "../page_assets/page.js", taking);
await bundle(`${STUDIO}/page_source/studio.js`, [...own, ...studios], `${STUDIO}/page_assets/studio.js`, taking);
copyFileSync("node_modules/three/LICENSE", "../page_assets/three_licence.txt");

/** Bundle a script, with a digest of the sources that it depends on. */
async function bundle(entry, sources, outfile, options, licence = "") {
  const digest = createHash("sha256");
  for (const path of sources) digest.update(readFileSync(path));
  const js = `/* sources ${digest.digest("hex")} */\n${licence}`;
  await build({ ...COMMON, entryPoints: [entry], outfile, banner: { js }, ...options });
}

/** A plugin that puts, in place of a module of this folder, names of the shared global. */
async function takenFromShared() {
  const { metafile } = await build({ ...COMMON, entryPoints: ["views.js"], format: "esm", metafile: true, write: false });
  const names = Object.values(metafile.outputs)[0].exports;
  const contents = `export const { ${names.join(", ")} } = ${SHARED};`;
  const modules = new Set(own.filter((path) => path !== "./main.js").map((path) => resolve(path)));
  return ({ onLoad }) => {
    onLoad({ filter: /\.js$/ }, ({ path }) => (modules.has(path) ? { contents } : undefined));
  };
}
