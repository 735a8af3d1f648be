// Scripts of a page in a world of their own, without a browser: what they define at their top, by name.

import { readFileSync } from "node:fs";
import { runInNewContext } from "node:vm";

const HOME = new URL("../../desim_warehouse/", import.meta.url);
// `page`: a folder beside it; `world`: what the scripts find there beside the console.

export function load(page, files, names, world = {}) {
  const source = files.map((file) => readFileSync(new URL(`${page}/js/${file}.js`, HOME), "utf8")).join("\n");
  return runInNewContext(`${source}\n;({ ${names.join(", ")} })`, { console, ...world });
}
