// Bundles the scripts of result pages and of the studio with three.js, and copies its licence.
import { createHash } from "node:crypto";
import { copyFileSync, readFileSync, readdirSync } from "node:fs";
import { build } from "esbuild";

const STUDIO = "../../studio";
const scripts = (folder) =>
  readdirSync(folder).filter((name) => name.endsWith(".js")).sort().map((name) => `${folder}/${name}`);
const own = scripts(".");

await bundle("main.js", own, "../page_assets/page.js");
await bundle(
  `${STUDIO}/page_source/studio.js`,
  [...own, ...scripts(`${STUDIO}/page_source`)],
  `${STUDIO}/page_assets/studio.js`,
);
copyFileSync("node_modules/three/LICENSE", "../page_assets/three_licence.txt");

async function bundle(entry, sources, outfile) {
  const digest = createHash("sha256");
  for (const path of sources) digest.update(readFileSync(path));
  await build({
    entryPoints: [entry],
    bundle: true,
    minify: true,
    format: "esm",
    target: "es2022",
    charset: "ascii",
    legalComments: "none",
    outfile,
    banner: {
      js:
        `/* sources ${digest.digest("hex")} */\n` +
        "/* with three.js, Copyright 2010-2026 three.js authors, MIT licence: see the end of the page */",
    },
  });
}
