// Bundles the modules beside this file and three.js to ../page_assets/page.js, and copies its licence.
import { createHash } from "node:crypto";
import { copyFileSync, readFileSync, readdirSync } from "node:fs";
import { build } from "esbuild";

const sources = readdirSync(".").filter((name) => name.endsWith(".js")).sort();
const digest = createHash("sha256");
for (const name of sources) digest.update(readFileSync(name));

await build({
  entryPoints: ["main.js"],
  bundle: true,
  minify: true,
  format: "esm",
  target: "es2022",
  charset: "ascii",
  legalComments: "none",
  outfile: "../page_assets/page.js",
  banner: {
    js:
      `/* sources ${digest.digest("hex")} */\n` +
      "/* with three.js, Copyright 2010-2026 three.js authors, MIT licence: see the end of the page */",
  },
});
copyFileSync("node_modules/three/LICENSE", "../page_assets/three_licence.txt");
